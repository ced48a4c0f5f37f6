#include "gltf_ext/convert/encode_reports.h"

#include "gltf_ext/primitive/geometry_bytes.h"

namespace psplit {

EncodeReports::EncodeReports(const Document& input, const SkippedPrimitives& skipped,
                             std::span<const EncodeJob> jobs, std::span<const EncodeJob> large) {
  for (const auto& [id, bytes] : geometry_bytes(input)) {
    PrimitiveReport& report = reports_[id];
    report.id = {id.first, id.second};
    report.input_bytes = report.bytes = bytes;
  }
  for (const auto& [id, reason] : skipped) reports_.at(id).skipped = reason;
  for (const std::span<const EncodeJob> read : {jobs, large})
    for (const EncodeJob& job : read)
      for (size_t i = 0; i < job.group.ids.size(); ++i) {
        PrimitiveReport& report = (*this)[job.group.ids[i]];
        report.repeated = i > 0;
        report.faces = job.face_count;
        report.points = job.point_count();
      }
}

std::vector<PrimitiveReport> EncodeReports::list() && {
  std::vector<PrimitiveReport> list;
  for (auto& [id, report] : reports_) list.push_back(std::move(report));
  return list;
}

}  // namespace psplit
