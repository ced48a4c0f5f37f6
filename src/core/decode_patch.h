// One Draco mesh stream to faces, points and integers. Read this file first: it has the stages of the decoder
// in their order.
//
//   header         stream_header.h        counts, and which coding follows
//   connectivity   edgebreaker_decoder.h  symbols, split events, start faces -> corner table (edgebreaker.h)
//                  sequential.h           or the points of each face
//   seams          seam_decoder.h         seam bits -> corner tables of attributes, points (seams.h)
//   attributes     attribute_decoder.h    groups and descriptions (attributes.h), and for each attribute:
//     traversal    traversal.h            corner table -> the order of values
//     symbols      symbols.h, rans.h      entropy-coded symbols -> corrections
//     prediction   prediction.h           corrections, order, corner table -> integers by vertex
//   output         patch.h                integers -> values of the attribute's type, by point (value_writer.h)
//
// A condensed stream (condensed/condensed_stream.h) goes through the same stages, but reads its data elsewhere:
//
//   connectivity   condensed/condensed_connectivity.h  symbols in contexts (context_symbols.h) -> corner table
//   seams          condensed/seam_steps.h              seam bits
//   attributes     condensed/condensed_attributes.h    tokens (token_steps.h) -> corrections, as above; or
//                                                      values in order of creation, with their own
//                                                      prediction (creation.h)
//
// Most of the time goes into long chains of dependent steps. The decoder stops before each of them, so that a
// driver may take the steps of several attributes and several patches in turn (schedule.h).
#pragma once

#include "src/core/attribute_decoder.h"
#include "src/core/condensed/condensed_connectivity.h"
#include "src/core/edgebreaker_decoder.h"
#include "src/core/schedule.h"
#include "src/core/seam_decoder.h"
#include "src/core/sequential.h"

namespace psplit::core {

// Decodes a patch from one stop to the next:
//
//   Fault fault = decoder.start(lanes);
//   while (fault == Fault::kNone && decoder.stop() != Stop::kDone) {
//     take_steps(...);  // the steps that the decoder waits for
//     fault = decoder.resume(lanes);
//   }
template <typename Index, StreamKinds kKinds>
class PatchDecoder {
 public:
  // Whether one thread's traversals go on beside symbols that are read after others. It costs 350 bytes of
  // small code, and traversals keep their memory until the last symbols are read.
  static constexpr bool kWalksOn = !PSPLIT_IS_SMALL_CODE;

  PSPLIT_HD PatchDecoder(const StreamHeader& header, Arena& arena, Patch<Index>& out)
      : header_(header), reader_(header.body), arena_(arena), patch_(out), attributes_(header, arena, out) {}

  // Collective: all lanes share the decoder.
  template <Lanes L>
  PSPLIT_HD Fault start(L lanes) {
    const Fault fault = alone(lanes, [&] {
      patch_.face_count = header_.counts.face_count;
      return is_condensed() || header_.edgebreaker ? start_edgebreaker() : read_sequential_faces();
    });
    const bool waits = stop_ == Stop::kSymbolLists;
    lanes.sync();
    if (fault != Fault::kNone || waits) return fault;
    return is_condensed() || header_.edgebreaker ? begin_faces(lanes) : start_attributes(lanes);
  }
  PSPLIT_HD Fault start() { return start(SerialLanes()); }

  PSPLIT_HD Stop stop() const { return stop_; }
  PSPLIT_HD View<BitSteps> seams() const { return draco_only(seams_.steps()); }
  PSPLIT_HD View<ContextSymbolSteps> condensed_symbols() const { return condensed_only(condensed_.steps()); }
  PSPLIT_HD View<CondensedSeamSteps> condensed_seams() const {
    return condensed_only(seams_.condensed_steps());
  }
  // A byte for each inner edge, at Stop::kSeams after its steps.
  PSPLIT_HD View<const uint8_t> seam_flags(uint32_t attribute_data) const {
    return seams_.seams_of(attribute_data);
  }
  PSPLIT_HD View<CondensedAttribute<Index>> condensed_attributes() const {
    return condensed_only(attributes_.condensed());
  }
  PSPLIT_HD View<SymbolSequence> sequences() const {
    return draco_only(stop_ == Stop::kSymbolLists ? edgebreaker_.symbol_lists() : attributes_.sequences());
  }
  PSPLIT_HD View<DepthFirstTraversal<Index>> traversals() const { return attributes_.traversals(); }
  PSPLIT_HD View<PredictionDegreeTraversal<Index>> degree_walks() const { return attributes_.degree_walks(); }
  PSPLIT_HD View<IntegerDecoder<Index>> integers() const { return attributes_.integers(); }

