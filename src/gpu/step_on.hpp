// The step of the method in the memory of an executor (cuda/host.hpp): Step and its policies of
// mpm/, loop by loop, over the same bodies (mpm/pointwise.hpp) and the same functions of the grid.
//
// Everything stays there between steps; a step brings back which particle could not go on.
#pragma once

#include <utility>

#include "cuda/fold.hpp"
#include "cuda/layout.hpp"
#include "gpu/cells.hpp"
#include "gpu/corners.hpp"
#include "gpu/device_step.hpp"
#include "gpu/grid_fit.hpp"

namespace recon::mpm {

// Stands for the functions of particles whose corners move with the grid.
struct MovingCorners {};

// Calls work(functions) with the functions of a domain and basis that have a form for a GPU.
template <class Work>
void with_functions_on_gpu(const Method& method, const Work& work) {
  if (method.domain == Domain::cpdi2) return work(MovingCorners{});
  if (method.basis == Basis::bspline2) return work(SplineFunctions<2>{{method.border}});
  if (method.basis == Basis::bspline3) return work(SplineFunctions<3>{{method.border}});
  if (method.basis == Basis::mls_bspline2) return work(MomentSplineFunctions{{{method.border}}});
  return work(LinearFunctions{});
}

template <class Executor, int D>
class StepOn final : public DeviceStep<D> {
  template <class U>
  using Array = typename Executor::template Array<U>;

 public:
  StepOn(std::shared_ptr<Executor> executor, Plan<D>&& plan)
      : executor_(std::move(executor)), plan_(std::move(plan)) {
    Executor& run = *executor_;
    const std::size_t count = plan_.grid.node_count(), vectors = count * D;
    for (auto* array : {&mass_, &stiffness_}) run.provide(*array, count);
    for (auto* array : {&momentum_, &force_, &mapped_, &velocity_, &acceleration_, &straining_})
      run.provide(*array, vectors);
    if (plan_.method.has_light_nodes()) run.provide(internal_, vectors);
    run.provide(first_, plan_.grid.cell_count() + 1);
    run.provide(lost_, 1);
    materials_on_host_.reserve(plan_.materials.size());
    for (const Material& each : plan_.materials) materials_on_host_.emplace_back(each);
    copy(materials_on_host_, materials_);
    copy(plan_.walls, walls_);
    copy(plan_.held, held_);
    if (with_corners()) copy(std::vector<CornerGauss<D>>(1), gauss_);
    if (over_cells()) {
      const std::size_t cells = plan_.grid.cell_count();
      for (auto* array : {&volumes_, &fill_}) run.provide(*array, cells);
      run.provide(signs_of_nodes_, count);
      run.provide(watched_, 1);
    }
  }

  void put(const State<D>& s) override {
    Executor& run = *executor_;
    particles_.put(run, s.particles, plan_.kept);
    const std::size_t n = particles_.size(), corners = n << D;
    for (auto* array : {&key_, &order_}) run.provide(*array, with_corners() ? corners : n);
    if (with_corners()) {
      run.provide(given_by_corner_, corners);
      if (plan_.kept.modes > 0) run.provide(slopes_by_corner_, corners);
    } else {
      run.provide(given_, n);
      if (plan_.kept.modes > 0) run.provide(slopes_, n);
    }
    time_ = s.time;
    last_dt_ = s.last_dt;
    steps_ = s.steps;
    is_mapped_ = false;
    signs_ = {};
    if (over_cells()) {
      run.provide(cell_data_, n * static_cast<std::size_t>(cell_components<D>));
      run.for_each(plan_.grid.node_count(), NoSign{signs_of_nodes_.data()});
    }
    if (!with_fits() && !over_cells()) return;
    sources_ = std::make_shared<cuda::SourcesOn<Executor, D, double>>(executor_, points(),
                                                                      SourcesOptions{.threads = 1});
    if (with_fits()) velocities_.emplace(sources_, plan_.nodes, D, Weight::cubic_b_spline);
    if (over_cells())
      centres_.emplace(sources_, plan_.centres, cell_components<D>, Weight::quadratic_b_spline);
  }
  void bring(State<D>& s) override {
    particles_.bring(*executor_, s.particles, plan_.kept);
    s.time = time_;
    s.last_dt = last_dt_;
    s.steps = steps_;
  }

