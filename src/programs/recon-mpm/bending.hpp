// The conclusions of Andersen, Andersen 2007, "Material-point method analysis of bending in elastic
// beams", measured: a vibrating bar, a cantilever, a box that falls on a beam.
#pragma once

#include <span>

#include "programs/common/progress.hpp"
#include "verification.hpp"

namespace recon::program {

struct Findings {
  std::vector<Verdict> verdicts;
  std::string text;  // Markdown
};

struct BendingPart {
  std::string figure;
  std::size_t runs = 0;  // by which measure() advances the progress
  Findings (*measure)(const VerifyOptions& options, Progress& progress);
};

std::span<const BendingPart> bending_parts();

}  // namespace recon::program
