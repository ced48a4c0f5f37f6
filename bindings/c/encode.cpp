// Encodes a mesh of the caller's. Without the encoder the functions say that they cannot.
#include <algorithm>

#include "bindings/c/support.h"

#ifdef PSPLIT_C_HAS_ENCODER
#include <set>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/precision_guard.h"
#include "encoder/encode_mesh.h"
#include "encoder/encode_streams.h"
#include "encoder/stock_stream.h"
#endif

#include "src/container/stream_description.h"

struct psplit_encoded {
  psplit_kind kind = PSPLIT_KIND_NONE;
  std::vector<uint8_t> bytes{};
  std::vector<psplit::AttributeRequest> requests{};
  std::vector<uint32_t> source_points{};
  uint32_t face_count = 0, patch_count = 1;
  double position_error = -1;
};

namespace psplit::c {
namespace {

constexpr int32_t kDefaultSpeed = 5;
constexpr uint32_t kDefaultPatchFaces = 30000;

void set_defaults(psplit_encode_options& options) {
  options.kind = PSPLIT_KIND_PATCHES;
  options.speed = kDefaultSpeed;
  options.patch_faces = kDefaultPatchFaces;
  options.position_bits = 14;
  options.normal_bits = 10;
  options.texcoord_bits = 12;
  options.color_bits = 8;
  options.generic_bits = 12;
}

#ifdef PSPLIT_C_HAS_ENCODER

constexpr int kExactly = -1, kMostBits = 30;

Status check_bits(const char* what, int32_t bits) {
  if (bits == kExactly || (bits >= 1 && bits <= kMostBits)) return {};
  return wrong_usage(std::string(what) + ": " + std::to_string(bits) + " bits; 1 to 30 and -1 are possible");
}

Expected<psplit_encode_options> read_options(const psplit_encode_options* from) {
  psplit_encode_options options{};
  set_defaults(options);
  if (from == nullptr) return options;
  const Expected<psplit_encode_options> read = read_struct(from, "psplit_encode_options");
  if (!read) return read.status();
  options = *read;
  if (options.kind != PSPLIT_KIND_PATCHES && options.kind != PSPLIT_KIND_DRACO)
    return wrong_usage("there is no kind " + std::to_string(options.kind) + " to encode");
  if (options.speed < 0 || options.speed > 10)
    return wrong_usage("speed " + std::to_string(options.speed) + "; 0 to 10 are possible");
  constexpr uint32_t kFlags = PSPLIT_ENCODE_KEEP_DUPLICATES | PSPLIT_ENCODE_DROP_DEGENERATE |
                              PSPLIT_ENCODE_DROP_UNUSED | PSPLIT_ENCODE_CONDENSE |
                              PSPLIT_ENCODE_WITHOUT_VERIFYING;
  const uint32_t known = options.kind == PSPLIT_KIND_PATCHES ? kFlags : 0;
  if ((options.flags & ~known) != 0)
    return wrong_usage("this kind has no flags " + std::to_string(options.flags & ~known));
  for (const auto& [what, bits] :
       {std::pair("position_bits", options.position_bits), std::pair("normal_bits", options.normal_bits),
        std::pair("texcoord_bits", options.texcoord_bits), std::pair("color_bits", options.color_bits),
        std::pair("generic_bits", options.generic_bits)})
    if (Status status = check_bits(what, bits); !status.ok()) return status;
  return options;
}

Status read_faces(const psplit_encode_source& source, Mesh& mesh) {
  const uint32_t size = source.index_size;
  if (size != 1 && size != 2 && size != 4)
    return wrong_usage("indices of " + std::to_string(size) + " bytes; 1, 2 and 4 are possible");
  if (source.indices == nullptr && source.indices_size > 0) return wrong_usage("the indices are null");
  if (source.indices_size % (size_t{3} * size) != 0)
    return wrong_usage("the bytes of the indices are not whole faces");
  const auto* bytes = static_cast<const unsigned char*>(source.indices);
  mesh.faces.resize(source.indices_size / size / 3);
  for (std::array<uint32_t, 3>& face : mesh.faces)
    for (uint32_t& point : face) {
      point = 0;
      std::memcpy(&point, bytes, size);  // little-endian
      bytes += size;
    }
  return {};
}

Expected<Attribute> read_attribute(const psplit_attribute_values& from, uint32_t point_count) {
  if (from.name == nullptr || *from.name == 0) return wrong_usage("an attribute has no name");
  if (from.reserved != 0) return wrong_usage("psplit_attribute_values: `reserved` is not 0");
  Attribute attribute;
  attribute.semantic = from.name;
  const std::optional<ComponentType> type = component_type_of(from.type);
  if (!type) return unsupported(attribute.semantic + " has the type " + std::to_string(from.type));
  if (from.components < 1 || from.components > 16)
    return unsupported(attribute.semantic + " has " + std::to_string(from.components) + " components");
  attribute.component_type = *type;
  attribute.component_count = static_cast<uint8_t>(from.components);
  attribute.normalized = from.normalized != 0;
  const size_t size = attribute.stride(), stride = from.stride == 0 ? size : from.stride;
  if (stride < size) return wrong_usage("the stride of " + attribute.semantic + " is less than its size");
  if (point_count > 0 &&
      (from.data == nullptr || from.size < size || (from.size - size) / stride < point_count - 1))
    return wrong_usage(attribute.semantic + " has no values for " + std::to_string(point_count) + " points");
  attribute.values.resize(point_count * size);
  const auto* values = static_cast<const std::byte*>(from.data);
  for (size_t point = 0; point < point_count; ++point)
    std::memcpy(&attribute.values[point * size], values + point * stride, size);
  return attribute;
}

struct Source {
  Mesh mesh;
  std::vector<AttributeCoding> codings;
};

int bits_of(int32_t bits) { return bits == kExactly ? 0 : bits; }

Expected<Source> read_source(const psplit_encode_source* from, const psplit_encode_options& options) {
  const Expected<psplit_encode_source> source = read_struct(from, "psplit_encode_source");
  if (!source) return source.status();
  const Expected<std::vector<psplit_attribute_values>> elements =
      read_array(source->attributes, source->attribute_count, "psplit_attribute_values");
  if (!elements) return elements.status();
  Source read;
  read.mesh.point_count = source->point_count;
  if (Status status = read_faces(*source, read.mesh); !status.ok()) return status;
  std::set<std::string> names;
  for (const psplit_attribute_values& element : *elements) {
    Expected<Attribute> attribute = read_attribute(element, source->point_count);
    if (!attribute) return attribute.status();
    if (!names.insert(attribute->semantic).second)
      return wrong_usage("two attributes have the name " + attribute->semantic);
    if (element.bits != 0)
      if (Status status = check_bits(attribute->semantic.c_str(), element.bits); !status.ok()) return status;
    read.mesh.attributes.push_back(std::move(*attribute));
  }
  CodingOptions usual{bits_of(options.position_bits), bits_of(options.normal_bits),
                      bits_of(options.texcoord_bits), bits_of(options.color_bits),
                      bits_of(options.generic_bits)};
  usual.give_changed_bits();
  for (size_t i = 0; i < elements->size(); ++i) {
    CodingOptions coding = usual;
    const int32_t own = (*elements)[i].bits;
    if (own != 0)
      coding.position_bits = coding.normal_bits = coding.texcoord_bits = coding.color_bits =
          coding.generic_bits = bits_of(own);
    coding.give_changed_bits();
    read.codings.push_back(choose_coding(read.mesh.attributes[i], coding));
  }
  const std::vector<AttributeCoding> chosen = read.codings;
  guard_codings(read.mesh, usual, {}, read.codings);
  for (size_t i = 0; i < elements->size(); ++i)
    if ((*elements)[i].bits != 0) read.codings[i] = chosen[i];
  // Weights are rounded together, so that they keep their sum.
  std::set<int> weight_bits;
  for (size_t i = 0; i < read.codings.size(); ++i)
    if (read.codings[i].bits > 0 && read.mesh.attributes[i].semantic.starts_with("WEIGHTS_"))
      weight_bits.insert(read.codings[i].bits);
  if (weight_bits.size() > 1) return wrong_usage("WEIGHTS_n have different bits");
  if (Status status = check_mesh(read.mesh, read.codings); !status.ok()) return status;
  round_weights(read.mesh, read.codings);
  return read;
}

EncodeOptions encode_options(const psplit_encode_options& options, size_t face_count) {
  EncodeOptions result;
  const uint64_t faces = options.patch_faces == 0 ? kDefaultPatchFaces : options.patch_faces;
  const uint64_t stated = options.patch_count > 0 ? options.patch_count : (face_count + faces / 2) / faces;
  const uint64_t count = std::clamp<uint64_t>(stated, 1, std::max<size_t>(1, face_count));
  result.patch_count = static_cast<uint32_t>(count);
  result.encode_speed = options.speed;
  result.keep_duplicates = (options.flags & PSPLIT_ENCODE_KEEP_DUPLICATES) != 0;
  result.drop_degenerate = (options.flags & PSPLIT_ENCODE_DROP_DEGENERATE) != 0;
  result.drop_unused = (options.flags & PSPLIT_ENCODE_DROP_UNUSED) != 0;
  result.condense = (options.flags & PSPLIT_ENCODE_CONDENSE) != 0;
  result.verify = (options.flags & PSPLIT_ENCODE_WITHOUT_VERIFYING) == 0;
  return result;
}

Expected<std::unique_ptr<psplit_encoded>> encode_stock(const Source& source, int32_t speed) {
  if (source.mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  Expected<StockStream> stream = encode_stock_stream(source.mesh, source.codings, speed);
  if (!stream) return stream.status();
  auto encoded = std::make_unique<psplit_encoded>();
  encoded->kind = PSPLIT_KIND_DRACO;
  encoded->bytes = std::move(stream->bytes);
  encoded->requests = std::move(stream->requests);
  encoded->source_points = std::move(stream->source_point);
  encoded->face_count = static_cast<uint32_t>(stream->decoded.faces.size());
  return encoded;
}

Expected<std::unique_ptr<psplit_encoded>> encode_patches(const Source& source,
                                                         const psplit_encode_options& options) {
  const Expected<Threads> threads = Threads::of(options.pool, options.threads);
  if (!threads) return threads.status();
  const size_t face_count = source.mesh.faces.size();
  EncodeOptions encode = encode_options(options, face_count);
  std::atomic<size_t> done = 0;
  if (options.progress != nullptr)
    encode.patch_encoded = [&](size_t faces) { options.progress(options.user, done += faces, face_count); };
  Expected<EncodedMesh> mesh = encode_mesh(source.mesh, source.codings, encode, threads->pool());
  if (!mesh) return mesh.status();
  auto encoded = std::make_unique<psplit_encoded>();
  encoded->kind = PSPLIT_KIND_PATCHES;
  encoded->bytes = std::move(mesh->container);
  encoded->requests = std::move(mesh->requests);
  encoded->source_points = std::move(mesh->source_point);
  encoded->face_count = static_cast<uint32_t>(mesh->decoded.faces.size());
  encoded->patch_count = static_cast<uint32_t>(mesh->entries.size());
  encoded->position_error = mesh->statistics.position_error.value_or(-1);
  return encoded;
}

Expected<std::unique_ptr<psplit_encoded>> encode(const psplit_encode_source* from,
                                                 const psplit_encode_options* stated) {
  const Expected<psplit_encode_options> options = read_options(stated);
  if (!options) return options.status();
  const Expected<Source> source = read_source(from, *options);
  if (!source) return source.status();
  return options->kind == PSPLIT_KIND_DRACO ? encode_stock(*source, options->speed)
                                            : encode_patches(*source, *options);
}

#else

Expected<std::unique_ptr<psplit_encoded>> encode(const psplit_encode_source*, const psplit_encode_options*) {
  return unsupported("this library was built without its encoder");
}

#endif

}  // namespace
}  // namespace psplit::c

using namespace psplit;
using namespace psplit::c;

int32_t psplit_has_encoder() {
#ifdef PSPLIT_C_HAS_ENCODER
  return 1;
#else
  return 0;
#endif
}

void psplit_encode_options_init(psplit_encode_options* options) {
  if (options == nullptr) return;
  psplit_encode_options value{};
  set_defaults(value);
  (void)write_struct(options, value, "psplit_encode_options");
}

psplit_code psplit_encode(const psplit_encode_source* source, const psplit_encode_options* options,
                          psplit_encoded** encoded, psplit_error* error) {
  return make_handle(encoded, error, [&] { return encode(source, options); });
}
void psplit_encoded_free(psplit_encoded* encoded) { delete encoded; }

psplit_code psplit_encoded_get_info(const psplit_encoded* encoded, psplit_encoded_info* info,
                                    psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (encoded == nullptr) return null_handle();
    psplit_encoded_info value{};
    value.kind = encoded->kind;
    value.data = encoded->bytes.data();
    value.size = encoded->bytes.size();
    value.point_count = static_cast<uint32_t>(encoded->source_points.size());
    value.face_count = encoded->face_count;
    value.patch_count = encoded->patch_count;
    value.attribute_count = static_cast<uint32_t>(encoded->requests.size());
    value.source_points = encoded->source_points.data();
    value.position_error = encoded->position_error;
    return write_struct(info, value, "psplit_encoded_info");
  });
}

psplit_code psplit_encoded_get_attribute(const psplit_encoded* encoded, uint32_t attribute,
                                         psplit_attribute_request* request, psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (encoded == nullptr) return null_handle();
    if (attribute >= encoded->requests.size())
      return wrong_usage("there is no attribute " + std::to_string(attribute));
    const AttributeRequest& found = encoded->requests[attribute];
    psplit_attribute_request value{};
    value.unique_id = found.unique_id;
    value.name = found.semantic.c_str();
    value.type = static_cast<psplit_type>(stored_type(found.component_type));
    value.components = found.component_count;
    value.normalized = found.normalized;
    return write_struct(request, value, "psplit_attribute_request");
  });
}
