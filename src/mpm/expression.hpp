// Numbers that may vary: a constant, or a formula of position and time.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>

namespace recon::mpm {

class Expression {
 public:
  // X, Y, Z, x, y, z and t, in this order.
  using Variables = std::array<double, 7>;

  Expression(double constant = 0) : constant_(constant) {}  // NOLINT: numbers are expressions
  // Throws std::invalid_argument that says what is wrong with the formula.
  Expression(const std::string& formula, const std::map<std::string, double>& constants);

  bool is_constant() const { return !parser_; }
  // Not for several threads at once. Throws std::invalid_argument for a result that is not finite.
  double operator()(const Variables& at) const;

 private:
  struct Parser;
  double constant_;
  std::shared_ptr<Parser> parser_;
};

}  // namespace recon::mpm
