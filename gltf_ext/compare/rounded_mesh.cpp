#include "gltf_ext/compare/rounded_mesh.h"

#include <algorithm>
#include <cstring>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"
#include "gltf_ext/files/operating_system.h"

namespace psplit {
namespace {

constexpr size_t kPointsOfABlock = size_t{1} << 14;
constexpr size_t kBlocksOfARound = 64;  // memory is released after each

void round_values(const DeclaredGrid& grid, Attribute& attribute) {
  const size_t components = attribute.component_count;
  std::vector<float> value(components);
  for (std::byte* at = attribute.values.data(); at != attribute.values.data() + attribute.values.size();
       at += attribute.stride()) {
    std::memcpy(value.data(), at, attribute.stride());
    if (grid.direction)
      std::ranges::copy(round_direction({value[0], value[1], value[2]}, grid.bits), value.begin());
    else
      for (size_t c = 0; c < components; ++c) value[c] = round_to_step(value[c], grid, c);
    std::memcpy(at, value.data(), attribute.stride());
  }
}

struct Column {
  const MeshView::Values* from;
  const DeclaredGrid* grid;
  std::span<uint8_t> to;  // tightly packed
};

// Reads `count` values of each column from `first` on.
Mesh read_block(std::span<const Column> columns, size_t first, size_t count) {
  Mesh block;
  block.point_count = static_cast<uint32_t>(count);
  for (const Column& column : columns) {
    const ValuesView& values = column.from->values;
    Attribute& attribute = block.attributes.emplace_back(
        Attribute{column.from->semantic, values.component_type, values.component_count, false, {}});
    attribute.values.resize(count * attribute.stride());
    for (size_t i = 0; i < count; ++i)
      std::memcpy(attribute.values.data() + i * attribute.stride(), values.at(first + i), attribute.stride());
  }
  return block;
}

void round_block(std::span<const Column> columns, WeightRounding weights, size_t first, size_t count) {
  Mesh block = read_block(columns, first, count);
  std::vector<AttributeCoding> codings;
  for (size_t i = 0; i < columns.size(); ++i) {
    const DeclaredGrid& grid = *columns[i].grid;
    codings.push_back({grid.bits, grid.direction, grid.origin, grid.range});
    trim_noise(block.attributes[i]);
  }
  if (weights == WeightRounding::kTogether) round_weights(block, codings);
  for (size_t i = 0; i < columns.size(); ++i) {
    Attribute& attribute = block.attributes[i];
    round_values(*columns[i].grid, attribute);
    std::memcpy(columns[i].to.data() + first * attribute.stride(), attribute.values.data(),
                attribute.values.size());
  }
}

}  // namespace

float round_to_step(float value, const DeclaredGrid& grid,
                    size_t component) {  // the arithmetic of Draco in floats
  const float origin = grid.origin[component], most = static_cast<float>((1u << grid.bits) - 1);
  if (!(grid.range > 0)) return origin;
  return grid_place(value, origin, grid.range, grid.bits) * (grid.range / most) + origin;
}

Expected<RoundedMesh> round_to_grids(const MeshView& mesh, const std::map<std::string, DeclaredGrid>& grids,
                                     WeightRounding weights, const std::filesystem::path& folder,
                                     const ThreadPool& pool) {
  std::vector<Column> columns;
  uint64_t bytes = 0;
  for (const MeshView::Values& attribute : mesh.attributes)
    if (const auto grid = grids.find(attribute.semantic); grid != grids.end()) {
      columns.push_back({&attribute, &grid->second, {}});
      bytes += uint64_t{mesh.point_count} * attribute.values.value_bytes();
    }
  const Expected<FileMemory> memory = FileMemory::create(folder, bytes);
  if (!memory) return memory.status();
  RoundedMesh result{mesh, *memory};
  size_t offset = 0;
  for (Column& column : columns) {
    column.to = memory->bytes().subspan(offset, mesh.point_count * column.from->values.value_bytes());
    offset += column.to.size();
    MeshView::Values& values =
        result.view.attributes[static_cast<size_t>(column.from - mesh.attributes.data())];
    values.values.bytes = std::as_bytes(column.to);
    values.values.stride = 0;
  }
  constexpr size_t kPointsOfARound = kBlocksOfARound * kPointsOfABlock;
  for (size_t round = 0; round < mesh.point_count; round += kPointsOfARound) {
    const size_t end = std::min<size_t>(round + kPointsOfARound, mesh.point_count);
    pool.for_each((end - round + kPointsOfABlock - 1) / kPointsOfABlock, [&](size_t block) {
      const size_t first = round + block * kPointsOfABlock;
      round_block(columns, weights, first, std::min(kPointsOfABlock, end - first));
    });
    for (const Column& column : columns) {
      const ValuesView& from = column.from->values;
      release_mapped({reinterpret_cast<const uint8_t*>(from.at(round)), (end - round - 1) * from.step()});
      release_mapped(column.to);
    }
  }
  return result;
}

}  // namespace psplit
