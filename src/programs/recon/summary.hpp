// What a run did, for the reader of the terminal.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "fit_choice.hpp"
#include "mapping.hpp"

namespace recon::program {

// One line: a name in a column of its own, and a text.
void print_line(std::string_view name, std::string_view text);

// "imls, degree 1, cubic weight (radial)".
std::string describe_method(const Method& method, const FitChoice& choice);

// Lines about full, reduced and missing fits, the neighbours, the conditioning and the limit.
void print_fit(const Mapped& mapped, const FitChoice& choice);
// `values`: how many there are, of which `limited` were limited.
void print_fit(const FitSummary& summary, const LimitCount& limited, std::size_t values,
               const FitChoice& choice);
// Least and greatest of a component; NaN where no target has a value.
struct FieldRange {
  double least, greatest;
  std::size_t missing = 0;  // targets without a value
};
FieldRange range_of(const NamedField& field, int component);
// The ranges of the fields.
void print_fields(const FieldSet& fields);
// Those that `range` gives for each component, of so many targets.
void print_fields(const FieldSet& fields,
                  const std::function<FieldRange(const NamedField&, int)>& range,
                  std::size_t targets);
// What was noticed when the file was read.
void print_remarks(const ParticleTable& table);

}  // namespace recon::program
