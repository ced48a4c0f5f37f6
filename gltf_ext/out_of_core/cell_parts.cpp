#include "gltf_ext/out_of_core/cell_parts.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <utility>

#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffff;

template <typename T>
std::span<uint8_t> writable_bytes(T& values) {
  return {reinterpret_cast<uint8_t*>(values.data()), values.size() * sizeof(values[0])};
}

// A face of another cell uses the point.
struct Request {
  uint32_t point, cell;
};

// The points of a cell, in the order of the file.
struct CellPoints {
  std::vector<uint32_t> ids;  // ascending
  std::vector<uint8_t> records;
  std::vector<uint32_t> lowest;  // for each point the lowest of the cell that equals it

  std::optional<uint32_t> find(uint32_t id) const {
    const auto found = std::ranges::lower_bound(ids, id);
    if (found == ids.end() || *found != id) return std::nullopt;
    return static_cast<uint32_t>(found - ids.begin());
  }
};

std::vector<uint32_t> lowest_equal(const CellPoints& points, size_t width, const ThreadPool& pool) {
  return lowest_equal_rows(static_cast<uint32_t>(points.ids.size()), std::as_bytes(std::span(points.records)),
                           width, {}, pool);
}

// Forgets most requests that were made before. Faces around a point come soon after each other.
class RecentRequests {
 public:
  RecentRequests() : slots_(kSlots, {kNone, kNone}) {}
  bool add(const Request& request) {
    Request& slot = slots_[(request.point * 0x9e3779b1u + request.cell * 0x85ebca77u) >> 16 & (kSlots - 1)];
    if (slot.point == request.point && slot.cell == request.cell) return false;
    slot = request;
    return true;
  }

 private:
  static constexpr size_t kSlots = size_t{1} << 16;
  std::vector<Request> slots_;
};

}  // namespace

class CellParts::Builder {
 public:
  Builder(const LargeMesh& mesh, const Options& options, const ThreadPool& pool, CellParts& result)
      : mesh_(mesh), options_(options), pool_(pool), result_(result), width_(mesh.record_bytes()) {}

  Status build() {
    if (Status status = distribute(); !status.ok()) return status;
    mesh_.forget();
    for (uint32_t cell = 0; cell < counts_.size(); ++cell)
      if (Status status = own_points(cell); !status.ok()) return status;
    if (Status status = answers_->finish(); !status.ok()) return status;
    if (Status status = numbers_.flush(); !status.ok()) return status;
    requests_.reset();
    uses_.assign(number_count_, 0);
    for (uint32_t cell = 0; cell < counts_.size(); ++cell)
      if (Status status = write_part(cell); !status.ok()) return status;
    if (result_.statistics_.kept_faces == 0) return unsupported("no triangles but degenerate ones");
    count_uses();
    choose_codings();
    return result_.file_.flush();
  }

 private:
  template <typename Count>
  Expected<BucketFile> buckets(const Count& count, size_t record_bytes, uint64_t share) {
    std::vector<uint64_t> counts;
    for (const CellAssignment::Counts& cell : counts_) counts.push_back(count(cell));
    return BucketFile::create(options_.folder, counts, record_bytes, options_.buffer_bytes / share);
  }

  // Points, faces and requests to the files of their cells.
  Status distribute() {
    Expected<CellAssignment> assignment = CellAssignment::make(mesh_, options_.cost, pool_);
    if (!assignment) return assignment.status();
    counts_ = assignment->counts();
    using Counts = CellAssignment::Counts;
    constexpr uint64_t kHalf = 2, kQuarter = 4;  // of the memory for buffers
    Expected<BucketFile> points =
        buckets([](const Counts& cell) { return cell.points; }, sizeof(uint32_t) + width_, kHalf);
    if (!points) return points.status();
    Expected<BucketFile> faces = buckets([](const Counts& cell) { return cell.faces; }, sizeof(Face), kQuarter);
    if (!faces) return faces.status();
    Expected<BucketFile> requests =
        buckets([](const Counts& cell) { return cell.requests; }, sizeof(Request), kQuarter);
    if (!requests) return requests.status();
    if (Status status = distribute_points(*assignment, *points); !status.ok()) return status;
    if (Status status = distribute_faces(*assignment, *faces, *requests); !status.ok()) return status;
    for (BucketFile* file : {&*points, &*faces, &*requests})
      if (Status status = file->finish(); !status.ok()) return status;
    points_ = std::move(*points);
    faces_ = std::move(*faces);
    requests_ = std::move(*requests);
    Expected<BucketFile> answers =
        buckets([](const Counts& cell) { return cell.foreign_corners; }, 2 * sizeof(uint32_t) + width_, kHalf);
    if (!answers) return answers.status();
    answers_ = std::move(*answers);
    Expected<AppendFile> numbers = AppendFile::create(options_.folder);
    if (!numbers) return numbers.status();
    numbers_ = std::move(*numbers);
    result_.statistics_.faces = mesh_.face_count();
    return {};
  }

