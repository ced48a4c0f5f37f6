// What one command refuses, all refuse; and what validate says of stock Draco and of values.
#include <random>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/json/glb.h"
#include "psplit/document.h"
#include "psplit/gltf.h"
#include "src/container/patch_container.h"
#include "system/files.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

// The verdict of each function on a document, as the code of its error.
struct Verdicts {
  StatusCode decode, expand, check, validate;

  bool agree() const { return expand == decode && check == decode && validate == decode; }
};

StatusCode refusal_of(std::span<const Finding> findings) {
  for (const Finding& finding : findings)
    if (finding.is_refused()) return finding.code;
  return StatusCode::kOk;
}

Verdicts verdicts_on(const Document& document) {
  Document decoded = document, expanded = document;
  return {decode_document(decoded, cpu_backend(), test_pool()).code(),
          expand_document(expanded, cpu_backend(), test_pool()).status().code(),
          check_document(document, cpu_backend(), test_pool()).code(),
          refusal_of(validate_document(document, cpu_backend(), test_pool()))};
}

// An asset with a skinned primitive in condensed patches, one in stock Draco, and a plain one with morph
// targets.
Document every_storage(int patches) {
  Document document = document_from_mesh(rich_mesh(12, 9));
  add_mesh(document, make_grid(7, 6));
  add_mesh(document, make_grid(5, 4));
  EncodeDocumentOptions options;
  options.condense = Condense::kFast;
  options.patches.count = static_cast<uint32_t>(patches);
  EXPECT_TRUE(encode(document, options).ok());
  Document stock = document_from_mesh(make_grid(9, 8));
  EXPECT_TRUE(encode_document_stock(stock, {}, test_pool()).ok());
  const StoredPrimitive stored = must(stored_primitive(stock, {0, 0}));
  Json primitive = primitive_of(stock);
  primitive["extensions"][kStockExtensionName]["bufferView"] = append_buffer_view(document, stored.bytes);
  for (Json& index : primitive["attributes"]) {
    document.json()["accessors"].push_back(stock.json()["accessors"][index.get<size_t>()]);
    index = document.json()["accessors"].size() - 1;
  }
  document.json()["accessors"].push_back(stock.json()["accessors"][primitive["indices"].get<size_t>()]);
  primitive["indices"] = document.json()["accessors"].size() - 1;
  document.json()["meshes"].push_back({{"primitives", Json::array({primitive})}});
  list_extension(document, kStockExtensionName, true);
  add_mesh(document, make_grid(4, 4));
  Json& plain = document.json()["meshes"].back()["primitives"][0];
  plain["targets"] = Json::array({{{"POSITION", plain["attributes"]["POSITION"]}}});
  return document;
}

TEST(Verdict, EveryStorageIsValid) {
  for (const int patches : {1, 3}) {
    const Document document = every_storage(patches);
    EXPECT_EQ(findings_of(document, cpu_backend()), "");
    EXPECT_TRUE(verdicts_on(document).agree());
  }
}

// A flipped bit in the data, or a changed digit in the JSON: all functions refuse the mutant, or none.
TEST(Verdict, AMutantHasOne) {
  size_t refused = 0, accepted = 0;
  for (const int patches : {1, 3}) {
    const std::string path = testing::TempDir() + "verdict" + std::to_string(patches) + ".glb";
    ASSERT_TRUE(write_document(every_storage(patches), path, {}).ok());
    const std::vector<uint8_t> glb = must(read_file(path));
    const size_t json_end = 20 + must(parse_glb(glb)).json.size();
    std::mt19937 random(static_cast<uint32_t>(patches));
    for (int round = 0; round < 400; ++round) {
      std::vector<uint8_t> bytes = glb;
      if (round % 2 == 0) {
        const size_t at = json_end + 8 + random() % (bytes.size() - json_end - 8);
        bytes[at] = static_cast<uint8_t>(bytes[at] ^ 1u << random() % 8);
      } else {
        size_t at = 20 + random() % (json_end - 20);
        while (bytes[at] < '0' || bytes[at] > '9') at = at + 1 < json_end ? at + 1 : 20;
        bytes[at] = static_cast<uint8_t>('0' + random() % 10);
      }
      const Expected<Document> mutant = parse_document(Span<const uint8_t>(bytes), "mutant.glb");
      if (!mutant) continue;  // all commands read it so
      const Verdicts verdicts = verdicts_on(*mutant);
      ++(verdicts.decode == StatusCode::kOk ? accepted : refused);
      EXPECT_TRUE(verdicts.agree()) << round << ": " << static_cast<int>(verdicts.decode) << " "
                                    << static_cast<int>(verdicts.expand) << " "
                                    << static_cast<int>(verdicts.check) << " "
                                    << static_cast<int>(verdicts.validate);
    }
  }
  EXPECT_GT(refused, 20u);
  EXPECT_GT(accepted, 20u);
}

