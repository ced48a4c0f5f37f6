// Reads from the JSON of a glTF primitive what to ask of its container, and checks whether the decoded mesh fits it, by the rules of
// PSPLIT_mesh_draco_patches. Errors name the place in the primitive; callers add mesh and primitive.
import { PsplitError } from './error.js';

export const kExtensionName = 'PSPLIT_mesh_draco_patches';
export const kDraco = 'KHR_draco_mesh_compression';

// Types and counts by glTF's numbers and names.
export const kComponentTypes = { 5120: 'int8', 5121: 'uint8', 5122: 'int16', 5123: 'uint16', 5125: 'uint32', 5126: 'float32' };
export const kComponentCounts = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };
export const kIndexArrays = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array };

const invalid = (message) => new PsplitError(message, 'invalid-input');

/**
 * The bytes of an accessor without gaps, from its buffer view's bytes. Throws if it is not in them.
 * @returns {Uint8Array}
 */
export function packed(data, { byteOffset = 0, componentType, count, type }, { byteStride }) {
  const component_bytes = componentType >= 5125 ? 4 : componentType >= 5122 ? 2 : 1;
  const item_bytes = kComponentCounts[type] * component_bytes, stride = byteStride ?? item_bytes;
  if (!(byteOffset >= 0 && stride >= item_bytes && count >= 0 && (count === 0 || byteOffset + (count - 1) * stride + item_bytes <= data.length)))
    throw invalid('an accessor is not in its buffer view');
  const bytes = new Uint8Array(count * item_bytes);
  if (stride === item_bytes) bytes.set(data.subarray(byteOffset, byteOffset + bytes.length));
  else for (let i = 0, from = byteOffset; i < count; ++i, from += stride)
    bytes.set(data.subarray(from, from + item_bytes), i * item_bytes);
  return bytes;
}

/**
 * Where a primitive has the number of an accessor: an object and its key, for a morph target also its number. The name is that of
 * an attribute, or like targets/3/POSITION; undefined of indices.
 */
export function slot_of(primitive, name) {
  const [, target, key] = /^targets\/(\d+)\/(.+)/.exec(name) ?? [];
  return name === undefined ? [primitive, 'indices'] : key ? [primitive.targets?.[target], key, target] : [primitive.attributes, name];
}
export function number_of(primitive, name) {
  const [holder, key] = slot_of(primitive, name);
  return holder?.[key];
}
export function set_number(primitive, name, number) {
  const [holder, key] = slot_of(primitive, name);
  holder[key] = number;
}
/** The names of all attributes of a primitive, and of its morph targets. */
export const names_of = ({ attributes = {}, targets = [] }) => [...Object.keys(attributes),
  ...targets.flatMap((target, t) => Object.keys(target).map((name) => `targets/${t}/${name}`))];

function accessor_of(json, primitive, name) {
  const accessor = json.accessors?.[number_of(primitive, name)];
  name ??= 'indices';
  if (accessor === undefined) throw invalid(`${name} has no accessor`);
  if (accessor.sparse !== undefined) throw invalid(`${name} is in the patches, but its accessor is sparse`);
  return accessor;
}

/** The mesh with the primitives of its extension in place of coarse ones, which are for other loaders. */
export function fine_mesh(mesh, number) {
  const { [kExtensionName]: stored, ...extensions } = mesh.extensions ?? {};
  if (stored === undefined) return mesh;
  if (!Array.isArray(stored?.primitives) || stored.primitives.length === 0)
    throw invalid(`mesh ${number}: ${kExtensionName} of a mesh has no list of primitives`);
  return { ...mesh, extensions, primitives: stored.primitives };
}
/** Gives all meshes of an asset these primitives, in place. */
export function use_fine_meshes(json) {
  if (json.meshes !== undefined) json.meshes = json.meshes.map(fine_mesh);
}

/**
 * The container's buffer view, and the attributes to decode. Undefined if the primitive does not have the extension.
 * @returns {{ bufferView: number, attributes: import('./index.js').AttributeRequest[] } | undefined}
 */