  TimeStep choose_step() override {
    if (plan_.time.rule == StepRule::fixed) return {plan_.time.step, 0};
    using Of = AllowedStep<D>;
    const Allowed* const shortest = cuda::fold<Allowed>(
        *executor_, allowed_, particles_.size(),
        Of{particles_.numbers(), materials_.data(), plan_.time.rule, plan_.courant, plan_.grid.h()},
        Shorter{});
    Allowed found;
    executor_->to_host(shortest, &found, 1);
    return {found.dt, found.particle};
  }

  void map() override {
    if (is_mapped_) return;
    with_functions_on_gpu(plan_.method, [&](const auto& functions) { to_nodes(functions); });
    is_mapped_ = true;
  }

  std::optional<Stopped> step(double dt) override {
    map();
    is_mapped_ = false;
    executor_->for_each(1, NothingLost{lost_.data()});
    with_functions_on_gpu(plan_.method,
                          [&](const auto& functions) { to_particles(functions, dt); });
    return stopped(lost());
  }

  std::size_t unfitted() override {
    if (!with_fits()) return 0;
    map();
    const std::uint32_t* const sum =
        cuda::fold<std::uint32_t>(*executor_, unfitted_, plan_.grid.node_count(),
                                  IsUnfitted{mass_.data(), velocities_->supported()}, Sum{});
    std::uint32_t found = 0;
    executor_->to_host(sum, &found, 1);
    return found;
  }
  MassSigns signs() const override { return signs_; }

 private:
  bool with_fits() const { return is_fit(plan_.method.velocity); }
  bool over_cells() const { return plan_.method.quadrature == Quadrature::cells; }
  cuda::Points<D, double> points() { return {particles_.numbers().x, particles_.size()}; }
  bool with_corners() const { return plan_.method.domain == Domain::cpdi2; }
  Lost lost() {
    Lost found;
    executor_->to_host(lost_.data(), &found, 1);
    return found;
  }
  // The one that a loop over blocks of particles would meet first, in which particles are strained
  // before they are looked for in the grid.
  static std::optional<Stopped> stopped(const Lost& lost) {
    constexpr std::uint32_t block = 1024;
    if (lost.turned == cuda::none && lost.off_grid == cuda::none) return {};
    if (lost.turned != cuda::none && lost.turned / block <= lost.off_grid / block)
      return Stopped{lost.turned, true};
    return Stopped{lost.off_grid, false};
  }

  template <class U>
  void copy(const std::vector<U>& from, Array<U>& to) {
    executor_->provide(to, from.size());
    if (!from.empty()) executor_->to_device(from.data(), to.data(), from.size());
  }

  NodeNumbers nodes() {
    const bool light = plan_.method.has_light_nodes();
    return {mass_.data(),
            momentum_.data(),
            force_.data(),
            light ? internal_.data() : nullptr,
            light ? stiffness_.data() : nullptr,
            mapped_.data(),
            velocity_.data(),
            acceleration_.data(),
            straining_.data()};
  }

  // Step::to_nodes().
  template <class Functions>
  void to_nodes(const Functions& functions) {
    Executor& run = *executor_;
    const std::size_t count = plan_.grid.node_count();
    sum_to_nodes(functions);
    if (with_fits() || over_cells()) sources_->update(points());
    if (over_cells()) sum_over_cells();
    heaviest_at_ =
        cuda::fold<double>(run, heaviest_, count, SizeOfMass{mass_.data()}, cuda::Larger{});
    if (over_cells()) watch();
    if (with_fits()) velocities_->fit(particles_.numbers().v);
    MoveNode<D> move{nodes(),
                     heaviest_at_,
                     {},
                     plan_.damping,
                     plan_.damping.any(),
                     with_fits() ? velocities_->values() : nullptr,
                     with_fits() ? velocities_->supported() : nullptr};
    for (int d = 0; d < D; ++d) move.gravity[d] = plan_.gravity[d];
    run.for_each(count, move);
    const double lag = plan_.method.velocity_lag(last_dt_);
    give(time_ - lag, velocity_);
    drive(time_ - lag, time_);
  }

