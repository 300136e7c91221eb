// All targets of a GPU at once, for any executor (host.hpp): search, fit, operators and products.
//
// Rows stand in the order of the cells that their targets lie in; target_of() says whose they are.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <variant>

#include "cuda/fit.hpp"
#include "cuda/products.hpp"
#include "recon/neighbourhood/question_checks.hpp"
#include "recon/neighbourhood/search.hpp"
#include "recon/shape/options.hpp"

namespace recon::cuda {

// The degrees that are compiled.
template <int... degrees>
struct Degrees {
  // Calls body(std::integral_constant<int, R>) for the degree; false where it is not compiled.
  template <class Body>
  static bool with(int degree, const Body& body) {
    const auto one = [&](auto r) {
      if (r != degree) return false;
      body(r);
      return true;
    };
    return (one(std::integral_constant<int, degrees>{}) || ...);
  }
};

// What a derivative operator is of.
enum class Asked { gradient, hessian, laplacian };
constexpr int blocks_of(Asked asked, int dimension) {
  return asked == Asked::gradient  ? dimension
         : asked == Asked::hessian ? dimension * (dimension + 1) / 2
                                   : 1;
}

// Throws InvalidArgument, naming the option, for all that there is not on a GPU.
inline void require_on_gpu(const Options& options) {
  using detail::require;
  options.validate_with_sources();
  require(options.weight.named().has_value(), "weight", "of your own",
          "must be one of recon::Weight on a GPU");
  require(options.form.value_or(WeightForm::radial) == WeightForm::radial, "form", "tensor_product",
          "must be radial on a GPU");
  const Solver solver = options.solver.value_or(Solver::gram_schmidt);
  require(solver == Solver::moment_matrix || solver == Solver::gram_schmidt, "solver",
          name_of(solver), "must be moment_matrix or gram_schmidt on a GPU");
  require(options.search == SearchMethod::automatic || options.search == SearchMethod::cell_grid,
          "search", static_cast<int>(options.search), "must be automatic or cell_grid on a GPU");
  require(!options.visible, "visible", "given", "must be empty on a GPU");
  require(options.max_distance == std::numeric_limits<double>::infinity(), "max_distance",
          options.max_distance, "must be infinite on a GPU");
  require(options.grow.steps == 0, "grow.steps", options.grow.steps, "must be 0 on a GPU");
  require(options.unsupported == Unsupported::fill, "unsupported", "nearest",
          "must be fill on a GPU");
  require(!options.progress, "progress", "given", "must be empty on a GPU");
  if (options.neighbours)
    require(std::holds_alternative<Radius>(*options.neighbours) ||
                std::holds_alternative<Nearest>(*options.neighbours),
            "neighbours", "another rule", "must be Radius or Nearest on a GPU");
}

template <class Executor, int D, class T, class Compiled>
class ReconstructionOn {
  template <class U>
  using Array = typename Executor::template Array<U>;

 public:
  using Sources = SourcesOn<Executor, D, T>;

  // Numbers for each entry: of the values themselves, or of derivatives.
  struct Operator {
    int blocks = 1;
    std::uint64_t version = 0;
    Array<T> values;
  };

  ReconstructionOn(std::shared_ptr<Sources> sources, const Points<D, T>& targets,
                   const Options& options)
      : sources_(std::move(sources)), executor_(sources_->executor()) {
    require_on_gpu(options);
    options_.emplace(options.for_points(D));
    rule_ = *options_->neighbours;
    detail::require(Compiled::with(options_->degree, [](auto) {}), "degree", options_->degree,
                    "must be one of those that are compiled for a GPU");
    detail::require_valid_rule<T>(rule_, D, targets.count, sources_->size());
    executor_->provide(trouble_, 1);
    executor_->provide(total_, 2);
    start(targets);
    find(nullptr);
    finish();
  }
  ReconstructionOn(const ReconstructionOn&) = delete;
  ReconstructionOn& operator=(const ReconstructionOn&) = delete;

  // For targets of the same or another number, and the present positions of the Sources. Nothing is
  // allocated for numbers that are not larger, and nobody waits.
  void update(const Points<D, T>& targets) {
    start(targets);
    find(&room_);
    finish();
  }

  // Memory for so many neighbours of all targets, and of one: what an update needs that finds more.
  void reserve(std::int64_t entries, std::int64_t longest_row) {
    room_.entries = most_of(room_.entries, entries);
    room_.longest = most_of(room_.longest, longest_row);
    require_entries(room_.entries);
  }

