// Compares what a loader made of a character and of what `encode --meshopt` made of it: points, faces, morph targets, skins and
// animations. Runs in Node.js and in pages. of_three() and of_babylon() give what a loader made in one form:
//
//   primitives  { key, indices, attributes: { NAME: { size, values } } }, morph targets as "NAME, target 3"
//   bones       the numbers of all inverse bind matrices
//   tracks      { key, path, times, values }

const kNames = { position: 'POSITION', normal: 'NORMAL', tangent: 'TANGENT', uv: 'TEXCOORD_0', uv1: 'TEXCOORD_1', color: 'COLOR_0', skinIndex: 'JOINTS_0',
  skinWeight: 'WEIGHTS_0' };
const kPaths = { position: 'translation', quaternion: 'rotation', scale: 'scale', morphTargetInfluences: 'weights' };

export function of_three({ scene, animations, parser }) {
  const primitives = [], bones = [];
  const numbers = (attribute) => ({ size: attribute.itemSize, values: Float32Array.from({ length: attribute.count * attribute.itemSize },
    (_, i) => attribute.getComponent(Math.floor(i / attribute.itemSize), i % attribute.itemSize)) });
  scene.traverse((object) => {
    if (object.isSkinnedMesh) bones.push(...object.skeleton.boneInverses.flatMap(({ elements }) => elements));
    if (object.geometry === undefined) return;
    const { geometry } = object, { meshes, primitives: p = 0 } = parser.associations.get(object), attributes = {};
    for (const [name, attribute] of Object.entries(geometry.attributes)) attributes[kNames[name] ?? name] = numbers(attribute);
    for (const [name, targets] of Object.entries(geometry.morphAttributes))
      targets.forEach((target, t) => (attributes[`${kNames[name]}, target ${t}`] = numbers(target)));
    const count = geometry.attributes.position.count;
    primitives.push({ key: `mesh ${meshes}, primitive ${p}`, attributes, corners: object.isPoints ? 1 : object.isLine ? 2 : 3,
      indices: geometry.index?.array ?? Uint32Array.from({ length: count }, (_, i) => i) });
  });
  const tracks = animations.flatMap(({ name: clip, tracks: of_clip }) => of_clip.map(({ name, times, values }, i) =>
    ({ key: `${clip}, track ${i}`, path: kPaths[name.slice(name.lastIndexOf('.') + 1)], times, values })));
  return { primitives, bones, tracks };
}

// Babylon.js makes meshes, skeletons and tracks in the order in which their data arrives.
const by = (name) => (a, b) => (a[name] < b[name] ? -1 : Number(a[name] > b[name]));

