#include "recon/transfer/point_functions.hpp"

namespace recon {

void detail::throw_coordinate(double x, int axis) {
  throw_invalid(std::string("coordinate ") + "xyz"[axis], x, "must be finite");
}

void detail::throw_no_cells() {
  throw_invalid("grid", "without cells", "must be made with its box and its spacing");
}

void detail::throw_component(const char* of, double value, std::size_t component,
                             const char* rule) {
  throw_invalid("component " + std::to_string(component) + " of " + of, value, rule);
}

void detail::throw_nodal(std::uint32_t node, double value, std::size_t component,
                         const char* rule) {
  throw_component(("the nodal data at node " + std::to_string(node)).c_str(), value, component,
                  rule);
}

std::string_view name_of(SplineBorder border) {
  switch (border) {
    case SplineBorder::corrected:
      return "corrected";
    case SplineBorder::extra_column:
      return "extra_column";
    case SplineBorder::linear_cells:
      return "linear_cells";
  }
  return "";
}

}  // namespace recon
