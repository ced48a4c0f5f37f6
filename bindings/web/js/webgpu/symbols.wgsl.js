// Symbols to corrections (src/core/symbols.h). One thread for each attribute of a stream.
export const symbols = /* wgsl */ `
@compute @workgroup_size(kStreamsPerGroup)
fn decode_symbols(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + id.y];
  if (a.coding == kCodingRaw) { return; }
  let head = head_of(a);
  let out = corrections_of(a);
  let count = load(head, kCount);
  let total = count * a.value_components;
  let kind = load(head, kKind);
  let at = load(head, kAt);
  if (kind == kKindRaw) {
    var sequence = symbols_of(a);
    for (var k = 0u; k < total; k++) { store(out, k, next_symbol(&sequence)); }
  } else if (kind == kKindTagged) {
    var bit = 0u;
    for (var k = 0u; k < count; k++) {
      let width = load(out, total - count + k);
      for (var c = 0u; c < a.value_components; c++) {
        let value = bits_at(at, bit, s.end);
        store(out, k * a.value_components + c, select(value & ((1u << (width & 31u)) - 1u), value, width == 32u));
        bit += width;
      }
    }
  } else {
    let width = load(head, kSize);
    for (var k = 0u; k < total; k++) {
      var value = 0u;
      for (var b = 0u; b < width; b++) { value |= byte_at(at + k * width + b) << (8u * b); }
      store(out, k, value);
    }
  }
}
`;
