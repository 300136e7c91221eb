// Values outside the range of the data: how often and how far, by support, leverage and limit.
//
// Clouds that leave parts of their box empty, mapped to the nodes of a grid over the box as the
// program `recon map` does. The range is that of all data; an excess of 1 is a whole range beyond.
#include "accuracy.hpp"
#include "accuracy_clouds.hpp"
#include "accuracy_measure.hpp"
#include "recon/io/read.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon_bench {
namespace {

using recon::Limit;

template <int D>
struct Data {
  std::string name;
  recon::PointList<double, D> points;
  Eigen::MatrixXd values;  // a row per particle
  recon::PeriodicDomain<double> domain{};
};

// A smooth field, one that varies on the scale of the holes, and a smooth one with noise.
template <int D>
Eigen::MatrixXd values_at(const recon::PointList<double, D>& points) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(points.size()), 3);
  recon::RandomNumbers random(77);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    double phase = 0;
    for (int d = 0; d < D; ++d) phase += (d + 1) * points[i][d];
    values(row, 0) = field(points[i]);
    values(row, 1) = std::sin(2 * phase);
    values(row, 2) = field(points[i]) + 0.3 * random.uniform(-1, 1);
  }
  return values;
}

template <int D>
std::vector<Data<D>> clouds() {
  using namespace recon;
  constexpr std::size_t n = D == 2 ? 40 : 16;
  std::vector<Data<D>> all;
  const auto add = [&](const char* name, PointList<double, D> points) {
    auto values = values_at<D>(points);
    all.push_back({name, std::move(points), std::move(values), {}});
  };
  add("holes", points_with_holes<double, D>(n, 6, 0.15, 1));
  add("heap", heap_points<double, D>(n, 2));
  add("gas", random_points<double, D>(D == 2 ? 300 : 600, 3));
  add("clusters", clustered_points<double, D>(D == 2 ? 600 : 1500, 20, 0.1, 4));
  add("lattice", regular_points<double, D>(n));
  add("random", random_points<double, D>(n * n * (D == 2 ? 1 : n), 5));
  return all;
}

Data<3> chute() {
  const auto table = recon::read_particles(RECON_BENCH_DATA "/chute.dump.gz", {.frame = -1});
  const auto positions = table.positions(3);
  const auto velocity = table.field("v", {"vx", "vy", "vz"});
  Data<3> data{"chute", {}, Eigen::MatrixXd(positions.size(), 3), table.domain(3)};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    data.points.push_back({positions(i, 0), positions(i, 1), positions(i, 2)});
    for (int c = 0; c < 3; ++c)
      data.values(static_cast<Eigen::Index>(i), c) = velocity.view()(i, c);
  }
  return data;
}

// The nodes of a grid over the box of the points, `spacing` apart, that lie within it: a node
// beyond the last particle of all can only be extrapolated to.
template <int D>
recon::PointList<double, D> nodes_over(const Data<D>& data, double spacing) {
  const auto box = recon::bounding_box(recon::points_of(data.points), "points");
  const auto grid = recon::covering_grid(box, spacing, data.domain);
  recon::PointList<double, D> nodes;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    std::array<double, D> x;
    bool within = true;
    for (int d = 0; d < D; ++d) {
      x[d] = grid.coordinate(grid.index(i)[d], d);
      within =
          within && (data.domain.periodic[d] || (x[d] >= box.lower[d] && x[d] <= box.upper[d]));
    }
    if (within) nodes.push_back(x);
  }
  return nodes;
}

// The median over the particles of the distance to the D (D + 1)th neighbour, as the spacing of a
// lattice of that density.
template <int D>
double median_spacing(const Data<D>& data) {
  constexpr std::size_t k = D * (D + 1);
  const recon::PointCloud<double> cloud(recon::points_of(data.points), "points", data.domain);
  auto reach =
      recon::find_neighbours(cloud, cloud, recon::Nearest{k + 1, 2.0}, data.domain).support;
  const auto middle = reach.begin() + static_cast<std::ptrdiff_t>(reach.size() / 2);
  std::nth_element(reach.begin(), middle, reach.end());
  constexpr double unit_ball[] = {2, std::numbers::pi, 4 * std::numbers::pi / 3};
  return *middle / 2 * std::pow(unit_ball[D - 1] / k, 1.0 / D);
}

