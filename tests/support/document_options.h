// Options of encode_document whose members can be named where they are made: DocumentOptions{.lossless = true}.
// A struct with a base cannot.
#pragma once

#include <string>
#include <vector>

#include "psplit/decode.h"
#include "psplit/gltf.h"

namespace psplit {

struct DocumentOptions {
  PatchTarget patches{};
  int position_bits = CodingOptions().position_bits;
  int normal_bits = CodingOptions().normal_bits;
  int texcoord_bits = CodingOptions().texcoord_bits;
  int color_bits = CodingOptions().color_bits;
  int generic_bits = CodingOptions().generic_bits;
  bool position_bits_by_edges = false;
  double max_position_error = 0;
  QuantizationVolume volume = EncodeDocumentOptions().volume;
  int encode_speed = EncodeOptions().encode_speed;
  bool by_libdraco = false;
  bool lossless = false;
  bool keep_degenerate = false;
  bool keep_unused = false;
  bool keep_duplicates = false;
  std::vector<std::string> skip{};
  Fallback fallback = Fallback::kNone;
  double coarse_share = EncodeDocumentOptions().coarse_share;
  Compat compat = Compat::kNone;
  bool condense = false;
  bool verify = true;
  MeshoptRest meshopt = MeshoptRest::kNo;
  AnimationBits animation_bits{};

  operator EncodeDocumentOptions() const {  // NOLINT: implicit
    EncodeDocumentOptions options;
    options.patches = patches;
    options.position_bits = position_bits;
    options.normal_bits = normal_bits;
    options.texcoord_bits = texcoord_bits;
    options.color_bits = color_bits;
    options.generic_bits = generic_bits;
    options.position_bits_by_edges = position_bits_by_edges;
    options.max_position_error = max_position_error;
    options.volume = volume;
    options.encode_speed = encode_speed;
    options.by_libdraco = by_libdraco;
    options.lossless = lossless;
    options.keep_degenerate = keep_degenerate;
    options.keep_unused = keep_unused;
    options.keep_duplicates = keep_duplicates;
    options.skip = skip;
    options.fallback = fallback;
    options.coarse_share = coarse_share;
    options.compat = compat;
    options.condense = condense ? Condense::kFast : Condense::kNo;
    options.verify = verify;
    options.meshopt = meshopt;
    options.animation_bits = animation_bits;
    return options;
  }
};

// Each primitive as one stream of stock Draco, as `decode --to draco` writes it.
inline Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                                    EncodeDocumentOptions options,
                                                                    const ThreadPool& pool) {
  options.storage = Storage::kOneStream;
  options.keep_duplicates = true;
  return encode_document(document, options, cpu_backend(), pool);
}

}  // namespace psplit
