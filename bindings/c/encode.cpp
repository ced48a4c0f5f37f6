// Encodes a mesh of the caller's. Without the encoder the functions say that they cannot.
#include "bindings/c/encoded.h"
#include "bindings/c/mesh.h"
#include "bindings/c/support.h"

#ifdef PSPLIT_C_HAS_ENCODER
#include <algorithm>
#include <map>

#include "encoder/coding/choose_codings.h"
#endif

#include "psplit/encode.h"
#include "src/container/stored_type.h"
#include "src/mesh/no_indices.h"

namespace psplit::c {
namespace {

void set_defaults(psplit_encode_options& options) {
  const EncodeOptions defaults;
  options.kind = PSPLIT_KIND_NONE;
  options.speed = defaults.encode_speed;
  options.position_bits = defaults.position_bits;
  options.normal_bits = defaults.normal_bits;
  options.texcoord_bits = defaults.texcoord_bits;
  options.color_bits = defaults.color_bits;
  options.generic_bits = defaults.generic_bits;
}

#ifdef PSPLIT_C_HAS_ENCODER

constexpr int kExactly = -1;

// In the C interface, 0 means the default, and -1 means exact values.
int bits_of(int32_t bits) { return bits == kExactly ? 0 : bits; }

Status check_bits(const char* what, int32_t bits) {
  if (bits == kExactly || (bits >= 1 && bits <= kMostGridBits)) return {};
  return wrong_usage(std::string(what) + ": " + std::to_string(bits) + " bits; bits must be -1 or 1 to " +
                     std::to_string(kMostGridBits));
}

struct Options {
  psplit_encode_options stated{};
  EncodeOptions encode{};
};

Storage storage_of(psplit_kind kind) {
  return kind == PSPLIT_KIND_PATCHES ? Storage::kContainer
         : kind == PSPLIT_KIND_DRACO ? Storage::kOneStream
                                     : Storage::kAsFits;
}

Expected<Options> read_options(const psplit_encode_options* from) {
  Options options;
  psplit_encode_options& stated = options.stated;
  set_defaults(stated);
  if (from != nullptr) {
    const Expected<psplit_encode_options> read = read_struct(from, "psplit_encode_options");
    if (!read) return read.status();
    stated = *read;
  }
  if (stated.kind < PSPLIT_KIND_NONE || stated.kind > PSPLIT_KIND_DRACO)
    return wrong_usage("kind " + std::to_string(stated.kind) + " cannot be encoded");
  constexpr uint32_t kFlags = PSPLIT_ENCODE_KEEP_DUPLICATES | PSPLIT_ENCODE_KEEP_DEGENERATE |
                              PSPLIT_ENCODE_KEEP_UNUSED | PSPLIT_ENCODE_CONDENSE |
                              PSPLIT_ENCODE_WITHOUT_VERIFYING | PSPLIT_ENCODE_POINTS;
  const bool is_draco = stated.kind == PSPLIT_KIND_DRACO, is_cloud = (stated.flags & PSPLIT_ENCODE_POINTS) != 0;
  if (is_cloud && stated.kind == PSPLIT_KIND_PATCHES) return wrong_usage("a point cloud has no patches");
  const uint32_t known =
      is_draco || is_cloud ? uint32_t{PSPLIT_ENCODE_WITHOUT_VERIFYING | PSPLIT_ENCODE_POINTS} : kFlags;
  if ((stated.flags & ~known) != 0)
    return wrong_usage((is_cloud ? "a point cloud has no flags " : "this kind has no flags ") +
                       std::to_string(stated.flags & ~known));
  for (const auto& [what, bits] :
       {std::pair("position_bits", stated.position_bits), std::pair("normal_bits", stated.normal_bits),
        std::pair("texcoord_bits", stated.texcoord_bits), std::pair("color_bits", stated.color_bits),
        std::pair("generic_bits", stated.generic_bits)})
    if (Status status = check_bits(what, bits); !status.ok()) return status;
  EncodeOptions& encode = options.encode;
  encode.storage = is_cloud ? Storage::kCloud : storage_of(stated.kind);
  encode.encode_speed = stated.speed;
  encode.patches.count = stated.patch_count;
  encode.patches.always = stated.kind == PSPLIT_KIND_PATCHES;
  encode.patches.faces = stated.patch_count > 0 ? 0 : stated.patch_faces;
  encode.position_bits = bits_of(stated.position_bits);
  encode.normal_bits = bits_of(stated.normal_bits);
  encode.texcoord_bits = bits_of(stated.texcoord_bits);
  encode.color_bits = bits_of(stated.color_bits);
  encode.generic_bits = bits_of(stated.generic_bits);
  const auto has = [&](uint32_t flag) { return (stated.flags & flag) != 0; };
  encode.keep_duplicates = is_draco || has(PSPLIT_ENCODE_KEEP_DUPLICATES);  // as Draco keeps them
  encode.keep_degenerate = has(PSPLIT_ENCODE_KEEP_DEGENERATE);
  encode.keep_unused = has(PSPLIT_ENCODE_KEEP_UNUSED);
  encode.condense = has(PSPLIT_ENCODE_CONDENSE) ? Condense::kFast : Condense::kNo;
  encode.verify = !has(PSPLIT_ENCODE_WITHOUT_VERIFYING);
  return options;
}

Span<const std::byte> bytes_of(const void* data, size_t size) {
  return {static_cast<const std::byte*>(data), data == nullptr ? 0 : size};
}

Expected<ValuesView> indices_of(const psplit_encode_source& source) {
  const uint32_t size = source.index_size;
  if (size != 1 && size != 2 && size != 4)
    return wrong_usage("indices of " + std::to_string(size) + " bytes; 1, 2 and 4 are possible");
  if (source.indices == nullptr && source.indices_size > 0) return wrong_usage("the indices are null");
  if (source.indices_size % (size_t{3} * size) != 0)
    return wrong_usage("the bytes of the indices are not whole faces");
  if (source.indices_size / size > UINT32_MAX) return unsupported("more indices than 32 bits can count");
  const ComponentType type = size == 1   ? ComponentType::kUint8
                             : size == 2 ? ComponentType::kUint16
                                         : ComponentType::kUint32;
  return ValuesView{type,
                    1,
                    false,
                    static_cast<uint32_t>(source.indices_size / size),
                    bytes_of(source.indices, source.indices_size),
                    0};
}

// Adds the attribute to the view, and its bits to the codings, if it has its own.
Status read_attribute(const psplit_attribute_values& from, uint32_t point_count, MeshView& view,
                      std::map<size_t, OwnCoding>& own_codings) {
  if (from.name == nullptr || *from.name == 0) return wrong_usage("an attribute has no name");
  if (from.reserved != 0) return wrong_usage("psplit_attribute_values: `reserved` is not 0");
  const std::string name = from.name;
  const std::optional<ComponentType> type = component_type_of(from.type);
  if (!type) return unsupported(name + " has the type " + std::to_string(from.type));
  if (from.components < 1 || from.components > 16)
    return unsupported(name + " has " + std::to_string(from.components) + " components");
  if (from.bits != 0) {
    if (Status status = check_bits(from.name, from.bits); !status.ok()) return status;
    own_codings[view.attributes.size()] = {bits_of(from.bits)};
  }
  view.attributes.push_back({name,
                             {*type, static_cast<uint8_t>(from.components), from.normalized != 0, point_count,
                              bytes_of(from.data, from.size), from.stride}});
  return {};
}

Expected<MeshToEncode> read_source(const psplit_encode_source* from, bool is_cloud) {
  const Expected<psplit_encode_source> source = read_struct(from, "psplit_encode_source");
  if (!source) return source.status();
  const Expected<std::vector<psplit_attribute_values>> elements =
      read_array(source->attributes, source->attribute_count, "psplit_attribute_values");
  if (!elements) return elements.status();
  if (is_cloud && (source->indices != nullptr || source->indices_size > 0))
    return wrong_usage("a point cloud has no indices");
  const Expected<ValuesView> indices = is_cloud ? no_indices() : indices_of(*source);
  if (!indices) return indices.status();
  if (!is_cloud && indices->count == 0) return invalid_input("the mesh has no triangles");
  MeshToEncode read;
  MeshView view{source->point_count, {}, *indices};
  for (const psplit_attribute_values& element : *elements)
    if (Status status = read_attribute(element, source->point_count, view, read.own_codings); !status.ok())
      return status;
  Expected<Mesh> mesh = mesh_of(view);
  if (!mesh) return mesh.status();
  read.mesh = std::move(*mesh);
  return read;
}

// Why an attribute of a planned mesh is stored as it is: a sentence about it.
std::string reason_of(const MeshToEncode& source, size_t i, const EncodeOptions& options) {
  const Attribute& attribute = source.mesh.attributes[i];
  const AttributeCoding& coding = source.codings[i];
  const std::string& name = attribute.semantic;
  for (const PrecisionNote& note : source.notes)
    if (note.text.starts_with(name) && (note.text[name.size()] == ' ' || note.text[name.size()] == ':'))
      return note.text;
  const auto own = source.own_codings.find(i);
  const bool has_own = own != source.own_codings.end();
  const int wanted = has_own ? own->second.bits : wanted_bits(attribute, options);
  if (attribute.component_type != ComponentType::kFloat32) return name + " is kept exactly: it has integers";
  const std::string bits = std::to_string(coding.bits) + (coding.bits == 1 ? " bit" : " bits");
  if (coding.bits == 0) {
    if (target_of(name)) return name + " is kept exactly, as the values that it changes";
    if (wanted > 0)
      return name + " is kept exactly: no grid of " + std::to_string(wanted) + " bits has its values";
    if (!has_own && wanted_bits(attribute, {}) == 0) return name + " is kept exactly: it names features";
    return name + " is kept exactly, as its bits say";
  }
  if (coding.exact) return name + " is kept exactly, on a grid of " + bits + " that has all of its values";
  if (target_of(name)) return name + " gets " + bits + ", with the step of the values that it changes";
  const char* const grid = coding.octahedral ? ", on an octahedron" : "";
  return name + " gets " + bits + grid + (has_own ? ", as its own bits say" : ", as the options say");
}

Expected<std::unique_ptr<psplit_encoded>> encode(const psplit_encode_source* from,
                                                 const psplit_encode_options* stated) {
  const Expected<Options> options = read_options(stated);
  if (!options) return options.status();
  const Expected<Threads> threads = Threads::of(options->stated.pool, options->stated.threads);
  if (!threads) return threads.status();
  const bool is_cloud = options->encode.storage == Storage::kCloud;
  Expected<MeshToEncode> source = read_source(from, is_cloud);
  if (!source) return source.status();
  MeshToEncode* const planned[] = {&*source};
  if (Status status = plan(planned, options->encode, threads->pool()); !status.ok()) return status;
  Watch watch;
  if (options->stated.progress != nullptr)
    watch.progress = [progress = options->stated.progress, user = options->stated.user](
                         size_t done, size_t total) { progress(user, done, total); };
  if (options->stated.stop != nullptr) watch.stop = &options->stated.stop->flag;
  std::vector<std::string> reasons;
  for (size_t i = 0; i < source->codings.size(); ++i) reasons.push_back(reason_of(*source, i, options->encode));
  Expected<EncodedMesh> mesh = psplit::encode(std::move(*source), options->encode, threads->pool(), watch);
  if (!mesh) return mesh.status();
  EncodedPiece& piece = mesh->pieces[0];
  auto encoded = std::make_unique<psplit_encoded>();
  encoded->kind = piece.is_container ? PSPLIT_KIND_PATCHES
                  : is_cloud         ? PSPLIT_KIND_DRACO_FILE
                                     : PSPLIT_KIND_DRACO;
  encoded->bytes = std::move(piece.bytes);
  encoded->requests = std::move(mesh->requests);
  for (size_t i = 0; i < encoded->requests.size(); ++i) {
    AttributeCoding& coding = mesh->codings[i];
    const Attribute& decoded = piece.decoded.attributes[i];
    ValueBounds bounds;
    bounds.add(decoded.component_type, decoded.component_count, decoded.values.data(), piece.point_count,
               decoded.stride());
    bounds.finish();
    encoded->storage.push_back(
        {coding.bits, coding.range, std::move(coding.origin), std::move(reasons[i]), std::move(bounds)});
  }
  encoded->source_points = std::move(piece.source_point);
  for (PrecisionNote& note : mesh->notes) encoded->notes.push_back(std::move(note.text));
  encoded->face_count = piece.face_count;
  encoded->patch_count = static_cast<uint32_t>(piece.entries.size());
  encoded->position_error = mesh->statistics.position_error.value_or(-1);
  return encoded;
}

#else

Expected<std::unique_ptr<psplit_encoded>> encode(const psplit_encode_source*, const psplit_encode_options*) {
  return unsupported("this library was built without its encoder");
}

#endif

}  // namespace

const OlderStreams* built_in_older_streams() {
#ifdef PSPLIT_C_HAS_ENCODER
  return older_streams();
#else
  return nullptr;
#endif
}

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
    value.note_count = static_cast<uint32_t>(encoded->notes.size());
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

const char* psplit_encoded_note(const psplit_encoded* encoded, uint32_t note) {
  return encoded == nullptr || note >= encoded->notes.size() ? nullptr : encoded->notes[note].c_str();
}

psplit_code psplit_encoded_get_quantization(const psplit_encoded* encoded, uint32_t attribute,
                                            psplit_quantization* quantization, psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (encoded == nullptr) return null_handle();
    if (attribute >= encoded->storage.size())
      return wrong_usage("there is no attribute " + std::to_string(attribute));
    const psplit_encoded::Storage& found = encoded->storage[attribute];
    psplit_quantization value{};
    value.bits = found.bits;
    value.range = found.range;
    value.origin_count = static_cast<uint32_t>(found.origin.size());
    value.origin = found.origin.empty() ? nullptr : found.origin.data();
    return write_struct(quantization, value, "psplit_quantization");
  });
}

const char* psplit_encoded_reason(const psplit_encoded* encoded, uint32_t attribute) {
  return encoded == nullptr || attribute >= encoded->storage.size()
             ? nullptr
             : encoded->storage[attribute].reason.c_str();
}
