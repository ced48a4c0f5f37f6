#include "tests/support/draco_clouds.h"

#include <draco/compression/point_cloud/algorithms/float_points_tree_encoder.h>

#include <cstring>
#include <random>

#include "src/core/byte_reader.h"
#include "tests/support/draco_subject.h"

namespace psplit {
namespace {

constexpr draco::DataType kTypes[] = {draco::DT_INT8,   draco::DT_UINT8, draco::DT_INT16,
                                      draco::DT_UINT16, draco::DT_INT32, draco::DT_UINT32};
constexpr draco::DataType kWideTypes[] = {draco::DT_INT64, draco::DT_UINT64, draco::DT_FLOAT64, draco::DT_BOOL};
constexpr Pattern kPatterns[] = {Pattern::kSmooth, Pattern::kRandom, Pattern::kConstant,
                                 Pattern::kFew,    Pattern::kWide,   Pattern::kEnds};
constexpr int kMostLevel = 6;

template <typename T>
void append(std::vector<uint8_t>& bytes, T value) {
  const auto* first = reinterpret_cast<const uint8_t*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof value);
}

Subject cloud_of(const std::string& name, uint32_t point_count) {
  Subject subject{.name = name + " of " + std::to_string(point_count), .point_count = point_count};
  return subject;
}

class CloudGenerator {
 public:
  explicit CloudGenerator(const std::function<void(const DracoStream&)>& visit) : visit_(visit) {}

  void run() {
    sizes();
    bits();
    types();
    axes();
    old_streams();
    specials();
  }

 private:
  void emit(const Subject& subject, const Recipe& recipe) {
    if (auto bytes = encode_cloud(*build(subject), recipe); bytes && decode_cloud_with_libdraco(*bytes))
      visit_({subject.name + (subject.welded ? ": " : ", not welded: ") +
                  (recipe.sequential ? "" : "kD-tree, ") + describe(recipe),
              std::move(*bytes)});
  }
  // As kD-trees of every level, and sequentially.
  void emit_all(const Subject& subject, const Recipe& with = {}) {
    Recipe recipe = with;
    for (int level = 0; level <= kMostLevel; ++level) {
      recipe.speed = 10 - level;
      recipe.sequential = false;
      emit(subject, recipe);
    }
    recipe.sequential = true;
    for (const int speed : {0, 5, 10}) {
      recipe.speed = speed;
      emit(subject, recipe);
    }
    recipe.entropy_coding = false;
    emit(subject, recipe);
  }

  void sizes() {
    for (const uint32_t count : {1u, 2u, 3u, 4u, 5u, 63u, 64u, 65u, 200u, 3000u, 70'000u})
      for (const Pattern pattern : kPatterns) {
        if (count > 3000 && pattern != Pattern::kRandom) continue;
        Subject subject = cloud_of("positions", count);
        subject.welded = pattern == Pattern::kFew;
        add(subject, Role::POSITION, draco::DT_FLOAT32, 3, pattern);
        emit_all(subject);
        if (count > 3000) continue;
        Subject more = cloud_of("positions, normals and colours", count);
        add(more, Role::POSITION, draco::DT_FLOAT32, 3, pattern);
        add(more, Role::NORMAL, draco::DT_FLOAT32, 3, Pattern::kRandom);
        add(more, Role::COLOR, draco::DT_UINT8, 4, pattern);
        emit_all(more);
      }
  }

  void bits() {
    for (int bits = 1; bits <= 30; ++bits) {
      Subject subject = cloud_of("bits", 150);
      add(subject, Role::POSITION, draco::DT_FLOAT32, 3, bits % 2 == 0 ? Pattern::kRandom : Pattern::kEnds);
      add(subject, Role::GENERIC, draco::DT_FLOAT32, 1 + bits % 5, Pattern::kSmooth);
      // The sequential encoder would count symbols in a table of all of them.
      for (int level = bits % 2; level <= kMostLevel; level += 2)
        emit(subject, {.speed = 10 - level, .bits = {bits, bits, bits, bits, bits}});
      if (bits <= 18) emit(subject, {.sequential = true, .bits = {bits, std::max(bits, 2), bits, bits, bits}});
    }
    Subject subject = cloud_of("given grid", 300);
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kRandom);
    emit_all(subject, {.given_grid = true});
  }

  void types() {
    for (const draco::DataType type : kTypes)
      for (const Pattern pattern : kPatterns)
        for (const int components : {1, 2, 3, 4}) {
          Subject subject = cloud_of("type " + std::to_string(type) + " x " + std::to_string(components), 130);
          add(subject, Role::GENERIC, type, components, pattern);
          // A sequential encoder has a table of all symbols.
          if (pattern != Pattern::kWide || draco::DataTypeLength(type) < 4) {
            emit_all(subject);
          } else {
            for (int level = 0; level <= kMostLevel; ++level) emit(subject, {.speed = 10 - level});
          }
        }
    for (const draco::DataType type : kWideTypes) {
      Subject subject = cloud_of("type " + std::to_string(type), 130);
      add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kRandom);
      add(subject, Role::GENERIC, type, 2, Pattern::kRandom);
      emit(subject, {.sequential = true});
      emit(subject, {.sequential = true, .bits = kRawBits});
    }
  }

