// Point clouds have the bytes of libdraco's encoder.
#include "encoder/stream/cloud_stream.h"

#include <cstring>
#include <limits>
#include <map>
#include <random>

#include "encoder/coding/quantization.h"
#include "encoder/stream/draco_encoder.h"
#include "src/mesh/number_of.h"
#include "tests/support/draco_oracle.h"
#include "tests/support/draco_subject.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

constexpr draco::DataType kCloudTypes[] = {draco::DT_INT8,   draco::DT_UINT8, draco::DT_INT16,
                                           draco::DT_UINT16, draco::DT_INT32, draco::DT_UINT32,
                                           draco::DT_FLOAT32};
constexpr Pattern kCloudPatterns[] = {Pattern::kSmooth, Pattern::kRandom, Pattern::kConstant,
                                      Pattern::kFew,    Pattern::kWide,   Pattern::kEnds};
using Method = std::optional<CloudMethod>;
constexpr Method kAny, kTree = CloudMethod::kTree, kSequential = CloudMethod::kSequential;

// The cloud as a caller of encode_as_draco builds it.
DracoMesh labelled(const Subject& subject) {
  DracoMesh cloud;
  cloud.mesh.point_count = subject.point_count;
  for (const Values& values : subject.attributes) {
    const DracoLabel label{static_cast<DracoSemantic>(values.role), static_cast<DataType>(values.type)};
    Attribute& attribute = cloud.mesh.attributes.emplace_back();
    attribute.semantic = std::to_string(cloud.labels.size());
    attribute.component_type = component_type_of(label.type).value();
    attribute.component_count = static_cast<uint8_t>(values.component_count);
    attribute.normalized = values.normalized;
    attribute.values.resize(values.bytes.size());
    if (!values.bytes.empty()) std::memcpy(attribute.values.data(), values.bytes.data(), values.bytes.size());
    cloud.labels.push_back(label);
    cloud.share_values.push_back(0);
  }
  return cloud;
}

// Streams by their method, and of trees by their level.
struct CloudCounts {
  size_t sequential = 0, refused = 0;
  std::map<int, size_t> trees;
};

void expect_same_cloud(const Subject& subject, Method method, int speed, std::span<const int> bits,
                       CloudCounts& seen) {
  SCOPED_TRACE(subject.name + ", speed " + std::to_string(speed) +
               (!method           ? ""
                : method == kTree ? ", as a tree"
                                  : ", sequential"));
  const int number = !method           ? kAuto
                     : method == kTree ? draco::POINT_CLOUD_KD_TREE_ENCODING
                                       : draco::POINT_CLOUD_SEQUENTIAL_ENCODING;
  const auto expected = encode_cloud(*build(subject), number, speed, bits);
  std::vector<AttributeCoding> codings;
  for (const int of_attribute : bits) codings.push_back({of_attribute, false, {}, 0});
  const Expected<LabelledStream> made =
      encode_cloud_as_draco(labelled(subject), std::move(codings), method, speed);
  if (made.status().code() == StatusCode::kUnsupported) {
    ++seen.refused;
    ASSERT_FALSE(expected && decode_cloud_with_libdraco(*expected)) << made.status().message();
    return;
  }
  ASSERT_EQ(made.status().ok(), expected.has_value()) << made.status().message();
  if (!expected) {
    ++seen.refused;
    return;
  }
  constexpr size_t kMethod = 8;
  if ((*expected)[kMethod] == draco::POINT_CLOUD_KD_TREE_ENCODING)
    ++seen.trees[std::min(10 - speed, 6)];
  else
    ++seen.sequential;
  EXPECT_EQ(made->point_count, subject.point_count);
  ASSERT_TRUE(made->bytes == *expected);
}

// Compares clouds of every method and speed.
void expect_same_clouds(const Subject& subject, std::span<const int> bits, CloudCounts& seen) {
  for (int speed = 0; speed <= 10; ++speed)
    for (const Method method : {kAny, kSequential, kTree})
      expect_same_cloud(subject, method, speed, bits, seen);
}

Subject cloud_of(const std::string& name, uint32_t point_count) {
  Subject subject{.name = name + " of " + std::to_string(point_count), .point_count = point_count};
  return subject;
}

