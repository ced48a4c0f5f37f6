// Values at borders (src/core/condensed/border_part.h), when the walks of all streams up to this one are numbered: by place of a walk a
// word that says whether the value is the stream's own, and the value. They are beside the numbers of points, because streams of other windows
// share them.
export const border_part = /* wgsl */ `
fn known_at(s: Stream, place: u32) -> u32 {
  return record_of(s, kKnownField) + min(place, max(record_of(s, kMostPlacesField), 1u) - 1u) * (1u + record_of(s, kBorderWidthField));
}

// One thread puts the stream's own values to their places: those that no run of the stitch map has.
@compute @workgroup_size(kStreamsPerGroup)
fn place_own_values(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || record_of(s, kHasBordersField) == 0u) { return; }
  let walk = walk_of(s);
  let length = state(i, kWalkLength);
  let width = record_of(s, kBorderWidthField);
  var count = 0u;
  var before = kNone;
  for (var place = 0u; place < length && place < record_of(s, kMostPlacesField); place++) {
    let at = known_at(s, place);
    let is_own = run_of(s, load(walk, place)) == kNone;
    walks[at] = select(0u, 1u, is_own);
    if (!is_own) { continue; }
    if (count == record_of(s, kBorderCountField)) {
      count = kNone;
      break;
    }
    for (var c = 1u; c <= width; c++) {
      var value = signed_of_symbol(memory[record_of(s, kOwnValuesField) + width * count + c - 1u]);
      if (before != kNone) { value += i32(walks[before + c]); }
      walks[at + c] = u32(value);
    }
    before = at;
    count += 1u;
  }
  if (count != record_of(s, kBorderCountField) || length > record_of(s, kMostPlacesField)) { fail(i); }
}
// The reference of a point that is in a run, or kNone.
fn run_of(s: Stream, point: u32) -> u32 {
  let number = load(numbers_of(s), point);
  if (number < s.mesh_points || (load(references_of(s), 2u * (number - s.mesh_points)) & kIsPair) != 0u) { return kNone; }
  return number - s.mesh_points;
}

// All lanes of a group copy what other streams own.
@compute @workgroup_size(kLanes)
fn share_values(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  if (!is_fine(i) || record_of(s, kHasBordersField) == 0u) { return; }
  let walk = walk_of(s);
  let width = record_of(s, kBorderWidthField);
  for (var place = lane; place < state(i, kWalkLength); place += kLanes) {
    let r = run_of(s, load(walk, place));
    if (r == kNone) { continue; }
    let owner = load(references_of(s), 2u * r);
    let there = load(references_of(s), 2u * r + 1u);
    let source = known_at(streams[owner], there);
    if (there >= state(owner, kWalkLength) || walks[source] == 0u) { fail(i); }
    for (var c = 1u; c <= width; c++) { walks[known_at(s, place) + c] = walks[source + c]; }
  }
}
`;
