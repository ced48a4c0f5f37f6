// References to points of other streams (src/core/stitch.h), when all streams up to this one are numbered. The lanes of a group share a
// stream.
export const stitch = /* wgsl */ `
@compute @workgroup_size(kLanes)
fn resolve(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  if (!is_fine(i)) { return; }
  let references = references_of(s);
  for (var r = lane; r < s.reference_count; r += kLanes) {
    let owner = load(references, 2u * r) & ~kIsPair;
    let place = load(references, 2u * r + 1u);
    if (load(references, 2u * r) == kIsRepeat) { continue; }
    var number = streams[owner].first_point + place;
    var count = streams[owner].point_count - streams[owner].reference_count;
    if ((load(references, 2u * r) & kIsPair) == 0u) {
      count = state(owner, kWalkLength);
      number = walks[streams[owner].walk + min(place, max(count, 1u) - 1u)];
    }
    if (place >= count || number == kNone) { fail(i); }
    store(references, 2u * r + 1u, number);
  }
}
`;
