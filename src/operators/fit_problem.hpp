// What a reconstruction keeps: whom it asks (the cloud), what was asked (options, targets), and
// what derivatives need later.
//
// Targets are put in an order in which those that follow each other are close in space: all work
// then finds what it needs in the cache. Here "target" means a number in that order and "particle"
// a place in the cloud; the pattern that make_pattern() leaves speaks of the caller's particles.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "neighbourhood/cloud.hpp"
#include "recon/operators/csr_operator.hpp"
#include "recon/operators/fit_summary.hpp"
#include "recon/operators/functional.hpp"
#include "recon/shape/options.hpp"
#include "recon/shape/shape_kernel.hpp"

namespace recon::detail {

// The radii or packed tensors that a rule refers to.
struct OwnSupports {
  std::vector<double> targets, particles;

  void clear() {
    targets.clear();
    particles.clear();
  }
};

template <class Scalar>
class FitProblem {
 public:
  // Throws InvalidArgument for options outside their range.
  FitProblem(std::shared_ptr<const Cloud<Scalar>> cloud, const Options& options);

  // One of the same cloud and choices, the latest rule among them, without targets.
  std::shared_ptr<FitProblem> another() const;

  // Takes the targets, and with them a rule that replaces that of the options for good, or
  // neighbours of the caller's. Throws InvalidArgument for what is wrong with them, and then leaves
  // all as it was.
  void take(const PointsView<Scalar>& targets, const NeighbourRule* rule);
  void take(const PointsView<Scalar>& targets, NeighbourList<Scalar> neighbours);
  // Finds the neighbours of the targets taken and fits, into the memory of older values and of a
  // pattern that nobody else holds.
  // Where the search or a fit throws, there are no targets afterwards, and the rule of before holds.
  void fit(Array<Scalar> values);

  // Gives back the memory that is kept for the next fit.
  void forget_buffers();

  const Options& options() const { return options_; }
  bool has_own_neighbours() const { return own_neighbours_; }
  int dimension() const { return cloud_->points().dimension(); }

  // The results of the latest fit.
  const std::shared_ptr<SparsityPattern<Scalar>>& pattern() const { return pattern_; }
  Array<Scalar> give_up_values() { return std::move(values_); }
  // Of the caller's targets.
  const FitReports& reports() const { return reports_; }

  // First derivatives of a kind and second derivatives, D and D (D + 1) / 2 numbers for each entry
  // of the pattern; null where they are not wanted.
  void derivatives(Derivative kind, Array<Scalar>* first, Array<Scalar>* second) const;

  // The numbers of these functionals of the local polynomial, side by side for each entry of the
  // pattern.
  Array<Scalar> functionals(std::span<const OwnFunctional::Action> asked) const;

 private:
  void fit_taken();
  void abandon();
  void require_dimension(const PointsView<Scalar>& targets) const;
  void order_targets();
  void make_pattern();

  std::size_t caller_target(std::size_t t) const { return target_of_.empty() ? t : target_of_[t]; }
  NeighbourOptions search_options() const;
  // The rule, with its radii or tensors kept here.
  NeighbourRule with_kept_supports(const NeighbourRule& rule);
  // The rule for the targets in this order; `supports` keeps what it refers to.
  NeighbourRule ordered_rule(std::vector<double>& supports) const;
  ShapeProblem<Scalar> shape_problem(const PointCloud<Scalar>& at,
                                     const NeighbourListView<Scalar>& list) const;
  // Evaluates rows of the kernel at the targets of the pattern.
  template <class Rows>
  void evaluate(const Rows& rows) const;
  // Fits the targets of a list; `values` per entry and `reports` per target.
  void fit_list(const PointCloud<Scalar>& at, const NeighbourList<Scalar>& list,
                const Progress& progress, Array<Scalar>& values, Array<FitReport>& reports) const;
  void fit_rows(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                Array<Scalar>& values, Array<FitReport>& reports) const;
  // Finds the neighbours of the targets and, where the search goes along with that, fits each block
  // of them while all that belongs to it is in the cache. Returns whether it has. With `last`
  // nothing is asked of the list afterwards: the indices of these rows become the caller's.
  bool fits_while_finding() const;
  bool find_and_fit(const NeighbourRule& rule, const NeighbourOptions& search, bool last);
  bool is_too_far(std::size_t t) const { return !too_far_.empty() && too_far_[t]; }

  // Targets farther from every particle than Options::max_distance lose their neighbours.
  void mark_too_far(bool complete, const NeighbourOptions& search);
  // Enlarges the supports of targets that miss the asked degree. True where any has been replaced.
  bool grow(const NeighbourRule& rule, const NeighbourOptions& search);
  // Gives targets without support the nearest visible particle, with weight one.
  void use_nearest(const NeighbourOptions& search);

  std::shared_ptr<const Cloud<Scalar>> cloud_;
  Options options_;
  OwnSupports supports_;  // of the caller's targets and particles
  NeighbourRule rule_;    // refers to supports_
  NeighbourRule rule_before_ = Nearest{1};
  NeighbourList<Scalar> given_;  // the caller's, until fit() takes it
  std::shared_ptr<const ShapeKernel<Scalar>> kernel_;
  bool own_neighbours_ = false;

  PointCloud<Scalar> incoming_, targets_;
  CountingSort sort_;
  std::vector<double> ordered_supports_;
  Array<std::uint32_t> target_of_;    // until make_pattern() takes it
  NeighbourList<Scalar> neighbours_;  // likewise
  Array<Scalar> values_;
  Array<FitReport> row_reports_;  // in the order of the targets here
  FitReports reports_;
  bool indices_are_callers_ = false;         // those of neighbours_; else they are places
  std::vector<std::uint32_t> nearest_rows_;  // targets that have the value of the nearest particle
  std::vector<bool> too_far_;                // empty: none is
  std::shared_ptr<SparsityPattern<Scalar>> pattern_;
};

extern template class FitProblem<float>;
extern template class FitProblem<double>;

}  // namespace recon::detail
