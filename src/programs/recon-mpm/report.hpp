// The verdicts as Markdown: docs/verification.md and a part of docs/papers.md.
#pragma once

#include <map>
#include <string>

#include "judge.hpp"

namespace recon::program {

// A claim and what the runs say about it.
struct Judged {
  const Document* document;
  const Claim* claim;
  std::vector<Judgement> judgements;  // on the grids of the verdict
  Verdict verdict = Verdict::unknown;
  std::string why;  // it cannot be judged
  // What the verdict would be on the grids of the quick verification, with the finer ones, and at
  // other times; empty: there is nothing to say.
  std::string quick, finer, quarter, three_eighths;
};

struct Report {
  const ClaimList& list;
  std::vector<Judged> claims;
  std::map<std::string, StudyResults> results;  // by the name of the study
  bool full = false;
  std::string only = {};    // what of the list was asked for; empty: all
  std::string folder = {};  // of pictures, beside the page; empty: none
};

std::string verification_page(const Report& report);
// A page with what stands between its marks and the next <!-- end --> written anew:
//   <!-- claims -->                     the claims that no run of the driver judges
//   <!-- claims: SOURCE -->             those of one source, with their verdicts
//   <!-- study: NAME; grid: 8 -->       the numbers of a study, on all grids or one
//   <!-- study: NAME; of: QUANTITY -->  a quantity, with a column for each grid
// Throws InvalidArgument for a mark that names what there is not.
std::string filled_page(const std::string& page, const Report& report);
// One line for each number and claim; nothing where `only` names none.
std::string listing(const ClaimList& list, const std::string& only);
// Whether --only names this claim: by its study, or, if there is no study of that name, by a text in
// its place or words.
bool wanted(const ClaimList& list, const Document& document, const Claim& claim,
            const std::string& only);
std::string picture_name(const Study& study, const RunKey& key);

}  // namespace recon::program
