// A Draco mesh stream of Edgebreaker as its fields: counts, symbols and flags without their entropy coding.
//
// read_fields takes a stream apart. write_fields puts it together again: it codes the fields exactly as
// libdraco's encoder does. So a stream of libdraco can be stored as its fields, under any model, and comes back
// bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "src/core/condensed/skeleton.h"
#include "src/core/edgebreaker_symbols.h"

namespace psplit {

// The fields of one attribute of the stream.
struct AttributeFields {
  static constexpr uint32_t kCreaseLists = 4;  // core::kMaxParallelograms

  core::SkeletonAttribute skeleton;  // what the skeleton says about it; read_fields alone sets it
  uint32_t component_bytes = 0;      // of an attribute that is stored raw; read_fields sets it
  uint32_t grid_size = 0;            // of octahedral corrections: places of a component; read_fields sets it

  uint32_t count = 0;       // values
  uint32_t components = 0;  // of each value; two for octahedral normals

  // count * components symbols in the order of the stream. They stand for corrections, or for values if the
  // attribute is not predicted. Octahedral corrections are symbols as they are. All other symbols stand for
  // signed numbers (core::signed_of_symbol). Empty if the attribute is stored raw.
  std::vector<uint32_t> symbols;
  // The bytes of an attribute that is stored raw: lossless floats and other values that are not coded.
  std::vector<uint8_t> raw;

  // The range of the wrap transform; 0 and 0 with other transforms.
  int32_t wrap_min = 0, wrap_max = 0;

  // All vectors of flags have a byte, 0 or 1, for each bit, in the order in which a decoder reads the bits.
  // Constrained multi-parallelogram: the crease flags of values with 1, 2, 3 and 4 parallelograms.
  std::array<std::vector<uint8_t>, kCreaseLists> creases;
  // Texture coordinates: whether an orientation is the same as the one before.
  std::vector<uint8_t> same_orientations;
  // Geometric normals: whether the predicted normal points the other way, one flag for each value.
  std::vector<uint8_t> flips;

  bool operator==(const AttributeFields&) const = default;
};

// All fields of a stream. AttributeFields describes vectors of flags.
struct DracoFields {
  static constexpr uint32_t kSymbolLists = 6;  // of the valence traversal, for valences 2 to 7

  // The literal bytes of the stream, in their order, without the fields: the header and the metadata, the
  // traversal's type; the number of attribute data; groups, descriptions of attributes and types of their
  // decoders; for each attribute its scheme and its transform, the flag that it is compressed, the octahedral
  // grid; the transforms of each group; bytes after the end. Streams of one primitive often have the same
  // skeleton.
  std::vector<uint8_t> skeleton;

  // The counts of the header.
  uint32_t vertex_count = 0, face_count = 0, symbol_count = 0;

  std::vector<core::SplitEvent> split_events;  // in the order of the stream
  // core::Clers in their order of decoding: symbol_count symbols, for both traversals.
  std::vector<uint8_t> symbols;
  // The valence traversal only: the lists of symbols 0 to 4 (C, S, L, R, E) in the order of the stream. They
  // have all symbols except the first. list_symbols finds them from `symbols`.
  std::array<std::vector<uint8_t>, kSymbolLists> symbol_lists;
  std::vector<uint8_t> start_faces;         // a flag for each component, in the order of decoding
  std::vector<std::vector<uint8_t>> seams;  // by attribute data: a flag for each edge between two faces

  std::vector<AttributeFields> attributes;  // in the order of the stream

  // The level of compression that libdraco's symbol encoder is told: 10 - speed. It changes the precision of
  // attributes' tables. 11 stands for versions before 1.2.5, which had no levels. Several levels may give the
  // same bytes: bit l of possible_levels says that level l does. Without any, the stream does not come back.
  // read_fields sets symbol_level to the lowest possible level. Streams of one primitive have a level in
  // common.
  int symbol_level = 0;
  uint32_t possible_levels = 0;
};

// Errors: kUnsupported for streams that have no fields: sequential meshes, other versions than 2.2, deprecated
// schemes, attributes with integers that are not entropy-coded. kInvalidInput for streams that cannot be
// decoded, and for counts that the bytes do not justify. The bytes may be anything. Thread-safe.
Expected<DracoFields> read_fields(std::span<const uint8_t> stream);

// Returns the stream that libdraco's encoder writes for these fields. Does not use possible_levels, nor
// `symbols` of a valence traversal. The fields may be anything: an error, kInvalidInput, says that they
// contradict each other. `table_bytes` gets how many of the bytes are tables of probabilities. Thread-safe.
Expected<std::vector<uint8_t>> write_fields(const DracoFields& fields, size_t* table_bytes = nullptr);

// Fills symbol_lists of a valence traversal from vertex_count, face_count, symbol_count, symbols, split_events
// and start_faces. Errors: kInvalidInput if they do not form a mesh.
Status list_symbols(DracoFields& fields);

}  // namespace psplit
