// References to points of other streams (src/core/stitch.h), when all streams up to this one are numbered. The lanes of a group share a
// stream.
export const stitch = /* wgsl */ `
@compute @workgroup_size(kLanes)
fn resolve(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  if (!is_fine(i)) { return; }
  let references = references_of(s);
  var reference = 0u;
  for (var r = 0u; r < s.run_count; r++) {
    let run = s.runs + kRunWords * r;
    let count = plan[run + 1u];
    let owner = s.first_stream + plan[run + 2u];
    let start = plan[run + 3u];
    let forward = plan[run + 4u] != 0u;
    let length = state(owner, kWalkLength);
    for (var k = lane; k < count; k += kLanes) {
      let place = select(start - k, start + k, forward);
      let number = walks[streams[owner].walk + min(place, max(length, 1u) - 1u)];
      if (place >= length || number == kNone) { fail(i); }
      store(references, reference + k, number);
    }
    reference += count;
  }
  for (var p = s.repeat_count + lane; p < s.pair_count; p += kLanes) {
    let owner = s.first_stream + plan[s.pairs + kPairWords * p + 1u];
    let rank = plan[s.pairs + kPairWords * p + 2u];
    let of_owner = streams[owner];
    if (rank >= of_owner.point_count - of_owner.reference_count) { fail(i); }
    store(references, reference + p, of_owner.first_point + rank);
  }
}
`;
