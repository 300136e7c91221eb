// The aims: one line for each, what was measured, what it is compared with, and whether it is met.
#pragma once

#include <string>

#include "table.hpp"

namespace recon_bench {

class Summary {
 public:
  Summary();

  // `recon` and `reference` in the unit that `quantity` names; `ratio` is what the goal is about.
  void at_least(const std::string& workload, const std::string& quantity, double recon,
                double reference, double ratio, double goal);
  void at_most(const std::string& workload, const std::string& quantity, double recon,
               double reference, double ratio, double goal);
  // Reported without a goal.
  void note(const std::string& workload, const std::string& quantity, double recon,
            double reference, double ratio);

  const Table& table() const { return table_; }  // workload,quantity,recon,reference,ratio,goal,met
  int aims() const { return aims_; }
  int met() const { return met_; }

 private:
  void add(const std::string& workload, const std::string& quantity, double recon, double reference,
           double ratio, const std::string& goal, bool met);

  Table table_;
  int aims_ = 0, met_ = 0;
};

}  // namespace recon_bench