  // Mass, momentum and internal force of nodes.
  template <class Functions>
  void sum_to_nodes(const Functions& functions) {
    Executor& run = *executor_;
    const ParticleNumbers<D> particles = particles_.numbers();
    const std::size_t n = particles_.size();
    sort_by_cells(particles.x, n);
    GivenSlope<D>* const slopes = plan_.kept.modes > 0 ? slopes_.data() : nullptr;
    run.for_each(n,
                 MakeGiven<D>{particles, materials_.data(), order_.data(), given_.data(), slopes});
    run.for_each(plan_.grid.node_count(),
                 SumToNodes<D, Functions>{plan_.grid, functions, first_.data(), given_.data(),
                                          slopes, nodes()});
  }
  void sum_to_nodes(MovingCorners) {
    Executor& run = *executor_;
    const ParticleNumbers<D> particles = particles_.numbers();
    const std::size_t n = particles_.size();
    sort_by_cells(particles.corners, n << D);
    GivenSlopeByCorner<D>* const slopes = plan_.kept.modes > 0 ? slopes_by_corner_.data() : nullptr;
    run.for_each(n,
                 MakeGivenByCorners<D>{gauss_.data(), particles, given_by_corner_.data(), slopes});
    run.for_each(plan_.grid.node_count(),
                 SumCornersToNodes<D>{plan_.grid, first_.data(), order_.data(),
                                      given_by_corner_.data(), slopes, nodes()});
  }
  // Mass and internal force of the nodes from fits at the middles of cells, in place of those of
  // the particles (points, which have just been sorted); QuadraturePolicy::over_cells().
  void sum_over_cells() {
    Executor& run = *executor_;
    const ParticleNumbers<D> particles = particles_.numbers();
    const std::size_t cells = plan_.grid.cell_count();
    run.for_each(particles_.size(), MakeCellData<D>{particles, cell_data_.data()});
    run.for_each(cells, SumVolumes<D>{first_.data(), order_.data(), particles, volumes_.data()});
    run.for_each(cells, FillCells<D>{plan_.grid, volumes_.data(), fill_.data()});
    centres_->fit(cell_data_.data());
    run.for_each(plan_.grid.node_count(),
                 SumCellsToNodes<D>{plan_.grid, fill_.data(), centres_->values(), nodes()});
  }
  // MassPolicy::watch().
  void watch() {
    Executor& run = *executor_;
    run.for_each(1, NothingWatched{watched_.data()});
    run.for_each(plan_.grid.node_count(),
                 WatchMass{mass_.data(), heaviest_at_, signs_of_nodes_.data(), watched_.data()});
    Watched found;
    run.to_host(watched_.data(), &found, 1);
    const auto note = [&](std::uint32_t node, std::optional<NegativeMass>& first) {
      if (node == cuda::none || first) return;
      first = NegativeMass{steps_, node, 0};
      run.to_host(mass_.data() + node, &first->mass, 1);
    };
    note(found.negative, signs_.negative);
    note(found.change, signs_.change);
  }
  // The order of so many points by the cells that they lie in, and where each cell begins in it.
  void sort_by_cells(const double* x, std::size_t n) {
    Executor& run = *executor_;
    const std::size_t cells = plan_.grid.cell_count();
    run.for_each(n, KeyOfParticle<D>{plan_.grid, x, key_.data(), order_.data()});
    run.sort(key_, order_, n, cuda::bits_of(cells - 1));
    using First = cuda::FirstOfEach<cuda::Known>;
    run.for_each(n + 1, First{key_.data(), n, {static_cast<std::int64_t>(cells)}, first_.data()});
  }

  // Held components of a velocity become those of a time; BoundaryPolicy::give().
  void give(double time, Array<double>& of_nodes) {
    hold(plan_.held_velocities(time), held_velocities_, of_nodes);
  }
  // Their accelerations become what changes them from one time to another; BoundaryPolicy::drive().
  void drive(double before, double after) {
    std::vector<double> change(plan_.held.size(), 0);
    if (after > before) {
      const std::vector<double> from = plan_.held_velocities(before);
      const std::vector<double> to = plan_.held_velocities(after);
      for (std::size_t h = 0; h < change.size(); ++h)
        if (plan_.held[h].varies) change[h] = (to[h] - from[h]) / (after - before);
    }
    hold(std::move(change), held_accelerations_, acceleration_);
  }
  // What is on the executor already is not copied again.
  struct OnBoth {
    std::vector<double> here;
    Array<double> there;
  };
  void hold(std::vector<double>&& values, OnBoth& kept, Array<double>& of_nodes) {
    if (values.empty()) return;
    if (values != kept.here) {
      kept.here = std::move(values);
      copy(kept.here, kept.there);
    }
    executor_->for_each(kept.here.size(),
                        Hold<D>{held_.data(), kept.there.data(), of_nodes.data()});
  }

