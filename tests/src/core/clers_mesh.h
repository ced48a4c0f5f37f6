// Small meshes for tests of the core's stages: decoded from a string of the letters C, L, E, R, S.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "src/core/edgebreaker.h"

namespace psplit::core {

// Symbols for decode_connectivity. A letter that is not a symbol stays invalid.
struct Letters {
  const char* at;
  uint32_t next(uint32_t) {
    switch (*at++) {
      case 'C': return kC;
      case 'L': return kL;
      case 'E': return kE;
      case 'R': return kR;
      case 'S': return kS;
      default: return 6;
    }
  }
  void added(uint32_t, uint32_t, uint32_t, uint32_t) {}
  void merged(uint32_t, uint32_t) {}
};

// Bits that are all the same: at least the first ninety.
inline RansBits same_bits(bool bit) {
  static constexpr uint8_t kOnes[] = {1, 1, 0};  // the probability of a 0 is 1 / 256; a state of one byte
  RansBits bits;
  ByteReader reader(kOnes, sizeof kOnes);
  if (bit && bits.start(reader) != Fault::kNone) __builtin_trap();
  return bits;
}

struct ClersMesh {
  // `holes` are faces that no symbol adds. If there are any, every border that waits is said to be a hole. The
  // memory is exactly what the stage says that it takes.
  // With moves_rows it is decoded as by a device.
  explicit ClersMesh(const std::string& letters, const std::vector<SplitEvent>& events = {}, uint32_t holes = 0,
                     uint32_t vertex_limit = 100, bool moves_rows = PSPLIT_MOVES_ROWS) {
    const auto count = static_cast<uint32_t>(letters.size());
    mesh.counts = {count + holes, vertex_limit, count, static_cast<uint32_t>(events.size())};
    memory_.resize(mesh.bytes(mesh.counts) + connectivity_scratch_bytes<uint16_t>(mesh.counts));
    Arena arena(memory_.data(), memory_.size());
    if (!mesh.allocate(arena)) __builtin_trap();
    RansBits start_faces = same_bits(holes > 0);
    const auto decode = [&]<bool kMovesRows>() {
      return decode_connectivity<kMovesRows>(Letters{letters.c_str()},
                                             View<const SplitEvent>(events.data(), events.size()), start_faces,
                                             arena, mesh);
    };
    fault = moves_rows ? decode.operator()<true>() : decode.operator()<false>();
  }
  ClersMesh(const ClersMesh&) = delete;

  using Face = std::array<uint32_t, 3>;
  std::vector<Face> faces() const {
    std::vector<Face> out;
    for (uint32_t c = 0; c < 4 * mesh.counts.face_count; c += 4)
      out.push_back({mesh.table.vertex[c], mesh.table.vertex[c + 1], mesh.table.vertex[c + 2]});
    return out;
  }

  // Numbers the vertices without gaps: merged ones are replaced, or all move up.
  void fill_holes() {
    mesh.fill_holes();
    mesh.find_closed_vertices(SerialLanes());
  }
  void move_up() {
    mesh.move_up(SerialLanes());
    mesh.find_closed_vertices(SerialLanes());
  }

  // The loops of the border, each from its lowest vertex.
  std::vector<std::vector<uint32_t>> borders() const {
    std::vector<std::vector<uint32_t>> loops;
    std::map<uint32_t, uint32_t> after;
    for (uint32_t c = 0; c < 4 * mesh.counts.face_count; ++c)
      if (c % 4 != 3 && mesh.table.opposite[c] == kNone<uint16_t>)
        after[mesh.table.vertex[previous(c)]] = mesh.table.vertex[next(c)];
    while (!after.empty()) {
      loops.emplace_back();
      for (auto at = after.begin(); at != after.end(); at = after.find(loops.back().back())) {
        loops.back().push_back(at->second);
        after.erase(at);
      }
      std::vector<uint32_t>& loop = loops.back();
      loop.insert(loop.begin(), loop.back());
      loop.pop_back();
    }
    return loops;
  }

  Connectivity<uint16_t> mesh;
  Fault fault = Fault::kNone;

 private:
  std::vector<uint8_t> memory_;
};

}  // namespace psplit::core
