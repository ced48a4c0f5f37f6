#include "encoder/condensing/coded_patch.h"

#include "encoder/fields/symbol_lists.h"
#include "src/container/condensed_head.h"
#include "src/core/stitch_codes.h"

namespace psplit {
namespace {

uint32_t folded(uint32_t difference) {
  return static_cast<uint32_t>(core::fold(static_cast<int32_t>(difference)));
}

// Each component is a correction of the same component of the value before it.
std::vector<uint32_t> raw_differences(const AttributeFields& fields) {
  const uint32_t component_bytes = fields.component_bytes;
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
  constexpr uint32_t kSymbols = core::SymbolContext::kCount;
  if (symbol_contexts == kValenceContexts) return kSymbols * DracoFields::kSymbolLists;
  uint32_t count = 1;
  for (uint32_t i = 0; i < symbol_contexts; ++i) count *= kSymbols;
  return count;
}

std::vector<uint16_t> contexts_of_symbols(const DracoFields& fields, uint32_t symbol_contexts) {
  std::vector<uint16_t> contexts(fields.symbols.size() - 1);
  const auto number = [&](size_t i) -> uint32_t { return core::number_of_clers(fields.symbols[i]); };
  if (symbol_contexts == kValenceContexts) {
    const Expected<std::vector<uint8_t>> lists = lists_of_symbols(fields);
    if (!lists) return {};
    for (size_t i = 0; i < contexts.size(); ++i)
      contexts[i] = static_cast<uint16_t>(core::SymbolContext::kCount * (*lists)[i + 1] + number(i));
    return contexts;
  }
  // The string begins as if E had come before, and with E.
  const uint32_t count = context_count(symbol_contexts);
  uint32_t context = count - 1;
  for (size_t i = 0; i < contexts.size(); ++i) {
    context = (core::SymbolContext::kCount * context + number(i)) % count;
    contexts[i] = static_cast<uint16_t>(context);
  }
  return contexts;
}

CodedValues code_in_draco_order(const AttributeFields& fields) {
  CodedValues coded;
  coded.symbols = fields.skeleton.is_raw() ? raw_differences(fields) : fields.symbols;
  if (fields.grid_size > 0)
    for (uint32_t& symbol : coded.symbols)
      symbol = folded(symbol <= fields.grid_size / 2 ? symbol : symbol - fields.grid_size);
  constexpr uint32_t kFirst = 3;
  coded.table.assign(fields.count, 1);
  std::fill_n(coded.table.begin(), std::min(kFirst, fields.count), uint8_t{0});
  return coded;
}

CreationSymbols::CreationSymbols(const DecodedSource& source, uint32_t attribute, bool backward, bool two,
                                 std::span<const uint32_t> known)
    : attribute_(source.attribute(attribute)) {
  const core::AttributeTable<uint32_t>& table = source.table(attribute);
  const uint32_t count = table.vertex_count, components = attribute_.value_components();
  const size_t size = core::Sequence<uint32_t>::bytes(count) +
                      core::CreatedValues<uint32_t>::bytes(count, 1, components, /*predictors=*/2);
  memory_.reset(new uint8_t[size]);
  core::Arena arena(memory_.get(), size);
  // With a mean, each value has two predictors, whatever is chosen. The memory is enough.
  core::AttributeModel model;
  model.by_creation = model.mean = true;
  model.backward = backward;
  model.two = two;
  core::Sequence<uint32_t> order;
  order.allocate(count, arena);
  created_.allocate(model, table, attribute_, arena);
  const core::View<int32_t> values = source.attribute(attribute).values;
  std::copy_n(values.data(), size_t{count} * core::value_stride(components), attribute_.values.data());
  core::fill(order.rank, core::kNone<uint32_t>);
  for (uint32_t i = 0; i < known.size(); ++i) order.rank[known[i]] = i, order.corner[i] = 0;
  const auto known_count = static_cast<uint32_t>(known.size());
  core::CreationOrder<uint32_t> creation(table.table, known_count, order);
  const auto face_count = static_cast<uint32_t>(table.table.vertex.size() / 4);
  backward ? creation.see_backward(face_count) : creation.see_forward(face_count);
  created_.find_predictors(core::SerialLanes(), model, order, known_count);
}

uint32_t CreationSymbols::symbol(uint32_t i, uint32_t component, bool mean, uint32_t reach) const {
  using Block = core::Components<1>;
  const core::Predictors<uint32_t>* const by = &created_.predictors()[2 * size_t{i}];
  const int32_t* const values = attribute_.values.data() + component;
  const uint32_t stride = core::value_stride(attribute_.value_components());
  const auto number = [&](uint32_t vertex) { return values[size_t{vertex} * stride]; };
  const auto predicted = [&](const core::Predictors<uint32_t>& p) {
    const Block a(number(p.a())), b(number(p.b())), far(number(p.far()));
    return reach == 0 ? core::predicted_by<core::CreationMode::kTwo>(a, b, far, reach)
                      : core::predicted_by<core::CreationMode::kDamped>(a, b, far, reach);
  };
  Block value = predicted(by[0]);
  // A single parallelogram is there twice.
  if (mean || parallelograms(i) > 0) value = value + (predicted(by[1]) - value).shifted(1);
  return folded_difference(number(by[0].value()), value[0]);
}

CodedValues code_by_creation(const DecodedSource& source, uint32_t attribute, core::ValueCoding coding,
                             std::span<const uint32_t> known) {
  const CreationSymbols values(source, attribute, coding.backward, coding.two, known);
  const uint32_t components = source.attribute(attribute).value_components();
  CodedValues coded;
  coded.symbols.reserve(size_t{values.count()} * components);
  coded.table.reserve(values.count());
  for (uint32_t i = 0; i < values.count(); ++i) {
    coded.table.push_back(static_cast<uint8_t>(values.parallelograms(i)));
    for (uint32_t k = 0; k < components; ++k)
      coded.symbols.push_back(values.symbol(i, k, coding.mean, coding.reach));
  }
  return coded;
}

}  // namespace psplit
