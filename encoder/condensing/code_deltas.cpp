#include "encoder/condensing/code_deltas.h"

#include <algorithm>
#include <cmath>

#include "src/core/condensed/deltas.h"

namespace psplit {
namespace {

using core::kDeltaComponents;
using core::kDeltaOne;

// The vertices of the first attribute's table, in the order in which deltas are coded.
class DeltaOrder {
 public:
  explicit DeltaOrder(const DecodedSource& source) : table_(source.table(0)) {
    const uint32_t count = table_.vertex_count;
    memory_.reset(new uint8_t[core::Sequence<uint32_t>::bytes(count)]);
    core::Arena arena(memory_.get(), core::Sequence<uint32_t>::bytes(count));
    order_.allocate(count, arena);
    core::fill(order_.rank, core::kNone<uint32_t>);
    core::CreationOrder<uint32_t>(table_.table, 0, order_)
        .see_backward(static_cast<uint32_t>(table_.table.vertex.size() / 4));
  }
  const core::Sequence<uint32_t>& sequence() const { return order_; }
  uint32_t vertex(uint32_t place) const { return table_.table.vertex[order_.corner[place]]; }
  core::DeltaSourceSearch<uint32_t> search(const DecodedSource& source, bool has_places) const {
    return {table_.table, order_, core::DeltaPlaces::of(source.attribute(0), has_places)};
  }

 private:
  const core::AttributeTable<uint32_t>& table_;
  std::unique_ptr<uint8_t[]> memory_;
  core::Sequence<uint32_t> order_;
};

int32_t delta_of(const DecodedSource& source, const core::DeltaModel& model, uint32_t vertex,
                 uint32_t component) {
  return core::wrapping_sub(source.number(model.attribute, vertex, component), model.zero[component]);
}

bool is_some(const DecodedSource& source, const core::DeltaModel& model, uint32_t vertex) {
  bool result = false;
  for (uint32_t k = 0; k < kDeltaComponents; ++k) result |= delta_of(source, model, vertex, k) != 0;
  return result;
}

// Where 0 is on the grid of an attribute, if it is on it.
bool find_zero(const core::Attribute<uint32_t>& attribute, int32_t (&zero)[kDeltaComponents]) {
  if (attribute.coding != core::Coding::kQuantized) return attribute.coding == core::Coding::kInteger;
  const double step = attribute.step();
  if (!(step > 0)) return false;
  for (uint32_t k = 0; k < kDeltaComponents; ++k) {
    float origin;
    std::memcpy(&origin, attribute.origin + sizeof origin * k, sizeof origin);
    const double place = -double{origin} / step;
    constexpr double kMost = 1 << 30;
    if (!(std::abs(place) < kMost)) return false;
    zero[k] = static_cast<int32_t>(std::floor(place + 0.5));
  }
  return true;
}

// About the bits of a correction, times 8.
uint32_t cost_of_correction(int64_t correction) {
  const uint64_t size = correction < 0 ? static_cast<uint64_t>(-correction) : static_cast<uint64_t>(correction);
  if (size == 0) return 4;
  const auto top = static_cast<uint32_t>(std::bit_width(size)) - 1;
  const auto next = static_cast<uint32_t>((size << 3 >> top) & 7);  // three bits below the highest one
  return 16 + 8 * top + next;
}

// A sum of products with weights or factors, which are in 1 / 64, as a decoder rounds it.
int64_t rounded(int64_t sum) { return (sum + kDeltaOne / 2) >> core::kDeltaBits; }

// Writes flags and corrections.
class DeltaWriter {
 public:
  DeltaWriter(std::span<const uint32_t> flags, std::span<const int32_t> deltas, CodedDeltas& out)
      : truth_(flags), deltas_(deltas), out_(out) {
    begin_run();
  }
  void end() { out_.flags[run_at_] = CodedDeltas::kRun + run_; }

