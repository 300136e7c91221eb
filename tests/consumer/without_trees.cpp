// recon without Boost and without nanoflann: the R-tree is refused by the name of the option, and all
// else gives what brute force gives, on clouds that are far too uneven for cells too.
#include <array>
#include <cmath>
#include <cstdio>
#include <recon/neighbourhood/kd_tree.hpp>
#include <recon/neighbourhood/r_tree.hpp>
#include <recon/recon.hpp>
#include <string>
#include <vector>

namespace {

using Points = std::vector<std::array<double, 3>>;
using recon::NeighbourRule;
using recon::SearchMethod;

int failures = 0;

void expect(bool holds, const std::string& what) {
  if (holds) return;
  ++failures;
  std::printf("not so: %s\n", what.c_str());
}

// Distances from the origin from 1e-12 to 1: of 3,000 particles half lie within 1e-6.
Points spike() {
  Points points;
  for (int i = 0; i < 3000; ++i) {
    const double r = std::pow(10, -12 * (i / 3000.0)), a = 2.4 * i, z = std::cos(1.7 * i);
    const double s = std::sqrt(1 - z * z);
    points.push_back({r * s * std::cos(a), r * s * std::sin(a), r * z});
  }
  return points;
}

template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const recon::InvalidArgument& error) {
    return error.what();
  }
  return "nothing was refused";
}

}  // namespace

int main() {
  const Points points = spike();
  const recon::PointCloud<double> cloud(recon::points_of(points));

  const std::string rule =
      "search = r_tree: needs Boost.Geometry, and recon was built with RECON_WITH_BOOST=OFF";
  expect(refusal([&] { recon::RTree<double, 3> tree(cloud); }) == rule, "RTree(cloud)");
  expect(refusal([] { recon::RTree<float, 2> tree; }) == rule, "RTree()");
  expect(refusal([&] {
           recon::find_neighbours(cloud, cloud, recon::Nearest{9}, {},
                                  {.search = SearchMethod::r_tree});
         }) == rule,
         "find_neighbours with an R-tree");
  expect(refusal([&] {
           recon::reconstruct(recon::points_of(points), recon::points_of(points),
                              {.search = SearchMethod::r_tree});
         }) == rule,
         "reconstruct with an R-tree");

  const auto odd = [](std::size_t t, std::size_t p) { return (t + p) % 3 != 0; };
  for (const NeighbourRule& question :
       {NeighbourRule(recon::Nearest{12}), NeighbourRule(recon::NearestWithin{12, 1e-3}),
        NeighbourRule(recon::Radius{1e-9})})
    for (const bool masked : {false, true}) {
      recon::NeighbourOptions options;
      if (masked) options.visible = odd;
      options.search = SearchMethod::brute_force;
      const auto expected = recon::find_neighbours(cloud, cloud, question, {}, options);
      for (const SearchMethod search : {SearchMethod::automatic, SearchMethod::kd_tree}) {
        options.search = search;
        const auto found = recon::find_neighbours(cloud, cloud, question, {}, options);
        expect(found.offsets == expected.offsets && found.indices == expected.indices &&
                   found.support == expected.support,
               "rule " + std::to_string(question.index()) + ", search " +
                   std::to_string(static_cast<int>(search)));
      }
    }

  // Linear fields are reproduced.
  const recon::Reconstruction fit =
      recon::reconstruct(recon::points_of(points), recon::points_of(points), {.degree = 1});
  std::vector<double> linear;
  for (const auto& x : points) linear.push_back(1 + x[0] - 2 * x[1] + x[2] / 2);
  const Eigen::MatrixXd values = fit.apply(recon::field_of(linear));
  double error = 0;
  for (std::size_t t = 0; t < linear.size(); ++t)
    error = std::fmax(error, std::fabs(values(Eigen::Index(t), 0) - linear[t]));
  expect(error <= 1e-12, "linear field: error " + std::to_string(error));
  return failures == 0 ? 0 : 1;
}
