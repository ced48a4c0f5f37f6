#include "tests/support/draco_streams.h"

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <map>
#include <set>

#include "tests/support/draco_clouds.h"
#include "tests/support/draco_features.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

struct Feature {
  std::string name;
  std::function<bool(const StreamFeatures&)> is_in;
};

// Turns a condition on attributes into one on streams: whether it holds for any attribute.
template <typename Test>
std::function<bool(const StreamFeatures&)> any(Test test) {
  return [test](const StreamFeatures& stream) {
    return std::any_of(stream.attributes.begin(), stream.attributes.end(), test);
  };
}

// A list of features, which makes this function long.
std::vector<Feature> features(StreamSet set) {
  using Stream = StreamFeatures;
  using Attribute = AttributeFeatures;
  std::vector<Feature> list = {
      {"standard connectivity", [](const Stream& s) { return s.connectivity == 0; }},
      {"valence connectivity", [](const Stream& s) { return s.connectivity == 2; }},
      {"tagged symbols of a context",
       [](const Stream& s) { return std::ranges::count(s.context_symbols, 0) > 0; }},
      {"split symbols, standard",
       [](const Stream& s) { return s.connectivity == 0 && s.split_symbol_count > 0; }},
      {"split symbols, valence",
       [](const Stream& s) { return s.connectivity == 2 && s.split_symbol_count > 0; }},
      {"split events, standard",
       [](const Stream& s) { return s.connectivity == 0 && s.split_event_count > 0; }},
      {"split events, valence", [](const Stream& s) { return s.connectivity == 2 && s.split_event_count > 0; }},
      {"sequential", [](const Stream& s) { return !s.edgebreaker; }},
      {"compressed indices", [](const Stream& s) { return s.index_coding == 0; }},
      {"compressed indices, tagged", [](const Stream& s) { return s.index_symbols == 0; }},
      {"compressed indices, raw", [](const Stream& s) { return s.index_symbols == 1; }},
      {"indices of 8 bits", [](const Stream& s) { return s.index_bytes == 1; }},
      {"indices of 16 bits", [](const Stream& s) { return s.index_bytes == 2; }},
      {"metadata", [](const Stream& s) { return s.metadata; }},
      {"unique ids of two bytes", any([](const Attribute& a) { return a.unique_id > 127; })},
      {"no attributes", [](const Stream& s) { return s.attributes.empty(); }},
      {"no faces", [](const Stream& s) { return s.face_count == 0; }},
      {"no positions",
       [](const Stream& s) {
         return s.edgebreaker && std::none_of(s.attributes.begin(), s.attributes.end(),
                                              [](const Attribute& a) { return a.type == 0; });
       }},
      {"positions last",
       [](const Stream& s) { return s.attributes.size() > 1 && s.attributes.back().type == 0; }},
      {"integer positions", any([](const Attribute& a) { return a.type == 0 && a.coder == 1; })},
      {"attributes of 16 components", any([](const Attribute& a) { return a.component_count == 16; })},
      {"several attributes", [](const Stream& s) { return s.attributes.size() > 3; }},
      {"seams", any([](const Attribute& a) { return a.element == 1; })},
      {"two attributes with seams",
       [](const Stream& s) {
         return std::count_if(s.attributes.begin(), s.attributes.end(),
                              [](const Attribute& a) { return a.element == 1; }) > 1;
       }},
      {"attribute connectivity without seams",
       any([](const Attribute& a) { return a.element == 0 && a.data_id >= 0; })},
      {"attributes on the connectivity of positions",
       any([](const Attribute& a) { return a.type > 0 && a.data_id < 0; })},
      {"depth first", any([](const Attribute& a) { return a.traversal == 0; })},
      {"by prediction degree", any([](const Attribute& a) { return a.traversal == 1; })},
      {"raw floats", any([](const Attribute& a) { return a.coder == 0 && a.data_type == 9; })},
      {"integers", any([](const Attribute& a) { return a.coder == 1; })},
      {"quantized", any([](const Attribute& a) { return a.coder == 2; })},
      {"octahedral normals", any([](const Attribute& a) { return a.coder == 3; })},
      {"octahedral normals with seams", any([](const Attribute& a) { return a.coder == 3 && a.element == 1; })},
      {"transform wrap", any([](const Attribute& a) { return a.transform == 1; })},
      {"transform canonicalized octahedral", any([](const Attribute& a) { return a.transform == 3; })},
      {"tagged symbols", any([](const Attribute& a) { return a.symbols == 0; })},
      {"raw symbols", any([](const Attribute& a) { return a.symbols == 1; })},
  };
  for (const int scheme : {-2, 0, 1, 4, 5, 6})
    for (const int element : {0, 1})
      list.push_back({"scheme " + std::to_string(scheme) + (element ? ", per corner" : ", per vertex"),
                      any([=](const Attribute& a) { return a.scheme == scheme && a.element == element; })});
  for (const int bytes : {1, 2, 3, 4})
    list.push_back({"stored values of " + std::to_string(bytes) + " bytes",
                    any([=](const Attribute& a) { return a.stored_bytes == bytes; })});
  for (int type = 1; type <= 11; ++type)
    list.push_back(
        {"data type " + std::to_string(type), any([=](const Attribute& a) { return a.data_type == type; })});
  for (const int bits : {1, 2, 8, 16, 24, 30})
    list.push_back({std::to_string(bits) + " bits", any([=](const Attribute& a) { return a.bits == bits; })});
  for (size_t context = 0; context < 6; ++context)
    list.push_back({"raw symbols of context " + std::to_string(context),
                    [=](const Stream& s) { return s.context_symbols[context] == 1; }});
  const int widest = set == StreamSet::kAll ? 18 : 8;
  for (int bits = 1; bits <= widest; ++bits)
    list.push_back({"raw symbols of " + std::to_string(bits) + " bits",
                    any([=](const Attribute& a) { return a.symbol_bits == bits; })});
  if (set == StreamSet::kAll) {
    list.push_back({"indices as varints", [](const Stream& s) { return s.index_bytes == 0; }});
    list.push_back({"indices of 32 bits", [](const Stream& s) { return s.index_bytes == 4; }});
  }
  return list;
}

