#include "neighbourhood/cell_search.hpp"

#include <atomic>
#include <mutex>

#include "neighbourhood/cells.hpp"
#include "recon/neighbourhood/cell_grid.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"
#include "recon/neighbourhood/kd_tree.hpp"

namespace recon::detail {

namespace {

constexpr double particles_per_cell = 3;
constexpr std::size_t targets_per_block = 512;

// A rule in the form that the search works with.
template <class S>
struct Question {
  bool nearest = false;
  std::size_t k = 0;
  double factor = 0;              // of Nearest; 0 for NearestWithin
  S radius = 0;                   // of all targets; infinite for Nearest
  std::span<const double> radii;  // one per target, of Radii

  explicit Question(const NeighbourRule& rule) {
    if (const auto* within = std::get_if<Radius>(&rule)) {
      radius = static_cast<S>(within->radius);
    } else if (const auto* own = std::get_if<Radii>(&rule)) {
      radii = own->radii;
    } else if (const auto* near = std::get_if<Nearest>(&rule)) {
      nearest = true;
      k = near->k;
      factor = near->factor;
      radius = std::numeric_limits<S>::infinity();
    } else if (const auto* near_within = std::get_if<NearestWithin>(&rule)) {
      nearest = true;
      k = near_within->k;
      radius = static_cast<S>(near_within->radius);
    }
  }

  S radius_of(std::size_t target) const {
    return radii.empty() ? radius : static_cast<S>(radii[target]);
  }
};

// The kernels of one instruction set.
template <class S, int D>
struct Kernels {
  decltype(&generic::gather_ball<S, D>) gather;
  decltype(&generic::ranks<S>) rank_distances;
  decltype(&generic::ranks<std::uint32_t>) rank_indices;
  std::size_t most_ranked;  // sorting is faster beyond

  Kernels(InstructionSet set, SupportShape shape, bool nearest)
      : gather(shape == SupportShape::cube && !nearest ? RECON_DISPATCH(set, gather_cube<S, D>)
                                                       : RECON_DISPATCH(set, gather_ball<S, D>)),
        rank_distances(RECON_DISPATCH(set, ranks<S>)),
        rank_indices(RECON_DISPATCH(set, ranks<std::uint32_t>)),
        most_ranked(set == InstructionSet::avx512 ? 256
                    : set == InstructionSet::avx2 ? 160
                                                  : 96) {}
};

// A k-d tree that is built when targets have cost as much without it as building it does.
template <class S, int D>
class TreeForHardTargets {
 public:
  TreeForHardTargets(const PointCloud<S>& particles, bool allowed, std::size_t k)
      : particles_(particles),
        allowed_(allowed),
        hard_work_(8000 + 100 * static_cast<std::int64_t>(k)),
        price_(work_per_particle * static_cast<std::int64_t>(particles.size())) {}

  // Work for one target that a query of the tree would not exceed by much.
  std::int64_t hard_work() const { return hard_work_; }
  bool worthwhile() const { return allowed_ && paid_.load(std::memory_order_relaxed) >= price_; }
  void add(std::int64_t work) {
    if (work > hard_work_) paid_.fetch_add(work, std::memory_order_relaxed);
  }
  const KdTree<S, D>& get() {
    std::call_once(once_, [this] { tree_ = std::make_unique<KdTree<S, D>>(particles_); });
    return *tree_;
  }

 private:
  static constexpr std::int64_t work_per_particle = 400;

  const PointCloud<S>& particles_;
  const bool allowed_;
  const std::int64_t hard_work_, price_;
  std::atomic<std::int64_t> paid_ = 0;
  std::once_flag once_;
  std::unique_ptr<KdTree<S, D>> tree_;
};

// All that targets share.
template <class S, int D>
struct Shared {
  const PointCloud<S>& particles;
  const PointCloud<S>& targets;
  const NeighbourRule& rule;
  const PeriodicDomain<S>& domain;
  const NeighbourOptions& options;
  const Question<S> question;
  const CellGrid<S, D> grid;
  const Kernels<S, D> kernels;
  const S spacing;
  int axes = 0;         // along which the particles extend
  double start = 0;     // a first guess of the k-th distance
  double widening = 1;  // by which guesses exceed the k-th distance
  double least_period = 0;
  TreeForHardTargets<S, D> tree;

