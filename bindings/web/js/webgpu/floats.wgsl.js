// Floating-point numbers of 32 bits in integers, each rounded as IEEE 754 says. WGSL lets devices fuse and reorder operations, divide
// with errors, and drop subnormal numbers; so all that must be equal on each device is computed here. A number is its bits.
export const floats = /* wgsl */ `
fn is_finite(a: u32) -> bool { return (a & 0x7f800000u) != 0x7f800000u; }
fn negate(a: u32) -> u32 { return a ^ 0x80000000u; }
fn is_negative(a: u32) -> bool { return a > 0x80000000u; }  // not -0

// mantissa times 2^exponent. The lowest bit of the mantissa is set if the number is above it, and not a whole multiple.
fn rounded(sign: u32, exponent: i32, mantissa: u32) -> u32 {
  if (mantissa == 0u) { return sign; }
  let zeros = countLeadingZeros(mantissa);
  var m = mantissa << zeros;
  var biased = exponent - i32(zeros) + 31 + 127;
  if (biased >= 255) { return sign | 0x7f800000u; }
  if (biased <= 0) {
    // Subnormal: the exponent is that of the smallest normal number.
    let shift = u32(1 - biased);
    if (shift > 31u) { return sign; }
    m = (m >> shift) | select(0u, 1u, (m & ((1u << shift) - 1u)) != 0u);
    biased = 0;
  }
  let rest = m & 0xffu;
  let up = select(0u, 1u, rest > 0x80u || (rest == 0x80u && (m & 0x100u) != 0u));
  return sign | ((u32(biased) << 23u) + (((m >> 8u) & select(0x7fffffu, 0xffffffu, biased == 0)) + up));
}
// The mantissa of a number that is not 0, from 2^23 on, and its exponent.
struct Parts { mantissa: u32, exponent: i32 }
fn parts(a: u32) -> Parts {
  let biased = (a >> 23u) & 0xffu;
  let fraction = a & 0x7fffffu;
  if (biased > 0u) { return Parts(fraction | 0x800000u, i32(biased) - 150); }
  let shift = countLeadingZeros(fraction) - 8u;
  return Parts(fraction << shift, -149 - i32(shift));
}
fn is_zero(a: u32) -> bool { return (a << 1u) == 0u; }

fn float_of(value: i32) -> u32 { return rounded(select(0u, 0x80000000u, value < 0), 0, u32(abs(value))); }
fn multiply(a: u32, b: u32) -> u32 {
  let sign = (a ^ b) & 0x80000000u;
  if (is_zero(a) || is_zero(b)) { return sign; }
  let x = parts(a);
  let y = parts(b);
  // 48 bits, of which the lower 16 are only looked at.
  let low = (x.mantissa & 0xffffu) * (y.mantissa & 0xffffu);
  let middle = (x.mantissa >> 16u) * (y.mantissa & 0xffffu) + (y.mantissa >> 16u) * (x.mantissa & 0xffffu) + (low >> 16u);
  let high = (x.mantissa >> 16u) * (y.mantissa >> 16u);
  return rounded(sign, x.exponent + y.exponent + 16, ((high << 16u) + middle) | select(0u, 1u, (low & 0xffffu) != 0u));
}
fn add(a: u32, b: u32) -> u32 {
  if (is_zero(a)) { return select(b, a & b, is_zero(b)); }
  if (is_zero(b) || !is_finite(a)) { return a; }
  let a_first = (a << 1u) >= (b << 1u);
  let larger = select(b, a, a_first);
  let smaller = select(a, b, a_first);
  let x = parts(larger);
  let y = parts(smaller);
  let shift = u32(x.exponent - y.exponent);
  var m = y.mantissa << 7u;
  m = select((m >> (shift & 31u)) | select(0u, 1u, (m & ((1u << (shift & 31u)) - 1u)) != 0u), 1u, shift > 31u);
  let sign = larger & 0x80000000u;
  if (((a ^ b) & 0x80000000u) == 0u) { return rounded(sign, x.exponent - 7, (x.mantissa << 7u) + m); }
  let difference = (x.mantissa << 7u) - m;
  return select(rounded(sign, x.exponent - 7, difference), 0u, difference == 0u);
}
fn divide(a: u32, b: u32) -> u32 {
  let sign = (a ^ b) & 0x80000000u;
  if (is_zero(a)) { return sign; }
  let x = parts(a);
  let y = parts(b);
  var rest = x.mantissa;
  var quotient = 0u;
  for (var k = 0u; k < 32u; k++) {
    quotient <<= 1u;
    if (rest >= y.mantissa) {
      rest -= y.mantissa;
      quotient |= 1u;
    }
    rest <<= 1u;
  }
  return rounded(sign, x.exponent - y.exponent - 31, quotient | select(0u, 1u, rest != 0u));
}
// Of a number that is not negative.
fn square_root(a: u32) -> u32 {
  if (is_zero(a)) { return a; }
  let x = parts(a);
  let odd = u32(x.exponent & 1);
  let square = x.mantissa << odd;  // 25 bits, followed by zeros
  var root = 0u;
  var rest = 0u;
  for (var k = 0u; k < 27u; k++) {
    rest = (rest << 2u) | select(0u, (square >> (24u - 2u * min(k, 12u))) & 3u, k < 13u);
    root <<= 1u;
    if (rest > 2u * root) {
      rest -= 2u * root + 1u;
      root |= 1u;
    }
  }
  return rounded(0u, (x.exponent - i32(odd)) / 2 - 14, root | select(0u, 1u, rest != 0u));
}
`;