  // Of several attributes, and of more than the 15 axes that level 6 can name.
  void axes() {
    for (const int components : {5, 12, 13, 40, 200}) {
      Subject subject = cloud_of("axes", 100);
      add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kRandom);
      add(subject, Role::GENERIC, draco::DT_INT16, components, Pattern::kSmooth);
      emit_all(subject);
    }
    Subject subject = cloud_of("all types", 500);
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kSmooth);
    for (const draco::DataType type : kTypes) add(subject, Role::GENERIC, type, 1, Pattern::kSmooth);
    add(subject, Role::TEX_COORD, draco::DT_FLOAT32, 2, Pattern::kRandom);
    emit_all(subject);
  }

  // A kD-tree of unsigned integers in the form of bitstream 2.2, from that of 2.3: it had a method, and the
  // number of points once more.
  void emit_old(const Subject& subject, int level) {
    const auto bytes = encode_cloud(*build(subject), {.speed = 10 - level});
    if (!bytes) return;
    core::ByteReader reader(bytes->data(), bytes->size());
    reader.skip(11);
    const uint32_t point_count = reader.u32();
    reader.skip(1);
    for (uint32_t count = reader.varint(); count > 0; --count) {
      reader.skip(4);
      (void)reader.varint();
    }
    const auto at = static_cast<std::ptrdiff_t>(reader.position());
    std::vector<uint8_t> old(bytes->begin(), bytes->begin() + at);
    old[6] = 2;
    old.push_back(1);
    old.push_back((*bytes)[reader.position()]);
    append(old, point_count);
    old.insert(old.end(), bytes->begin() + at + 1, bytes->end());
    emit_if_decoded({subject.name + ": bitstream 2.2, level " + std::to_string(level), std::move(old)});
  }
  // Positions on the grid of bitstream 2.2.
  void emit_old_grid(uint32_t point_count, uint32_t bits, uint8_t level) {
    std::mt19937 random(point_count + bits + level);
    std::vector<draco::Point3f> points(point_count);
    for (draco::Point3f& point : points)
      for (int k = 0; k < 3; ++k)
        point[k] = static_cast<float>(static_cast<int32_t>(random())) * static_cast<float>(1.0 / (1u << 30));
    draco::FloatPointsTreeEncoder encoder(draco::KDTREE, bits, level);
    if (!encoder.EncodePointCloud(points.begin(), points.end())) return;
    std::vector<uint8_t> bytes = {'D', 'R', 'A', 'C', 'O', 2, 2, 0, 1, 0, 0};
    append(bytes, point_count);
    for (const int byte : {1, 1, 0, int{draco::DT_FLOAT32}, 3, 0, 7, 0, int{level}})
      bytes.push_back(static_cast<uint8_t>(byte));
    append(bytes, point_count);
    const auto* tree = reinterpret_cast<const uint8_t*>(encoder.buffer()->data());
    bytes.insert(bytes.end(), tree, tree + encoder.buffer()->size());
    emit_if_decoded({"grid of 2.2, " + std::to_string(bits) + " bits, level " + std::to_string(level) + " of " +
                         std::to_string(point_count),
                     std::move(bytes)});
  }
  void emit_if_decoded(const DracoStream& stream) {
    if (decode_cloud_with_libdraco(stream.bytes)) visit_(stream);
  }
  void old_streams() {
    for (int level = 0; level <= kMostLevel; ++level) {
      for (const draco::DataType type : {draco::DT_UINT8, draco::DT_UINT16, draco::DT_UINT32})
        for (const uint32_t count : {1u, 100u, 300u}) {
          Subject subject = cloud_of("old type " + std::to_string(type), count);
          add(subject, Role::GENERIC, type, 3, Pattern::kRandom);
          add(subject, Role::COLOR, draco::DT_UINT8, 3, Pattern::kSmooth);
          emit_old(subject, level);
        }
      for (const uint32_t bits : {1u, 5u, 12u, 20u})
        for (const uint32_t count : {1u, 2u, 200u}) emit_old_grid(count, bits, static_cast<uint8_t>(level));
    }
  }

  // Without points, and without attributes. libdraco's encoder writes neither.
  void emit_empty(bool is_kd_tree, uint8_t minor) {
    const std::string name = std::string(is_kd_tree ? "kD-tree of 2." : "sequential of 2.") + char('0' + minor);
    std::vector<uint8_t> front = {'D', 'R', 'A', 'C', 'O', 2, minor, 0, uint8_t{is_kd_tree}, 0, 0};
    std::vector<uint8_t> bytes = front;
    append(bytes, uint32_t{17});
    bytes.push_back(0);
    emit_if_decoded({name + ", no attributes", bytes});

    append(front, uint32_t{0});
    for (const int byte : {1, 1, 0, int{draco::DT_INT16}, 1, 0, 0}) front.push_back(static_cast<uint8_t>(byte));
    for (uint8_t level = 0; level <= kMostLevel; ++level) {
      bytes = front;
      if (is_kd_tree) {
        if (minor == 2) bytes.push_back(1);
        bytes.push_back(level);
        if (minor == 2) append(bytes, uint32_t{0});
        append(bytes, uint64_t{0});          // bits and points of the tree
        if (minor == 3) bytes.push_back(5);  // the lowest number
      } else {
        bytes.push_back(0);  // plain values: libdraco refuses integers without a point
      }
      emit_if_decoded({name + ", no points, level " + std::to_string(level), bytes});
      if (!is_kd_tree) break;
    }
  }

  void specials() {
    Subject subject = cloud_of("metadata", 50);
    subject.metadata = true;
    subject.first_id = 1000;
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kRandom);
    add(subject, Role::NORMAL, draco::DT_FLOAT32, 3, Pattern::kRandom);
    emit_all(subject);
    emit(subject, {.sequential = true, .bits = kRawBits});
    emit(subject, {.sequential = true, .scheme = {-2, -2, -2, -2, -2}});
    for (const bool is_kd_tree : {false, true})
      for (const uint8_t minor : {uint8_t{2}, uint8_t{3}}) emit_empty(is_kd_tree, minor);
  }

  const std::function<void(const DracoStream&)>& visit_;
};

}  // namespace

void for_each_draco_cloud(const std::function<void(const DracoStream&)>& visit) { CloudGenerator(visit).run(); }

const std::vector<DracoStream>& small_draco_clouds() {
  static const std::vector<DracoStream> clouds = [] {
    std::vector<DracoStream> small;
    for_each_draco_cloud([&](const DracoStream& stream) {
      if (stream.bytes.size() <= 4000) small.push_back(stream);
    });
    return small;
  }();
  return clouds;
}

}  // namespace psplit
