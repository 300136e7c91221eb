#include "recon/ranks/distributed_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_map>

#include "mpm/policies.hpp"
#include "petsc/call.hpp"
#include "ranks/boxes.hpp"
#include "ranks/frame_pieces.hpp"
#include "ranks/messages.hpp"
#include "ranks/votes.hpp"

namespace recon::mpm {
template <int D>
class DistributedSimulation<D>::Exchange : public OtherParts<D> {
 public:
  Exchange(const petsc::Communicator& ranks, Problem<D> problem)
      : votes(ranks), size_(static_cast<std::size_t>(ranks.size())), to_(size_), from_(size_) {
    votes.together([&] {
      require_parts(problem);
      State<D> whole = start(std::move(problem));
      kept_ = problem.kept();
      messages.emplace(votes, kept_);
      all = whole.particles.size();
      boxes_.emplace(whole.particles.x, ranks.size());
      choose_own(whole);
      problem.particles = {};
      // One rank alone is one whole, to the bit.
      step.emplace(std::move(problem), numbers.size(), ranks.size() > 1 ? this : nullptr);
    });
  }

  // The part of a whole state that is this rank's.
  void choose_own(const State<D>& whole) {
    std::vector<std::size_t> mine;
    for (std::size_t p = 0; p < whole.particles.size(); ++p)
      if (boxes_->rank_of(whole.particles.x[p]) == rank()) mine.push_back(p);
    state = {chosen(whole.particles, kept_, mine), whole.time, whole.last_dt, whole.steps};
    numbers.assign(mine.begin(), mine.end());
    has_lists_ = false;
    mapped = false;
    failed = false;
  }

  // Lets go of the copies.
  void forget_copies() {
    keep_first(state.own(), kept_, state.particles);
    state.others = 0;
  }

  void copy_to(State<D>& s) override {
    votes.vote();
    if (s.others == 0 && !has_lists_) return make_copies(s);
    messages->send_changes(to_, from_, s.own(), s.particles);
  }

  void copy_to(const State<D>& s, std::vector<Vector<D>>& of_particles) override {
    votes.vote();
    messages->send_vectors(to_, from_, s.own(), of_particles);
  }

  void sum(std::span<double> numbers_of_all) override { view().sum(numbers_of_all); }

  // The numbers of each rank, one rank after the other. Each sends as many as the one with most.
  std::vector<double> gather(const std::vector<double>& mine) {
    constexpr double at_once = 1e8;
    const double most = votes.vote(static_cast<double>(mine.size()));
    recon::detail::require(most <= at_once, "numbers of a rank", most,
                           "must be at most 1e8 to be gathered");
    const std::size_t room = static_cast<std::size_t>(most) + 1;
    std::vector<double> sent(room), each(room * size_), found;
    sent[0] = static_cast<double>(mine.size());
    std::copy(mine.begin(), mine.end(), sent.begin() + 1);
    RECON_MPI(MPI_Allgather(sent.data(), static_cast<int>(room), MPI_DOUBLE, each.data(),
                            static_cast<int>(room), MPI_DOUBLE, votes.ranks().get()));
    ++votes.rounds;
    for (auto from = each.begin(); from != each.end(); from += static_cast<std::ptrdiff_t>(room))
      found.insert(found.end(), from + 1, from + 1 + static_cast<std::ptrdiff_t>(*from));
    return found;
  }

  View<D> view() {
    return View<D>(state, *step, mapped, &numbers,
                   [this](const std::vector<double>& mine) { return gather(mine); });
  }

  double largest(double number) override { return votes.vote(number); }

  std::optional<std::size_t> place_of(std::size_t number) const override {
    const auto found = places_.find(static_cast<std::uint32_t>(number));
    if (found == places_.end()) return {};
    return found->second;
  }

  // Own particles that have left the box of this rank go to that of another one.
  void migrate() {
    forget_copies();
    has_lists_ = false;
    Lists leaving(size_);
    std::vector<std::size_t> staying;
    for (std::size_t p = 0; p < numbers.size(); ++p) {
      const int r = boxes_->rank_of(state.particles.x[p]);
      (r == rank() ? staying : leaving[static_cast<std::size_t>(r)]).push_back(p);
    }
    const auto arrived = messages->send(leaving, state.particles, numbers);
    const std::size_t left = numbers.size() - staying.size();
    migrated += static_cast<std::int64_t>(left);
    if (left == 0 && !arrived.any()) return;
    std::vector<std::uint32_t> now = chosen(numbers, staying);
    Particles<D> particles = chosen(state.particles, kept_, staying);
    messages->append(arrived, particles, now);
    // In the order of the problem, in which the particles of a body stand together.
    std::vector<std::size_t> order(now.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return now[a] < now[b]; });
    state.particles = chosen(particles, kept_, order);
    numbers = chosen(now, order);
  }

