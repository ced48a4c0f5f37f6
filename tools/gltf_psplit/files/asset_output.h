// The output of commands that write an asset.
#pragma once

#include <string>

#include "gltf_ext/document/document.h"
#include "psplit/document.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// Logs which files are missing, and which were renamed. Each line begins with `prefix`.
void log_written(const WriteReport& report, const Log& log, const std::string& prefix = "");
// Appends the same as JSON: "images" and "warnings" of an asset.
void append_written(Json& object, const WriteReport& report);

// Checks that the output and, if `report` is not empty, the report can be written; that the report replaces
// neither a file of the input nor the output, which becomes the first file of `written`; and that the output
// replaces no file of the input, unless --force was given. Without `document`, only the input's own file
// counts.
Status check_paths(const std::string& input, const Document* document, const std::string& output,
                   const std::string& report, const Session& session, WriteReport& written,
                   OutputForms forms = OutputForms::kGltf);
// Reads the input of a command that makes one asset of another, between these checks without and with the
// document. read_input describes the rest.
Expected<Document> read_for_output(const std::string& input, const std::string& output,
                                   const std::string& report, const Session& session, WriteReport& written,
                                   const std::string& backend = "auto", const std::filesystem::path& spool = {},
                                   OutputForms forms = OutputForms::kGltf,
                                   PointClouds clouds = PointClouds::kRefuse, const OriginChoice& origin = {});
// Writes the document, and logs what `written` then reports. Errors: as for write_document, with the file.
Status write_asset(const Document& document, const std::string& output, WriteOptions options,
                   const Session& session, WriteReport& written);
// Writes the JSON of --report with what append_written adds. kUsage if that would replace a written file.
Status write_asset_report(Json report, const std::string& path, const Session& session,
                          const WriteReport& written);

}  // namespace psplit
