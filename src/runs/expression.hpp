// Numbers that may vary: a constant, or a formula of position and time.
//
// A formula is one number (lists with commas are not) of variables and constants, and assigns
// nothing. What a formula remembers while it is evaluated belongs to the evaluation: any number of
// threads may ask the same formula, or copies of it, and get the same bits.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace recon::mpm {

// A formula of the variables with these names, and of pi.
class Formula {
 public:
  // Throws std::invalid_argument that says what is wrong with the formula, or with a constant: a
  // name that formulas cannot use or that is taken, a value that is not finite.
  Formula(std::string text, std::vector<std::string> variables,
          const std::map<std::string, double>& constants);

  // A parser borrowed from the formula, for many values in one thread; it is returned at the end.
  class Evaluator {
   public:
    ~Evaluator();
    Evaluator(Evaluator&&) noexcept;
    Evaluator& operator=(Evaluator&&) = delete;
    // Evaluates for these variables, in the order of their names. Throws std::invalid_argument for
    // a result that is not finite.
    double operator()(std::span<const double> values);

   private:
    friend class Formula;
    struct Parser;
    struct Shared;
    explicit Evaluator(std::shared_ptr<Shared> shared);
    std::shared_ptr<Shared> shared_;
    std::unique_ptr<Parser> parser_;
  };
  Evaluator evaluator() const { return Evaluator(shared_); }
  double operator()(std::span<const double> values) const { return evaluator()(values); }

 private:
  std::shared_ptr<Evaluator::Shared> shared_;
};

// A number of a problem: constant, or a formula of X, Y, Z, x, y, z and t.
class Expression {
 public:
  // X, Y, Z, x, y, z and t, in this order.
  using Variables = std::array<double, 7>;
  static std::vector<std::string> variable_names() { return {"X", "Y", "Z", "x", "y", "z", "t"}; }

  Expression(double constant = 0) : constant_(constant) {}  // NOLINT: numbers are expressions
  // Throws as the constructor of Formula does.
  Expression(const std::string& formula, const std::map<std::string, double>& constants)
      : formula_(std::make_shared<Formula>(formula, variable_names(), constants)) {}

  bool is_constant() const { return !formula_; }
  // The value; may be called from any number of threads.
  double operator()(const Variables& at) const { return formula_ ? (*formula_)(at) : constant_; }

  // Evaluates many values in one thread.
  class Evaluator {
   public:
    explicit Evaluator(const Expression& of) : constant_(of.constant_) {
      if (of.formula_) formula_.emplace(of.formula_->evaluator());
    }
    double operator()(const Variables& at) { return formula_ ? (*formula_)(at) : constant_; }

   private:
    double constant_;
    std::optional<Formula::Evaluator> formula_;
  };
  Evaluator evaluator() const { return Evaluator(*this); }

 private:
  double constant_ = 0;
  std::shared_ptr<const Formula> formula_;
};

}  // namespace recon::mpm
