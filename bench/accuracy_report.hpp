// How the accuracy studies write numbers and pictures.
#pragma once

#include <string>

#include "context.hpp"
#include "pictures.hpp"
#include "recon/io/picture.hpp"

namespace recon_bench {

// Draws <out>/<name>.png and .svg, and lists the picture in the section.
inline void add_picture(Section& section, const Context& context, const std::string& name,
                        const recon::LinePlot& plot) {
  recon::draw(context.out / (name + ".png"), plot);
  recon::draw(context.out / (name + ".svg"), plot);
  section.pictures.push_back(name);
}

// Seconds that one timing may take.
inline double timing_budget(const Context& context) {
  return context.quick ? 0.004 : 0.1;
}

}  // namespace recon_bench
