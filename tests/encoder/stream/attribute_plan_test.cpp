// Plans, skeletons and integers of attributes are those of libdraco's encoder: from the values of a mesh and
// the connectivity of its stream come the bytes of the stream.
#include "encoder/stream/attribute_plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/stream/attribute_values.h"
#include "tests/encoder/stream/decoded_values.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/reproducible_meshes.h"

namespace psplit {
namespace {

constexpr size_t kTraversalAt = 11;  // in a skeleton
constexpr uint8_t kValence = 2;

// The fields of a stream, with the attributes' part made from the mesh.
class MadeFields {
 public:
  MadeFields(const WeldedMesh& welded, const PatchMesh& patch, std::span<const AttributeCoding> codings,
             int speed, const EncodedPatch& encoded)
      : welded_(welded), patch_(patch), codings_(codings), speed_(speed), encoded_(encoded) {}

  DracoFields make(const DracoFields& stored) {
    DracoFields made = stored;
    must(decoded_.decode(encoded_.bytes) == core::Fault::kNone ? Status() : runtime_failure("not decoded"));
    const auto overflows = [&](size_t i) {
      return texture_prediction_may_overflow(welded_, patch_, codings_, i, speed_);
    };
    std::vector<AttributePlan> plans = plan_attributes(
        *welded_.mesh, codings_, {.speed = speed_, .point_count = static_cast<uint32_t>(patch_.points.size())},
        overflows);
    made.attributes.clear();
    std::vector<core::Attribute<uint32_t>> attributes;
    values_.resize(plans.size());
    raw_.resize(plans.size());
    for (uint32_t i = 0; i < plans.size(); ++i) attributes.push_back(take_values(i, plans[i]));
    for (uint32_t i = 0; i < plans.size(); ++i) {
      const core::Group<uint32_t>&group = group_of(i), &position_group = group_of(0);
      made.attributes.push_back(must(correct_values(
          {group, attributes[i], plans[i].scheme, plans[i].transform, &position_group, &attributes[0]})));
    }
    std::vector<uint8_t> has_seams;
    for (const std::vector<uint8_t>& seams : stored.seams)
      has_seams.push_back(std::ranges::count(seams, 1) > 0 ? 1 : 0);
    made.skeleton = edgebreaker_skeleton(plans, speed_, stored.skeleton[kTraversalAt] == kValence, has_seams);
    made.symbol_level = symbol_level_of(speed_);
    return made;
  }

 private:
  const core::Group<uint32_t>& group_of(uint32_t i) const {
    return decoded_.patch().groups[decoded_.patch().attributes[i].group];
  }

  // The values of the plan in the tables of the decoder.
  core::Attribute<uint32_t> take_values(uint32_t i, AttributePlan& plan) {
    const Attribute& source = welded_.mesh->attributes[plan.source];
    const core::Group<uint32_t>& group = group_of(i);
    std::vector<uint32_t> rows(group.table.vertex_count);
    const auto row_of = [&](uint32_t patch_point) {
      return welded_.value_of_point[plan.source][patch_.points_of_values()[patch_point]];
    };
    for (uint32_t corner = 0; corner < group.table.table.vertex.size(); ++corner)
      if (corner % 4 != 3)
        rows[group.table.table.vertex[corner]] =
            row_of(encoded_.patch_point[decoded_.patch().point_at[corner]]);
    std::vector<uint32_t> all_rows;
    for (uint32_t point = 0; point < patch_.points.size(); ++point) all_rows.push_back(row_of(point));
    core::Attribute<uint32_t> attribute = plan.description;
    if (plan.description.coding == core::Coding::kRaw) {
      std::vector<uint32_t> ordered;
      for (uint32_t k = 0; k < group.sequence.count; ++k)
        ordered.push_back(rows[group.table.table.vertex[group.sequence.corner[k]]]);
      raw_[i] = raw_values(source, ordered);
      attribute.raw = raw_[i].data();
      return attribute;
    }
    if (plan.description.coding == core::Coding::kQuantized)
      set_stream_grid(source, codings_[plan.source], all_rows, plan);
    std::vector<int32_t>& values = values_[i];
    values.resize(rows.size() * core::value_stride(attribute.value_components()));
    must(write_integers(source, plan, rows, values));
    attribute.values = {values.data(), values.size()};
    return attribute;
  }

