#include "summary.hpp"

namespace recon_bench {

Summary::Summary()
    : table_("summary", {"workload", "quantity", "recon", "reference", "ratio", "goal", "met"}) {}

void Summary::add(const std::string& workload, const std::string& quantity, double recon,
                  double reference, double ratio, const std::string& goal, bool met) {
  ++aims_;
  met_ += met;
  table_.add({workload, quantity, number(recon), number(reference), number(ratio), goal,
              met ? "yes" : "no"});
}

// A ratio that is not a number meets nothing.
void Summary::at_least(const std::string& workload, const std::string& quantity, double recon,
                       double reference, double ratio, double goal) {
  add(workload, quantity, recon, reference, ratio, ">= " + number(goal), ratio >= goal);
}

void Summary::at_most(const std::string& workload, const std::string& quantity, double recon,
                      double reference, double ratio, double goal) {
  add(workload, quantity, recon, reference, ratio, "<= " + number(goal), ratio <= goal);
}

void Summary::note(const std::string& workload, const std::string& quantity, double recon,
                   double reference, double ratio) {
  table_.add({workload, quantity, number(recon), number(reference), number(ratio), "", "-"});
}

}  // namespace recon_bench