template <int D>
double box_spacing(const Data<D>& data) {
  const auto box = recon::bounding_box(recon::points_of(data.points), "points");
  double volume = 1;
  for (int d = 0; d < D; ++d) volume *= box.extent(d);
  return std::pow(volume / static_cast<double>(data.points.size()), 1.0 / D);
}

constexpr double max_distance = 2;  // as the program has it

// Of the values at targets whose status is `full`: how many leave the range of the data by
// more than 2 % of it, and by how many ranges the worst does. How many values each limit
// changes, of all.
struct Outside {
  double values = 0, full = 0, beyond = 0, farthest = 0, by_range = 0, by_relaxed = 0;
};

template <int D>
Outside outside_of(const Data<D>& data, const recon::PointList<double, D>& targets,
                   const recon::Options& options) {
  const auto fit = reconstruct(recon::points_of(data.points), recon::points_of(targets), options);
  const Eigen::MatrixXd values = fit.apply(recon::field_of(data.values));
  Outside out;
  recon::LimitCount count;
  fit.apply(recon::field_of(data.values), {.limit = Limit::range, .count = &count});
  out.by_range = static_cast<double>(count.values);
  fit.apply(recon::field_of(data.values), {.limit = Limit::relaxed, .count = &count});
  out.by_relaxed = static_cast<double>(count.values);
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double least = data.values.col(c).minCoeff(), greatest = data.values.col(c).maxCoeff();
    for (Eigen::Index t = 0; t < values.rows(); ++t) {
      const auto status = fit.report()[static_cast<std::size_t>(t)].status;
      out.values += status != recon::FitStatus::too_far && status != recon::FitStatus::no_support;
      if (status != recon::FitStatus::full) continue;
      out.full += 1;
      const double excess =
          std::max(least - values(t, c), values(t, c) - greatest) / (greatest - least);
      out.beyond += excess > 0.02;
      out.farthest = std::max(out.farthest, excess);
    }
  }
  return out;
}

constexpr double unit_ball[] = {2, std::numbers::pi, 4 * std::numbers::pi / 3};

// The radius that the program takes for kernel sums, and took for fits once.
template <int D>
double radius_of(double spacing, int degree) {
  const double terms = static_cast<double>(recon::monomial_count(D, degree));
  return spacing * std::max(2.0, std::pow((2 * terms + 1) / unit_ball[D - 1], 1.0 / D));
}

template <int D>
std::vector<std::pair<std::string, recon::NeighbourRule>> rules(const Data<D>& data, int degree) {
  const auto terms = static_cast<std::size_t>(recon::monomial_count(D, degree));
  return {{"radius (box)", recon::Radius{radius_of<D>(box_spacing(data), degree)}},
          {"radius (median)", recon::Radius{radius_of<D>(median_spacing(data), degree)}},
          {"nearest 2 per term", recon::Nearest{2 * terms + 1}},
          {"nearest 3 per term", recon::Nearest{3 * terms}}};
}

template <int D>
void add_outside(Table& table, const Data<D>& data) {
  const auto targets = nodes_over<D>(data, median_spacing(data));
  for (const int degree : {1, 2})
    for (const auto& [name, rule] : rules<D>(data, degree))
      for (const double leverage : {30.0, 5.0, 2.5, 2.0}) {
        recon::Options options{.degree = degree,
                               .neighbours = rule,
                               .domain = data.domain,
                               .max_distance = max_distance};
        options.tolerances.leverage = leverage;
        const Outside out = outside_of<D>(data, targets, options);
        table.add({data.name, std::to_string(D), std::to_string(degree), name, number(leverage),
                   number(100 * out.full / out.values), number(1000 * out.beyond / out.full),
                   number(out.farthest), number(1000 * out.by_range / out.values),
                   number(1000 * out.by_relaxed / out.values)});
      }
}

// ---- What limits cost where data are dense ------------------------------------------------------

// Smooth, with its greatest value 1 in the middle of the cube.
template <int D>
double hill(const std::array<double, D>& x) {
  double u = 1;
  for (int d = 0; d < D; ++d) u *= std::sin(std::numbers::pi * (0.1 + 0.8 * x[d]));
  return u;
}

