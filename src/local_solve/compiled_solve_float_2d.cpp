#include "local_solve/compiled_solve_impl.hpp"

template std::unique_ptr<recon::detail::CompiledSolve<float, 2>>
recon::detail::make_solve<float, 2>(int, Solver, const FitTolerances&);