  // Some particles of each rank at a time: the first one has the whole once, and no other more than
  // its own.
  State<D> gather() {
    constexpr std::size_t at_once = 16384;
    State<D> whole{{}, state.time, state.last_dt, state.steps};
    std::vector<bool> arrived_before(rank() == 0 ? all : 0);
    std::size_t count = 0;
    const auto place = [&](const Particles<D>& some, const std::vector<std::uint32_t>& whose) {
      for (const std::uint32_t number : whose) {
        recon::detail::require(number < all && !arrived_before[number], "particles of all ranks",
                               number, "must be those of the problem, each once");
        arrived_before[number] = true;
      }
      count += whose.size();
      put(some, kept_, whose, whole.particles);
    };
    if (rank() == 0) whole.particles = sized<D>(kept_, all);
    const std::size_t turns = (numbers.size() + at_once - 1) / at_once;
    const auto most = static_cast<std::size_t>(votes.vote(static_cast<double>(turns)));
    for (std::size_t turn = 0; turn < most; ++turn) {
      const std::size_t begin = std::min(turn * at_once, numbers.size());
      const std::size_t end = std::min(begin + at_once, numbers.size());
      std::vector<std::size_t> some(end - begin);
      std::iota(some.begin(), some.end(), begin);
      Lists sent(size_);
      if (rank() == 0)
        place(chosen(state.particles, kept_, some), chosen(numbers, some));
      else
        sent[0] = std::move(some);
      votes.vote();
      const auto arrived = messages->send(sent, state.particles, numbers);
      if (rank() != 0) continue;
      Particles<D> more;
      std::vector<std::uint32_t> whose;
      messages->append(arrived, more, whose);
      place(more, whose);
    }
    if (rank() == 0)
      recon::detail::require(count == all, "particles of all ranks", count,
                             "must be those of the problem, each once");
    return whole;
  }

  // The signs of the masses of the nodes that this rank has.
  struct Signs {
    Grid<D> grid;
    Window<D> window;
    std::vector<signed char> of_nodes;
  };
  Signs known_signs() const {
    return {step->nodes().grid, step->nodes().window, step->signs().of_nodes};
  }

  // Notes negative masses of nodes and changes of their sign, as a step does in one whole: the rank
  // that knows a node may be another one in the next step. `before` are the signs of that step.
  void watch(const Signs& before) {
    const Signs now = known_signs();
    if (now.of_nodes.empty()) return;  // the method has none
    const Nodes<D>& nodes = step->nodes();
    const Grid<D>& whole = step->problem().grid;
    // Of all ranks, by the numbers in the whole grid of nodes that are here.
    const auto masses_of_all = [&](const std::vector<std::size_t>& here) {
      std::vector<double> of_nodes;
      for (const std::size_t i : here) {
        of_nodes.push_back(static_cast<double>(nodes.number_in(whole, i)));
        of_nodes.push_back(nodes.mass[i]);
      }
      of_nodes = gather(of_nodes);
      std::map<std::size_t, double> masses;
      for (std::size_t at = 0; at < of_nodes.size(); at += 2)
        masses.emplace(static_cast<std::size_t>(of_nodes[at]), of_nodes[at + 1]);
      return masses;
    };
    const auto first_of = [&](const std::map<std::size_t, double>& found) {
      return NegativeMass{state.steps, found.begin()->first, found.begin()->second};
    };
    std::vector<std::size_t> here;
    for (std::size_t i = 0; i < now.of_nodes.size(); ++i)
      if (now.of_nodes[i] < 0) here.push_back(i);
    const std::map<std::size_t, double> negative = masses_of_all(here);
    if (!negative.empty() && !signs.negative) signs.negative = first_of(negative);
    // Nodes that were negative and are not any more may be positive now, and others were before.
    std::vector<std::size_t> turned;
    bool may_have_turned = false;
    const auto look = [&](std::size_t number, const Signs& at) {
      may_have_turned = true;
      const auto place =
          at.of_nodes.empty() ? std::nullopt : at.window.place_of(whole, at.grid, number);
      if (!place || at.of_nodes[*place] <= 0) return;
      if (const auto i = now.window.place_of(whole, now.grid, number)) turned.push_back(*i);
    };
    for (const auto& [i, mass] : negative)
      if (!std::binary_search(negative_before_.begin(), negative_before_.end(), i)) look(i, before);
    for (const std::size_t i : negative_before_)
      if (!negative.contains(i)) look(i, now);
    if (may_have_turned && !signs.change) {
      std::map<std::size_t, double> found = masses_of_all(turned);
      if (!found.empty()) {
        signs.change = first_of(found);
        // Who knew it before need not know its mass now.
        if (const auto known = negative.find(signs.change->node); known != negative.end())
          signs.change->mass = known->second;
      }
    }
    negative_before_.clear();
    for (const auto& [i, mass] : negative) negative_before_.push_back(i);
  }
  void forget_signs() {
    signs = {};
    negative_before_.clear();
  }