// The character in an AssetContainer of Babylon.js.
export function of_babylon({ meshes, skeletons, animationGroups }) {
  const kinds = { position: ['POSITION', 3], normal: ['NORMAL', 3], tangent: ['TANGENT', 4], uv: ['TEXCOORD_0', 2], matricesIndices: ['JOINTS_0', 4],
    matricesWeights: ['WEIGHTS_0', 4] };
  // Targets are what a point becomes, and not how far it goes.
  const deltas = (to, from) => Float32Array.from(to, (value, i) => value - from[i]);
  const primitives = meshes.filter((mesh) => mesh.getTotalVertices() > 0).map((mesh) => {
    const attributes = {}, targets = mesh.morphTargetManager;
    for (const [kind, [name, size]] of Object.entries(kinds)) {
      const values = mesh.getVerticesData(kind);
      if (values) attributes[name] = { size, values: Float32Array.from(values) };
    }
    for (let t = 0; t < (targets?.numTargets ?? 0); ++t)
      for (const [name, values] of [['POSITION', targets.getTarget(t).getPositions()], ['NORMAL', targets.getTarget(t).getNormals()]])
        if (values) attributes[`${name}, target ${t}`] = { size: 3, values: deltas(values, attributes[name].values) };
    const [pointer = ''] = mesh._internalMetadata?.gltf?.pointers?.filter((text) => text.startsWith('/meshes/')) ?? [];
    const [, m = 0, p = 0] = /^\/meshes\/(\d+)\/primitives\/(\d+)/.exec(pointer) ?? [];
    // Materials, which are not loaded, would tell triangles from other primitives.
    return { key: `mesh ${m}, primitive ${p}`, attributes, corners: 3, indices: Uint32Array.from(mesh.getIndices()) };
  }).sort(by('key'));
  const bones = [...skeletons].sort(by('id')).flatMap((skeleton) => skeleton.bones.flatMap((bone) => [...bone.getAbsoluteInverseBindMatrix().m]));
  const paths = { position: 'translation', rotationQuaternion: 'rotation', scaling: 'scale', influence: 'weights' }, names = new Map();
  for (const { name, morphTargetManager: targets } of meshes)
    for (let t = 0; t < (targets?.numTargets ?? 0); ++t) names.set(targets.getTarget(t), `${name}, target ${t}`);
  const tracks = animationGroups.flatMap(({ name, targetedAnimations }) => targetedAnimations.map(({ animation, target }) => {
    const keys = animation.getKeys(), numbers = ({ value }) => (typeof value === 'number' ? [value] : value.asArray()), path = paths[animation.targetProperty];
    return { key: `${name}, ${path} of ${names.get(target) ?? target.name}`, path, times: keys.map(({ frame }) => frame), values: keys.flatMap(numbers) };
  })).sort(by('key'));
  return { primitives, bones, tracks };
}

const largest = (values) => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
const equal = (a, b) => a.length === b.length && a.every((value, i) => value === b[i]);

// How far a value may be from the original one: the manual's bounds, for the defaults of `encode`.
function track_limit({ path, values }) {
  return { translation: largest(values) * 2 ** -15, scale: largest(values) * 2 ** -15, rotation: 6e-4, weights: 2 ** -9 }[path];
}
function track_differences(original, encoded) {
  const { key, path, times, values } = original;
  if (key !== encoded.key || path !== encoded.path || path === undefined) return [`${encoded.path} of ${encoded.key}, not ${path} of ${key}`];
  if (!equal(times, encoded.times)) return [`${key}: other times`];
  if (values.length !== encoded.values.length) return [`${key}: ${encoded.values.length} values, not ${values.length}`];
  const limit = track_limit(original), size = path === 'rotation' ? 4 : 1;
  for (let i = 0; i < values.length; i += size) {
    const from = values.slice(i, i + size), to = encoded.values.slice(i, i + size);
    // A quaternion and its opposite are one rotation.
    const length = size === 4 ? Math.hypot(...from) : 1, sign = size === 4 && from.reduce((sum, value, k) => sum + value * to[k], 0) < 0 ? -1 : 1;
    const most = Math.max(...from.map((value, k) => Math.abs(value / length - sign * to[k])));
    if (!(most <= limit)) return [`${key}: ${path} differs by ${most}, more than ${limit}`];
  }
  return [];
}

const kSteps = 2 ** 14 - 1;
// The largest error of an attribute: half a step of the mesh's grid for positions and their targets, half of 2^-9 for targets of normals.
function limit_of(name, values, extent) {
  if (name.startsWith('POSITION')) return 0.51 * extent / kSteps + 1e-7 * extent;
  if (/^(NORMAL|TANGENT), target/.test(name)) return 2 ** -10;
  if (name === 'NORMAL' || name === 'TANGENT') return 0.01;
  if (name.startsWith('JOINTS')) return 0;
  if (name.startsWith('WEIGHTS')) return 1.51 / 255;  // of 8 bits, and rounded together
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < values.length; ++i) [low, high] = [Math.min(low, values[i]), Math.max(high, values[i])];
  return 0.51 * (high - low) / (name.startsWith('COLOR') ? 255 : 4095) + 1e-6;
}
function extent_of(primitives, key) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], [mesh] = key.split(',');
  for (const { key: other, attributes: { POSITION: { values } } } of primitives)
    if (other.split(',')[0] === mesh) {
      values.forEach((value, i) => {
        low[i % 3] = Math.min(low[i % 3], value);
        high[i % 3] = Math.max(high[i % 3], value);
      });
    }
  return Math.max(...high.map((value, i) => value - low[i]));
}
// The faces, except those that repeat a point, which `encode` drops.
function faces_of({ indices, corners }) {
  const faces = [];
  for (let i = 0; i + corners <= indices.length; i += corners) faces.push([...indices.subarray(i, i + corners)]);
  return faces.filter((face) => new Set(face).size === corners);
}
const used_points = (primitive) => [...new Set(faces_of(primitive).flat())];