  // At Stop::kConnectivity, in place of steps: adds all faces. Its fault comes from resume.
  PSPLIT_HD void add_faces() {
    const bool keep_order = header_.attribute_data_count > 0;
    connectivity_fault_ = is_condensed() ? condensed_.add_faces(header_.condensed, keep_order, patch_.mesh)
                                         : edgebreaker_.add_faces(keep_order, patch_.mesh);
  }

  // Goes on to the next stop after all steps were taken, except steps that sequences leave to their finish.
  // Stays at kChains while more symbols come, beside which one thread may take the steps that its traversals
  // have left. Collective: all lanes share the decoder.
  template <Lanes L>
  PSPLIT_HD Fault resume(L lanes) {
    const Stop stop = stop_;
    lanes.sync();
    switch (stop) {
      case Stop::kCorrections: return predict(lanes);
      case Stop::kPrediction: {
        const Fault fault = alone(lanes, [&] { return finish_predictions(); });
        return fault == Fault::kNone ? attributes_.decode_deltas(lanes) : fault;
      }
      default: return resume_to_corrections(lanes);
    }
  }
  // The parts of it that most streams need: from a stop before kCorrections, and from kCorrections.
  template <Lanes L>
  PSPLIT_HD Fault resume_to_corrections(L lanes) {
    const Stop stop = stop_;
    lanes.sync();
    switch (stop) {
      case Stop::kSymbolLists: return begin_faces(lanes);
      case Stop::kConnectivity: return finish_faces(lanes);
      case Stop::kSeams: return finish_seams(lanes);
      case Stop::kChains: return finish_chains(lanes);
      default: return Fault::kNone;
    }
  }
  // At Stop::kChains: whether no more sequences come after resume.
  PSPLIT_HD bool is_read() const { return attributes_.is_read(); }
  // At Stop::kChains, in place of steps and resume: reads what the stream says about attributes, to its end.
  PSPLIT_HD Fault read_to_end() { return attributes_.read_to_end(reader_); }
  template <Lanes L>
  PSPLIT_HD Fault predict(L lanes) {
    attributes_.start_predictions(lanes);
    const Fault fault = alone(lanes, [&] {
      return attributes_.are_predicted() ? stop_at(Stop::kDone, attributes_.check_created())
                                         : stop_at(Stop::kPrediction, Fault::kNone);
    });
    const bool is_done = fault == Fault::kNone && stop_ == Stop::kDone;
    lanes.sync();
    return is_done ? attributes_.decode_deltas(lanes) : fault;
  }

 private:
  PSPLIT_HD bool is_condensed() const { return header_.template is_condensed_of<kKinds>(); }
  // Runs of streams of a kind, known to the compiler to be empty for streams of the other kind.
  template <typename Runs>
  PSPLIT_HD static Runs draco_only(Runs runs) {
    return kKinds == StreamKinds::kCondensed ? Runs() : runs;
  }
  template <typename Runs>
  PSPLIT_HD static Runs condensed_only(Runs runs) {
    return kKinds == StreamKinds::kDraco ? Runs() : runs;
  }

  PSPLIT_HD Fault read_sequential_faces() {
    patch_.point_count = header_.point_count;
    return header_.is_cloud ? Fault::kNone : decode_sequential_faces(reader_, arena_, patch_);
  }

  // Ends at the next stop if there are symbols to decode before faces can be added.
  PSPLIT_HD Fault start_edgebreaker() {
    if (header_.attribute_data_count > kMaxAttributeData) return Fault::kAttribute;
    if (is_condensed())
      return stop_at(Stop::kSymbolLists,
                     condensed_.start(header_.counts, header_.condensed, arena_, patch_.mesh));
    Fault fault = edgebreaker_.start(header_, reader_, arena_, patch_.mesh);
    if (fault == Fault::kNone) fault = seams_.read(reader_, header_.attribute_data_count);
    if (fault != Fault::kNone || !header_.valence) return fault;
    return stop_at(Stop::kSymbolLists, edgebreaker_.start_symbol_lists(header_.counts, reader_, arena_));
  }
  template <Lanes L>
  PSPLIT_HD Fault begin_faces(L lanes) {
    fill(lanes, patch_.mesh.table.opposite, kNone<Index>);
    return alone(lanes, [&] {
      return stop_at(Stop::kConnectivity, is_condensed()
                                              ? condensed_.begin_faces(arena_, header_.counts)
                                              : edgebreaker_.begin_faces(reader_, arena_, header_.counts));
    });
  }
  template <Lanes L>
  PSPLIT_HD Fault finish_faces(L lanes) {
    if (connectivity_fault_ != Fault::kNone) return connectivity_fault_;
    const bool has_attribute_data = header_.attribute_data_count > 0;
    if (has_attribute_data) patch_.mesh.move_up(lanes);  // their order counts
    patch_.mesh.find_closed_vertices(lanes);
    if (lanes.rank() == 0) {
      if (is_condensed())
        condensed_.finish(arena_, patch_.mesh);
      else
        edgebreaker_.finish(arena_, patch_.mesh);
      patch_.point_at = patch_.mesh.table.vertex;
      patch_.point_count = patch_.mesh.vertex_count;
    }
    lanes.sync();
    return has_attribute_data ? start_seams(lanes) : start_attributes(lanes);
  }

