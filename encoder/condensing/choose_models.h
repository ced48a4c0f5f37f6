// Chooses how the streams of a primitive are coded.
#pragma once

#include "encoder/condensing/models.h"

namespace psplit {

struct Codings {
  uint32_t symbol_contexts = 0;
  std::vector<ValueCoding> values;  // by attribute
};

// The counts of a sample of streams under all codings that may be chosen.
class CodingCounts {
 public:
  explicit CodingCounts(size_t attribute_count) : attributes_(attribute_count) {}

  // `source` is null if no attribute may be coded by creation.
  void add(const DracoFields& fields, const Skeleton& skeleton, const DecodedSource* source);
  CodingCounts& operator+=(const CodingCounts& other);

  // All streams have `scale` times the symbols of the sample.
  Codings choose(double scale, bool smallest) const;

 private:
  static constexpr uint32_t kValueCodings = 9;
  static ValueCoding value_coding(uint32_t number);
  ValueCoding choose_values(uint32_t attribute, double scale, bool smallest, double& bits) const;
  uint32_t choose_symbols(double scale, bool smallest, double bits_of_values) const;

  SymbolCounts last_symbols_ = SymbolCounts(context_count(kMostLastSymbols));
  SymbolCounts valences_ = SymbolCounts(context_count(kValenceContexts));
  struct Attribute {
    bool has_values = false;  // some streams may code it by creation
    std::array<AttributeCounts, kValueCodings> counts;
  };
  std::vector<Attribute> attributes_;
};

}  // namespace psplit
