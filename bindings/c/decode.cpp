// Decodes meshes into the caller's memory.
#include <algorithm>
#include <atomic>

#include "bindings/c/mesh.h"
#include "src/loader/check_buffers.h"
#include "src/loader/older_streams.h"

namespace psplit::c {
namespace {

struct Run {
  Threads threads;
  LoadOptions options;

  static Expected<std::unique_ptr<Run>> of(const psplit_run* from) {
    psplit_run stated{};
    if (from != nullptr) {
      const Expected<psplit_run> read = read_struct(from, "psplit_run");
      if (!read) return read.status();
      stated = *read;
    }
    Expected<Threads> threads = Threads::of(stated.pool, stated.threads);
    if (!threads) return threads.status();
    auto run = std::make_unique<Run>();
    run->threads = std::move(*threads);
    run->options.pool = &run->threads.pool();
    if (stated.stop != nullptr) run->options.stop = &stated.stop->flag;
    if (stated.progress != nullptr)
      run->options.progress = [progress = stated.progress, user = stated.user](size_t done, size_t total) {
        progress(user, done, total);
      };
    return run;
  }

  bool is_stopped() const { return options.stop != nullptr && *options.stop; }
};

// The caller's memory, and which attributes of the mesh it is for.
struct Wanted {
  std::vector<size_t> attributes{};
  PrimitiveBuffers out{};
};

Expected<WritableBytes> writable(void* data, size_t size) {
  if (data == nullptr && size > 0) return wrong_usage("a buffer of " + std::to_string(size) + " bytes is null");
  return WritableBytes(std::span(static_cast<std::byte*>(data), size));
}

Expected<Wanted> read_buffers(const psplit_mesh& mesh, const psplit_buffers* from) {
  const Expected<psplit_buffers> buffers = read_struct(from, "psplit_buffers");
  if (!buffers) return buffers.status();
  if (buffers->reserved != 0) return wrong_usage("psplit_buffers: `reserved` is not 0");
  const size_t count = buffers->attribute_count;
  if (count != 0 && count != mesh.attributes.size())
    return wrong_usage(std::to_string(count) + " buffers for " + std::to_string(mesh.attributes.size()) +
                       " attributes");
  const Expected<std::vector<psplit_attribute_buffer>> elements =
      read_array(buffers->attributes, count, "psplit_attribute_buffer");
  if (!elements) return elements.status();
  Wanted wanted;
  const Expected<WritableBytes> indices = writable(buffers->indices, buffers->indices_size);
  if (!indices) return indices.status();
  wanted.out.indices = *indices;
  wanted.out.index_bytes = buffers->index_size;
  for (size_t k = 0; k < count; ++k) {
    const psplit_attribute_buffer& element = (*elements)[k];
    if (element.reserved != 0) return wrong_usage("psplit_attribute_buffer: `reserved` is not 0");
    const Expected<WritableBytes> bytes = writable(element.data, element.size);
    if (!bytes) return bytes.status();
    if (element.data == nullptr) continue;
    wanted.attributes.push_back(k);
    wanted.out.attributes.push_back({*bytes, element.stride});
  }
  return wanted;
}

Expected<PrimitiveLoad> load_of(const psplit_mesh& mesh, Wanted wanted) {
  const CompressedPrimitive& primitive = *mesh.primitive;
  if (wanted.attributes.size() == mesh.attributes.size())
    return PrimitiveLoad{primitive, std::move(wanted.out)};
  std::vector<AttributeRequest> requests;
  for (const size_t attribute : wanted.attributes) requests.push_back(primitive.attributes()[attribute]);
  Expected<CompressedPrimitive> selected = primitive.with_attributes(std::move(requests));
  if (!selected) return selected.status();
  return PrimitiveLoad{std::move(*selected), std::move(wanted.out)};
}

// Whether the stream is still the mesh's. If not, the caller has changed the bytes since it opened them.
bool is_of(const StreamDescription& description, Span<const StoredValues> stored, const psplit_mesh& mesh) {
  if (description.point_count != mesh.point_count() || description.face_count != mesh.face_count() ||
      description.attributes.size() != mesh.attributes.size())
    return false;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const MeshAttribute& opened = mesh.attributes[i];
    if (opened.is_integers && !stored[i].has_integers) return false;
    const GeometryAttribute decoded{description.attributes[i], {}, opened.is_integers};
    if (decoded.stride() != opened.value_bytes) return false;
  }
  return true;
}

// Decodes a whole Draco stream.
Status decode_file(const psplit_mesh& mesh, const Wanted& wanted, const Run& run) {
  std::vector<NamedSize> sizes;
  for (const size_t attribute : wanted.attributes) {
    const MeshAttribute& described = mesh.attributes[attribute];
    sizes.push_back({described.name.empty() ? "attribute " + std::to_string(attribute) : described.name,
                     described.value_bytes});
  }
  const Expected<PrimitiveBuffers> out =
      check_buffers(sizes, wanted.out, mesh.point_count(), mesh.face_count());
  if (!out) return out.status();
  if (run.is_stopped()) return cancelled();
  if (mesh.file->of_libdraco) {
    std::vector<AttributeRequest> requests;
    for (const size_t attribute : wanted.attributes) requests.push_back((*mesh.file->of_libdraco)[attribute]);
    return decode_older(*built_in_older_streams(), mesh.file->stream, requests, mesh.point_count(),
                        mesh.face_count(), *out);
  }
  return decode_geometry(
      mesh.file->stream,
      [&](const StreamDescription& description, Span<const StoredValues> stored) -> Expected<GeometryPlaces> {
        if (run.is_stopped()) return cancelled();
        if (!is_of(description, stored, mesh)) return invalid_input("other bytes than those that were opened");
        GeometryPlaces places;
        places.faces = out->indices.data();
        places.index_bytes = out->index_bytes;
        places.attributes.resize(mesh.attributes.size());
        for (size_t k = 0; k < sizes.size(); ++k) {
          const auto& [bytes, stride] = out->attributes[k];
          const size_t attribute = wanted.attributes[k];
          places.attributes[attribute] = {bytes.data(), nullptr, mesh.attributes[attribute].is_integers,
                                          stride};
        }
        return places;
      });
}

// A whole Draco stream among jobs.
struct FileJob {
  const psplit_mesh* mesh = nullptr;
  Wanted wanted;
  size_t place = 0;
};

// Decodes a stream on each thread, the largest first: a thread that begins a large one last works alone.
// `all_steps` is for progress.
void decode_files(std::span<FileJob> jobs, size_t all_steps, const Run& run, std::span<Status> statuses) {
  std::stable_sort(jobs.begin(), jobs.end(), [](const FileJob& a, const FileJob& b) {
    return a.mesh->file->stream.size() > b.mesh->file->stream.size();
  });
  std::atomic<size_t> done = 0;
  run.threads.pool().for_each(jobs.size(), [&](size_t i) {
    const auto& [mesh, wanted, place] = jobs[i];
    statuses[place] = decode_file(*mesh, wanted, run);
    if (const Progress& progress = run.options.progress) progress(++done, all_steps);
  });
}

// A status for each job, in their order.
std::vector<Status> decode(std::span<const psplit_job> jobs, const Run& run) {
  std::vector<Status> statuses(jobs.size());
  std::vector<FileJob> files;
  std::vector<PrimitiveLoad> loads;
  size_t patches = 0;
  std::vector<size_t> places;  // of the loads among the jobs
  for (size_t i = 0; i < jobs.size(); ++i) {
    const psplit_mesh* const mesh = jobs[i].mesh;
    if (mesh == nullptr) {
      statuses[i] = null_handle();
      continue;
    }
    Expected<Wanted> wanted = read_buffers(*mesh, jobs[i].buffers);
    if (!wanted) {
      statuses[i] = wanted.status();
    } else if (mesh->file) {
      files.push_back({mesh, std::move(*wanted), i});
    } else if (Expected<PrimitiveLoad> load = load_of(*mesh, std::move(*wanted)); load) {
      patches += mesh->patch_count();
      loads.push_back(std::move(*load));
      places.push_back(i);
    } else {
      statuses[i] = load.status();
    }
  }
  decode_files(files, files.size() + patches, run, statuses);
  LoadOptions options = run.options;
  if (options.progress && !files.empty())
    options.progress = [&](size_t done, size_t total) {
      run.options.progress(files.size() + done, files.size() + total);
    };
  std::vector<Status> decoded = decode_primitives(loads, options);
  for (size_t n = 0; n < places.size(); ++n) statuses[places[n]] = std::move(decoded[n]);
  for (size_t i = 0; i < jobs.size(); ++i)
    if (jobs[i].mesh != nullptr) statuses[i] = std::move(statuses[i]).at(jobs[i].mesh->place);
  return statuses;
}

Status decode_patch(const psplit_mesh& mesh, uint32_t patch, const psplit_buffers* buffers, const Run& run) {
  if (patch >= mesh.patch_count()) return wrong_usage("there is no patch " + std::to_string(patch));
  Expected<Wanted> wanted = read_buffers(mesh, buffers);
  if (!wanted) return wanted.status();
  if (mesh.file) return decode_file(mesh, *wanted, run);
  const Expected<PrimitiveLoad> load = load_of(mesh, std::move(*wanted));
  if (!load) return load.status();
  return load->primitive.decode_patch(patch, load->out, run.options);
}

}  // namespace
}  // namespace psplit::c

