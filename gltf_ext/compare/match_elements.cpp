#include "gltf_ext/compare/match_elements.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

namespace psplit {
namespace {

constexpr size_t kMostDimensions = 5;
constexpr size_t kEnoughFits = 16;  // the best of them is taken
constexpr double kCrowded = 16;     // average number of elements in a cell
constexpr double kFarAway = 1e15;   // in cells

uint64_t mix(uint64_t hash, uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  return hash ^ (hash >> 29);
}

uint64_t bits_of(double value) { return std::bit_cast<uint64_t>(value + 0.0); }  // the same for -0 and 0

// The keys by which elements are looked up.
class Cells {
 public:
  explicit Cells(const ElementPair& pair) : corner_count_(pair.a().corner_count()) {
    for (size_t column = 0; column < pair.column_count(); ++column) {
      const double limit = pair.largest_limit(column);
      if (limit == 0) {
        exact_.push_back(column);
      } else if (!pair.is_direction(column) && std::isfinite(limit)) {
        const size_t components = pair.a().parts()[0].columns[column]->component_count;
        for (size_t c = 0; c < std::min<size_t>(components, 3) && dimensions_.size() < kMostDimensions; ++c)
          dimensions_.push_back({column, c, limit * corner_count_});
      }
    }
  }

  // The neighbourhood of a value is two limits wide. A cell is eight limits wide, so that one cell mostly
  // contains it. If cells hold too many elements, narrow cells, of which several are searched, are faster.
  void narrow() { width_ = 2.5; }

  // The cells of elements that may fit this one; if `own` is true, only its own cell.
  void find(const ElementBag& bag, uint32_t element, bool own, std::vector<uint64_t>& keys) const {
    const ElementBag::Located located = bag.locate(element);
    const ElementPart& part = bag.parts()[located.part];
    uint64_t sum = 0;  // the same for every turn
    for (int corner = 0; corner < corner_count_; ++corner) {
      uint64_t hash = 0;
      for (const size_t column : exact_)
        for (size_t c = 0; c < part.columns[column]->component_count; ++c)
          hash = mix(hash,
                     bits_of(number_at(*part.columns[column], located.points[static_cast<size_t>(corner)], c)));
      sum += mix(hash, 1);
    }
    keys.assign(1, sum);
    for (const Dimension& dimension : dimensions_) {
      double value = 0;
      for (int corner = 0; corner < corner_count_; ++corner)
        value += number_at(*part.columns[dimension.column], located.points[static_cast<size_t>(corner)],
                           dimension.component);
      const double around = own ? 0 : dimension.limit + 1e-14 * std::fabs(value);
      const int64_t low = cell(value - around, dimension), high = cell(value + around, dimension);
      const size_t count = keys.size();
      if (high != low)
        for (size_t i = 0; i < count; ++i) keys.push_back(mix(keys[i], static_cast<uint64_t>(high)));
      for (size_t i = 0; i < count; ++i) keys[i] = mix(keys[i], static_cast<uint64_t>(low));
    }
  }

 private:
  struct Dimension {
    size_t column, component;
    double limit;  // of the sum
  };

  int64_t cell(double value, const Dimension& dimension) const {
    const double number = std::floor(value / (width_ * dimension.limit));
    return std::isnan(number) ? INT64_MIN : static_cast<int64_t>(std::clamp(number, -kFarAway, kFarAway));
  }

  double width_ = 8;  // of a cell, in limits
  int corner_count_;
  std::vector<size_t> exact_;
  std::vector<Dimension> dimensions_;
};

class Matcher {
 public:
  Matcher(const ElementPair& pair, uint64_t spare_tests) : pair_(pair), cells_(pair) {
    const uint32_t count_a = pair.a().size(), count_b = pair.b().size();
    tests_left_ = spare_tests + 300 * (uint64_t{count_a} + count_b);
    partner_of_a_.assign(count_a, kNoElement);
    partner_of_b_.assign(count_b, kNoElement);
    seen_.assign(count_b, 0);
    fill_buckets(count_b);
    double tests = 0;  // expected tests for each element of `b`
    for (const Bucket& bucket : buckets_) tests += std::pow(bucket.end - bucket.begin, 2.0) / count_b;
    if (tests > kCrowded) {
      cells_.narrow();
      fill_buckets(count_b);
    }
    slots_.assign(std::bit_ceil(2 * buckets_.size() + 2), kNoElement);
    for (uint32_t i = 0; i < buckets_.size(); ++i) slots_[slot_of(buckets_[i].key)] = i;
  }

