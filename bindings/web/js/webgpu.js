// Decodes containers of PSPLIT_mesh_draco_patches on a GPU, by WebGPU. The WebAssembly decoder takes broken
// containers, and those that the shaders do not support; docs/webgpu.md lists them.
import { PsplitError } from './error.js';
import { is_condensed } from './head.js';
import { bytes_of, check_signal, invalid, make_job, or_abort } from './job.js';
import { array_of } from './types.js';
import { Batch, batches_of, fits, have_one_grid, in_words } from './webgpu/batch.js';
import { ContainerPlan, draco } from './webgpu/container_plan.js';
import { refuse, Refusal } from './webgpu/refusal.js';

export { PsplitError } from './error.js';

const kStorageBuffers = 8, kMostMemory = 128 * 1024 * 1024, kStreamsPerGroup = 8;
const failed = (message) => new PsplitError(message, 'failed');
const bytes_of_type = (type) => array_of(type).BYTES_PER_ELEMENT;
const float_of = (bits) => new Float32Array(Uint32Array.of(bits).buffer)[0];

// Decoding by WebAssembly is loaded when it is needed.
const decode_by_wasm = async (bytes, attributes) => (await import('./index.js')).decodeContainer(bytes, { attributes });

async function make_pipelines(device, streams_per_group, kind) {
  const { code, stages } = kind;
  const module = device.createShaderModule({ label: 'psplit', code });
  const entry = (binding, type, hasDynamicOffset = false) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: { type, hasDynamicOffset } });
  const bind_group_layout = device.createBindGroupLayout({ entries: [...[0, 1, 2, 3].map((i) => entry(i, 'read-only-storage')),
    ...[4, 5, 6, 7].map((i) => entry(i, 'storage')), entry(8, 'uniform', true)] });
  const layout = device.createPipelineLayout({ bindGroupLayouts: [bind_group_layout] });
  const pipelines = new Map(await Promise.all(stages.map(async ({ entry: entryPoint, by }) => {
    const constants = by.startsWith('lanes') ? {} : { kStreamsPerGroup: streams_per_group };
    return [entryPoint, await device.createComputePipelineAsync({ label: `psplit ${entryPoint}`, layout, compute: { module, entryPoint, constants } })];
  })));
  return { kind, bind_group_layout, pipelines };
}

// A decoded mesh: buffers of the device, or without a device the arrays of WebAssembly.
class GpuMesh {
  #device;
  #mesh;  // of WebAssembly, without a device

  constructor(device, fields, mesh) {
    this.#device = device;
    this.#mesh = mesh;
    Object.assign(this, fields);
  }