  static double cell_size(const PointCloud<S>& points, const Question<S>& question) {
    const double size = density_cell_size(points, particles_per_cell);
    if (question.nearest) return size;
    auto radius = static_cast<double>(question.radius);
    for (const double r : question.radii) radius += r / static_cast<double>(question.radii.size());
    return std::clamp(radius / 2, size, std::numeric_limits<double>::max());
  }

  Shared(const PointCloud<S>& all_particles, const PointCloud<S>& all_targets,
         const NeighbourRule& neighbour_rule, const PeriodicDomain<S>& where,
         const NeighbourOptions& how, bool may_build_tree)
      : particles(all_particles),
        targets(all_targets),
        rule(neighbour_rule),
        domain(where),
        options(how),
        question(rule),
        grid(particles, cell_size(particles, question), options.threads),
        kernels(resolved(options.instruction_set), options.shape, question.nearest),
        spacing(mean_spacing(particles, domain)),
        tree(particles, may_build_tree, question.k) {
    for (int d = 0; d < D; ++d) axes += particles.box().extent(d) > 0;
    axes = std::max(axes, 1);
    const auto k = static_cast<double>(question.k);
    const double unit_ball = axes == 1 ? 2.0 : axes == 2 ? 3.14 : 4.19;
    start = static_cast<double>(spacing) * std::pow(std::max(k, 1.0) / unit_ball, 1.0 / axes);
    // Evenly spread particles in a ball that holds m on average number m +- sqrt(m).
    widening = std::pow((k + 1.6 * std::sqrt(k) + 1) / std::max(k, 1.0), 1.0 / axes);
    least_period = std::numeric_limits<double>::infinity();
    for (int d = 0; d < D; ++d)
      if (domain.periodic[d])
        least_period = std::min(least_period, static_cast<double>(domain.period(d)));
  }
};

// Finds the neighbours of one target after another; has the buffers for that. A neighbour is
// written as a key: its index, and behind it the shift in periodic domains, so that the order of
// the keys is the one that the rules ask for.
template <class S, int D, bool periodic>
class CellTargets {
 public:
  using Point = std::array<S, D>;
  using Key = std::conditional_t<periodic, std::uint64_t, std::uint32_t>;

  explicit CellTargets(Shared<S, D>& shared)
      : shared_(shared), images_(shared.domain, shared.particles.box()), near_(shared.start) {
    // Candidates too many have to be sorted out; neighbours are what a radius asks for.
    out_.work_per_found = shared.question.nearest ? 12 : -16;
    make_room(512);
  }

  static ParticleIndex index_of(Key key) {
    if constexpr (periodic) return static_cast<ParticleIndex>(key >> 24);
    return static_cast<ParticleIndex>(key);
  }
  static ImageShift shift_of(Key key) {
    ImageShift shift{};
    for (int d = 0; d < max_dimension; ++d)
      shift[d] = static_cast<std::int8_t>(static_cast<int>(key >> (16 - 8 * d) & 0xFF) - 128);
    return shift;
  }

  // Of the target at x, in order, valid until the next call of find().
  const Key* begin() const { return ordered_.data(); }
  std::size_t size() const { return size_; }

  // Returns the support radius.
  S find(std::size_t target, const Point& x) {
    if (skip_ > 0) {
      --skip_;
      return find_in_tree(target);
    }
    x_ = x;
    out_.work = 0;
    out_.work_limit = shared_.tree.worthwhile() ? shared_.tree.hard_work() : INT64_MAX;
    S rho = 0;
    const Outcome outcome =
        shared_.question.nearest ? nearest(target, rho) : all_within(target, rho);
    shared_.tree.add(out_.work + out_.work_per_found * out_.count);
    if (outcome == Outcome::too_much_work) {
      skip_ = next_skip_;
      next_skip_ = std::min(2 * next_skip_ + 1, 63);
      return find_in_tree(target);
    }
    next_skip_ = 0;
    if (outcome == Outcome::not_covered) {
      if (!general_)
        general_.emplace(shared_.grid, shared_.particles, shared_.targets, shared_.domain,
                         shared_.options, shared_.spacing);
      return find_with(*general_, target);
    }
    return rho;
  }

