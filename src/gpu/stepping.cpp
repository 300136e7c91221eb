#include "gpu/stepping.hpp"

#include "mpm/policies.hpp"
#include "runs/frame_fields.hpp"
#include "runs/stepping.hpp"

namespace recon::mpm {
namespace {

// A simulation whose state is elsewhere. What is measured and written goes by a copy of it here,
// and by the nodes to which the processor maps that.
template <int D>
class Elsewhere final : public Stepping<D> {
 public:
  Elsewhere(Problem<D>&& problem, const MakeStep<D>& make)
      : state_(start(std::move(problem))),
        mapping_(std::move(problem), state_.particles.size()),
        there_(make(Plan<D>(mapping_.problem()))) {
    there_->put(state_);
  }

  TimeStep choose_step() override { return there_->choose_step(); }
  void map() override { there_->map(); }
  void step(double dt) override {
    here_ = false;
    if (const auto stopped = there_->step(dt)) {
      // With stress first, strain follows when the step has been counted.
      const bool counted = stopped->turned && problem().method.stress == StressUpdate::first;
      const std::int64_t steps = state_.steps + (counted ? 1 : 0);
      there_->bring(state_);
      const std::size_t p = stopped->particle;
      if (stopped->turned) throw turned_inside_out(steps, p, state_.particles.F[p].determinant());
      throw off_grid<D>(steps, p, state_.particles.x[p]);
    }
    state_.tick(dt);
  }
  View<D> view() const override {
    if (!here_) {
      there_->bring(state_);
      mapping_.to_nodes(state_);
      here_ = true;
    }
    return {state_, mapping_, true};
  }
  typename Stepping<D>::Clock clock() const override {
    return {state_.time, state_.last_dt, state_.steps};
  }
  const Problem<D>& problem() const override { return mapping_.problem(); }
  void sum(std::span<double>) const override {}  // there is one process
  double unfitted() const override { return static_cast<double>(there_->unfitted()); }
  bool writes() const override { return true; }

  typename Stepping<D>::Restart read_checkpoint(const std::filesystem::path& path,
                                                const Formulas& formulas) override {
    Problem<D> problem = mapping_.problem();
    problem.particles = state_.particles;
    Simulation<D> whole(std::move(problem));
    RunState state = mpm::read_checkpoint(path, whole, formulas);
    state_ = whole.state();
    there_->put(state_);
    here_ = false;
    return {std::move(state), forecast(whole.problem(), state_)};
  }
  void write_checkpoint(const std::filesystem::path& path, const Formulas& formulas,
                        const RunState& state) override {
    mpm::write_checkpoint(path, mapping_.problem(), view().state(), formulas, state);
  }
  void write_frame(const std::filesystem::path& folder, const std::string& name,
                   std::vector<double>& times, const FrameOptions& options) override {
    write_frame_of(folder, name, view(), times, options);
  }
  MassSigns signs() const override { return there_->signs(); }

 private:
  // The clock of the state is always right; its particles, and the nodes, where here_ says so.
  mutable State<D> state_;
  mutable Step<D> mapping_;
  mutable bool here_ = false;
  std::unique_ptr<DeviceStep<D>> there_;
};

}  // namespace

template <int D>
RunResult run_with(const MakeStep<D>& make, ProblemFile<D> file, const RunOptions& options) {
  require_form_on_gpu(file.problem);
  return run<D>(std::move(file), options, {[&](Problem<D>&& problem) {
                  return std::make_unique<Elsewhere<D>>(std::move(problem), make);
                }});
}

#define RECON_INSTANTIATE(D) \
  template RunResult run_with(const MakeStep<D>&, ProblemFile<D>, const RunOptions&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
