// The lists of extensions that a document uses.
#pragma once

#include <optional>
#include <string>

#include "gltf_ext/document/document.h"

namespace psplit {

// Adds `name` to extensionsUsed. If `required` is true, also adds it to extensionsRequired.
void list_extension(Document& document, const char* name, bool required);

// Adds `name` to extensionsRequired if it is required, and removes it if it is not. No effect on a document
// that does not use the extension.
void require_extension(Document& document, const char* name, bool required);

// Removes an extension from every object that has it, and from both lists, with the accessors and buffer views
// that nothing else uses. Returns the number of objects; nothing if the document does not name the extension.
std::optional<size_t> drop_extension(Document& document, const std::string& name);

// Removes `name` from both lists if no object of the document has that extension.
void unlist_unused_extension(Document& document, const char* name);

}  // namespace psplit