using namespace psplit;
using namespace psplit::c;

psplit_code psplit_mesh_decode(const psplit_mesh* mesh, const psplit_buffers* buffers, const psplit_run* run,
                               psplit_error* error) {
  return guarded(error, [&]() -> Status {
    const Expected<std::unique_ptr<Run>> read = Run::of(run);
    if (!read) return read.status();
    const psplit_job job{sizeof(psplit_job), PSPLIT_OK, mesh, buffers, nullptr};
    return std::move(decode({&job, 1}, **read).front());
  });
}

psplit_code psplit_mesh_decode_patch(const psplit_mesh* mesh, uint32_t patch, const psplit_buffers* buffers,
                                     const psplit_run* run, psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (mesh == nullptr) return null_handle();
    const Expected<std::unique_ptr<Run>> read = Run::of(run);
    if (!read) return read.status();
    return decode_patch(*mesh, patch, buffers, **read).at(mesh->place);
  });
}

psplit_code psplit_decode_meshes(psplit_job* jobs, size_t job_count, const psplit_run* run,
                                 psplit_error* error) {
  return guarded(error, [&]() -> Status {
    const Expected<std::vector<psplit_job>> read_jobs = read_array<psplit_job>(jobs, job_count, "psplit_job");
    if (!read_jobs) return read_jobs.status();
    const Expected<std::unique_ptr<Run>> read = Run::of(run);
    if (!read) return read.status();
    const std::vector<Status> statuses = decode(*read_jobs, **read);
    Status first;
    for (size_t i = 0; i < job_count; ++i) {
      psplit_job* const job = element_of(jobs, i);
      job->code = report(statuses[i], job->error);
      if (first.ok()) first = statuses[i];
    }
    return first;
  });
}