  Status distribute_points(const CellAssignment& assignment, BucketFile& file) {
    std::vector<uint8_t> record(sizeof(uint32_t) + width_);
    return assignment.for_each_point([&](uint64_t first, std::span<const uint8_t> records,
                                         std::span<const CellAssignment::Cell> cells) -> Status {
      for (size_t i = 0; i < cells.size(); ++i) {
        const auto id = static_cast<uint32_t>(first + i);
        std::memcpy(record.data(), &id, sizeof(id));
        std::memcpy(record.data() + sizeof(id), records.data() + i * width_, width_);
        if (Status status = file.add(cells[i], record); !status.ok()) return status;
      }
      return {};
    });
  }

  Status distribute_faces(const CellAssignment& assignment, BucketFile& file, BucketFile& requests) {
    RecentRequests recent;
    return assignment.for_each_face(
        [&](std::span<const Face> faces, std::span<const std::array<CellAssignment::Cell, 3>> cells) -> Status {
          for (size_t i = 0; i < faces.size(); ++i) {
            const CellAssignment::Cell cell = CellAssignment::cell_of_face(cells[i]);
            if (Status status = file.add(cell, bytes_of(faces[i])); !status.ok()) return status;
            for (size_t c = 0; c < 3; ++c) {
              const std::array<Request, 1> request = {{{faces[i][c], cell}}};
              if (cells[i][c] == cell || !recent.add(request[0])) continue;
              if (Status status = requests.add(cells[i][c], bytes_of(request)); !status.ok()) return status;
            }
          }
          return {};
        });
  }

  Expected<CellPoints> read_points(uint32_t cell) {
    const auto count = static_cast<size_t>(points_->count(cell));
    const size_t stride = sizeof(uint32_t) + width_;
    CellPoints points;
    points.ids.resize(count);
    points.records.resize(count * width_);
    constexpr size_t kAtOnce = 16384;
    std::vector<uint8_t> block;
    for (size_t first = 0; first < count; first += kAtOnce) {
      const size_t block_count = std::min(kAtOnce, count - first);
      block.resize(block_count * stride);
      if (Status status = points_->read(cell, first, block); !status.ok()) return status;
      for (size_t i = 0; i < block_count; ++i) {
        std::memcpy(&points.ids[first + i], block.data() + i * stride, sizeof(uint32_t));
        std::memcpy(points.records.data() + (first + i) * width_, block.data() + i * stride + sizeof(uint32_t),
                    width_);
      }
    }
    if (options_.keep_duplicates) {
      points.lowest.resize(count);
      std::iota(points.lowest.begin(), points.lowest.end(), 0u);
    } else {
      points.lowest = lowest_equal(points, width_, pool_);
    }
    return points;
  }

  // Numbers the points that other cells ask for, and gives them to these cells.
  Status own_points(uint32_t cell) {
    const Expected<CellPoints> read = read_points(cell);
    if (!read) return read.status();
    const CellPoints& points = *read;
    result_.statistics_.points += points.ids.size();
    for (uint32_t i = 0; i < points.ids.size(); ++i) different_points_ += points.lowest[i] == i;
    std::vector<uint32_t> number(requests_->count(cell) > 0 ? points.ids.size() : 0, kNone);
    std::vector<std::array<uint32_t, 2>> numbered;
    std::vector<uint8_t> answer(2 * sizeof(uint32_t) + width_);
    constexpr uint64_t kAtOnce = 65536;
    std::vector<Request> requests;
    for (uint64_t first = 0; first < requests_->count(cell); first += kAtOnce) {
      requests.resize(static_cast<size_t>(std::min(kAtOnce, requests_->count(cell) - first)));
      if (Status status = requests_->read(cell, first, writable_bytes(requests)); !status.ok()) return status;
      for (const Request& request : requests) {
        const uint32_t point = points.lowest[*points.find(request.point)];
        if (number[point] == kNone) {
          number[point] = number_count_++;
          numbered.push_back({point, number[point]});
        }
        std::memcpy(answer.data(), &request.point, sizeof(uint32_t));
        std::memcpy(answer.data() + sizeof(uint32_t), &number[point], sizeof(uint32_t));
        std::memcpy(answer.data() + 2 * sizeof(uint32_t), points.records.data() + point * width_, width_);
        if (Status status = answers_->add(request.cell, answer); !status.ok()) return status;
      }
    }
    number_places_.push_back({numbers_.size(), numbered.size()});
    return numbers_.append(bytes_of(numbered));
  }

