#include "mpm/expression.hpp"

#include <muParser.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace recon::mpm {

struct Expression::Parser {
  mu::Parser parser;
  Variables at{};
  std::string formula;
};

Expression::Expression(const std::string& formula, const std::map<std::string, double>& constants)
    : constant_(0), parser_(std::make_shared<Parser>()) {
  constexpr const char* names[] = {"X", "Y", "Z", "x", "y", "z", "t"};
  parser_->formula = formula;
  try {
    for (std::size_t i = 0; i < std::size(names); ++i)
      parser_->parser.DefineVar(names[i], &parser_->at[i]);
    parser_->parser.DefineConst("pi", std::numbers::pi);
    for (const auto& [name, value] : constants) parser_->parser.DefineConst(name, value);
    parser_->parser.SetExpr(formula);
    parser_->parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    throw std::invalid_argument("'" + formula + "': " + error.GetMsg());
  }
}

double Expression::operator()(const Variables& at) const {
  if (!parser_) return constant_;
  parser_->at = at;
  double value = 0;
  try {
    value = parser_->parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    throw std::invalid_argument("'" + parser_->formula + "': " + error.GetMsg());
  }
  if (!std::isfinite(value))
    throw std::invalid_argument("'" + parser_->formula +
                                "' is not finite at t = " + std::to_string(at[6]));
  return value;
}

}  // namespace recon::mpm