  void begin_vertex(uint32_t place, size_t words, size_t rows) {
    flags_ = truth_.data() + place * words;
    row_deltas_ = deltas_.data() + place * rows * kDeltaComponents;
  }
  uint32_t flags(uint32_t sure, uint32_t expected, uint32_t mixed) {
    const uint32_t flags = *flags_++;
    for (; sure != 0; sure &= sure - 1) {
      const uint32_t bit = sure & (0u - sure);
      if (((flags ^ expected) & bit) == 0) {
        ++run_;
        continue;
      }
      end();
      begin_run();
    }
    for (; mixed != 0; mixed &= mixed - 1) out_.flags.push_back((flags & mixed & (0u - mixed)) != 0 ? 1 : 0);
    return flags;
  }
  void begin_corrections(core::View<const core::DeltaItem>, core::View<core::DeltaValues>) const {}
  // Stores what an expected delta is off by.
  core::DeltaBlock correction(const core::DeltaItem& item, const core::DeltaValues&,
                              core::DeltaBlock expected) const {
    core::DeltaValues predicted, corrections = {};
    expected.store(predicted.of);
    for (uint32_t k = 0; k < kDeltaComponents; ++k) {
      const int32_t delta = row_deltas_[item.row * kDeltaComponents + k];
      out_.corrections[k].push_back(
          {folded_difference(delta, predicted.of[k]), core::delta_level(item.means[k])});
      corrections.of[k] = core::wrapping_sub(delta, predicted.of[k]);
    }
    return core::DeltaBlock(corrections.of);
  }

 private:
  void begin_run() {
    run_at_ = out_.flags.size();
    out_.flags.push_back(0);
    run_ = 0;
  }

