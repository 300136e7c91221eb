// What the parts of `recon-mpm verify` share.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "recon/io/picture.hpp"
#include "recon/runs/read_problem.hpp"

namespace recon::program {

struct VerifyOptions {
  bool full = false, quiet = false;
  std::string out, only;
};

// A row of the table of all claims.
struct Verdict {
  std::string figure, statement, verdict;
};

// "holds" where all parts of a statement do, "holds partly" where some do, else "does
// not reproduce".
std::string verdict_of(int kept, int all);

// An example problem with settings.
mpm::AnyProblem load(const std::string& name, std::vector<std::string> settings,
                     std::span<const std::string> more = {});

// Draws, unless there is no folder or no gnuplot; the Markdown of the picture.
std::string picture(const VerifyOptions& options, const std::string& figure, const LinePlot& plot);
std::string picture(const VerifyOptions& options, const std::string& figure, const HeatMap& map);

// Of the report, in the folder options.out.
inline constexpr const char* picture_folder = "verification";

}  // namespace recon::program
