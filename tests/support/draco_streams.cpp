#include "tests/support/draco_streams.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <utility>

#include "encoder/libdraco/draco_types.h"
#include "tests/support/draco_subject.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// The encoder counts symbols and compares choices of parallelograms in tables with an entry for every possible
// symbol. These would take gigabytes for 30 bits.
constexpr int kMaxEntropyBits = 24;
// For many attributes of many values, tables of more bits take seconds for each stream.
constexpr int kCheapEntropyBits = 21;

Role role_of(const std::string& semantic) {
  const auto starts = [&](const char* prefix) { return semantic.starts_with(prefix); };
  if (starts("POSITION")) return Role::POSITION;
  if (starts("NORMAL")) return Role::NORMAL;
  if (starts("COLOR")) return Role::COLOR;
  if (starts("TEXCOORD")) return Role::TEX_COORD;
  return Role::GENERIC;
}

Subject subject_of(const std::string& name, const Mesh& mesh) {
  Subject subject{
      .name = name, .point_count = mesh.point_count, .faces = {mesh.faces.begin(), mesh.faces.end()}};
  for (const Attribute& attribute : mesh.attributes) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(attribute.values.data());
    subject.attributes.push_back({role_of(attribute.semantic), draco_type(attribute.component_type),
                                  attribute.component_count, attribute.normalized,
                                  std::vector<uint8_t>(bytes, bytes + attribute.values.size())});
  }
  return subject;
}

// The sets.

class Generator {
 public:
  Generator(const std::function<void(const DracoStream&)>& visit, StreamSet set)
      : visit_(visit), all_(set != StreamSet::kSmall), step_(set == StreamSet::kThird ? 3 : 1) {
    for (const std::vector<NamedMesh>* meshes : {&all_meshes(), &large_grids()})
      for (const NamedMesh& mesh : *meshes) meshes_.push_back(subject_of(mesh.name, mesh.mesh));
  }

  void run() {
    topologies();
    schemes();
    bits();
    long_edges();
    types();
    specials();
  }

 private:
  void emit(const Subject& subject, const std::vector<Recipe>& recipes) {
    const std::unique_ptr<draco::Mesh> mesh = build(subject);
    for (const Recipe& recipe : recipes) {
      if (number_++ % step_ != 0) continue;
      // Some combinations are impossible: a mesh without a face that Edgebreaker can encode, or a coordinate
      // out of a predictor's range. The decoder also rejects compressed indices in a stream of fewer than three
      // bytes per face.
      if (auto bytes = encode(*mesh, recipe);
          bytes && (!recipe.compress_indices || decode_with_libdraco(*bytes)))
        visit_(
            {subject.name + (subject.welded ? ": " : ", not welded: ") + describe(recipe), std::move(*bytes)});
    }
  }

  const Subject& mesh(std::string_view name) const {
    return *std::find_if(meshes_.begin(), meshes_.end(), [&](const Subject& s) { return s.name == name; });
  }

  // Every mesh, to cover all connectivities and seams.
  void topologies() {
    const std::vector<Recipe> few = {
        {.speed = 0},
        {.speed = 3, .connectivity = kValence},
        {.speed = 5},
        {.speed = 7, .connectivity = kValence},
        {.speed = 10, .sequential = true},
        {.speed = 6, .sequential = true, .compress_indices = true, .bits = kRawBits}};
    std::vector<Recipe> many;
    for (int speed = 0; speed <= 10; ++speed) {
      for (const int connectivity : {kStandard, kValence})
        for (const int split : {0, 1})
          many.push_back({.speed = speed, .connectivity = connectivity, .split_on_seams = split});
      if (speed % 5 == 0)
        for (const bool compress : {false, true})
          many.push_back({.speed = speed,
                          .sequential = true,
                          .compress_indices = compress,
                          .bits = compress ? kRawBits : kUsualBits});
    }
    for (Subject subject : meshes_) {
      const size_t face_count = subject.faces.size();
      if (!all_ && face_count > 3300) continue;
      const bool small = face_count <= 4000;
      emit(subject, all_ && small ? many : few);
      if (!all_ || !small) continue;
      subject.welded = false;
      emit(subject, few);
    }
  }