  // Degenerate triangles are matched last: elements that have a partner then keep one.
  bool run() {
    for (const bool degenerate : {false, true}) {
      std::vector<uint32_t> left;
      for (uint32_t a = 0; a < partner_of_a_.size(); ++a)
        if (pair_.a().is_degenerate(a) == degenerate && !take_free(a, degenerate)) left.push_back(a);
      for (const uint32_t a : left) reassign(a);
    }
    return !exhausted();
  }

  bool exhausted() const { return tests_left_ == 0; }
  const std::vector<uint32_t>& partner_of_a() const { return partner_of_a_; }
  const std::vector<uint32_t>& partner_of_b() const { return partner_of_b_; }

  // The best turn of `a` onto `b`, or nothing.
  std::optional<int> best_turn(uint32_t a, uint32_t b) {
    std::optional<int> best;
    double least = 0;
    const ElementBag::Located in_a = pair_.a().locate(a), in_b = pair_.b().locate(b);
    for (int turn = 0; turn < pair_.a().corner_count(); ++turn) {
      const std::optional<double> score = pair_.fit(in_a, in_b, turn);
      if (!score || (best && *score >= least)) continue;
      best = turn;
      least = *score;
    }
    return best;
  }

  // Whether `a` fits exactly one element, in exactly one turn.
  bool has_one_choice(uint32_t a) {
    const ElementBag::Located in_a = pair_.a().locate(a);
    int ways = 0;
    cells_.find(pair_.a(), a, /*own=*/false, keys_);
    for (const uint64_t key : keys_) {
      const Bucket* bucket = find_bucket(key);
      if (bucket == nullptr) continue;
      for (uint32_t i = bucket->begin; i < bucket->end && ways < 2; ++i) {
        if (!count_test()) return false;
        const ElementBag::Located in_b = pair_.b().locate(order_[i]);
        for (int turn = 0; turn < pair_.a().corner_count(); ++turn) ways += pair_.fit(in_a, in_b, turn) ? 1 : 0;
      }
    }
    return ways == 1;
  }

 private:
  // A cell of `b`: order_[begin, end). Those in [begin, free_end) have no partner yet.
  struct Bucket {
    uint64_t key;
    uint32_t begin, end, free_end;
  };

  void fill_buckets(uint32_t count_b) {
    std::vector<std::pair<uint64_t, uint32_t>> keyed(count_b);
    for (uint32_t b = 0; b < count_b; ++b) {
      cells_.find(pair_.b(), b, /*own=*/true, keys_);
      keyed[b] = {keys_[0], b};
    }
    std::ranges::sort(keyed);
    order_.clear();
    buckets_.clear();
    order_.reserve(count_b);
    for (uint32_t i = 0; i < count_b; ++i) {
      if (i == 0 || keyed[i].first != keyed[i - 1].first) buckets_.push_back({keyed[i].first, i, i, i});
      buckets_.back().end = buckets_.back().free_end = i + 1;
      order_.push_back(keyed[i].second);
    }
  }

  // The slot of the key, or the free slot where it would go.
  size_t slot_of(uint64_t key) const {
    size_t slot = mix(key, 0) & (slots_.size() - 1);
    while (slots_[slot] != kNoElement && buckets_[slots_[slot]].key != key)
      slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }
  Bucket* find_bucket(uint64_t key) {
    const uint32_t bucket = slots_[slot_of(key)];
    return bucket == kNoElement ? nullptr : &buckets_[bucket];
  }

  bool count_test() {
    if (tests_left_ > 0) --tests_left_;
    return tests_left_ > 0;
  }

  std::optional<double> fit(const ElementBag::Located& a, uint32_t b) {
    std::optional<double> best;
    const ElementBag::Located in_b = pair_.b().locate(b);
    for (int turn = 0; turn < pair_.a().corner_count(); ++turn) {
      const std::optional<double> score = pair_.fit(a, in_b, turn);
      if (score && (!best || *score < *best)) best = score;
    }
    return best;
  }

  void take(Bucket& bucket, uint32_t place) {
    --bucket.free_end;
    std::swap(order_[place], order_[bucket.free_end]);
  }

