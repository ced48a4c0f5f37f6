// A condensed stream, in the order of its bytes. Begin to read here. Specification: "condensed streams"
// (gltf_ext/PSPLIT_mesh_draco_patches).
//
// It says the same as a Draco stream, in fewer bytes: what the streams of a container have in common is in the
// container's head. There are skeletons, the literal bytes of Draco streams without counts, symbols and values
// (skeleton.h), and models, the probabilities of symbols (models.h). The stream has the rest, in sections:
//
//   byte 0                                                                                     the last byte
//   | attribute 1          | attribute 2          | ... | first section                                    |
//   | words ->    <- bits  | words ->    <- bits  |     | words ->                                 <- bits |
//
// A section has 16-bit words of an entropy coder from its front, and plain bits from its back (section.h). The
// first section comes last, so that its bits begin at the end of the stream, which is known. In it are, in the
// order in which they are read:
//
//   numbers         plain bits    counts, split events, which attributes have seams, the lengths of the other
//                                 sections, ranges of values (condensed_header.h, condensed_numbers.h)
//   border part     words, bits   the values of attribute 0 that this stream owns at its border (border_part.h)
//   symbols         words         Edgebreaker's C, S, L, R, E in contexts (context_symbols.h)
//   seams           words         a bit for each inner edge and attribute with seams (seam_steps.h)
//   attribute 0     words, bits   tokens, the high bits of corrections in words, and their low bits
//                                 (token_steps.h); then flags of its prediction (condensed_attributes.h)
//
// Each other attribute has a section of its own, which is like the part of attribute 0. A decoder so reads all
// attributes at once. Only the attributes of deltas share four sections, which follow those (deltas.h).
// Corrections are those of the Draco stream in its order, or those of values in order of creation (creation.h).
// encoder/fields/expand.h makes the Draco stream again; encoder/condensing/condense.h makes condensed streams.
#pragma once

#include "src/core/condensed/section.h"

namespace psplit::core {

// The bytes of the stream and the shared models; both must outlive it. The stream's numbers are plain bits of
// its first section, which is the last one in the bytes: the places say from which bit on a decoder reads them.
struct CondensedStream {
  View<const uint8_t> bytes;  // empty for a Draco stream
  CondensedModels models;
  uint32_t attribute_count = 0;
  uint32_t traversed_count = 0;     // attributes that are not in order of creation
  uint32_t delta_row_count = 0;     // attributes of deltas that are not 0 everywhere
  uint32_t split_symbol_count = 0;  // of S
  uint32_t interior_count = 0;      // components that end with a start face
  uint32_t component_count = 0;
  uint64_t start_faces_at = 0;  // a bit for each component, if some end with a start face and others do not
  uint64_t events_at = 0;       // split events
  uint64_t seams_at = 0;        // for each attribute data whether it has seams
  uint64_t lengths_at = 0;      // of all sections except the first, followed by the attributes' numbers
  uint64_t numbers_end = 0;     // after all numbers
  size_t first_section = 0;     // where the first section begins, after all others

  // With models.has_borders: the stream's border part has values of the first attribute at places of its border
  // walk that no other stream owns. A driver decodes the parts of all streams first (border_part.h), and then
  // sets the values at all places of this stream's walk, and its coder to the end of the part.
  uint32_t border_count = 0, border_components = 0;
  View<const int32_t> known;    // by place, border_components numbers each
  SectionReader behind_border;  // not set yet if it has no bytes

  PSPLIT_HD bool has_start_face_bits() const { return interior_count > 0 && interior_count < component_count; }
  PSPLIT_HD SectionReader numbers(uint64_t at) const {
    SectionReader reader(bytes.data(), bytes.size());
    reader.go_to_bit(at);
    return reader;
  }
};

}  // namespace psplit::core
