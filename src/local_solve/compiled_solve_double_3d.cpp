#include "local_solve/compiled_solve_impl.hpp"

template std::unique_ptr<recon::detail::CompiledSolve<double, 3>>
recon::detail::make_solve<double, 3>(int, Solver, const FitTolerances&);
