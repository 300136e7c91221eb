// What frames (frames.hpp) hold, of one whole or of a part of it.
#pragma once

#include <string>
#include <vector>

#include "recon/fields/field_set.hpp"
#include "recon/runs/frames.hpp"
#include "recon/runs/view.hpp"

namespace recon::mpm {

// Of the own particles, these of particle_fields().
template <int D>
FieldSet particle_frame(const View<D>& view, const std::vector<std::string>& names);
// At the nodes that the view has.
template <int D>
FieldSet node_frame(const View<D>& view);
// Whether the method has fields at cells, and those at the cells of the nodes of the view.
bool has_cell_frame(const Method& method);
template <int D>
FieldSet cell_frame(const View<D>& view);

// write_frame() (frames.hpp) of a view of one whole.
template <int D>
void write_frame_of(const std::filesystem::path& folder, const std::string& name,
                    const View<D>& view, std::vector<double>& times, const FrameOptions& options);

// NAME_kind_0007.ext, or of one of several pieces NAME_kind_0007_2.ext.
std::string frame_file(const std::string& name, const char* kind, std::size_t number,
                       const char* extension, int piece = -1);
// The files of frames of this name in a folder, pieces too, from number `first` on.
std::vector<std::filesystem::path> frames_in(const std::filesystem::path& folder,
                                             const std::string& name, std::size_t first);
// Makes a folder that of a run which has written the frames at these times, the first ones of them
// elsewhere: what another run has left of later ones, in whatever form, is removed, and lists that are
// there name no others. Throws FileError for a file that cannot be removed.
void begin_frames(const std::filesystem::path& folder, const std::string& name,
                  const std::vector<double>& times, std::size_t first_listed);
// NAME_kind.pvd of the frames at these times from number `first` on that are in the folder. Those of a
// run before a restart may be in pieces where the others are not, or in another folder.
void write_frame_list(const std::filesystem::path& folder, const std::string& name,
                      const char* kind, const char* extension, const std::vector<double>& times,
                      std::size_t first);

}  // namespace recon::mpm