TEST(CloudStream, CloudsOfEverySizeHaveTheBytesOfLibdraco) {
  CloudCounts seen;
  for (const uint32_t count : {1u, 2u, 3u, 7u, 63u, 64u, 65u, 128u, 129u, 1000u, 100'000u})
    for (const Pattern pattern : kCloudPatterns) {
      if (count > 1000 && pattern != Pattern::kRandom && pattern != Pattern::kFew) continue;
      Subject subject = cloud_of("positions", count);
      subject.welded = pattern == Pattern::kFew;
      add(subject, Role::POSITION, draco::DT_FLOAT32, 3, pattern);
      if (count > 1000) {
        for (const int speed : {0, 5, 7, 9, 10}) expect_same_cloud(subject, kAny, speed, std::array{14}, seen);
        continue;
      }
      expect_same_clouds(subject, std::array{11}, seen);
      add(subject, Role::NORMAL, draco::DT_FLOAT32, 3, Pattern::kRandom);
      add(subject, Role::COLOR, draco::DT_UINT8, 4, pattern);
      expect_same_clouds(subject, std::array{14, 10, 8}, seen);
    }
  for (int level = 0; level <= 6; ++level) EXPECT_GT(seen.trees[level], 100u) << level;
  EXPECT_GT(seen.sequential, 500u);
}

TEST(CloudStream, GridsOfEveryNumberOfBitsHaveTheBytesOfLibdraco) {
  CloudCounts seen;
  for (int bits = 1; bits <= 30; ++bits) {
    Subject subject = cloud_of("bits", 150);
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, bits % 2 == 0 ? Pattern::kRandom : Pattern::kEnds);
    add(subject, Role::GENERIC, draco::DT_FLOAT32, 1 + bits % 5, Pattern::kSmooth);
    add(subject, Role::NORMAL, draco::DT_FLOAT32, 3, Pattern::kRandom);
    for (int speed = 0; speed < 10; ++speed)
      expect_same_cloud(subject, kTree, speed, std::array{bits, bits, 31 - bits}, seen);
    // libdraco counts symbols in a table of all of them.
    if (bits <= 18)
      expect_same_cloud(subject, kSequential, bits % 11, std::array{bits, bits, std::max(bits, 2)}, seen);
  }
}

TEST(CloudStream, ValuesOfEveryTypeHaveTheBytesOfLibdraco) {
  CloudCounts seen;
  for (const draco::DataType type : kCloudTypes)
    for (const Pattern pattern : kCloudPatterns)
      for (const int components : {1, 2, 3, 4, 7, 15, 16}) {
        Subject subject = cloud_of("type " + std::to_string(type) + " x " + std::to_string(components), 130);
        add(subject, Role::GENERIC, type, components, pattern);
        const std::array bits{type == draco::DT_FLOAT32 ? 12 : 0};
        for (const int speed : {0, 4, 5, 7, 9, 10}) {
          expect_same_cloud(subject, kTree, speed, bits, seen);
          if (pattern != Pattern::kWide || draco::DataTypeLength(type) < 4)
            expect_same_cloud(subject, kAny, speed, bits, seen);
        }
      }
  EXPECT_GT(seen.trees[6], 100u);
}

// Of several attributes, and of more than the 15 axes that level 6 can name.
TEST(CloudStream, CloudsOfManyAttributesHaveTheBytesOfLibdraco) {
  CloudCounts seen;
  for (const int components : {5, 12, 13, 40, 100}) {
    Subject subject = cloud_of("axes", 100);
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kRandom);
    add(subject, Role::GENERIC, draco::DT_INT16, components, Pattern::kSmooth);
    expect_same_clouds(subject, std::array{11, 0}, seen);
  }
  Subject subject = cloud_of("all types", 500);
  for (const draco::DataType type : kCloudTypes) add(subject, Role::GENERIC, type, 1, Pattern::kSmooth);
  add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kSmooth);
  add(subject, Role::TEX_COORD, draco::DT_FLOAT32, 2, Pattern::kRandom);
  add(subject, Role::POSITION, draco::DT_UINT16, 3, Pattern::kRandom);
  expect_same_clouds(subject, std::array{0, 0, 0, 0, 0, 0, 9, 11, 12, 0}, seen);
  // A float that is not quantized needs the sequential method.
  const size_t refused = seen.refused;
  expect_same_clouds(subject, std::array{0, 0, 0, 0, 0, 0, 0, 11, 12, 0}, seen);
  EXPECT_EQ(seen.refused, refused + 11);
}

// An origin and a range of the caller's, with values on both sides.
TEST(CloudStream, GivenGridsHaveTheBytesOfLibdraco) {
  for (const bool is_sequential : {false, true})
    for (int speed = 0; speed <= 10; ++speed) {
      SCOPED_TRACE(std::to_string(speed) + (is_sequential ? " sequential" : " tree"));
      Subject subject = cloud_of("given grid", 300);
      add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kRandom);
      const auto expected = encode_cloud(
          *build(subject),
          {.speed = speed, .sequential = is_sequential, .given_grid = true, .bits = {11, 0, 0, 0, 0}});
      ASSERT_TRUE(expected);
      const auto made =
          must(encode_cloud_as_draco(labelled(subject), {{11, false, {0.25f, 0.25f, 0.25f}, 1.5f}},
                                     is_sequential ? kSequential : kTree, speed));
      EXPECT_TRUE(made.bytes == *expected);
    }
}