 private:
  enum class Outcome { found, not_covered, too_much_work };

  // ---- The particles around a target --------------------------------------------------------

  void make_room(std::size_t count) {
    constexpr std::size_t beyond = 64;  // what the kernels may touch behind the last
    out_.capacity = static_cast<std::int64_t>(count);
    distance2_.resize(count + beyond);
    index_.resize(count + beyond);
    if constexpr (periodic) shift_.resize(count + beyond);
    out_.distance2 = distance2_.data();
    out_.index = index_.data();
  }

  // Everything within the radius, over all images. False if it was too much work.
  bool gather(S radius) {
    out_.count = 0;
    if constexpr (!periodic) return gather_image(x_, radius);
    if (!images_needed(radius)) return gather_image(x_, radius) && put_shift(0, {});
    // The shape of a cube reaches to its corners.
    const bool cube = shared_.options.shape == SupportShape::cube && !shared_.question.nearest;
    const S limit =
        cube ? std::min(reach(radius * std::sqrt(S(D))), std::numeric_limits<S>::max()) : radius;
    typename PeriodicImages<S, D>::Image image;
    for (images_.start(x_); images_.next(limit * limit, image);) {
      const std::int64_t before = out_.count;
      if (!gather_image(image.x, radius)) return false;
      put_shift(before, image.shift);
    }
    return true;
  }

  bool gather_image(const Point& x, S radius) {
    const std::int64_t count = out_.count, work = out_.work;
    for (;;) {
      const GatherResult result =
          shared_.kernels.gather(shared_.grid.sorted_cells().view(), x.data(), radius, out_);
      if (result != GatherResult::no_room) return result == GatherResult::complete;
      make_room(4 * static_cast<std::size_t>(out_.capacity));
      out_.count = count;
      out_.work = work;
    }
  }

  bool put_shift(std::int64_t from, const ImageShift& shift) {
    std::uint32_t code = 0;
    for (const std::int8_t s : shift) code = code << 8 | static_cast<std::uint32_t>(s + 128);
    std::fill(shift_.data() + from, shift_.data() + out_.count, code);
    return true;
  }

  // May an image other than the target itself be within the radius of a particle?
  bool images_needed(S radius) const {
    const S far = reach(radius);
    const auto& box = shared_.particles.box();
    for (int d = 0; d < D; ++d) {
      if (!shared_.domain.periodic[d]) continue;
      const S period = shared_.domain.period(d);
      if (!(box.lower[d] - (x_[d] - period) > far) || !(x_[d] + period - box.upper[d] > far))
        return true;
    }
    return false;
  }

  Key key(std::size_t i) const {
    if constexpr (periodic) return static_cast<Key>(index_[i]) << 24 | shift_[i];
    return index_[i];
  }

  // ---- Radius and Radii ----------------------------------------------------------------------

  Outcome all_within(std::size_t target, S& rho) {
    rho = shared_.question.radius_of(target);
    if (!gather(rho)) return Outcome::too_much_work;
    const auto count = static_cast<std::size_t>(out_.count);
    start_order(count, count);
    if (count <= shared_.kernels.most_ranked) {
      rank_index_.resize(std::max(rank_index_.size(), count + 64));
      shared_.kernels.rank_indices(out_.index, out_.count, rank_index_.data());
      place(rank_index_.data());
    } else {
      for (std::size_t i = 0; i < count; ++i) ordered_[i] = key(i);
      std::sort(ordered_.begin(), ordered_.begin() + static_cast<std::ptrdiff_t>(count));
    }
    return Outcome::found;
  }

  // ---- Nearest and NearestWithin -------------------------------------------------------------

