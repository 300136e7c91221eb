// Must not compile: a report has no room for this degree.
#include "recon/local_solve/local_solve.hpp"

template class recon::LocalSolve<double, recon::Monomials<1, recon::FitReport::max_degree + 1>>;