  // Positions, normals, texture coordinates with seams, colours and generic floats.
  Subject carrier(std::string_view name = "scene 5") const {
    Subject subject = mesh(name);
    add(subject, Role::COLOR, draco::DT_FLOAT32, 4, Pattern::kSmooth);
    add(subject, Role::GENERIC, draco::DT_FLOAT32, 2, Pattern::kSmooth);
    subject.name = "carrier " + subject.name;
    return subject;
  }

  // Every prediction scheme for every role, one role at a time.
  void schemes() {
    constexpr int kNone = draco::PREDICTION_NONE, kDifference = draco::PREDICTION_DIFFERENCE;
    constexpr int kParallelogram = draco::MESH_PREDICTION_PARALLELOGRAM;
    constexpr int kConstrained = draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM;
    constexpr int kTexcoords = draco::MESH_PREDICTION_TEX_COORDS_PORTABLE;
    constexpr int kNormals = draco::MESH_PREDICTION_GEOMETRIC_NORMAL;
    const std::pair<Role, std::vector<int>> choices[] = {
        {Role::POSITION, {kNone, kDifference, kParallelogram, kConstrained}},
        {Role::NORMAL, {kNone, kDifference, kNormals}},
        {Role::COLOR, {kNone, kDifference, kParallelogram, kConstrained}},
        {Role::TEX_COORD, {kNone, kDifference, kParallelogram, kConstrained, kTexcoords}},
        {Role::GENERIC, {kNone, kDifference, kParallelogram, kConstrained, kTexcoords}}};
    std::vector<Recipe> recipes;
    for (const auto& [role, list] : choices)
      for (const int scheme : list)
        for (const int speed : all_ ? std::vector{0, 5, 8} : std::vector{5})
          for (const int split : {0, 1})
            for (const bool entropy_coding : {true, false}) {
              Recipe recipe{.speed = speed, .split_on_seams = split, .entropy_coding = entropy_coding};
              recipe.scheme[static_cast<size_t>(role)] = scheme;
              recipes.push_back(recipe);
            }
    emit(carrier(), recipes);
    if (!all_) return;
    emit(carrier("scene 4"), recipes);
    emit(carrier("texture seams across a grid"), recipes);
    emit(carrier("moebius strip with seams"), recipes);
    emit(carrier("soup with seams"), recipes);
  }

  // Every number of quantization bits, one role at a time, and explicit grids.
  void bits() {
    std::vector<Recipe> recipes;
    std::vector<int> depths = {1, 2, 4, 8, 11, 16, 20, 24, 30};
    if (all_) {
      depths.resize(30);
      std::iota(depths.begin(), depths.end(), 1);
    }
    for (size_t role = 0; role < kRoleCount; ++role)
      for (const int depth : depths)
        for (const int speed : all_ ? std::vector{0, 3, 7} : std::vector{2}) {
          if (depth == kUsualBits[role] || (role == Role::NORMAL && depth == 1)) continue;
          if (depth > kMaxEntropyBits && speed < 2) continue;
          const int most = all_ || role == Role::POSITION ? kMaxEntropyBits : kCheapEntropyBits;
          Recipe recipe{.speed = speed, .entropy_coding = depth <= most};
          recipe.bits[role] = depth;
          recipes.push_back(recipe);
        }
    for (const int speed : {1, 3, 5, 7, 9}) {
      recipes.push_back({.speed = speed, .given_grid = true});
      recipes.push_back({.speed = speed, .bits = kRawBits});
    }
    emit(carrier(), recipes);
  }

