// The loops that most of the time goes into. This file is compiled for speed, and the rest of the core for
// size: the linker takes a function that is in several files from this one.
#include "bindings/web/src/decoded_stream.h"
#include "src/core/decode_patch.h"
#include "src/core/stitch.h"

namespace psplit::core {

using Index = uint32_t;

// Connectivity and seams
template void fill(SerialLanes, View<Index>, Index);
template void fill(SerialLanes, View<uint8_t>, uint8_t);
template Fault add_all_faces(StandardSymbols, WaitingEdges<Index>, RansBits&, Connectivity<Index>&);
template Fault add_all_faces(ValenceSymbols<Index>, WaitingEdges<Index>, RansBits&, Connectivity<Index>&);
template Fault add_all_faces(DecodedSymbols<Index, false>, WaitingEdges<Index>, CondensedStartFaces&,
                             Connectivity<Index>&);
template Fault add_all_faces(DecodedSymbols<Index, true>, WaitingEdges<Index>, CondensedStartFaces&,
                             Connectivity<Index>&);
template Fault add_all_faces(ValenceContextSymbols<Index, false>, WaitingEdges<Index>, CondensedStartFaces&,
                             Connectivity<Index>&);
template Fault add_all_faces(ValenceContextSymbols<Index, true>, WaitingEdges<Index>, CondensedStartFaces&,
                             Connectivity<Index>&);
template void Connectivity<Index>::move_up(SerialLanes);
template void Connectivity<Index>::fill_holes();
template void Connectivity<Index>::find_closed_vertices(SerialLanes);
template void step_all<kInStep, BitSteps>(BitSteps* const*, uint32_t);
template void step_all<kInStep, ContextSymbolSteps>(ContextSymbolSteps* const*, uint32_t);
template void step_all<1, CondensedSeamSteps>(CondensedSeamSteps* const*, uint32_t);
template uint32_t list_inner_edges(const CornerTable<Index>&, View<Index>);
template Fault cut_seams(const Connectivity<Index>&, View<Index>, View<const uint8_t>, Arena&,
                         AttributeTable<Index>&, View<bool>);
template class VertexSplit<Index>;
template size_t link_border(SerialLanes, const Patch<Index>&, View<Index>);

// Orders of values, and their corrections
template void step_chains(View<DepthFirstTraversal<Index>>, View<SymbolSequence>);
template void step_all<kInStep, DepthFirstTraversal<Index>>(DepthFirstTraversal<Index>* const*, uint32_t);
template void DepthFirstTraversal<Index>::begin(SerialLanes);
template Fault traverse_by_prediction_degree(const AttributeTable<Index>&, Arena&, const Sequence<Index>&);
template class CreationOrder<Index>;
template Fault CreationOrder<Index>::see_last(SerialLanes, View<const Index>, uint32_t, View<uint8_t>);
template void step_symbols<kInStep>(SymbolSequence* const*, uint32_t);
template void step_tokens<kInStep>(TokenSequence* const*, uint32_t);
template Fault read_tagged(SerialLanes, ByteReader&, View<const uint32_t>, uint32_t, View<uint32_t>);
template void IntegerDecoder<Index>::start_prediction(SerialLanes, bool, bool);

// Values
template void step_all<kInStep, ParallelogramSteps<Index, 3>>(ParallelogramSteps<Index, 3>* const*, uint32_t);
template void step_all<kInStep, ParallelogramSteps<Index, 2>>(ParallelogramSteps<Index, 2>* const*, uint32_t);
template void step_normals(NormalSteps<Index>* const*, uint32_t);
template Fault predict(const PredictedValues<Index, 0>&, const PredictionData&, ParallelogramFinder<Index>&,
                       Arena&);
template void step_created<kInStep>(CreatedValues<Index>* const*, uint32_t);
template void CreatedValues<Index>::find_predictors(SerialLanes, const AttributeModel&, const Sequence<Index>&,
                                                    uint32_t);
template Fault predict_by_constrained_multi_parallelogram(WrappedValues<Index, 3>, ParallelogramFinder<Index>,
                                                          const View<uint8_t> (&)[kMaxParallelograms]);
template Fault predict_from_positions(const PredictedValues<Index, 2>&, const Positions<Index>&,
                                      PredictionData&, Arena&);
template void Patch<Index>::write_values(SerialLanes, const Attribute<Index>&, DataType,
                                         web::ValuePlaces) const;

// Stitching
template Fault number_mesh_points(SerialLanes, const StitchRow&, View<const Index>, View<uint32_t>,
                                  View<uint32_t>);

}  // namespace psplit::core