  bool take_free(uint32_t a, bool degenerate) {
    const ElementBag::Located in_a = pair_.a().locate(a);
    Bucket* best_bucket = nullptr;
    uint32_t best_place = 0;
    double least = 0;
    size_t fits = 0;
    cells_.find(pair_.a(), a, /*own=*/false, keys_);
    for (const uint64_t key : keys_) {
      Bucket* bucket = find_bucket(key);
      if (bucket == nullptr) continue;
      for (uint32_t i = bucket->begin; i < bucket->free_end && fits < kEnoughFits; ++i) {
        if (!count_test()) return false;
        std::optional<double> score = fit(in_a, order_[i]);
        if (!score) continue;
        ++fits;
        // A last resort: it should stay free for elements of its own kind.
        if (pair_.b().is_degenerate(order_[i]) != degenerate) *score += 1e3;
        if (best_bucket != nullptr && *score >= least) continue;
        best_bucket = bucket;
        best_place = i;
        least = *score;
      }
    }
    if (best_bucket == nullptr) return false;
    const uint32_t b = order_[best_place];
    partner_of_a_[a] = b;
    partner_of_b_[b] = a;
    take(*best_bucket, best_place);
    return true;
  }

  // Finds a shortest augmenting path and applies it. If there is none, the elements that the search saw stay
  // marked: no later path can lead through them.
  void reassign(uint32_t start) {
    std::vector<uint32_t> queue{start}, seen;
    std::unordered_map<uint32_t, uint32_t> wanted_by;  // element of b -> element of a
    for (size_t next = 0; next < queue.size(); ++next) {
      const uint32_t a = queue[next];
      const ElementBag::Located in_a = pair_.a().locate(a);
      cells_.find(pair_.a(), a, /*own=*/false, keys_);
      for (const uint64_t key : keys_) {
        Bucket* bucket = find_bucket(key);
        if (bucket == nullptr) continue;
        for (uint32_t i = bucket->begin; i < bucket->end; ++i) {
          uint32_t b = order_[i];
          if (seen_[b] != 0) continue;
          if (!count_test()) return;
          if (!fit(in_a, b)) continue;
          seen_[b] = 1;
          seen.push_back(b);
          wanted_by[b] = a;
          if (partner_of_b_[b] != kNoElement) {
            queue.push_back(partner_of_b_[b]);
            continue;
          }
          take(*bucket, i);
          for (;;) {
            const uint32_t taker = wanted_by[b];
            const uint32_t left = std::exchange(partner_of_a_[taker], b);
            partner_of_b_[b] = taker;
            if (taker == start) break;
            b = left;
          }
          for (const uint32_t one : seen) seen_[one] = 0;
          return;
        }
      }
    }
  }

  const ElementPair& pair_;
  Cells cells_;
  std::vector<uint32_t> partner_of_a_, partner_of_b_;
  std::vector<uint32_t> order_;  // elements of b, sorted by cell
  std::vector<Bucket> buckets_;
  std::vector<uint32_t> slots_;  // a hash table of indices into buckets_
  std::vector<uint8_t> seen_;    // one flag for each element of b
  std::vector<uint64_t> keys_;
  uint64_t tests_left_ = 0;
};

// A number for each point of each part. Points at the same position have the same number.
std::vector<std::vector<uint32_t>> number_positions(const ElementBag& bag, size_t& count) {
  struct Hash {
    size_t operator()(const std::array<uint64_t, 3>& position) const {
      return mix(mix(mix(0, position[0]), position[1]), position[2]);
    }
  };
  std::unordered_map<std::array<uint64_t, 3>, uint32_t, Hash> numbers;
  std::vector<std::vector<uint32_t>> of_parts;
  for (const ElementPart& part : bag.parts()) {
    const Attribute& position = *part.columns[0];
    std::vector<uint32_t>& of_points = of_parts.emplace_back(position.values.size() / position.stride());
    for (uint32_t point = 0; point < of_points.size(); ++point) {
      std::array<uint64_t, 3> bits{};
      for (size_t c = 0; c < std::min<size_t>(3, position.component_count); ++c)
        bits[c] = bits_of(number_at(position, point, c));
      of_points[point] = numbers.emplace(bits, static_cast<uint32_t>(numbers.size())).first->second;
    }
  }
  count = numbers.size();
  return of_parts;
}

// Finds a position of one bag that is two positions in the other, among pairs that cannot be exchanged.
class TearFinder {
 public:
  TearFinder(const ElementPair& pair, Matcher& matcher) : pair_(pair), matcher_(matcher) {
    numbers_[0] = number_positions(pair.a(), counts_[0]);
    numbers_[1] = number_positions(pair.b(), counts_[1]);
  }

