#include "recon/ranks/distributed_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "mpm/policies.hpp"
#include "petsc/call.hpp"
#include "ranks/boxes.hpp"
#include "ranks/votes.hpp"

namespace recon::mpm {
namespace {

using Bytes = std::vector<std::byte>;

template <class T>
void put(const std::vector<T>& values, Bytes& to) {
  static_assert(std::is_trivially_destructible_v<T>);
  const std::size_t begin = to.size(), length = values.size() * sizeof(T);
  to.resize(begin + length);
  if (length > 0) std::memcpy(to.data() + begin, static_cast<const void*>(values.data()), length);
}

// Reads `count` values, and moves on.
template <class T>
void take(const std::byte*& from, std::size_t count, std::vector<T>& to) {
  to.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(to.data()), from, count * sizeof(T));
  from += count * sizeof(T);
}

// Whether an array changes within a step in a way that copies need.
bool changes(const char* array) {
  for (const std::string_view name : {"x", "v", "F", "L", "stress", "corners", "modes"})
    if (name == array) return true;
  return false;
}

}  // namespace

template <int D>
class DistributedSimulation<D>::Exchange : public OtherParts<D> {
 public:
  Exchange(const petsc::Communicator& ranks, Problem<D> problem)
      : votes(ranks), size_(static_cast<std::size_t>(ranks.size())), to_(size_), from_(size_) {
    votes.together([&] {
      require_parts(problem);
      State<D> whole = start(std::move(problem));
      kept_ = problem.kept();
      all = whole.particles.size();
      boxes_.emplace(whole.particles.x, ranks.size());
      choose_own(whole);
      problem.particles = {};
      step.emplace(std::move(problem), numbers.size(), this);
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
    std::vector<Bytes> out(size_), in(size_);
    for (std::size_t r = 0; r < size_; ++r) {
      if (!to_[r].empty()) pack(chosen(s.particles, kept_, to_[r]), true, out[r]);
      in[r].resize(bytes_of(from_[r], true));
    }
    exchange(out, in);
    std::size_t at = s.own();
    for (std::size_t r = 0; r < size_; ++r) {
      unpack(in[r], from_[r], at, s.particles);
      at += from_[r];
    }
  }

  void copy_to(const State<D>& s, std::vector<Vector<D>>& of_particles) override {
    votes.vote();
    std::vector<Bytes> out(size_), in(size_);
    for (std::size_t r = 0; r < size_; ++r) {
      std::vector<Vector<D>> values;
      for (const std::size_t p : to_[r]) values.push_back(of_particles[p]);
      put(values, out[r]);
      in[r].resize(from_[r] * sizeof(Vector<D>));
    }
    exchange(out, in);
    std::size_t at = s.own();
    for (std::size_t r = 0; r < size_; ++r) {
      const std::byte* read = in[r].data();
      std::vector<Vector<D>> values;
      take(read, from_[r], values);
      std::copy(values.begin(), values.end(),
                of_particles.begin() + static_cast<std::ptrdiff_t>(at));
      at += from_[r];
    }
  }

  void sum(std::span<double> numbers_of_all) override {
    votes.vote();
    const std::size_t count = numbers_of_all.size();
    std::vector<double> each(count * size_);
    RECON_MPI(MPI_Allgather(numbers_of_all.data(), static_cast<int>(count), MPI_DOUBLE, each.data(),
                            static_cast<int>(count), MPI_DOUBLE, votes.ranks().get()));
    ++votes.rounds;
    std::fill(numbers_of_all.begin(), numbers_of_all.end(), 0.0);
    for (std::size_t i = 0; i < each.size(); ++i) numbers_of_all[i % count] += each[i];
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
    std::vector<std::vector<std::size_t>> leaving(size_);
    std::vector<std::size_t> staying;
    for (std::size_t p = 0; p < numbers.size(); ++p) {
      const int r = boxes_->rank_of(state.particles.x[p]);
      if (r == rank())
        staying.push_back(p);
      else
        leaving[static_cast<std::size_t>(r)].push_back(p);
    }
    std::vector<std::size_t> coming = counts_of(leaving);
    std::vector<Bytes> out(size_), in(size_);
    bool changed = staying.size() != numbers.size();
    for (std::size_t r = 0; r < size_; ++r) {
      in[r].resize(coming[r] == 0 ? 0 : bytes_of(coming[r], false));
      changed = changed || coming[r] > 0;
      if (leaving[r].empty()) continue;
      pack(chosen(state.particles, kept_, leaving[r]), false, out[r]);
      put(chosen_numbers(leaving[r]), out[r]);
      migrated += static_cast<std::int64_t>(leaving[r].size());
    }
    exchange(out, in);
    if (!changed) return;
    std::vector<std::uint32_t> now = chosen_numbers(staying);
    Particles<D> particles = chosen(state.particles, kept_, staying);
    for (std::size_t r = 0; r < size_; ++r)
      if (coming[r] > 0) receive(in[r], coming[r], particles, now);
    // In the order of the problem, in which the particles of a body stand together.
    std::vector<std::size_t> order(now.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return now[a] < now[b]; });
    state.particles = chosen(particles, kept_, order);
    numbers.clear();
    for (const std::size_t i : order) numbers.push_back(now[i]);
  }

  State<D> gather() {
    std::vector<std::vector<std::size_t>> sent(size_);
    sent[0].resize(numbers.size());
    std::iota(sent[0].begin(), sent[0].end(), std::size_t{0});
    if (rank() == 0) sent[0].clear();
    const std::vector<std::size_t> coming = counts_of(sent);
    std::vector<Bytes> out(size_), in(size_);
    for (std::size_t r = 0; r < size_; ++r) in[r].resize(bytes_of(coming[r], false));
    const std::size_t own = state.own();
    Particles<D> particles = state.particles;
    keep_first(own, kept_, particles);
    if (!sent[0].empty()) {
      pack(particles, false, out[0]);
      put(numbers, out[0]);
    }
    exchange(out, in);
    if (rank() != 0) return {{}, state.time, state.last_dt, state.steps};
    std::vector<std::uint32_t> whose = numbers;
    for (std::size_t r = 1; r < size_; ++r)
      if (coming[r] > 0) receive(in[r], coming[r], particles, whose);
    std::vector<std::size_t> order(all, all);
    for (std::size_t i = 0; i < whose.size(); ++i) order.at(whose[i]) = i;
    recon::detail::require(
        whose.size() == all && std::find(order.begin(), order.end(), all) == order.end(),
        "particles of all ranks", whose.size(), "must be those of the problem, each once");
    return {chosen(particles, kept_, order), state.time, state.last_dt, state.steps};
  }

  // What work throws with the number that a particle has here is thrown with its own.
  void in_step(const std::function<void()>& work) {
    votes.together([&] {
      try {
        work();
      } catch (const Failure& e) {
        const std::string what = e.what();
        const std::size_t reason = what.find(": ");
        if (what.find(", particle ") > reason || what.compare(reason + 2, 5, "rank ") == 0) throw;
        throw Failure(e.step(), "particle",
                      e.number() < numbers.size() ? numbers[e.number()] : e.number(),
                      what.substr(reason + 2));
      }
    });
  }

  int rank() const { return votes.ranks().rank(); }

  mutable Votes votes;
  State<D> state;
  std::vector<std::uint32_t> numbers;  // of the own particles in the problem
  std::size_t all = 0;
  std::optional<Step<D>> step;
  bool mapped = false, failed = false;
  std::int64_t messages = 0, bytes = 0, migrated = 0;
  std::size_t copies = 0;
  mutable Traffic traffic;

 private:
  std::vector<std::uint32_t> chosen_numbers(const std::vector<std::size_t>& which) const {
    std::vector<std::uint32_t> some;
    for (const std::size_t p : which) some.push_back(numbers[p]);
    return some;
  }

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
    from_ = counts_of(to_);
    std::vector<Bytes> out(size_), in(size_);
    for (std::size_t r = 0; r < size_; ++r) {
      if (!to_[r].empty()) {
        pack(chosen(s.particles, kept_, to_[r]), false, out[r]);
        put(chosen_numbers(to_[r]), out[r]);
      }
      in[r].resize(bytes_of(from_[r], false));
    }
    exchange(out, in);
    std::vector<std::uint32_t> of_all = numbers;
    for (std::size_t r = 0; r < size_; ++r)
      if (from_[r] > 0) receive(in[r], from_[r], s.particles, of_all);
    s.others = of_all.size() - numbers.size();
    copies = s.others;
    places_.clear();
    if (problem.loads.empty()) return;
    for (std::size_t i = 0; i < of_all.size(); ++i) places_.emplace(of_all[i], i);
  }

