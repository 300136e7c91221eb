// The particles of a GPU in the order of cells, for any executor (host.hpp).
#pragma once

#include <memory>
#include <string>

#include "cuda/fold.hpp"
#include "cuda/layout.hpp"
#include "recon/neighbourhood/sources.hpp"

namespace recon::cuda {

// What a search reads.
template <int D, class T>
struct CloudView {
  const Layout<T>* layout;
  const std::uint32_t* first;  // of each cell
  const T* x;                  // [place][axis]
  std::uint32_t count;
  Frame<D, T> frame;
};

// Throws InvalidArgument for what Trouble says of points that stand at `x`, [point][axis].
template <int D, class T, class Executor>
void refuse_bad_points(Executor& executor, const Trouble& trouble, const T* x, const char* name) {
  if (trouble.not_finite != none) {
    T own[D];
    executor.to_host(x + std::size_t{trouble.not_finite} * D, own, D);
    for (int d = 0; d < D; ++d)
      if (!std::isfinite(own[d]))
        detail::throw_invalid(detail::coordinate_name(trouble.not_finite, d, name), own[d],
                              "must be finite");
  }
  detail::require(trouble.too_large == none, name, "too large",
                  "must have coordinates whose squares can be represented");
}

template <class Executor, int D, class T>
class SourcesOn {
 public:
  SourcesOn(std::shared_ptr<Executor> executor, const Points<D, T>& points,
            const SourcesOptions& options)
      : executor_(std::move(executor)) {
    options.validate();
    options.domain.validate(D);
    detail::require(options.particle_weights.empty(), "particle_weights",
                    options.particle_weights.size(), "must be empty on a GPU: there are none yet");
    for (int d = 0; d < D; ++d) {
      frame_.stretch[d] = options.stretch[d];
      frame_.periodic[d] = options.domain.periodic[d];
      frame_.lower[d] = static_cast<T>(options.domain.lower[d] / options.stretch[d]);
      frame_.upper[d] = static_cast<T>(options.domain.upper[d] / options.stretch[d]);
      frame_.period[d] = frame_.upper[d] - frame_.lower[d];
    }
    executor_->provide(trouble_, 1);
    executor_->provide(layout_, 1);
    update(points);
  }
  SourcesOn(const SourcesOn&) = delete;
  SourcesOn& operator=(const SourcesOn&) = delete;

  void update(const Points<D, T>& points) {
    points.validate("points");
    count_ = points.count;
    ++version_;
    Executor& run = *executor_;
    const std::size_t n = count_, cells = static_cast<std::size_t>(detail::most_cells(n));
    for (auto* array : {&incoming_, &x_}) run.provide(*array, n * D);
    for (auto* array : {&key_, &order_, &place_}) run.provide(*array, n);
    run.provide(first_, cells + 1);
    run.for_each(1, Forget{trouble_.data()});
    run.for_each(n, Load<D, T>{points, frame_, incoming_.data(), trouble_.data()});
    const Extent<T>* box = nullptr;
    if (n > 0) {
      box = fold<Extent<T>>(run, boxes_, n, ExtentOf<D, T>{incoming_.data()}, JoinExtents<D, T>{});
    } else {
      run.provide(boxes_, 1);
      run.for_each(1, NoExtent<T>{boxes_.data()});
      box = boxes_.data();
    }
    run.for_each(1, ChooseCells<D, T>{box, n, frame_, layout_.data(), trouble_.data()});
    sort(incoming_.data(), n, key_, order_);
    run.for_each(n, Permute<D, T>{incoming_.data(), order_.data(), x_.data()});
    run.for_each(n, PlaceOf{order_.data(), place_.data()});
    using First = FirstOfEach<CellsOfLayout<T>>;
    run.for_each(n + 1, First{key_.data(), n, {layout_.data()}, first_.data()});
  }

  // The numbers of points, in the order of the cells that they lie in or nearest to, into `order`.
  void sort(const T* x, std::size_t n, typename Executor::template Array<std::uint32_t>& key,
            typename Executor::template Array<std::uint32_t>& order) {
    executor_->for_each(n, Key<D, T>{x, layout_.data(), key.data(), order.data()});
    executor_->sort(key, order, n, bits_of(static_cast<std::uint64_t>(detail::most_cells(count_))));
  }

  // Waits, and throws InvalidArgument for coordinates that are not finite, or too large.
  void check() {
    Trouble trouble;
    executor_->to_host(trouble_.data(), &trouble, 1);
    refuse_bad_points<D>(*executor_, trouble, incoming_.data(), "points");
  }

  std::size_t size() const { return count_; }
  std::uint64_t version() const { return version_; }
  const Frame<D, T>& frame() const { return frame_; }
  const std::shared_ptr<Executor>& executor() const { return executor_; }
  CloudView<D, T> view() const {
    return {layout_.data(), first_.data(), x_.data(), static_cast<std::uint32_t>(count_), frame_};
  }
  // The caller's number of the particle at each place, and the place of each particle.
  const std::uint32_t* order() const { return order_.data(); }
  const std::uint32_t* place() const { return place_.data(); }

 private:
  template <class U>
  using Array = typename Executor::template Array<U>;

  std::shared_ptr<Executor> executor_;
  Frame<D, T> frame_;
  std::size_t count_ = 0;
  std::uint64_t version_ = 0;
  Array<T> incoming_, x_;  // [point][axis], by number and by place
  Array<std::uint32_t> key_, order_, place_, first_;
  Array<Extent<T>> boxes_;
  Array<Layout<T>> layout_;
  Array<Trouble> trouble_;
};

}  // namespace recon::cuda