  const WeldedMesh& welded_;
  const PatchMesh& patch_;
  const std::span<const AttributeCoding> codings_;
  const int speed_;
  const EncodedPatch& encoded_;
  DecodedValues decoded_;
  std::vector<std::vector<int32_t>> values_;
  std::vector<std::vector<uint8_t>> raw_;
};

PatchMesh whole_mesh(const Mesh& mesh) {
  PatchMesh whole;
  whole.points.resize(mesh.point_count);
  std::iota(whole.points.begin(), whole.points.end(), 0u);
  whole.faces.assign(mesh.faces.begin(), mesh.faces.end());
  return whole;
}

// Returns whether libdraco has a stream of the mesh.
bool expect_same_stream(const std::string& name, const Mesh& mesh, std::span<const AttributeCoding> codings,
                        int speed) {
  SCOPED_TRACE(name + ", speed " + std::to_string(speed));
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  const PatchMesh whole = whole_mesh(mesh);
  const Expected<EncodedPatch> encoded = encode_edgebreaker(welded, whole, codings, speed);
  if (!encoded) return false;
  const DracoFields stored = must(read_fields(encoded->bytes));
  const DracoFields made = MadeFields(welded, whole, codings, speed, *encoded).make(stored);
  EXPECT_EQ(made.skeleton, stored.skeleton);
  for (size_t i = 0; i < stored.attributes.size(); ++i) {
    EXPECT_EQ(made.attributes[i].symbols, stored.attributes[i].symbols) << "attribute " << i;
    EXPECT_EQ(made.attributes[i].raw, stored.attributes[i].raw) << "attribute " << i;
  }
  EXPECT_EQ(must(write_fields(made)), encoded->bytes);
  return true;
}

std::vector<AttributeCoding> codings_of_bits(const Mesh& mesh, int bits) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) {
    AttributeCoding coding;
    if (attribute.component_type == ComponentType::kFloat32) {
      if (attribute.semantic == "NORMAL" && bits > 1)
        coding = {bits, true, {}, 0};
      else if (Expected<AttributeCoding> grid = fit_grid(attribute, bits))
        coding = std::move(*grid);
    }
    codings.push_back(std::move(coding));
  }
  return codings;
}

TEST(AttributePlan, EveryMeshAtEverySpeedHasTheBytesOfLibdraco) {
  size_t streams = 0;
  for (const NamedMesh& named : all_meshes())
    for (const bool lossless : {false, true}) {
      const Coded coded = default_codings(named.mesh, lossless);
      for (int speed = 0; speed <= 10; ++speed)
        streams +=
            expect_same_stream(named.name + (lossless ? ", lossless" : ""), named.mesh, coded.codings, speed);
    }
  RecordProperty("streams", std::to_string(streams));
  EXPECT_GT(streams, 300u);
}

// libdraco's encoder counts symbols in tables that have an entry for every number up to the largest. So grids
// of many bits are larger than the mesh, which has the numbers of kMostWidth bits.
std::vector<AttributeCoding> codings_of_large_grids(const Mesh& mesh, int bits) {
  constexpr int kMostWidth = 18;
  std::vector<AttributeCoding> codings = codings_of_bits(mesh, bits);
  for (AttributeCoding& coding : codings)
    if (coding.octahedral)
      coding.bits = std::min(bits, kMostWidth);
    else if (bits > kMostWidth)
      coding.range = std::ldexp(coding.range, bits - kMostWidth);
  return codings;
}

TEST(AttributePlan, EveryNumberOfBitsHasTheBytesOfLibdraco) {
  size_t streams = 0;
  const Mesh sheet = make_sheet(24, 20), edges = long_edges();
  for (int bits = 1; bits <= kMostPositionBits; ++bits)
    for (const int speed : {0, 3, 5, 8})
      for (const Mesh* mesh : {&sheet, &edges})
        streams += expect_same_stream("bits " + std::to_string(bits), *mesh,
                                      codings_of_large_grids(*mesh, bits), speed);
  RecordProperty("streams", std::to_string(streams));
  EXPECT_GT(streams, 200u);
}

// libdraco stores the first of the least values, so the first zero decides the sign of the grid's origin.
TEST(AttributePlan, TheOriginIsTheFirstZero) {
  for (const float first : {0.0f, -0.0f}) {
    std::vector<float> positions;
    for (int i = 0; i < 9; ++i)
      positions.insert(positions.end(),
                       {i % 3 == 0 ? (i == 0 ? first : -first) : static_cast<float>(i % 3),
                        static_cast<float>(i / 3), -static_cast<float>(i / 3 == 0 ? 0 : i / 3)});
    const Mesh mesh = make_mesh(positions, make_grid(2, 2).faces);
    for (const int speed : {0, 5, 7})
      EXPECT_TRUE(expect_same_stream("zeros", mesh, codings_of_bits(mesh, 10), speed));
  }
}

}  // namespace
}  // namespace psplit