// Points of `a` that no point of `b` equals within the limits. Both have the same attributes.
function points_alone(a, b, limits) {
  const cell = 2 * limits.POSITION || 1, cells = new Map(), { values: of_b } = b.attributes.POSITION, { values: of_a } = a.attributes.POSITION;
  const key = (values, point, [x, y, z] = [0, 0, 0]) =>
    `${Math.floor(values[3 * point] / cell) + x},${Math.floor(values[3 * point + 1] / cell) + y},${Math.floor(values[3 * point + 2] / cell) + z}`;
  for (const point of used_points(b)) {
    const at = key(of_b, point);
    if (!cells.has(at)) cells.set(at, []);
    cells.get(at).push(point);
  }
  const columns = Object.entries(a.attributes).map(([name, { size, values }]) => [size, values, b.attributes[name].values, limits[name]]);
  const is_same = (one, other) => columns.every(([size, left, right, limit]) => {
    for (let c = 0; c < size; ++c) if (!(Math.abs(left[one * size + c] - right[other * size + c]) <= limit)) return false;
    return true;
  });
  const around = [-1, 0, 1].flatMap((x) => [-1, 0, 1].flatMap((y) => [-1, 0, 1].map((z) => [x, y, z])));
  return used_points(a).filter((point) => !around.some((move) => (cells.get(key(of_a, point, move)) ?? []).some((other) => is_same(point, other))));
}

function primitive_differences(original, encoded, extent) {
  const { key, attributes } = original, names = (of) => Object.keys(of.attributes).sort().join('; ');
  if (encoded.key !== key || names(original) !== names(encoded)) return [`${encoded.key} with ${names(encoded)}, not ${key} with ${names(original)}`];
  const limits = Object.fromEntries(Object.entries(attributes).map(([name, { values }]) => [name, limit_of(name, values, extent)]));
  const lines = [];
  const [before, after] = [original, encoded].map((primitive) => faces_of(primitive).length);
  if (before !== after) lines.push(`${key}: ${after} faces, not ${before}`);
  for (const [a, b, whose] of [[original, encoded, 'the original'], [encoded, original, 'the other']]) {
    const alone = points_alone(a, b, limits);
    if (alone.length > 0) lines.push(`${key}: ${alone.length} points of ${whose} are alone, such as ${alone[0]}`);
  }
  return lines;
}

// In what `encoded` differs from `original` by more than is stated: lines of text.
export function character_differences(original, encoded) {
  const pairs = (list) => original[list].map((item, i) => [item, encoded[list][i]]);
  for (const list of ['primitives', 'tracks'])
    if (original[list].length !== encoded[list].length) return [`${encoded[list].length} ${list}, not ${original[list].length}`];
  return [...equal(original.bones, encoded.bones) ? [] : ['other inverse bind matrices'],
    ...pairs('tracks').flatMap(([a, b]) => track_differences(a, b)),
    ...pairs('primitives').flatMap(([a, b]) => primitive_differences(a, b, extent_of(original.primitives, a.key)))];
}
// How much there is to compare.
export const counts_of = ({ primitives, bones, tracks }) => ({ primitives: primitives.length, bones: bones.length / 16, tracks: tracks.length,
  targets: primitives.reduce((sum, { attributes }) => sum + Object.keys(attributes).filter((name) => name.includes('POSITION, target')).length, 0) });