  template <Lanes L>
  PSPLIT_HD Fault start_seams(L lanes) {
    const Fault fault = is_condensed() ? seams_.start(lanes, header_.condensed, condensed_.section(),
                                                      header_.attribute_data_count, patch_.mesh, arena_)
                                       : seams_.start(lanes, patch_.mesh, arena_);
    return alone(lanes, [&] { return stop_at(Stop::kSeams, fault); });
  }
  template <Lanes L>
  PSPLIT_HD Fault finish_seams(L lanes) {
    const Fault fault = seams_.finish(lanes, arena_, patch_);
    return fault == Fault::kNone ? start_attributes(lanes) : fault;
  }

  template <Lanes L>
  PSPLIT_HD Fault start_attributes(L lanes) {
    Fault fault = alone(lanes, [&] { return attributes_.start(reader_, seams_.tables()); });
    if (fault == Fault::kNone && is_condensed()) {
      const View<CondensedSeamSteps> seams = condensed_seams();
      const SectionReader section = seams.empty() ? condensed_.section() : seams[0].section();
      fault = attributes_.start_condensed(lanes, section, condensed_.corners());
    }
    if (fault == Fault::kNone) fault = attributes_.begin_traversals(lanes);
    if (fault != Fault::kNone) return fault;
    fill_buckets(lanes);
    return alone(lanes, [&] { return stop_at(Stop::kChains, Fault::kNone); });
  }
  template <Lanes L>
  PSPLIT_HD Fault finish_chains(L lanes) {
    // Traversals of one thread may have steps left, which it takes beside the symbols that are read now.
    const bool walks_on = L::size() == 1 && kWalksOn && !attributes_.is_read() && attributes_.walks();
    // Whoever takes the steps, the fault of a traversal comes before that of a sequence.
    const auto first = [&](Fault fault) {
      if (!walks_on || fault == Fault::kNone) return fault;
      const Fault of_walk = attributes_.walk_to_end();
      return of_walk == Fault::kNone ? fault : of_walk;
    };
    Fault fault = walks_on ? Fault::kNone : alone(lanes, [&] { return attributes_.finish_traversals(); });
    if (fault == Fault::kNone && is_condensed())
      fault = alone(lanes, [&] { return attributes_.finish_tokens(); });
    if (fault == Fault::kNone) fault = attributes_.finish_sequences(lanes, reader_);
    if (fault != Fault::kNone) return first(fault);
    const bool is_read = attributes_.is_read();
    lanes.sync();
    if (!is_read) {
      fault = alone(lanes, [&] { return attributes_.read_on(reader_); });
      if (fault == Fault::kNone) fill_buckets(lanes);
      const bool is_over = attributes_.is_read() && sequences().empty();
      lanes.sync();
      if (fault != Fault::kNone || !is_over) return first(fault);
    }
    if (walks_on) return Fault::kNone;
    return alone(lanes, [&] { return stop_at(Stop::kCorrections, attributes_.take_values()); });
  }
  // Threads that take the steps of sequences need not do it then.
  template <Lanes L>
  PSPLIT_HD void fill_buckets(L lanes) {
    if constexpr (L::size() > 1) {
      const View<SymbolSequence> pending = sequences();
      lanes.sync();
      for (size_t i = 0; i < pending.size(); ++i) pending[i].fill_buckets(lanes);
    }
  }
  PSPLIT_HD Fault finish_predictions() { return stop_at(Stop::kDone, attributes_.finish_predictions()); }

  // Sets the stop that a stage leads to, unless the stage has a fault.
  PSPLIT_HD Fault stop_at(Stop stop, Fault fault) {
    if (fault == Fault::kNone) stop_ = stop;
    return fault;
  }

