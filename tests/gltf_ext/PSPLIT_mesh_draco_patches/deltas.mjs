// "Deltas" of the specification.
import { bit_reader, demand, kinds_of } from './bits.mjs';
import { next, previous, swing_left, swing_right } from './corner_table.mjs';

const kLevels = 21, kMostSources = 8;

// The head's section of type 3. `token_table` reads a table. `attributes` come from the section of tables; attributes of
// deltas get a mark.
export function parse_deltas(part, attributes, token_table) {
  const { bits, number, signed, end } = bit_reader(part, 'section of deltas');
  const kinds = kinds_of({ count: 0, used: 5, skip: 0, zero: 10, back: 1, factor: 5 });
  const models = [], count = number(kinds.count) + 1;
  for (let n = 0, attribute = 0; n < count; ++n) {
    attribute += number(kinds.skip) + 1;
    demand(attribute < attributes.length, 'deltas of an attribute without a model');
    const model = attributes[attribute];
    demand(model.by_creation && model.sets.length === 1, 'deltas with a model of other values');
    model.is_delta = true;
    const is_even = bits(1) === 1, zero = [0, 1, 2].map(() => signed(kinds.zero));
    let reference = -1, factor = 0;
    if (bits(1) === 1) {
      reference = n - number(kinds.back) - 1;
      factor = signed(kinds.factor);
      demand(reference >= 0 && Math.abs(factor) <= 32767, 'an invalid reference');
    }
    models.push({ attribute, is_even, zero, reference, factor });
  }
  const some = bits(12);
  demand(some > 0, 'a probability of 0');
  const begins = Array.from({ length: kLevels }, (_, level) => level === 0 || bits(1) === 1);
  demand(begins.filter((begin) => begin).length <= 8, 'too many tables of deltas');
  const runs = token_table(number, kinds.used), tables = [];
  begins.forEach((begin, level) => tables.push(begin ? token_table(number, kinds.used) : tables[level - 1]));
  end();
  return { models, some, runs, tables };
}

// The sources that come before vertex i: vertices are numbered in order of creation.
function sources_of({ opposite, vertex, corner_of }, i) {
  const neighbours = new Set(), across = new Set(), table = { opposite };
  const add_face = (corner) => {
    const a = vertex[next(corner)], b = vertex[previous(corner)], far = opposite[corner];
    for (const v of [a, b]) if (v < i) neighbours.add(v);
    if (a < i && b < i && far !== -1 && vertex[far] < i) across.add(vertex[far]);
  };
  const start = corner_of[i];
  let corner = start;
  do {
    add_face(corner);
    corner = swing_left(table, corner);
  } while (corner !== -1 && corner !== start);
  if (corner === -1)
    for (corner = swing_right(table, start); corner !== -1; corner = swing_right(table, corner)) add_face(corner);
  if (neighbours.size === 0 && i > 0) neighbours.add(i - 1);
  const all = [...new Set([...neighbours, ...across])].sort((a, b) => b - a).slice(0, kMostSources);
  return { all, neighbours: all.filter((v) => neighbours.has(v)) };
}

function weights_of_shares(shares) {
  let total = shares.reduce((a, b) => a + b, 0);
  if (total <= 0) [shares, total] = [shares.map(() => 1), shares.length];
  const weights = shares.map((share) =>
    Math.min(127, Math.max(-127, Math.floor((64 * share + Math.floor(total / 2)) / total))));
  const largest = weights.indexOf(Math.max(...weights));
  weights[largest] += 64 - weights.reduce((a, b) => a + b, 0);
  return weights;
}

// `places` has the sources' places, seen from the vertex: three numbers each.
function affine_weights(places) {
  const count = places.length;
  if (count < 2) return weights_of_shares(places.map(() => 1));
  let shift = 0;
  while (places.flat().some((x) => (x >> shift) < -128 || (x >> shift) > 127)) ++shift;
  const y = places.map((place) => place.map((x) => x >> shift));
  const squares = y.map((at) => at.reduce((sum, x) => sum + x * x, 0));
  const mean = Math.floor(squares.reduce((a, b) => a + b, 0) / count) + 1;
  const q = squares.map((square) => Math.floor((256 * mean) / (20 * square + mean)) + 1);
  const sum = (f) => q.reduce((all, weight, n) => all + weight * f(y[n]), 0);
  const matrix = [0, 1, 2].map((r) => [0, 1, 2].map((c) =>
    sum((at) => at[r] * at[c]) + (r === c ? Math.floor((3 * mean) / 8) + 1 : 0)));
  let down = 0;
  while ([0, 1, 2].some((k) => matrix[k][k] >> down >= 2 ** 18)) ++down;
  const m = matrix.map((row, r) => row.map((x, c) => BigInt((x >> down) + (r === c ? 1 : 0))));
  const b = [0, 1, 2].map((k) => BigInt(sum((at) => at[k])));
  const cofactor = (r, c) => {
    const [r1, r2] = [(r + 1) % 3, (r + 2) % 3], [c1, c2] = [(c + 1) % 3, (c + 2) % 3];
    return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
  };
  const determinant = [0, 1, 2].reduce((all, c) => all + m[0][c] * cofactor(0, c), 0n) >> BigInt(16 - down);
  const limit = (x, most) => (x > most ? most : x < -most ? -most : x);
  const slope = [0, 1, 2].map((k) => (determinant > 0n
    ? limit([0, 1, 2].reduce((all, c) => all + cofactor(c, k) * b[c], 0n) / determinant, 1n << 24n) : 0n));
  return weights_of_shares(y.map((at, n) => {
    const along = at.reduce((all, x, k) => all + slope[k] * BigInt(x), 0n);
    return Number(limit((BigInt(q[n]) * (65536n - along)) >> 6n, 1n << 24n));
  }));
}