  // The points of other cells that the faces of a cell use, in ascending order of `number`.
  struct ForeignPoints {
    std::vector<std::array<uint32_t, 2>> of_id;  // ascending: id, index of the point
    std::vector<uint32_t> numbers;
    std::vector<uint8_t> records;

    uint32_t find(uint32_t id) const {
      return (*std::ranges::lower_bound(of_id, std::array<uint32_t, 2>{id, 0}))[1];
    }
  };

  Expected<ForeignPoints> read_foreign(uint32_t cell) {
    const size_t stride = 2 * sizeof(uint32_t) + width_;
    std::vector<uint8_t> answers(static_cast<size_t>(answers_->count(cell)) * stride);
    if (Status status = answers_->read(cell, 0, answers); !status.ok()) return status;
    ForeignPoints foreign;
    std::vector<std::array<uint32_t, 2>> by_number;  // number, index of the answer
    for (uint32_t i = 0; i * stride < answers.size(); ++i) {
      std::array<uint32_t, 2> head;
      std::memcpy(head.data(), answers.data() + i * stride, sizeof(head));
      foreign.of_id.push_back(head);
      by_number.push_back({head[1], i});
    }
    std::ranges::sort(by_number);
    for (const auto& [number, answer] : by_number) {
      if (!foreign.numbers.empty() && foreign.numbers.back() == number) continue;
      foreign.numbers.push_back(number);
      const auto record = answers.begin() + static_cast<std::ptrdiff_t>(answer * stride + 2 * sizeof(uint32_t));
      foreign.records.insert(foreign.records.end(), record, record + static_cast<std::ptrdiff_t>(width_));
    }
    for (auto& [id, number] : foreign.of_id)
      number =
          static_cast<uint32_t>(std::ranges::lower_bound(foreign.numbers, number) - foreign.numbers.begin());
    std::ranges::sort(foreign.of_id);
    return foreign;
  }

  Status write_part(uint32_t cell) {
    Array<Face> faces(static_cast<size_t>(faces_->count(cell)));
    const auto [numbers_at, numbered_count] = number_places_[cell];
    if (faces.empty() && !options_.keep_unused) return {};
    if (Status status = faces_->read(cell, 0, writable_bytes(faces)); !status.ok()) return status;
    const Expected<CellPoints> own = read_points(cell);
    if (!own) return own.status();
    const Expected<ForeignPoints> foreign = read_foreign(cell);
    if (!foreign) return foreign.status();
    const auto own_count = static_cast<uint32_t>(own->ids.size());

    // First the number of each point is that of its own points, followed by foreign ones.
    std::vector<uint32_t> place(own_count + foreign->numbers.size(), kNone);
    for (uint32_t i = 0; i < own_count && options_.keep_unused; ++i)
      if (own->lowest[i] == i) place[i] = 0;
    size_t kept = 0;
    for (Face& face : faces) {
      for (uint32_t& point : face) {
        const std::optional<uint32_t> index = own->find(point);
        point = index ? own->lowest[*index] : own_count + foreign->find(point);
      }
      if (!options_.keep_degenerate && repeats_a_point(face)) continue;
      for (const uint32_t point : face) place[point] = 0;
      faces[kept++] = face;
    }
    result_.statistics_.dropped_faces += faces.size() - kept;
    result_.statistics_.kept_faces += kept;
    faces.resize(kept);

    Place part{result_.file_.size(), static_cast<uint32_t>(kept), 0, 0};
    std::vector<uint8_t> records;
    std::vector<std::array<uint32_t, 2>> numbered(static_cast<size_t>(numbered_count)), shared;
    if (Status status = numbers_.read(numbers_at, writable_bytes(numbered)); !status.ok()) return status;
    std::ranges::sort(numbered);
    auto next = numbered.begin();
    for (uint32_t i = 0; i < place.size(); ++i) {
      if (place[i] == kNone) continue;
      place[i] = part.point_count++;
      const bool is_own = i < own_count;
      const uint8_t* const record =
          is_own ? own->records.data() + i * width_ : foreign->records.data() + (i - own_count) * width_;
      records.insert(records.end(), record, record + width_);
      uint32_t number = is_own ? kNone : foreign->numbers[i - own_count];
      while (next != numbered.end() && (*next)[0] < i) ++next;
      if (is_own && next != numbered.end() && (*next)[0] == i) number = (*next)[1];
      if (number == kNone) {
        ++used_points_;
        continue;
      }
      shared.push_back({place[i], number});
      if (uses_[number] < 2) ++uses_[number];
    }
    if (part.point_count == 0) return {};
    for (Face& face : faces)
      for (uint32_t& point : face) point = place[point];
    part.shared_count = static_cast<uint32_t>(shared.size());
    result_.places_.push_back(part);
    if (Status status = result_.file_.append(bytes_of(faces)); !status.ok()) return status;
    if (Status status = append_columns(records); !status.ok()) return status;
    return result_.file_.append(bytes_of(shared));
  }

