#include "cuda/grid_moments.cuh"

namespace recon::cuda {
template class GridMoments<1, float>;
template class GridMoments<2, float>;
template class GridMoments<3, float>;
}  // namespace recon::cuda