  // All arrays of particles one after the other, or those that change alone.
  static void pack(const Particles<D>& particles, const Kept& kept, bool changing, Bytes& to) {
    particles.arrays(kept, [&](const ParticleArray& array, const auto& values) {
      if (!changing || changes(array.name)) put(values, to);
    });
  }
  void pack(const Particles<D>& particles, bool changing, Bytes& to) const {
    pack(particles, kept_, changing, to);
  }
  // Of so many particles; with their numbers where all arrays are sent.
  std::size_t bytes_of(std::size_t count, bool changing) const {
    std::size_t length = changing ? 0 : count * sizeof(std::uint32_t);
    Particles<D> none;
    none.arrays(kept_, [&](const ParticleArray& array, const auto& values) {
      using T = typename std::decay_t<decltype(values)>::value_type;
      if (!changing || changes(array.name)) length += count * array.per_particle * sizeof(T);
    });
    return length;
  }
  // After the particles that there are, and their numbers.
  void receive(const Bytes& from, std::size_t count, Particles<D>& to,
               std::vector<std::uint32_t>& whose) const {
    const std::byte* read = from.data();
    Particles<D> more;
    more.arrays(kept_, [&](const ParticleArray& array, auto& values) {
      take(read, count * array.per_particle, values);
    });
    append(more, kept_, to);
    std::vector<std::uint32_t> more_numbers;
    take(read, count, more_numbers);
    whose.insert(whose.end(), more_numbers.begin(), more_numbers.end());
  }
  // What changes, in the place of what was there.
  void unpack(const Bytes& from, std::size_t count, std::size_t at, Particles<D>& to) const {
    const std::byte* read = from.data();
    to.arrays(kept_, [&](const ParticleArray& array, auto& values) {
      if (!changes(array.name)) return;
      using T = typename std::decay_t<decltype(values)>::value_type;
      const std::size_t entries = count * array.per_particle;
      if (entries > 0)
        std::memcpy(static_cast<void*>(values.data() + at * array.per_particle), read,
                    entries * sizeof(T));
      read += entries * sizeof(T);
    });
  }

