// Wrong calls and what recon says to them, a line "name<tab>message" for each: the Python module must say the
// same to the same calls (test_messages.py).
#include <array>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "recon/io/read.hpp"
#include "recon/operators/kernel_sum.hpp"
#include "recon/recon.hpp"

namespace {

using recon::field_of;
using recon::points_of;

void say(const char* name, const std::function<void()>& call) {
  try {
    call();
    std::printf("%s\tnothing\n", name);
  } catch (const std::exception& error) {
    std::printf("%s\t%s\n", name, error.what());
  }
}

}  // namespace

int main() {
  std::vector<std::array<double, 2>> points, broken;
  for (int i = 0; i < 100; ++i) points.push_back({i % 10 * 0.1, i / 10 * 0.1});
  broken = points;
  broken[7][1] = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> u(100, 1), short_field(3, 1), wrong(100, 1);
  wrong[40] = std::numeric_limits<double>::infinity();
  const auto view = points_of(points);
  const recon::Reconstruction fit = recon::reconstruct(view, view);
  const std::vector<double> line{0, 1, 2, 3};

  say("degree", [&] { recon::reconstruct(view, view, {.degree = 5}); });
  say("radius", [&] { recon::reconstruct(view, view, {.neighbours = recon::Radius{-1}}); });
  say("no neighbour", [&] { recon::reconstruct(view, view, {.neighbours = recon::Nearest{0}}); });
  say("factor", [&] { recon::reconstruct(view, view, {.neighbours = recon::Nearest{5, 1.0}}); });
  say("coordinate", [&] { recon::Sources{points_of(broken)}; });
  say("target", [&] { recon::reconstruct(view, points_of(broken)); });
  say("dimension", [&] { recon::reconstruct(view, points_of(line)); });
  say("size", [&] { fit.apply(field_of(short_field)); });
  say("value", [&] { fit.apply(field_of(wrong)); });
  say("transposed value", [&] { fit.apply_transpose(field_of(wrong)); });
  say("stretch", [&] { recon::Sources(view, {.stretch = {1, -1, 1}}); });
  say("weights", [&] { recon::Sources(view, {.particle_weights = short_field}); });
  say("grow", [&] { recon::reconstruct(view, view, {.grow = {.steps = -1}}); });
  say("leverage", [&] { recon::reconstruct(view, view, {.tolerances = {.leverage = 0.5}}); });
  say("grid spacing", [&] {
    recon::StructuredGrid<double> grid{
        .dimension = 2, .origin = {0, 0}, .spacing = {0, 1}, .counts = {2, 2}};
    grid.validate();
  });
  say("domain", [&] {
    recon::PeriodicDomain<double> domain{{0, 0}, {1, 0}, {true, true}};
    domain.validate(2);
  });
  say("curl", [&] {
    recon::reconstruct(points_of(line), points_of(line)).operators(recon::Functional::curl);
  });
  say("partial", [&] { recon::Functional::partial(5); });
  say("components",
      [&] { std::get<0>(fit.operators(recon::Functional::divergence)).apply(field_of(u)); });
  say("kernel radius", [&] {
    recon::kernel_sum(recon::Sources(view), view, field_of(u), recon::Weight::gaussian, -2);
  });
  say("scale", [&] { std::numeric_limits<double>::infinity() * fit.values(); });
  say("file", [&] { recon::read_particles("nowhere.dump"); });
}
