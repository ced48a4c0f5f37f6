// Compares what three's GLTFLoader made of two assets. Runs in Node.js and in pages.

const bytes_of = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);

function same_bytes(a, b) {
  const first = bytes_of(a), second = bytes_of(b);
  return first.length === second.length && first.every((byte, i) => byte === second[i]);
}

// The values of an attribute without gaps, in their own type.
export function values_of(attribute) {
  if (attribute.data === undefined) return attribute.array;
  const { data: { array, stride }, offset, itemSize, count } = attribute;
  const values = new array.constructor(count * itemSize);
  for (let i = 0; i < values.length; ++i) values[i] = array[offset + Math.floor(i / itemSize) * stride + (i % itemSize)];
  return values;
}

// DRACOLoader makes all indices 32 bits wide.
const wide = (index) => ({ ...index, array: Uint32Array.from(index.array), count: index.count });

function attribute_difference(name, a, b) {
  const facts = ({ itemSize, normalized, count }, values) => `${values.constructor.name} ${itemSize} ${normalized} ${count}`;
  const first = values_of(a), second = values_of(b);
  if (facts(a, first) !== facts(b, second)) return [`${name}: ${facts(b, second)}, not ${facts(a, first)}`];
  return same_bytes(first, second) ? [] : [`${name}: other values`];
}

// Returns the differences of `actual` from `expected` as lines of text.
export function geometry_differences(expected, actual) {
  const names = (geometry) => Object.keys(geometry.attributes).sort().join(' ');
  if (names(expected) !== names(actual)) return [`attributes: ${names(actual)}, not ${names(expected)}`];
  if ((expected.index === null) !== (actual.index === null)) return ['one has no index'];
  const pairs = Object.keys(expected.attributes).map((name) => [name, expected.attributes[name], actual.attributes[name]]);
  if (expected.index !== null) pairs.push(['index', wide(expected.index), wide(actual.index)]);
  for (const [name, targets] of Object.entries(expected.morphAttributes))
    for (const [i, target] of targets.entries()) pairs.push([`target ${i}: ${name}`, target, actual.morphAttributes[name]?.[i]]);
  const lines = pairs.flatMap(([name, a, b]) => (b === undefined ? [`${name} is missing`] : attribute_difference(name, a, b)));
  if (JSON.stringify(expected.boundingBox) !== JSON.stringify(actual.boundingBox)) lines.push('other bounds');
  if (JSON.stringify(expected.userData) !== JSON.stringify(actual.userData)) lines.push('other extras');
  return lines;
}

// The geometries of a loaded asset by the mesh and primitive of glTF that they are of.
export async function geometries_of({ parser }) {
  const geometries = new Map();
  for (const [mesh, { primitives }] of (parser.json.meshes ?? []).entries()) {
    const loaded = await parser.loadGeometries(primitives);
    for (const [primitive, geometry] of loaded.entries()) geometries.set(`mesh ${mesh}, primitive ${primitive}`, geometry);
  }
  return geometries;
}

export async function scene_differences(expected, actual) {
  const first = await geometries_of(expected), second = await geometries_of(actual);
  if ([...first.keys()].join() !== [...second.keys()].join()) return [`${[...second.keys()]}, not ${[...first.keys()]}`];
  return [...first].flatMap(([name, geometry]) =>
    geometry_differences(geometry, second.get(name)).map((line) => `${name}: ${line}`));
}

// A plugin for GLTFLoader: plain materials, so that no images are loaded.
export const plain_materials = (Material) => () => ({ name: 'plain_materials', loadMaterial: async () => new Material() });