  const StreamHeader& header_;
  ByteReader reader_;
  Arena& arena_;
  Patch<Index>& patch_;
  Stop stop_ = Stop::kDone;
  Fault connectivity_fault_ = Fault::kNone;
  EdgebreakerDecoder<Index> edgebreaker_;
  CondensedConnectivity<Index> condensed_;
  SeamDecoder<Index> seams_;
  AttributeDecoder<Index, kKinds> attributes_;
};

// Decodes several started decoders to their ends, or to the first fault of each: faults[n] is that of decoder
// n. go_on(at, fault_of, count) takes the steps of `count` decoders that wait at the same stop, and resumes
// them.
template <uint32_t kCount, typename Index, StreamKinds kKinds, typename GoOn>
PSPLIT_HD void finish_in_step(PatchDecoder<Index, kKinds>* const (&decoders)[kCount], Fault (&faults)[kCount],
                              GoOn go_on) {
  for (;;) {
    // The decoders at the earliest stop go on. The others wait until all are at their stop.
    PatchDecoder<Index, kKinds>* at[kCount];
    Fault* fault_of[kCount];
    uint32_t count = 0;
    for (uint32_t n = 0; n < kCount; ++n) {
      if (faults[n] != Fault::kNone || decoders[n]->stop() == Stop::kDone) continue;
      if (count > 0 && decoders[n]->stop() > at[0]->stop()) continue;
      if (count > 0 && decoders[n]->stop() < at[0]->stop()) count = 0;
      at[count] = decoders[n];
      fault_of[count++] = &faults[n];
    }
    if (count == 0) return;
    go_on(at, fault_of, count);
  }
}
template <typename Index, StreamKinds kKinds>
PSPLIT_HD void take_steps_and_resume(PatchDecoder<Index, kKinds>* const* decoders, Fault* const* faults,
                                     uint32_t count) {
  take_steps(decoders, count);
  for (uint32_t n = 0; n < count; ++n) *faults[n] = decoders[n]->resume(SerialLanes());
}

// Decodes the streams of several decoders that are not started. faults[n] becomes the fault of decoder n.
template <uint32_t kCount, typename Index, StreamKinds kKinds>
PSPLIT_HD void decode_in_step(PatchDecoder<Index, kKinds>* const (&decoders)[kCount], Fault (&faults)[kCount]) {
  for (uint32_t n = 0; n < kCount; ++n) faults[n] = decoders[n]->start();
  finish_in_step(decoders, faults, take_steps_and_resume<Index, kKinds>);
}

// Decodes from a decoder's stop to the end with all lanes of a warp, which share the decoder. One lane takes
// all steps of a run. Collective.
template <Lanes L, typename Index, StreamKinds kKinds>
PSPLIT_HD Fault finish_together(L lanes, PatchDecoder<Index, kKinds>& decoder) {
  Fault fault = Fault::kNone;
  while (fault == Fault::kNone && decoder.stop() != Stop::kDone) {
    const bool is_prediction = decoder.stop() == Stop::kPrediction;
    for_each_lane_item(lanes, pending_runs(decoder), [&](uint32_t run) {
      return is_prediction ? take_prediction(decoder, run) : take_run(decoder, run);
    });
    lanes.sync();
    fault = decoder.resume(lanes);
  }
  return fault;
}

// Decodes a stream whose header was read. Index must be wide enough: see StreamHeader::fits_16_bits. The bytes
// may be anything: a fault names their error, and no memory but theirs and the arena's is touched. Thread-safe,
// as long as each thread has an arena of its own.
template <typename Index, StreamKinds kKinds = StreamKinds::kBoth>
PSPLIT_HD Fault decode_patch(const StreamHeader& header, Arena& arena, Patch<Index>& out) {
  PatchDecoder<Index, kKinds> decoder(header, arena, out);
  PatchDecoder<Index, kKinds>* const one[1] = {&decoder};
  Fault fault[1];
  decode_in_step(one, fault);
  return fault[0];
}

// Like decode_patch, but without values: decodes the faces and the number of points, and reads all other data
// about attributes.
template <typename Index>
PSPLIT_HD Fault outline_patch(const StreamHeader& header, Arena& arena, Patch<Index>& out) {
  PatchDecoder<Index> decoder(header, arena, out);
  PatchDecoder<Index>* const one[1] = {&decoder};
  Fault fault = decoder.start();
  while (fault == Fault::kNone && decoder.stop() < Stop::kChains) {
    take_steps(one, 1);
    fault = decoder.resume(SerialLanes());
  }
  return fault == Fault::kNone ? decoder.read_to_end() : fault;
}

}  // namespace psplit::core