  // What work throws with the number that a particle has here is thrown with its own.
  void in_step(const std::function<void()>& work) {
    votes.together([&] {
      try {
        work();
      } catch (const Failure& e) {
        if (dynamic_cast<const Told*>(&e) || std::string_view(e.place()) != "particle") throw;
        throw Failure(e.step(), e.place(),
                      e.number() < numbers.size() ? numbers[e.number()] : e.number(), e.reason());
      }
    });
  }

  void write_frame(const std::filesystem::path& folder, const std::string& name,
                   std::vector<double>& times, const FrameOptions& options) {
    write_frame_pieces(folder, name, view(), *boxes_, votes, *messages, times, options);
  }

  int rank() const { return votes.ranks().rank(); }

  Votes votes;
  std::optional<Messages<D>> messages;
  State<D> state;
  std::vector<std::uint32_t> numbers;  // of the own particles in the problem
  std::size_t all = 0;
  std::optional<Step<D>> step;
  bool mapped = false, failed = false;
  std::size_t copies = 0;
  std::int64_t migrated = 0;
  MassSigns signs;  // of all ranks; without of_nodes

 private:
  // Which own particles other ranks need, and theirs.
  void make_copies(State<D>& s) {
    has_lists_ = true;
    const Problem<D>& problem = step->problem();
    // Each rank's box of particles, and the widest domain.
    constexpr double infinite = std::numeric_limits<double>::infinity();
    struct Span {
      std::array<double, D> lower, upper;
      double widest;
    };
    Span mine;
    mine.lower.fill(infinite);
    mine.upper.fill(-infinite);
    for (const Vector<D>& x : s.particles.x)
      for (std::size_t d = 0; d < D; ++d) {
        mine.lower[d] = std::min(mine.lower[d], x[static_cast<int>(d)]);
        mine.upper[d] = std::max(mine.upper[d], x[static_cast<int>(d)]);
      }
    mine.widest = half_width(problem, s.particles);
    std::vector<Span> spans(size_);
    constexpr int per_span = 2 * D + 1;
    static_assert(sizeof(Span) == per_span * sizeof(double));
    RECON_MPI(MPI_Allgather(&mine, per_span, MPI_DOUBLE, spans.data(), per_span, MPI_DOUBLE,
                            votes.ranks().get()));
    ++votes.rounds;
    double widest = 0;
    for (const Span& span : spans) widest = std::max(widest, span.widest);
    const double reach = reach_of_copies(problem, widest);
    std::array<double, D> period{};
    for (int d = 0; d < D; ++d)
      if (problem.periodic[d])
        period[static_cast<std::size_t>(d)] = problem.room(d).second - problem.room(d).first;
    const auto is_near = [&](const Vector<D>& x, const Span& span) {
      for (int axis = 0; axis < D; ++axis) {
        const auto d = static_cast<std::size_t>(axis);
        const auto apart = [&](double at) {
          return std::max({span.lower[d] - at, at - span.upper[d], 0.0});
        };
        double least = apart(x[axis]);
        if (period[d] > 0)
          least = std::min({least, apart(x[axis] - period[d]), apart(x[axis] + period[d])});
        if (!(least <= reach)) return false;
      }
      return true;
    };
    for (std::size_t r = 0; r < size_; ++r) {
      to_[r].clear();
      if (static_cast<int>(r) == rank()) continue;
      for (std::size_t p = 0; p < numbers.size(); ++p)
        if (is_near(s.particles.x[p], spans[r])) to_[r].push_back(p);
    }
    const auto arrived = messages->send(to_, s.particles, numbers);
    from_ = arrived.counts;
    std::vector<std::uint32_t> of_all = numbers;
    messages->append(arrived, s.particles, of_all);
    s.others = of_all.size() - numbers.size();
    copies = s.others;
    places_.clear();
    if (problem.loads.empty()) return;
    for (std::size_t i = 0; i < of_all.size(); ++i) places_.emplace(of_all[i], i);
  }

  std::size_t size_;
  Kept kept_;
  std::optional<Boxes<D>> boxes_;
  // The own particles of which each rank has copies, and how many this one has of those of each.
  Lists to_;
  std::vector<std::size_t> from_;
  bool has_lists_ = false;
  std::vector<std::size_t> negative_before_;  // nodes of negative mass of all ranks, ascending
  std::unordered_map<std::uint32_t, std::size_t> places_;  // with loads alone
};

template <int D>
DistributedSimulation<D>::DistributedSimulation(const petsc::Communicator& ranks,
                                                Problem<D> problem)
    : exchange_(std::make_unique<Exchange>(ranks, std::move(problem))) {}
