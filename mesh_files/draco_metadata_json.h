// What a Draco stream says beside its geometry, as JSON and as names of glTF.
#pragma once

#include "gltf_ext/json/json.h"
#include "mesh_files/mesh_file.h"
#include "psplit/decode.h"

namespace psplit {

// The entries and parts of a tree, as members of one object. Draco does not store the types of values: text
// stays text, otherwise 4 bytes are an integer, 8 bytes a double if that is a usual number, and more bytes
// arrays of these. Null for an empty tree. `losses` gets the data that JSON cannot hold; `of` names the owner
// of the tree.
Json json_of_metadata(const Metadata& metadata, const std::string& of, Losses& losses);

// For each of `requests` the metadata of its attribute, or null. As for libdraco, the first of an id count.
std::vector<const Metadata*> metadata_of_attributes(const StreamMetadata& metadata,
                                                    const std::vector<AttributeRequest>& requests,
                                                    Losses& losses);

// Gives generic attributes the names that their metadata state: "attr_x" becomes _ATTR_X. `requests` come from
// gltf_attributes.
void take_names(const std::vector<const Metadata*>& of_attributes, std::vector<AttributeRequest>& requests);

}  // namespace psplit
