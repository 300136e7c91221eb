#include "where.hpp"

#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>

#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/core/names.hpp"

namespace recon::program {

namespace {

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// The condition as muParser reads it: columns are called c0, c1, ..., and the words for `and`, `or`
// and `not` are signs. What muParser would accept and misunderstand is refused here.
class Translation {
 public:
  Translation(const std::string& text, const ParticleTable& table, const mu::Parser& parser)
      : text_(text), table_(table) {
    for (const auto& [name, function] : parser.GetFunDef()) functions_.push_back(name);
    while (at_ < text_.size()) translate_next();
    if (parentheses_.size() > 1) fail(parentheses_.back().place, "the parenthesis is not closed");
  }

  const std::string& formula() const { return formula_; }
  const std::vector<std::string>& columns() const { return columns_; }

  [[noreturn]] void fail(std::size_t place, const std::string& what) const {
    const std::string where =
        place < text_.size() ? "at position " + std::to_string(place + 1) + ": " : "";
    fail_usage("--where '" + text_ + "': " + where + what);
  }
  // As muParser counts, in its formula.
  [[noreturn]] void fail_in_formula(std::size_t position) const {
    const std::size_t place = position < from_.size() ? from_[position] : text_.size();
    if (text_.find_first_not_of(' ', place) >= text_.size())
      fail(place, "the condition ends too early");
    fail(place, "'" + text_.substr(place) + "' cannot be understood");
  }

 private:
  struct Parenthesis {
    std::size_t place;
    bool of_function, compared;  // a comparison since the last and, or, not or comma
  };

  bool next_is(std::string_view sign) const { return text_.compare(at_, sign.size(), sign) == 0; }

  void put(std::string_view formula, std::size_t letters) {
    formula_ += formula;
    from_.resize(formula_.size(), at_);
    at_ += letters;
  }

  void translate_next() {
    const char c = text_[at_];
    if (is_letter(c)) return translate_word();
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1])))
      return translate_number();
    if (c == '`') return translate_quoted();
    if (c == '(') return open(false);
    if (c == ')') return close();
    for (const char* sign : {"==", "!=", "<=", ">=", "<", ">"})
      if (next_is(sign)) return compare(sign);
    for (const char* sign : {"&&", "||", "!"})
      if (next_is(sign)) return join(sign, std::string_view(sign).size());
    if (c == '=') fail(at_, "'=' assigns; the sign of equality is ==");
    if (c == ',' && !parentheses_.back().of_function)
      fail(at_, "one condition is needed; join several with 'and' or 'or'");
    if (c == '?' || c == ':' || c == ',') return join(std::string(1, c), 1);
    if (std::string_view(" \t\n+-*/^").find(c) == std::string_view::npos) fail_sign(c);
    put(std::string(1, c == '\t' || c == '\n' ? ' ' : c), 1);
  }

  [[noreturn]] void fail_sign(char c) const {
    if (c == '\'' || c == '"') fail(at_, "texts cannot be compared, only numbers");
    if (c == '&' || c == '|') fail(at_, std::string("write '") + (c == '&' ? "and" : "or") + "'");
    fail(at_, std::string("'") + c +
                  "' has no meaning here; names with such signs stand in `backticks`");
  }

  void compare(std::string_view sign) {
    if (parentheses_.back().compared)
      fail(at_, "comparisons in a row do not mean what they seem to; write 'a < b and b < c'");
    parentheses_.back().compared = true;
    put(sign, sign.size());
  }

  void join(std::string_view sign, std::size_t letters) {
    parentheses_.back().compared = false;
    put(sign, letters);
  }

  void open(bool of_function) {
    parentheses_.push_back({at_, of_function, false});
    put("(", 1);
  }
  void close() {
    if (parentheses_.size() == 1) fail(at_, "there is no '(' to this ')'");
    parentheses_.pop_back();
    put(")", 1);
  }

  void translate_number() {
    double value = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc()) fail(at_, "the number does not fit a double");
    put(std::string_view(begin, end), static_cast<std::size_t>(end - begin));
  }

  void translate_word() {
    std::size_t end = at_;
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    const std::string word = text_.substr(at_, end - at_);
    std::string lower = word;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (lower == "and") return join("&&", word.size());
    if (lower == "or") return join("||", word.size());
    if (lower == "not") return join("!", word.size());
    const std::size_t next = text_.find_first_not_of(' ', end);
    if (next < text_.size() && text_[next] == '(') return translate_function(word, next);
    if (end < text_.size() && text_[end] == '[') {  // c_stress[1]
      std::size_t close = end + 1;
      while (close < text_.size() && is_digit(text_[close])) ++close;
      if (close > end + 1 && close < text_.size() && text_[close] == ']')
        return put_column(text_.substr(at_, close + 1 - at_), close + 1 - at_);
    }
    put_column(word, word.size());
  }

  void translate_function(const std::string& word, std::size_t parenthesis) {
    if (std::find(functions_.begin(), functions_.end(), word) == functions_.end())
      fail(at_, "unknown function '" + word + "'; " + suggest(word, functions_));
    put(word, parenthesis - at_);
    open(true);
  }

  void translate_quoted() {
    const std::size_t end = text_.find('`', at_ + 1);
    if (end == std::string::npos) fail(at_, "the backtick is not closed");
    put_column(text_.substr(at_ + 1, end - at_ - 1), end + 1 - at_);
  }

  void put_column(const std::string& name, std::size_t letters) {
    const std::vector<std::string> texts = table_.text_columns();
    const bool known =
        table_.has(name) || std::find(texts.begin(), texts.end(), name) != texts.end();
    if (!known && name == "pi" && text_[at_] != '`') return put("c_pi", letters);
    if (!known) fail(at_, "unknown column '" + name + "'; " + suggest(name, table_.names()));
    auto column = std::find(columns_.begin(), columns_.end(), name);
    if (column == columns_.end()) column = columns_.insert(column, name);
    put("c" + std::to_string(column - columns_.begin()), letters);
  }

  const std::string& text_;
  const ParticleTable& table_;
  std::vector<std::string> functions_;
  std::size_t at_ = 0;
  std::string formula_;
  std::vector<std::size_t> from_;  // for each letter of the formula its place in the text
  std::vector<std::string> columns_;
  std::vector<Parenthesis> parentheses_{{0, false, false}};
};

