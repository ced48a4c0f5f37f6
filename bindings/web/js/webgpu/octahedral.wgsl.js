// Unit vectors as two integers (src/core/octahedral.h, which draws the grid).
export const octahedral = /* wgsl */ `
struct OctahedralGrid { most: i32, center: i32, canonicalized: bool }
fn grid_of(head: View) -> OctahedralGrid {
  let most = i32(load(head, kHigh));
  return OctahedralGrid(most, (most - 1) / 2, load(head, kTransform) == kTransformCanonicalized);
}
fn negated(x: i32, is_so: bool) -> i32 { return select(x, -x, is_so); }
// Reflects a place, relative to the center, at the nearest edge of the diamond.
fn mirrored(grid: OctahedralGrid, at: vec2i) -> vec2i {
  let right = at.x > 0 || (at.x == 0 && at.y >= 0);
  let up = at.y > 0 || (at.y == 0 && at.x >= 0);
  let corner = vec2i(negated(grid.center, !right), negated(grid.center, !up));
  let same = right == up;
  return vec2i(negated(2 * at.y - corner.y, same) + corner.x, negated(2 * at.x - corner.x, same) + corner.y) / 2;
}
// The number of quarter turns that bring a place to the bottom left quadrant.
fn quarter_turns(at: vec2i) -> u32 {
  let below = at.y < 0;
  return select(select(select(0u, 1u, below && at.x >= 0), 3u, at.y > 0), select(2u, 1u, below), at.x > 0);
}
// After 0, 1, 2 and 3 quarter turns: (s, t), (t, -s), (-s, -t), (-t, s).
fn turned(at: vec2i, turns: u32) -> vec2i {
  let swapped = select(at, at.yx, (turns & 1u) != 0u);
  return vec2i(negated(swapped.x, turns > 1u), negated(swapped.y, turns == 1u || turns == 2u));
}
// Wraps a coordinate into the square of the octahedron.
fn folded(grid: OctahedralGrid, x: i32) -> i32 { return select(select(x, x + grid.most, x < -grid.center), x - grid.most, x > grid.center); }
fn corrected(grid: OctahedralGrid, predicted: vec2i, correction: vec2i) -> vec2i {
  let place = predicted - grid.center;
  let outside = u32(abs(place.x)) + u32(abs(place.y)) > u32(grid.center);
  let p = select(place, mirrored(grid, place), outside);
  let turns = select(0u, quarter_turns(p), grid.canonicalized);
  let sum = turned(p, turns) + correction;
  let value = turned(vec2i(folded(grid, sum.x), folded(grid, sum.y)), (4u - turns) & 3u);
  return select(value, mirrored(grid, value), outside) + grid.center;
}


// Where the ray along v meets the octahedron, whose corners are "center" from its middle. x and y are known, and on which sides.
fn place_of(grid: OctahedralGrid, along: vec3i) -> vec2i {
  let most = grid.most - 1;
  if (along.x >= 0) { return canonical(grid, along.yz + grid.center); }
  let size = abs(along.yz);
  return canonical(grid, vec2i(select(most - size.y, size.y, along.y < 0), select(most - size.x, size.x, along.z < 0)));
}
// The square's edges are folded onto themselves, and its corners are one place: returns one name for each place.
fn canonical(grid: OctahedralGrid, at: vec2i) -> vec2i {
  let most = grid.most - 1;
  let center = grid.center;
  if ((at.x == 0 && (at.y == 0 || at.y == most)) || (at.x == most && at.y == 0)) { return vec2i(most); }
  if ((at.x == 0 && at.y > center) || (at.x == most && at.y < center)) { return vec2i(at.x, 2 * center - at.y); }
  if ((at.y == most && at.x < center) || (at.y == 0 && at.x > center)) { return vec2i(2 * center - at.x, at.y); }
  return at;
}
`;
