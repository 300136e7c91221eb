// What the publications say about convergence and conservation, as studies that can be run.
#pragma once

#include <string>
#include <vector>

#include "recon/studies/convergence.hpp"

namespace recon::program {

// An order of convergence that the statement implies: slope of log(error) over log(h),
// fitted to all grids, at least (or at most) this. A run that fails has no order: it
// satisfies "at most" only.
struct Expectation {
  std::string method, field;
  bool at_least = true;
  double order = 0;
};

struct Claim {
  std::string figure, statement, problem;
  std::vector<std::string> settings;
  std::vector<std::string> methods;
  std::vector<int> cells, full_cells;  // of the short and of the full verification
  std::string norm;
  double time;  // part of the end at which the statement is made
  std::vector<Expectation> expected;
};

// A run whose momentum and energy are shown over time.
struct Account {
  std::string figure, statement, problem;
  std::vector<std::string> settings;
  std::vector<std::string> methods;
};

// Maps of what the particles carry at some times (parts of the end), one panel for each method and
// time. Quantity: speed, or the size of an error: displacement, velocity, stress.
struct Snapshot {
  std::string figure, statement, problem;
  std::vector<std::string> settings;
  std::vector<std::string> methods;
  std::vector<double> times;
  std::string quantity;
};

std::vector<Claim> claims();
std::vector<Account> accounts();
std::vector<Snapshot> snapshots();

}  // namespace recon::program
