#include "runs/expression.hpp"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <stdexcept>

#include "recon/core/error.hpp"

namespace recon::mpm {
namespace {

// A single '='; the operators ==, <=, >= and != have it too. The parser would assign to a variable.
bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool pair = i + 1 < text.size() && text[i + 1] == '=';
    if (pair && (text[i] == '=' || text[i] == '<' || text[i] == '>' || text[i] == '!'))
      ++i;
    else if (text[i] == '=')
      return true;
  }
  return false;
}

[[noreturn]] void fail(const std::string& text, const std::string& what) {
  throw std::invalid_argument("'" + text + "'" + what);
}

}  // namespace

struct Formula::Evaluator::Parser {
  mu::Parser parser;
  std::vector<double> at;
};

// What all evaluators of a formula have in common, and those that nobody uses now.
struct Formula::Evaluator::Shared {
  std::string text;
  std::vector<std::string> variables;
  std::map<std::string, double> constants;
  std::mutex guard;
  std::vector<std::unique_ptr<Parser>> idle;

  std::unique_ptr<Parser> make() const {
    auto made = std::make_unique<Parser>();
    made->at.assign(variables.size(), 0);
    for (std::size_t i = 0; i < variables.size(); ++i)
      made->parser.DefineVar(variables[i], &made->at[i]);
    made->parser.DefineConst("pi", std::numbers::pi);
    for (const auto& [name, value] : constants) made->parser.DefineConst(name, value);
    made->parser.SetExpr(text);
    return made;
  }
  std::unique_ptr<Parser> take() {
    {
      const std::lock_guard lock(guard);
      if (!idle.empty()) {
        auto taken = std::move(idle.back());
        idle.pop_back();
        return taken;
      }
    }
    return make();
  }
};

Formula::Evaluator::Evaluator(std::shared_ptr<Shared> shared)
    : shared_(std::move(shared)), parser_(shared_->take()) {}

Formula::Evaluator::Evaluator(Evaluator&&) noexcept = default;

Formula::Evaluator::~Evaluator() {
  if (!parser_) return;
  try {
    const std::lock_guard lock(shared_->guard);
    shared_->idle.push_back(std::move(parser_));
  } catch (const std::exception&) {  // without memory it is made again
  }
}

double Formula::Evaluator::operator()(std::span<const double> values) {
  recon::detail::require(values.size() == parser_->at.size(), "values of a formula", values.size(),
                         "must be one for each variable");
  std::copy(values.begin(), values.end(), parser_->at.begin());
  double value = 0;
  try {
    value = parser_->parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    fail(shared_->text, ": " + error.GetMsg());
  }
  if (std::isfinite(value)) return value;
  std::string where;
  for (std::size_t i = 0; i < values.size(); ++i)
    where +=
        (i ? ", " : " at ") + shared_->variables[i] + " = " + recon::detail::to_text(values[i]);
  fail(shared_->text, " is not finite" + where);
}

Formula::Formula(std::string text, std::vector<std::string> variables,
                 const std::map<std::string, double>& constants)
    : shared_(std::make_shared<Evaluator::Shared>()) {
  for (const auto& [name, value] : constants) {
    if (name == "pi" || std::find(variables.begin(), variables.end(), name) != variables.end())
      fail(name, " has a meaning in formulas already: choose another name");
    if (!std::isfinite(value)) fail(name, " must be finite");
  }
  if (assigns(text)) fail(text, ": a formula assigns nothing; == compares");
  shared_->text = std::move(text);
  shared_->variables = std::move(variables);
  shared_->constants = constants;
  try {
    auto parser = shared_->make();
    int results = 0;
    parser->parser.Eval(results);
    if (results != 1)
      fail(shared_->text, ": must be one number, and is a list of " + std::to_string(results));
    shared_->idle.push_back(std::move(parser));
  } catch (const mu::Parser::exception_type& error) {
    fail(shared_->text, ": " + error.GetMsg());
  }
}

}  // namespace recon::mpm
