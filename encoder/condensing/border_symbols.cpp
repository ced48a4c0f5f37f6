#include "encoder/condensing/border_symbols.h"

#include <algorithm>

#include "encoder/condensing/coded_patch.h"
#include "src/core/stitch_reader.h"

namespace psplit {
namespace {

// Calls visit(place, owner, owner's place) for each place in a run. Returns false if the part is broken.
template <typename Visit>
bool for_run_places(const PatchContainer& draco, uint32_t stream, Visit visit) {
  core::StitchRow row;
  row.bytes = {draco.stitch[stream].data(), draco.stitch[stream].size()};
  row.stream = stream;
  row.point_count = draco.entries[stream].point_count;
  row.reference_count = draco.entries[stream].reference_count;
  core::StitchReader reader(row);
  for (core::StitchReader::Run run; reader.next_run(run);)
    for (uint32_t k = 0; k < run.length; ++k) visit(run.begin + k, run.owner, run.place(k));
  return !reader.broken();
}

}  // namespace

bool BorderPart::agrees(const PatchContainer& draco, uint32_t stream, uint32_t components,
                        std::span<const BorderPart> parts) const {
  bool agree = true;
  const bool is_whole = for_run_places(draco, stream, [&](uint64_t place, uint32_t owner, uint32_t at) {
    agree = agree && place < is_own.size() && owner < parts.size() && at < parts[owner].is_own.size() &&
            parts[owner].is_own[at] != 0 &&
            std::equal(&values[place * components], &values[place * components] + components,
                       &parts[owner].values[size_t{at} * components]);
  });
  return agree && is_whole;
}

BorderPart make_border_part(const DecodedSource& source, const PatchContainer& draco, uint32_t stream,
                            uint32_t components) {
  BorderPart part;
  std::vector<bool> is_known(source.table(0).vertex_count);
  for (const uint32_t vertex : source.walk()) {
    for (uint32_t k = 0; k < components; ++k) part.values.push_back(source.number(0, vertex, k));
    if (!is_known[vertex]) part.known.push_back(vertex);
    is_known[vertex] = true;
  }
  part.is_own.assign(source.walk().size(), 1);
  for_run_places(draco, stream, [&](uint64_t place, uint32_t, uint32_t) {
    if (place < part.is_own.size()) part.is_own[place] = 0;
  });
  size_t last = part.is_own.size();
  for (size_t place = 0; place < part.is_own.size(); ++place) {
    if (part.is_own[place] == 0) continue;
    for (uint32_t k = 0; k < components; ++k) {
      const int32_t before = last < place ? part.values[last * components + k] : 0;
      part.symbols.push_back(folded_difference(part.values[place * components + k], before));
    }
    last = place;
  }
  return part;
}

}  // namespace psplit
