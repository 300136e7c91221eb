#include "recon/transfer/domain_functions.hpp"

#include <cmath>
#include <string>

namespace recon::detail {

void throw_half_edge(double l, int axis) {
  throw_invalid(std::string("half edge of the particle domain along ") + "xyz"[axis], l,
                "must be positive and finite");
}

void throw_width(double cells, int axis) {
  throw_invalid(std::string("cells of the particle domain along ") + "xyz"[axis], cells,
                "must be at most 32");
}

void throw_half_edges(const double* H, int dimension, double determinant) {
  for (int i = 0; i < dimension * dimension; ++i)
    if (!std::isfinite(H[i]))
      throw_invalid(std::string("component ") + "xyz"[i % dimension] + " of half edge " +
                        std::to_string(i / dimension) + " of the particle domain",
                    H[i], "must be finite");
  throw_invalid("determinant of the half edges of the particle domain", determinant,
                "must be finite and not zero");
}

void throw_corners(const double* corners, int count, int dimension, double volume) {
  for (int i = 0; i < count * dimension; ++i)
    if (!std::isfinite(corners[i]))
      throw_invalid(std::string("coordinate ") + "xyz"[i % dimension] + " of corner " +
                        std::to_string(i / dimension) + " of the particle domain",
                    corners[i], "must be finite");
  throw_invalid("volume of the particle domain", volume,
                "must be finite and not zero: its corners must span a cell");
}

}  // namespace recon::detail