  // How many entries each rank has for this one.
  std::vector<std::size_t> counts_of(const std::vector<std::vector<std::size_t>>& lists) {
    std::vector<std::int64_t> mine(size_), others(size_);
    for (std::size_t r = 0; r < size_; ++r) mine[r] = static_cast<std::int64_t>(lists[r].size());
    RECON_MPI(MPI_Alltoall(mine.data(), 1, MPI_INT64_T, others.data(), 1, MPI_INT64_T,
                           votes.ranks().get()));
    ++votes.rounds;
    return {others.begin(), others.end()};
  }

  // Sends to and receives from all ranks for which there is something.
  void exchange(const std::vector<Bytes>& out, std::vector<Bytes>& in) {
    constexpr std::size_t most = std::size_t{1} << 30;  // of one message, in whose int it must fit
    std::vector<MPI_Request> requests;
    const MPI_Comm comm = votes.ranks().get();
    const auto in_pieces = [&](std::size_t length, const auto& piece) {
      for (std::size_t begin = 0; begin < length; begin += most)
        piece(begin, static_cast<int>(std::min(most, length - begin)));
    };
    for (std::size_t r = 0; r < size_; ++r)
      in_pieces(in[r].size(), [&](std::size_t begin, int length) {
        requests.emplace_back();
        RECON_MPI(MPI_Irecv(in[r].data() + begin, length, MPI_BYTE, static_cast<int>(r), 0, comm,
                            &requests.back()));
      });
    for (std::size_t r = 0; r < size_; ++r)
      in_pieces(out[r].size(), [&](std::size_t begin, int length) {
        requests.emplace_back();
        RECON_MPI(MPI_Isend(out[r].data() + begin, length, MPI_BYTE, static_cast<int>(r), 0, comm,
                            &requests.back()));
        ++messages;
        bytes += length;
      });
    RECON_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  }

