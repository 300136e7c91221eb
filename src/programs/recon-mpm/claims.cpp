#include "claims.hpp"

namespace recon::program {
namespace {

const std::vector<std::string> all_fields{"displacement", "velocity", "density", "stress"};

std::vector<Expectation> each(const std::vector<std::string>& methods,
                              const std::vector<std::string>& fields, bool at_least, double order) {
  std::vector<Expectation> all;
  for (const std::string& method : methods)
    for (const std::string& field : fields) all.push_back({method, field, at_least, order});
  return all;
}

std::vector<Expectation> operator+(std::vector<Expectation> a, const std::vector<Expectation>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// "Second order" is a slope of at least 1.75, "does not converge" one of at most 0.5, "first order"
// one between 0.75 and 1.5.
constexpr double second = 1.75, none = 0.5, first = 0.75;

}  // namespace

std::vector<Claim> claims() {
  const std::vector<int> line{8, 16, 32, 64}, long_line{8, 16, 32, 64, 128, 256};
  const std::vector<int> square{8, 16, 32}, large_square{8, 16, 32, 64};
  const std::vector<std::string> mechanics{"displacement", "velocity"};
  return {
      {"Gong 2015, figure 4.7", "MPM appears to be of second order at small deformation, 1-D.",
       "vibration_1d", {"G=0.0001"}, {"mpm"}, line, line, "l2", 1,
       each({"mpm"}, all_fields, true, second)},
      {"Gong 2015, figure 4.8", "MPM does not converge at large deformation, 1-D.", "vibration_1d",
       {"G=0.1"}, {"mpm"}, line, line, "l2", 1, each({"mpm"}, all_fields, false, none)},
      {"Gong 2015, figure 4.9",
       "MPM at small deformation, 2-D: displacement of second order, the rest between 1 and 2.",
       "vibration_2d", {"G=0.0001"}, {"mpm"}, square, large_square, "l2", 1,
       each({"mpm"}, {"displacement"}, true, second) +
           each({"mpm"}, {"velocity", "density", "stress"}, true, 1)},
      {"Gong 2015, figure 4.10", "MPM does not converge at G = 0.05, 2-D.", "vibration_2d",
       {"G=0.05"}, {"mpm"}, square, large_square, "l2", 1, each({"mpm"}, all_fields, false, none)},
      {"Gong 2015, figure 5.5", "IMPM is of second order at small deformation, 1-D.",
       "vibration_1d", {"G=0.0001"}, {"impm"}, line, line, "l2", 1,
       each({"impm"}, all_fields, true, second)},
      {"Gong 2015, figure 5.6", "IMPM is of second order at large deformation, 1-D.",
       "vibration_1d", {"G=0.1"}, {"impm"}, line, long_line, "l2", 1,
       each({"impm"}, all_fields, true, second)},
      {"Gong 2015, figure 5.7", "IMPM is of second order at small deformation, 2-D.",
       "vibration_2d", {"G=0.0001"}, {"impm"}, square, large_square, "l2", 1,
       each({"impm"}, all_fields, true, second)},
      {"Gong 2015, figure 5.8", "IMPM is of second order at large deformation, 2-D.",
       "vibration_2d", {"G=0.1"}, {"impm"}, square, large_square, "l2", 1,
       each({"impm"}, all_fields, true, second)},
      {"Gong 2015, figure 6.1", "CPDI appears to be of second order on coarse grids.",
       "vibration_1d", {"G=0.1"}, {"cpdi2"}, line, line, "l2", 1,
       each({"cpdi2"}, all_fields, true, second)},
      {"Gong 2015, figures 6.2 and 6.3",
       "On fine grids the rate of CPDI drops, that of IMPM stays longer.", "vibration_1d",
       {"G=0.1"}, {"cpdi2", "impm"}, {64, 128, 256}, {128, 256, 512, 1024, 2048}, "l2", 1,
       each({"cpdi2"}, mechanics, false, second) + each({"impm"}, mechanics, true, second)},
      {"Gong 2015, figure 6.4", "The improved map keeps the rate of CPDI on fine grids.",
       "vibration_1d", {"G=0.1"}, {"cpdi2", "improved_cpdi"}, {64, 128, 256},
       {128, 256, 512, 1024, 2048}, "l2", 1, each({"improved_cpdi"}, mechanics, true, second)},
      {"Tran et al. 2019, figures 9, 11, 13",
       "MPM, CPDI and CPLS are of second order at small deformation.", "axis_vibration",
       {"G=0.0001"}, {"mpm", "cpdi1", "cpls"}, square, large_square, "rms", 1,
       each({"mpm", "cpdi1", "cpls"}, {"displacement", "velocity", "stress"}, true, second)},
      {"Tran et al. 2019, figures 10, 12, 14",
       "At large deformation MPM diverges, CPDI loses its rate, CPLS keeps it.", "axis_vibration",
       {"G=0.1"}, {"mpm", "cpdi1", "cpls"}, square, {8, 16, 32, 64, 128}, "rms", 1,
       each({"mpm"}, mechanics, false, none) + each({"cpdi1"}, mechanics, false, second) +
           each({"cpls"}, {"displacement", "velocity", "stress"}, true, second)},
      {"Tran et al. 2019, figures 23, 25, 27",
       "Ring, small deformation: second order in displacement and velocity, first in stress.", "ring",
       {"G=0.0001"}, {"cpdi1", "cpls"}, {10, 20, 40}, {10, 20, 40, 80}, "rms", 1,
       each({"cpdi1", "cpls"}, mechanics, true, second) +
           each({"cpdi1", "cpls"}, {"stress"}, true, first)},
      {"Tran et al. 2019, figures 24, 26, 28",
       "Ring, large deformation: CPDI loses the rate, CPLS keeps it.", "ring", {"G=0.1"},
       {"cpdi1", "cpls"}, {10, 20, 40}, {10, 20, 40, 80}, "rms", 1,
       each({"cpdi1"}, mechanics, false, second) + each({"cpls"}, mechanics, true, second) +
           each({"cpls"}, {"stress"}, true, first)},
      {"Tran et al. 2019, figures 43-45",
       "Vortex: MPM breaks the ring; CPLS is of about second order, CPDI loses it on fine grids.",
       "vortex", {}, {"mpm", "cpdi1", "cpls"}, {8, 16}, {8, 16, 32, 64}, "rms", 1,
       each({"mpm"}, {"displacement"}, false, none) +
           each({"cpdi1"}, {"displacement"}, false, second) +
           each({"cpls"}, {"displacement", "velocity", "stress"}, true, second)},
  };
}

std::vector<Account> accounts() {
  return {
      {"Tran et al. 2019, figures 16-20",
       "The map of CPLS misses a negligible part of the momentum; energies follow the exact ones.",
       "axis_vibration", {"cells=8"}, {"cpdi1", "cpls"}},
      {"Tran et al. 2019, figures 29, 30",
       "Ring: the momentum that the map of CPLS misses is negligible.", "ring", {"cells=10"},
       {"cpdi1", "cpls"}},
      {"Tran et al. 2019, figures 46, 47",
       "Vortex: the momentum that the map of CPLS misses is small.", "vortex", {"cells=8"},
       {"cpdi1", "cpls"}},
      {"Tran et al. 2019, figures 49-54",
       "Disks: kinetic energy goes into strain and comes back; no treatment of contact is needed.",
       "disks", {}, {"cpdi1", "cpls"}},
      {"Tran et al. 2019, figures 56-58",
       "Rebound: a slight loss of total energy, less with CPLS than with CPDI.", "wall", {},
       {"cpdi1", "cpls"}},
      {"Free spin", "Angular momentum of a disk that turns freely (no figure).", "spin", {},
       {"mpm", "cpdi1", "impm", "cpls"}},
  };
}

}  // namespace recon::program