  // Waits, and throws InvalidArgument for what was found wrong in the Sources and here.
  void check() {
    sources_->check();
    Trouble trouble;
    executor_->to_host(trouble_.data(), &trouble, 1);
    refuse_bad_points<D>(*executor_, trouble, incoming_.data(), "targets");
    const auto caller = [&](std::uint32_t row) {
      std::uint32_t target = 0;
      executor_->to_host(target_of_.data() + row, &target, 1);
      return target;
    };
    if (trouble.shift != none)
      detail::throw_invalid("target " + std::to_string(caller(trouble.shift)), "far away",
                            "must not need shifts of periodic images beyond 127");
    if (trouble.support != none)
      detail::throw_invalid("target " + std::to_string(caller(trouble.support)), "infinite",
                            "must have a support that can be represented");
    if (trouble.room != none) {
      std::int64_t found[2];
      executor_->to_host(total_.data(), found, 2);
      detail::throw_invalid(
          "neighbours of all targets, and of one",
          detail::to_text(found[0]) + ", " + detail::to_text(found[1]),
          "must not exceed the memory there is, " + detail::to_text(room_.entries) + " and " +
              detail::to_text(room_.longest) + ": reserve() more and update again");
    }
  }

  std::size_t targets() const { return count_; }
  const Options& options() const { return *options_; }
  const std::shared_ptr<Sources>& sources() const { return sources_; }
  const Operator& values() const { return values_; }
  // On the device: of the caller's targets, and of the rows.
  const FitReport* reports() const { return reports_.data(); }
  const std::uint32_t* target_of() const { return target_of_.data(); }
  const std::int64_t* offsets() const { return offsets_.data(); }
  const std::uint32_t* columns() const { return columns_.data(); }
  const std::uint32_t* shifts() const { return frame().any_period() ? shifts_.data() : nullptr; }
  const T* support() const { return support_.data(); }

  // Waits for the number of neighbours of all targets.
  std::int64_t entries() {
    std::int64_t total = 0;
    executor_->to_host(offsets_.data() + count_, &total, 1);
    return total;
  }

  void derive(Asked asked, Derivative kind, Operator& into) {
    require_current();
    detail::require_derivative(kind);
    into.blocks = blocks_of(asked, D);
    into.version = version_;
    executor_->provide(into.values, static_cast<std::size_t>(room_.entries * into.blocks));
    FitTask<D, T> task = this->task();
    task.kind = kind;
    (asked == Asked::gradient  ? task.gradient
     : asked == Asked::hessian ? task.hessian
                               : task.laplacian) = into.values.data();
    fit(task);
  }

  void apply(const Operator& values, const Field<const T>& in, const Field<T>& out) {
    require_current(values);
    in.validate("field", sources_->size());
    out.validate("result", count_);
    detail::require(out.components == in.components * values.blocks, "components of the result",
                    out.components, "must be those of the field times the blocks of the operator");
    executor_->for_each(count_, Apply<T>{offsets_.data(), columns_.data(), target_of_.data(),
                                         reports_.data(), values.values.data(), values.blocks, in,
                                         out, static_cast<T>(options_->fill_value)});
  }

  // The first call after an update sorts the entries by columns, and the very first needs memory
  // for that: 16 bytes for each entry.
  void apply_transpose(const Operator& values, const Field<const T>& in, const Field<T>& out) {
    require_current(values);
    in.validate("field", count_);
    out.validate("result", sources_->size());
    detail::require(in.components == out.components * values.blocks, "components of the field",
                    in.components, "must be those of the result times the blocks of the operator");
    sort_by_columns();
    executor_->for_each(
        sources_->size(),
        ApplyTransposed<T>{first_.data(), entry_.data(), row_of_.data(), target_of_.data(),
                           values.values.data(), values.blocks, in, out});
  }

 private:
  // What there is memory for, and must be said beforehand: entries of all rows, and of one.
  struct RoomFor {
    std::int64_t entries = 0, longest = 0;
  };

  const Frame<D, T>& frame() const { return sources_->frame(); }
  Rows<T> rows() { return {offsets_.data(), places_.data(), shifts_.data(), support_.data()}; }

  static void require_entries(std::int64_t entries) {
    detail::require(entries < 0xFFFFFFFFll, "neighbours of all targets", entries,
                    "must be fewer than 2^32 - 1");
  }
  void require_current() const {
    detail::require(sources_version_ == sources_->version(), "reconstruction", "stale",
                    "must be updated after its Sources were");
  }
  void require_current(const Operator& values) const {
    require_current();
    detail::require(values.version == version_, "operator", "stale",
                    "must be made anew after an update of its reconstruction");
  }