  std::optional<Tear> find(bool in_b) {
    struct First {
      uint32_t position = 0, element = kNoElement;
      std::pair<int32_t, size_t> grid;  // a part without a stated grid counts as a grid
      int corner = 0;
    };
    std::vector<First> firsts(counts_[in_b ? 0 : 1]);
    for (uint32_t a = 0; a < pair_.a().size(); ++a) {
      const uint32_t b = matcher_.partner_of_a()[a];
      const auto turn = b == kNoElement ? std::nullopt : matcher_.best_turn(a, b);
      if (!turn) continue;
      const ElementBag::Located in_a = pair_.a().locate(a), in_b_located = pair_.b().locate(b);
      for (int corner = 0; corner < pair_.a().corner_count(); ++corner) {
        uint32_t whole = numbers_[0][in_a.part][in_a.points[static_cast<size_t>(corner)]];
        const int corner_of_b = (corner + *turn) % pair_.b().corner_count();
        uint32_t torn = numbers_[1][in_b_located.part][in_b_located.points[static_cast<size_t>(corner_of_b)]];
        auto grid = grid_of(pair_.b(), in_b_located.part);
        if (!in_b) {
          std::swap(whole, torn);
          grid = grid_of(pair_.a(), in_a.part);
        }
        First& first = firsts[whole];
        if (first.element == kNoElement) first = First{torn, a, grid, corner};
        // Positions on two grids may differ.
        if (first.position == torn || first.grid != grid) continue;
        if (matcher_.has_one_choice(a) && matcher_.has_one_choice(first.element))
          return Tear{in_b, {first.element, a}, {first.corner, corner}};
      }
    }
    return std::nullopt;
  }

 private:
  static std::pair<int32_t, size_t> grid_of(const ElementBag& bag, size_t part) {
    const int32_t grid = bag.parts()[part].limits[0].grid;
    return {grid, grid < 0 ? part : 0};
  }

  const ElementPair& pair_;
  Matcher& matcher_;
  std::array<std::vector<std::vector<uint32_t>>, 2> numbers_;
  std::array<size_t, 2> counts_{};
};

std::optional<Tear> find_tear(const ElementPair& pair, TearSearch tears, Matcher& matcher) {
  if (tears == TearSearch::kNone || pair.a().corner_count() != 3 || pair.largest_limit(0) == 0)
    return std::nullopt;
  TearFinder finder(pair, matcher);
  if (tears != TearSearch::kInEither) return finder.find(tears == TearSearch::kInB);
  return finder.find(true) ? finder.find(false) : std::nullopt;
}

}  // namespace

Expected<ElementMatch> match_elements(const ElementPair& pair, TearSearch tears, uint64_t spare_tests) {
  Matcher matcher(pair, spare_tests);
  const Status too_many =
      runtime_failure("too many elements are within the tolerance of each other to be told apart");
  if (!matcher.run()) return too_many;
  ElementMatch match;
  match.partner = matcher.partner_of_a();
  match.taken.resize(pair.b().size());
  for (uint32_t b = 0; b < pair.b().size(); ++b) match.taken[b] = matcher.partner_of_b()[b] != kNoElement;
  match.largest.assign(pair.column_count(), 0.0);
  bool complete = true;
  for (uint32_t a = 0; a < pair.a().size(); ++a) {
    const uint32_t b = match.partner[a];
    const auto turn = b == kNoElement ? std::nullopt : matcher.best_turn(a, b);
    if (!turn) {
      complete &= pair.a().is_degenerate(a);
      continue;
    }
    const ElementBag::Located in_a = pair.a().locate(a), in_b = pair.b().locate(b);
    for (size_t column = 0; column < match.largest.size(); ++column)
      for (int corner = 0; corner < pair.a().corner_count(); ++corner)
        match.largest[column] =
            std::max(match.largest[column], pair.difference(column, in_a, in_b, corner, *turn));
  }
  for (uint32_t b = 0; b < pair.b().size(); ++b) complete &= match.taken[b] != 0 || pair.b().is_degenerate(b);
  if (complete) match.tear = find_tear(pair, tears, matcher);
  if (matcher.exhausted()) return too_many;
  return match;
}

}  // namespace psplit
