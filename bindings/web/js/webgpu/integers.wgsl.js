// Integers of 64 bits, as two words, the lower one first. Sums and products wrap around. Signed ones are in two's complement.
export const integers = /* wgsl */ `
alias Wide = vec2u;
const kZero = Wide(0u, 0u);
fn wide(x: i32) -> Wide { return Wide(u32(x), u32(x >> 31u)); }
fn plus(a: Wide, b: Wide) -> Wide {
  let low = a.x + b.x;
  return Wide(low, a.y + b.y + select(0u, 1u, low < a.x));
}
fn minus(a: Wide, b: Wide) -> Wide { return Wide(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x)); }
fn is_below_zero(a: Wide) -> bool { return (a.y >> 31u) != 0u; }
fn magnitude(a: Wide) -> Wide { return select(a, minus(kZero, a), is_below_zero(a)); }
// Of unsigned numbers.
fn is_above(a: Wide, b: Wide) -> bool { return a.y > b.y || (a.y == b.y && a.x > b.x); }

fn words_product(a: u32, b: u32) -> Wide {
  let low = (a & 0xffffu) * (b & 0xffffu);
  let middle = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
  let other = (a & 0xffffu) * (b >> 16u) + (middle & 0xffffu);
  return Wide((other << 16u) | (low & 0xffffu), (a >> 16u) * (b >> 16u) + (middle >> 16u) + (other >> 16u));
}
fn times(a: Wide, b: Wide) -> Wide {
  let low = words_product(a.x, b.x);
  return Wide(low.x, low.y + a.x * b.y + a.y * b.x);
}
fn product(a: i32, b: i32) -> Wide { return times(wide(a), wide(b)); }

fn unsigned_quotient(a: Wide, b: Wide) -> Wide {
  if ((a.y | b.y) == 0u) { return Wide(a.x / b.x, 0u); }
  var rest = kZero;
  var result = kZero;
  for (var k = select(31u, 63u, a.y != 0u) + 1u; k > 0u; k--) {
    let bit = k - 1u;
    let carry = rest.y >> 31u;
    rest = Wide((rest.x << 1u) | ((select(a.x, a.y, bit > 31u) >> (bit & 31u)) & 1u), (rest.y << 1u) | (rest.x >> 31u));
    if (carry != 0u || !is_above(b, rest)) {
      rest = minus(rest, b);
      if (bit > 31u) { result.y |= 1u << (bit & 31u); } else { result.x |= 1u << bit; }
    }
  }
  return result;
}
// Rounds toward zero. b is positive.
fn quotient(a: Wide, b: Wide) -> Wide {
  let result = unsigned_quotient(magnitude(a), b);
  return select(result, minus(kZero, result), is_below_zero(a));
}
// The root of an unsigned number, rounded down.
fn wide_root(a: Wide) -> Wide {
  var rest = kZero;
  var root = 0u;
  for (var k = 32u; k > 0u; k--) {
    let pair = (select(a.x, a.y, k > 16u) >> (2u * ((k - 1u) & 15u))) & 3u;
    rest = Wide((rest.x << 2u) | pair, (rest.y << 2u) | (rest.x >> 30u));
    let trial = Wide((root << 2u) | 1u, root >> 30u);
    root <<= 1u;
    if (!is_above(trial, rest)) {
      rest = minus(rest, trial);
      root |= 1u;
    }
  }
  return Wide(root, 0u);
}
`;
