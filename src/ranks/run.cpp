#include "recon/ranks/run.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "petsc/call.hpp"
#include "ranks/votes.hpp"
#include "recon/ranks/distributed_simulation.hpp"
#include "runs/identity.hpp"
#include "runs/stepping.hpp"

namespace recon::mpm {
namespace {

// A number that is the same for the same bytes, and hardly ever for others.
class Fingerprint {
 public:
  void add(const void* data, std::size_t bytes) {
    for (std::size_t at = 0; at < bytes; at += sizeof value_) {
      std::uint64_t word = 0;
      std::memcpy(&word, static_cast<const char*>(data) + at, std::min(sizeof word, bytes - at));
      value_ = (value_ ^ word) * 1099511628211u;
      value_ ^= value_ >> 32;
    }
  }
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(double number) { add(&number, sizeof number); }
  // Which a double has to the last bit.
  double number() const { return static_cast<double>(value_ >> 11); }

 private:
  std::uint64_t value_ = 14695981039346656037u;
};

// Throws InvalidArgument where a number is not the same on all ranks.
void require_same(Votes& votes, double number, const char* argument) {
  const double most = votes.vote(number), least = -votes.vote(-number);
  recon::detail::require(most == least, argument, "different on some ranks",
                         "must be the same on all ranks");
}

template <int D>
void require_same(Votes& votes, const ProblemFile<D>& file, const RunOptions& options) {
  const auto require_path = [&](const std::filesystem::path& path, const char* argument) {
    Fingerprint print;
    print.add(path.string());
    require_same(votes, print.number(), argument);
  };
  require_path(options.folder, "folder");
  require_path(options.restart, "restart");
  Fingerprint print;
  const Problem<D>& problem = file.problem;
  print.add(to_text(identity_of(problem, problem.particles, file.formulas)));
  problem.particles.arrays(problem.kept(), [&](const ParticleArray&, const auto& values) {
    using T = typename std::decay_t<decltype(values)>::value_type;
    print.add(values.data(), values.size() * sizeof(T));
  });
  const TimeOptions& time = problem.time;
  for (const double each :
       {time.end, static_cast<double>(time.rule), time.courant.value_or(-1), time.step,
        time.rest.value_or(-1), file.limits.steps, static_cast<double>(file.output.frames),
        static_cast<double>(file.output.ledger), file.output.probe_interval,
        static_cast<double>(file.output.probe_every)})
    print.add(each);
  print.add(probes_header(file.probes));
  require_same(votes, print.number(), "problem");
}

int ranks_of_this_machine(const petsc::Communicator& ranks) {
  MPI_Comm here = MPI_COMM_NULL;
  RECON_MPI(MPI_Comm_split_type(ranks.get(), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here));
  int count = 1;
  RECON_MPI(MPI_Comm_size(here, &count));
  RECON_MPI(MPI_Comm_free(&here));
  return count;
}

// A simulation that is spread over ranks.
template <int D>
class OnRanks final : public Stepping<D> {
 public:
  // A restart is compared with the particles of the problem, which are kept until it has been read.
  OnRanks(Votes& votes, Problem<D>&& problem, bool restarts)
      : votes_(votes),
        particles_(restarts ? problem.particles : Particles<D>()),
        parts_(votes.ranks(), std::move(problem)) {}

  TimeStep choose_step() override { return parts_.choose_step(); }
  void map() override { parts_.map(); }
  void step(double dt) override {
    parts_.step(dt);
    ++steps_;
  }
  View<D> view() const override { return parts_.view(); }
  bool writes() const override { return parts_.ranks().rank() == 0; }
  void agree() override { votes_.vote(); }

  // Every rank reads it, and keeps what is its own.
  typename Stepping<D>::Restart read_checkpoint(const std::filesystem::path& path,
                                                const Formulas& formulas) override {
    Problem<D> problem = parts_.problem();
    problem.particles = std::move(particles_);
    Simulation<D> whole(std::move(problem));
    RunState state = mpm::read_checkpoint(path, whole, formulas);
    parts_.restore(whole.state());
    return {std::move(state), forecast(whole.problem(), whole.state())};
  }
  void write_checkpoint(const std::filesystem::path& path, const Formulas& formulas,
                        const RunState& state) override {
    const State<D> whole = parts_.gather();
    if (writes()) mpm::write_checkpoint(path, parts_.problem(), whole, formulas, state);
  }
  void write_frame(const std::filesystem::path& folder, const std::string& name,
                   std::vector<double>& times, const FrameOptions& options) override {
    parts_.write_frame(folder, name, times, options);
  }

  MassSigns signs() const override { return parts_.signs(); }
  std::optional<Spread> spread() const override;

 private:
  Votes& votes_;
  Particles<D> particles_;
  DistributedSimulation<D> parts_;
  std::int64_t steps_ = 0;
};

template <int D>
std::optional<Spread> OnRanks<D>::spread() const {
  const View<D> all = view();
  const Traffic sent = parts_.traffic();
  const auto own = static_cast<double>(all.state().own());
  const std::vector<double> each =
      all.of_all({own, static_cast<double>(sent.copies), static_cast<double>(sent.bytes)});
  Spread spread;
  spread.ranks = parts_.ranks().size();
  spread.least = spread.most = static_cast<std::size_t>(each[0]);
  double bytes = 0;
  for (std::size_t i = 0; i < each.size(); i += 3) {
    spread.least = std::min(spread.least, static_cast<std::size_t>(each[i]));
    spread.most = std::max(spread.most, static_cast<std::size_t>(each[i]));
    spread.copies += static_cast<std::size_t>(each[i + 1]);
    bytes += each[i + 2];
  }
  spread.bytes_per_step = bytes / static_cast<double>(std::max<std::int64_t>(steps_, 1));
  return spread;
}

}  // namespace

template <int D>
RunResult run(const petsc::Communicator& ranks, ProblemFile<D> file, const RunOptions& options) {
  require_on_processor(file);
  RunResult result;
  if (ranks.size() == 1) {
    const std::size_t all = file.problem.particles.size();
    result = run<D>(std::move(file), options);
    result.spread = Spread{.ranks = 1, .least = all, .most = all};
    return result;
  }
  Votes votes(ranks);
  votes.together([&] {
    require_same(votes, file, options);
    RunOptions own = options;
    if (ranks.rank() != 0) own.begins = {}, own.progress = {}, own.saved = {};
    // At the start all ranks have all particles, while they are made, and the first one when they are
    // saved; then their parts, with at most as many copies.
    const double here = ranks_of_this_machine(ranks), part = here / ranks.size();
    const double all = 2 * bytes_of_particle<D>(file.problem.kept()) *
                       static_cast<double>(file.problem.particles.size());
    const bool first = ranks.rank() == 0;
    const auto memory = [=](double of_one) {
      return std::max(here * all, 2 * part * of_one + (first ? all : 0));
    };
    result = run<D>(std::move(file), own,
                    {[&](Problem<D>&& problem) {
                       return std::make_unique<OnRanks<D>>(votes, std::move(problem),
                                                           !own.restart.empty());
                     },
                     memory});
  });
  return result;
}

#define RECON_INSTANTIATE(D) \
  template RunResult run(const petsc::Communicator&, ProblemFile<D>, const RunOptions&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
