// The lists of extensions that a document uses.
#pragma once

#include <optional>
#include <string>

#include "gltf_ext/document/document.h"

namespace psplit {

// Whether `list`, "extensionsUsed" or "extensionsRequired", has the name.
bool lists_extension(const Json& json, const char* list, const char* name);

// Adds `name` to extensionsUsed. If `required` is true, also adds it to extensionsRequired. Joins the Draco
// extensions of the list (join_draco_extensions).
void list_extension(Document& document, const char* name, bool required);

// Adds `name` to extensionsRequired if it is required, and removes it if it is not. No effect on a document
// that does not use the extension.
void require_extension(Document& document, const char* name, bool required);

// If a list has both Draco extensions, they get adjacent places, stock Draco first, where the first of them
// was. So a document that is condensed and expanded again has its original lists.
void join_draco_extensions(Document& document);

// Removes an extension from every object that has it, and from both lists, with the accessors and buffer views
// that nothing else uses. Returns the number of objects; nothing if the document does not name the extension.
std::optional<size_t> drop_extension(Document& document, const std::string& name);

// Removes `name` from both lists if no object of the document has that extension.
void unlist_unused_extension(Document& document, const char* name);

}  // namespace psplit