// Stock Draco is what no primitive in patches depends on: expand has to decode it all the same.
TEST(Verdict, BrokenStockDracoAndPlainDataAreRefusedByAll) {
  Document document = every_storage(3);
  const DracoRecord draco = *document.records().primitive({3, 0}).stock;
  const BufferRange range = document.records().view(draco.view).range;
  std::vector<uint8_t>& bytes = document.buffers[static_cast<size_t>(range.buffer)].own();
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(range.offset), 5, uint8_t{0});
  Verdicts verdicts = verdicts_on(document);
  EXPECT_NE(verdicts.decode, StatusCode::kOk);
  EXPECT_TRUE(verdicts.agree());

  document = every_storage(3);
  accessor_of(document, "indices", 4)["count"] = 44;
  verdicts = verdicts_on(document);
  EXPECT_EQ(verdicts.decode, StatusCode::kInvalidInput);
  EXPECT_TRUE(verdicts.agree());
}

Document stock_grid() {
  Document document = document_from_mesh(rich_mesh(14, 14));
  EXPECT_TRUE(encode_document_stock(document, {}, test_pool()).ok());
  document.source = "asset.glb";
  return document;
}

// The rules that a change breaks, with a space after each, and whether decode corrects it.
std::string broken_stock(const std::function<void(Document&)>& change) {
  Document document = stock_grid();
  EXPECT_EQ(findings_of(document, cpu_backend()), "");
  change(document);
  std::string rules;
  for (const Finding& finding : validate_document(document, cpu_backend(), test_pool()))
    rules += finding.rule + (finding.error ? " " : "? ");
  EXPECT_TRUE(verdicts_on(document).agree());
  return rules;
}

TEST(StockRules, CountsOfAccessors) {
  EXPECT_EQ(broken_stock([](Document& d) { accessor_of(d, "NORMAL")["count"] = 140; }), "accessor-count ");
  EXPECT_EQ(broken_stock([](Document& d) { accessor_of(d, "indices")["count"] = 3; }), "accessor-count ");
  // Two primitives with one stream, and another number of indices each.
  EXPECT_EQ(broken_stock([](Document& d) {
              Json other = primitive_of(d);
              Json indices = accessor_of(d, "indices");
              indices["count"] = 9;
              d.json()["accessors"].push_back(indices);
              other["indices"] = d.json()["accessors"].size() - 1;
              d.json()["meshes"][0]["primitives"].push_back(other);
            }),
            "accessor-count ");
  Document document = stock_grid();
  accessor_of(document, "NORMAL")["count"] = 140;
  std::vector<Finding> corrections;
  ASSERT_TRUE(decode_document(document, cpu_backend(), test_pool(), {}, {}, &corrections).ok());
  ASSERT_EQ(corrections.size(), 1u);
  EXPECT_EQ(corrections[0].message, "NORMAL: the accessor counts 140, the stream has 225");
  EXPECT_EQ(accessor_of(document, "NORMAL")["count"], 225);
}

