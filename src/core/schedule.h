// The chains of dependent steps that decoders stop at, and two ways to take them: one thread takes the steps of
// several runs in turn, or each lane of a warp takes the steps of one run.
#pragma once

#include "src/core/condensed/condensed_attributes.h"
#include "src/core/condensed/context_symbols.h"
#include "src/core/condensed/seam_steps.h"

namespace psplit::core {

// The runs of steps that a decoder waits for. Runs at the same stop are independent of each other.
enum class Stop : uint8_t {
  kSymbolLists,   // sequences(): the symbols of a valence traversal; condensed_symbols()
  kConnectivity,  // add_faces()
  kSeams,         // seams(), condensed_seams()
  kChains,        // sequences() of the attributes, traversals(), degree_walks(), and the tokens of
                  // condensed_attributes()
  kCorrections,   // none
  kPrediction,    // parallelograms_3d(), parallelograms_2d(), parallelograms_4d() and normals() of integers(),
                  // and the created values of condensed_attributes()
  kDone,
};

template <typename Index, StreamKinds kKinds = StreamKinds::kBoth>
class PatchDecoder;

// Calls take(runs, count) until it has seen all runs of some decoders, at most 16 at a time. A run is
// run_of(item) of an item of list_of(decoder).
template <typename Run, typename Decoder, typename ListOf, typename RunOf, typename Take>
PSPLIT_HD void for_runs(Decoder* const* decoders, uint32_t decoder_count, ListOf list_of, RunOf run_of,
                        Take take) {
  constexpr uint32_t kMost = 16;
  Run* runs[kMost] = {};
  uint32_t count = 0;
  const auto take_all = [&] {
    sort_longest_first(runs, count);
    take(runs, count);
    count = 0;
  };
  for (uint32_t n = 0; n < decoder_count; ++n) {
    const auto list = list_of(*decoders[n]);
    for (size_t i = 0; i < list.size(); ++i) {
      runs[count++] = &run_of(list[i]);
      if (count == kMost) take_all();
    }
  }
  take_all();
}

// Takes steps of a stream's traversals, two at most, and of its sequences of symbols, one after the other, in
// turn, until there are no more of either. There are about two symbols for each step of a traversal: half as
// many vertices as faces, and three components each.
template <typename Index>
PSPLIT_HD void step_chains(View<DepthFirstTraversal<Index>> traversals, View<SymbolSequence> sequences) {
  using Traversal = DepthFirstTraversal<Index>;
  constexpr uint32_t kMost = PSPLIT_IS_SMALL_CODE ? 1 : 2;
  const auto step = [&](auto symbols) {
    for (renew_steps(symbols); symbols.steps_left() > 0; renew_steps(symbols)) {
      Traversal* running[kMost] = {};
      uint32_t count = 0;
      for (size_t i = 0; i < traversals.size() && count < kMost; ++i)
        if (traversals[i].steps_left() > 0) running[count++] = &traversals[i];
      if (count == 0) break;
      if constexpr (kMost > 1)
        if (count > 1) step_in_turn(*running[0], *running[1], symbols);
      if (count == 1) step_in_turn(*running[0], symbols);
    }
    return symbols;
  };
  constexpr uint32_t kSequences = 16;
  SymbolSequence* longest[kSequences];
  uint32_t count = 0;
  for (; count < kSequences && count < sequences.size(); ++count) longest[count] = &sequences[count];
  sort_longest_first(longest, count);
  for (uint32_t i = 0; i < count; ++i) {
    SymbolSequence& sequence = *longest[i];
    sequence.fill_buckets();
    if (sequence.is_direct())
      sequence = step(SymbolPairSteps<true>(sequence));
    else
      sequence = step(SymbolPairSteps<false>(sequence));
  }
}

// Takes the steps of all symbols and traversals, kInStep runs of one kind in turn. The remaining runs of each
// kind then take turns with runs of other kinds.
template <typename Traversal, typename Decoder>
PSPLIT_HD void take_chains(Decoder* const* decoders, uint32_t count) {
  using Direct = SymbolSteps<true>;
  using Wide = SymbolSteps<false>;
  LeftRuns<Traversal> traversals;
  LeftRuns<SymbolSequence> direct, wide;
  const auto itself = [](auto& run) -> auto& { return run; };
  for_runs<SymbolSequence>(
      decoders, count, [](Decoder& decoder) { return decoder.sequences(); }, itself,
      [&](SymbolSequence* const* runs, uint32_t run_count) {
        for_tables(
            runs, run_count, [&](auto* const* of, uint32_t n) { direct.template take_most<Direct>(of, n); },
            [&](auto* const* of, uint32_t n) { wide.template take_most<Wide>(of, n); });
      });
  for_runs<Traversal>(
      decoders, count, [](Decoder& decoder) { return decoder.traversals(); }, itself,
      [&](Traversal* const* runs, uint32_t run_count) {
        traversals.template take_most<Traversal>(runs, run_count);
      });
  step_left_in_turn<Traversal, SymbolPairSteps<true>>(traversals, direct);
  step_left_in_turn<Traversal, SymbolPairSteps<false>>(traversals, wide);
  step_left_in_turn<Direct, Wide>(direct, wide);
  traversals.template finish<Traversal>();
  direct.template finish<Direct>();
  wide.template finish<Wide>();
}

// Takes steps of a stream's predictions in turn: of points and groups of four until one ends, then of three
// kinds until one ends, then of two. One may be left.
template <typename Index>
PSPLIT_HD void step_predictions(View<IntegerDecoder<Index>> integers) {
  ParallelogramSteps<Index, 3>* points = nullptr;
  ParallelogramSteps<Index, 4>* fours = nullptr;
  ParallelogramSteps<Index, 2>* places = nullptr;
  NormalSteps<Index>* normals = nullptr;
  for (size_t i = 0; i < integers.size(); ++i) {
    if (points == nullptr && integers[i].parallelograms_3d().steps_left() > 0)
      points = &integers[i].parallelograms_3d();
    if (fours == nullptr && integers[i].parallelograms_4d().steps_left() > 0)
      fours = &integers[i].parallelograms_4d();
    if (places == nullptr && integers[i].parallelograms_2d().steps_left() > 0)
      places = &integers[i].parallelograms_2d();
    if (normals == nullptr && integers[i].normals().steps_left() > 0) normals = &integers[i].normals();
  }
  if (points != nullptr && fours != nullptr) step_in_turn(*points, *fours);
  if (points != nullptr && places != nullptr && normals != nullptr) step_in_turn(*points, *places, *normals);
  if (points != nullptr && normals != nullptr) step_in_turn(*points, *normals);
  if (places != nullptr && normals != nullptr) step_in_turn(*places, *normals);
  if (points != nullptr && places != nullptr) step_in_turn(*points, *places);
}

// Takes all pending steps of decoders that are at the same stop, kInStep runs in turn.
template <typename Index, StreamKinds kKinds>
PSPLIT_HD void take_steps(PatchDecoder<Index, kKinds>* const* decoders, uint32_t count) {
  using Decoder = PatchDecoder<Index, kKinds>;
  constexpr bool kHasCondensed = kKinds != StreamKinds::kDraco;
  using Integers = IntegerDecoder<Index>;
  const auto itself = [](auto& run) -> auto& { return run; };
  const auto sequences = [](Decoder& decoder) { return decoder.sequences(); };
  const auto take_predictions = [&]<typename Run>(Run& (Integers::*steps)(),
                                                  void (*take)(Run* const*, uint32_t)) {
    for_runs<Run>(
        decoders, count, [](Decoder& decoder) { return decoder.integers(); },
        [=](Integers & integers) -> auto& { return (integers.*steps)(); }, take);
  };
  const auto attributes = [](Decoder& decoder) { return decoder.condensed_attributes(); };
  switch (decoders[0]->stop()) {
    case Stop::kSeams:
      if constexpr (kHasCondensed)
        for_runs<CondensedSeamSteps>(
            decoders, count, [](Decoder& decoder) { return decoder.condensed_seams(); }, itself,
            step_all<kRareInStep<kInStep>, CondensedSeamSteps, CondensedSeamSteps>);
      for_runs<BitSteps>(
          decoders, count, [](Decoder& decoder) { return decoder.seams(); }, itself,
          step_all<kInStep, BitSteps, BitSteps>);
      return;
    case Stop::kSymbolLists:
      if constexpr (kHasCondensed)
        for_runs<ContextSymbolSteps>(
            decoders, count, [](Decoder& decoder) { return decoder.condensed_symbols(); }, itself,
            step_all<kInStep, ContextSymbolSteps, ContextSymbolSteps>);
      for_runs<SymbolSequence>(decoders, count, sequences, itself, step_symbols<kInStep>);
      return;
    case Stop::kConnectivity:
      for (uint32_t n = 0; n < count; ++n) decoders[n]->add_faces();
      return;
    case Stop::kChains: {
      using Run = DepthFirstTraversal<Index>;
      const auto traversals = [](Decoder& decoder) { return decoder.traversals(); };
      if (count == 1) {
        step_chains(traversals(*decoders[0]), sequences(*decoders[0]));
        // Symbols that are not read yet take turns with the traversals, too.
        if (Decoder::kWalksOn && !decoders[0]->is_read())
          return for_runs<SymbolSequence>(decoders, count, sequences, itself, step_symbols<kInStep>);
      }
      if constexpr (PSPLIT_IS_SMALL_CODE) {
        for_runs<SymbolSequence>(decoders, count, sequences, itself, step_symbols<kInStep>);
        for_runs<Run>(decoders, count, traversals, itself, step_all<kInStep, Run, Run>);
      } else {
        take_chains<Run>(decoders, count);
      }
      if constexpr (kHasCondensed)
        for_runs<TokenSequence>(
            decoders, count, attributes, [](auto& attribute) -> auto& { return attribute.tokens; },
            step_tokens<kInStep>);
      return;
    }
    case Stop::kPrediction:
      if constexpr (kHasCondensed)
        for_runs<CreatedValues<Index>>(
            decoders, count, attributes, [](auto& attribute) -> auto& { return attribute.created; },
            step_created<kInStep, Index>);
      if constexpr (Integers::kStepsFour)
        if (count == 1) step_predictions(decoders[0]->integers());
      take_predictions(&Integers::parallelograms_3d, step_all<kInStep, ParallelogramSteps<Index, 3>>);
      take_predictions(&Integers::parallelograms_2d, step_all<kInStep, ParallelogramSteps<Index, 2>>);
      if constexpr (Integers::kStepsFour)
        take_predictions(&Integers::parallelograms_4d, step_all<kInStep, ParallelogramSteps<Index, 4>>);
      take_predictions(&Integers::normals, step_normals<Index>);
      return;
    case Stop::kCorrections:
    case Stop::kDone: return;
  }
}

// For lanes that each take a run of their own: the number of runs that a decoder waits for, and all steps of
// one run: take_prediction at Stop::kPrediction, otherwise take_run.
template <typename Index, StreamKinds kKinds>
PSPLIT_HD uint32_t pending_runs(const PatchDecoder<Index, kKinds>& decoder) {
  switch (decoder.stop()) {
    case Stop::kConnectivity: return 1;
    case Stop::kSeams: return static_cast<uint32_t>(decoder.seams().size() + decoder.condensed_seams().size());
    case Stop::kSymbolLists:
      return static_cast<uint32_t>(decoder.sequences().size() + decoder.condensed_symbols().size());
    case Stop::kChains:
      return static_cast<uint32_t>(decoder.sequences().size() + decoder.traversals().size() +
                                   decoder.degree_walks().size() + decoder.condensed_attributes().size());
    case Stop::kPrediction:
      return static_cast<uint32_t>(decoder.integers().size() + decoder.condensed_attributes().size());
    case Stop::kCorrections:
    case Stop::kDone: break;
  }
  return 0;
}
template <typename Index, StreamKinds kKinds>
PSPLIT_HD void take_run(PatchDecoder<Index, kKinds>& decoder, uint32_t number) {
  const auto step_through = []<typename Run>(Run& run) {
    Run* const one = &run;
    step_all<1, Run>(&one, 1);
  };
  // Whether the run is in this list. If not, its number counts from the next list on.
  const auto is_in = [&](const auto& list) {
    const bool found = number < list.size();
    if (!found) number -= static_cast<uint32_t>(list.size());
    return found;
  };
  switch (decoder.stop()) {
    case Stop::kConnectivity: return decoder.add_faces();
    case Stop::kSeams:
      if (is_in(decoder.seams())) return step_through(decoder.seams()[number]);
      if (is_in(decoder.condensed_seams())) step_through(decoder.condensed_seams()[number]);
      return;
    case Stop::kSymbolLists:
    case Stop::kChains: {
      if (is_in(decoder.sequences())) {
        SymbolSequence* const one = &decoder.sequences()[number];
        return step_symbols<1>(&one, 1);
      }
      if (decoder.stop() == Stop::kSymbolLists) {
        if (is_in(decoder.condensed_symbols())) step_through(decoder.condensed_symbols()[number]);
        return;
      }
      if (is_in(decoder.traversals())) return step_through(decoder.traversals()[number]);
      if (is_in(decoder.degree_walks())) return step_through(decoder.degree_walks()[number]);
      if (!is_in(decoder.condensed_attributes())) return;
      TokenSequence* const one = &decoder.condensed_attributes()[number].tokens;
      return step_tokens<1>(&one, 1);
    }
    case Stop::kCorrections:
    case Stop::kPrediction:
    case Stop::kDone: return;
  }
}
template <typename Index, StreamKinds kKinds>
PSPLIT_HD void take_prediction(PatchDecoder<Index, kKinds>& decoder, uint32_t number) {
  const View<IntegerDecoder<Index>> integers = decoder.integers();
  if (number < integers.size()) return integers[number].take_prediction();
  if constexpr (kKinds != StreamKinds::kDraco) {
    CreatedValues<Index>* const one = &decoder.condensed_attributes()[number - integers.size()].created;
    step_created<1>(&one, 1);
  }
}

}  // namespace psplit::core
