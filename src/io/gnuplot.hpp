// gnuplot as a program of its own: a script in, a picture out.
#pragma once

#include <filesystem>
#include <string>

namespace recon::detail {

// Text as a quoted string of gnuplot, shown letter by letter.
std::string gnuplot_string(const std::string& text);

// Runs `script`, which must not set terminal or output, and writes what gnuplot draws to `path`.
// Width and height are in pixels, before they are multiplied by the scale. Throws FileError (see
// recon/io/picture.hpp).
void run_gnuplot(const std::filesystem::path& path, int width, int height, double scale,
                 const std::string& script);

}  // namespace recon::detail
