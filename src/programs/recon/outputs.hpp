// The files that a run writes.
#pragma once

#include <string>
#include <vector>

namespace recon::program {

// Ends before the work begins what would fail after it: an extension that nothing writes, a folder
// that is missing or write-protected, two outputs or an input and an output that are the same file.
// csv_only: no VTK.
void check_outputs(const std::vector<std::string>& outputs, const std::string& picture,
                   const std::vector<std::string>& inputs, bool grid, bool csv_only = false);

// "1.2 MB" and the like.
std::string file_size(const std::string& path);

}  // namespace recon::program
