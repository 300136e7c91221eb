#include "pictures.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace recon_bench {

recon::LinePlot log_plot(const std::string& title, const std::string& x_label,
                         const std::string& y_label) {
  recon::LinePlot plot;
  plot.title = title;
  plot.x_label = x_label;
  plot.y_label = y_label;
  plot.log_y = true;
  return plot;
}

recon::LinePlot log_log_plot(const std::string& title, const std::string& x_label,
                             const std::string& y_label) {
  recon::LinePlot plot = log_plot(title, x_label, y_label);
  plot.log_x = true;
  return plot;
}

void draw_picture(const Context& context, Section& section, const std::string& name,
                  recon::LinePlot plot) {
  if (context.smoke) return;
  for (recon::Curve& curve : plot.curves) {
    recon::Curve kept = curve;
    kept.x.clear();
    kept.y.clear();
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!std::isfinite(curve.y[i])) continue;
      kept.x.push_back(curve.x[i]);
      kept.y.push_back(curve.y[i]);
    }
    curve = std::move(kept);
  }
  std::erase_if(plot.curves, [](const recon::Curve& curve) { return curve.x.empty(); });
  if (plot.curves.empty()) return;
  try {
    for (const char* suffix : {".png", ".svg"}) recon::draw(context.out / (name + suffix), plot);
    section.pictures.push_back(name);
  } catch (const std::exception& error) {
    section.text += "\n\nNo picture `" + name + "`: " + error.what();
  }
}

void sort_by_x(recon::Curve& curve) {
  std::vector<std::size_t> order(curve.x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return curve.x[a] < curve.x[b]; });
  const std::vector<double> x = curve.x, y = curve.y;
  for (std::size_t i = 0; i < order.size(); ++i) {
    curve.x[i] = x[order[i]];
    curve.y[i] = y[order[i]];
  }
}

}  // namespace recon_bench
