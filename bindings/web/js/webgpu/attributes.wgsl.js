// What a stream says of its attributes (src/core/attribute_decoder.h, integer_decoder.h, prediction_data.h): where their symbols are,
// and how corrections become values. One thread reads a stream. It decodes symbols only where nothing else says where they end: the
// tags of tagged ones.
export const attribute_views = /* wgsl */ `
fn stored_bits(head: View, at: u32) -> Bits { return Bits(load(head, at), load(head, at + 1u), load(head, at + 2u), load(head, at + 3u)); }

fn head_of(a: Attribute) -> View { return View(a.head, kHeadWords); }
fn corrections_of(a: Attribute) -> View { return View(a.corrections, a.value_room); }
fn values_of(a: Attribute) -> View { return View(a.values, a.value_room); }
`;
export const attributes = /* wgsl */ `
// Reads bytes in order. Bytes past the end are 0.
var<private> reader_at: u32;
var<private> reader_end: u32;
var<private> is_truncated: bool;
fn u8() -> u32 {
  if (reader_at >= reader_end) {
    is_truncated = true;
    return 0u;
  }
  reader_at += 1u;
  return byte_at(reader_at - 1u);
}
fn u32_() -> u32 {
  let a = u8();
  let b = u8();
  let c = u8();
  return a | (b << 8u) | (c << 16u) | (u8() << 24u);
}
// A number of at most "most_bytes" bytes, of which 32 bits are taken. Longer lengths are longer than any stream.
fn varint(most_bytes: u32) -> u32 {
  var value = 0u;
  var above = 0u;
  for (var i = 0u; i < most_bytes; i++) {
    let byte = u8();
    if (i < 5u) { value |= (byte & 0x7fu) << (7u * i); }
    if (i == 4u) { above |= (byte & 0x7fu) >> 4u; }
    if (i > 4u) { above |= byte & 0x7fu; }
    if (byte < 0x80u) {
      if (most_bytes > 5u && above != 0u) { is_truncated = true; }
      return value;
    }
  }
  is_truncated = true;
  return 0u;
}
fn skip(count: u32) {
  if (count > reader_end - reader_at) {
    is_truncated = true;
    reader_at = reader_end;
  } else {
    reader_at += count;
  }
}
// A block of bits of one probability, whose words go to a head from "to" on. Returns false if it is broken.
fn read_bits(head: View, to: u32) -> bool {
  const kBase = 4096u;
  let probability = (256u - u8()) & 0xffu;
  let length = varint(5u);
  let at = reader_at;
  skip(length);
  if (is_truncated || length == 0u) { return false; }
  var state = 0u;
  let count = 1u + (byte_at(at + length - 1u) >> 6u);
  if (count > 3u || count > length) { return false; }
  for (var k = 1u; k <= count; k++) { state = (state << 8u) | byte_at(at + length - k); }
  state = (state & ((1u << (8u * count - 2u)) - 1u)) + kBase;
  store(head, to, probability);
  store(head, to + 1u, at);
  store(head, to + 2u, length - count);
  store(head, to + 3u, state);
  return state < 256u * kBase;
}

fn symbols_of(a: Attribute) -> Symbols {
  let head = head_of(a);
  return Symbols(View(a.slots, 2u * load(head, kSlotCount) + 2u), View(a.buckets, 1u << a.bucket_bits),
    load(head, kPrecision) - a.bucket_bits, load(head, kPrecision), load(head, kAt), load(head, kSize), load(head, kRansState));
}

@compute @workgroup_size(kStreamsPerGroup)
fn read_attributes(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i)) { return; }
  reader_at = s.body;
  reader_end = s.end;
  is_truncated = false;
  for (var g = 0u; g < s.group_count; g++) {
    let group = group_of(s, g);
    let count = table_of(s, i, group).count;
    for (var k = group.first; k < group.first + group.count; k++) {
      if (!read_attribute(s, attributes[s.attributes + k], count)) {
        fail(i);
        return;
      }
    }
    for (var k = group.first; k < group.first + group.count; k++) {
      if (!read_transform(attributes[s.attributes + k])) {
        fail(i);
        return;
      }
    }
  }
}

fn read_attribute(s: Stream, a: Attribute, count: u32) -> bool {
  let head = head_of(a);
  store(head, kCount, count);
  if (a.coding == kCodingRaw) {
    store(head, kAt, reader_at);
    skip(count * a.components * a.type_bytes);
    return !is_truncated;
  }
  var scheme = u8();
  var transform = kTransformWrap;
  if (scheme == kStoredNone) {
    scheme = kSchemeNone;
  } else {
    transform = u8();
    let is_wrap = a.coding != kCodingNormal;
    // Broken streams mean what they mean to libdraco, which is left to WebAssembly.
    if (is_wrap != (transform == kTransformWrap) || transform < kTransformWrap || transform > kTransformCanonicalized) { return false; }
    if (scheme != kSchemeDifference && !((scheme == kSchemeParallelogram || scheme == kSchemeParallelograms) && is_wrap)) {
      if (scheme != select(kSchemeGeometricNormal, kSchemeTexCoords, is_wrap) || a.position == 0u || a.value_components != 2u) {
        return false;
      }
      let position = attributes[s.attributes + a.position - 1u];
      if (position.coding == kCodingRaw || position.value_components != 3u) { return false; }
    }
  }
  store(head, kScheme, scheme);
  store(head, kTransform, transform);
  if (!read_symbols(a, count)) { return false; }
  if (scheme == kSchemeNone) { return true; }
  for (var n = 0u; n < 4u && scheme == kSchemeParallelograms; n++) {
    let flags = varint(5u);
    store(head, kCreases + 5u * n, flags);
    if (is_truncated || flags > 3u * s.face_count || (flags > 0u && !read_bits(head, kCreases + 5u * n + 1u))) { return false; }
  }
  if (scheme == kSchemeTexCoords) {
    let flags = u32_();
    store(head, kOrientations, flags);
    if (flags > 3u * s.face_count || !read_bits(head, kFlips)) { return false; }
  }
  if (transform == kTransformWrap) {
    let low = i32(u32_());
    let high = i32(u32_());
    let difference = u32(high) - u32(low);
    store(head, kLow, u32(low));
    store(head, kHigh, u32(high));
    if (is_truncated || high < low || difference >= 0x7fffffffu) { return false; }
  } else {
    let most = u32_();
    if (transform == kTransformCanonicalized) { _ = u32_(); }
    var bits = 0u;
    while (bits < 31u && (1u << bits) - 1u < most) { bits += 1u; }
    if (is_truncated || bits < 2u || bits > 30u || (most & 1u) == 0u) { return false; }
    store(head, kHigh, (1u << bits) - 1u);
    if (scheme == kSchemeGeometricNormal && !read_bits(head, kFlips)) { return false; }
  }
  return !is_truncated;
}

// Finds the symbols of an attribute, and reads their table.
fn read_symbols(a: Attribute, count: u32) -> bool {
  let head = head_of(a);
  let total = count * a.value_components;
  if (u8() == 0u) {
    let width = u8();
    store(head, kKind, kKindPlain);
    store(head, kSize, width);
    store(head, kAt, reader_at);
    if (is_truncated || width > 4u) { return false; }
    skip(total * width);
    return !is_truncated;
  }
  let is_raw = u8();
  if (is_truncated || is_raw > 1u) { return false; }
  store(head, kKind, select(kKindTagged, kKindRaw, is_raw == 1u));
  var symbol_bits = 5u;
  if (is_raw == 1u) { symbol_bits = u8(); }
  if (symbol_bits == 0u || symbol_bits > 18u) { return false; }
  let precision_bits = clamp(3u * symbol_bits / 2u, 12u, 20u);
  store(head, kPrecision, precision_bits);
  if (!read_table(a, precision_bits)) { return false; }
  let size = varint(10u);
  let at = reader_at;
  skip(size);
  if (is_truncated || size == 0u) { return false; }
  let state_bytes = 1u + (byte_at(at + size - 1u) >> 6u);
  if (state_bytes > size) { return false; }
  var value = 0u;
  for (var k = 1u; k <= state_bytes; k++) { value = (value << 8u) | byte_at(at + size - k); }
  value = (value & ((1u << (8u * state_bytes - 2u)) - 1u)) + (4u << precision_bits);
  if (value >= (4u << precision_bits) * 256u) { return false; }
  store(head, kAt, at);
  store(head, kSize, size - state_bytes);
  store(head, kRansState, value);
  if (is_raw == 1u) { return true; }

  // Tags are where the last values will be, and are read before these are written.
  let corrections = corrections_of(a);
  var symbols = symbols_of(a);
  var bits = 0u;
  for (var k = 0u; k < count; k++) {
    let tag = next_symbol(&symbols);
    if (tag > 32u) { return false; }
    store(corrections, total - count + k, tag);
    bits += tag * a.value_components;
  }
  store(head, kAt, reader_at);
  skip((bits + 7u) / 8u);
  return !is_truncated;
}

fn read_table(a: Attribute, precision_bits: u32) -> bool {
  let sum_of_all = 1u << precision_bits;
  let symbol_count = varint(5u);
  if (is_truncated || symbol_count == 0u || symbol_count / 64u > reader_end - reader_at || symbol_count > (1u << 24u)) { return false; }
  let slots = View(a.slots, 2u * a.slot_room + 2u);
  var sum = 0u;
  var slot_count = 0u;
  for (var symbol = 0u; symbol < symbol_count && !is_truncated; symbol++) {
    let byte = u8();
    let extra_bytes = byte & 3u;
    if (extra_bytes == 3u) {  // this and some more do not occur
      symbol += byte >> 2u;
      if (symbol >= symbol_count) { return false; }
      continue;
    }
    var probability = byte >> 2u;
    for (var k = 0u; k < extra_bytes; k++) { probability |= u8() << (8u * k + 6u); }
    if (probability == 0u) { continue; }
    // An encoder writes only symbols that occur.
    if (probability > sum_of_all - sum || slot_count == a.slot_room) { return false; }
    store(slots, 2u * slot_count, symbol);
    store(slots, 2u * slot_count + 1u, sum);
    slot_count += 1u;
    sum += probability;
  }
  if (is_truncated || sum != sum_of_all) { return false; }
  store(slots, 2u * slot_count, 0u);
  store(slots, 2u * slot_count + 1u, sum);
  store(head_of(a), kSlotCount, slot_count);
  let shift = precision_bits - a.bucket_bits;
  var filled = 0u;
  for (var slot = 0u; slot < slot_count; slot++) {
    let end = load(slots, 2u * slot + 3u);
    for (; (filled << shift) < end && filled < (1u << a.bucket_bits); filled++) { memory[a.buckets + filled] = slot; }
  }
  return true;
}

// The numbers that turn integers into values of the attribute's type.
fn read_transform(a: Attribute) -> bool {
  let head = head_of(a);
  if (a.coding == kCodingQuantized) {
    store(head, kOrigin, reader_at);
    skip(4u * a.components);
    let range = u32_();
    let bits = u8();
    // Ranges and origins that are not finite are left to WebAssembly.
    if (is_truncated || bits < 1u || bits > 30u || !is_finite(range)) { return false; }
    for (var k = 0u; k < a.components; k++) { if (!is_finite(origin_of(a, k))) { return false; } }
    store(head, kBits, bits);
    store(head, kStep, divide(range, float_of(i32((1u << bits) - 1u))));
  } else if (a.coding == kCodingNormal) {
    let bits = u8();
    store(head, kBits, bits);
    if (bits < 2u || bits > 30u) { return false; }
    store(head, kStep, divide(0x40000000u, float_of(i32((1u << bits) - 2u))));
  }
  return !is_truncated;
}
// The bits of a float of an attribute's origin.
fn origin_of(a: Attribute, k: u32) -> u32 {
  let at = load(head_of(a), kOrigin) + 4u * k;
  return byte_at(at) | (byte_at(at + 1u) << 8u) | (byte_at(at + 2u) << 16u) | (byte_at(at + 3u) << 24u);
}
`;
