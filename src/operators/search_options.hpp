// How neighbours are searched for a sum with weights.
#pragma once

#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/weights/weight.hpp"

namespace recon::detail {

// Of Options or KernelOptions: in a ball for radial weights, in a cube for products of the axes.
template <class Choice>
NeighbourOptions search_options(const Choice& choice, WeightForm form) {
  NeighbourOptions search;
  search.shape = form == WeightForm::radial ? SupportShape::ball : SupportShape::cube;
  search.search = choice.search;
  search.threads = choice.threads;
  search.instruction_set = choice.instruction_set;
  return search;
}

}  // namespace recon::detail
