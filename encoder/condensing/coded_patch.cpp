#include "encoder/condensing/coded_patch.h"

#include "src/condensed/symbol_lists.h"
#include "src/core/stitch_codes.h"

namespace psplit {
namespace {

uint32_t folded(uint32_t difference) {
  return static_cast<uint32_t>(core::fold(static_cast<int32_t>(difference)));
}

// Each component is a correction of the same component of the value before it.
std::vector<uint32_t> raw_differences(const AttributeFields& fields, uint32_t component_bytes) {
  const size_t count = fields.raw.size() / component_bytes;
  std::vector<uint32_t> numbers(count), symbols(count);
  for (size_t i = 0; i < count; ++i)
    for (uint32_t byte = 0; byte < component_bytes; ++byte)
      numbers[i] |= static_cast<uint32_t>(fields.raw[i * component_bytes + byte]) << 8 * byte;
  const uint32_t unused_bits = 32 - 8 * component_bytes;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t before = i < fields.components ? 0 : numbers[i - fields.components];
    const uint32_t difference = (numbers[i] - before) << unused_bits;
    symbols[i] = folded(static_cast<uint32_t>(static_cast<int32_t>(difference) >> unused_bits));
  }
  return symbols;
}

}  // namespace

uint32_t folded_difference(int32_t value, int32_t predicted) {
  return folded(static_cast<uint32_t>(value) - static_cast<uint32_t>(predicted));
}

uint32_t context_count(uint32_t symbol_contexts) {
  if (symbol_contexts == kValenceContexts) return 5 * DracoFields::kSymbolLists;
  uint32_t count = 1;
  for (uint32_t i = 0; i < symbol_contexts; ++i) count *= 5;
  return count;
}

std::vector<uint16_t> contexts_of_symbols(const DracoFields& fields, uint32_t symbol_contexts) {
  std::vector<uint16_t> contexts(fields.symbols.size() - 1);
  const auto number = [&](size_t i) -> uint32_t { return kNumberOfClers[fields.symbols[i]]; };
  if (symbol_contexts == kValenceContexts) {
    const Expected<std::vector<uint8_t>> lists = lists_of_symbols(fields);
    if (!lists) return {};
    for (size_t i = 0; i < contexts.size(); ++i)
      contexts[i] = static_cast<uint16_t>(5 * (*lists)[i + 1] + number(i));
    return contexts;
  }
  // The string begins as if E had come before, and with E.
  const uint32_t count = context_count(symbol_contexts);
  uint32_t context = count - 1;
  for (size_t i = 0; i < contexts.size(); ++i) {
    context = (5 * context + number(i)) % count;
    contexts[i] = static_cast<uint16_t>(context);
  }
  return contexts;
}

CodedValues code_in_draco_order(const AttributeFields& fields, const SkeletonAttribute& attribute) {
  CodedValues coded;
  coded.symbols = attribute.is_raw ? raw_differences(fields, attribute.component_bytes) : fields.symbols;
  if (attribute.grid_max > 0)
    for (uint32_t& symbol : coded.symbols)
      symbol = folded(symbol <= attribute.grid_max / 2 ? symbol : symbol - attribute.grid_max);
  constexpr uint32_t kFirst = 3;
  coded.table.assign(fields.count, 1);
  std::fill_n(coded.table.begin(), std::min(kFirst, fields.count), uint8_t{0});
  return coded;
}

CreatedValues::CreatedValues(const DecodedSource& source, uint32_t attribute, uint32_t components,
                             bool backward, bool two, std::span<const uint32_t> known)
    : components_(components),
      order_(source.table(attribute), source.vertex_count(attribute), backward, known),
      predictor_(source.table(attribute), order_, two),
      values_(order_.vertex.size() * components) {
  size_t at = 0;
  for (const uint32_t vertex : order_.vertex)
    for (uint32_t k = 0; k < components; ++k) values_[at++] = source.number(attribute, vertex, k);
}

uint32_t CreatedValues::symbol(uint32_t i, uint32_t component, const CreationPredictor::Prediction& by,
                               bool mean, uint32_t reach) const {
  const auto value = [&](uint32_t rank) { return values_[size_t{rank} * components_ + component]; };
  const int32_t predicted = predicted_number(by, mean, reach, value);
  return folded_difference(value(i), predicted);
}

CodedValues code_by_creation(const DecodedSource& source, uint32_t attribute, uint32_t components,
                             ValueCoding coding, std::span<const uint32_t> known) {
  const CreatedValues values(source, attribute, components, coding.backward, coding.two, known);
  CodedValues coded;
  coded.symbols.reserve(size_t{values.count()} * components);
  coded.table.reserve(values.count());
  for (uint32_t i = values.first(); i < values.count(); ++i) {
    const CreationPredictor::Prediction by = values.predictors(i);
    coded.table.push_back(static_cast<uint8_t>(by.parallelogram_count));
    for (uint32_t k = 0; k < components; ++k)
      coded.symbols.push_back(values.symbol(i, k, by, coding.mean, coding.reach));
  }
  return coded;
}

}  // namespace psplit