function level_of(sizes) {
  if (sizes.length === 0) return kLevels - 1;
  const mean = Math.floor((4 * sizes.reduce((a, b) => a + b, 0)) / sizes.length);
  if (mean < 2) return mean;
  const top = Math.floor(Math.log2(mean));
  return 2 * top + ((mean >> (top - 1)) & 1);
}

// The values of all attributes of deltas, by vertex: an array for each model. `is_row` says which of them are not 0
// everywhere, `place_of(corner)` is the place of a vertex, and `sections` are the coders.
export function decode_deltas({ models, some, runs, tables }, is_row, table, place_of, sections, uses) {
  const [flags, ...corrections] = sections;
  const vertices = table.corner_of.length, rows = models.map((_, n) => n).filter((n) => is_row[n]);
  const deltas = models.map(() => Array.from({ length: vertices }, () => [0, 0, 0]));
  const out = () => deltas.map((of, n) => of.map((delta) => delta.map((x, k) => (x + models[n].zero[k]) | 0)));
  if (rows.length === 0) return out();
  demand(runs.length > 0 && tables.every((table) => table.length > 0), 'deltas without a table');
  const remainders = models.map(() => []), sizes = models.map(() => []), is_some = models.map(() => []);
  let run = flags.token_value(runs);
  const narrow = (x) => Math.min(32767, Math.max(-32768, x));
  for (let i = 0; i < vertices; ++i) {
    const { all, neighbours } = sources_of(table, i);
    const here = place_of(table.corner_of[i]);
    const affine = affine_weights(all.map((v) => place_of(table.corner_of[v]).map((x, k) => (x - here[k]) | 0)));
    const even = weights_of_shares(all.map(() => 1));
    // Flags come in groups of 32: first the flags on which all neighbours agree, then the others.
    for (let first = 0; first < rows.length; first += 32) {
      const group = rows.slice(first, first + 32);
      const around = (n) => neighbours.map((v) => is_some[n][v]);
      const agree = (n) => new Set(around(n)).size < 2;
      for (const n of group.filter(agree)) {
        const expected = neighbours.length > 0 && around(n)[0];
        is_some[n][i] = run > 0 ? expected : !expected;
        run = run > 0 ? run - 1 : flags.token_value(runs);
      }
      for (const n of group.filter((n) => !agree(n))) is_some[n][i] = flags.flag(some) === 1;
    }
    for (const n of rows) {
      const { is_even, reference, factor } = models[n];
      const weights = is_even ? even : affine;
      const part = [0, 1, 2].map((k) => (reference >= 0 && is_row[reference]
        ? ((Math.imul(factor, deltas[reference][i][k]) + 32) | 0) >> 6 : 0));
      sizes[n][i] = [0, 0, 0];
      if (!is_some[n][i]) {
        remainders[n][i] = part.map((x) => narrow(-x | 0));
        continue;
      }
      const levels = [0, 1, 2].map((k) => level_of(all.map((v) => sizes[n][v][k])));
      const predicted = [0, 1, 2].map((k) =>
        (all.reduce((sum, v, s) => sum + weights[s] * remainders[n][v][k], 0) + 32) >> 6);
      const corrected = levels.map((level, k) => corrections[k].signed_value(tables[level]));
      remainders[n][i] = predicted.map((x, k) => narrow((x + corrected[k]) | 0));
      deltas[n][i] = predicted.map((x, k) => (x + corrected[k] + part[k]) | 0);
      sizes[n][i] = corrected.map((x) => Math.min(255, Math.abs(x)));
      uses.deltas = (uses.deltas ?? 0) + 1;
      uses.deltas_with_references = (uses.deltas_with_references ?? 0) + Number(reference >= 0);
    }
  }
  for (const section of sections) section.end();
  return out();
}