// Speed, entropy coding and the coding of indices change the bytes of a sequential stream, but not the decoded
// mesh.
class SequentialMeshes {
 public:
  size_t compared = 0;

  void expect_same(const DracoStream& stream) {
    const size_t end = stream.name.find(": sequential"), bits = stream.name.find(", bits");
    if (end == std::string::npos) return;
    const std::string what =
        stream.name.substr(0, end) + (bits < stream.name.size() ? stream.name.substr(bits) : "");
    const RawMesh mesh = must(decode_with_libdraco(stream.bytes));
    const auto [entry, is_new] = decoded_.try_emplace(what, mesh);
    compared += !is_new;
    EXPECT_EQ(entry->second, mesh) << stream.name;
  }

 private:
  std::map<std::string, RawMesh> decoded_;
};

void check_set(StreamSet set) {
  const std::vector<Feature> wanted = features(set);
  SequentialMeshes sequential;
  std::set<std::string> names;
  std::vector<size_t> counts(wanted.size());
  size_t bytes = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        EXPECT_TRUE(names.insert(stream.name).second) << stream.name << " comes twice";
        bytes += stream.bytes.size();
        const StreamFeatures found = must(read_features(stream.bytes));
        for (size_t i = 0; i < wanted.size(); ++i) counts[i] += wanted[i].is_in(found);
        sequential.expect_same(stream);
      },
      set);
  std::cout << names.size() << " streams, " << bytes << " bytes\n";
  for (size_t i = 0; i < wanted.size(); ++i) {
    std::cout << std::setw(8) << counts[i] << "  " << wanted[i].name << '\n';
    EXPECT_GT(counts[i], 0u) << wanted[i].name;
  }
  EXPECT_GE(sequential.compared, set == StreamSet::kAll ? 300u : 0u);
}

TEST(DracoStreams, AreTheSameEveryTime) {
  size_t count = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        ASSERT_LT(count, small_draco_streams().size());
        EXPECT_EQ(stream.bytes, small_draco_streams()[count++].bytes) << stream.name;
      },
      StreamSet::kSmall);
  EXPECT_EQ(count, small_draco_streams().size());
}

