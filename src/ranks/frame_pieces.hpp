// The frame of a state that is spread over ranks: each writes the piece of it that lies in its box,
// and the first one the files that name the pieces.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "ranks/boxes.hpp"
#include "ranks/messages.hpp"
#include "recon/runs/frames.hpp"
#include "recon/runs/view.hpp"

namespace recon::mpm {

// Collective. The nodes must be those of the state. What the particles of a rank see goes to the ranks
// in whose boxes the nodes and cells lie.
template <int D>
void write_frame_pieces(const std::filesystem::path& folder, const std::string& name,
                        const View<D>& view, const Boxes<D>& boxes, Votes& votes,
                        Messages<D>& messages, std::vector<double>& times,
                        const FrameOptions& options);

}  // namespace recon::mpm