// Any attributes, with values that repeat bits of others. libdraco decodes what it encoded.
TEST(CloudStream, RandomCloudsHaveTheBytesOfLibdraco) {
  std::mt19937 random(7);
  const auto below = [&](uint32_t bound) { return static_cast<uint32_t>(random() % bound); };
  CloudCounts seen;
  for (int i = 0; i < 600; ++i) {
    Subject subject = cloud_of("random " + std::to_string(i), 1 + below(below(10) == 0 ? 3000 : 200));
    subject.welded = below(2) == 0;
    std::vector<int> bits;
    for (uint32_t count = 1 + below(4); count > 0; --count) {
      const draco::DataType type = kCloudTypes[below(std::size(kCloudTypes))];
      add(subject, static_cast<Role>(below(5)), type, static_cast<int>(1 + below(5)), Pattern::kRandom);
      if (subject.attributes.back().role == Role::NORMAL && type != draco::DT_FLOAT32)
        subject.attributes.back().role = Role::GENERIC;
      if (subject.attributes.back().role == Role::NORMAL) {
        subject.attributes.pop_back();
        add(subject, Role::NORMAL, type, 3, Pattern::kRandom);
      }
      // Clusters and lines: some bits repeat the value before.
      if (type != draco::DT_FLOAT32 && below(2) == 0) {
        const auto mask = static_cast<uint8_t>(random());
        std::vector<uint8_t>& bytes = subject.attributes.back().bytes;
        for (size_t at = 8; at < bytes.size(); ++at)
          bytes[at] = static_cast<uint8_t>((bytes[at] & mask) | (bytes[at - 8] & ~mask));
      }
      const int most = below(2) == 0 ? 24 : 8;
      bits.push_back(type != draco::DT_FLOAT32 ? 0 : 2 + static_cast<int>(below(static_cast<uint32_t>(most))));
    }
    expect_same_cloud(subject, kTree, static_cast<int>(below(11)), bits, seen);
  }
  for (int level = 0; level <= 6; ++level) EXPECT_GT(seen.trees[level], 20u) << level;
}

Mesh one_attribute(ComponentType type, std::span<const std::byte> bytes, uint32_t point_count) {
  Mesh cloud{point_count, {}, {{"POSITION", type, 1, false, {}}}};
  cloud.attributes[0].values.assign(bytes.begin(), bytes.end());
  return cloud;
}

// libdraco's encoder crashes without points, and takes the rest to streams that its decoder refuses.
TEST(CloudStream, WhatNoStreamHoldsIsAnError) {
  const auto fails = [](StatusCode code, const DracoMesh& cloud, int bits, Method method,
                        const std::string& text) {
    std::vector<AttributeCoding> codings(cloud.mesh.attributes.size(), AttributeCoding{bits, false, {}, 0});
    const Status status = encode_cloud_as_draco(cloud, std::move(codings), method, 5).status();
    EXPECT_EQ(status.code(), code) << status.message();
    EXPECT_NE(status.message().find(text), std::string::npos) << status.message();
  };
  const auto cloud_with = [](DataType type, auto... values) {
    const std::array all{values...};
    DracoMesh cloud{one_attribute(component_type_of(type).value(), std::as_bytes(std::span(all)),
                                  static_cast<uint32_t>(all.size())),
                    {{DracoSemantic::kPosition, type}},
                    {0}};
    return cloud;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kMost = std::numeric_limits<float>::max();
  const DracoMesh floats = cloud_with(DataType::kFloat32, 1.0f, 2.0f);
  for (const Method method : {kAny, kTree, kSequential}) {
    DracoMesh none = floats;
    none.mesh.point_count = 0;
    none.mesh.attributes[0].values.clear();
    fails(StatusCode::kInvalidInput, none, 11, method, "without points");
    fails(StatusCode::kInvalidInput, DracoMesh{{3, {}, {}}, {}, {}}, 11, method, "without attributes");
    DracoMesh more = floats;
    more.mesh.point_count = 3;
    fails(StatusCode::kInvalidInput, more, 11, method, "another number of points");
    more.mesh.point_count = 0xffffffff;
    fails(StatusCode::kUnsupported, more, 11, method, "too many");
    fails(StatusCode::kInvalidInput, cloud_with(DataType::kFloat32, 1.0f, kNan), 11, method, "not finite");
    fails(StatusCode::kInvalidInput, cloud_with(DataType::kFloat32, kMost, -kMost), 11, method, "not finite");
    fails(StatusCode::kInvalidInput, floats, 31, method, "more than 30 bits");
  }
  fails(StatusCode::kInvalidInput, floats, 0, kTree, "only on a grid");
  // Of signed numbers in a tree, differences are stored.
  const DracoMesh apart = cloud_with(DataType::kInt32, -1, 0x7fffffff);
  fails(StatusCode::kUnsupported, apart, 0, kTree, "2^31 and more apart");
  EXPECT_TRUE(encode_cloud_as_draco(cloud_with(DataType::kInt32, 0, 0x7fffffff), {{}}, kTree, 5));
  // Of unsigned ones not: a tree has all of them.
  EXPECT_TRUE(encode_cloud_as_draco(cloud_with(DataType::kUint32, 0u, 0xffffffffu), {{}}, kTree, 5));
  fails(StatusCode::kInvalidInput, cloud_with(DataType::kUint32, 0u, 0xffffffffu), 0, kSequential, "2^31 - 1");
}

}  // namespace
}  // namespace psplit