  Outcome nearest(std::size_t target, S& rho) {
    const Question<S>& question = shared_.question;
    const std::size_t particles = shared_.particles.size();
    const std::size_t k = periodic ? question.k : std::min(question.k, particles);
    const S limit = question.radius_of(target);
    S radius = first_guess(k, limit);
    for (int tries = 1;; ++tries) {
      if (periodic && static_cast<double>(radius) > shared_.least_period)
        return Outcome::not_covered;
      if (!gather(radius)) return Outcome::too_much_work;
      const auto count = static_cast<std::size_t>(out_.count);
      if (count >= k || radius >= limit) break;
      if (tries == most_tries) return Outcome::not_covered;
      radius = std::min(limit, larger_guess(radius, count, k));
    }
    const auto count = static_cast<std::size_t>(out_.count);
    start_order(count, std::min(k, count));
    const S farthest2 = order_by_distance();
    if (size_ > 0) learn(std::sqrt(static_cast<double>(farthest2)));
    if (question.factor == 0) {
      rho = limit;
      return Outcome::found;
    }
    const S farthest =
        shared_.options.shape == SupportShape::cube ? farthest_along_axis() : std::sqrt(farthest2);
    rho = static_cast<S>(question.factor * static_cast<double>(farthest));
    return farthest > 0 && std::isfinite(rho) ? Outcome::found : Outcome::not_covered;
  }

  // A radius that most likely holds k.
  S first_guess(std::size_t k, S limit) const {
    constexpr std::size_t few = 64;
    if (!periodic && (shared_.particles.size() <= few || 2 * k >= shared_.particles.size()))
      return limit;
    const double least = std::sqrt(static_cast<double>(std::numeric_limits<S>::min()));
    return std::min(limit, static_cast<S>(std::max(near_ * shared_.widening, least)));
  }

  S larger_guess(S radius, std::size_t count, std::size_t k) const {
    const auto now = static_cast<double>(radius);
    if (count > 0) {
      const double ratio = 1.5 * static_cast<double>(k) / static_cast<double>(count);
      return static_cast<S>(now * std::clamp(std::pow(ratio, 1.0 / shared_.axes), 1.25, 1.6));
    }
    double outside2 = 0;  // at least to the box of the particles, and somewhat into it
    for (int d = 0; d < D; ++d) {
      const auto& box = shared_.particles.box();
      const S outside = std::max({S(0), box.lower[d] - x_[d], x_[d] - box.upper[d]});
      outside2 += static_cast<double>(outside) * static_cast<double>(outside);
    }
    return static_cast<S>(std::max(1.6 * now, std::sqrt(outside2) + shared_.start));
  }

  // The k-th distance of the next target is likely that of the last ones.
  void learn(double distance) {
    const bool jump = distance > 2 * near_ || distance < near_ / 2;
    near_ += (distance - near_) * (jump ? 1 : 0.125);
  }

  // The size_ nearest of all that were gathered; returns the largest of their squared distances.
  S order_by_distance() {
    const auto count = static_cast<std::size_t>(out_.count);
    S farthest2 = 0;
    if (count <= shared_.kernels.most_ranked) {
      rank_distance_.resize(std::max(rank_distance_.size(), count + 64));
      const S* const rank = rank_distance_.data();
      shared_.kernels.rank_distances(out_.distance2, out_.count, rank_distance_.data());
      place(rank);
      const S end = static_cast<S>(size_);
      for (std::size_t i = 0; i < count; ++i)
        farthest2 = std::max(farthest2, rank[i] < end ? distance2_[i] : S(0));
      return farthest2;
    }
    pairs_.resize(count);
    for (std::size_t i = 0; i < count; ++i) pairs_[i] = {distance2_[i], key(i)};
    const auto end = pairs_.begin() + static_cast<std::ptrdiff_t>(size_);
    if (size_ < count) std::nth_element(pairs_.begin(), end, pairs_.end());
    std::sort(pairs_.begin(), end);
    for (std::size_t i = 0; i < size_; ++i) ordered_[i] = pairs_[i].second;
    return size_ > 0 ? pairs_[size_ - 1].first : S(0);
  }

  S farthest_along_axis() const {
    S farthest = 0;
    for (std::size_t i = 0; i < size_; ++i)
      for (int d = 0; d < D; ++d) {
        S x = x_[d];
        if constexpr (periodic)
          if (shared_.domain.periodic[d])
            x -= static_cast<S>(shift_of(ordered_[i])[d]) * shared_.domain.period(d);
        farthest = std::max(farthest, std::abs(x - shared_.particles(index_of(ordered_[i]), d)));
      }
    return farthest;
  }

  // ---- Order -----------------------------------------------------------------------------------

  void start_order(std::size_t count, std::size_t size) {
    size_ = size;
    if (ordered_.size() < count + 1) ordered_.resize(2 * count + 64);
  }