  std::size_t size_;
  Kept kept_;
  std::optional<Boxes<D>> boxes_;
  // The own particles of which each rank has copies, and how many this one has of those of each.
  std::vector<std::vector<std::size_t>> to_;
  std::vector<std::size_t> from_;
  bool has_lists_ = false;
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
const Traffic& DistributedSimulation<D>::traffic() const {
  const Exchange& of = *exchange_;
  of.traffic = {of.messages, of.bytes, of.votes.rounds, of.copies, of.migrated};
  return of.traffic;
}
template <int D>
const petsc::Communicator& DistributedSimulation<D>::ranks() const {
  return exchange_->votes.ranks();
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
    const double number = limits ? of.numbers[mine.particle] : 4294967295.0;
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
  of.in_step([&] { of.step->to_nodes(of.state); });
  of.mapped = true;
  of.failed = false;
}

template <int D>
void DistributedSimulation<D>::step(double dt) {
  Exchange& of = *exchange_;
  of.votes.ranks().together(
      [&] {
        recon::detail::require(dt > 0 && std::isfinite(dt), "time step", dt,
                               "must be positive and finite");
        recon::detail::require(time() + dt > time(), "time step", dt,
                               "is too short to move the clock");
      },
      "time step", {dt});
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
  Exchange& of = *exchange_;
  recon::detail::require(of.mapped, "account", "of nodes of another time", "needs a map() before");
  Ledger sums;
  double power = 0;
  of.votes.together([&] {
    sums = sums_of(of.state, *of.step);
    const Nodes<D>& nodes = of.step->nodes();
    double negative = 0;  // a node of several ranks counts once
    if (nodes.negative > 0)
      for (std::size_t i = 0; i < nodes.mass.size(); ++i)
        if (nodes.mass[i] < -lightest_node * nodes.heaviest()) negative += nodes.share_of(i);
    std::vector<double> each;
    const auto all_sums = [&](const auto& field) {
      for (double* one : {&sums.mass, &sums.node_mass, &sums.kinetic, &sums.node_kinetic,
                          &sums.strain, &sums.linear_strain, &sums.power, &power, &negative})
        field(*one);
      for (auto* three : {&sums.momentum, &sums.node_momentum, &sums.angular, &sums.node_angular})
        for (double& one : *three) field(one);
    };
    power = external_forces(of.state, *of.step).power;
    all_sums([&](double& one) { each.push_back(one); });
    of.sum(each);
    std::size_t next = 0;
    all_sums([&](double& one) { one = each[next++]; });
    sums.negative_nodes = static_cast<std::size_t>(std::llround(negative));
  });
  return mpm::account(sums, power, start, before);
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
  });
}

template class DistributedSimulation<1>;
template class DistributedSimulation<2>;
template class DistributedSimulation<3>;

}  // namespace recon::mpm
