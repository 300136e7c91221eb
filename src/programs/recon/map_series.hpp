// recon map over several frames: a series of outputs, or their mean and standard deviation.
//
// A series: each output and picture gets the number of its frame in the series (v.vti becomes
// v_0000.vti, v_0001.vti, ...), and .vti and .vtp a list for ParaView (v.pvd) with the times or,
// where a frame has none, the steps or else the numbers. Each frame has the grid that covers it,
// all with the spacing of the first.
//
// An average (see average.hpp): one output, on the grid of the first frame or of --bounds, with the
// supports of the first frame. What lies outside that grid later on is counted and said.
//
// Memory is that of one frame, and of the average. A coordinate that counts in the first frame
// counts in all; one that begins to vary later is an error.
#pragma once

#include "map_job.hpp"

namespace recon::program {

void map_series(const MapOptions& options, const Method& method);
void map_average(const MapOptions& options, const Method& method);

}  // namespace recon::program