  // Takes the targets, in the order of the cells.
  void start(const Points<D, T>& targets) {
    targets.validate("targets");
    count_ = targets.count;
    ++version_;
    sources_version_ = sources_->version();
    columns_are_sorted_ = false;
    Executor& run = *executor_;
    const std::size_t n = count_;
    for (auto* array : {&incoming_, &targets_}) run.provide(*array, n * D);
    for (auto* array : {&key_, &target_of_, &others_, &others_at_}) run.provide(*array, n + 1);
    run.provide(list_, n);
    run.provide(offsets_, n + 1);
    run.provide(support_, n);
    run.provide(reports_, n);
    run.for_each(1, Forget{trouble_.data()});
    run.for_each(n, Load<D, T>{targets, frame(), incoming_.data(), trouble_.data()});
    sources_->sort(incoming_.data(), n, key_, target_of_);
    run.for_each(n, Permute<D, T>{incoming_.data(), target_of_.data(), targets_.data()});
  }

  void provide_entries() {
    const auto entries = static_cast<std::size_t>(room_.entries);
    executor_->provide(places_, entries);
    executor_->provide(columns_, entries);
    executor_->provide(values_.values, entries);
    if (frame().any_period()) executor_->provide(shifts_, entries);
  }

  // Finds the rows. `room`: what there is memory for; null: as much as needed, which waits for the
  // number of neighbours where a rule does not say it.
  void find(const RoomFor* room) {
    if (frame().any_period())
      find<true>(room);
    else
      find<false>(room);
  }
  template <bool periodic>
  void find(const RoomFor* room) {
    if (const auto* nearest = std::get_if<Nearest>(&rule_))
      find_nearest<periodic>(*nearest);
    else
      find_within<periodic>(std::get<Radius>(rule_), room);
  }

  template <bool periodic>
  void find_nearest(const Nearest& rule) {
    const std::size_t there = sources_->size();
    std::size_t k = rule.k;
    if (there == 0 || !periodic) k = k < there ? k : there;
    detail::require(k < 0x7FFFFFFFu, "k", k, "must be fewer than 2^31 - 1 on a GPU");
    const auto entries = static_cast<std::int64_t>(k * count_);
    require_entries(entries);
    room_.entries = most_of(room_.entries, entries);
    room_.longest = most_of(room_.longest, static_cast<std::int64_t>(k));
    provide_entries();
    executor_->for_each(count_ + 1, EqualRows{offsets_.data(), static_cast<std::int64_t>(k)});
    // Boxes of cells that hold k by the mean density.
    int reach = 1;
    const auto holds = [&] { return particles_per_cell * std::pow(2 * reach + 1, D); };
    while (holds() < static_cast<double>(k) && reach < 1000) ++reach;
    const int n = static_cast<int>(k);
    if (n <= 32) return nearest_in<periodic, 32>(n, reach, rule.factor);
    if (n <= 64) return nearest_in<periodic, 64>(n, reach, rule.factor);
    nearest_in<periodic, 0>(n, reach, rule.factor);
  }
  template <bool periodic, int room>
  void nearest_in(int k, int reach, double factor) {
    FindNearest<D, T, periodic, room> search{sources_->view(), targets_.data(), k, reach, factor,
                                             rows(),           trouble_.data()};
    if constexpr (room == 0) {
      const std::size_t entries = static_cast<std::size_t>(k) * count_;
      Array<KeyOf<periodic>>& keys = std::get<Array<KeyOf<periodic>>>(far_keys_);
      executor_->provide(keys, entries);
      search.far_distance2 = values_.values.data();  // the fit comes later
      search.far_key = keys.data();
    }
    executor_->for_each(count_, search);
  }

  template <bool periodic>
  void find_within(const Radius& rule, const RoomFor* room) {
    const T rho = static_cast<T>(rule.radius), far = reach(rho);
    Executor& run = *executor_;
    using Count = CountWithin<D, T, periodic>;
    using Find = FindWithin<D, T, periodic>;
    run.for_each(count_,
                 Count{sources_->view(), targets_.data(), rho, far, rows(), trouble_.data()});
    run.for_each(1, SetOne{offsets_.data() + count_, 0});
    if (count_ > 0) {
      const std::int64_t* const longest =
          fold<std::int64_t>(run, longest_, count_, CountOf{offsets_.data()}, Larger{});
      run.for_each(1, CopyOne{longest, total_.data() + 1});
    } else {
      run.for_each(1, SetOne{total_.data() + 1, 0});
    }
    run.scan(offsets_.data(), offsets_.data(), count_ + 1);
    run.for_each(1, CopyOne{offsets_.data() + count_, total_.data()});
    if (!room) {
      std::int64_t found[2];
      run.to_host(total_.data(), found, 2);
      // Some more, for updates.
      room_ = {found[0] + found[0] / 4, found[1] + found[1] / 2};
    }
    require_entries(room_.entries);
    provide_entries();
    run.for_each(count_ + 1, KeepToRoom{offsets_.data(), total_.data(), total_.data() + 1,
                                        room_.entries, room_.longest, trouble_.data()});
    run.for_each(count_, Find{sources_->view(), targets_.data(), rho, far, rows()});
  }

