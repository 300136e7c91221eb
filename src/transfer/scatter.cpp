#include "recon/transfer/scatter.hpp"

#include "core/counting_sort.hpp"

namespace recon::detail {

SlabOrder::SlabOrder(std::size_t particles)
    : sort_(std::make_unique<CountingSort>()), first_rows_(sort_->keys(particles)) {}
SlabOrder::~SlabOrder() = default;

void SlabOrder::sort(std::uint32_t thickness, std::size_t slabs, int threads) {
  recon::parallel_blocks(first_rows_.size(), 16384, threads,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t p = begin; p < end; ++p) first_rows_[p] /= thickness;
                         });
  sort_->sort(slabs, threads);
  order_ = sort_->order();
  begin_ = sort_->first();
}

void throw_rows(int first, int last) {
  throw InvalidArgument("rows", std::to_string(first) + " to " + std::to_string(last),
                        "must be the first and the last index of a node, from 0 on");
}

void throw_for_particle(std::size_t particle, const InvalidArgument& error) {
  throw InvalidArgument("particle " + std::to_string(particle) + ": " + error.argument(),
                        error.value(), error.rule());
}

void throw_amount(std::size_t particle, double value, std::size_t component) {
  try {
    throw_component(added_amount, value, component, "must be finite");
  } catch (const InvalidArgument& error) {
    throw_for_particle(particle, error);
  }
}

}  // namespace recon::detail