// Targets: well inside; about the extremum; in the outermost half spacing of the cloud; in the
// first half spacing beyond.
template <int D>
recon::PointList<double, D> targets_at(const std::string& place, double spacing) {
  auto targets = inner_targets<D>(2000, 9);
  recon::RandomNumbers random(10);
  for (auto& x : targets) {
    if (place == "extremum")
      for (double& c : x) c = 0.5 + spacing * random.uniform(-1, 1);
    else if (place == "wall")
      x[0] = 1 - spacing / 2 * random.uniform();
    else if (place == "beyond")
      x[0] = 1 + spacing / 2 * random.uniform();
  }
  return targets;
}

// Brings a value back into the range of its data widened by `width` times itself, and into the
// range of all data.
double limited(double value, const recon::CsrOperator<double>::Row& row,
               const std::vector<double>& u, double width) {
  double least = HUGE_VAL, greatest = -HUGE_VAL;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (row.value(i) == 0) continue;
    least = std::min(least, u[row.particle(i)]);
    greatest = std::max(greatest, u[row.particle(i)]);
  }
  const double more = width * (greatest - least);
  const auto [all_least, all_greatest] = std::minmax_element(u.begin(), u.end());
  return std::clamp(value, std::max(*all_least, least - more),
                    std::min(*all_greatest, greatest + more));
}

// The errors on a jittered cloud with so many particles per axis.
struct DenseErrors {
  std::array<double, 4> rms{};      // no limit, range, half of the range beyond, relaxed
  std::array<double, 4> changed{};  // values per mille
  double before = 0, after = 0;     // as the program had it, and as it has it
  double reduced_before = 0, reduced_after = 0;  // per cent
};

template <int D>
DenseErrors dense_errors(const std::string& place, int degree, std::size_t per_axis) {
  const double spacing = 1.0 / static_cast<double>(per_axis);
  const auto points = recon::jittered_points<double, D>(per_axis, 0.3, 1);
  const auto targets = targets_at<D>(place, spacing);
  const double share = 1.0 / static_cast<double>(targets.size());
  std::vector<double> u;
  for (const auto& x : points) u.push_back(hill<D>(x));
  const auto rms = [&](const auto& value) {
    double sum = 0;
    for (std::size_t t = 0; t < targets.size(); ++t)
      sum += share * std::pow(value(t) - hill<D>(targets[t]), 2);
    return std::sqrt(sum);
  };
  const auto fit_with = [&](const recon::NeighbourRule& rule, double leverage) {
    recon::Options options{.degree = degree, .neighbours = rule};
    options.tolerances.leverage = leverage;
    return reconstruct(recon::points_of(points), recon::points_of(targets), options);
  };
  const recon::Nearest nearest{
      3 * static_cast<std::size_t>(recon::monomial_count(D, std::max(degree, 1)))};
  DenseErrors out;
  const auto fit = fit_with(nearest, 30);
  const Eigen::MatrixXd plain = fit.apply(recon::field_of(u));
  const double widths[] = {HUGE_VAL, 0, 0.5, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto value = [&](std::size_t t) {
      const double v = plain(static_cast<Eigen::Index>(t), 0);
      return i == 0 ? v : limited(v, fit.values().row(t), u, widths[i]);
    };
    out.rms[i] = rms(value);
    for (std::size_t t = 0; t < targets.size(); ++t)
      if (std::abs(value(t) - plain(static_cast<Eigen::Index>(t), 0)) > 1e-13)
        out.changed[i] += 1000 * share;
  }
  const auto old = fit_with(recon::Radius{radius_of<D>(spacing, degree)}, 30);
  const Eigen::MatrixXd old_values = old.apply(recon::field_of(u));
  const auto now = fit_with(nearest, 2.5);
  const Eigen::MatrixXd now_values =
      now.apply(recon::field_of(u), {.limit = Limit::relaxed, .count = nullptr});
  out.before = rms([&](std::size_t t) { return old_values(static_cast<Eigen::Index>(t), 0); });
  out.after = rms([&](std::size_t t) { return now_values(static_cast<Eigen::Index>(t), 0); });
  out.reduced_before = 100 * share * static_cast<double>(old.report().reduced());
  out.reduced_after = 100 * share * static_cast<double>(now.report().reduced());
  return out;
}

