#include "cuda/grid_moments.cuh"

namespace recon::cuda {
template class GridMoments<1, double>;
template class GridMoments<2, double>;
template class GridMoments<3, double>;
}  // namespace recon::cuda
