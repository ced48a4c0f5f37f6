#include "tests/support/draco_subject.h"

#include <draco/compression/expert_encode.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

namespace psplit {
namespace {

std::string describe(const PerRole& values) {
  std::string text;
  for (const int value : values) text += (text.empty() ? "" : "/") + std::to_string(value);
  return text;
}

std::unique_ptr<draco::PointAttribute> make_attribute(const Values& values, uint32_t point_count, bool welded) {
  const auto stride = static_cast<size_t>(values.component_count * draco::DataTypeLength(values.type));
  std::vector<uint32_t> value_of_point(point_count), point_of_value;
  std::map<std::string_view, uint32_t> known;
  for (uint32_t point = 0; point < point_count; ++point) {
    const auto next = static_cast<uint32_t>(point_of_value.size());
    value_of_point[point] = next;
    if (welded) {
      const auto* bytes = reinterpret_cast<const char*>(values.bytes.data() + point * stride);
      value_of_point[point] = known.try_emplace({bytes, stride}, next).first->second;
    }
    if (value_of_point[point] == next) point_of_value.push_back(point);
  }
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(values.role, static_cast<int8_t>(values.component_count), values.type, values.normalized,
                  point_of_value.size());
  for (uint32_t i = 0; i < point_of_value.size(); ++i)
    attribute->SetAttributeValue(draco::AttributeValueIndex(i),
                                 values.bytes.data() + point_of_value[i] * stride);
  attribute->SetExplicitMapping(point_count);
  for (uint32_t point = 0; point < point_count; ++point)
    attribute->SetPointMapEntry(draco::PointIndex(point), draco::AttributeValueIndex(value_of_point[point]));
  return attribute;
}

void add_metadata(draco::Mesh& mesh) {
  auto part = std::make_unique<draco::Metadata>();
  part->AddEntryIntArray("list", {1, -2, 300000});
  auto whole = std::make_unique<draco::GeometryMetadata>();
  whole->AddEntryInt("number", 7);
  whole->AddEntryDouble("ratio", 0.25);
  // Empty entries are left out, because libdraco writes them but does not read them.
  whole->AddEntryString("long", std::string(300, 'x'));
  whole->AddSubMetadata("part", std::move(part));
  mesh.AddMetadata(std::move(whole));
  for (int i = 0; i < mesh.num_attributes(); i += 2) {
    auto of_attribute = std::make_unique<draco::AttributeMetadata>();
    of_attribute->AddEntryString("name", "attribute " + std::to_string(i));
    of_attribute->AddEntryBinary("binary", {0, 255, 1});
    mesh.AddAttributeMetadata(i, std::move(of_attribute));
  }
}

// Integers use the whole range of their type. 32-bit integers do so only if they are wide; even then the length
// of the range fits a positive int32, because the encoder cannot wrap a longer one.
template <typename T>
T integer_value(double unit, bool wide) {
  double low = std::numeric_limits<T>::min(), high = static_cast<double>(std::numeric_limits<T>::max());
  if (sizeof(T) == 4) {
    const double range = wide ? 2147483646.0 : 1000000.0;
    low = std::is_unsigned_v<T> ? 0 : -range / 2;
    high = low + range;
  }
  return static_cast<T>(low + std::floor(unit * (high - low)));
}

// `encoder` is that of the cloud.
void set_attribute_options(const draco::PointCloud& cloud, const Recipe& recipe,
                           draco::ExpertEncoder& encoder) {
  auto& options = encoder.options();
  PerRole seen = {};
  for (int id = 0; id < cloud.num_attributes(); ++id) {
    const draco::PointAttribute& attribute = *cloud.attribute(id);
    const auto role = static_cast<size_t>(attribute.attribute_type());
    const int bits = recipe.bits[role] - (seen[role]++ > 0 && recipe.bits[role] > 2 ? 1 : 0);
    if (recipe.given_grid) {
      const std::vector<float> origin(static_cast<size_t>(attribute.num_components()), 0.25f);
      encoder.SetAttributeExplicitQuantization(id, bits, attribute.num_components(), origin.data(), 1.5f);
    } else if (bits > 0) {
      encoder.SetAttributeQuantization(id, bits);
    }
    // SetAttributePredictionScheme would reject some schemes that the encoder can write.
    if (recipe.scheme[role] != kAuto) options.SetAttributeInt(id, "prediction_scheme", recipe.scheme[role]);
  }
}

std::optional<std::vector<uint8_t>> bytes_of(draco::ExpertEncoder& encoder) {
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return std::nullopt;
  return std::vector<uint8_t>(buffer.data(), buffer.data() + buffer.size());
}

}  // namespace

double pattern_value(Pattern pattern, uint32_t point, int component) {
  const uint64_t at = uint64_t{point} * 8 + static_cast<uint64_t>(component) + 1;
  const double random = static_cast<double>((at * 0x9e3779b97f4a7c15u) >> 40) / (1 << 24);
  switch (pattern) {
    case Pattern::kSmooth:
      return std::abs((point * 5 + static_cast<uint32_t>(component) * 77) % 2000 / 1000.0 - 0.9995);
    case Pattern::kRandom:
    case Pattern::kWide: return random;
    case Pattern::kEnds: return std::clamp(random * 3 - 1, 0.0, 1.0);
    case Pattern::kConstant: return 0.625;
    case Pattern::kFew: return std::floor(random * 3) / 4;
  }
  return 0;
}

void add(Subject& subject, Role role, draco::DataType type, int component_count, Pattern pattern) {
  Values values{role, type, component_count, role == Role::COLOR, {}};
  const auto fill = [&](auto convert) {
    values.bytes = filled(subject.point_count, component_count, pattern, convert);
  };
  const auto fill_integers = [&]<typename T>(T) {
    fill([&](double unit) { return integer_value<T>(unit, pattern == Pattern::kWide); });
  };
  switch (type) {
    case draco::DT_INT8: fill_integers(int8_t{}); break;
    case draco::DT_UINT8: fill_integers(uint8_t{}); break;
    case draco::DT_INT16: fill_integers(int16_t{}); break;
    case draco::DT_UINT16: fill_integers(uint16_t{}); break;
    case draco::DT_INT32: fill_integers(int32_t{}); break;
    case draco::DT_UINT32: fill_integers(uint32_t{}); break;
    case draco::DT_INT64: fill_integers(int64_t{}); break;
    case draco::DT_UINT64: fill_integers(uint64_t{}); break;
    case draco::DT_FLOAT32: fill([](double unit) { return static_cast<float>(unit * 3 - 1); }); break;
    case draco::DT_FLOAT64: fill([](double unit) { return unit * 3 - 1; }); break;
    case draco::DT_BOOL: fill([](double unit) { return static_cast<uint8_t>(unit >= 0.5); }); break;
    default: break;
  }
  subject.attributes.push_back(std::move(values));
}

std::string describe(const Recipe& recipe) {
  std::string text = (recipe.sequential ? "sequential, speed " : "speed ") + std::to_string(recipe.speed);
  if (recipe.compress_indices) text += ", compressed indices";
  if (recipe.connectivity != kAuto) text += recipe.connectivity == kValence ? ", valence" : ", standard";
  if (recipe.split_on_seams != kAuto)
    text += recipe.split_on_seams ? ", split on seams" : ", not split on seams";
  if (!recipe.entropy_coding) text += ", stored values";
  if (recipe.given_grid) text += ", given grid";
  if (recipe.bits != kUsualBits) text += ", bits " + describe(recipe.bits);
  if (recipe.scheme != kAutoSchemes) text += ", schemes " + describe(recipe.scheme);
  return text;
}

std::unique_ptr<draco::Mesh> build(const Subject& subject) {
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(subject.point_count);
  mesh->SetNumFaces(subject.faces.size());
  for (uint32_t i = 0; i < subject.faces.size(); ++i) {
    const auto& face = subject.faces[i];
    mesh->SetFace(draco::FaceIndex(i),
                  {draco::PointIndex(face[0]), draco::PointIndex(face[1]), draco::PointIndex(face[2])});
  }
  for (const Values& values : subject.attributes) {
    const int id = mesh->AddAttribute(make_attribute(values, subject.point_count, subject.welded));
    mesh->attribute(id)->set_unique_id(subject.first_id + static_cast<uint32_t>(id));
    mesh->SetAttributeElementType(id, subject.element);
  }
  if (subject.metadata) add_metadata(*mesh);
  return mesh;
}

std::optional<std::vector<uint8_t>> encode(const draco::Mesh& mesh, const Recipe& recipe) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(recipe.sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                              : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(recipe.speed, recipe.speed);
  encoder.SetUseBuiltInAttributeCompression(recipe.entropy_coding);
  auto& options = encoder.options();
  options.SetGlobalBool("compress_connectivity", recipe.compress_indices);
  if (recipe.connectivity != kAuto) options.SetGlobalInt("edgebreaker_method", recipe.connectivity);
  if (recipe.split_on_seams != kAuto) options.SetGlobalBool("split_mesh_on_seams", recipe.split_on_seams != 0);
  set_attribute_options(mesh, recipe, encoder);
  return bytes_of(encoder);
}

std::optional<std::vector<uint8_t>> encode_cloud(const draco::PointCloud& cloud, const Recipe& recipe) {
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(recipe.sequential ? draco::POINT_CLOUD_SEQUENTIAL_ENCODING
                                              : draco::POINT_CLOUD_KD_TREE_ENCODING);
  encoder.SetSpeedOptions(recipe.speed, recipe.speed);
  encoder.SetUseBuiltInAttributeCompression(recipe.entropy_coding);
  set_attribute_options(cloud, recipe, encoder);
  return bytes_of(encoder);
}

std::optional<std::vector<uint8_t>> encode_cloud(const draco::PointCloud& cloud, int method, int speed,
                                                 std::span<const int> bits) {
  draco::ExpertEncoder encoder(cloud);
  if (method != kAuto) encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  for (size_t i = 0; i < bits.size(); ++i)
    if (bits[i] > 0) encoder.SetAttributeQuantization(static_cast<int>(i), bits[i]);
  return bytes_of(encoder);
}

}  // namespace psplit
