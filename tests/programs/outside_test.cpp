// Values of `recon map` beside their data: with its defaults none leaves the range of the
// particles; without a limit hardly any does at targets that are called full and lie
// within the box.
#include <algorithm>
#include <cmath>
#include <span>

#include "recon/points/generate.hpp"
#include "run_program.hpp"

namespace recon::test {
namespace {

class OutsideTest : public ProgramTest {
 protected:
  // A smooth field, one of shorter waves, and the first with noise.
  template <int D>
  void write_cloud(const std::string& name, const PointList<double, D>& points) const {
    RandomNumbers random(77);
    std::ostringstream text;
    text.precision(17);
    text << (D == 2 ? "x,y,u,s,w\n" : "x,y,z,u,s,w\n");
    for (const auto& x : points) {
      double u = 1, phase = 0;
      for (int d = 0; d < D; ++d) {
        u *= std::sin(3.14159265358979 * x[d] + 0.5 * (d + 1));
        phase += (d + 1) * x[d];
        text << x[d] << ',';
      }
      text << u << ',' << std::sin(2 * phase) << ',' << u + 0.3 * random.uniform(-1, 1) << '\n';
    }
    write(name, text.str());
  }

  // Values of targets that are called full and lie within the box of the particles.
  struct Outside {
    std::size_t values = 0, full = 0, beyond = 0;
    double farthest = -HUGE_VAL;  // of all values, in ranges of the data
    double farthest_full = -HUGE_VAL;
  };
  Outside outside(const std::string& particles_file, const std::vector<std::string>& fields,
                  const std::string& result) const {
    const ParticleTable particles = table(particles_file), grid = table(result);
    std::vector<bool> full;
    std::istringstream lines(read(result));
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);)
      full.push_back(line.find(",full,") != std::string::npos);
    const auto axes = particles.coordinates(particles.dimension());
    Outside out;
    for (const std::string& name : fields) {
      const std::span<const double> data = particles.column(name), values = grid.raw_column(name);
      const auto [least, greatest] = std::minmax_element(data.begin(), data.end());
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (std::isnan(values[i])) continue;
        const double excess =
            std::max(*least - values[i], values[i] - *greatest) / (*greatest - *least);
        out.values += 1;
        out.farthest = std::max(out.farthest, excess);
        bool within = full[i];
        for (const std::string& axis : axes) {
          const auto at = particles.column(axis);
          const auto [lower, upper] = std::minmax_element(at.begin(), at.end());
          within = within && grid.column(axis)[i] >= *lower && grid.column(axis)[i] <= *upper;
        }
        if (!within) continue;
        out.full += 1;
        out.beyond += excess > 0.02;
        out.farthest_full = std::max(out.farthest_full, excess);
      }
    }
    return out;
  }

  void check(const std::string& file, const std::vector<std::string>& fields, double per_mille) {
    std::string names;
    for (const std::string& field : fields) names += (names.empty() ? "" : ",") + field;
    const std::string map = "map " + file + " --fields " + names + " --out a.csv ";
    EXPECT_THAT(succeed(map), testing::HasSubstr("of the values, at"));
    Outside out = outside(file, fields, "a.csv");
    EXPECT_LE(out.farthest, 1e-12) << file;
    succeed(map + "--limit none");
    out = outside(file, fields, "a.csv");
    EXPECT_GT(out.full, 300u) << file;
    EXPECT_LE(static_cast<double>(out.beyond), per_mille / 1000 * static_cast<double>(out.full))
        << file;
    EXPECT_LE(out.farthest_full, 0.2) << file;
  }
};

TEST_F(OutsideTest, CloudsThatDoNotFillTheirBox) {
  write_cloud<2>("holes2.csv", points_with_holes<double, 2>(40, 6, 0.15, 1));
  write_cloud<3>("holes3.csv", points_with_holes<double, 3>(16, 6, 0.15, 1));
  write_cloud<2>("heap2.csv", heap_points<double, 2>(40, 2));
  write_cloud<3>("heap3.csv", heap_points<double, 3>(16, 2));
  write_cloud<2>("gas2.csv", random_points<double, 2>(300, 3));
  write_cloud<3>("gas3.csv", random_points<double, 3>(600, 3));
  write_cloud<2>("clusters2.csv", clustered_points<double, 2>(600, 20, 0.1, 4));
  write_cloud<3>("clusters3.csv", clustered_points<double, 3>(1500, 20, 0.1, 4));
  for (const char* file : {"holes2.csv", "holes3.csv", "heap2.csv", "heap3.csv", "gas2.csv",
                           "gas3.csv", "clusters2.csv"})
    check(file, {"u", "s", "w"}, 1);
  // The field of shorter waves, which clusters this far apart do not resolve, leaves more often.
  check("clusters3.csv", {"u", "s", "w"}, 5);
}

TEST_F(OutsideTest, Chute) {
  check(chute(), {"vx", "vy", "vz"}, 1);
}

}  // namespace
}  // namespace recon::test