export function stored_primitive(json, primitive) {
  const stored = primitive.extensions?.[kExtensionName];
  if (stored === undefined) return undefined;
  if ((primitive.mode ?? 4) !== 4) throw invalid('patches are triangle lists: mode must be 4');
  if (json.bufferViews?.[stored.bufferView] === undefined) throw invalid('the container has no buffer view');
  // Each semantic has an id for each target of the primitive, or -1.
  const targets = Object.entries(stored.targets ?? {}).flatMap(([name, ids]) => {
    if (!Array.isArray(ids) || ids.length !== primitive.targets?.length) throw invalid(`${kExtensionName} has no id for each target of ${name}`);
    return ids.map((id, t) => [`targets/${t}/${name}`, id]).filter(([, id]) => id !== -1);
  });
  const attributes = [...Object.entries(stored.attributes ?? {}), ...targets].map(([name, uniqueId]) => {
    const { componentType, type, normalized = false } = accessor_of(json, primitive, name);
    if (kComponentTypes[componentType] === undefined || kComponentCounts[type] === undefined)
      throw invalid(`the accessor of ${name} has no valid type`);
    return { name, uniqueId, type: kComponentTypes[componentType], componentCount: kComponentCounts[type], normalized };
  });
  if (attributes.length === targets.length) throw invalid(`${kExtensionName} has no attributes`);
  if (kIndexArrays[accessor_of(json, primitive).componentType] === undefined)
    throw invalid('the accessor of indices has no valid type');
  return { bufferView: stored.bufferView, attributes };
}

/**
 * The buffer view of the stream of a primitive in stock Draco, and the attributes to decode. Undefined if the primitive does not have
 * KHR_draco_mesh_compression. Draco says how many components they have.
 * @returns {{ bufferView: number, attributes: import('./index.js').AttributeRequest[] } | undefined}
 */
export function draco_primitive(json, primitive) {
  const stored = primitive.extensions?.[kDraco];
  if (stored === undefined) return undefined;
  if (json.bufferViews?.[stored.bufferView] === undefined) throw invalid('the Draco stream has no buffer view');
  const attributes = Object.entries(stored.attributes ?? {}).map(([name, uniqueId]) => {
    const accessor = json.accessors?.[primitive.attributes?.[name]];
    if (kComponentTypes[accessor?.componentType] === undefined) throw invalid(`${name} has no accessor with a valid type`);
    return { name, uniqueId, type: kComponentTypes[accessor.componentType], normalized: accessor.normalized ?? false };
  });
  return { bufferView: stored.bufferView, attributes };
}

/** Throws if a mesh with these counts does not fit the accessors of these attributes and of indices. */
export function check_counts(json, primitive, attributes, { faceCount, pointCount }) {
  for (const { name } of attributes) {
    const { count } = accessor_of(json, primitive, name);
    if (count !== pointCount) throw invalid(`the accessor of ${name} has ${count} points, but the patches have ${pointCount}`);
  }
  const { count, componentType } = accessor_of(json, primitive);
  if (count !== 3 * faceCount) throw invalid(`the accessor of indices has ${count} indices, but the patches have ${3 * faceCount}`);
  // No index may be the largest value of the type.
  if (pointCount > 2 ** (8 * kIndexArrays[componentType].BYTES_PER_ELEMENT) - 1)
    throw invalid(`${pointCount} points do not fit the component type ${componentType} of indices`);
}

/**
 * The component type of indices of a mesh with this many points: the accessor's, or a wider one. A mesh of chosen patches may
 * have more points than the whole.
 */
export const index_type = ({ componentType }, point_count) =>
  (point_count > 2 ** (8 * kIndexArrays[componentType].BYTES_PER_ELEMENT) - 1 ? 5125 : componentType);

/**
 * Whether all data of a primitive that goes with its points is in patches, so that patches may be left out.
 * @param {object} primitive as the JSON has it @param {{ name: string }[]} attributes of the patches
 */
export const is_all_stored = (primitive, attributes) => names_of(primitive).every((of) => attributes.some(({ name }) => name === of));

/** The mesh's indices in the type of the primitive's accessor. Throws if the mesh does not fit the accessors. */
export function fitting_indices(json, primitive, mesh) {
  check_counts(json, primitive, mesh.attributes, mesh);
  const Type = kIndexArrays[json.accessors[primitive.indices].componentType];
  return Type === Uint32Array ? mesh.indices : new Type(mesh.indices);
}