template <int D>
void add_dense(Table& table, const std::string& place) {
  constexpr std::size_t n = D == 2 ? 40 : 20;
  for (int degree = 0; degree <= 4; ++degree) {
    const DenseErrors coarse = dense_errors<D>(place, degree, n);
    const DenseErrors fine = dense_errors<D>(place, degree, 2 * n);
    std::vector<std::string> cells{std::to_string(D),           place,
                                   std::to_string(degree),      number(coarse.before),
                                   number(coarse.after),        number(coarse.reduced_before),
                                   number(coarse.reduced_after)};
    for (const double e : coarse.rms) cells.push_back(number(e));
    for (const std::size_t i : {1u, 3u}) cells.push_back(number(coarse.changed[i]));
    for (const std::size_t i : {0u, 1u, 3u})
      cells.push_back(number(std::log2(coarse.rms[i] / fine.rms[i])));
    table.add(cells);
  }
}

template <int D>
void add_times(Table& table) {
  const auto s = make_setting<D>(CloudKind::random, D == 2 ? 150 : 30, 20000);
  for (int degree = 1; degree <= 4; ++degree) {
    const auto fit = reconstruct(recon::points_of(s.points), recon::points_of(s.targets),
                                 recon::Options{.degree = degree, .threads = 1});
    for (const int components : {1, 3}) {
      Eigen::MatrixXd u(static_cast<Eigen::Index>(s.points.size()), components);
      for (std::size_t i = 0; i < s.points.size(); ++i)
        u.row(static_cast<Eigen::Index>(i)).setConstant(field(s.points[i]));
      Eigen::MatrixXd v(static_cast<Eigen::Index>(s.targets.size()), components);
      double times[3];
      for (const Limit limit : {Limit::none, Limit::range, Limit::relaxed})
        times[static_cast<int>(limit)] = fastest(Timer::one_thread, 0.05, [&] {
          fit.apply(recon::field_of(u), recon::field_of(v), {.limit = limit});
        });
      const double micro = 1e6 / static_cast<double>(s.targets.size());
      table.add({std::to_string(D), std::to_string(degree), std::to_string(components),
                 number(micro * times[0]), number(times[1] / times[0]),
                 number(times[2] / times[0])});
    }
  }
}

}  // namespace

Section outside_study(const Context& context) {
  Table table("accuracy_outside",
              {"cloud", "dimension", "degree", "support", "leverage", "full %", "outside per mille",
               "farthest", "limited per mille: range", "limited per mille: relaxed"});
  for (const auto& data : clouds<2>()) add_outside<2>(table, data);
  if (!context.quick)
    for (const auto& data : clouds<3>()) add_outside<3>(table, data);
  add_outside<3>(table, chute());
  Table dense(
      "accuracy_limits",
      {"dimension", "targets", "degree", "before", "after", "reduced % before", "reduced % after",
       "no limit", "range", "half", "relaxed", "changed per mille: range",
       "changed per mille: relaxed", "order: no limit", "order: range", "order: relaxed"});
  for (const char* place : {"inside", "extremum", "wall", "beyond"}) {
    add_dense<2>(dense, place);
    if (!context.quick) add_dense<3>(dense, place);
  }
  Table times("accuracy_limit_times",
              {"dimension", "degree", "components", "apply us", "range / none", "relaxed / none"});
  add_times<2>(times);
  add_times<3>(times);
  return {
      "Values outside the range of the data",
      "Clouds that leave parts of their box empty, mapped to the nodes of a grid over it: of the "
      "values called full, how many (per mille) leave the range of all data by more than 2 % of "
      "it, and by how many ranges the farthest does; how many values limits change. Then what "
      "defaults and limits cost where particles are dense (RMS errors, a field of size 1), and "
      "in time (of apply, one thread). Before: a radius of 2 spacings or more, leverage 30; "
      "after: the 3 nearest per term, leverage 2.5, limit relaxed.",
      {table, dense, times},
      {}};
}

}  // namespace recon_bench
