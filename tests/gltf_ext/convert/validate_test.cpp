// Breaks every rule of the extension once.
#include "gltf_ext/convert/validate.h"

#include <functional>

#include "psplit/decode.h"
#include "psplit/document.h"
#include "src/container/condensed_head.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/decode_bytes.h"

namespace psplit {
namespace {

// The findings with libdraco's decoder. The CPU's decoder must give findings for the same rules and places, and
// the same findings if it may have no more than one patch in memory.
std::vector<Finding> validate(const Document& document) {
  const std::vector<Finding> findings = validate_document(document, draco_backend(), test_pool());
  const std::vector<Finding> others = validate_document(document, cpu_backend(), test_pool());
  EXPECT_EQ(findings.size(), others.size());
  for (size_t i = 0; i < std::min(findings.size(), others.size()); ++i) {
    EXPECT_EQ(findings[i].rule, others[i].rule);
    EXPECT_EQ(findings[i].place.mesh, others[i].place.mesh);
    EXPECT_EQ(findings[i].place.primitive, others[i].place.primitive);
    EXPECT_EQ(findings[i].place.patch, others[i].place.patch);
  }
  const MemoryLimit little{1, testing::TempDir()};
  const std::vector<Finding> by_windows = validate_document(document, cpu_backend(), test_pool(), little);
  EXPECT_EQ(by_windows.size(), others.size());
  for (size_t i = 0; i < std::min(by_windows.size(), others.size()); ++i) {
    const auto text_of = [](const Finding& finding) {
      return finding.rule + std::string(finding.error ? ": " : " (warning): ") +
             Status(finding.code, finding.message, finding.place).to_string();
    };
    EXPECT_EQ(text_of(by_windows[i]), text_of(others[i]));
  }
  return findings;
}

// Two meshes; mesh 1, primitive 1 is a wavy grid in four patches.
Document patched(Fallback fallback = Fallback::kNone) {
  Document document = document_from_mesh(rich_mesh());
  const Json primitive = primitive_of(document);
  Json points = primitive;
  points["mode"] = 0;
  document.json()["meshes"] =
      Json::array({{{"primitives", {points}}}, {{"primitives", Json::array({points, primitive})}}});
  EXPECT_TRUE(encode(document, DocumentOptions{.patches = {.count = 4}, .fallback = fallback}).ok());
  document.source = "asset.glb";
  return document;
}

Json& the_primitive(Document& document) { return primitive_of(document, 1, 1); }
Json& the_extension(Document& document) { return the_primitive(document)["extensions"][kExtensionName]; }
Json& the_accessor(Document& document, const char* name) { return accessor_of(document, name, 1, 1); }

std::span<const uint8_t> container_of(Document& document) {
  return *buffer_view_bytes(document, the_extension(document)["bufferView"].get<int64_t>());
}
void set_container(Document& document, std::span<const uint8_t> bytes) {
  the_extension(document)["bufferView"] = append_buffer_view(document, bytes);
}

// The findings after a change, one on each line: rule, place, message.
std::string broken(const std::function<void(Document&)>& change, Fallback fallback = Fallback::kNone) {
  Document document = patched(fallback);
  change(document);
  std::string text;
  for (const Finding& finding : validate(document))
    text += finding.rule + (finding.error ? "" : " (warning)") + " " +
            Status(StatusCode::kInvalidInput, finding.message, finding.place).to_string() + "\n";
  return text;
}

constexpr const char* kPlace = "asset.glb: mesh 1, primitive 1";

TEST(Validate, AcceptsWhatEncodeWrites) {
  for (const Fallback fallback : {Fallback::kNone, Fallback::kUncompressed})
    EXPECT_EQ(broken([](Document&) {}, fallback), "");
  EXPECT_TRUE(validate(document_from_mesh(make_grid(2, 2))).empty());
}

TEST(Validate, ExtensionLists) {
  EXPECT_EQ(broken([](Document& document) { document.json().erase("extensionsUsed"); }),
            "extension-used asset.glb: extensionsUsed does not list the extension\n");
  const std::string required =
      "extension-required asset.glb: a primitive has no fallback, but "
      "extensionsRequired does not list the extension\n";
  EXPECT_EQ(broken([](Document& document) { document.json().erase("extensionsRequired"); }), required);
  EXPECT_EQ(broken([](Document& document) { the_accessor(document, "NORMAL").erase("bufferView"); },
                   Fallback::kUncompressed),
            required);
  // The accessors have no data then: all values are zeros, of which others warn.
  EXPECT_TRUE(
      broken([](Document& document) {
        the_primitive(document).erase("extensions");
      }).ends_with("extension-unused (warning) asset.glb: the extension is listed, but nothing uses it\n"));
}

TEST(Validate, Mode) {
  EXPECT_EQ(broken([](Document& document) { the_primitive(document)["mode"] = 5; }),
            std::string("mode ") + kPlace + ": patches are triangle lists: mode must be 4\n");
  EXPECT_TRUE(
      broken([](Document& document) { the_primitive(document)["mode"] = "four"; }).starts_with("mode "));
}

TEST(Validate, Members) {
  const auto members = [](const char* cause, const std::function<void(Document&)>& change) {
    EXPECT_EQ(broken(change), std::string("members ") + kPlace + ": " + cause + "\n");
  };
  members("PSPLIT_mesh_draco_patches is not an object",
          [](Document& document) { the_extension(document) = Json::array(); });
  members("the extension has no bufferView",
          [](Document& document) { the_extension(document).erase("bufferView"); });
  members("the extension has no attributes",
          [](Document& document) { the_extension(document).erase("attributes"); });
  members("the extension has no attributes",
          [](Document& document) { the_extension(document)["attributes"] = Json::object(); });
  members("the extension's attribute NORMAL has no unique id",
          [](Document& document) { the_extension(document)["attributes"]["NORMAL"] = -1; });
  members("the extension's attribute _MISSING has no accessor",
          [](Document& document) { the_extension(document)["attributes"]["_MISSING"] = 0; });
  members("the primitive has no indices accessor",
          [](Document& document) { the_primitive(document).erase("indices"); });
}

// Reading a file refuses them.
TEST(Validate, BufferViewsThatDoNotExist) {
  for (const Json& index : {Json("0"), Json(99)}) {
    Document document = patched();
    the_extension(document)["bufferView"] = index;
    const std::string message = "an image or an extension names a buffer view that does not exist";
    EXPECT_EQ(document.check().message(), message);
    EXPECT_EQ(findings_of(document, cpu_backend()), "members: " + message + "\n");
  }
}

TEST(Validate, UnknownUniqueId) {
  EXPECT_EQ(
      broken([](Document& document) { the_extension(document)["attributes"]["NORMAL"] = 77; }),
      std::string("decode ") + kPlace + ", patch 0: Draco stream: no attribute for NORMAL (unique id 77)\n");
}

TEST(Validate, EveryTruncation) {
  Document document = patched();
  const auto whole = container_of(document);
  const std::vector<uint8_t> bytes(whole.begin(), whole.end());
  for (size_t length = 0; length < bytes.size(); length += length < 200 ? 1 : 37) {
    Document cut = document;
    set_container(cut, std::span(bytes).first(length));
    const std::vector<Finding> findings = validate(cut);
    ASSERT_EQ(findings.size(), 1u) << length;
    EXPECT_EQ(findings[0].rule, "container") << length;
    EXPECT_EQ(findings[0].place.mesh, 1);
    EXPECT_EQ(findings[0].place.primitive, 1);
  }
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  set_container(document, longer);
  EXPECT_EQ(validate(document)[0].rule, "container");
}

// A flipped bit need not break a rule, because any coordinate is valid. But every finding has the right place,
// and a document without findings decodes.
TEST(Validate, EveryFlippedByte) {
  Document document = patched();
  const auto whole = container_of(document);
  std::vector<uint8_t> bytes(whole.begin(), whole.end());
  set_container(document, bytes);
  const auto& view = document.json()["bufferViews"][the_extension(document)["bufferView"].get<size_t>()];
  const auto offset = view["byteOffset"].get<size_t>();
  const size_t stride = std::max<size_t>(1, bytes.size() / 700);
  for (size_t i = 0; i < bytes.size(); i += i < 120 ? 1 : stride) {
    uint8_t& byte = document.buffers[0].own()[offset + i];
    byte ^= 0x41;
    const std::vector<Finding> findings = validate(document);
    byte ^= 0x41;
    for (const Finding& finding : findings) {
      EXPECT_EQ(finding.place.mesh, 1) << i << " " << finding.message;
      EXPECT_EQ(finding.place.primitive, 1);
      EXPECT_FALSE(finding.message.empty());
    }
    if (i < 52) {
      EXPECT_FALSE(findings.empty()) << "header byte " << i;
    }
  }
}

// Takes the container apart, and writes it again after a change.
void change_parts(Document& document, const std::function<void(ContainerParts&)>& change) {
  const auto whole = container_of(document);
  const std::vector<uint8_t> bytes(whole.begin(), whole.end());
  ContainerParts parts(must(open_container(bytes)));
  change(parts);
  set_container(document, parts.write());
}

TEST(Validate, BadStitchReferences) {
  const auto bad = [](const std::function<void(std::vector<uint8_t>&)>& change) {
    const std::string found = broken([&](Document& document) {
      change_parts(document, [&](ContainerParts& parts) { change(parts.stitch[3]); });
    });
    EXPECT_TRUE(found.starts_with(std::string("decode ") + kPlace + ", patch 3: ")) << found;
    EXPECT_EQ(std::count(found.begin(), found.end(), '\n'), 1) << found;
  };
  bad([](std::vector<uint8_t>& map) { map = {0x80}; });           // a number that does not end
  bad([](std::vector<uint8_t>& map) { map = {0}; });              // fewer references than the directory states
  bad([](std::vector<uint8_t>& map) { map = {1, 0, 0, 9, 0}; });  // a patch before the first
  bad([](std::vector<uint8_t>& map) { map = {1, 0, 0, 1, 0x7f}; });     // outside of the owner's walk
  bad([](std::vector<uint8_t>& map) { map = {1, 0x7f, 0, 1, 0}; });     // outside of its own walk
  bad([](std::vector<uint8_t>& map) { map = {0, 0x7f, 1, 0}; });        // a point that does not exist
  bad([](std::vector<uint8_t>& map) { map = {0, 0, 1, 0xff, 0x7f}; });  // a rank that does not exist
  bad([](std::vector<uint8_t>& map) { map.pop_back(); });
}

TEST(Validate, ADirectoryThatLies) {
  const std::string found = broken([](Document& document) {
    change_parts(document, [](ContainerParts& parts) { --parts.entries[2].face_count; });
  });
  EXPECT_TRUE(found.starts_with(std::string("decode ") + kPlace + ", patch 2: the stream has ")) << found;
}

TEST(Validate, AccessorCounts) {
  EXPECT_EQ(broken([](Document& document) { the_accessor(document, "TEXCOORD_0")["count"] = 3; }),
            std::string("accessor-count ") + kPlace + ": TEXCOORD_0 has another count than 130\n");
  EXPECT_EQ(
      broken([](Document& document) { the_accessor(document, "indices")["count"] = 3; }),
      std::string("accessor-count ") + kPlace + ": the accessor of the indices has another count than 648\n");
}

TEST(Validate, AccessorTypes) {
  const std::string found =
      broken([](Document& document) { the_accessor(document, "TEXCOORD_0")["type"] = "VEC3"; });
  EXPECT_TRUE(found.starts_with(std::string("decode ") + kPlace + ", patch 0: Draco stream: TEXCOORD_0"))
      << found;
}

TEST(Validate, AccessorBounds) {
  EXPECT_EQ(
      broken([](Document& document) { the_accessor(document, "POSITION").erase("max"); }),
      std::string("accessor-bounds ") + kPlace + ": POSITION: max differs from that of the decoded values\n");
  EXPECT_EQ(
      broken([](Document& document) { the_accessor(document, "POSITION")["min"][2] = -3; }),
      std::string("accessor-bounds ") + kPlace + ": POSITION: min differs from that of the decoded values\n");
  EXPECT_EQ(
      broken([](Document& document) { the_accessor(document, "POSITION")["min"][2] = "x"; }),
      std::string("accessor-bounds ") + kPlace + ": POSITION: min differs from that of the decoded values\n");
  EXPECT_EQ(
      broken([](Document& document) {
        the_accessor(document, "indices")["min"] = {0};
        the_accessor(document, "indices")["max"] = {130};
      }),
      std::string("accessor-bounds ") + kPlace + ": indices: max differs from that of the decoded values\n");
  const std::string both = broken([](Document& document) { the_accessor(document, "COLOR_0")["min"] = {0}; });
  EXPECT_EQ(std::count(both.begin(), both.end(), '\n'), 2) << both;
}

TEST(Validate, IndexTypes) {
  EXPECT_EQ(broken([](Document& document) { the_accessor(document, "indices")["componentType"] = 5126; }),
            std::string("index-type ") + kPlace + ": 130 points do not fit the indices' component type\n");
  EXPECT_EQ(broken([](Document& document) { the_accessor(document, "indices")["componentType"] = 5121; }), "");
}

TEST(Validate, IndexShape) {
  EXPECT_EQ(broken([](Document& document) { the_accessor(document, "indices")["type"] = "VEC3"; }),
            std::string("index-type ") + kPlace + ": indices are not scalars\n");
}

TEST(Validate, Exclusions) {
  const auto sparse = [](Document& document) -> Json {
    const Json& view = the_extension(document)["bufferView"];
    return {{"count", 1},
            {"indices", {{"bufferView", view}, {"componentType", 5121}}},
            {"values", {{"bufferView", view}}}};
  };
  const auto exclusion = [](const char* cause, const std::function<void(Document&)>& change) {
    EXPECT_EQ(broken(change), std::string("exclusion ") + kPlace + ": " + cause + "\n");
  };
  exclusion("the primitive has KHR_draco_mesh_compression as well", [](Document& document) {
    the_primitive(document)["extensions"][kStockExtensionName] = the_extension(document);
  });
  exclusion("NORMAL is in the patches, but its accessor is sparse",
            [&](Document& document) { the_accessor(document, "NORMAL")["sparse"] = sparse(document); });
  exclusion("indices is in the patches, but its accessor is sparse",
            [&](Document& document) { the_accessor(document, "indices")["sparse"] = sparse(document); });
  exclusion("the container's buffer view is compressed", [](Document& document) {
    Json& view = document.json()["bufferViews"][the_extension(document)["bufferView"].get<size_t>()];
    view["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0}, {"byteLength", 1}, {"byteStride", 4}, {"count", 1}, {"mode", "ATTRIBUTES"}};
  });
}

// Equal primitives share a container. A backend other than the CPU's decodes it once more.
TEST(Validate, DecodesEachContainerOnce) {
  Document document = patched();
  document.json()["meshes"].push_back(document.json()["meshes"][1]);
  const DecodeBackend unused{
      "cpu", [](std::span<const DecodeTask> tasks, const BuffersFor&, const ThreadPool&, const Watch&) {
        ADD_FAILURE() << "decodes " << tasks.size() << " containers again";
        return std::vector<Status>(tasks.size());
      }};
  EXPECT_TRUE(validate_document(document, unused, test_pool()).empty());
  size_t decoded = 0;
  const DecodeBackend counting{"another", [&](std::span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                              const ThreadPool& pool, const Watch& watch) {
                                 decoded += tasks.size();
                                 return draco_backend().decode_into(tasks, buffers_for, pool, watch);
                               }};
  EXPECT_TRUE(validate_document(document, counting, test_pool()).empty());
  EXPECT_EQ(decoded, 1u);
}

TEST(Validate, EqualPrimitivesHaveTheSameFindings) {
  EXPECT_EQ(broken([](Document& document) {
              document.json()["meshes"].push_back(document.json()["meshes"][1]);
              the_accessor(document, "NORMAL")["count"] = 7;
            }),
            std::string("accessor-count ") + kPlace + ": NORMAL has another count than 130\n" +
                "accessor-count asset.glb: mesh 2, primitive 1: NORMAL has another count than 130\n");
}

// Small integers are stored with 16 bits; decoders can convert them to bytes.
TEST(Validate, TypesOfStoredAttributes) {
  std::string wanted;
  for (const char* patch : {"0", "1", "2", "3"})
    wanted += std::string("attribute-type ") + kPlace + ", patch " + patch +
              ": _FEATURE_ID_0 is stored in another type than its accessor's\n";
  EXPECT_EQ(broken([](Document& document) { the_accessor(document, "_FEATURE_ID_0")["componentType"] = 5121; }),
            wanted);
}

// A patch with a grid of its own decodes, but its border is not at the same positions as in its neighbours.
TEST(Validate, CopiesOfPoints) {
  const std::string found = broken([](Document& document) {
    Document coarse = document_from_mesh(rich_mesh());
    ASSERT_TRUE(encode(coarse, DocumentOptions{.patches = {.count = 4}, .position_bits = 9}).ok());
    const auto coarse_bytes = *buffer_view_bytes(
        coarse, primitive_of(coarse)["extensions"][kExtensionName]["bufferView"].get<int64_t>());
    const ContainerParts other(must(open_container(coarse_bytes)));
    change_parts(document, [&](ContainerParts& parts) { parts.streams[3] = other.streams[3]; });
  });
  EXPECT_TRUE(found.starts_with(std::string("copies ") + kPlace + ", patch 3: POSITION of decoded point "))
      << found;
}

// `change` gets the content of the section: the bounds of the mesh, 24 bytes, and 6 bytes for each patch.
std::string with_broken_boxes(const std::function<void(std::vector<uint8_t>&)>& change) {
  return broken([&](Document& document) {
    const auto whole = container_of(document);
    const std::vector<uint8_t> bytes(whole.begin(), whole.end());
    const PatchContainer container = must(open_container(bytes));
    const Mesh mesh = must(read(document, 1, 1));
    std::vector<uint8_t> section = write_boxes(boxes_of(container, mesh));
    ASSERT_EQ(section.size(), 24u + 4 * 6);
    change(section);
    set_container(document, with_head_section(container, HeadSection::kBoxes, section));
    // No reader refuses a mesh because of its boxes.
    EXPECT_TRUE(check_patches(document, test_pool()).ok());
  });
}

TEST(Validate, Boxes) {
  const auto found = [](size_t patch, size_t at, uint8_t byte) {
    return with_broken_boxes([=](std::vector<uint8_t>& section) { section[24 + 6 * patch + at] = byte; });
  };
  const std::string place = std::string("boxes ") + kPlace;
  EXPECT_EQ(with_broken_boxes([](std::vector<uint8_t>&) {}), "");
  // A larger box than that of the points has them all.
  EXPECT_EQ(found(2, 0, 0), "");
  EXPECT_EQ(found(2, 5, 255), "");
  for (size_t axis = 0; axis < 3; ++axis) {
    // A box that is as flat as its least, and one that is as flat as its greatest.
    const auto flat = [&](size_t patch, size_t to, size_t from) {
      return with_broken_boxes([=](std::vector<uint8_t>& section) {
        section[24 + 6 * patch + to + axis] = section[24 + 6 * patch + from + axis];
      });
    };
    const std::string low = flat(1, 0, 3), high = flat(3, 3, 0);
    EXPECT_TRUE(low.starts_with(place + ", patch 1: its " + "xyz"[axis] + " is from ")) << low;
    EXPECT_TRUE(high.starts_with(place + ", patch 3: its " + "xyz"[axis] + " is from ")) << high;
    EXPECT_EQ(std::count(low.begin(), low.end(), '\n'), 1) << low;
  }
  const std::string empty = with_broken_boxes([](std::vector<uint8_t>& section) {
    std::fill_n(section.begin() + 24, 6, uint8_t{9}), section[24] = 10;
  });
  EXPECT_TRUE(empty.starts_with(place + ", patch 0: ")) << empty;
  EXPECT_TRUE(contains(empty, "but its box is empty\n")) << empty;
  EXPECT_EQ(with_broken_boxes([](std::vector<uint8_t>& section) { section.pop_back(); }),
            place + ": head: boxes of another number of streams\n");
  EXPECT_EQ(with_broken_boxes([](std::vector<uint8_t>& section) { std::fill_n(section.begin(), 4, 0xff); }),
            place + ": head: boxes without bounds\n");
}

TEST(Validate, FallbackData) {
  for (const char* name : {"NORMAL", "COLOR_1", "indices"}) {
    const auto change = [&](Document& document) {
      const Json& accessor = the_accessor(document, name);
      const Json& view = document.json()["bufferViews"][accessor["bufferView"].get<size_t>()];
      document.buffers[view["buffer"].get<size_t>()].own()[view["byteOffset"].get<size_t>()] ^= 1;
    };
    EXPECT_EQ(broken(change, Fallback::kUncompressed), std::string("fallback ") + kPlace + ": " + name +
                                                           " differs from the decoded data of the patches\n");
  }
}

TEST(Validate, CountsBesideThePatches) {
  const std::string extra = broken([](Document& document) {
    the_extension(document)["attributes"].erase("COLOR_1");
    the_accessor(document, "COLOR_1")["count"] = 4;
  });
  EXPECT_TRUE(
      extra.ends_with(std::string("accessor-count ") + kPlace + ": COLOR_1 has another count than 130\n"))
      << extra;
  const std::string morph = broken([](Document& document) {
    the_primitive(document)["targets"] = Json::array({{{"POSITION", the_primitive(document)["indices"]}}});
  });
  EXPECT_EQ(morph,
            std::string("accessor-count ") + kPlace + ": targets/0/POSITION has another count than 130\n");
}

// Without indices a fallback is incomplete, and loaders ignore all of it.
TEST(Validate, WhatIsNoWholeFallbackIsAWarning) {
  const std::string found = broken(
      [](Document& document) {
        the_accessor(document, "indices").erase("bufferView");
        the_accessor(document, "POSITION")["bufferView"] = the_accessor(document, "NORMAL")["bufferView"];
        document.json()["extensionsRequired"] = Json::array({kExtensionName});
      },
      Fallback::kUncompressed);
  EXPECT_EQ(found, std::string("fallback (warning) ") + kPlace +
                       ": POSITION differs from the decoded data of the patches\n");
}

TEST(Validate, ExtraAttributes) {
  EXPECT_EQ(broken([](Document& document) { the_extension(document)["attributes"].erase("COLOR_1"); }),
            std::string("attribute-extra (warning) ") + kPlace +
                ": COLOR_1 is not in the patches: its accessor must follow their order\n");
}

}  // namespace
}  // namespace psplit
