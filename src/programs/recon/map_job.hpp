// recon map, step by step: the particles of a frame to fields at targets, and these into files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit_choice.hpp"
#include "mapping.hpp"
#include "programs/common/json.hpp"
#include "slice_picture.hpp"

namespace recon::program {

struct MapOptions {
  InputOptions input;
  FitChoice fit;
  PictureOptions picture;
  std::string method = "imls", fields, targets = "grid";
  std::vector<std::string> components, outputs;
  std::optional<double> spacing;
  bool gradient = false, average = false, quiet = false, json = false;
};

// Where the fields are wanted: a grid, or the points of a file.
struct Targets {
  bool is_grid = true;
  StructuredGrid<double> grid;
  StructuredGrid<double>::Nodes nodes;
  ParticleTable table;
  PointsView<double> points;  // refers to nodes or table
  std::string description;
};

// What is mapped, where and how: decided before the work begins.
struct MapJob {
  Particles particles;
  FieldPlan plan;
  FitOptions fit;  // refers to the particles
  Targets targets;
  Cut cut;
};

// Ends with wrong_usage for options that contradict each other.
void check_options(const MapOptions& options);

// Ends with wrong_usage or wrong_input for what the particles do not have.
MapJob prepare(const MapOptions& options, const Method& method, Particles particles);

// Writes the outputs and draws the picture. With reports, .csv has them in words. The answer: what
// lies beyond the colours of the picture, in words.
std::string write_outputs(const MapOptions& options, const MapJob& job, const FieldSet& fields,
                          const FitReports* reports);

// Whether an output is the standard output, which then holds nothing else.
bool writes_to_pipe(const MapOptions& options);

// The files that a run with these options reads, and those that it writes.
std::vector<std::string> inputs_of(const MapOptions& options);
std::vector<std::string> files_of(const MapOptions& options);

void print_summary(const MapOptions& options, const Method& method, const MapJob& job,
                   const Mapped& mapped);
// The same as members of an object.
void set_summary(Json& object, const MapOptions& options, const Method& method, const MapJob& job,
                 const Mapped& mapped);
// "written       a.vti (1.2 MB)", a line for each file.
void print_written(const std::vector<std::string>& files, const std::string& beyond);

}  // namespace recon::program
