// Decodes a batch of containers on a device: buffers, dispatches, and the status that comes back at their end.
import { kBoundsWords, kGridWords, kNone, kStateWords } from './layout.js';

const kUniformBytes = 256;
export const in_words = (bytes) => Math.ceil(bytes / 4) * 4;
// What shaders load together with the last byte.
const kBeyond = 8;

// The bytes of each buffer that grows with the containers of a batch. A stream has one window at most.
const buffer_sizes = (plan) => [in_words(plan.byte_count), kUniformBytes * plan.stream_count, ...plan.sizes.map((words) => 4 * words)];
const all_fit = (sizes, most_bytes) => sizes.every((size) => size + kBeyond <= most_bytes);
/** Whether a plan fits a batch of its own. */
export const fits = (plan, most_bytes) => all_fit(buffer_sizes(plan), most_bytes);
/** Plans that fit a batch each, in order, by batches. */
export function batches_of(plans, most_bytes) {
  const batches = [];
  let sums = [Infinity];
  for (const plan of plans) {
    const sizes = buffer_sizes(plan), together = sizes.map((size, i) => size + (sums[i] ?? 0));
    if (all_fit(together, most_bytes)) sums = together;
    else batches.push([]), (sums = sizes);
    batches.at(-1).push(plan);
  }
  return batches;
}

/** Whether the quantized values of all streams lie on one grid. */
export function have_one_grid({ stream_count }, grids, states) {
  for (let k = kGridWords; k < kGridWords * stream_count; ++k) if (states[grids + k] !== states[grids + (k % kGridWords)]) return false;
  return true;
}

export class Batch {
  #device;
  #decoder;
  #layout;
  #plans;
  #buffers = [];

  /** @param {{ device: GPUDevice, kind: object, pipelines: Map<string, GPUComputePipeline>, bind_group_layout: GPUBindGroupLayout, most_memory: number, streams_per_group: number }} decoder */
  constructor(decoder, plans) {
    this.#decoder = decoder;
    this.#device = decoder.device;
    this.#plans = plans;
    const layout = (this.#layout = new decoder.kind.Layout(decoder.most_memory / 4, plans));
    let at = 0;
    for (const plan of plans) {
      plan.bytes_at = at;
      plan.place(layout, at);
      at += in_words(plan.byte_count);
    }
    this.byte_count = at;
  }

  #buffer(size, usage, words) {
    const buffer = this.#device.createBuffer({ size: Math.max(in_words(size), 16), usage });
    this.#buffers.push(buffer);
    if (words !== undefined && words.length > 0) this.#device.queue.writeBuffer(buffer, 0, words);
    return buffer;
  }

  /**
   * Submits all work.
   * @param {(plan: object) => { bytes: Uint8Array, buffer?: GPUBuffer, offset?: number }} source_of where a container's bytes are
   * @param {(plan: object, copy: (buffer: GPUBuffer, place: number) => void) => void} take_results copies results out
   * @returns {Promise<Uint32Array>} the states of the streams, followed by their grids and bounds
   */
  async run(source_of, take_results) {
    const { STORAGE, COPY_DST, COPY_SRC, UNIFORM, MAP_READ } = GPUBufferUsage, layout = this.#layout, device = this.#device;
    const bytes = this.#buffer(this.byte_count + kBeyond, STORAGE | COPY_DST);
    const encoder = device.createCommandEncoder();
    for (const plan of this.#plans) {
      const source = source_of(plan);
      if (source.buffer !== undefined && source.offset % 4 === 0 && plan.byte_count % 4 === 0)
        encoder.copyBufferToBuffer(source.buffer, source.offset, bytes, plan.bytes_at, plan.byte_count);
      else this.#write_bytes(bytes, plan.bytes_at, source.bytes);
    }
    const states = new Uint32Array(layout.state_words);
    for (const { outputs } of this.#plans) for (const { bounds } of outputs) if (bounds !== undefined) states.fill(kNone, bounds, bounds + kBoundsWords / 2);
    const state_bytes = 4 * layout.state_words, results = this.#buffer(4 * layout.result_words, STORAGE | COPY_SRC);
    const on_device = this.#buffer(state_bytes, STORAGE | COPY_SRC | COPY_DST, states), read_back = this.#buffer(state_bytes, MAP_READ | COPY_DST);
    const storage = [bytes, this.#buffer(4 * layout.plan.length, STORAGE | COPY_DST, layout.plan.words),
      this.#buffer(4 * layout.streams.length, STORAGE | COPY_DST, layout.streams.words),
      this.#buffer(4 * layout.attributes.length, STORAGE | COPY_DST, layout.attributes.words), this.#buffer(4 * layout.memory_words, STORAGE),
      this.#buffer(4 * layout.walk_words, STORAGE), results, on_device];
    const windows = new Uint32Array((kUniformBytes / 4) * layout.windows.length);
    layout.windows.forEach(({ first, count }, i) => windows.set([first, count], (kUniformBytes / 4) * i));
    const uniform = this.#buffer(4 * windows.length, UNIFORM | COPY_DST, windows);
    const bind_group = device.createBindGroup({ layout: this.#decoder.bind_group_layout, entries: [
      ...storage.map((buffer, binding) => ({ binding, resource: { buffer } })), { binding: 8, resource: { buffer: uniform, size: 16 } }] });
    const pass = encoder.beginComputePass();
    layout.windows.forEach(({ count }, i) => {
      pass.setBindGroup(0, bind_group, [kUniformBytes * i]);
      for (const stage of this.#decoder.kind.stages) this.#dispatch(pass, stage, count);
    });
    pass.end();
    for (const plan of this.#plans) take_results(plan, (buffer, place) => encoder.copyBufferToBuffer(results, 4 * place, buffer, 0, buffer.size));
    encoder.copyBufferToBuffer(on_device, 0, read_back, 0, state_bytes);
    device.queue.submit([encoder.finish()]);
    await read_back.mapAsync(GPUMapMode.READ);
    const found = new Uint32Array(read_back.getMappedRange()).slice();
    read_back.unmap();
    return found;
  }
  #write_bytes(buffer, at, source) {
    const whole = source.length - (source.length % 4);
    if (whole > 0) this.#device.queue.writeBuffer(buffer, at, source, 0, whole);
    if (whole === source.length) return;
    const rest = new Uint8Array(4);
    rest.set(source.subarray(whole));
    this.#device.queue.writeBuffer(buffer, at + whole, rest);
  }
  #dispatch(pass, { entry, by, of = by }, count) {
    const { list_count, data_count, group_count, attribute_count } = this.#layout;
    // The first attribute is not predicted from others.
    const most = { list: list_count, data: data_count, group: group_count, attribute: attribute_count, 'lanes of attribute': attribute_count,
      'other attribute': attribute_count > 1 ? attribute_count : 0 }[of] ?? 1;
    if (most === 0) return;
    pass.setPipeline(this.#decoder.pipelines.get(entry));
    const groups = by.startsWith('lanes') ? count : Math.ceil(count / this.#decoder.streams_per_group);
    pass.dispatchWorkgroups(groups, by === 'stream' ? 1 : most);
  }

  /** Whether the streams of a container decoded, and places that are written lie on one grid. */
  is_fine(plan, states) {
    for (let i = 0; i < plan.stream_count; ++i) if (states[kStateWords * (plan.first_stream + i)] !== 0) return false;
    return plan.outputs.every(({ is_grid, grids }) => !is_grid || have_one_grid(plan, grids, states));
  }

  destroy() {
    for (const buffer of this.#buffers) buffer.destroy();
    this.#buffers = [];
  }
}
