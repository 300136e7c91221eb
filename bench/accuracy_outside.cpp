// Values outside the range of the data: how often and how far, by support, leverage and limit.
//
// Clouds that leave parts of their box empty, mapped to the nodes of a grid over the box as the
// program `recon map` does. The range is that of all data; an excess of 1 is a whole range beyond.
#include <cstdio>
#include <filesystem>

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

const char* name_of(Limit limit) {
  return limit == Limit::none ? "none" : limit == Limit::range ? "range" : "relaxed";
}

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
    values(row, 1) = std::sin(4 * phase);
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

// The nodes of a grid over the box of the points, `spacing` apart.
template <int D>
recon::PointList<double, D> nodes_over(const recon::PointList<double, D>& points, double spacing) {
  const auto grid = recon::covering_grid(recon::bounding_box(recon::points_of(points), "points"),
                                         spacing, recon::PeriodicDomain<double>{});
  recon::PointList<double, D> nodes;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    std::array<double, D> x;
    for (int d = 0; d < D; ++d) x[d] = grid.coordinate(grid.index(i)[d], d);
    nodes.push_back(x);
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

struct Outside {
  double values = 0, full = 0, beyond = 0, farthest = 0, limited = 0;
};

// Values at targets whose status is `full`: how many leave the range of the data by more than 2 % of
// it, and by how many ranges the worst does.
template <int D>
Outside outside_of(const Data<D>& data, const recon::PointList<double, D>& targets,
                   const recon::Options& options, Limit limit) {
  const auto fit = reconstruct(recon::points_of(data.points), recon::points_of(targets), options);
  recon::LimitCount count;
  const Eigen::MatrixXd values =
      fit.apply(recon::field_of(data.values), {.limit = limit, .count = &count});
  Outside out;
  out.limited = static_cast<double>(count.values);
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double least = data.values.col(c).minCoeff(), greatest = data.values.col(c).maxCoeff();
    for (Eigen::Index t = 0; t < values.rows(); ++t) {
      out.values += 1;
      if (fit.report()[static_cast<std::size_t>(t)].status != recon::FitStatus::full) continue;
      out.full += 1;
      const double excess =
          std::max(least - values(t, c), values(t, c) - greatest) / (greatest - least);
      out.beyond += excess > 0.02;
      out.farthest = std::max(out.farthest, excess);
    }
  }
  return out;
}

template <int D>
std::vector<std::pair<std::string, recon::NeighbourRule>> rules(const Data<D>& data, int degree) {
  const auto terms = static_cast<std::size_t>(recon::monomial_count(D, degree));
  constexpr double unit_ball[] = {2, std::numbers::pi, 4 * std::numbers::pi / 3};
  const double enough = std::max(
      2.0, std::pow(static_cast<double>(2 * terms + 1) / unit_ball[D - 1], 1.0 / D));
  return {{"radius, box", recon::Radius{enough * box_spacing(data)}},
          {"radius, median", recon::Radius{enough * median_spacing(data)}},
          {"nearest 2 t + 1", recon::Nearest{2 * terms + 1}},
          {"nearest 3 t", recon::Nearest{3 * terms}}};
}

template <int D>
void add_outside(Table& table, const Data<D>& data) {
  const auto targets = nodes_over<D>(data.points, median_spacing(data));
  for (const int degree : {1, 2})
    for (const auto& [name, rule] : rules<D>(data, degree))
      for (const double leverage : {30.0, 5.0, 2.0})
        for (const Limit limit : {Limit::none, Limit::range, Limit::relaxed}) {
          recon::Options options{.degree = degree, .neighbours = rule, .domain = data.domain};
          options.tolerances.leverage = leverage;
          const Outside out = outside_of<D>(data, targets, options, limit);
          table.add({data.name, std::to_string(D), std::to_string(degree), name, number(leverage),
                     name_of(limit), number(100 * out.full / out.values),
                     number(1000 * out.beyond / out.full), number(out.farthest),
                     number(1000 * out.limited / out.values)});
        }
}

