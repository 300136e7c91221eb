// A state and its step as those see them who measure: one whole, or one of the parts that it is
// spread over (mpm/parts.hpp).
//
// Whoever measures goes through the own particles of the part, and through the nodes with
// Nodes::share_of(), and asks sum() and of_all() for what the parts have together. All parts
// measure the same, in the same order.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "recon/runs/simulation.hpp"

namespace recon::mpm {

template <int D>
class View {
 public:
  // The numbers of each part, one part after the other; the same on all parts.
  using Gather = std::function<std::vector<double>(const std::vector<double>& of_this_part)>;

  // One whole.
  View(const Simulation<D>& simulation)  // NOLINT: a simulation is a view of itself
      : View(simulation.state(), simulation.stepper(), simulation.mapped()) {}
  // One whole, or with `gather` a part, whose own particles have these numbers in the problem,
  // which ascend. `mapped`: whether the nodes of the step are those of the state. All that is given
  // must outlive the view.
  View(const State<D>& state, const Step<D>& step, bool mapped,
       const std::vector<std::uint32_t>* numbers = nullptr, Gather gather = {})
      : state_(&state),
        step_(&step),
        mapped_(mapped),
        numbers_(numbers),
        gather_(std::move(gather)) {}

  const State<D>& state() const { return *state_; }
  const Particles<D>& particles() const { return state_->particles; }
  const Step<D>& step() const { return *step_; }
  const Problem<D>& problem() const { return step_->problem(); }
  const Nodes<D>& nodes() const { return step_->nodes(); }
  bool is_whole() const { return !gather_; }

  // Throws InvalidArgument, in the name of `what`, unless the nodes are those of the state.
  void require_mapped(const char* what) const;
  // Where the particle with this number in the problem is among the own ones; none: it is of
  // another part.
  std::optional<std::size_t> place_of(std::size_t number) const;
  // The number in the problem of an own particle.
  std::size_t number_of(std::size_t place) const { return numbers_ ? (*numbers_)[place] : place; }

  // The numbers of all parts; each becomes the sum of those of all parts.
  std::vector<double> of_all(std::vector<double> of_this_part) const;
  void sum(std::span<double> numbers) const;

 private:
  const State<D>* state_;
  const Step<D>* step_;
  bool mapped_;
  const std::vector<std::uint32_t>* numbers_;
  Gather gather_;
};

extern template class View<1>;
extern template class View<2>;
extern template class View<3>;

}  // namespace recon::mpm