  std::span<const uint32_t> truth_;  // by place, then by word of rows
  std::span<const int32_t> deltas_;  // by place, row and component
  const uint32_t* flags_ = nullptr;
  const int32_t* row_deltas_ = nullptr;
  CodedDeltas& out_;
  size_t run_at_ = 0;
  uint32_t run_ = 0;
};

}  // namespace

std::vector<core::DeltaModel> possible_deltas(const DecodedSource& source, const DracoFields& fields) {
  constexpr uint8_t kGeneric = 4;
  std::vector<core::DeltaModel> found;
  for (uint32_t i = 1; i < fields.attributes.size(); ++i) {
    const core::Attribute<uint32_t>& attribute = source.attribute(i);
    if (attribute.semantic != kGeneric || attribute.value_components() != kDeltaComponents ||
        attribute.group != source.attribute(0).group || !fields.attributes[i].skeleton.allows_creation_order())
      continue;
    core::DeltaModel model;
    model.attribute = static_cast<uint16_t>(i);
    if (find_zero(attribute, model.zero)) found.push_back(model);
  }
  return found;
}

void DeltaSample::add(const DecodedSource& source, std::span<const core::DeltaModel> deltas, bool has_places,
                      uint32_t every) {
  delta_count_ = deltas.size();
  const DeltaOrder order(source);
  const core::DeltaSourceSearch<uint32_t> search = order.search(source, has_places);
  const size_t count = is_some_.size() + (order.sequence().count + every - 1) / every * deltas.size();
  is_some_.reserve(count);
  for (auto& by_component : corrections_)
    for (std::vector<int32_t>& corrections : by_component) corrections.reserve(count);
  for (uint32_t i = 0; i < order.sequence().count; i += every) {
    const core::DeltaSources<uint32_t> sources = search.find(i);
    const core::DeltaWeights even = core::even_delta_weights(sources.count);
    for (const core::DeltaModel& model : deltas) {
      is_some_.push_back(is_some(source, model, order.vertex(i)));
      for (uint32_t k = 0; k < kDeltaComponents; ++k) {
        // Clamps the sums: a reference does not help with deltas that are larger.
        const auto narrow = [](int64_t sum) {
          constexpr int64_t kMost = 1 << 15;
          return static_cast<int32_t>(std::clamp(rounded(sum), -kMost, kMost));
        };
        const int64_t delta = delta_of(source, model, order.vertex(i), k);
        int64_t affine_sum = kDeltaOne * delta, even_sum = affine_sum;
        for (uint32_t n = 0; n < sources.count; ++n) {
          const int64_t at = delta_of(source, model, order.vertex(sources.place[n]), k);
          affine_sum -= sources.weights.of[n] * at;
          even_sum -= even.of[n] * at;
        }
        corrections_[false][k].push_back(narrow(affine_sum));
        corrections_[true][k].push_back(narrow(even_sum));
      }
    }
  }
}

void DeltaSample::append(DeltaSample&& other) {
  delta_count_ = std::max(delta_count_, other.delta_count_);
  const auto append_to = [](auto& all, auto&& more) {
    if (all.empty())
      all = std::move(more);
    else
      all.insert(all.end(), more.begin(), more.end());
  };
  for (size_t is_even = 0; is_even < corrections_.size(); ++is_even)
    for (uint32_t k = 0; k < kDeltaComponents; ++k)
      append_to(corrections_[is_even][k], std::move(other.corrections_[is_even][k]));
  append_to(is_some_, std::move(other.is_some_));
  other = {};
}

uint64_t DeltaSample::cost_of(size_t delta, bool is_even) const {
  uint64_t cost = 0;
  for_each_correction(delta, is_even,
                      [&](const int32_t* corrections) { cost += cost_of_correction(corrections[delta]); });
  return cost;
}

void DeltaSample::choose(std::span<core::DeltaModel> deltas, const ThreadPool& pool) const {
  if (is_some_.empty()) return;
  pool.for_each(deltas.size(), [&](size_t n) {
    deltas[n].is_even = cost_of(n, true) < cost_of(n, false);
    choose_reference(deltas, n);
  });
}

// Least squares find the factor of each earlier attribute, where small corrections count as much as large ones.
// Of the two that leave least, the one that costs less is the reference.
void DeltaSample::choose_reference(std::span<core::DeltaModel> deltas, size_t delta) const {
  core::DeltaModel& model = deltas[delta];
  const bool is_even = model.is_even;
  // The sums of products with each earlier attribute, and of its squares. They are integers below 2^53.
  std::vector<double> products(delta), squares(delta);
  for_each_correction(delta, is_even, [&](const int32_t* corrections) {
    constexpr int32_t kWeight = 4096, kSmall = 4;
    const int32_t weight = kWeight / (kSmall + std::abs(corrections[delta]));
    const double weighted = weight * corrections[delta], of_square = weight;
    for (size_t r = 0; r < delta; ++r) {
      const double of_reference = corrections[r];
      products[r] += weighted * of_reference;
      squares[r] += of_square * of_reference * of_reference;
    }
  });
  struct Choice {
    double gain = 0;
    size_t reference = 0;
    int32_t factor = 0;
  };
  std::array<Choice, 2> best{};
  for (size_t r = 0; r < delta; ++r) {
    if (squares[r] == 0) continue;
    const double factor = products[r] / squares[r];
    constexpr double kMostFactor = 512;
    const Choice choice{
        factor * products[r], r,
        static_cast<int32_t>(std::floor(std::clamp(kDeltaOne * factor, -kMostFactor, kMostFactor) + 0.5))};
    if (choice.gain > best[0].gain)
      best = {choice, best[0]};
    else if (choice.gain > best[1].gain)
      best[1] = choice;
  }
  constexpr uint64_t kHeadCost = 8 * 16;  // of a reference in the head
  uint64_t least = cost_of(delta, is_even);
  for (const Choice& choice : best) {
    if (choice.factor == 0) continue;
    uint64_t cost = kHeadCost;
    for_each_correction(delta, is_even, [&](const int32_t* corrections) {
      cost += cost_of_correction(corrections[delta] -
                                 rounded(int64_t{choice.factor} * corrections[choice.reference]));
    });
    if (cost >= least) continue;
    least = cost;
    model.reference = static_cast<uint16_t>(choice.reference);
    model.factor = static_cast<int16_t>(choice.factor);
  }
}

CodedDeltas code_deltas(const DecodedSource& source, std::span<const core::DeltaModel> deltas,
                        bool has_places) {
  CodedDeltas coded;
  const DeltaOrder order(source);
  const uint32_t vertex_count = order.sequence().count;
  std::vector<const core::DeltaModel*> models;  // of the rows
  std::vector<core::DeltaRow> rows;
  std::vector<uint16_t> row_of;
  for (const core::DeltaModel& model : deltas) {
    bool is_row = false;
    for (uint32_t v = 0; v < vertex_count && !is_row; ++v) is_row = is_some(source, model, v);
    coded.is_row.push_back(is_row);
    row_of.push_back(is_row ? static_cast<uint16_t>(rows.size()) : core::DeltaRow::kNone);
    if (!is_row) continue;
    models.push_back(&model);
    core::DeltaRow& row = rows.emplace_back();
    row.factor = model.factor;
    row.is_even = model.is_even;
    if (model.reference != core::DeltaModel::kNoReference) row.reference = row_of[model.reference];
  }
  if (rows.empty()) return coded;

  const size_t words = (rows.size() + 31) / 32;
  std::vector<uint32_t> flags(words * vertex_count);
  std::vector<int32_t> values(rows.size() * kDeltaComponents * vertex_count);
  for (uint32_t i = 0; i < vertex_count; ++i)
    for (size_t r = 0; r < rows.size(); ++r) {
      bool some = false;
      for (uint32_t k = 0; k < kDeltaComponents; ++k) {
        const int32_t delta = delta_of(source, *models[r], order.vertex(i), k);
        values[(i * rows.size() + r) * kDeltaComponents + k] = delta;
        some |= delta != 0;
      }
      flags[i * words + r / 32] |= uint32_t{some} << r % 32;
    }
  const size_t size = core::DeltaCoding<uint32_t>::bytes(vertex_count, rows.size());
  const std::unique_ptr<uint8_t[]> memory(new uint8_t[size]);
  core::Arena arena(memory.get(), size);
  core::DeltaCoding<uint32_t> coding;
  coding.allocate(vertex_count, {rows.data(), rows.size()}, arena);
  const core::DeltaSourceSearch<uint32_t> search = order.search(source, has_places);
  DeltaWriter writer(flags, values, coded);
  for (uint32_t i = 0; i < vertex_count; ++i) {
    coding.sources()[i] = search.find(i);
    writer.begin_vertex(i, words, rows.size());
    coding.code(i, writer, [](const core::DeltaRow&, core::DeltaBlock) {});
  }
  writer.end();
  return coded;
}

// Joins levels beside each other in the groups that take the fewest bits, by dynamic programming.
DeltaTables delta_tables(const DeltaCounts& counts) {
  constexpr uint32_t kLevels = core::DeltaTables::kLevels;
  DeltaTables tables;
  tables.some = fitting_probability(counts.some[0], counts.some[1]);
  tables.runs = fitting_frequencies(counts.runs);
  const auto bits_of = [](const TokenCounts& of) {
    const std::vector<uint16_t> table = fitting_frequencies(of);
    BitStringWriter written;
    core::NumberKind used = used_kind();
    write_token_table(table, used, written);
    return token_bits(of, table) + static_cast<double>(written.bit_count());
  };
  // By number of tables, and by the level that they end before: the fewest bits, and where the last one begins.
  struct Best {
    double bits = -1;
    uint32_t begin = 0;
  };
  std::array<std::array<Best, kLevels + 1>, kMostDeltaTables + 1> best{};
  best[0][0].bits = 0;
  for (uint32_t begin = 0; begin < kLevels; ++begin) {
    TokenCounts sum{};
    for (uint32_t end = begin + 1; end <= kLevels; ++end) {
      sum += counts.corrections[end - 1];
      if (std::ranges::all_of(sum, [](uint64_t count) { return count == 0; })) continue;
      const double bits = bits_of(sum);
      for (uint32_t count = 0; count < kMostDeltaTables; ++count) {
        const double before = best[count][begin].bits;
        Best& to = best[count + 1][end];
        if (before >= 0 && (to.bits < 0 || before + bits < to.bits)) to = {before + bits, begin};
      }
    }
  }
  uint32_t count = 0;
  for (uint32_t n = 1; n <= kMostDeltaTables; ++n)
    if (best[n][kLevels].bits >= 0 && (count == 0 || best[n][kLevels].bits < best[count][kLevels].bits))
      count = n;
  for (uint32_t end = kLevels; count > 0; --count) {
    const uint32_t begin = best[count][end].begin;
    TokenCounts sum{};
    for (uint32_t level = begin; level < end; ++level) sum += counts.corrections[level];
    tables.begins |= 1u << begin;
    tables.corrections.insert(tables.corrections.begin(), fitting_frequencies(sum));
    end = begin;
  }
  if (tables.corrections.empty()) tables.corrections.emplace_back();
  return tables;
}

double delta_bits(const DeltaCounts& counts, const DeltaTables& tables) {
  const std::array some{static_cast<uint16_t>(core::kSlots - tables.some), static_cast<uint16_t>(tables.some)};
  double bits = coded_bits(counts.some, some) + token_bits(counts.runs, tables.runs);
  size_t table = 0;
  for (uint32_t level = 0; level < core::DeltaTables::kLevels; ++level) {
    if (level > 0 && (tables.begins >> level & 1) != 0) ++table;
    if (table < tables.corrections.size() && !tables.corrections[table].empty())
      bits += token_bits(counts.corrections[level], tables.corrections[table]);
  }
  return bits;
}

}  // namespace psplit
