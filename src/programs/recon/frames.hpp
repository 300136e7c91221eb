// Which frames of which files, and the walk through them with the memory of one.
//
// --frame N is one frame; all, and FIRST:LAST with both ends (either may be left out or be counted
// from the end, and :STEP may follow) are several. With several files the choice holds for each of
// them, one after the other.
#pragma once

#include <functional>
#include <string>

#include "particles.hpp"

namespace recon::program {

// Is the answer to these options a series of frames, though it may have but one?
bool is_series(const InputOptions& options);

// What --frame takes, for its check: an empty text or what is wrong.
std::string check_frame_text(const std::string& text);

struct FramePlace {
  std::size_t number = 0;   // in the series, from 0
  double progress = 0;      // part of the files that has been read, 0 to 1
  std::string description;  // the source of the table, for messages
};

// Calls `use` for each frame chosen, in order. A choice that a file does not have ends the program
// with wrong_input before the first call. The answer: remarks about files that end within a frame.
std::vector<std::string> for_each_frame(
    const InputOptions& options, const std::function<void(ParticleTable, const FramePlace&)>& use);

}  // namespace recon::program
