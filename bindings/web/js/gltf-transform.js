// The extension PSPLIT_mesh_draco_patches for glTF-Transform 4. It reads containers, and writes a container that it read or that
// psplit() made, if the geometry did not change since. Other geometry is written without the extension.
import { Extension, ExtensionProperty, GLB_BUFFER, Primitive, PropertyType, RefList } from '@gltf-transform/core';
import { error_from_data, PsplitError } from './error.js';
import { fine_mesh, fitting_indices, kComponentCounts, kComponentTypes, kExtensionName, number_of, slot_of, stored_primitive } from './gltf.js';
import { Decoder } from './instance.js';
import { make_job } from './job.js';
import { Modules } from './module.js';

/** A decoder that works on the calling thread and returns at once, because glTF-Transform reads and writes that way. */
export async function createDecoder(options) {
  // Reading is synchronous, so no other module can be loaded when it is needed.
  const decoder = new Decoder(await new Modules(options?.wasm).get(options?.wasm == null));
  return { decodeContainer: (data, options) => decoder.run(make_job('container', data, options)) };
}

// Calls work(definition of the primitive, its stored data, numbers of mesh and primitive). Errors get the place in the asset.
function for_each_stored_primitive(json, work) {
  (json.meshes ?? []).forEach((mesh, m) => fine_mesh(mesh, m).primitives.forEach((primitive, p) => {
    try {
      const stored = stored_primitive(json, primitive);
      if (stored !== undefined) work(primitive, stored, m, p);
    } catch (error) {
      throw placed(error, m, p);
    }
  }));
}
const placed = (error, mesh, primitive) => error instanceof PsplitError ? error_from_data({ code: error.code, patch: error.patch,
  message: `[${kExtensionName}] mesh ${mesh}, primitive ${primitive}: ${error.message}` }) : error;

// Meshes that decodeAhead decoded, by the extension's object in the JSON.
const decoded_ahead = new WeakMap();

/** Decodes all containers of a JSONDocument in a pool's workers, so that io.readJSON() finds them decoded. */
export async function decodeAhead({ json, resources }, pool, options) {
  const signal = options?.signal;
  const jobs = new Map();  // by buffer view and attributes, because primitives may share a container
  for_each_stored_primitive(json, (primitive, { bufferView, attributes }, m, p) => {
    const key = JSON.stringify([bufferView, attributes]), { buffer, byteOffset = 0, byteLength } = json.bufferViews[bufferView];
    const bytes = resources[json.buffers[buffer].uri ?? GLB_BUFFER].subarray(byteOffset, byteOffset + byteLength);
    if (!jobs.has(key)) jobs.set(key, { bytes, attributes, m, p, primitives: [] });
    jobs.get(key).primitives.push(primitive);
  });
  await Promise.all([...jobs.values()].map(async ({ bytes, attributes, m, p, primitives }) => {
    try {
      const mesh = await pool.decodeContainer(bytes, { attributes, signal });
      for (const primitive of primitives) decoded_ahead.set(primitive.extensions[kExtensionName], mesh);
    } catch (error) {
      throw placed(error, m, p);
    }
  }));
}

// A container as it was read. Primitives that share it share this property.
class PatchContainer extends ExtensionProperty {
  static EXTENSION_NAME = kExtensionName;

  init() {
    this.extensionName = kExtensionName;
    this.propertyType = 'PatchContainer';
    this.parentTypes = [PropertyType.PRIMITIVE];
  }
  getDefaults() {
    return Object.assign(super.getDefaults(), { bytes: null, attributes: [], buffer: null });
  }
  // `attributes`: the decoder is asked for these.
  fill(bytes, attributes, buffer) {
    return this.set('bytes', bytes).set('attributes', attributes).setRef('buffer', buffer);
  }
  get bytes() {
    return this.get('bytes');
  }
  get attributes() {
    return this.get('attributes');
  }
  get buffer() {
    return this.getRef('buffer');
  }
}

// The coarse primitives of a mesh, for loaders that do not support the extension. They are written as they were read, while
// the mesh has a container.
class CoarsePrimitives extends ExtensionProperty {
  static EXTENSION_NAME = kExtensionName;

