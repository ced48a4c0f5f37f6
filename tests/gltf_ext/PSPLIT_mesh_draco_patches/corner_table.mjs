// The connectivity of a Draco mesh: what "Version 3" of the specification refers to Draco's own for.
import { demand } from './bits.mjs';

export const next = (corner) => (corner % 3 === 2 ? corner - 2 : corner + 1);
export const previous = (corner) => (corner % 3 === 0 ? corner + 2 : corner - 1);
export const kC = 0, kS = 1, kL = 2, kR = 3, kE = 4;

// Draco's "Edgebreaker decoder": the corner table of symbols. next_symbol returns them from the second on; it is told the
// valence of the vertex at corner 1 of the last face.
export function decode_connectivity(faces, symbol_count, events, start_faces, next_symbol) {
  const opposite = new Int32Array(3 * faces).fill(-1), vertex = new Int32Array(3 * faces);
  const valence = [], stack = [], set_aside = new Map();
  let symbol = kE, splits = 0;
  const link = (a, b) => {
    demand(a !== undefined && opposite[a] === -1 && opposite[b] === -1 && a !== b, 'symbols that do not form a mesh');
    opposite[a] = b;
    opposite[b] = a;
  };
  const border_before = (corner) => {
    let at = previous(corner);
    while (opposite[at] >= 0 && at !== corner) at = previous(opposite[at]);
    return at;
  };
  const add = (corner, vertices, more) => vertices.forEach((v, k) => {
    vertex[corner + k] = v;
    valence[v] = (valence[v] ?? 0) + more[k];
  });

  const waiting = events.slice();
  for (let i = 0; i < symbol_count; ++i) {
    const corner = 3 * i, created = valence.length;
    if (i > 0) symbol = next_symbol(valence[vertex[corner - 2]]);
    const a = stack.at(-1);
    if (symbol === kC) {
      const b = border_before(a);
      const vertices = [vertex[next(a)], vertex[next(b)], vertex[previous(a)]];
      link(a, corner + 1);
      link(b, corner + 2);
      add(corner, vertices, [0, 1, 1]);
    } else if (symbol === kS) {
      splits += 1;
      const b = stack.pop();
      if (set_aside.has(i)) stack.push(set_aside.get(i));
      const a = stack.at(-1);
      demand(a !== undefined, 'symbols that do not form a mesh');
      const kept = vertex[previous(a)], merged = vertex[next(b)];
      demand(kept !== merged, 'symbols that do not form a mesh');
      for (let c = 0; c < corner; ++c) if (vertex[c] === merged) vertex[c] = kept;
      valence[kept] += valence[merged];
      const vertices = [kept, vertex[next(a)], vertex[previous(b)]];
      link(a, corner + 2);
      link(b, corner + 1);
      add(corner, vertices, [0, 1, 1]);
    } else if (symbol === kL) {
      const vertices = [vertex[next(a)], created, vertex[previous(a)]];
      link(a, corner + 1);
      add(corner, vertices, [1, 2, 1]);
    } else if (symbol === kR) {
      const vertices = [vertex[previous(a)], vertex[next(a)], created];
      link(a, corner + 2);
      add(corner, vertices, [1, 1, 2]);
    } else {
      stack.push(undefined);
      add(corner, [created, created + 1, created + 2], [2, 2, 2]);
    }
    demand(vertex[corner + 1] !== vertex[corner + 2], 'symbols that do not form a mesh');
    stack[stack.length - 1] = corner;
    if (symbol === kC || symbol === kS) continue;
    while (waiting.length > 0 && waiting.at(-1).source === symbol_count - 1 - i) {
      const { split, edge } = waiting.pop();
      set_aside.set(symbol_count - 1 - split, edge === 1 ? next(corner) : previous(corner));
    }
  }
  demand(waiting.length === 0, 'a split event of no symbol');

  demand(stack.length === start_faces.length, 'another number of components');
  let corner = 3 * symbol_count;
  for (const has_start_face of start_faces) {
    const a = stack.pop();
    if (has_start_face === 0) continue;
    demand(opposite[a] === -1, 'symbols that do not form a mesh');
    const b = border_before(a), c = border_before(b);
    demand(a !== b && vertex[next(c)] === vertex[previous(a)], 'a start face that is not a triangle');
    const vertices = [vertex[next(b)], vertex[next(c)], vertex[next(a)]];
    link(corner, a);
    link(corner + 1, b);
    link(corner + 2, c);
    add(corner, vertices, [0, 0, 0]);
    corner += 3;
  }
  demand(corner === 3 * faces, 'another number of start faces');
  return { opposite, vertex, splits };
}

// The edges between two faces, in Draco's order, each by the corner across from it in the first face.
export function inner_edges({ opposite }) {
  const edges = [];
  opposite.forEach((across, corner) => { if (across > corner) edges.push(corner); });
  return edges;
}

// The corner table of an attribute: cut along seams, with vertices numbered in order of creation. Those at `known` corners
// come first.
export function attribute_table({ opposite }, seams, backward, known = []) {
  const cut = opposite.slice();
  for (const corner of seams) cut[corner] = cut[opposite[corner]] = -1;
  const vertex = new Int32Array(cut.length).fill(-1), corner_of = [];
  const table = { opposite: cut, vertex, corner_of };
  const see = (corner) => {
    if (vertex[corner] !== -1) return;
    vertex[corner] = corner_of.length;
    for (const swing of [swing_left, swing_right])
      for (let at = swing(table, corner); at !== -1 && vertex[at] === -1; at = swing(table, at))
        vertex[at] = corner_of.length;
    corner_of.push(corner);
  };
  known.forEach(see);
  table.known_count = corner_of.length;
  for (let corner = 0; corner < cut.length; corner += 3) {
    const first = backward ? cut.length - 3 - corner : corner;
    for (const k of backward ? [1, 2, 0] : [0, 1, 2]) see(first + k);
  }
  return table;
}
export const swing_left = ({ opposite }, c) => (opposite[next(c)] === -1 ? -1 : next(opposite[next(c)]));
export const swing_right = ({ opposite }, c) => (opposite[previous(c)] === -1 ? -1 : previous(opposite[previous(c)]));
