#include "summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "programs/common/text.hpp"

namespace recon::program {

FieldRange range_of(const NamedField& field, int component) {
  FieldRange range{std::nan(""), std::nan("")};
  const FieldView<double> values = field.view();
  for (std::size_t i = 0; i < field.size(); ++i) {
    const double value = values(i, component);
    range.least = std::fmin(range.least, value);
    range.greatest = std::fmax(range.greatest, value);
    range.missing += std::isnan(value) ? 1 : 0;
  }
  return range;
}

namespace {

std::string describe_range(const FieldRange& found, std::size_t targets) {
  if (found.missing == targets) return "no value anywhere";
  return range(found.least, found.greatest) +
         (found.missing > 0 ? " (nan at " + count(found.missing) + ")" : "");
}

}  // namespace

void print_line(std::string_view name, std::string_view text) {
  std::printf("%-13.*s %.*s\n", static_cast<int>(name.size()), name.data(),
              static_cast<int>(text.size()), text.data());
}

std::string describe_method(const Method& method, const FitChoice& choice) {
  return method.name + ", degree " + std::to_string(method.degree) + ", weight " + choice.weight +
         " (" + choice.form + ")" + (choice.weight_by.empty() ? "" : ", times " + choice.weight_by);
}

void print_fit(const Mapped& mapped, const FitChoice& choice) {
  print_fit(mapped.reports.summary(), mapped.limited, mapped.values, choice);
}

void print_fit(const FitSummary& summary, const LimitCount& limited, std::size_t values,
               const FitChoice& choice) {
  const auto share_of = [](std::size_t part, std::size_t all) {
    const double percent = 100.0 * static_cast<double>(part) / static_cast<double>(all);
    const bool nearly_all = part < all && percent > 99.9;
    return count(part) + " (" + (nearly_all ? "> 99.9" : number(percent, 3)) + " %)";
  };
  const auto share = [&](std::size_t part) { return share_of(part, summary.targets); };
  std::string text = "full degree at " + share(summary.full);
  if (summary.reduced > 0) text += ", reduced at " + share(summary.reduced);
  if (summary.nearest > 0) text += ", nearest particle at " + share(summary.nearest);
  if (summary.no_support > 0)
    text += ", no support at " + share(summary.no_support) + ": " + choice.unsupported;
  if (summary.too_far > 0)
    text += ", too far from all particles at " + share(summary.too_far) + ": " +
            (choice.unsupported == "nearest" ? "nan" : choice.unsupported);
  print_line("fit", text);
  if (summary.handed_over > 0)
    print_line("",
               "handed over to Gram-Schmidt, being ill-conditioned: " + share(summary.handed_over));
  print_line("neighbours", "least " + count(summary.fewest_neighbours) + ", mean " +
                               number(summary.mean_neighbours, 3) + ", most " +
                               count(summary.most_neighbours));
  if (summary.no_support + summary.too_far + summary.nearest < summary.targets)
    print_line("conditioning", "smallest pivot " + number(summary.smallest_pivot, 3) +
                                   ", errors in the data amplified at most " +
                                   number(summary.largest_amplification, 3) + " times");
  if (choice.limit == "none")
    print_line("limited", "nothing (--limit none)");
  else if (values > 0)
    print_line("limited", share_of(limited.values, values) + " of the values, at " +
                              counted(limited.targets, "target") + " (--limit " + choice.limit +
                              ")");
}

void print_fields(const FieldSet& fields) {
  print_fields(
      fields, [](const NamedField& field, int component) { return range_of(field, component); },
      fields.begin() == fields.end() ? 0 : fields.begin()->size());
}

void print_fields(const FieldSet& fields,
                  const std::function<FieldRange(const NamedField&, int)>& range,
                  std::size_t targets) {
  std::size_t width = 0;
  for (const NamedField& field : fields) width = std::max(width, field.name.size() + 2);
  std::string_view heading = "fields";
  for (const NamedField& field : fields) {
    if (field.name == report_names().front()) break;
    for (int c = 0; c < field.components; ++c) {
      std::string name = field.name + component_suffix(field, c, field.components);
      name.resize(std::max(name.size(), width), ' ');
      print_line(heading, name + "  " + describe_range(range(field, c), targets));
      heading = "";
    }
  }
}

void print_remarks(const ParticleTable& table) {
  for (const std::string& remark : table.remarks) print_line("note", remark);
}

}  // namespace recon::program