  // Puts the key of everything gathered at its rank; those of equal rank follow each other.
  template <class T>
  void place(const T* rank) {
    const auto count = static_cast<std::size_t>(out_.count);
    std::size_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto at = static_cast<std::uint32_t>(rank[i]);
      ordered_[at] = key(i);
      sum += at;
    }
    if (sum == count * (count - 1) / 2 || count == 0) return;  // no two are equal
    constexpr Key none = std::numeric_limits<Key>::max();
    std::fill_n(ordered_.begin(), count + 1, none);
    for (std::size_t i = 0; i < count; ++i) {
      auto at = static_cast<std::uint32_t>(rank[i]);
      Key moved = key(i);
      while (ordered_[at] < moved) ++at;
      for (; moved != none; ++at) std::swap(moved, ordered_[at]);
    }
  }

  // ---- Targets that are left to others ---------------------------------------------------------

  S find_in_tree(std::size_t target) {
    if (!in_tree_)
      in_tree_.emplace(shared_.tree.get(), shared_.particles, shared_.targets, shared_.domain,
                       shared_.options, shared_.spacing);
    return find_with(*in_tree_, target);
  }

  template <class Neighbours>
  S find_with(Neighbours& neighbours, std::size_t target) {
    const S rho =
        std::visit([&](const auto& r) { return neighbours.find(target, r); }, shared_.rule);
    const auto& entries = neighbours.entries();
    start_order(entries.size(), entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      Key all = entries[i].index;
      if constexpr (periodic)
        for (const std::int8_t s : entries[i].shift) all = all << 8 | static_cast<Key>(s + 128);
      ordered_[i] = all;
    }
    return rho;
  }

  static constexpr int most_tries = 40;

  Shared<S, D>& shared_;
  PeriodicImages<S, D> images_;
  Point x_{};
  Gathered<S> out_{nullptr, nullptr};
  std::vector<S> distance2_, rank_distance_;
  std::vector<std::uint32_t> index_, shift_, rank_index_;
  std::vector<std::pair<S, Key>> pairs_;
  std::vector<Key> ordered_;
  std::size_t size_ = 0;
  double near_;                   // k-th distance of the latest targets
  int skip_ = 0, next_skip_ = 0;  // targets to be left to the tree without a try
  std::optional<TargetNeighbours<CellGrid<S, D>>> general_;
  std::optional<TargetNeighbours<KdTree<S, D>>> in_tree_;
};

// Targets in the order of bricks of cells, in which they are treated.
template <class S, int D>
SortedPoints<S, D> by_bricks(const Cells<S, D>& cells, const PointCloud<S>& targets, int threads) {
  int edge = D == 1 ? 64 : D == 2 ? 8 : 4;
  CellIndex bricks{};
  const auto count = [&] {
    std::size_t all = 1;
    for (int d = 0; d < max_dimension; ++d) {
      bricks[d] = (cells.count(d) + edge - 1) / edge;
      all *= static_cast<std::size_t>(bricks[d]);
    }
    return all;
  };
  while (count() > 4 * targets.size() + 1024) edge *= 2;
  int shift = 0;
  while (1 << shift < edge) ++shift;
  return sort_by_key<D>(
      targets, count(),
      [&](const std::array<S, D>& x) {
        const CellIndex at = cells.cell_index(x);
        return ((at[2] >> shift) * bricks[1] + (at[1] >> shift)) * bricks[0] + (at[0] >> shift);
      },
      threads, nullptr);
}

template <class S, int D, bool periodic>
NeighbourList<S> find_all(Shared<S, D>& shared) {
  using Targets = CellTargets<S, D, periodic>;
  using Key = typename Targets::Key;
  const int threads = shared.options.threads;
  const std::size_t count = shared.targets.size();
  const Cells<S, D>& cells = shared.grid.sorted_cells();
  SortedPoints<S, D> own;
  const bool same = &shared.targets == &shared.particles;  // sorted already
  if (!same) own = by_bricks(cells, shared.targets, threads);
  const SortedPoints<S, D>& order = same ? cells.sorted() : own;

  NeighbourList<S> list;
  list.offsets.resize(count + 1);
  list.support.resize(count);
  const auto resize = [&](std::size_t entries) {
    list.indices.resize(entries);
    if (periodic) list.shifts.resize(entries);
  };
  const auto write = [&](const Key* keys, std::size_t size, std::size_t at) {
    for (std::size_t i = 0; i < size; ++i) list.indices[at + i] = Targets::index_of(keys[i]);
    if constexpr (periodic)
      for (std::size_t i = 0; i < size; ++i) list.shifts[at + i] = Targets::shift_of(keys[i]);
  };

  if (shared.question.factor > 0) {  // Nearest: the length of each row is known
    const std::size_t k =
        periodic ? shared.question.k : std::min(shared.question.k, shared.particles.size());
    for (std::size_t t = 0; t < count; ++t)
      list.offsets[t + 1] = static_cast<std::int64_t>((t + 1) * k);
    resize(count * k);
    recon::parallel_blocks(count, targets_per_block, threads,
                           [&](std::size_t begin, std::size_t end) {
                             Targets found(shared);
                             for (std::size_t s = begin; s < end; ++s) {
                               const std::size_t t = order.index[s];
                               list.support[t] = found.find(t, order.point(s));
                               write(found.begin(), k, t * k);
                             }
                           });
    return list;
  }
  std::vector<std::vector<Key>> blocks((count + targets_per_block - 1) / targets_per_block);
  recon::parallel_blocks(count, targets_per_block, threads,
                         [&](std::size_t begin, std::size_t end) {
                           Targets found(shared);
                           std::vector<Key>& block = blocks[begin / targets_per_block];
                           for (std::size_t s = begin; s < end; ++s) {
                             const std::size_t t = order.index[s];
                             list.support[t] = found.find(t, order.point(s));
                             list.offsets[t + 1] = static_cast<std::int64_t>(found.size());
                             block.insert(block.end(), found.begin(), found.begin() + found.size());
                           }
                         });
  for (std::size_t t = 0; t < count; ++t) list.offsets[t + 1] += list.offsets[t];
  resize(static_cast<std::size_t>(list.offsets.back()));
  recon::parallel_blocks(
      count, targets_per_block, threads, [&](std::size_t begin, std::size_t end) {
        const std::vector<Key> block = std::move(blocks[begin / targets_per_block]);
        const Key* from = block.data();
        for (std::size_t s = begin; s < end; ++s) {
          const std::size_t t = order.index[s];
          const auto size = static_cast<std::size_t>(list.count(t));
          write(from, size, static_cast<std::size_t>(list.offsets[t]));
          from += size;
        }
      });
  return list;
}

}  // namespace

