#include "gltf_ext/convert/encode_job.h"

#include "src/mesh/select_points.h"

namespace psplit {

EncodeOptions EncodeDocumentOptions::of_meshes() const {
  EncodeOptions options = *this;
  if (!condenses()) options.condense = Condense::kNo;
  if (storage == Storage::kOneStream) return options;
  options.storage = compat == Compat::kKhr                            ? Storage::kStreams
                    : patches.always || fallback == Fallback::kCoarse ? Storage::kContainer
                                                                      : Storage::kAsFits;
  if (compat == Compat::kKhr && patches.most == 0) options.patches.most = kMostPatchPrimitives;
  return options;
}

void EncodeJob::add_equal_targets() {
  for (const auto& [name, stored] : equal_targets) {
    const auto request = std::ranges::find(encoded.requests, stored, &AttributeRequest::semantic);
    AttributeRequest same = *request;
    same.semantic = name;
    encoded.codings.push_back(encoded.codings[static_cast<size_t>(request - encoded.requests.begin())]);
    encoded.requests.push_back(std::move(same));
    for (EncodedPiece& piece : encoded.pieces) {
      Attribute copy = *piece.decoded.find(stored);
      copy.semantic = name;
      piece.decoded.attributes.push_back(std::move(copy));
    }
  }
}

void EncodeJob::note_storage() {
  stored_as = encoded.is_in_container() ? StoredAs::kPatches
              : piece_count() == 1      ? StoredAs::kDraco
                                        : StoredAs::kPatchPrimitives;
  stored_bytes = 0;
  for (const EncodedPiece& piece : encoded.pieces) stored_bytes += piece.size();
}

void EncodeJob::report(PrimitiveReport& report) {
  report.stored_as = stored_as;
  report.bytes = stored_bytes;
  for (const EncodedPiece& piece : encoded.pieces) {
    report.streams.insert(report.streams.end(), piece.entries.begin(), piece.entries.end());
    report.head_bytes += piece.head_bytes;
  }
  report.has_residue = encoded.statistics.patch_count < report.streams.size();
  if (const AttributeCoding* coding = position_coding(); coding != nullptr) report.position_coding = *coding;
  report.statistics = encoded.statistics;
  report.warnings.insert(report.warnings.end(), warnings.begin(), warnings.end());
  for (const PrecisionNote& note : source.notes)
    if (!report.repeated) (note.is_warning ? report.warnings : report.notes).push_back(note.text);
}

std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point) {
  std::vector<MorphAttribute> ordered;
  for (const MorphAttribute& morph : morphs) {
    MorphAttribute& copy = ordered.emplace_back(MorphAttribute{morph.target, morph.semantic, {}, morph.sparse});
    copy.data = {morph.data.component_type,
                 morph.data.component_count,
                 morph.data.normalized,
                 static_cast<uint32_t>(source_point.size()),
                 {}};
    const size_t width = component_bytes(morph.data.component_type) * morph.data.component_count;
    copy.data.values = select_rows(morph.data.values, width, source_point);
  }
  return ordered;
}

}  // namespace psplit
