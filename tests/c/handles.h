// The C interface for tests in C++: handles that free themselves, and meshes that are decoded through it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "psplit/decode.h"
#include "psplit/psplit.h"
#include "src/container/stored_type.h"
#include "tests/src/loader/buffers.h"

namespace psplit {

template <typename Struct>
Struct init() {
  Struct made;
  PSPLIT_INIT(made);
  return made;
}

struct FreeHandle {
  void operator()(psplit_mesh* handle) const { psplit_mesh_free(handle); }
  void operator()(psplit_gltf* handle) const { psplit_gltf_free(handle); }
  void operator()(psplit_pool* handle) const { psplit_pool_free(handle); }
  void operator()(psplit_stop* handle) const { psplit_stop_free(handle); }
  void operator()(psplit_encoded* handle) const { psplit_encoded_free(handle); }
  void operator()(psplit_output* handle) const { psplit_output_free(handle); }
};
template <typename T>
using Handle = std::unique_ptr<T, FreeHandle>;

// Requests whose names live in `requests`.
inline std::vector<psplit_attribute_request> c_requests(std::span<const AttributeRequest> requests) {
  std::vector<psplit_attribute_request> made;
  for (const AttributeRequest& request : requests) {
    made.push_back(init<psplit_attribute_request>());
    made.back().unique_id = request.unique_id;
    made.back().name = request.semantic.c_str();
    made.back().type = static_cast<psplit_type>(stored_type(request.component_type));
    made.back().components = request.component_count;
    made.back().normalized = request.normalized;
  }
  return made;
}

struct Opened {
  psplit_code code = PSPLIT_OK;
  psplit_error error = init<psplit_error>();
  Handle<psplit_mesh> mesh{};
};
inline Opened open_bytes(psplit_kind kind, std::span<const uint8_t> bytes,
                         std::span<const AttributeRequest> requests = {}, uint32_t flags = 0) {
  const std::vector<psplit_attribute_request> attributes = c_requests(requests);
  auto source = init<psplit_source>();
  source.kind = kind;
  source.data = bytes.data();
  source.size = bytes.size();
  source.attributes = attributes.data();
  source.attribute_count = static_cast<uint32_t>(attributes.size());
  source.flags = flags;
  Opened opened;
  psplit_mesh* mesh = nullptr;
  opened.code = psplit_mesh_open(&source, &mesh, &opened.error);
  opened.mesh.reset(mesh);
  EXPECT_EQ(opened.code == PSPLIT_OK, mesh != nullptr);
  EXPECT_EQ(opened.code, opened.error.code);
  EXPECT_EQ(opened.code == PSPLIT_OK, opened.error.text[0] == 0);
  return opened;
}
inline Handle<psplit_mesh> must_open(psplit_kind kind, std::span<const uint8_t> bytes,
                                     std::span<const AttributeRequest> requests = {}, uint32_t flags = 0) {
  Opened opened = open_bytes(kind, bytes, requests, flags);
  EXPECT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
  return std::move(opened.mesh);
}

inline psplit_mesh_info info_of(const psplit_mesh* mesh) {
  auto info = init<psplit_mesh_info>();
  EXPECT_EQ(psplit_mesh_get_info(mesh, &info, nullptr), PSPLIT_OK);
  return info;
}
inline psplit_attribute_info attribute_of(const psplit_mesh* mesh, uint32_t attribute) {
  auto info = init<psplit_attribute_info>();
  EXPECT_EQ(psplit_mesh_get_attribute(mesh, attribute, &info, nullptr), PSPLIT_OK);
  return info;
}

// The structs for buffers of a test.
struct CBuffers {
  std::vector<psplit_attribute_buffer> attributes{};
  psplit_buffers buffers = init<psplit_buffers>();

  explicit CBuffers(const PrimitiveBuffers& out) {
    for (const AttributeBuffer& buffer : out.attributes) {
      attributes.push_back(init<psplit_attribute_buffer>());
      attributes.back().data = buffer.bytes.data();
      attributes.back().size = buffer.bytes.size();
      attributes.back().stride = buffer.stride;
    }
    buffers.index_size = out.index_bytes;
    buffers.indices = out.indices.data();
    buffers.indices_size = out.indices.size();
    buffers.attributes = attributes.data();
    buffers.attribute_count = static_cast<uint32_t>(attributes.size());
  }
  CBuffers(const CBuffers&) = delete;
};

}  // namespace psplit
