// Chooses how the streams of a primitive are coded.
#pragma once

#include "encoder/condensing/border_symbols.h"
#include "encoder/condensing/shared_models.h"
#include "src/container/condensed_head.h"

namespace psplit {

struct Codings {
  uint32_t symbol_contexts = 0;
  std::vector<core::ValueCoding> values;  // by attribute
  std::vector<double> bits;               // about what the values of all streams take, by attribute
  bool has_borders = false;               // border parts have values of the first attribute
};

// The counts of a sample of streams under all codings that may be chosen.
class CodingCounts {
 public:
  // Of attributes that may be coded as deltas, only one order of creation is counted, to compare with.
  CodingCounts(size_t attribute_count, std::span<const core::DeltaModel> deltas)
      : attributes_(attribute_count) {
    for (const core::DeltaModel& delta : deltas) attributes_[delta.attribute].may_be_deltas = true;
  }

  // `source` is null if no attribute may be coded by creation. `border` is null if values at borders cannot be
  // stored once.
  void add(const DracoFields& fields, const DecodedSource* source, const BorderPart* border);
  CodingCounts& operator+=(const CodingCounts& other);

  // All streams have `scale` times the symbols of the sample. Without `with_borders`, values at borders are not
  // to be stored once. If there are deltas, the first attribute is in order of creation where it can be: it has
  // their places.
  Codings choose(double scale, bool smallest, bool with_borders, bool with_deltas) const;

 private:
  // Values in the order of creation: those without a parallelogram by `mean`, the others by `reach`.
  struct CreationCounts {
    TokenCounts none[2]{}, one[kReaches]{}, two[kReaches]{};
  };
  struct Attribute {
    bool may_be_by_creation = false;  // in some streams
    bool may_be_deltas = false;
    AttributeCounts in_draco_order;
    CreationCounts by_creation[2][2];  // by `backward` and `two`
    void add(const Attribute& other);
    bool is_counted(bool backward, bool two) const { return !may_be_deltas || (backward && !two); }
  };
  static void add_by_creation(const DecodedSource& source, uint32_t attribute, std::span<const uint32_t> known,
                              Attribute& to);
  static core::ValueCoding choose_values(const Attribute& attribute, double scale, bool smallest,
                                         bool in_creation_order, double& bits);
  uint32_t choose_symbols(double scale, bool smallest, double bits_of_values) const;

  SymbolCounts last_symbols_ = SymbolCounts(context_count(kMostHistory));
  SymbolCounts valences_ = SymbolCounts(context_count(kValenceContexts));
  std::vector<Attribute> attributes_;
  // The first attribute with border parts, and the tokens of these.
  Attribute inner_;
  std::array<TokenCounts, 2> border_{};
};

}  // namespace psplit
