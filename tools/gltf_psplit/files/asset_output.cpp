#include "tools/gltf_psplit/files/asset_output.h"

#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
void log_written(const WriteReport& report, const Log& log, const std::string& prefix) {
  for (const std::string& note : report.notes) log.note(prefix + note);
  for (const std::string& warning : report.warnings) log.warning(prefix + warning);
}

void append_written(Json& object, const WriteReport& report) {
  object["images"] = {
      {"embedded", report.embedded_images}, {"copied", report.copied_images}, {"bytes", report.image_bytes}};
  object["warnings"] = report.warnings;
}

Status check_paths(const std::string& input, const Document* document, const std::string& output,
                   const std::string& report, const Session& session, WriteReport& written, OutputForms forms) {
  Status status = check_output_paths(output, report, session.force, forms);
  if (status.ok()) status = check_not_in_place(output, input, document, session.force);
  if (status.ok())
    status = document != nullptr ? check_not_an_input(report, "--report", *document)
                                 : check_not_an_input(report, "--report", {&input, 1});
  written.files = {output};
  return status.ok() ? check_not_an_output(report, "--report", written) : std::move(status);
}

Expected<Document> read_for_output(const std::string& input, const std::string& output,
                                   const std::string& report, const Session& session, WriteReport& written,
                                   const std::string& backend, const std::filesystem::path& spool,
                                   OutputForms forms, PointClouds clouds, const OriginChoice& origin) {
  Status status = check_paths(input, nullptr, output, report, session, written, forms);
  if (!status.ok()) return status;
  Expected<Document> document = [&] {
    ProgressBar bar("reading", session.log);
    return read_input(input, session, backend, FileAccess::kMap, spool, bar.callback("byte"), clouds, origin);
  }();
  if (!document) return document;
  status = check_paths(input, &*document, output, report, session, written, forms);
  if (!status.ok()) return status;
  return document;
}

Status write_asset(const Document& document, const std::string& output, WriteOptions options,
                   const Session& session, WriteReport& written) {
  options.replace_read_only = session.force;
  if (Status status = write_document(document, output, options, &written); !status.ok())
    return std::move(status).at({.file = output});
  log_written(written, session.log);
  return {};
}

Status write_asset_report(Json report, const std::string& path, const Session& session,
                          const WriteReport& written) {
  append_written(report, written);
  if (Status status = check_not_an_output(path, "--report", written); !status.ok()) return status;
  return write_text(path, report_text(report), session.if_read_only());
}

}  // namespace psplit