  // Edges as long as the grid, on fine grids: predictions are outside the grid, and with 30 bits outside int32.
  void long_edges() {
    Subject subject = mesh("torus");
    subject.name += ", long edges";
    subject.attributes.clear();
    subject.welded = false;
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kEnds);
    add(subject, Role::NORMAL, draco::DT_FLOAT32, 3, Pattern::kRandom);
    add(subject, Role::TEX_COORD, draco::DT_FLOAT32, 2, Pattern::kEnds);
    add(subject, Role::GENERIC, draco::DT_FLOAT32, 4, Pattern::kEnds);
    std::vector<int> depths = {18, 21, 24, 28, 30};
    if (all_) {
      depths.resize(16);
      std::iota(depths.begin(), depths.end(), 15);
    }
    std::vector<Recipe> recipes;
    for (const int depth : depths)
      for (const int speed : {0, 1, 2, 4, 6, 8, 10}) {
        if (depth > kCheapEntropyBits && speed < 2) continue;
        if (!all_ && depth == kCheapEntropyBits && speed != 4) continue;
        // The values of all roles are far apart.
        Recipe recipe{.speed = speed, .entropy_coding = depth <= kCheapEntropyBits};
        recipe.bits = {depth, depth, depth, depth, depth};
        recipes.push_back(recipe);
      }
    emit(subject, recipes);

