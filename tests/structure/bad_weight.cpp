// Must not compile: weights that are none, one at a time.
#ifdef IN_AN_EVALUATOR
#include "recon/shape/shape_function.hpp"
#else
#include "recon/shape/options.hpp"
#endif

struct Parabola {
#ifdef WRONG_ARGUMENT
  double operator()(const char* q) const {
    return 1;
  }
#else
  double operator()(double q) const {
    return (1 - q) * (1 - q);
  }
#endif
#ifdef DERIVATIVE_IS_NOT_CONST
  double derivative(double q) {
    return 2 * q - 2;
  }
#elif defined(WRONG_RESULT)
  void derivative(double) const {}
#elif !defined(NO_DERIVATIVE) && !defined(IN_AN_EVALUATOR)
  double derivative(double q) const {
    return 2 * q - 2;
  }
#endif
};

#ifdef IN_AN_EVALUATOR
recon::ShapeEvaluator<recon::Monomials<2, 1>, Parabola> shapes(Parabola{});
#elif defined(A_LAMBDA)
recon::Options options{.weight = [](double q) { return 1 - q; }};
#else
recon::Options options{.degree = 1, .weight = Parabola{}};
#endif