  // The records, attribute by attribute.
  Status append_columns(std::span<const uint8_t> records) {
    size_t offset = 0;
    bounds_.resize(mesh_.attributes().size());
    for (size_t k = 0; k < bounds_.size(); ++k) {
      Attribute column = mesh_.attributes()[k];
      const size_t stride = column.stride();
      column.values.resize(records.size() / width_ * stride);
      for (size_t i = 0; i * width_ < records.size(); ++i)
        std::memcpy(column.values.data() + i * stride, records.data() + i * width_ + offset, stride);
      bounds_[k].add(mesh_.bounds_for(column));
      if (Status status = result_.file_.append(bytes_of(column.values)); !status.ok()) return status;
      offset += stride;
    }
    return {};
  }

  void choose_codings() {
    for (size_t k = 0; k < bounds_.size(); ++k) {
      const Attribute& attribute = mesh_.attributes()[k];
      result_.codings_.push_back(mesh_.coding_of(attribute, bounds_[k]));
      std::string loss = loss_of_whole_numbers(attribute, bounds_[k], result_.codings_.back());
      if (!loss.empty()) result_.losses_.push_back(std::move(loss));
    }
  }

  void count_uses() {
    CellStatistics& statistics = result_.statistics_;
    result_.shared_number_.assign(number_count_, kNone);
    for (uint32_t number = 0; number < number_count_; ++number) {
      used_points_ += uses_[number] > 0;
      if (uses_[number] > 1) result_.shared_number_[number] = result_.shared_count_++;
    }
    statistics.merged_points = statistics.points - different_points_;
    statistics.dropped_points = different_points_ - used_points_;
  }

  const LargeMesh& mesh_;
  const Options& options_;
  const ThreadPool& pool_;
  CellParts& result_;
  const size_t width_;  // of a record
  std::vector<CellAssignment::Counts> counts_;
  std::optional<BucketFile> points_, faces_, requests_, answers_;
  AppendFile numbers_;  // of each cell: the points that others asked for, and their numbers
  std::vector<std::pair<uint64_t, uint64_t>> number_places_;  // of each cell: offset and count
  uint32_t number_count_ = 0;
  std::vector<uint8_t> uses_;  // by how many parts each numbered point is used; 2 also for more
  uint64_t different_points_ = 0, used_points_ = 0;
  std::vector<CodingBounds> bounds_;  // of the points in parts
};

Expected<std::unique_ptr<CellParts>> CellParts::make(const LargeMesh& mesh, const Options& options,
                                                     const ThreadPool& pool) {
  std::unique_ptr<CellParts> parts(new CellParts());
  parts->attributes_ = mesh.attributes();
  Expected<AppendFile> file = AppendFile::create(options.folder);
  if (!file) return file.status();
  parts->file_ = std::move(*file);
  if (Status status = Builder(mesh, options, pool, *parts).build(); !status.ok()) return status;
  return parts;
}

Expected<MeshPart> CellParts::read(uint32_t index) {
  const Place& place = places_[index];
  MeshPart part;
  uint64_t offset = place.offset;
  Status status;
  const auto read_next = [&](std::span<uint8_t> to) {
    if (status.ok()) status = file_.read(offset, to);
    offset += to.size();
  };
  part.mesh.point_count = place.point_count;
  part.mesh.faces.resize(place.face_count);
  read_next(writable_bytes(part.mesh.faces));
  part.mesh.attributes = attributes_;
  for (Attribute& attribute : part.mesh.attributes) {
    attribute.values.resize(attribute.stride() * place.point_count);
    read_next(writable_bytes(attribute.values));
  }
  std::vector<std::array<uint32_t, 2>> shared(place.shared_count);
  read_next(writable_bytes(shared));
  if (!status.ok()) return status;
  for (const auto& [point, number] : shared) {
    if (shared_number_[number] == kNone) continue;
    part.shared_points.push_back(point);
    part.shared_numbers.push_back(shared_number_[number]);
  }
  return part;
}

}  // namespace psplit
