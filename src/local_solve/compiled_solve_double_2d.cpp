#include "local_solve/compiled_solve_impl.hpp"

template std::unique_ptr<recon::detail::CompiledSolve<double, 2>>
recon::detail::make_solve<double, 2>(int, Solver, const FitTolerances&);
