// Pictures of a section, as PNG and SVG.
#pragma once

#include <string>

#include "context.hpp"
#include "recon/io/picture.hpp"

namespace recon_bench {

// Without curves; y logarithmic, or both axes.
recon::LinePlot log_plot(const std::string& title, const std::string& x_label,
                         const std::string& y_label);
recon::LinePlot log_log_plot(const std::string& title, const std::string& x_label,
                             const std::string& y_label);

// Draws <name>.png and <name>.svg and names them in the section; where that fails (no gnuplot), the
// section says why instead. Points that are NaN are left out. Nothing is drawn in a smoke test.
void draw_picture(const Context& context, Section& section, const std::string& name,
                  recon::LinePlot plot);

// Points in the order of x.
void sort_by_x(recon::Curve& curve);

}  // namespace recon_bench