  async read() {
    const { faceCount, pointCount } = this;
    if (this.#mesh !== undefined) return this.#mesh;
    const [indices, ...values] = await Promise.all([this.indices, ...this.attributes].map(({ buffer }) => read_buffer(this.#device, buffer)));
    return { faceCount, pointCount, indices: new Uint32Array(indices, 0, 3 * faceCount), attributes: this.attributes.map((attribute, i) => {
      const { name, uniqueId, type, componentCount, normalized, stride } = attribute, Type = array_of(type);
      const width = stride / Type.BYTES_PER_ELEMENT, all = new Type(values[i], 0, width * pointCount);
      const array = width === componentCount ? all : new Type(componentCount * pointCount);
      if (width !== componentCount)
        for (let k = 0; k < array.length; ++k) array[k] = all[Math.floor(k / componentCount) * width + (k % componentCount)];
      return { name, uniqueId, type, componentCount, normalized, array };
    }) };
  }
  destroy() {
    for (const { buffer } of [this.indices, ...this.attributes]) buffer?.destroy();
  }
}

async function read_buffer(device, source, offset = 0, size = source.size - offset) {
  const buffer = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
  try {
    const encoder = device.createCommandEncoder();
    encoder.copyBufferToBuffer(source, offset, buffer, 0, size);
    device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    return buffer.getMappedRange().slice(0);
  } finally {
    buffer.destroy();
  }
}

class GpuDecoder {
  #device;
  #options;
  #lost = null;  // the error then
  #decoder;      // what a batch needs
  #condensed;    // the same for condensed streams, when there are some

  constructor(device, options, parts) {
    this.#device = device;
    this.#options = options;
    if (device === null) return;
    const { maxStorageBufferBindingSize, maxBufferSize } = device.limits, most_bytes = Math.min(maxStorageBufferBindingSize, maxBufferSize);
    this.#decoder = { device, ...parts, most_bytes, most_memory: Math.min(most_bytes, options.memory), streams_per_group: kStreamsPerGroup };
    device.lost.then(({ reason, message }) => (this.#lost = failed(`the GPU device was lost: ${message || reason}`)));
  }

  get device() {
    return this.#device;
  }

  async decode(data, options) {
    const { attributes, as = 'float32', wasm = true, signal } = options ?? {};
    check_signal(signal);
    if (as !== 'float32' && as !== 'quantized') throw invalid("the option `as` is neither 'float32' nor 'quantized'");
    const is_list = Array.isArray(data), list = is_list ? data : [data];
    const is_list_of_lists = is_list && attributes?.some?.((one) => one == null || Array.isArray(one));
    const meshes = await this.#decode_all(list, list.map((_, i) => (is_list_of_lists ? attributes[i] : attributes)), as, wasm, signal);
    return is_list ? meshes : meshes[0];
  }

  async #decode_all(list, requests, as, wasm, signal) {
    const meshes = [], jobs = [];
    let on_device = Promise.resolve(), by_wasm = on_device;
    try {
      for (const [i, data] of list.entries()) {
        const source = await or_abort(this.#source(data), signal), { attributes } = make_job('container', source.bytes, { attributes: requests[i] });
        jobs.push({ ...source, attributes, plan: null, why: null });
      }
      if (this.#device !== null) await or_abort(on_device = this.#decode_on_device(jobs, as, meshes, signal), signal);
      for (const [i, job] of jobs.entries()) {
        // Of several containers, a broken one is not the others' failure.
        const failure = (error) => (jobs.length > 1 && error.code !== 'aborted' ? error : Promise.reject(error));
        meshes[i] ??= await or_abort(by_wasm = wasm ? this.#decode_by_wasm(job) : Promise.reject(new PsplitError(job.why ?? 'there is no GPU device', 'unsupported')), signal).catch(failure);
      }
      return meshes;
    } catch (error) {
      // What the device or WebAssembly has begun goes on.
      Promise.allSettled([on_device, by_wasm]).then(([, { value }]) => [...meshes, value].forEach((mesh) => mesh?.destroy?.()));
      throw error;
    }
  }

  // Where the bytes of a container are. Those on the device are copied back once, because the host reads directory and stitch map.
  async #source(data) {
    const is_buffer = (value) => typeof GPUBuffer !== 'undefined' && value instanceof GPUBuffer;
    const buffer = is_buffer(data) ? data : is_buffer(data?.buffer) ? data.buffer : undefined;
    if (buffer === undefined) return { bytes: bytes_of(data) };
    if (this.#device === null) throw failed('a buffer of a GPU, but no GPU device');
    const { offset = 0, byteLength = buffer.size - offset } = data === buffer ? {} : data, front = offset % 4;
    // Copies are of whole words.
    if (![offset, byteLength].every((value) => Number.isInteger(value) && value >= 0) || in_words(offset + byteLength) > buffer.size ||
      !(buffer.usage & GPUBufferUsage.COPY_SRC))
      throw invalid('the GPU buffer has no such words, or no COPY_SRC');
    const bytes = await read_buffer(this.#device, buffer, offset - front, in_words(front + byteLength));
    return { bytes: new Uint8Array(bytes, front, byteLength), buffer, offset };
  }

  // What condensed streams need is loaded and compiled for the first of them.
  async #condensed_decoder() {
    this.#condensed ??= import('./webgpu/condensed.js').then(({ condensed }) => make_pipelines(this.#device, kStreamsPerGroup, condensed));
    try {
      return { ...this.#decoder, ...await this.#condensed };
    } catch (error) {
      this.#condensed = undefined;  // the next ones are tried again
      return refuse(`condensed patches: ${error.message}`);
    }
  }

  async #decode_on_device(jobs, as, meshes, signal) {
    if (this.#lost !== null) return this.#give_up(this.#lost, jobs);
    const { most_bytes, most_memory } = this.#decoder, plans = new Map();  // by kind
    for (const job of jobs) {
      try {
        const { kind } = (job.decoder = is_condensed(job.bytes) ? await this.#condensed_decoder() : this.#decoder);
        job.plan = new ContainerPlan(job.bytes, job.attributes, as, most_memory / 4, kind);
        if (!fits(job.plan, most_bytes)) throw new Refusal('more bytes than a buffer of the device has');
        if (!plans.has(kind)) plans.set(kind, []);
        plans.get(kind).push(job.plan);
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
        job.plan = null;
        job.why = error.message;
      }
    }
    if (this.#lost !== null) return this.#give_up(this.#lost, jobs);  // meanwhile
    for (const batch of [...plans.values()].flatMap((of_kind) => batches_of(of_kind, most_bytes))) {
      if (signal?.aborted) return;
      const of_batch = jobs.filter(({ plan }) => batch.includes(plan));
      try {
        await this.#run(of_batch, jobs, meshes);
      } catch (error) {
        this.#give_up(error instanceof PsplitError ? error : failed(error.message), of_batch);
      }
    }
  }
  // Leaves jobs to WebAssembly if the caller wants that.
  #give_up(error, jobs) {
    if (this.#options.fallback !== 'wasm') throw error;
    for (const job of jobs) job.why = error.message;
  }

  async #run(of_batch, jobs, meshes) {
    const device = this.#device, taken = new Map(), batch = new Batch(of_batch[0].decoder, of_batch.map(({ plan }) => plan));
    // What memory ran out for is invalid as well.
    const scopes = ['validation', 'internal', 'out-of-memory'];
    for (const filter of scopes) device.pushErrorScope(filter);
    let errors, states, problem;
    try {
      const running = batch.run((plan) => of_batch.find((job) => job.plan === plan), (plan, copy) => taken.set(plan, this.#take_buffers(plan, copy)));
      errors = scopes.map(() => device.popErrorScope());
      states = await running;
    } catch (error) {
      problem = error;
    } finally {
      batch.destroy();
    }
    const [memory, internal, validation] = await Promise.all(errors ?? []), found = memory ?? internal ?? validation ?? problem;
    if (found !== undefined || this.#lost !== null) {
      for (const buffers of taken.values()) for (const buffer of buffers) buffer.destroy();
      await null;  // a loss is noticed first
      throw this.#lost ?? new PsplitError(`the GPU failed: ${found.message}`, memory ? 'out-of-memory' : 'failed');
    }
    for (const job of of_batch) {
      const { plan } = job, buffers = taken.get(plan);
      if (batch.is_fine(plan, states)) {
        meshes[jobs.indexOf(job)] = new GpuMesh(device, mesh_of(plan, buffers, states));
      } else {
        for (const buffer of buffers) buffer.destroy();
        job.why = 'the shaders do not decode it';
      }
    }
  }
  #take_buffers(plan, copy) {
    const places = [[plan.indices, 3 * plan.face_count], ...plan.outputs.map(({ out, stride }) => [out, stride * plan.point_count])];
    return places.map(([place, words], i) => {
      const buffer = this.#result_buffer(4 * words, i === 0);
      copy(buffer, place);
      return buffer;
    });
  }
  #result_buffer(size, is_index, mappedAtCreation = false) {
    const { INDEX, VERTEX, STORAGE, COPY_SRC, COPY_DST } = GPUBufferUsage;
    return this.#device.createBuffer({ size, usage: (is_index ? INDEX : VERTEX) | STORAGE | COPY_SRC | COPY_DST, mappedAtCreation });
  }

  async #decode_by_wasm({ bytes, attributes, why }) {
    const mesh = await decode_by_wasm(bytes, attributes), { faceCount, pointCount, patchCount, hasResidue, isCondensed, firstFaces } = mesh, uploaded = [];
    const upload = (array, componentCount, is_index) => {
      if (this.#device === null || this.#lost !== null) return undefined;
      const width = array.BYTES_PER_ELEMENT, stride = in_words(width * componentCount);
      const buffer = this.#result_buffer(Math.max((array.length / componentCount) * stride, 4), is_index, true);
      uploaded.push(buffer);
      const range = buffer.getMappedRange();
      const out = new array.constructor(range, 0, Math.floor(range.byteLength / width)), step = stride / width;
      if (step === componentCount) out.set(array);
      else for (let k = 0; k < array.length; ++k) out[Math.floor(k / componentCount) * step + (k % componentCount)] = array[k];
      buffer.unmap();
      return buffer;
    };
    try {
      const fields = { way: 'wasm', why, faceCount, pointCount, patchCount, hasResidue, isCondensed, firstFaces, indices: { buffer: upload(mesh.indices, 3, true), format: 'uint32', count: 3 * faceCount },
        attributes: mesh.attributes.map(({ name, uniqueId, type, componentCount, normalized, array }) => ({ name, uniqueId, type, componentCount,
          normalized, stride: in_words(bytes_of_type(type) * componentCount), buffer: upload(array, componentCount, false) })) };
      return new GpuMesh(this.#device, fields, fields.indices.buffer === undefined ? mesh : undefined);
    } catch (error) {
      for (const buffer of uploaded) buffer.destroy();
      // Only a lack of memory keeps a buffer from being mapped at its creation.
      throw new PsplitError(error.message, 'out-of-memory');
    }
  }
}

// A container's mesh on the device.
function mesh_of(plan, [indices, ...buffers], states) {
  const attributes = plan.outputs.map(({ request, is_grid, stride, grids, bounds, is_bounded }, i) => {
    const { name, uniqueId, type, componentCount, normalized = false } = request;
    const attribute = { name, uniqueId, type: is_grid ? 'uint16' : type, componentCount, normalized, stride: 4 * stride, buffer: buffers[i] };
    if (grids === undefined) return attribute;
    const bits = states[grids], scale = float_of(states[grids + 1]), origin = Array.from({ length: componentCount }, (_, k) => float_of(states[grids + 2 + k]));
    Object.assign(attribute, is_grid ? { bits, scale, origin } : {});
    // To the bit what shaders write: a float times a float is exact in a double.
    const value = (at, k) => Math.fround(Math.fround(Math.fround((states[at] ^ 0x80000000) | 0) * scale) + origin[k]);
    if (is_bounded && plan.point_count > 0 && have_one_grid(plan, grids, states))
      Object.assign(attribute, { min: [0, 1, 2].map((k) => value(bounds + k, k)), max: [0, 1, 2].map((k) => value(bounds + 3 + k, k)) });
    return attribute;
  });
  return { way: 'gpu', faceCount: plan.face_count, pointCount: plan.point_count, patchCount: plan.stream_count, hasResidue: false,
    isCondensed: plan.kind.is_condensed, firstFaces: plan.directory.first_faces, attributes,
    indices: { buffer: indices, format: 'uint32', count: 3 * plan.face_count } };
}

export async function createGpuDecoder(device, options) {
  const { fallback, memory = kMostMemory } = options ?? {};
  if (fallback !== undefined && fallback !== 'wasm') throw invalid("the option `fallback` is not 'wasm'");
  if (typeof memory !== 'number' || !(memory >= 0)) throw invalid('the option `memory` is not a number');
  const without = (why) => {
    if (fallback !== 'wasm') throw failed(why);
    return new GpuDecoder(null, { fallback });
  };
  if (device == null) return without('there is no GPU device');
  const { maxStorageBuffersPerShaderStage, maxComputeInvocationsPerWorkgroup } = device.limits;
  if (maxStorageBuffersPerShaderStage < kStorageBuffers || maxComputeInvocationsPerWorkgroup < 64)
    return without(`the GPU device has ${maxStorageBuffersPerShaderStage} storage buffers for a shader, and ${maxComputeInvocationsPerWorkgroup} invocations for a group; 8 and 64 are needed`);
  try {
    return new GpuDecoder(device, { fallback, memory }, await make_pipelines(device, kStreamsPerGroup, draco));
  } catch (error) {
    return without(`the GPU device does not compile the shaders: ${error.message}`);
  }
}