  FitTask<D, T> task() {
    FitTask<D, T> task;
    task.particles = sources_->view().x;
    task.targets = targets_.data();
    task.rows = rows();
    task.frame = frame();
    const auto* nearest = std::get_if<Nearest>(&rule_);
    task.support_factor = nearest ? static_cast<T>(nearest->factor) : T(0);
    task.tolerances = options_->tolerances;
    task.weight = {*options_->weight.named()};
    task.solver = *options_->solver;
    task.target_of = target_of_.data();
    task.others = others_.data();
    return task;
  }

  void finish() {
    FitTask<D, T> task = this->task();
    task.value = values_.values.data();
    task.reports = reports_.data();
    values_.version = version_;
    fit(task);
    executor_->for_each(count_, NameEntries{offsets_.data(), count_, places_.data(),
                                            sources_->order(), columns_.data(), nullptr});
  }

  void fit(const FitTask<D, T>& task) {
    Compiled::with(options_->degree, [&](auto r) {
      constexpr int R = decltype(r)::value;
      if (*options_->solver == Solver::moment_matrix)
        fit_safe<R, Solver::moment_matrix>(task);
      else
        fit_safe<R, Solver::gram_schmidt>(task);
      fit_others<R>(task);
    });
  }
  template <int R, Solver solver>
  void fit_safe(const FitTask<D, T>& task) {
    if (task.gradient || task.second())
      fit_in_room<R, solver, true>(task);
    else
      fit_in_room<R, solver, false>(task);
  }
  template <int R, Solver solver, bool derivatives>
  void fit_in_room(const FitTask<D, T>& task) {
    constexpr int small = Executor::small_room, large = Executor::large_room;
    if constexpr (small < large)
      if (room_.longest > small)
        return executor_->for_each(count_, FitSafe<D, R, T, solver, large, derivatives>{task});
    executor_->for_each(count_, FitSafe<D, R, T, solver, small, derivatives>{task});
  }

  template <int R>
  void fit_others(const FitTask<D, T>& task) {
    Executor& run = *executor_;
    using Fit = FitOthers<D, R, T>;
    run.for_each(1, SetFlag{others_.data() + count_});
    run.scan(others_.data(), others_at_.data(), count_ + 1);
    run.for_each(count_, Select{others_.data(), others_at_.data(), list_.data()});
    const int most = static_cast<int>(most_of<std::int64_t>(room_.longest, 1));
    const std::size_t bytes = Fit::bytes_for(most);
    const std::size_t fewest = least_of<std::size_t>(count_, Executor::fewest_workers);
    const std::size_t workers =
        least_of(count_, most_of(fewest, Executor::bytes_of_workers / bytes));
    run.provide(memory_, workers * bytes);
    run.for_each(workers, Fit{task, list_.data(), others_at_.data() + count_, workers,
                              memory_.data(), bytes, most});
  }

  void sort_by_columns() {
    if (columns_are_sorted_) return;
    Executor& run = *executor_;
    const auto entries = static_cast<std::size_t>(room_.entries);
    const std::size_t particles = sources_->size();
    run.provide(row_of_, entries);
    run.provide(column_key_, entries);
    run.provide(entry_, entries);
    run.provide(first_, particles + 1);
    run.for_each(count_, NameEntries{offsets_.data(), count_, places_.data(), sources_->order(),
                                     nullptr, row_of_.data()});
    run.for_each(entries, KeyEntries{offsets_.data() + count_, columns_.data(),
                                     static_cast<std::uint32_t>(particles), column_key_.data(),
                                     entry_.data()});
    run.sort(column_key_, entry_, entries, bits_of(particles));
    run.for_each(
        entries + 1,
        FirstOfEach<Known>{
            column_key_.data(), entries, {static_cast<std::int64_t>(particles)}, first_.data()});
    columns_are_sorted_ = true;
  }

  std::shared_ptr<Sources> sources_;
  std::shared_ptr<Executor> executor_;
  std::optional<Options> options_;
  NeighbourRule rule_ = Nearest{1};
  RoomFor room_;
  std::size_t count_ = 0;
  std::uint64_t version_ = 0, sources_version_ = 0;
  bool columns_are_sorted_ = false;

  Array<T> incoming_, targets_, support_;
  Array<std::uint32_t> key_, target_of_, others_, others_at_, list_;
  Array<std::int64_t> offsets_, total_, longest_;
  Array<std::uint32_t> places_, shifts_, columns_;
  std::tuple<Array<std::uint32_t>, Array<std::uint64_t>> far_keys_;
  Array<std::uint32_t> row_of_, column_key_, entry_, first_;
  Array<FitReport> reports_;
  Array<Trouble> trouble_;
  Array<std::byte> memory_;
  Operator values_;
};

}  // namespace recon::cuda
