// What WGSL lacks, and what all stages share: bytes, views with bounds, products of 64 bits, and the numbers of corners. The stages
// are those of src/core, and have the names of its files; shaders.js says in which order they run.
//
// Every loop ends after as many steps as the counts of a stream allow, also if the stream is broken, and every load and store is
// clamped to its view: a stream that is broken changes its own memory only.
export const platform = /* wgsl */ `
struct Window { first: u32, count: u32 }

@group(0) @binding(0) var<storage, read> bytes: array<u32>;            // of all containers
@group(0) @binding(1) var<storage, read> plan: array<u32>;             // what the plan lists for streams
@group(0) @binding(2) var<storage, read> streams: array<Stream>;
@group(0) @binding(3) var<storage, read> attributes: array<Attribute>;
@group(0) @binding(4) var<storage, read_write> memory: array<u32>;     // of the streams of one window
@group(0) @binding(5) var<storage, read_write> walks: array<u32>;      // the mesh's points along the borders of all streams
@group(0) @binding(6) var<storage, read_write> results: array<u32>;
@group(0) @binding(7) var<storage, read_write> states: array<atomic<u32>>;
@group(0) @binding(8) var<uniform> window: Window;

const kNone = 0xffffffffu;
override kStreamsPerGroup: u32 = 8;
const kLanes = 64u;  // of stages in which all lanes of a group share a stream

// The state of each stream, which the host reads: a fault, and counts.
const kStateWords = 4u;
const kFault = 0u;
const kVertexCount = 1u;
const kPointCount = 2u;
const kWalkLength = 3u;
fn state(i: u32, k: u32) -> u32 { return atomicLoad(&states[kStateWords * i + k]); }
fn set_state(i: u32, k: u32, value: u32) { atomicStore(&states[kStateWords * i + k], value); }
fn is_fine(i: u32) -> bool { return state(i, kFault) == 0u; }
fn fail(i: u32) { set_state(i, kFault, 1u); }

// An array of a stream: its place in memory, and its length, which is not 0.
alias View = vec2u;
fn load(view: View, i: u32) -> u32 { return memory[view.x + min(i, view.y - 1u)]; }
fn store(view: View, i: u32, value: u32) { memory[view.x + min(i, view.y - 1u)] = value; }

fn byte_at(at: u32) -> u32 { return (bytes[at >> 2u] >> (8u * (at & 3u))) & 0xffu; }
// 32 bits from bit "bit" on, counted from byte "base". Bits from byte "end" on are 0.
fn bits_at(base: u32, bit: u32, end: u32) -> u32 {
  let byte = base + (bit >> 3u);
  if (byte >= end) { return 0u; }
  let shift = 8u * (byte & 3u) + (bit & 7u);
  let word = byte >> 2u;
  var value = bytes[word] >> shift;
  if (shift > 0u) { value |= bytes[word + 1u] << (32u - shift); }
  let left = 8u * (end - byte) - (bit & 7u);
  return select(value, value & ((1u << (left & 31u)) - 1u), end - byte < 5u && left < 32u);
}

// Corner k of face f has number 4 f + k (src/core/corner_table.h).
fn next(corner: u32) -> u32 { return select(corner + 1u, corner - 2u, (corner & 2u) != 0u); }
fn previous(corner: u32) -> u32 { return select(corner + 2u, corner - 1u, (corner & 3u) != 0u); }
fn swing_left(opposite: View, corner: u32) -> u32 {
  let across = load(opposite, next(corner));
  return select(next(across), kNone, across == kNone);
}
fn swing_right(opposite: View, corner: u32) -> u32 {
  let across = load(opposite, previous(corner));
  return select(previous(across), kNone, across == kNone);
}

// The arrays of a stream's mesh.
fn opposite_of(s: Stream) -> View { return View(s.opposite, 4u * s.face_count); }
fn vertex_of(s: Stream) -> View { return View(s.vertex, 4u * s.face_count); }
fn border_of(s: Stream) -> View { return View(s.border, s.vertex_limit + 3u); }          // the corner of the edge that leaves a vertex
fn beyond_of(s: Stream) -> View { return View(s.border + s.vertex_limit + 3u, s.vertex_limit + 3u); }  // and the vertex at its end
fn scratch_of(s: Stream) -> View { return View(s.scratch, s.scratch_count); }
fn numbers_of(s: Stream) -> View { return View(s.numbers, s.point_count); }
fn references_of(s: Stream) -> View { return View(s.references, 2u * s.reference_count + 1u); }
// Of streams with attribute data, also: the point at each corner, a corner of each point, and for each data its cut table and the
// vertices on its seams.
fn point_at_of(s: Stream) -> View { return View(select(s.point_at, s.vertex, s.data_count == 0u), 4u * s.face_count); }
fn corner_of_point_of(s: Stream) -> View { return View(s.point_at + 4u * s.face_count, s.point_count); }
fn point_counts_of(s: Stream) -> View { return View(s.point_at + 4u * s.face_count + s.point_count, s.point_count); }
fn data_at(s: Stream, data: u32) -> u32 { return s.cut + data * (8u * s.face_count + s.point_count + kDataWords); }
fn cut_opposite_of(s: Stream, data: u32) -> View { return View(data_at(s, data), 4u * s.face_count); }
fn cut_vertex_of(s: Stream, data: u32) -> View { return View(data_at(s, data) + 4u * s.face_count, 4u * s.face_count); }
fn on_seam_of(s: Stream, data: u32) -> View { return View(data_at(s, data) + 8u * s.face_count, s.point_count); }
fn data_words_of(s: Stream, data: u32) -> View { return View(data_at(s, data) + 8u * s.face_count + s.point_count, kDataWords); }
const kDataWords = 2u;
const kHasSeams = 0u;
const kDataVertices = 1u;

// Whether a vertex of the mesh is on no border. All faces are there.
fn is_closed(s: Stream, vertex: u32) -> bool {
  let corner = load(border_of(s), vertex);
  return corner != kNone && load(opposite_of(s), corner) != kNone;
}

// A group of attributes: which data has its seams, and what it says of its values.
struct Group { has_data: bool, data: u32, first: u32, count: u32, at: u32, walk: u32, by_degree: bool }
fn group_of(s: Stream, g: u32) -> Group {
  let at = s.groups + kGroupWords * g;
  return Group(plan[at] > 0u, plan[at] - 1u, plan[at + 1u], plan[at + 2u], plan[at + 3u], plan[at + 4u], plan[at + 5u] != 0u);
}
// The table of a group, and its sequence: the corner at which a walk met each vertex, and the place of each vertex.
struct Table { opposite: View, vertex: View, count: u32, corner: View, rank: View }
fn table_of(s: Stream, i: u32, group: Group) -> Table {
  var table = Table(opposite_of(s), vertex_of(s), state(i, kVertexCount), View(group.at, s.point_count + 1u),
    View(group.at + s.point_count + 1u, s.point_count));
  if (group.has_data && load(data_words_of(s, group.data), kHasSeams) != 0u) {
    table.opposite = cut_opposite_of(s, group.data);
    table.vertex = cut_vertex_of(s, group.data);
    table.count = load(data_words_of(s, group.data), kDataVertices);
  }
  return table;
}
`;
