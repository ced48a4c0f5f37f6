#include "tools/gltf_psplit/diff/match_elements.h"

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

uint64_t bits_of(double value) { return std::bit_cast<uint64_t>(value + 0.0); }  // -0 and 0 have equal bits

// The keys by which elements are looked up.
class Cells {
 public:
  explicit Cells(const ElementPair& pair) : corner_count_(pair.a().corner_count()) {
    for (size_t column = 0; column < pair.column_count(); ++column) {
      const double limit = pair.largest_limit(column);
      if (limit == 0) {
        exact_.push_back(column);
      } else if (!pair.is_direction(column) && std::isfinite(limit)) {
        const size_t components = pair.a().parts()[0].columns[column].component_count;
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
    const std::vector<ValuesView>& columns = bag.parts()[located.part].columns;
    uint64_t sum = 0;  // does not depend on the first corner
    for (int corner = 0; corner < corner_count_; ++corner) {
      uint64_t hash = 0;
      for (const size_t column : exact_)
        for (size_t c = 0; c < columns[column].component_count; ++c)
          hash = mix(hash, bits_of(bag.number(located, column, corner, c)));
      sum += mix(hash, 1);
    }
    keys.assign(1, sum);
    for (const Dimension& dimension : dimensions_) {
      double value = 0;
      for (int corner = 0; corner < corner_count_; ++corner)
        value += bag.number(located, dimension.column, corner, dimension.component);
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
  // The last `paired` elements of both bags are partners of each other in their order. `rim`: if not empty,
  // elements of `a` that were searched for before, and of whose choices some may be missing from `b`.
  Matcher(const ElementPair& pair, uint64_t spare_tests, uint32_t paired = 0, std::vector<bool> rim = {})
      : pair_(pair), cells_(pair), paired_(paired), rim_(std::move(rim)) {
    const uint32_t count_a = pair.a().size(), count_b = pair.b().size();
    tests_left_ = spare_tests + 300 * (uint64_t{count_a} + count_b);
    partner_of_a_.assign(count_a, kNoElement);
    partner_of_b_.assign(count_b, kNoElement);
    for (uint32_t i = 1; i <= paired; ++i) {
      partner_of_a_[count_a - i] = count_b - i;
      partner_of_b_[count_b - i] = count_a - i;
    }
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
        if (partner_of_a_[a] == kNoElement && !is_rim(a) && pair_.a().is_degenerate(a) == degenerate &&
            !take_free(a, degenerate))
          left.push_back(a);
      for (const uint32_t a : left) reassign(a);
    }
    return !is_undecided();
  }

  // Too many tests, or a search that would have gone on beyond the rim.
  bool is_undecided() const { return tests_left_ == 0 || met_rim_; }
  const std::vector<uint32_t>& partner_of_a() const { return partner_of_a_; }
  const std::vector<uint32_t>& partner_of_b() const { return partner_of_b_; }

  // The turn in which an element of `a` fits one of `b` best, with ElementPair::fit. Nothing if none fits.
  struct Fit {
    double score;
    int turn;
  };
  std::optional<Fit> best_fit(const ElementBag::Located& a, uint32_t b) const {
    std::optional<Fit> best;
    const ElementBag::Located in_b = pair_.b().locate(b);
    for (int turn = 0; turn < pair_.a().corner_count(); ++turn) {
      const std::optional<double> score = pair_.fit(a, in_b, turn);
      if (score && (!best || *score < best->score)) best = Fit{*score, turn};
    }
    return best;
  }

  // Whether `a` fits exactly one element, in exactly one turn.
  bool has_one_choice(uint32_t a) {
    if (is_rim(a)) return false;
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
  // A cell of `b`: order_[begin, end). Elements in [begin, free_end) have no partner yet.
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
      buckets_.back().end = i + 1;
      if (keyed[i].second < count_b - paired_) buckets_.back().free_end = i + 1;
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

  bool is_rim(uint32_t a) const { return !rim_.empty() && rim_[a]; }

  bool count_test() {
    if (tests_left_ > 0) --tests_left_;
    return tests_left_ > 0;
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
        const std::optional<Fit> fit = best_fit(in_a, order_[i]);
        if (!fit) continue;
        ++fits;
        double score = fit->score;
        // A last resort: it should stay free for elements of its own kind.
        if (pair_.b().is_degenerate(order_[i]) != degenerate) score += 1e3;
        if (best_bucket != nullptr && score >= least) continue;
        best_bucket = bucket;
        best_place = i;
        least = score;
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
          if (!best_fit(in_a, b)) continue;
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
    met_rim_ |= std::ranges::any_of(queue, [&](uint32_t a) { return is_rim(a); });
  }

  const ElementPair& pair_;
  Cells cells_;
  uint32_t paired_;
  std::vector<bool> rim_;
  bool met_rim_ = false;
  std::vector<uint32_t> partner_of_a_, partner_of_b_;
  std::vector<uint32_t> order_;  // elements of b, sorted by cell
  std::vector<Bucket> buckets_;
  std::vector<uint32_t> slots_;  // a hash table of indices into buckets_
  std::vector<uint8_t> seen_;    // one flag for each element of b
  std::vector<uint64_t> keys_;
  uint64_t tests_left_ = 0;
};

// Finds a position of one bag that is two positions in the other, among pairs that cannot be exchanged.
class TearFinder {
 public:
  TearFinder(const ElementPair& pair, Matcher& matcher) : pair_(pair), matcher_(matcher) {}

  std::optional<Tear> find(bool in_b) {
    struct First {
      Position torn{};
      uint32_t element = kNoElement;
      std::pair<int32_t, size_t> grid;  // a part without a stated grid counts as a grid
      int corner = 0;
    };
    std::unordered_map<Position, First, Hash> firsts;
    for (uint32_t a = 0; a < pair_.a().size(); ++a) {
      const uint32_t b = matcher_.partner_of_a()[a];
      if (b == kNoElement) continue;
      const ElementBag::Located in_a = pair_.a().locate(a), in_b_located = pair_.b().locate(b);
      const std::optional<Matcher::Fit> fit = matcher_.best_fit(in_a, b);
      if (!fit) continue;
      for (int corner = 0; corner < pair_.a().corner_count(); ++corner) {
        Position whole = position_of(pair_.a(), in_a, corner);
        Position torn = position_of(pair_.b(), in_b_located, (corner + fit->turn) % pair_.b().corner_count());
        auto grid = grid_of(pair_.b(), in_b_located.part);
        if (!in_b) {
          std::swap(whole, torn);
          grid = grid_of(pair_.a(), in_a.part);
        }
        const auto [found, is_new] = firsts.try_emplace(whole, First{torn, a, grid, corner});
        const First& first = found->second;
        // Positions on two grids may differ.
        if (is_new || first.torn == torn || first.grid != grid) continue;
        if (matcher_.has_one_choice(a) && matcher_.has_one_choice(first.element))
          return Tear{in_b, {first.element, a}, {first.corner, corner}};
      }
    }
    return std::nullopt;
  }

 private:
  using Position = std::array<uint64_t, 3>;
  struct Hash {
    size_t operator()(const Position& position) const {
      return mix(mix(mix(0, position[0]), position[1]), position[2]);
    }
  };

  static Position position_of(const ElementBag& bag, const ElementBag::Located& element, int corner) {
    const size_t components = bag.parts()[element.part].columns[0].component_count;
    Position position{};
    for (size_t c = 0; c < std::min<size_t>(3, components); ++c)
      position[c] = bits_of(bag.number(element, 0, corner, c));
    return position;
  }

  static std::pair<int32_t, size_t> grid_of(const ElementBag& bag, size_t part) {
    const int32_t grid = bag.parts()[part].limits[0].grid;
    return {grid, grid < 0 ? part : 0};
  }

  const ElementPair& pair_;
  Matcher& matcher_;
};

std::optional<Tear> find_tear(const ElementPair& pair, TearSearch tears, Matcher& matcher) {
  if (tears == TearSearch::kNone || pair.a().corner_count() != 3 || pair.largest_limit(0) == 0)
    return std::nullopt;
  TearFinder finder(pair, matcher);
  if (tears != TearSearch::kInEither) return finder.find(tears == TearSearch::kInB);
  return finder.find(true) ? finder.find(false) : std::nullopt;
}

// Ranges of keys that divide the elements of both bags. The key of an element is the sum of its corners along
// one axis. Partners have keys that are at most `reach` apart. Elements of `a` are in the range of their key
// plus `reach`, so that all elements that they may fit are there or before.
class Windows {
 public:
  Windows(const ElementPair& pair, uint64_t most, bool with_tears) : pair_(pair) {
    if (uint64_t{pair.a().size()} + pair.b().size() <= most) return;
    choose_axis(with_tears);
    constexpr size_t kBins = size_t{1} << 16;
    std::vector<uint64_t> counts(kBins);
    const double low = low_, width = (high_ + reach_ - low_) / kBins;
    if (!(width > 0 && std::isfinite(width))) return;  // all keys are equal
    for (const size_t side : {0u, 1u})
      for (uint32_t i = 0; i < bag(side).size(); ++i)
        ++counts[static_cast<size_t>(std::clamp((key(side, i) - low) / width, 0.0, kBins - 1.0))];
    uint64_t count = 0;
    for (size_t bin = 0; bin < kBins; ++bin) {
      if (count > 0 && count + counts[bin] > most) {
        borders_.push_back(low + static_cast<double>(bin) * width);
        count = 0;
      }
      count += counts[bin];
    }
  }

  size_t count() const { return borders_.size() + 1; }
  std::vector<uint32_t> elements_of(size_t window, size_t side) const {
    std::vector<uint32_t> elements;
    for (uint32_t i = 0; i < bag(side).size(); ++i) {
      const double at = key(side, i);
      if ((window == 0 || at >= borders_[window - 1]) && (window == borders_.size() || at < borders_[window]))
        elements.push_back(i);
    }
    return elements;
  }
  // Whether a later window needs the element.
  bool stays(size_t window, size_t side, uint32_t element) const {
    return window < borders_.size() && key(side, element) >= borders_[window] - margin_;
  }
  bool is_rim(size_t window, uint32_t element_of_a) const {
    return window > 0 && key(0, element_of_a) < borders_[window - 1] - margin_ + 3 * reach_;
  }

 private:
  const ElementBag& bag(size_t side) const { return side == 0 ? pair_.a() : pair_.b(); }

  // The sum along an axis. No turn changes it but for rounding; `reach` covers that.
  double sum(size_t side, uint32_t element, size_t axis) const {
    const ElementBag::Located located = bag(side).locate(element);
    double sum = 0;
    for (int corner = 0; corner < bag(side).corner_count(); ++corner)
      sum += bag(side).number(located, 0, corner, axis);
    return std::isnan(sum) ? low_ : std::clamp(sum, low_, high_);
  }
  double key(size_t side, uint32_t element) const {
    return sum(side, element, axis_) + (side == 0 ? reach_ : 0);
  }

  void choose_axis(bool with_tears) {
    constexpr double kLargest = 1e300;
    double widest = -1, low_of_widest = 0, high_of_widest = 0, longest_of_widest = 0;
    const size_t components = pair_.a().parts()[0].columns[0].component_count;
    for (size_t axis = 0; axis < std::min<size_t>(3, components); ++axis) {
      low_ = -kLargest;
      high_ = kLargest;
      double low = kLargest, high = -kLargest, longest = 0;
      for (const size_t side : {0u, 1u})
        for (uint32_t i = 0; i < bag(side).size(); ++i) {
          const double at = sum(side, i, axis);
          if (std::fabs(at) == kLargest) continue;
          low = std::min(low, at);
          high = std::max(high, at);
          const ElementBag::Located located = bag(side).locate(i);
          double least = kLargest, most = -kLargest;
          for (int corner = 0; corner < bag(side).corner_count(); ++corner) {
            const double value = bag(side).number(located, 0, corner, axis);
            least = std::min(least, value);
            most = std::max(most, value);
          }
          longest = std::max(longest, most - least);
        }
      if (high - low <= widest) continue;
      widest = high - low;
      axis_ = axis;
      low_of_widest = low;
      high_of_widest = high;
      longest_of_widest = longest;
    }
    low_ = low_of_widest;
    high_ = high_of_widest;
    reach_ =
        pair_.a().corner_count() * pair_.largest_limit(0) + 1e-13 * std::max(std::fabs(low_), std::fabs(high_));
    constexpr double kLongestSearch = 64;  // of augmenting paths, in reaches
    // Elements that share a corner have sums that are at most twice the length of each apart.
    margin_ = kLongestSearch * reach_ + (with_tears ? 4 * longest_of_widest : 0);
  }

  const ElementPair& pair_;
  size_t axis_ = 0;
  double low_ = 0, high_ = 0, reach_ = 0, margin_ = 0;
  std::vector<double> borders_;
};

}  // namespace

Expected<ElementMatch> match_elements(const ElementPair& pair, TearSearch tears, const MatchLimits& limits) {
  const Status undecided =
      runtime_failure("too many elements are within the tolerance of each other to be told apart");
  const Windows windows(pair, limits.window, tears != TearSearch::kNone);
  const bool is_one = windows.count() == 1;
  const ElementBag* const bags[] = {&pair.a(), &pair.b()};
  ElementMatch match;
  match.largest.assign(pair.column_count(), 0.0);
  for (const size_t side : {0u, 1u}) match.has_partner[side].resize(bags[side]->size());
  bool complete = true;
  // The elements of each side that stay for the next window: `alone` have no partner, `paired` have one.
  std::vector<uint32_t> alone[2], paired[2];
  for (size_t window = 0; window < windows.count(); ++window) {
    std::vector<uint32_t> elements[2];
    if (alone[0].size() + alone[1].size() + paired[0].size() + paired[1].size() > limits.window)
      return unsupported("--memory is too small to pair elements of this size or with this tolerance");
    for (const size_t side : {0u, 1u}) {
      if (is_one) continue;
      elements[side] = windows.elements_of(window, side);
      for (const std::vector<uint32_t>* kept : {&alone[side], &paired[side]})
        elements[side].insert(elements[side].end(), kept->begin(), kept->end());
      alone[side].clear();
    }
    const auto number = [&](size_t side, uint32_t i) { return is_one ? i : elements[side][i]; };
    std::vector<bool> rim;
    for (const uint32_t element : elements[0]) rim.push_back(windows.is_rim(window, element));
    const ElementBag a = is_one ? pair.a() : pair.a().chosen(elements[0]);
    const ElementBag b = is_one ? pair.b() : pair.b().chosen(elements[1]);
    const ElementPair local = pair.of(a, b);
    Matcher matcher(local, limits.spare_tests, static_cast<uint32_t>(paired[0].size()), std::move(rim));
    if (!matcher.run()) return undecided;
    for (std::vector<uint32_t>& kept : paired) kept.clear();
    const auto leave_alone = [&](size_t side, uint32_t i) {
      if (windows.stays(window, side, number(side, i)))
        alone[side].push_back(number(side, i));
      else
        complete &= (side == 0 ? a : b).is_degenerate(i);
    };
    for (uint32_t i = 0; i < a.size(); ++i) {
      const uint32_t partner = matcher.partner_of_a()[i];
      if (partner == kNoElement) {
        leave_alone(0, i);
        continue;
      }
      const uint32_t in_a = number(0, i), in_b = number(1, partner);
      match.has_partner[0][in_a] = match.has_partner[1][in_b] = true;
      if (windows.stays(window, 0, in_a) || windows.stays(window, 1, in_b)) {
        paired[0].push_back(in_a);
        paired[1].push_back(in_b);
        continue;
      }
      const ElementBag::Located of_a = a.locate(i), of_b = b.locate(partner);
      const int turn = matcher.best_fit(of_a, partner)->turn;
      for (size_t column = 0; column < match.largest.size(); ++column)
        for (int corner = 0; corner < a.corner_count(); ++corner)
          match.largest[column] =
              std::max(match.largest[column], local.difference(column, of_a, of_b, corner, turn));
    }
    for (uint32_t i = 0; i < b.size(); ++i)
      if (matcher.partner_of_b()[i] == kNoElement) leave_alone(1, i);
    if (complete && !match.tear) {
      match.tear = find_tear(local, tears, matcher);
      if (match.tear)
        for (uint32_t& element : match.tear->elements) element = number(0, element);
    }
    if (matcher.is_undecided()) return undecided;
    if (is_one) continue;
    pair.a().release();
    pair.b().release();
  }
  if (!complete) match.tear.reset();
  return match;
}

}  // namespace psplit
