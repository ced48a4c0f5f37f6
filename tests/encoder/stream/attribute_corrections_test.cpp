// The values that a stream decodes to have the corrections, and the flags, that libdraco's encoder stored.
#include "encoder/stream/attribute_corrections.h"

#include <map>

#include "tests/encoder/stream/decoded_values.h"
#include "tests/support/corpus_streams.h"
#include "tests/support/draco_streams.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

// Counts attributes by how they are predicted. It shows that the tests meet all schemes.
struct Seen {
  std::map<std::pair<core::Coding, core::Scheme>, size_t> by_scheme;
  size_t attributes = 0, creases = 0, orientations = 0, flips = 0;
};

std::string difference(const AttributeFields& made, const AttributeFields& stored) {
  const auto place = [](const auto& a, const auto& b) {
    const auto [in_a, in_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
    return a == b ? std::string() : std::to_string(in_a - a.begin()) + " of " + std::to_string(b.size());
  };
  std::string what;
  for (const auto& [name, at] : std::map<std::string, std::string>{
           {"raw", place(made.raw, stored.raw)},
           {"symbols", place(made.symbols, stored.symbols)},
           {"orientations", place(made.same_orientations, stored.same_orientations)},
           {"creases 1", place(made.creases[0], stored.creases[0])},
           {"creases 2", place(made.creases[1], stored.creases[1])},
           {"creases 3", place(made.creases[2], stored.creases[2])},
           {"creases 4", place(made.creases[3], stored.creases[3])},
           {"flips", place(made.flips, stored.flips)}})
    if (!at.empty()) what += name + " at " + at + "; ";
  if (made.wrap_min != stored.wrap_min || made.wrap_max != stored.wrap_max) what += "range; ";
  if (made.count != stored.count || made.components != stored.components) what += "counts; ";
  return what;
}

// Makes the fields of all attributes again.
void expect_same_fields(const std::string& name, std::span<const uint8_t> stream, Seen& seen) {
  const Expected<DracoFields> fields = read_fields(stream);
  if (!fields) return;  // a sequential mesh, or integers that are not entropy-coded
  DecodedValues decoded;
  ASSERT_EQ(decoded.decode(stream), core::Fault::kNone) << name;
  for (uint32_t i = 0; i < fields->attributes.size(); ++i) {
    const AttributeFields& stored = fields->attributes[i];
    const Expected<AttributeFields> made = correct_values(decoded.values(i, stored));
    ASSERT_TRUE(made.status().ok()) << name << ", attribute " << i << ": " << made.status().message();
    ++seen.attributes;
    ++seen.by_scheme[{stored.skeleton.coding, stored.skeleton.scheme}];
    for (const std::vector<uint8_t>& flags : stored.creases)
      seen.creases += static_cast<size_t>(std::ranges::count(flags, 1));
    seen.orientations += stored.same_orientations.size();
    seen.flips += static_cast<size_t>(std::ranges::count(stored.flips, 1));
    EXPECT_EQ(difference(*made, stored), "")
        << name << ", attribute " << i << ", scheme " << static_cast<int>(stored.skeleton.scheme);
  }
}

void expect_corrections_of_libdraco(StreamSet set) {
  Seen seen;
  for_each_draco_stream([&](const DracoStream& stream) { expect_same_fields(stream.name, stream.bytes, seen); },
                        set);
  for (const auto& [kind, count] : seen.by_scheme)
    testing::Test::RecordProperty("coding_" + std::to_string(static_cast<int>(kind.first)) + "_scheme_" +
                                      std::to_string(static_cast<int>(kind.second)),
                                  std::to_string(count));
  using core::Coding, core::Scheme;
  for (const auto& kind : {std::pair{Coding::kRaw, Scheme::kNone},
                           {Coding::kQuantized, Scheme::kDifference},
                           {Coding::kQuantized, Scheme::kParallelogram},
                           {Coding::kQuantized, Scheme::kConstrainedMultiParallelogram},
                           {Coding::kQuantized, Scheme::kTexCoords},
                           {Coding::kInteger, Scheme::kDifference},
                           {Coding::kInteger, Scheme::kParallelogram},
                           {Coding::kInteger, Scheme::kConstrainedMultiParallelogram},
                           {Coding::kNormal, Scheme::kDifference},
                           {Coding::kNormal, Scheme::kGeometricNormal}})
    EXPECT_GT(seen.by_scheme[kind], 0u) << static_cast<int>(kind.first) << " " << static_cast<int>(kind.second);
  EXPECT_GT(seen.creases, 0u);
  EXPECT_GT(seen.orientations, 0u);
  EXPECT_GT(seen.flips, 0u);
}

TEST(AttributeCorrections, AreThoseOfLibdracosEncoder) { expect_corrections_of_libdraco(StreamSet::kSmall); }

TEST(AttributeCorrections, OfEveryThirdStreamTakesLong) { expect_corrections_of_libdraco(StreamSet::kThird); }

TEST(AttributeCorrections, OfTheCorpusAreThoseOfTheirEncoders) {
  Seen seen;
  for_each_corpus_stream([&](const std::string& file, const std::vector<uint8_t>& stream) {
    expect_same_fields(file, stream, seen);
  });
  EXPECT_TRUE(IsSkipped() || seen.attributes > 0);
}

}  // namespace
}  // namespace psplit