bool covered_by_cells(const NeighbourRule& rule, const NeighbourOptions& options) {
  return !options.visible &&
         !(std::holds_alternative<NearestWithin>(rule) && options.shape == SupportShape::cube);
}

template <int D, class Scalar>
std::optional<NeighbourList<Scalar>> find_by_cells(const PointCloud<Scalar>& particles,
                                                   const PointCloud<Scalar>& targets,
                                                   const NeighbourRule& rule,
                                                   const PeriodicDomain<Scalar>& domain,
                                                   const NeighbourOptions& options,
                                                   bool may_build_tree) {
  require_valid_question(particles, targets, rule, domain);
  Shared<Scalar, D> shared(particles, targets, rule, domain, options, may_build_tree);
  const double too_many = 1000 + 10 * static_cast<double>(shared.question.k);
  if (may_build_tree && shared.question.nearest &&
      shared.grid.sorted_cells().mean_company() > too_many)
    return {};
  return domain.any() ? find_all<Scalar, D, true>(shared) : find_all<Scalar, D, false>(shared);
}

#define RECON_INSTANTIATE(S, D)                                                                   \
  template std::optional<NeighbourList<S>> find_by_cells<D, S>(                                   \
      const PointCloud<S>&, const PointCloud<S>&, const NeighbourRule&, const PeriodicDomain<S>&, \
      const NeighbourOptions&, bool);
RECON_INSTANTIATE(float, 1)
RECON_INSTANTIATE(float, 2)
RECON_INSTANTIATE(float, 3)
RECON_INSTANTIATE(double, 1)
RECON_INSTANTIATE(double, 2)
RECON_INSTANTIATE(double, 3)
#undef RECON_INSTANTIATE

}  // namespace recon::detail
