// A grid by neighbour lists, a few thousand nodes at a time: what sums of moments cannot give.
#pragma once

#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon {

// Of options that leave nothing empty, with domain, stretch and weights of the Sources; `fields`
// are valid.
template <class Scalar>
BasicGridReconstruction<Scalar> by_lists(const BasicSources<Scalar>& sources,
                                         const std::vector<FieldView<Scalar>>& fields,
                                         const StructuredGrid<Scalar>& grid, Options options,
                                         const GridApply& apply);

extern template GridReconstruction by_lists(const Sources&, const std::vector<FieldView<double>>&,
                                            const StructuredGrid<double>&, Options,
                                            const GridApply&);
extern template GridReconstructionF by_lists(const SourcesF&, const std::vector<FieldView<float>>&,
                                             const StructuredGrid<float>&, Options,
                                             const GridApply&);

}  // namespace recon