  // Step::to_particles(): flip and pic.
  template <class Functions>
  void to_particles(const Functions& functions, double dt) {
    Executor& run = *executor_;
    const Method& method = plan_.method;
    const std::size_t count = plan_.grid.node_count();
    const double kick = method.kick(last_dt_, dt);
    const double before = time_ - method.velocity_lag(last_dt_), after = before + kick;
    drive(before, after);
    run.for_each(count * D, KickNumber{kick, acceleration_.data(), velocity_.data()});
    const auto take = [&](const Array<double>& carried, const Array<double>& straining,
                          Taken taken) {
      take_with(functions, [&](const auto& of_points) {
        return TakeFromNodes<D, std::decay_t<decltype(of_points)>>{
            plan_.grid,
            of_points,
            particles_.numbers(),
            materials_.data(),
            plan_.kept.history,
            walls_.data(),
            static_cast<int>(plan_.walls.size()),
            carried.data(),
            straining.data(),
            acceleration_.data(),
            kick,
            method.pic_part(kick),
            dt,
            taken,
            lost_.data()};
      });
    };
    switch (method.stress) {
      case StressUpdate::last:
        if (method.has_light_nodes()) {
          run.for_each(count, LimitStrain<D>{nodes(), heaviest_at_, kick, dt});
          give(after, straining_);
          take(velocity_, straining_, {});
        } else {
          take(velocity_, velocity_, {});
        }
        tick(dt);
        break;
      case StressUpdate::musl:
        run.for_each(count * D, CopyNumber{velocity_.data(), straining_.data()});
        take(velocity_, velocity_, {.strain = false, .position = false});
        to_nodes(functions);
        give(after, velocity_);
        take(straining_, velocity_, {.velocity = false});
        tick(dt);
        break;
      case StressUpdate::first:
        take(velocity_, velocity_, {.strain = false});
        tick(dt);
        if (stopped(lost())) return;  // a place that is none has no nodes
        to_nodes(functions);
        take(velocity_, velocity_, {.velocity = false, .position = false});
    }
  }

  // The particles take by these functions; make(functions) is what does it for points.
  template <class Functions, class Make>
  void take_with(const Functions& functions, const Make& make) {
    executor_->for_each(particles_.size(), make(functions));
  }
  template <class Make>
  void take_with(MovingCorners, const Make& make) {
    executor_->for_each(particles_.size(),
                        TakeByCorners<D>{gauss_.data(), make(LinearFunctions{})});
  }

  void tick(double dt) {
    time_ += dt;
    last_dt_ = dt;
    ++steps_;
  }

  std::shared_ptr<Executor> executor_;
  Plan<D> plan_;
  double time_ = 0, last_dt_ = 0;
  std::int64_t steps_ = 0;

  ParticleArrays<Executor, D> particles_;
  std::vector<MaterialOnGpu> materials_on_host_;
  Array<MaterialOnGpu> materials_;
  Array<WallNumbers<D>> walls_;
  Array<HeldNode> held_;
  OnBoth held_velocities_, held_accelerations_;
  Array<std::uint32_t> key_, order_, first_;
  Array<GivenByPoint<D>> given_;
  Array<GivenSlope<D>> slopes_;
  Array<GivenByCorner<D>> given_by_corner_;
  Array<GivenSlopeByCorner<D>> slopes_by_corner_;
  Array<CornerGauss<D>> gauss_;
  // Of nodes; straining_ keeps what carries particles where the map is asked twice.
  Array<double> mass_, stiffness_, momentum_, force_, internal_, mapped_, velocity_, acceleration_,
      straining_;
  bool is_mapped_ = false;  // whether nodes are those of the state
  // Of fits, and of quadratures over cells.
  std::shared_ptr<cuda::SourcesOn<Executor, D, double>> sources_;
  std::optional<GridFitOn<Executor, D>> velocities_, centres_;
  Array<double> volumes_, fill_, cell_data_;
  Array<signed char> signs_of_nodes_;
  Array<Watched> watched_;
  MassSigns signs_;
  Array<std::uint32_t> unfitted_;
  Array<double> heaviest_;
  const double* heaviest_at_ = nullptr;
  Array<Allowed> allowed_;
  Array<Lost> lost_;
};

}  // namespace recon::mpm