  init() {
    this.extensionName = kExtensionName;
    this.propertyType = kCoarse;
    this.parentTypes = [PropertyType.MESH];
  }
  getDefaults() {
    return Object.assign(super.getDefaults(), { primitives: new RefList() });
  }
  add(primitive) {
    return this.addRef('primitives', primitive);
  }
  list() {
    return this.listRefs('primitives');
  }
}
const kCoarse = 'CoarsePrimitives', kMeshopt = 'EXT_meshopt_compression', kMostAttributes = 256;

// As glTF-Transform reads and writes the primitives of meshes.
function read_primitive(document, context, { attributes = {}, indices, material, mode, targets = [], extras }, names = []) {
  const primitive = document.createPrimitive();
  for (const [name, accessor] of Object.entries(attributes)) primitive.setAttribute(name, context.accessors[accessor]);
  if (indices !== undefined) primitive.setIndices(context.accessors[indices]);
  if (material !== undefined) primitive.setMaterial(context.materials[material]);
  if (mode !== undefined) primitive.setMode(mode);
  if (extras !== undefined) primitive.setExtras(extras);
  targets.forEach((of_target, t) => {
    const target = document.createPrimitiveTarget(names[t] ?? String(t));
    for (const [name, accessor] of Object.entries(of_target)) target.setAttribute(name, context.accessors[accessor]);
    primitive.addTarget(target);
  });
  return primitive;
}
function write_primitive(context, primitive) {
  const indices = primitive.getIndices(), material = primitive.getMaterial(), extras = primitive.getExtras();
  const numbers_of = (of) => Object.fromEntries(
    of.listSemantics().map((name) => [name, context.accessorIndexMap.get(of.getAttribute(name))]));
  return { attributes: numbers_of(primitive), mode: primitive.getMode(),
    ...(indices !== null && { indices: context.accessorIndexMap.get(indices) }),
    ...(material !== null && { material: context.materialIndexMap.get(material) }),
    ...(primitive.listTargets().length > 0 && { targets: primitive.listTargets().map(numbers_of) }),
    ...(Object.keys(extras).length > 0 && { extras }) };
}

// Where a primitive has an accessor, as slot_of says: an object and the name there, for a morph target also its number.
const place_of = (primitive, name) => slot_of({ attributes: primitive, targets: primitive.listTargets() }, name);
function attribute_of(primitive, name) {
  const [holder, key] = place_of(primitive, name);
  return holder?.getAttribute(key) ?? null;
}

