// The claims of the publications as data: docs/claims, carried in the program.
//
// A document lists the numbers of all its figures, tables and sections. Each of them belongs to a
// claim or to a reason why nothing is claimed there; a list in which one has neither, or in which a
// claim, study or rule is named that does not exist, is refused.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace recon::program {

// How one way of saying something is judged (docs/claims/rules.toml).
struct Rule {
  std::string name, kind;
  double lower = 0, upper = 0;  // the number that is judged lies in [lower, upper]
  bool stops = false;           // a run that stops on a finer grid keeps the rule
};

// A name for settings of a study's runs; for `methods` only, unless they are empty.
struct Variant {
  std::string name;
  std::vector<std::string> settings, methods;
};

// A number that a run of the kind "probes" shows: a quantity over time, and what is taken of it.
struct Probe {
  std::string name;
  // "displacement", "velocity" or "stress" with `component` ("x", "xy"); "front", the greatest place
  // of a particle along it; or an energy of the ledger: "kinetic", "strain", "total", "angular".
  std::string of, component;
  std::vector<double> at;  // reference place, by a linear fit around it; none: mean over the body
  int body = 0;            // counted from 1; 0: all particles
  // "end", "least", "greatest", "time of least", "time of greatest", "mean", "change" from the first
  // to the last as a part of the first, "period" between zeros, "time above" the level.
  std::string take;
  double from = 0, until = 1e300, level = 0;  // times between which
};

// Runs that claims are judged by: every method in every variant on every grid.
struct Study {
  std::string name, kind, problem, norm;
  std::string about;  // source and set-up, for the page
  std::vector<Probe> probes;
  std::vector<std::string> settings, methods;
  std::vector<Variant> variants;         // at least one, which may have no name
  std::vector<int> quick, paper, finer;  // grids, cells per unit length; finer than the source's
};

// A rule about series of numbers, each of a quantity of a method in a variant.
struct Part {
  std::string rule;
  std::vector<std::string> of, methods, variants;
  std::vector<int> grids;  // if not those of the source
  // What to compare with: the same series but for these; or a number.
  std::string than, than_variant, than_of;
  std::optional<double> to;
  double printed = 0, unit = 0;
};

struct Claim {
  std::vector<std::string> at;  // "figure 4.7", "table 4.1", "section 4.6", "abstract"
  std::string says;
  std::string study;  // or, where no run of the program can judge:
  std::vector<Part> parts;
  std::string verdict, why;
};

// Numbers at which nothing is claimed that could be measured.
struct Without {
  std::vector<std::string> at;
  std::string why;
};

struct Document {
  std::string source;
  std::vector<std::string> numbers;  // all of them, in order: figures, tables, sections
  std::vector<Without> without;
  std::vector<Study> studies;
  std::vector<Claim> claims;

  const Study& study(const std::string& name) const;
  // Where a claim stands: "figures 10, 12; section 4.2".
  static std::string place(const Claim& claim);
};

struct ClaimList {
  std::map<std::string, Rule> rules;
  std::vector<Document> documents;
};

struct ClaimText {
  std::string name, text;
};
// Those of docs/claims, the rules among them.
const std::vector<ClaimText>& claim_texts();

// Throws InvalidArgument for a list that is not complete or contradicts itself.
ClaimList read_claims(std::span<const ClaimText> texts);

}  // namespace recon::program
