#include "claim_list.hpp"

#include <toml++/toml.h>
#include <algorithm>
#include <limits>
#include <set>

#include "recon/core/error.hpp"

namespace recon::program {
namespace {

using Words = std::vector<std::string>;

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
  recon::detail::throw_invalid("list of claims", where, what);
}

bool has(const Words& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// One table of a file. Every key must be asked for: a misspelt one is an error.
class Entry {
 public:
  Entry(const std::string& where, const toml::table& table) : where_(where), table_(table) {}
  ~Entry() noexcept(false) {
    if (std::uncaught_exceptions() > 0) return;
    for (const auto& [key, node] : table_) {
      (void)node;
      if (!asked_.contains(std::string(key.str())))
        refuse(where_, "has an unknown key " + std::string(key.str()));
    }
  }

  std::string text(const char* key, bool needed = false) {
    return value<std::string>(key, needed).value_or("");
  }
  std::optional<double> number(const char* key) { return value<double>(key, false); }
  Words words(const char* key) { return list<std::string>(key); }
  std::vector<int> whole_numbers(const char* key) { return list<int>(key); }
  std::vector<double> numbers(const char* key) { return list<double>(key); }
  bool holds(const char* key) { return value<bool>(key, false).value_or(false); }
  bool knows(const char* key) const { return table_.contains(key); }

  template <class Use>
  void each(const char* key, Use use) {
    asked_.insert(key);
    const auto* array = table_[key].as_array();
    if (!array) return;
    for (const auto& node : *array) {
      if (!node.is_table()) refuse(where_, std::string(key) + " must be tables");
      use(*node.as_table());
    }
  }

 private:
  template <class T>
  std::optional<T> value(const char* key, bool needed) {
    asked_.insert(key);
    const auto found = table_[key].value<T>();
    if (!found && (needed || table_.contains(key))) refuse(where_, std::string("needs ") + key);
    return found;
  }
  template <class T>
  std::vector<T> list(const char* key) {
    asked_.insert(key);
    std::vector<T> all;
    if (!table_.contains(key)) return all;
    const auto* array = table_[key].as_array();
    if (!array) refuse(where_, std::string(key) + " must be a list");
    for (const auto& node : *array) {
      const auto found = node.value<T>();
      if (!found) refuse(where_, std::string(key) + " has an element of a wrong type");
      all.push_back(*found);
    }
    return all;
  }

  std::string where_;
  const toml::table& table_;
  std::set<std::string> asked_;
};

Rule read_rule(const toml::table& table) {
  Entry entry("a rule", table);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Rule rule{entry.text("name", true), entry.text("kind", true)};
  rule.lower = entry.number("lower").value_or(-infinity);
  rule.upper = entry.number("upper").value_or(infinity);
  rule.stops = entry.holds("stops");
  const Words kinds{"order", "difference", "value", "ratio", "printed", "falls", "breaks"};
  if (!has(kinds, rule.kind)) refuse(rule.name, "has an unknown kind");
  if (!(rule.lower <= rule.upper)) refuse(rule.name, "has no number that keeps it");
  return rule;
}

Probe read_probe(const std::string& study, const toml::table& table) {
  Entry entry("a probe of " + study, table);
  Probe probe;
  probe.name = entry.text("name", true);
  probe.of = entry.text("of", true);
  probe.component = entry.text("component");
  probe.at = entry.numbers("at");
  probe.body = static_cast<int>(entry.number("body").value_or(0));
  probe.take = entry.text("take", true);
  probe.from = entry.number("from").value_or(probe.from);
  probe.until = entry.number("until").value_or(probe.until);
  probe.level = entry.number("level").value_or(probe.level);
  const Words quantities{"displacement", "velocity", "stress", "front",
                         "kinetic",      "strain",   "total",  "angular"};
  const Words takes{"end",  "least",  "greatest", "time of least", "time of greatest",
                    "mean", "change", "period",   "time above"};
  if (!has(quantities, probe.of)) refuse(probe.name, "is of the unknown quantity " + probe.of);
  if (!has(takes, probe.take)) refuse(probe.name, "takes the unknown number " + probe.take);
  return probe;
}

Study read_study(const toml::table& table) {
  Study study;
  Entry entry("a study", table);
  study.name = entry.text("name", true);
  study.kind = entry.text("kind", true);
  study.problem = entry.text("problem");
  study.norm = entry.text("norm");
  study.about = entry.text("about");
  study.settings = entry.words("set");
  study.methods = entry.words("methods");
  study.paper = entry.whole_numbers("paper");
  study.finer = entry.whole_numbers("finer");
  study.quick = entry.whole_numbers("quick");
  if (!entry.knows("quick")) study.quick = study.paper;
  entry.each("variants", [&](const toml::table& each) {
    Entry variant("a variant of " + study.name, each);
    study.variants.push_back(
        {variant.text("name", true), variant.words("set"), variant.words("methods")});
  });
  entry.each("probes", [&](const toml::table& each) {
    study.probes.push_back(read_probe(study.name, each));
  });
  if (study.variants.empty()) study.variants.push_back({});
  if (study.methods.empty() || study.paper.empty()) refuse(study.name, "needs methods and grids");
  return study;
}

Part read_part(const std::string& where, const toml::table& table) {
  Entry entry(where, table);
  Part part;
  part.rule = entry.text("rule", true);
  part.of = entry.words("of");
  part.methods = entry.words("methods");
  part.variants = entry.words("variants");
  part.grids = entry.whole_numbers("grids");
  part.than = entry.text("than");
  part.than_variant = entry.text("than_variant");
  part.than_of = entry.text("than_of");
  part.to = entry.number("to");
  part.printed = entry.number("printed").value_or(0);
  part.unit = entry.number("unit").value_or(0);
  return part;
}

Claim read_claim(const toml::table& table) {
  Entry entry("a claim", table);
  Claim claim;
  claim.at = entry.words("at");
  claim.says = entry.text("says", true);
  claim.study = entry.text("study");
  claim.verdict = entry.text("verdict");
  claim.why = entry.text("why");
  entry.each("parts",
             [&](const toml::table& each) { claim.parts.push_back(read_part(claim.says, each)); });
  return claim;
}

// All names that a part uses exist.
void check(const Claim& claim, Part& part, const Study& study,
           const std::map<std::string, Rule>& rules) {
  const auto rule = rules.find(part.rule);
  if (rule == rules.end()) refuse(claim.says, "names the unknown rule " + part.rule);
  if (part.of.empty()) refuse(claim.says, "has a part about nothing");
  if (part.methods.empty()) part.methods = study.methods;
  Words variants;
  for (const Variant& variant : study.variants) variants.push_back(variant.name);
  if (part.variants.empty()) part.variants = variants;
  for (const std::string& method : part.methods)
    if (!has(study.methods, method)) refuse(claim.says, "names the unknown method " + method);
  for (const std::string& variant : part.variants)
    if (!has(variants, variant)) refuse(claim.says, "names the unknown variant " + variant);
  if (!part.than.empty() && !has(study.methods, part.than))
    refuse(claim.says, "names the unknown method " + part.than);
  if (!part.than_variant.empty() && !has(variants, part.than_variant))
    refuse(claim.says, "names the unknown variant " + part.than_variant);
  const std::string& kind = rule->second.kind;
  const bool compares = !part.than.empty() || !part.than_variant.empty() || !part.than_of.empty();
  if (kind == "difference" && !compares) refuse(claim.says, "compares with nothing");
  if (kind == "ratio" && compares == part.to.has_value())
    refuse(claim.says, "must compare either with a series or with a number");
  if (kind == "printed" && !(part.unit > 0)) refuse(claim.says, "needs the unit of the last digit");
  for (const int grid : part.grids)
    if (std::find(study.paper.begin(), study.paper.end(), grid) == study.paper.end() &&
        std::find(study.finer.begin(), study.finer.end(), grid) == study.finer.end())
      refuse(claim.says, "names a grid that is not run");
}

void check(Document& document, const std::map<std::string, Rule>& rules) {
  Words with, without;
  for (const Without& each : document.without) {
    without.insert(without.end(), each.at.begin(), each.at.end());
    if (each.why.empty()) refuse(document.source, "leaves out a number without a reason");
  }
  for (Claim& claim : document.claims) {
    with.insert(with.end(), claim.at.begin(), claim.at.end());
    if (claim.at.empty()) refuse(claim.says, "stands nowhere in its source");
    if (claim.study.empty()) {
      if (!has({"holds", "holds partly", "does not reproduce", "cannot be judged"},
               claim.verdict) ||
          claim.why.empty() || !claim.parts.empty())
        refuse(claim.says, "needs a study, or a verdict and a reason");
      continue;
    }
    if (!claim.verdict.empty() || claim.parts.empty())
      refuse(claim.says, "needs parts that can be judged, and no verdict before");
    for (Part& part : claim.parts) check(claim, part, document.study(claim.study), rules);
  }
  for (const std::string& number : document.numbers)
    if (has(with, number) == has(without, number))
      refuse(document.source + ", " + number, "needs either a claim or a reason why there is none");
  with.insert(with.end(), without.begin(), without.end());
  for (const std::string& number : with)
    if (!has(document.numbers, number))
      refuse(document.source + ", " + number, "is not among the numbers of the source");
}

Document read_document(const toml::table& table, const std::map<std::string, Rule>& rules) {
  Document document;
  {
    Entry entry("a source", table);
    document.source = entry.text("source", true);
    for (const std::string& number : entry.words("figures"))
      document.numbers.push_back("figure " + number);
    for (const std::string& number : entry.words("tables"))
      document.numbers.push_back("table " + number);
    for (const std::string& number : entry.words("sections"))
      document.numbers.push_back(
          std::isdigit(static_cast<unsigned char>(number.front())) ? "section " + number : number);
    entry.each("without", [&](const toml::table& each) {
      Entry without("a reason", each);
      document.without.push_back({without.words("at"), without.text("why", true)});
    });
    entry.each("study",
               [&](const toml::table& each) { document.studies.push_back(read_study(each)); });
    entry.each("claim",
               [&](const toml::table& each) { document.claims.push_back(read_claim(each)); });
  }
  check(document, rules);
  return document;
}

}  // namespace

const Study& Document::study(const std::string& name) const {
  for (const Study& study : studies)
    if (study.name == name) return study;
  refuse(source, "has no study " + name);
}

std::string Document::place(const Claim& claim) {
  std::string text;
  for (std::size_t k = 0; k < claim.at.size();) {
    const std::size_t blank = claim.at[k].find(' ');
    const std::string kind = claim.at[k].substr(0, blank);
    std::string numbers;
    std::size_t count = 0;
    for (; k < claim.at.size() && claim.at[k].substr(0, claim.at[k].find(' ')) == kind;
         ++k, ++count)
      if (blank != std::string::npos)
        numbers += (numbers.empty() ? " " : ", ") + claim.at[k].substr(blank + 1);
    text += (text.empty() ? "" : "; ") + kind + (count > 1 ? "s" : "") + numbers;
  }
  return text;
}

ClaimList read_claims(std::span<const ClaimText> texts) {
  ClaimList list;
  std::vector<toml::table> documents;
  for (const ClaimText& each : texts) {
    toml::table table;
    try {
      table = toml::parse(each.text);
    } catch (const toml::parse_error& error) {
      refuse(each.name, std::string(error.description()));
    }
    if (!table.contains("rule")) {
      documents.push_back(std::move(table));
      continue;
    }
    Entry entry("the rules", table);
    entry.each("rule", [&](const toml::table& rule) {
      const Rule read = read_rule(rule);
      if (!list.rules.emplace(read.name, read).second) refuse(read.name, "stands there twice");
    });
  }
  for (const toml::table& table : documents)
    list.documents.push_back(read_document(table, list.rules));
  std::set<std::string> names;
  for (const Document& document : list.documents)
    for (const Study& study : document.studies)
      if (!names.insert(study.name).second) refuse(study.name, "names two studies");
  return list;
}

}  // namespace recon::program