    // Texture coordinates that are predicted from such edges overflow 64 bits. libdraco refuses to encode some
    // of these meshes. Depending on its version, it decodes the others or refuses them.
    const uint32_t quads = all_ ? 40 : 12;
    for (uint32_t seed = 0; seed < quads; ++seed) {
      subject = {.name = "long edges of a quad " + std::to_string(seed),
                 .point_count = 4,
                 .faces = {{0, 1, 2}, {2, 1, 3}}};
      uint32_t state = seed;
      const auto ends = [&](double) {
        state = state * 1664525 + 1013904223;
        return std::clamp(static_cast<float>(state >> 8) / 6e6f - 0.9f, 0.0f, 1.0f);
      };
      subject.attributes = {
          {Role::POSITION, draco::DT_FLOAT32, 3, false, filled(4, 3, Pattern::kRandom, ends)},
          {Role::TEX_COORD, draco::DT_FLOAT32, 2, false, filled(4, 2, Pattern::kRandom, ends)}};
      emit(subject, {{.speed = 0, .bits = {21, 10, 8, 21, 12}},
                     {.speed = 3, .entropy_coding = false, .bits = {17, 10, 8, 29, 12}},
                     {.speed = 3, .bits = {21, 10, 8, 12, 12}}});
    }
  }

  // Generic attributes of every type and number of components.
  void types() {
    std::vector<Recipe> recipes = {{.speed = 1},
                                   {.speed = 5, .bits = kRawBits},
                                   {.speed = 9, .split_on_seams = 0, .entropy_coding = false}};
    std::vector<Recipe> wide;
    for (const int scheme : {-2, 0, 1})
      wide.push_back({.entropy_coding = false, .scheme = {kAuto, kAuto, kAuto, kAuto, scheme}});
    if (all_)
      recipes.insert(recipes.end(), {{.speed = 0},
                                     {.speed = 3, .connectivity = kValence},
                                     {.speed = 8},
                                     {.sequential = true},
                                     {.sequential = true, .compress_indices = true, .entropy_coding = false}});
    struct Choice {
      Pattern pattern;
      const char* name;
      bool in_small;
    };
    constexpr Choice kChoices[] = {{Pattern::kSmooth, "smooth", true},
                                   {Pattern::kRandom, "random", true},
                                   {Pattern::kConstant, "constant", false},
                                   {Pattern::kFew, "few", false},
                                   {Pattern::kWide, "wide", true}};
    for (const char* name : {"moebius strip with seams", "book with seams", "torus"}) {
      for (int type = draco::DT_INT8; type < draco::DT_TYPES_COUNT; ++type)
        for (const int component_count : all_ ? std::vector{1, 2, 3, 4, 5, 16} : std::vector{1, 3, 16})
          for (const Choice& choice : kChoices) {
            const bool is_wide_type = type == draco::DT_INT32 || type == draco::DT_UINT32;
            const bool is_wide = choice.pattern == Pattern::kWide;
            if (!(all_ || choice.in_small) || (is_wide && !is_wide_type)) continue;
            Subject subject = mesh(name);
            add(subject, Role::GENERIC, static_cast<draco::DataType>(type), component_count, choice.pattern);
            subject.name +=
                ", " + std::to_string(component_count) + " x type " + std::to_string(type) + ", " + choice.name;
            emit(subject, is_wide ? wide : recipes);
          }
      if (!all_) break;
    }
  }

  // Cases that no other set covers: unusual attributes, orders and sizes. It is long because it is a list.
  void specials() {
    const std::vector<Recipe> several = {
        {.speed = 0}, {.speed = 3, .connectivity = kValence}, {.speed = 5}, {.speed = 7}, {.sequential = true}};
    const std::vector<Recipe> split = {{.speed = 0, .split_on_seams = 1},
                                       {.speed = 4, .connectivity = kValence, .split_on_seams = 1},
                                       {.speed = 8, .split_on_seams = 1},
                                       {.sequential = true}};
    const auto emit_as = [&](Subject subject, const char* name, const std::vector<Recipe>& recipes) {
      subject.name += std::string(", ") + name;
      emit(subject, recipes);
    };

    Subject subject = carrier();
    subject.metadata = true;
    subject.first_id = 300;
    emit_as(subject, "metadata", several);

    subject = carrier();
    subject.element = draco::MESH_VERTEX_ATTRIBUTE;
    emit_as(subject, "attributes of vertices", several);
    subject.element = draco::MESH_FACE_ATTRIBUTE;
    emit_as(subject, "attributes of faces", several);

    subject = carrier();
    std::reverse(subject.attributes.begin(), subject.attributes.end());
    emit_as(subject, "positions last", several);

    subject = carrier();
    add(subject, Role::NORMAL, draco::DT_FLOAT32, 3, Pattern::kRandom);
    add(subject, Role::TEX_COORD, draco::DT_FLOAT32, 2, Pattern::kSmooth);
    add(subject, Role::TEX_COORD, draco::DT_UINT16, 2, Pattern::kRandom);
    add(subject, Role::TEX_COORD, draco::DT_FLOAT32, 3, Pattern::kSmooth);
    add(subject, Role::COLOR, draco::DT_UINT8, 4, Pattern::kFew);
    add(subject, Role::GENERIC, draco::DT_INT32, 1, Pattern::kRandom);
    emit_as(subject, "several of a kind", several);

    for (const auto& [name, pattern] :
         {std::pair{"random normals", Pattern::kRandom}, {"few normals", Pattern::kFew}}) {
      subject = mesh("every corner a seam");
      add(subject, Role::NORMAL, draco::DT_FLOAT32, 3, pattern);
      emit_as(subject, name, several);
      for (Recipe recipe : several) {
        recipe.entropy_coding = false;
        recipe.bits[Role::NORMAL] = 30;
        emit_as(subject, name, {recipe});
      }
    }
    // The speed is above 4: otherwise libdraco treats integers as octahedral coordinates, and reads past their
    // end.
    for (const draco::DataType type : {draco::DT_INT8, draco::DT_INT16}) {
      subject = mesh("every corner a seam");
      add(subject, Role::NORMAL, type, 3, Pattern::kRandom);
      emit_as(subject, type == draco::DT_INT8 ? "normals of 8 bits" : "normals of 16 bits",
              {{.speed = 5}, {.speed = 7}});
    }

    // Positions of every type and number of components. Normals and texture coordinates can be predicted only
    // from 32-bit triples; with other positions libdraco writes streams that it cannot read.
    for (int type = draco::DT_INT8; type <= draco::DT_FLOAT64; ++type)
      for (const int component_count : {3, 1, 2, 4}) {
        subject = mesh("hard-edged cube");
        if (all_) subject = mesh("moebius strip with seams");
        std::erase_if(subject.attributes, [](const Values& values) { return values.role == Role::POSITION; });
        const bool is_parent =
            component_count == 3 && draco::DataTypeLength(static_cast<draco::DataType>(type)) <= 4;
        if (!is_parent) subject.attributes.clear();
        add(subject, Role::POSITION, static_cast<draco::DataType>(type), component_count, Pattern::kSmooth);
        std::rotate(subject.attributes.begin(), subject.attributes.end() - 1, subject.attributes.end());
        subject.name += ", positions " + std::to_string(component_count) + " x type " + std::to_string(type);
        emit(subject, {{.speed = 1}, {.speed = 5}, {.sequential = true}});
        subject.welded = false;
        emit(subject, {{.speed = 0, .connectivity = kValence}, {.speed = 3, .connectivity = kValence}});
      }

    // Without a single position attribute, all attributes must share one connectivity.
    subject = mesh("moebius strip with seams");
    subject.attributes[0].role = Role::GENERIC;
    emit_as(subject, "no positions", split);
    subject = mesh("moebius strip with seams");
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kSmooth);
    emit_as(subject, "two positions", split);

    subject = mesh("grid");
    subject.attributes.clear();
    emit_as(subject, "no attributes", {{.sequential = true}});
    subject = {.name = "nothing"};
    add(subject, Role::POSITION, draco::DT_FLOAT32, 3, Pattern::kSmooth);
    emit(subject, {{.sequential = true,
                    .bits = kRawBits}});  // quantization would read the first value, which does not exist

    subject = mesh("book with seams");
    for (int i = 0; i < 100; ++i)
      add(subject, Role::GENERIC, draco::DT_UINT8, 1 + i % 3, static_cast<Pattern>(i % 4));
    emit_as(subject, "100 attributes", {{.speed = 2}, {.speed = 7}});
    if (all_) giants();
  }

  void giants() {
    // Raw symbols that need the most precise probabilities: four components have many values, and twelve have
    // one value. The tagged coding would have to write all of them equally wide.
    for (const int value_bits : {14, 17}) {
      Subject subject = mesh("65,536 points");
      Values values{Role::GENERIC, draco::DT_INT32, 16, false, {}};
      uint32_t state = 1;
      values.bytes = filled(subject.point_count, 4, Pattern::kConstant, [&](double) {
        state = state * 1664525 + 1013904223;
        return std::array{static_cast<int32_t>(state >> (32 - value_bits)), 0, 0, 0};
      });
      subject.attributes.push_back(std::move(values));
      subject.name += ", symbols of " + std::to_string(value_bits) + " bits";
      for (const int speed : {0, 4, 5, 7}) {
        Recipe recipe{.speed = speed};
        recipe.scheme[Role::GENERIC] = draco::PREDICTION_NONE;
        emit(subject, {recipe});
      }
    }

    // From 2^21 points on, indices have four bytes.
    Subject subject = {.name = "2,097,153 points", .point_count = (1u << 21) + 1};
    for (uint32_t i = 0; 3 * i < subject.point_count; ++i)
      subject.faces.push_back({3 * i, (3 * i + 1) % subject.point_count, (3 * i + 2) % subject.point_count});
    add(subject, Role::POSITION, draco::DT_UINT8, 1, Pattern::kFew);
    emit(subject, {{.sequential = true}});
  }

  const std::function<void(const DracoStream&)>& visit_;
  const bool all_;
  const size_t step_;
  size_t number_ = 0;
  std::vector<Subject> meshes_;
};

}  // namespace

void for_each_draco_stream(const std::function<void(const DracoStream&)>& visit, StreamSet set) {
  Generator(visit, set).run();
}

const std::vector<DracoStream>& small_draco_streams() {
  static const std::vector<DracoStream> made = [] {
    std::vector<DracoStream> streams;
    for_each_draco_stream([&](const DracoStream& stream) { streams.push_back(stream); }, StreamSet::kSmall);
    return streams;
  }();
  return made;
}

}  // namespace psplit
