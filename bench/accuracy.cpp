#include "accuracy.hpp"

#include <chrono>
#include <cstdio>

namespace recon_bench {

std::vector<Section> run_accuracy(const Context& context) {
  struct Study {
    const char* name;
    Section (*run)(const Context&);
  };
  const Study studies[] = {{"solvers", solver_study},
                           {"clouds", cloud_study},
                           {"neighbours", neighbour_study},
                           {"weights", weight_study},
                           {"orders of convergence", order_study},
                           {"float and double", precision_study},
                           {"flattened clouds", flattening_study},
                           {"Tran et al., figures 4 and 5", tran_field_study},
                           {"Tran et al., figure 6", tran_cost_study},
                           {"values outside the data", outside_study}};
  std::vector<Section> sections;
  for (const Study& study : studies) {
    std::fprintf(stderr, "accuracy: %s ...", study.name);
    const auto begin = std::chrono::steady_clock::now();
    sections.push_back(study.run(context));
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    std::fprintf(stderr, " %.1f s\n", seconds.count());
  }
  return sections;
}

}  // namespace recon_bench
