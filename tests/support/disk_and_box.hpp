// A disk that flies towards a box, over a floor: runs of many kinds are compared on it.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "recon/runs/read_problem.hpp"

namespace recon::mpm::test {

// Settings as `recon-mpm run --set` takes them.
inline ProblemFile<2> disk_and_box(const std::string& method,
                                   std::vector<std::string> settings = {}) {
  settings.insert(settings.begin(), "method.name=" + method);
  const std::string text = R"TOML(
[grid]
lower = [0.0, 0.0]
upper = [2.0, 1.0]
cells = 10
[material]
young = 1000
poisson = 0.3
density = 10
[[body]]
shape = "disk"
centre = [0.3, 0.4]
radius = 0.2
velocity = [3, 0.1]
[[body]]
shape = "box"
lower = [0.6, 0.2]
upper = [0.9, 0.6]
[[boundary]]
axis = "y"
at = 0
kind = "roller"
[loads]
gravity = [0, -10]
[method]
name = "cpls"
[time]
end = 0.1
[[probe]]
kind = "section"
name = "middle"
axis = "x"
at = 0.7
[output]
frames = 4
)TOML";
  return std::get<ProblemFile<2>>(read_problem_text(text, "disk.toml", settings));
}

}  // namespace recon::mpm::test