function equal_bytes(a, b) {
  if (a.byteLength !== b.byteLength) return false;
  const [left, right] = [a, b].map((array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
  for (let i = 0; i < left.length; ++i) if (left[i] !== right[i]) return false;
  return true;
}

export class PsplitMeshDracoPatches extends Extension {
  static EXTENSION_NAME = kExtensionName;

  extensionName = kExtensionName;
  prereadTypes = [PropertyType.MESH, PropertyType.PRIMITIVE];
  prewriteTypes = [PropertyType.ACCESSOR];
  readDependencies = ['psplit.decoder'];
  writeDependencies = ['psplit.decoder'];
  #decoder;
  #own_meshes;            // of the JSON that is being read
  #read_primitives = [];  // { m, p, container, accessors: [[name, accessor]] }; the name of indices is undefined

  install(key, dependency) {
    if (key === 'psplit.decoder') this.#decoder = dependency ?? this.#decoder;
    return this;
  }

  get hasDecoder() {
    return this.#decoder !== undefined;
  }

  preread(context, type) {
    return type === PropertyType.MESH ? this.#choose_primitives(context) : this.#preread_primitives(context);
  }

  // What cannot be decoded stays in its coarse form. The reader gets the JSON's own meshes back.
  #choose_primitives({ jsonDoc: { json } }) {
    const is_ahead = ({ extensions }) => extensions?.[kExtensionName] === undefined || decoded_ahead.has(extensions[kExtensionName]);
    let is_coarse = false;
    this.#own_meshes = json.meshes;
    json.meshes = json.meshes?.map((mesh, m) => {
      const fine = fine_mesh(mesh, m);
      if (fine === mesh || this.#decoder !== undefined || fine.primitives.every(is_ahead)) return fine;
      is_coarse = true;
      return { ...mesh, extensions: fine.extensions };
    });
    if (is_coarse) this.#read_fallback();
    return this;
  }

  // Gives accessors the decoded arrays.
  #preread_primitives(context) {
    const { json } = context.jsonDoc;
    const stored_in = new Map();      // by buffer view and attributes: { container, mesh }
    const mesh_of_accessor = new Map();
    let is_fallback = false;
    for_each_stored_primitive(json, (primitive, { bufferView, attributes }, m, p) => {
      const ahead = decoded_ahead.get(primitive.extensions[kExtensionName]);
      if (ahead === undefined && this.#decoder === undefined) return void (is_fallback = true);
      const key = JSON.stringify([bufferView, attributes]), buffer = context.bufferViewBuffers[bufferView];
      if (!stored_in.has(key)) {
        const bytes = context.bufferViews[bufferView].slice();
        stored_in.set(key, { container: new PatchContainer(this.document.getGraph()).fill(bytes, attributes, buffer),
          mesh: ahead ?? this.#decoder.decodeContainer(bytes, { attributes }) });
      }
      const { container, mesh } = stored_in.get(key), primitive_read = { m, p, container, accessors: [] };
      const set = (name, i, array) => {
        // Two primitives may share an accessor, although their containers store different data of the same description.
        if (!mesh_of_accessor.has(i)) mesh_of_accessor.set(i, mesh);
        const shared = context.accessors[i], accessor = mesh_of_accessor.get(i) === mesh ? shared : shared.clone();
        accessor.setArray(array);
        // An accessor without data has no buffer of its own.
        if (json.accessors[i].bufferView === undefined) accessor.setBuffer(buffer);
        primitive_read.accessors.push([name, accessor]);
      };
      set(undefined, primitive.indices, fitting_indices(json, primitive, mesh));
      for (const { name, array } of mesh.attributes) set(name, number_of(primitive, name), array);
      this.#read_primitives.push(primitive_read);
    });
    if (is_fallback) this.#read_fallback();
    return this;
  }

  #read_fallback() {
    if (this.isRequired()) {
      throw new PsplitError(`[${kExtensionName}] the dependency "psplit.decoder" is missing: register what createDecoder() ` +
        'resolves to', 'invalid-input');
    }
    this.document.getLogger().warn(
      `[${kExtensionName}] There is no dependency "psplit.decoder": the fallback is read, and containers are not kept.`);
  }

  read(context) {
    const { json } = context.jsonDoc;
    for (const [m, mesh] of context.meshes.entries()) {
      const own = this.#own_meshes[m], is_fine = own.extensions?.[kExtensionName]?.primitives === json.meshes[m].primitives;
      if (!is_fine) continue;
      const coarse = new CoarsePrimitives(this.document.getGraph());
      for (const definition of own.primitives) coarse.add(read_primitive(this.document, context, definition, own.extras?.targetNames));
      mesh.setExtension(kExtensionName, coarse);
    }
    if (this.#own_meshes !== undefined) json.meshes = this.#own_meshes;
    for (const { m, p, container, accessors } of this.#read_primitives) {
      const primitive = context.meshes[m].listPrimitives()[p].setExtension(kExtensionName, container);
      for (const [name, accessor] of accessors) {
        const [holder, key] = place_of(primitive, name);
        if (name === undefined) primitive.setIndices(accessor);
        else holder.setAttribute(key, accessor);
      }
    }
    return this;
  }

  // Writes accessors without data if a container has the data. Extensions write in the order of their names: meshoptimizer's has
  // claimed all accessors, and compresses them later.
  prewrite(context) {
    const meshopt = meshopt_state(this.document.getRoot().listExtensionsUsed().find(({ extensionName }) => extensionName === kMeshopt));
    const kept = new Map(), changes = [];  // kept: primitive -> PatchContainer
    let decoded = {};                      // the last mesh; primitives that share a container are next to each other
    this.document.getRoot().listMeshes().forEach((mesh, m) => mesh.listPrimitives().forEach((primitive, p) => {
      const container = primitive.getExtension(kExtensionName);
      if (container === null) return;
      if (decoded.container !== container) decoded = { container, mesh: undefined };
      const change = this.#change_of(primitive, container, context, meshopt, () => (decoded.mesh ??= this.#decoder.decodeContainer(
        container.bytes, { attributes: container.attributes })));
      if (change === undefined) kept.set(primitive, container);
      else changes.push(`mesh ${m}, primitive ${p}: ${change}`);
    }));
    const gone = new Set(this.#read_primitives.map(({ container }) => container));
    for (const container of this.listProperties()) if (used_by_mesh(container)) gone.delete(container);
    if (gone.size > 0) changes.push(`${gone.size} containers that were read belong to no primitive any more`);
    if (changes.length > 0) {
      this.document.getLogger().warn(`[${kExtensionName}] Some geometry is written without patches: ${changes.join('; ')}. ` +
        'The transform psplit() makes patches again.');
    }
    take_back_from_draco(context, kept);
    const stored = this.#stored_accessors(new Map([...kept].filter(([primitive]) => this.#has_data_alone(primitive))));
    take_back_from_meshopt(context, meshopt, stored);
    write_accessors(context, stored);
    for (const [primitive, container] of kept) this.#add_buffer_view(context, primitive, container);
    context.extensionData[kExtensionName] = kept;
    return this;
  }

  // If loaders may ignore the extension, the accessors keep their data as the fallback, unless there are coarse primitives.
  #has_data_alone(primitive) {
    return this.isRequired() || has_coarse(primitive);
  }

  // Why a container cannot be kept; undefined if it can.
  #change_of(primitive, container, context, meshopt, decode) {
    const indices = primitive.getIndices(), present = present_attributes(primitive, container);
    if (this.#decoder === undefined) return 'there is no dependency "psplit.decoder" to compare the geometry with its container';
    if (indices === null || primitive.getMode() !== Primitive.Mode.TRIANGLES)
      return 'it is not a list of indexed triangles any more';
    if (present.every(({ name }) => primitive.getAttribute(name) === null)) return 'it has no attribute of its container any more';
    const another_type = present.find(({ type, componentCount, accessor }) =>
      kComponentTypes[accessor.getComponentType()] !== type || kComponentCounts[accessor.getType()] !== componentCount);
    if (another_type !== undefined) return `${another_type.name} has another type`;
    const accessors = [indices, ...present.map(({ accessor }) => accessor)];
    const is_compressed = (accessor) => meshopt.definition_of(context, accessor) !== undefined;
    if (accessors.some((accessor) => context.accessorIndexMap.has(accessor)) &&
      !(this.isRequired() && is_draco_only(context, primitive, container, accessors)) &&
      !(this.#has_data_alone(primitive) && accessors.every(is_compressed))) return 'another extension writes it';
    const mesh = decode();
    if (!equal_bytes(mesh.indices, new Uint32Array(indices.getArray()))) return 'indices changed';
    const changed = present.find(({ name, accessor }) =>
      !equal_bytes(mesh.attributes.find((attribute) => attribute.name === name).array, accessor.getArray()));
    return changed && `${changed.name} changed`;
  }

  // The accessors whose data containers have, and nothing else needs.
  #stored_accessors(kept) {
    const graph = this.document.getGraph();
    // Whether a container has what the graph's edge to an accessor refers to.
    const is_stored = (edge) => {
      const parent = edge.getParent(), container = kept.get(parent);
      const stores = (container, of) => container.attributes.some(({ name }) => name === of), { key } = edge.getAttributes();
      if (container !== undefined) return edge.getName() === 'indices' || (edge.getName() === 'attributes' && stores(container, key));
      if (parent.propertyType === PropertyType.PRIMITIVE_TARGET) {
        return parent.listParents().every((primitive) => primitive.propertyType !== PropertyType.PRIMITIVE || !is_in_mesh(primitive) ||
          primitive.listTargets().every((target, t) => target !== parent || (kept.has(primitive) && stores(kept.get(primitive), `targets/${t}/${key}`))));
      }
      return parent.propertyType === PropertyType.ROOT || (parent.propertyType === PropertyType.PRIMITIVE && !is_in_mesh(parent));
    };
    const accessors = [...kept].flatMap(([primitive, container]) =>
      [primitive.getIndices(), ...present_attributes(primitive, container).map(({ accessor }) => accessor)]);
    return [...new Set(accessors)].filter((accessor) => graph.listParentEdges(accessor).every(is_stored));
  }

  // Views are padded here, so that the next one is aligned; write() states the container's own length.
  #add_buffer_view({ extensionData, otherBufferViews }, primitive, container) {
    const padded = (extensionData[`${kExtensionName} views`] ??= new Map());
    if (padded.has(container)) return;
    const bytes = new Uint8Array((container.bytes.length + 3) & ~3);
    bytes.set(container.bytes);
    padded.set(container, bytes);
    const buffer = container.buffer ?? primitive.getAttribute('POSITION')?.getBuffer() ?? this.document.getRoot().listBuffers()[0];
    otherBufferViews.set(buffer, [...otherBufferViews.get(buffer) ?? [], bytes]);
  }

  write(context) {
    const { json } = context.jsonDoc, kept = context.extensionData[kExtensionName];
    const views = context.extensionData[`${kExtensionName} views`];
    for (const [mesh, m] of context.meshIndexMap) {
      mesh.listPrimitives().forEach((primitive, p) => {
        const container = kept.get(primitive);
        if (container === undefined) return;
        const view = context.otherBufferViewsIndexMap.get(views.get(container)), definition = json.meshes[m].primitives[p];
        json.bufferViews[view].byteLength = container.bytes.length;
        const attributes = {}, targets = {};
        for (const { name, uniqueId } of present_attributes(primitive, container)) {
          const [, key, target] = place_of(primitive, name);
          if (target === undefined) attributes[key] = uniqueId;
          else (targets[key] ??= primitive.listTargets().map(() => -1))[target] = uniqueId;
        }
        definition.extensions = { ...definition.extensions, [kExtensionName]: { bufferView: view, attributes,
          ...(Object.keys(targets).length > 0 && { targets }) } };
      });
      const coarse = mesh.getExtension(kExtensionName), definition = json.meshes[m];
      if (coarse === null || !mesh.listPrimitives().some((primitive) => kept.has(primitive))) continue;
      definition.extensions = { ...definition.extensions, [kExtensionName]: { primitives: definition.primitives } };
      definition.primitives = coarse.list().map((primitive) => write_primitive(context, primitive));
    }
    if (kept.size > 0) return this;
    for (const list of ['extensionsUsed', 'extensionsRequired']) json[list] = json[list].filter((name) => name !== kExtensionName);
    return this;
  }
}

// KHR_draco_mesh_compression comes before this extension, and encodes all indexed triangles, if the asset has such primitives as
// well. Its state while it writes is { primitiveHashMap: primitive -> key, primitiveEncodingMap: key -> { data } }.
const draco_state = ({ extensionData }) => extensionData.KHR_draco_mesh_compression ?? {};
// Whether Draco alone has the primitive's accessors, and no other primitive needs them for Draco.
function is_draco_only(context, primitive, container, accessors) {
  const { primitiveHashMap, primitiveEncodingMap } = draco_state(context), key = primitiveHashMap?.get(primitive);
  return primitiveEncodingMap?.get(key)?.data !== undefined &&
    primitive.listAttributes().every((attribute) => accessors.includes(attribute)) &&
    [...primitiveHashMap].every(([other, of_other]) => of_other !== key || other.getExtension(kExtensionName) === container);
}
function take_back_from_draco(context, kept) {
  const { primitiveHashMap, primitiveEncodingMap } = draco_state(context), { accessorIndexMap, otherBufferViews } = context;
  for (const primitive of kept.keys()) {
    const encoded = primitiveEncodingMap?.get(primitiveHashMap.get(primitive));
    if (encoded === undefined) continue;
    primitiveHashMap.delete(primitive);
    for (const [buffer, views] of otherBufferViews) otherBufferViews.set(buffer, views.filter((view) => view !== encoded.data));
    for (const accessor of [primitive.getIndices(), ...primitive.listAttributes()])
      context.jsonDoc.json.accessors[accessorIndexMap.get(accessor)] = context.createAccessorDef(accessor);
  }
}

// What glTF-Transform's extension for meshoptimizer is about to compress: views, and for each its accessors and their bytes.
function meshopt_state(meshopt) {
  const views = meshopt?._encoderBufferViews ?? {}, definitions = meshopt?._encoderBufferViewAccessors ?? {}, data = meshopt?._encoderBufferViewData ?? {};
  const bytes = new Map(Object.keys(views).flatMap((key) => definitions[key].map((definition, i) => [definition, data[key][i]])));
  const definition_of = ({ accessorIndexMap, jsonDoc }, accessor) => {
    const definition = jsonDoc.json.accessors[accessorIndexMap.get(accessor)];
    return bytes.has(definition) ? definition : undefined;
  };
  // Removes accessors: definition -> the one without data. The extension writes a buffer for its views, which cannot be empty.
  const remove = (fresh) => {
    if (fresh.size > 0 && fresh.size === bytes.size)
      fresh.delete([...fresh.keys()].reduce((a, b) => (bytes.get(b).byteLength < bytes.get(a).byteLength ? b : a)));
    for (const key of Object.keys(views)) {
      const view = views[key], compressed = view.extensions[kMeshopt];
      definitions[key] = definitions[key].filter((definition) => !fresh.has(definition));
      data[key] = definitions[key].map((definition) => bytes.get(definition));
      view.byteLength = 0;
      for (const definition of definitions[key]) {
        definition.byteOffset = view.byteLength;
        view.byteLength += bytes.get(definition).byteLength;
      }
      compressed.count = view.byteLength / compressed.byteStride;
      if (view.byteLength === 0) for (const state of [views, definitions, data]) delete state[key];
    }
    for (const [definition, other] of fresh) {
      for (const name of Object.keys(definition)) delete definition[name];
      Object.assign(definition, other);
    }
  };
  return { definition_of, remove };
}

// Views of meshoptimizer lose the accessors that containers have.
function take_back_from_meshopt(context, meshopt, stored) {
  const fresh = stored.map((accessor) => [meshopt.definition_of(context, accessor), context.createAccessorDef(accessor)]);
  meshopt.remove(new Map(fresh.filter(([definition]) => definition !== undefined)));
}
function write_accessors(context, stored) {
  const { accessors } = context.jsonDoc.json;
  for (const accessor of stored) {
    if (context.accessorIndexMap.has(accessor)) continue;
    context.accessorIndexMap.set(accessor, accessors.length);
    accessors.push(context.createAccessorDef(accessor));
  }
}

// The attributes of a container that the primitive has. Others were removed: they stay in the container, but are not read.
const present_attributes = (primitive, { attributes }) => attributes.map((attribute) =>
  ({ ...attribute, accessor: attribute_of(primitive, attribute.name) })).filter(({ accessor }) => accessor !== null);
const is_in_mesh = (primitive) => primitive.listParents().some((parent) => [PropertyType.MESH, kCoarse].includes(parent.propertyType));
const has_coarse = (primitive) => primitive.listParents().every((parent) =>
  parent.propertyType !== PropertyType.MESH || parent.getExtension(kExtensionName) !== null);
const used_by_mesh = (container) => container.listParents().some((parent) =>
  parent.propertyType === PropertyType.PRIMITIVE && is_in_mesh(parent));

// --- psplit()

// Why a primitive cannot be encoded; undefined if it can.
function reason_to_leave(primitive) {
  const indices = primitive.getIndices()?.getArray(), position = primitive.getAttribute('POSITION');
  if (primitive.getExtension(kExtensionName) !== null) return 'it is in patches already';
  if (primitive.getMode() !== Primitive.Mode.TRIANGLES) return 'it is no list of triangles';
  if (position === null || position.getCount() === 0) return 'it has no positions';
  if (primitive.listSemantics().some((name) => primitive.getAttribute(name).getComponentType() === 5125)) return 'an attribute holds 32-bit integers';
  return (indices?.length ?? position.getCount()) === 0 ? 'it has no triangles' : undefined;
}

// Groups of primitives with the same geometry, in their order: { place, primitives, meshes }.
function groups_of(meshes, leave) {
  const numbers = new Map(), groups = new Map();
  const number = (accessor) => numbers.get(accessor) ?? numbers.set(accessor, numbers.size).get(accessor);
  const key_of = (of) => of.listSemantics().map((name) => [name, number(of.getAttribute(name))]);
  meshes.forEach((mesh, m) => mesh.listPrimitives().forEach((primitive, p) => {
    const reason = reason_to_leave(primitive);
    const place = `mesh ${m}, primitive ${p}`;
    if (reason !== undefined) return leave(`${place}: ${reason}`);
    const key = JSON.stringify([number(primitive.getIndices()), key_of(primitive), primitive.listTargets().map(key_of)]);
    if (!groups.has(key)) groups.set(key, { place, primitives: [], meshes: [] });
    groups.get(key).primitives.push(primitive);
    groups.get(key).meshes.push(m);
  }));
  return [...groups.values()];
}

// For each group the number of its set; groups of a set share grids. Meshes that have a geometry in common are quantized as one.
function grids_of(groups, volume) {
  if (volume !== 'mesh') return groups.map((_, i) => (volume === 'primitive' ? i : 0));
  const lowest = new Map(), root = (mesh) => (lowest.has(mesh) ? root(lowest.get(mesh)) : mesh);
  for (const { meshes } of groups)
    for (const mesh of meshes) {
      const [low, high] = [root(meshes[0]), root(mesh)].sort((a, b) => a - b);
      if (low !== high) lowest.set(high, low);
    }
  return groups.map(({ meshes }) => root(meshes[0]));
}

// By which vectors nodes move meshes against each other, three numbers each; undefined if they do not; null if they also turn or
// scale them, or are too many. In the coordinates that the meshes have before the nodes count that all of them are below.
// Skinned meshes do not count. This is the rule of gltf-psplit's --quantization-volume scene.
function offsets_of(root, meshes) {
  const kMostNodes = 100000, paths = [], left = root.listScenes().flatMap((scene) => scene.listChildren().map((node) => [node]));
  for (let visits = 0; left.length > 0; ++visits) {
    if (visits > root.listNodes().length + kMostNodes) return null;
    const path = left.pop(), node = path.at(-1);
    if (meshes.has(node.getMesh()) && node.getSkin() === null) paths.push(path);
    left.push(...node.listChildren().map((child) => [...path, child]));
  }
  if (paths.length < 2) return undefined;
  let common = paths[0].length;
  for (const path of paths) {
    const differs = path.findIndex((node, i) => node !== paths[0][i]);
    common = Math.min(common, differs < 0 ? path.length : differs);
  }
  const is = (value, neutral) => value.every((number, i) => number === neutral[i]);
  const moved = paths.map((path) => path.slice(common).reduce((sum, node) => (sum === null || !is(node.getRotation(), [0, 0, 0, 1]) ||
    !is(node.getScale(), [1, 1, 1]) || node.getExtension('EXT_mesh_gpu_instancing') !== null ? null
    : sum.map((number, c) => number + node.getTranslation()[c])), [0, 0, 0]));
  if (moved.includes(null)) return null;
  const offsets = moved.map((sum) => sum.map((number, c) => number - moved[0][c])).filter((offset) => !is(offset, [0, 0, 0]));
  return offsets.length === 0 ? undefined : Float64Array.from(offsets.flat());
}

// The names of morph targets in slots, which a container stores or not. gltf-psplit has the same rules.
function names_of_targets(primitive, { exact = [], lossless }) {
  const stored = [], others = [];
  for (const [t, target] of primitive.listTargets().entries()) for (const name of target.listSemantics()) {
    const of_base = primitive.getAttribute(name)?.getArray(), array = target.getAttribute(name).getArray();
    const fits = array instanceof Float32Array ? !lossless && of_base instanceof Float32Array && !exact.includes(name) : !(array instanceof Uint32Array);
    const has_room = primitive.listSemantics().length + stored.length < kMostAttributes;
    (fits && has_room && array.some((value) => value !== 0) ? stored : others).push(`targets/${t}/${name}`);
  }
  return { stored, others };
}

// Data, as bytes for each point.
function bytes_of_points(arrays, points) {
  if (arrays.length === 0) return undefined;
  const widths = arrays.map(({ byteLength }) => byteLength / points), stride = widths.reduce((a, b) => a + b);
  const bytes = new Uint8Array(points * stride);
  let offset = 0;
  arrays.forEach((array, k) => {
    const from = new Uint8Array(array.buffer, array.byteOffset, array.byteLength), width = widths[k];
    for (let i = 0; i < points; ++i) bytes.set(from.subarray(i * width, (i + 1) * width), i * stride + offset);
    offset += width;
  });
  return bytes;
}

/** A transform: makes patches of all lists of triangles. */
export function psplit(options) {
  const { encoder, quantizationVolume = 'mesh', required = true, wasm, ...rest } = options ?? {};
  if (!['primitive', 'mesh', 'scene'].includes(quantizationVolume))
    throw new PsplitError(`the option \`quantizationVolume\` cannot be ${String(quantizationVolume)}`, 'invalid-input');
  async function psplit(document) {
    const root = document.getRoot(), graph = document.getGraph(), left = [];
    const groups = groups_of(root.listMeshes(), (reason) => left.push(reason));
    const meshes = groups.map((group) => {
      const { primitives: [primitive] } = group, { stored, others } = names_of_targets(primitive, rest);
      group.others = others;
      return { indices: primitive.getIndices()?.getArray(),
        attributes: Object.fromEntries([...primitive.listSemantics(), ...stored].map((name) => {
          const accessor = attribute_of(primitive, name);
          return [name, { array: accessor.getArray(), componentCount: accessor.getElementSize(), normalized: accessor.getNormalized() }];
        })),
        distinct: bytes_of_points(others.map((name) => attribute_of(primitive, name).getArray()), primitive.getAttribute('POSITION').getCount()) };
    });
    const { encodeMeshes } = encoder === undefined ? await import('./encode.js') : { encodeMeshes: (...of) => encoder.encodeMeshes(...of) };
    const offsets = quantizationVolume === 'scene' ? offsets_of(root, new Set(groups.flatMap(({ meshes: of }) => of.map((m) => root.listMeshes()[m])))) : undefined;
    const results = groups.length === 0 ? [] : await encodeMeshes(meshes, { ...rest, decoded: true, leave: true,
      grids: grids_of(groups, quantizationVolume), offsets: offsets ?? undefined });
    if (groups.length > 0 && (offsets === null || results.some(({ meets }) => meets === false)))
      document.getLogger().warn(`[${kExtensionName}] Nodes place meshes so that their grids do not meet: surfaces that touch may come apart.`);
    results.forEach(({ unsupported }, i) => unsupported !== undefined && left.push(`${groups[i].place}: ${unsupported}`));
    if (left.length > 0) document.getLogger().warn(`[${kExtensionName}] Some geometry is left as it is: ${left.join('; ')}.`);
    if (results.every(({ unsupported }) => unsupported !== undefined)) return;
    const extension = document.createExtension(PsplitMeshDracoPatches).setRequired(required);
    // Writing compares geometry with its containers.
    if (!extension.hasDecoder) extension.install('psplit.decoder', await createDecoder({ wasm }));

    const replaced = new Set();
    groups.forEach(({ primitives, others }, i) => {
      if (results[i].unsupported !== undefined) return;
      const { container: bytes, attributes, indices, pointCount, sourcePoints } = results[i], [first] = primitives;
      const buffer = first.getAttribute('POSITION').getBuffer() ?? root.listBuffers()[0] ?? document.createBuffer();
      const like = (accessor, array) => document.createAccessor(accessor?.getName()).setType(accessor?.getType() ?? 'SCALAR')
        .setNormalized(accessor?.getNormalized() ?? false).setArray(array).setBuffer(buffer);
      const made = Object.fromEntries(attributes.map(({ name, array }) => [name, like(attribute_of(first, name), array)]));
      const made_indices = like(first.getIndices(), pointCount <= 0xffff ? new Uint16Array(indices) : indices);
      for (const name of others) {
        const accessor = attribute_of(first, name), width = accessor.getElementSize(), from = accessor.getArray();
        const array = new from.constructor(width * pointCount);
        sourcePoints.forEach((source, point) => array.set(from.subarray(source * width, (source + 1) * width), point * width));
        made[name] = like(accessor, array).setSparse(accessor.getSparse());
      }
      const container = new PatchContainer(graph).fill(bytes,
        attributes.map(({ name, uniqueId, type, componentCount, normalized }) => ({ name, uniqueId, type, componentCount, normalized })), buffer);
      for (const primitive of primitives) {
        replaced.add(primitive.getIndices());
        primitive.setIndices(made_indices).setExtension(kExtensionName, container);
        for (const name of Object.keys(made)) {
          const [holder, key] = place_of(primitive, name);
          replaced.add(holder.getAttribute(key));
          holder.setAttribute(key, made[name]);
        }
      }
    });
    for (const accessor of replaced)
      if (accessor !== null && accessor.listParents().every(({ propertyType }) => propertyType === PropertyType.ROOT)) accessor.dispose();
  }
  return psplit;
}