template <int D>
DistributedSimulation<D>::DistributedSimulation(MPI_Comm ranks, Problem<D> problem)
    : DistributedSimulation(petsc::Communicator(ranks), std::move(problem)) {}
template <int D>
DistributedSimulation<D>::~DistributedSimulation() = default;

template <int D>
const State<D>& DistributedSimulation<D>::part() const {
  return exchange_->state;
}
template <int D>
const std::vector<std::uint32_t>& DistributedSimulation<D>::numbers() const {
  return exchange_->numbers;
}
template <int D>
const Step<D>& DistributedSimulation<D>::stepper() const {
  return *exchange_->step;
}
template <int D>
Traffic DistributedSimulation<D>::traffic() const {
  const Exchange& of = *exchange_;
  return {of.messages->messages, of.messages->bytes, of.votes.rounds, of.copies, of.migrated};
}
template <int D>
const petsc::Communicator& DistributedSimulation<D>::ranks() const {
  return exchange_->votes.ranks();
}
template <int D>
const MassSigns& DistributedSimulation<D>::signs() const {
  return exchange_->signs;
}
template <int D>
View<D> DistributedSimulation<D>::view() const {
  return exchange_->view();
}
template <int D>
std::size_t DistributedSimulation<D>::particles() const {
  return exchange_->all;
}

template <int D>
TimeStep DistributedSimulation<D>::choose_step() const {
  Exchange& of = *exchange_;
  TimeStep step;
  of.votes.together([&] {
    // Copies are of the same time, if there are any: they change nothing.
    const TimeStep mine = mpm::choose_step(problem(), of.state.particles);
    step.dt = -of.votes.vote(-mine.dt);
    const bool limits = mine.dt == step.dt && mine.particle < of.numbers.size();
    const double number =
        limits ? of.numbers[mine.particle] : std::numeric_limits<std::uint32_t>::max();
    step.particle = static_cast<std::size_t>(-of.votes.vote(-number));
    if (problem().time.rule == StepRule::fixed) step.particle = 0;
  });
  return step;
}

template <int D>
void DistributedSimulation<D>::map() {
  Exchange& of = *exchange_;
  recon::detail::require(!of.failed, "simulation", "failed",
                         "cannot go on after a step that failed; restore() brings back a state");
  if (of.mapped) return;
  of.failed = true;
  of.in_step([&] {
    const auto before = of.known_signs();
    of.step->to_nodes(of.state);
    of.watch(before);
  });
  of.mapped = true;
  of.failed = false;
}

template <int D>
void DistributedSimulation<D>::step(double dt) {
  Exchange& of = *exchange_;
  of.votes.together([&] {
    recon::detail::require(dt > 0 && std::isfinite(dt), "time step", dt,
                           "must be positive and finite");
    recon::detail::require(time() + dt > time(), "time step", dt, "is too short to move the clock");
    recon::detail::require(of.votes.vote(dt) == dt && of.votes.vote(-dt) == -dt, "time step",
                           "different on some ranks", "must be the same on all ranks");
  });
  map();
  of.failed = true;
  of.in_step([&] {
    of.step->to_particles(of.state, dt);
    of.votes.vote();
    of.migrate();
  });
  of.mapped = false;
  of.failed = false;
}

template <int D>
Ledger DistributedSimulation<D>::account(const std::optional<Ledger>& start,
                                         const std::optional<Ledger>& before) {
  Ledger now;
  exchange_->votes.together([&] {
    const View<D> view = exchange_->view();
    view.require_mapped("account");
    now = mpm::account(view, external_forces(view), start, before);
  });
  return now;
}

template <int D>
void DistributedSimulation<D>::write_frame(const std::filesystem::path& folder,
                                           const std::string& name, std::vector<double>& times,
                                           const FrameOptions& options) {
  exchange_->votes.together([&] { exchange_->write_frame(folder, name, times, options); });
}

template <int D>
State<D> DistributedSimulation<D>::gather() const {
  Exchange& of = *exchange_;
  State<D> whole;
  of.votes.together([&] {
    of.votes.vote();
    whole = of.gather();
  });
  return whole;
}

template <int D>
void DistributedSimulation<D>::restore(const State<D>& whole) {
  Exchange& of = *exchange_;
  of.votes.together([&] {
    recon::detail::require(whole.particles.size() == of.all, "particles of the restart",
                           whole.particles.size(), "must be as many as the problem has");
    problem().validate(whole.particles, true);
    recon::detail::require(std::isfinite(whole.time) && whole.time >= 0, "time of the restart",
                           whole.time, "must be finite and not negative");
    of.choose_own(whole);
    of.step->forget();
    of.forget_signs();
  });
}

template class DistributedSimulation<1>;
template class DistributedSimulation<2>;
template class DistributedSimulation<3>;

}  // namespace recon::mpm