double negation(double value) {
  return value == 0 ? 1 : 0;
}

std::vector<bool> evaluate(mu::Parser& parser, const Translation& translation,
                           const std::string& condition, ParticleTable& table) {
  std::vector<const std::vector<double>*> columns;
  with_exit_code(wrong_input, [&] {
    table.leave_out_missing(translation.columns());
    for (const std::string& name : translation.columns()) columns.push_back(&table.column(name));
  });
  std::vector<double> row(columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c)
    parser.DefineVar("c" + std::to_string(c), &row[c]);
  parser.SetExpr(translation.formula());
  std::vector<bool> holds(table.size());
  for (std::size_t i = 0; i < holds.size(); ++i) {
    for (std::size_t c = 0; c < columns.size(); ++c) row[c] = (*columns[c])[i];
    const double value = parser.Eval();
    if (value != 0 && value != 1)
      fail_input("--where '" + condition + "': is neither true nor false but " + number(value) +
                 " at " + table.describe_row(i) + "; a comparison is needed, such as z > 1");
    holds[i] = value == 1;
  }
  return holds;
}

}  // namespace

std::vector<bool> rows_where(const std::string& condition, ParticleTable& table) {
  constexpr int above_and_below_comparisons = 3;
  static_assert(above_and_below_comparisons > mu::prLAND &&
                above_and_below_comparisons < mu::prCMP);
  if (condition.find_first_not_of(" \t\n") == std::string::npos)
    fail_usage("--where: a condition is needed, as in 'type == 2 and z > 1'");
  mu::Parser parser;
  parser.ResetLocale();
  parser.DefineInfixOprt("!", negation, above_and_below_comparisons);
  parser.DefineConst("c_pi", std::numbers::pi);
  const Translation translation(condition, table, parser);
  try {
    return evaluate(parser, translation, condition, table);
  } catch (const mu::Parser::exception_type& error) {
    const auto position = error.GetPos();
    translation.fail_in_formula(static_cast<std::size_t>(position));
  }
}

}  // namespace recon::program
