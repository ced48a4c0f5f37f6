// Assets that are not in a folder: commands bring the inputs into a local folder, and take the outputs away.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include "gltf_ext/document/document.h"
#include "psplit/base.h"
#include "tools/gltf_psplit/batch/manifest.h"

namespace psplit {

// Commands of a shell, each empty if there is none.
struct StagingCommands {
  std::string fetch;         // brings input $1 (on Windows: %1), or a file that it refers to, to file $2
  std::string store;         // takes file $1 away as output $2
  std::string fetch_output;  // brings output $1 back to file $2
  std::string folder;        // for the files meanwhile; empty: in the folder of the record

  bool any() const { return !fetch.empty() || !store.empty() || !fetch_output.empty(); }
};

// Removes everything in a folder that can be removed, even read-only files. Returns whether the folder is gone.
bool remove_folder(const std::filesystem::path& folder);

// A folder for the files of one process. Next to it a lock shows that the process lives. So `open` also removes
// the folders of processes that were killed, whatever batch or shard they worked on.
class StagingFolder {
 public:
  StagingFolder() = default;
  ~StagingFolder();  // removes the folder with all that is in it
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;

  // Makes "gltf-psplit-staged-<random digits>" in `place`. Errors: as for io_error.
  Status open(const std::filesystem::path& place);
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::FILE* lock_ = nullptr;
};

// A folder for the files of one asset, which is removed with all that is in it.
class StagedAsset {
 public:
  StagedAsset(const StagingCommands& commands, std::filesystem::path folder)
      : commands_(commands), folder_(std::move(folder)) {}
  ~StagedAsset();
  StagedAsset(const StagedAsset&) = delete;
  StagedAsset& operator=(const StagedAsset&) = delete;

  // Makes the folder. Errors: as for io_error.
  Status open();
  // Runs --fetch, and returns the file, whose size and hash match the item's if it states them. kMayPass if the
  // command fails, because networks do; kIo if it exits with 66 (EX_NOINPUT of sysexits.h): there is no such
  // input.
  Expected<std::filesystem::path> fetch(const BatchItem& item) const;
  // Runs --fetch for the files without which the input cannot be read: buffers of glTF, and the material
  // libraries of an OBJ. They keep their paths below the input's folder, and only such files are brought. One
  // that --fetch does not find (66) is left to the reader. Other errors: as for `fetch`.
  Status fetch_parts(const BatchItem& item) const;
  // Fetches the other files that the document refers to, such as textures. kUnsupported for one that is not
  // below the input's folder.
  Status fetch_links(const BatchItem& item, const Document& document) const;
  // Where to write the output before it is stored.
  std::filesystem::path output(const BatchItem& item) const;
  // Runs --store, with PSPLIT_BYTES, PSPLIT_XXH128 and PSPLIT_REPLACE in its environment. PSPLIT_REPLACE is 1
  // if a batch wrote that output before, otherwise 0: then there should be no such output. With --fetch-output
  // the output is brought back, and its size and hash are compared.
  Status store(const BatchItem& item, bool replaces) const;
  // Brings an output back.
  Expected<std::filesystem::path> bring_back(const BatchItem& item) const;

 private:
  Expected<bool> fetch_beside(const BatchItem& item, const std::filesystem::path& relative) const;
  std::filesystem::path input(const BatchItem& item) const;

  const StagingCommands& commands_;
  std::filesystem::path folder_;
  bool is_open_ = false;
};

}  // namespace psplit
