#include "src/container/patch_container.h"

#include "src/container/condensed_head.h"
#include "src/container/patch_boxes.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/mutants.h"

namespace psplit {
namespace {

// The header of a Draco mesh stream, and bytes that follow. Opening reads no more of a stream.
struct StreamFront {
  bool edgebreaker = true;
  uint8_t faces = 1, points = 3;  // of an Edgebreaker stream, its vertices
  uint8_t attribute_data_count = 0;
};

std::vector<uint8_t> stream_of(const StreamFront& front, size_t size) {
  std::vector<uint8_t> bytes{'D', 'R', 'A', 'C', 'O', 2, 2, 1, uint8_t{front.edgebreaker}, 0, 0};
  if (front.edgebreaker)
    bytes.insert(bytes.end(),
                 {0, front.points, front.faces, front.attribute_data_count, front.faces, /*S symbols*/ 0,
                  /*split events*/ 0});
  else
    bytes.insert(bytes.end(), {front.faces, front.points});
  EXPECT_GE(size, bytes.size());
  bytes.resize(size);
  return bytes;
}

// Two patches and a residue, whose stream has a face more than its row counts.
ContainerParts three_streams() {
  ContainerParts parts;
  parts.has_residue = true;
  parts.entries = {{25, 100, 60, 0, 0}, {320, 101, 61, 7, 4}, {22, 2, 9, 9, 2}};
  for (const StreamEntry& entry : parts.entries) {
    parts.stitch.emplace_back(entry.stitch_bytes, uint8_t{0x11});
    const bool is_residue = parts.streams.size() == 2;
    const auto faces = static_cast<uint8_t>(entry.face_count + (is_residue ? 1 : 0));
    parts.streams.push_back(
        stream_of({!is_residue, faces, static_cast<uint8_t>(entry.point_count)}, entry.stream_bytes));
  }
  return parts;
}

Status open_status(const ContainerParts& parts) {
  const std::vector<uint8_t> bytes = parts.write();
  return open_container(bytes).status();
}

void expect_parts(const std::vector<uint8_t>& bytes, const ContainerParts& parts) {
  const PatchContainer container = must(open_container(bytes));
  EXPECT_EQ(container.entries, parts.entries);
  EXPECT_EQ(container.patch_count(), 2u);
  EXPECT_EQ(container.point_count(), 60u + 54u + 0u);
  EXPECT_EQ(container.face_count(), 203u);
  EXPECT_EQ(container.reference_count(), 16u);
  EXPECT_EQ(container.header_bytes + container.stitch_bytes() + container.stream_bytes(), bytes.size());
  EXPECT_EQ(container.bytes.data(), bytes.data());
  for (size_t i = 0; i < parts.entries.size(); ++i) {
    EXPECT_TRUE(std::equal(container.streams[i].begin(), container.streams[i].end(), parts.streams[i].begin(),
                           parts.streams[i].end()));
    EXPECT_TRUE(std::equal(container.stitch[i].begin(), container.stitch[i].end(), parts.stitch[i].begin(),
                           parts.stitch[i].end()));
  }
  EXPECT_EQ(container.headers[1].counts.face_count, 101u);
  EXPECT_EQ(container.headers[2].point_count, 9u);
  EXPECT_FALSE(container.headers[2].edgebreaker);
  EXPECT_EQ(container.stitch_row(1).owned_base, 60u);
}

TEST(PatchContainer, GivesBackWhatWasWritten) {
  const ContainerParts parts = three_streams();
  expect_parts(parts.write(), parts);
  const std::vector<uint8_t> bytes = parts.write();
  const PatchContainer container = *open_container(bytes);
  EXPECT_EQ(container.head, nullptr);
  EXPECT_EQ(container.condensed_count(), 0u);
}

TEST(PatchContainer, OpensAsItsBytesArrive) {
  const std::vector<uint8_t> bytes = three_streams().write();
  const PatchContainer whole = *open_container(bytes);
  const std::span front(bytes.data(), static_cast<size_t>(whole.header_bytes));
  PatchContainer short_of_a_byte;
  EXPECT_FALSE(open_front(front.first(front.size() - 1), false, short_of_a_byte).ok());
  PatchContainer not_whole;
  EXPECT_FALSE(open_front(front, true, not_whole).ok());

  PatchContainer container;
  ASSERT_TRUE(open_front(front, false, container).ok());
  EXPECT_EQ(container.total_bytes(), bytes.size());
  EXPECT_EQ(container.entries, whole.entries);
  // Memory of exactly this size: a read after the bytes that arrived would find zeros, which are no header.
  std::vector<uint8_t> memory(bytes.size());
  container.place(memory);
  for (size_t arrived = 0; arrived <= bytes.size(); ++arrived) {
    std::copy_n(bytes.begin(), arrived, memory.begin());
    ASSERT_TRUE(container.read_headers(arrived).ok());
    size_t there = 0, end = static_cast<size_t>(whole.header_bytes + whole.stitch_bytes());
    for (const StreamEntry& entry : whole.entries) there += (end += entry.stream_bytes) <= arrived ? 1 : 0;
    EXPECT_EQ(container.headers.size(), there);
  }
  EXPECT_EQ(container.headers[1].counts.face_count, 101u);

  memory[memory.size() - whole.entries[2].stream_bytes] = 'X';
  container.headers.pop_back();
  EXPECT_EQ(container.read_headers(memory.size()).place().patch, 2);
}

// A mesh whose point i is at (i, 0, -i), so that boxes tell which points they have.
Mesh line_of_points(const PatchContainer& container) {
  Mesh mesh{container.point_count(), {}, {{"POSITION", ComponentType::kFloat32, 3, false, {}}}};
  for (uint32_t point = 0; point < mesh.point_count; ++point)
    for (const float value : {static_cast<float>(point), 0.0f, -static_cast<float>(point)}) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      mesh.attributes[0].values.insert(mesh.attributes[0].values.end(), bytes, bytes + sizeof(value));
    }
  // The faces of stream 1 also use point 10, which stream 0 owns. The residue's faces use point 5.
  for (uint32_t face = 0; face < container.face_count(); ++face)
    mesh.faces.push_back(face < 100   ? std::array{0u, 1u, 2u}
                         : face < 201 ? std::array{10u, 61u, 62u}
                                      : std::array{5u, 5u, 5u});
  return mesh;
}

std::vector<uint8_t> with_boxes(const PatchContainer& container, const Mesh& decoded) {
  return with_head_section(container, HeadSection::kBoxes, write_boxes(boxes_of(container, decoded)));
}

TEST(PatchContainer, HasABoxOfEachStream) {
  const std::vector<uint8_t> plain = three_streams().write();
  const PatchContainer without = must(open_container(plain));
  EXPECT_TRUE(must(patch_boxes(without)).empty());
  const Mesh mesh = line_of_points(without);
  std::vector<uint8_t> bytes = with_boxes(without, mesh);
  EXPECT_EQ(bytes.size(), plain.size() + 2 + 24 + 3 * 6);
  const PatchContainer container = must(open_container(bytes));
  EXPECT_EQ(container.entries, without.entries);
  EXPECT_EQ(container.head, nullptr);
  const std::vector<PatchBox> boxes = must(patch_boxes(container));
  ASSERT_EQ(boxes.size(), 3u);
  const double step = 113.0 / 255;
  const double ends[3][2] = {{0, 59}, {10, 113}, {5, 5}};
  for (size_t i = 0; i < 3; ++i)
    for (const size_t axis : {size_t{0}, size_t{2}}) {
      const double low = axis == 0 ? ends[i][0] : -ends[i][1], high = axis == 0 ? ends[i][1] : -ends[i][0];
      EXPECT_LE(boxes[i].low[axis], low);
      EXPECT_GE(boxes[i].low[axis], low - step);
      EXPECT_GE(boxes[i].high[axis], high);
      EXPECT_LE(boxes[i].high[axis], high + step);
      EXPECT_EQ(boxes[i].low[1], 0);
      EXPECT_EQ(boxes[i].high[1], 0);
    }
  const std::vector<PatchBox> wanted = boxes_of(container, mesh);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(axis_outside(boxes[i], wanted[i]), std::nullopt);
  EXPECT_EQ(axis_outside(boxes[0], wanted[1]), 0u);
  EXPECT_EQ(axis_outside(no_box(), wanted[2]), 0u);
  EXPECT_EQ(axis_outside(no_box(), no_box()), std::nullopt);
  // Broken boxes are an error of who reads them, and of nobody else.
  const auto section = static_cast<std::ptrdiff_t>(container.header_bytes) - (24 + 3 * 6);
  std::vector<uint8_t> infinite = bytes;
  std::fill_n(infinite.begin() + section, 4, uint8_t{0xff});
  EXPECT_EQ(patch_boxes(must(open_container(infinite))).status().code(), StatusCode::kInvalidInput);
  const std::vector<uint8_t> short_section(5);
  const std::vector<uint8_t> of_five = with_head_section(without, HeadSection::kBoxes, short_section);
  EXPECT_EQ(patch_boxes(must(open_container(of_five))).status().code(), StatusCode::kInvalidInput);
}

TEST(PatchContainer, PositionsThatAreNotFiniteAreInNoBox) {
  const std::vector<uint8_t> plain = three_streams().write();
  const PatchContainer without = must(open_container(plain));
  Mesh mesh = line_of_points(without);
  const auto all_nan = [&](uint32_t first, uint32_t end) {
    std::fill(mesh.attributes[0].values.begin() + 12 * first, mesh.attributes[0].values.begin() + 12 * end,
              std::byte{0xff});
  };
  all_nan(5, 6);
  const std::vector<uint8_t> bytes = with_boxes(without, mesh);
  const std::vector<PatchBox> boxes = must(patch_boxes(must(open_container(bytes))));
  EXPECT_GE(boxes[0].high[0], 59);
  EXPECT_GT(boxes[2].low[0], boxes[2].high[0]);
  all_nan(0, mesh.point_count);
  EXPECT_TRUE(write_boxes(boxes_of(without, mesh)).empty());
}

TEST(PatchContainer, OneStreamCostsThirtyBytes) {
  const std::vector<StreamEntry> entries = {{1000, 12, 8, 0, 0}};
  const std::vector<std::vector<uint8_t>> stitch = {{}}, streams = {std::vector<uint8_t>(1000)};
  EXPECT_LE(write_container(entries, false, stitch, streams).size(), 1030u);
}

TEST(PatchContainer, RefusesEveryTruncationAndEveryExtension) {
  std::vector<uint8_t> bytes = three_streams().write();
  for_each_truncation(bytes, [](const std::vector<uint8_t>& part) {
    EXPECT_FALSE(open_container(part).ok()) << part.size();
    EXPECT_FALSE(check_directory(part).ok()) << part.size();
  });
  bytes.push_back(0);
  EXPECT_FALSE(open_container(bytes).ok());
}

TEST(PatchContainer, EveryChangedHeaderByteIsAnErrorOrAnotherDirectory) {
  const std::vector<uint8_t> bytes = three_streams().write();
  const PatchContainer original = *open_container(bytes);
  size_t opened = 0;
  for (size_t at = 0; at < original.header_bytes; ++at)
    for (int value = 0; value < 256; ++value) {
      std::vector<uint8_t> mutant = bytes;
      mutant[at] = static_cast<uint8_t>(value);
      const Expected<PatchContainer> container = open_container(mutant);
      if (!container.ok()) continue;
      ++opened;
      EXPECT_TRUE(check_directory(mutant).ok());
      const uint64_t end = container->header_bytes + container->stitch_bytes() + container->stream_bytes();
      EXPECT_EQ(end, mutant.size());
      EXPECT_EQ(container->streams.size(), container->entries.size());
      EXPECT_EQ(container->headers.size(), container->entries.size());
    }
  EXPECT_GT(opened, original.header_bytes);  // the bytes as they are, and others
}

// A change of one part, and its error.
TEST(PatchContainer, RefusesEachContradictionWithItsPatch) {
  struct Case {
    const char* message;
    int64_t patch;
    void (*change)(ContainerParts& parts);
  };
  const Case cases[] = {
      {"directory: more references than points", 1,
       [](ContainerParts& p) { p.entries[1].reference_count = 62; }},
      {"directory: more points than corners", 0, [](ContainerParts& p) { p.entries[0].point_count = 301; }},
      {"directory: a patch without faces", 0,
       [](ContainerParts& p) { p.entries[0].face_count = p.entries[0].point_count = 0; }},
      {"directory: an empty stream", 2,
       [](ContainerParts& p) { p.entries[2].stream_bytes = 0, p.streams[2].clear(); }},
      {"the stream has 100 faces, the directory says 99", 0,
       [](ContainerParts& p) { p.entries[0].face_count = 99; }},
      {"the stream has 3 faces, the directory says 4", 2,
       [](ContainerParts& p) { p.entries[2].face_count = 4; }},
      {"the stream has 9 points, the directory says 10", 2,
       [](ContainerParts& p) { p.entries[2].point_count = 10; }},
      // A residue may own no points, but its references take memory.
      {"the stream has 9 points, the directory says 1879048201", 2,
       [](ContainerParts& p) {
         p.entries[2].point_count += 0x70000000;
         p.entries[2].reference_count += 0x70000000;
       }},
      // A flag says which stream is the residue. Only the residue has no border walk.
      {"a patch is not an Edgebreaker mesh", 2,
       [](ContainerParts& p) { p.has_residue = false, p.entries[2].face_count = 3; }},
      {"a patch is not an Edgebreaker mesh", 1, [](ContainerParts& p) { p.streams[1][8] = 0; }},
      {"the residue is not a sequential mesh", 2,
       [](ContainerParts& p) {
         p.streams[2] = stream_of({true, 3, 9}, p.streams[2].size());
       }},
      {"Draco stream: not a Draco mesh", 1, [](ContainerParts& p) { p.streams[1][0] = 'd'; }},
      {"Draco stream: of bitstream 2.1, which is older than 2.2, the only one that is decoded", 0,
       [](ContainerParts& p) { p.streams[0][6] = 1; }},
  };
  for (const Case& each : cases) {
    ContainerParts parts = three_streams();
    each.change(parts);
    const Status status = open_status(parts);
    EXPECT_EQ(status.message(), each.message);
    EXPECT_EQ(status.place().patch, each.patch) << each.message;
    const bool is_version = std::string(each.message).find("bitstream") != std::string::npos;
    EXPECT_EQ(status.code(), is_version ? StatusCode::kUnsupported : StatusCode::kInvalidInput);
    const std::vector<uint8_t> bytes = parts.write();
    EXPECT_EQ(check_directory(bytes).ok(), std::string(each.message).find("directory: ") != 0) << each.message;
  }
}

// What another version of the format may have is not an error of the file.
TEST(PatchContainer, RefusesWhatIsNotKnownAsUnsupported) {
  const std::vector<uint8_t> bytes = three_streams().write();
  const auto with = [&](size_t at, int value) {
    std::vector<uint8_t> mutant = bytes;
    mutant[at] = static_cast<uint8_t>(value);
    const Status status = open_container(mutant).status();
    EXPECT_EQ(status.code(), StatusCode::kUnsupported);
    return status.message();
  };
  for (const int version : {0, 2, 255})
    EXPECT_EQ(with(4, version), "container: version " + std::to_string(version) + " is not known");
  EXPECT_EQ(with(5, 3), "container: a flag that is not known");
  EXPECT_EQ(with(6, 1), "container: codec 1 of its streams is not known; only 0 is, Draco 2.2");
  EXPECT_EQ(with(7, 1), "container: codec 256 of its streams is not known; only 0 is, Draco 2.2");
}

// A head whose sections a reader may skip changes nothing.
TEST(PatchContainer, SkipsSectionsThatItNeedNotKnow) {
  const ContainerParts parts = three_streams();
  const auto with = [&](int type) {
    std::vector<uint8_t> head;
    append_head_section(static_cast<HeadSection>(type), std::vector<uint8_t>(9), head);
    return write_container(parts.entries, true, parts.stitch, parts.streams, head);
  };
  expect_parts(with(128), parts);
  const std::vector<uint8_t> unknown = with(127);
  EXPECT_EQ(open_container(unknown).status().code(), StatusCode::kUnsupported);
}

// The counts and lengths of the header, changed one by one.
TEST(PatchContainer, RefusesPartsThatTheBytesCannotHold) {
  const std::vector<uint8_t> bytes = three_streams().write();
  const auto with = [&](size_t at, uint32_t value) {
    std::vector<uint8_t> mutant = bytes;
    for (size_t i = 0; i < 4; ++i) mutant[at + i] = static_cast<uint8_t>(value >> 8 * i);
    return open_container(mutant).status().message();
  };
  const auto rest = static_cast<uint32_t>(bytes.size() - 20);
  EXPECT_EQ(with(8, 0), "container: no streams");
  for (const uint32_t streams : {100u, 0xffffffffu})
    EXPECT_EQ(with(8, streams), "container: more streams than rows in the directory");
  for (const uint32_t directory_bytes : {rest + 1, 0xffffffffu})
    EXPECT_EQ(with(12, directory_bytes), "container: ends within the directory or the head");
  EXPECT_EQ(with(16, rest), "container: ends within the directory or the head");
  EXPECT_EQ(with(12, 1), "container: more streams than rows in the directory");
}

// A patch without its directory: no references, and the faces that its row counts.
TEST(PatchContainer, GivesEachPatchAlone) {
  const ContainerParts parts = three_streams();
  const std::vector<uint8_t> bytes = parts.write();
  const PatchContainer container = *open_container(bytes);
  for (uint32_t i = 0; i < 3; ++i) {
    const PatchContainer alone = container.alone(i);
    EXPECT_TRUE(alone.is_stock && alone.refusal.ok() && alone.is_point_count_known);
    EXPECT_EQ(alone.bytes.data(), container.streams[i].data());
    EXPECT_EQ(alone.patch_count(), 1u);
    EXPECT_EQ(alone.point_count(), parts.entries[i].point_count);
    EXPECT_EQ(alone.face_count(), parts.entries[i].face_count);
    EXPECT_EQ(alone.reference_count(), 0u);
    EXPECT_EQ(alone.headers[0].counts.face_count, container.headers[i].counts.face_count);
  }
}

TEST(PatchContainer, CountsTheFacesOfAStockStreamAndLimitsItsPoints) {
  const std::vector<uint8_t> plain = stream_of({true, 10, 8}, 100);
  const PatchContainer container = open_stream(plain);
  ASSERT_TRUE(container.refusal.ok()) << container.refusal.to_string();
  EXPECT_TRUE(container.is_stock);
  EXPECT_FALSE(container.is_point_count_known);
  EXPECT_EQ(container.face_count(), 10u);
  EXPECT_EQ(container.point_count(), 8u);
  // Each corner may have a point of its own where attributes have seams.
  const std::vector<uint8_t> with_seams = stream_of({true, 10, 8, 1}, 100);
  EXPECT_EQ(open_stream(with_seams).point_count(), 30u);
  EXPECT_LT(open_stream(with_seams).likely_point_count(0), 12u);
  PatchContainer limited = open_stream(with_seams, 20);
  EXPECT_EQ(limited.point_count(), 20u);
  EXPECT_FALSE(limited.is_point_count_known);
  limited.expect_points(11);
  EXPECT_EQ(limited.point_count(), 11u);
  EXPECT_EQ(limited.likely_point_count(0), 11u);

  const std::vector<uint8_t> sequential = stream_of({false, 2, 5}, 40);
  EXPECT_TRUE(open_stream(sequential).is_point_count_known);
  EXPECT_EQ(open_stream(sequential).point_count(), 5u);
  EXPECT_EQ(open_stream(sequential, 4).refusal.code(), StatusCode::kInvalidInput);
}

// libdraco may decode it: what the core cannot do is said, and nothing is counted.
TEST(PatchContainer, OpensStreamsThatTheCoreRefuses) {
  std::vector<uint8_t> older = stream_of({true, 10, 8}, 100);
  older[5] = 1;
  EXPECT_EQ(open_stream(older).refusal.code(), StatusCode::kUnsupported);
  EXPECT_EQ(open_stream(older).face_count(), 0u);
  EXPECT_TRUE(open_stream(older).headers.empty());
  const std::vector<uint8_t> whole = stream_of({true, 10, 8}, 18);
  for_each_truncation(whole, [](const std::vector<uint8_t>& part) {
    EXPECT_EQ(open_stream(part).refusal.code(), StatusCode::kInvalidInput) << part.size();
    EXPECT_EQ(open_stream(part).streams.size(), 1u);
  });
}

}  // namespace
}  // namespace psplit
