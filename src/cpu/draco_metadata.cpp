#include <set>
#include <utility>

#include "psplit/decode.h"
#include "src/container/claims.h"
#include "src/core/draco_header.h"

namespace psplit {
namespace {

// Builds trees from the visited parts, as long as libdraco would accept them. Addresses of parts stay valid: no
// array of parts grows beyond its reserved room.
class MetadataReader : public core::MetadataVisitor {
 public:
  explicit MetadataReader(StreamMetadata& metadata) : metadata_(metadata) {}

  bool is_valid() const { return is_valid_; }

  void attribute(uint32_t unique_id) {
    metadata_.attributes.push_back({unique_id, {}});
    begin_tree(metadata_.attributes.back().metadata);
  }
  void geometry() { begin_tree(metadata_.geometry); }
  void begin(core::View<const uint8_t> name) {
    if (!is_valid_) return;
    // The next part belongs to the last part whose children are not complete.
    while (open_.back().missing == 0) open_.pop_back();
    Open& open = open_.back();
    --open.missing;
    is_valid_ = open_.size() <= kMostDepth && open.names.insert(text_of(name)).second;
    if (!is_valid_) return;
    current_ = &open.metadata->parts.emplace_back();
    current_->name = text_of(name);
  }
  // The last of several entries of one name counts.
  void entry(core::View<const uint8_t> name, core::View<const uint8_t> value) {
    is_valid_ &= !value.empty();
    if (is_valid_)
      current_->entries[text_of(name)] = std::vector<uint8_t>(value.data(), value.data() + value.size());
  }
  void end(uint32_t part_count) {
    if (part_count == 0 || !is_valid_) return;
    current_->parts.reserve(part_count);
    open_.push_back({current_, part_count, {}});
  }

 private:
  static constexpr size_t kMostDepth = 1001;  // libdraco's limit of nested parts

  struct Open {
    Metadata* metadata;
    uint32_t missing;  // of its parts
    std::set<std::string> names;
  };

  static std::string text_of(core::View<const uint8_t> name) {
    return std::string(name.data(), name.data() + name.size());
  }
  void begin_tree(Metadata& root) {
    open_.clear();
    current_ = &root;
  }

  StreamMetadata& metadata_;
  Metadata* current_ = nullptr;
  std::vector<Open> open_;
  bool is_valid_ = true;
};

}  // namespace

Expected<StreamMetadata> read_metadata(Span<const uint8_t> stream) {
  core::ByteReader reader(stream.data(), stream.size());
  core::StreamFront front;
  core::Fault fault = core::read_front(reader, front);
  if (fault == core::Fault::kNone && front.kind != core::StreamKind::kMesh &&
      front.kind != core::StreamKind::kPointCloud)
    fault = core::Fault::kNotDraco;
  if (fault != core::Fault::kNone) return status_of(fault);
  const std::pair<uint32_t, uint32_t> version(front.major, front.minor), first(1, 3), last(2, 3);
  if (version < first || version > last)
    return unsupported("Draco stream: of bitstream " + std::to_string(front.major) + "." +
                       std::to_string(front.minor) + ", whose metadata are not read");
  StreamMetadata metadata;
  if (!front.has_metadata) return metadata;
  MetadataReader visitor(metadata);
  fault = core::walk_metadata(reader, visitor);
  if (fault != core::Fault::kNone) return status_of(fault);
  if (!visitor.is_valid())
    return invalid_input(
        "Draco stream: metadata with an empty value, or that repeat a name or nest too deeply");
  return metadata;
}

}  // namespace psplit
