// An export of the module for Draco streams alone: their metadata, as the core walks over them. The page makes
// trees of them.
#include "bindings/web/src/decoded_stream.h"
#include "bindings/web/src/exports.h"
#include "bindings/web/src/heap.h"
#include "src/core/metadata.h"

namespace psplit::web {
namespace {

using Bytes = core::View<const uint8_t>;

// Five words for each visit: its kind, and its arguments. Bytes are an address and a number.
class MetadataWords : public core::MetadataVisitor {
 public:
  void attribute(uint32_t unique_id) { add(kAttribute, unique_id); }
  void geometry() { add(kGeometry); }
  void begin(Bytes name) { add(kBegin, address(name), size(name)); }
  void entry(Bytes name, Bytes value) { add(kEntry, address(name), size(name), address(value), size(value)); }
  void end(uint32_t part_count) { add(kEnd, part_count); }

  const uint32_t* words() const { return words_; }
  uint32_t count() const { return count_; }

 private:
  enum Visit : uint32_t { kAttribute, kGeometry, kBegin, kEntry, kEnd };

  static uint32_t address(Bytes bytes) { return reinterpret_cast<uint32_t>(bytes.data()); }
  static uint32_t size(Bytes bytes) { return static_cast<uint32_t>(bytes.size()); }
  void add(Visit visit, uint32_t first = 0, uint32_t second = 0, uint32_t third = 0, uint32_t fourth = 0) {
    if (words_ == nullptr || !resize(words_, (count_ + 5) * sizeof *words_)) __builtin_trap();
    for (const uint32_t word : {uint32_t{visit}, first, second, third, fourth}) words_[count_++] = word;
  }

  // Nothing else is allocated while it grows.
  uint32_t* const words_ = static_cast<uint32_t*>(allocate_last(1));
  uint32_t count_ = 0;
};

}  // namespace

// The address of the words of MetadataWords, which the caller releases, and their number. The stream has `size`
// bytes, and has metadata.
PSPLIT_WEB_EXPORT(stream_metadata)
const uint32_t* stream_metadata(const DecodedStream* stream, size_t size) {
  static uint32_t result[2];
  MetadataWords visitor;
  core::ByteReader reader(stream->bytes(), size);
  core::StreamFront front;
  (void)core::read_front(reader, front);
  (void)core::walk_metadata(reader, visitor);  // it had no fault when the stream was decoded
  result[0] = reinterpret_cast<uint32_t>(visitor.words());
  result[1] = visitor.count();
  return result;
}

}  // namespace psplit::web