// ---- What limits cost where data are dense ----------------------------------------------------------

// Smooth, with its greatest value 1 in the middle of the cube.
template <int D>
double hill(const std::array<double, D>& x) {
  double u = 1;
  for (int d = 0; d < D; ++d) u *= std::sin(std::numbers::pi * (0.1 + 0.8 * x[d]));
  return u;
}

// Targets: well inside; about the extremum; in the outermost half spacing of the cloud; in the first
// half spacing beyond.
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

// Brings a value back into the range of its data widened by `width` times itself, and (where width
// is not 0) into the range of all data.
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

template <int D>
void add_dense(Table& table, const std::string& place) {
  constexpr std::size_t n = D == 2 ? 40 : 20;
  for (int degree = 0; degree <= 4; ++degree) {
    std::array<std::array<double, 5>, 2> errors{};  // with n and 2 n particles per axis
    double moved[5] = {}, reduced[2] = {};
    for (const bool fine : {false, true}) {
      const std::size_t per_axis = fine ? 2 * n : n;
      const double spacing = 1.0 / static_cast<double>(per_axis);
      const auto points = recon::jittered_points<double, D>(per_axis, 0.3, 1);
      const auto targets = targets_at<D>(place, spacing);
      std::vector<double> u;
      for (const auto& x : points) u.push_back(hill<D>(x));
      for (const bool low : {true, false}) {
        recon::Options options{.degree = degree};
        if (low) options.tolerances.leverage = 5;
        const auto fit =
            reconstruct(recon::points_of(points), recon::points_of(targets), options);
        reduced[low] = 100 * static_cast<double>(fit.report().reduced()) / 2000;
        if (low) continue;
        const Eigen::MatrixXd v = fit.apply(recon::field_of(u));
        for (std::size_t t = 0; t < targets.size(); ++t) {
          const auto row = fit.values().row(t);
          const double widths[] = {0, 0.25, 0.5, 1};
          for (std::size_t i = 0; i < 5; ++i) {
            const double plain = v(static_cast<Eigen::Index>(t), 0);
            const double value = i == 0 ? plain : limited(plain, row, u, widths[i - 1]);
            errors[fine][i] += std::pow(value - hill<D>(targets[t]), 2) / 2000;
            if (!fine) moved[i] += std::abs(value - plain) > 1e-13 ? 0.5 : 0;  // per mille
          }
        }
      }
    }
    std::vector<std::string> cells{std::to_string(D), place, std::to_string(degree)};
    for (const double e : errors[0]) cells.push_back(number(std::sqrt(e)));
    for (const std::size_t i : {1u, 3u}) cells.push_back(number(moved[i]));
    for (const std::size_t i : {0u, 1u, 3u})
      cells.push_back(number(std::log2(errors[0][i] / errors[1][i]) / 2));
    cells.push_back(number(reduced[0]));
    cells.push_back(number(reduced[1]));
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

Section outside_study(const Context&) {
  Table table("accuracy_outside",
              {"cloud", "dimension", "degree", "support", "leverage", "limit", "full %",
               "outside per mille", "farthest", "limited per mille"});
  for (const auto& data : clouds<2>()) add_outside<2>(table, data);
  for (const auto& data : clouds<3>()) add_outside<3>(table, data);
  add_outside<3>(table, chute());
  Table dense("accuracy_limits",
              {"dimension", "targets", "degree", "none", "range", "quarter", "relaxed", "whole",
               "limited per mille: range", "limited per mille: relaxed", "order: none",
               "order: range", "order: relaxed", "reduced %: leverage 30",
               "reduced %: leverage 5"});
  for (const char* place : {"inside", "extremum", "wall", "beyond"}) {
    add_dense<2>(dense, place);
    add_dense<3>(dense, place);
  }
  Table times("accuracy_limit_times", {"dimension", "degree", "components", "apply us",
                                       "range / none", "relaxed / none"});
  add_times<2>(times);
  add_times<3>(times);
  return {"Values outside the range of the data", "", {table, dense, times}, {}};
}

}  // namespace recon_bench
