// Options that take a word, and options of a command's files. Their variables must outlive the parse.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "psplit/document.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace psplit {

// Takes any word, which the help calls `type`.
CLI::Option* add_word_option(CLI::App& command, const std::string& name, std::string& word,
                             const std::string& type, const std::string& text);
// Takes one of `words`. If `word` is not empty, it is the default.
CLI::Option* add_choice_option(CLI::App& command, const std::string& name, std::string& word,
                               const std::vector<std::string>& words, const std::string& text);
// Takes a word that `take` understands and keeps. If `take` returns false, the word and `refusal` are the
// error: "is no length".
CLI::Option* add_parsed_option(CLI::App& command, const std::string& name, const std::string& type,
                               const std::string& text, const std::string& refusal,
                               std::function<bool(const std::string&)> take);
// Makes an option take several values in one word, with commas between them, which the help calls `type`.
CLI::Option* separated_by_commas(CLI::Option* option, const std::string& type);

inline constexpr const char* kInputText =
    "The input: a .gltf, .glb, .drc, .ply, .obj, .stl or .off file, optionally gzipped; - reads stdin";

// The outputs that a command writes: glTF alone, or .obj, .ply, .stl and .drc as well.
enum class OutputForms { kGltf, kGltfAndMeshFiles };

void add_input_option(CLI::App& command, std::string& path);  // IN
// The output's path: the word after the input, or -o. Add the input's option first.
void add_output_option(CLI::App& command, std::string& path, OutputForms forms = OutputForms::kGltf);
void add_form_option(CLI::App& command, std::string& form);         // --as: glb or gltf
void add_images_option(CLI::App& command, WriteOptions& options);   // --images
void add_report_option(CLI::App& command, std::string& path);       // --report
void add_text_output_option(CLI::App& command, std::string& path);  // -o, for a text
void add_wide_option(CLI::App& command, bool& wide);                // --wide, for tables
void add_format_option(CLI::App& command, std::string& name,        // --format: one of `forms`
                       const std::vector<std::string>& forms = {"text", "json"});

// The value of --images that `options` came from, or "default".
std::string describe_images(const WriteOptions& options);

}  // namespace psplit