TEST(StockRules, TypesAndBounds) {
  EXPECT_TRUE(broken_stock([](Document& d) {
                accessor_of(d, "NORMAL")["componentType"] = 5121;
                accessor_of(d, "NORMAL")["normalized"] = true;
              }).starts_with("attribute-type "));
  EXPECT_EQ(broken_stock([](Document& d) { accessor_of(d, "indices")["componentType"] = 5121; }), "");
  EXPECT_EQ(broken_stock([](Document& d) { accessor_of(d, "POSITION").erase("min"); }), "accessor-bounds ");
  EXPECT_EQ(broken_stock([](Document& d) {
              for (const char* name : {"min", "max"}) accessor_of(d, "POSITION")[name] = {0, 0, 0};
            }),
            "accessor-bounds accessor-bounds ");
  // The bounds from before quantization are right.
  EXPECT_EQ(broken_stock([](Document& d) {
              Json& least = accessor_of(d, "POSITION")["min"][0];
              least = least.get<double>() + 1e-5;
            }),
            "");
  Document large = document_from_mesh(make_grid(20, 20));
  ASSERT_TRUE(encode_document_stock(large, {}, test_pool()).ok());
  accessor_of(large, "indices")["componentType"] = 5121;
  EXPECT_EQ(findings_of(large, cpu_backend()),
            "index-type: 441 points do not fit the indices' component type\n");
}

TEST(StockRules, ListsModesAndMembers) {
  EXPECT_EQ(broken_stock([](Document& d) { d.json().erase("extensionsRequired"); }), "extension-required? ");
  EXPECT_EQ(broken_stock([](Document& d) {
              d.json().erase("extensionsRequired");
              d.json().erase("extensionsUsed");
            }),
            "extension-used extension-required? ");
  EXPECT_EQ(broken_stock([](Document& d) { primitive_of(d)["mode"] = 6; }), "mode ");
  EXPECT_EQ(broken_stock([](Document& d) { primitive_of(d).erase("indices"); }), "members ");
  EXPECT_EQ(broken_stock([](Document& d) {
              primitive_of(d)["extensions"][kStockExtensionName]["attributes"]["NORMAL"] = 99;
            }),
            "geometry ");
}

// The rules of warnings about a mesh, for plain data and for what was encoded.
std::string warned(const Mesh& mesh, size_t joints = 400) {
  std::string rules;
  for (const bool encodes : {false, true}) {
    Document document = document_from_mesh(mesh);
    Json bones = Json::array();
    for (size_t i = 0; i < joints; ++i) bones.push_back(0);
    document.json()["skins"] = Json::array({{{"joints", bones}}});
    document.json()["nodes"][0]["skin"] = 0;
    if (encodes) {
      EXPECT_TRUE(encode(document, DocumentOptions{.lossless = true}).ok());
    }
    std::string found;
    for (const Finding& finding : validate_document(document, cpu_backend(), test_pool())) {
      EXPECT_FALSE(finding.error) << finding.rule << finding.message;
      found += finding.rule + " ";
    }
    if (encodes) {
      EXPECT_EQ(found, rules);
    }
    rules = found;
  }
  return rules;
}

void set_float(Mesh& mesh, const char* semantic, size_t number, float value) {
  for (Attribute& attribute : mesh.attributes)
    if (attribute.semantic == semantic)
      std::memcpy(attribute.values.data() + number * sizeof value, &value, sizeof value);
}

TEST(ValueWarnings, NameWhatADecodedMeshShows) {
  const Mesh mesh = rich_mesh();
  EXPECT_EQ(warned(mesh), "");
  EXPECT_EQ(warned(mesh, 300), "joints-range ");
  Mesh wrong = mesh;
  set_float(wrong, "NORMAL", 4, 3.0f);
  EXPECT_EQ(warned(wrong), "unit-normals ");
  wrong = mesh;
  set_float(wrong, "WEIGHTS_0", 8, 2.0f);
  EXPECT_EQ(warned(wrong), "weights-sum ");
  wrong = mesh;
  set_float(wrong, "_TEMPERATURE", 2, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(warned(wrong), "finite ");
}

TEST(ValueWarnings, TargetsOfAnotherCount) {
  Document document = every_storage(3);
  Json& primitive = document.json()["meshes"][4]["primitives"][0];
  primitive["mode"] = 0;
  primitive["targets"][0]["POSITION"] = document.json()["meshes"][2]["primitives"][0]["attributes"]["POSITION"];
  const std::vector<Finding> findings = validate_document(document, cpu_backend(), test_pool());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].rule, "target-count");
  EXPECT_FALSE(findings[0].error);
}

}  // namespace
}  // namespace psplit
