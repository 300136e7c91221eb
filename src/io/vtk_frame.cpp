#include "formats.hpp"

namespace recon::detail {

namespace {

// Read as a whole.
class VtkFrame : public FrameSource {
 public:
  VtkFrame(VtkPoints read, const ReadOptions& options) {
    std::vector<ReadColumn> columns;
    add_columns({"position", max_dimension, std::move(read.points), {}}, columns);
    for (ReadArray& array : read.arrays) {
      const std::size_t before = columns.size();
      if (array.name.empty()) array.name = "unnamed";
      add_columns(array, columns);
      array.values = {};
      for (std::size_t c = before; c < columns.size(); ++c) {
        if (!axis_of_coordinate(columns[c].name)) continue;
        read.remarks.push_back("the array " + columns[c].name + " is called data_" +
                               columns[c].name + ", for the points have coordinates of their own");
        columns[c].name = "data_" + columns[c].name;
      }
    }
    for (const ReadColumn& column : columns) info_.columns.push_back(column.name);
    info_.particles = columns.front().values.size();
    info_.step = read.step;
    info_.time = read.time;
    table_.add_read_columns(std::move(columns));
    for (const std::string& marker : options.missing) table_.declare_missing(marker);
    table_.step = read.step;
    table_.time = read.time;
    table_.remarks = std::move(read.remarks);
    if (const auto repeated = table_.repeated_names(); !repeated.empty())
      table_.remarks.push_back("the name of several arrays, which can therefore not be used: " +
                               repeated.front());
  }

  bool next() override { return !std::exchange(done_, true); }
  const FrameInfo& info() const override { return info_; }
  void skip() override {}
  ParticleTable read() override { return table_; }
  void go_to(std::size_t) override { done_ = false; }
  bool is_series() const override { return false; }

 private:
  ParticleTable table_;
  FrameInfo info_;
  bool done_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> vtk_frame(VtkPoints read, const ReadOptions& options) {
  return std::make_unique<VtkFrame>(std::move(read), options);
}

}  // namespace recon::detail