TEST(DracoStreams, SmallSetHoldsEveryFeature) { check_set(StreamSet::kSmall); }

TEST(DracoStreams, FullSetHoldsEveryFeatureTakesLong) { check_set(StreamSet::kAll); }

// Where libdraco fuses nothing, the oracle's own arithmetic gives libdraco's floats. Where it does, tests
// compare with it.
TEST(DracoStreams, OracleRoundsAsLibdracoDoes) {
  for (const DracoStream& stream : small_draco_streams())
    EXPECT_TRUE(must(decode_with_libdraco(stream.bytes)) ==
                must(decode_with_libdraco(stream.bytes, AttributeTransforms::kApplyUnfused)))
        << stream.name;
  for (const DracoStream& stream : small_draco_clouds())
    EXPECT_TRUE(must(decode_cloud_with_libdraco(stream.bytes)) ==
                must(decode_cloud_with_libdraco(stream.bytes, AttributeTransforms::kApplyUnfused)))
        << stream.name;
}

// libdraco decodes the same points from a stream whether or not it applies the transforms, and all indices are
// in range.
TEST(DracoStreams, OracleDecodesWholeMeshes) {
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    const auto applied = must(decode_with_libdraco(stream.bytes));
    const auto skipped = must(decode_with_libdraco(stream.bytes, AttributeTransforms::kSkip));
    EXPECT_EQ(applied.faces, skipped.faces);
    EXPECT_EQ(applied.point_count, skipped.point_count);
    ASSERT_EQ(applied.attributes.size(), skipped.attributes.size());
    for (const auto& face : applied.faces)
      for (const uint32_t point : face) ASSERT_LT(point, applied.point_count);
    const auto found = must(read_features(stream.bytes));
    for (size_t i = 0; i < applied.attributes.size(); ++i) {
      const RawAttribute &a = applied.attributes[i], &b = skipped.attributes[i];
      EXPECT_EQ(a.unique_id, b.unique_id);
      EXPECT_EQ(a.unique_id, found.attributes[i].unique_id);
      EXPECT_EQ(a.component_count, found.attributes[i].component_count);
      const bool octahedral = found.attributes[i].coder == 3;
      EXPECT_EQ(b.component_count, octahedral ? 2 : a.component_count);
      EXPECT_TRUE(found.attributes[i].coder != 0 || a == b);
    }
  }
}

// A sequential stream of raw floats decodes to exactly the encoded mesh.
TEST(DracoStreams, OracleReturnsWhatWasEncoded) {
  std::map<std::string, RawMesh> decoded;
  for (const DracoStream& stream : small_draco_streams()) {
    const size_t end = stream.name.find(": sequential");
    if (end != std::string::npos && stream.name.ends_with("bits 0/0/0/0/0"))
      decoded[stream.name.substr(0, end)] = decode_with_libdraco(stream.bytes).value();
  }
  int compared = 0;
  for (const auto& [name, mesh] : nasty_meshes()) {
    SCOPED_TRACE(name);
    const auto found = decoded.find(name);
    if (found == decoded.end()) continue;
    const RawMesh& raw = found->second;
    EXPECT_TRUE(std::equal(raw.faces.begin(), raw.faces.end(), mesh.faces.begin(), mesh.faces.end()));
    EXPECT_EQ(raw.point_count, mesh.point_count);
    ASSERT_EQ(raw.attributes.size(), mesh.attributes.size());
    for (size_t i = 0; i < mesh.attributes.size(); ++i)
      EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(raw.attributes[i].point_values)),
                                     mesh.attributes[i].values));
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(DracoStreams, OracleRefusesCutStreams) {
  for (const DracoStream& stream : small_draco_streams()) {
    if (!stream.name.starts_with("one triangle:")) continue;
    for_each_truncation(stream.bytes, [&](const std::vector<uint8_t>& part) {
      EXPECT_FALSE(decode_with_libdraco(part)) << stream.name << ' ' << part.size();
    });
  }
}

}  // namespace
}  // namespace psplit
