// Particles in HDF5 files.
//
// H5MD (nongnu.org/h5md, version 1.1). /particles/<group>/<element> is a data set of values that do
// not change, [N] or [N][D], or a group of value [frame][N] or [frame][N][D], step and time. step
// and time are one number for each frame, or the distance from frame to frame with the attribute
// `offset`. The box is a group with attributes dimension and boundary, and edges as lengths or
// vectors, which may change with the frames. Its corner is the origin, unless there is an element
// `offset` (which is of earlier versions, and which recon writes).
//
// openPMD (version 1). /data/<iteration>/particles/<species>/<record> is a data set, or a group of
// them for x, y, z; what is the same for all particles may be attributes value and shape. Each has
// unitSI. Positions are position + positionOffset.
//
// Links into other files, external and virtual storage are refused, and so is a data set that
// promises more numbers than its bytes can hold.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats.hpp"
#include "h5md_file.hpp"
#include "hdf5.hpp"

namespace recon::detail {

namespace {

namespace fs = std::filesystem;

// No link into another file is followed.
herr_t refuse_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) {
  return -1;
}

class Hdf5File {
 public:
  Hdf5File(const fs::path& path, std::string image)
      : path_(path),
        image_(std::move(image)),
        file_(open(path, image_), H5Fclose),
        access_(H5Pcreate(H5P_LINK_ACCESS), H5Pclose) {
    if (file_ < 0) throw FileError(path, 0, "is damaged: it begins as HDF5, and is none");
    H5Pset_elink_cb(access_, refuse_link, nullptr);
    std::error_code ignored;
    bytes_ =
        image_.empty() ? static_cast<std::uint64_t>(fs::file_size(path, ignored)) : image_.size();
  }
  ~Hdf5File() {
    const QuietHdf5 quiet;
    file_.release();
    access_.release();
  }
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  [[noreturn]] void fail(const std::string& what) const { throw FileError(path_, 0, what); }

  bool has(const std::string& name) const {
    // Each part of the path must be there before the next one may be asked for.
    for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
      const std::string part = name.substr(0, end);
      if (H5Lexists(file_, part.c_str(), access_) <= 0) return false;
      const bool last = end == std::string::npos;
      if (H5Oexists_by_name(file_, part.c_str(), access_) <= 0) {
        if (!last) return false;
        fail(name + " is a link that leads nowhere, or into another file");
      }
      if (last) return true;
    }
  }
  H5O_type_t kind(const std::string& name) const {
    H5O_info_t info{};
    if (H5Oget_info_by_name(file_, name.c_str(), &info, access_) < 0)
      fail(name + " cannot be read");
    return info.type;
  }
  bool is_group(const std::string& name) const { return has(name) && kind(name) == H5O_TYPE_GROUP; }
  bool is_dataset(const std::string& name) const {
    return has(name) && kind(name) == H5O_TYPE_DATASET;
  }

  // The names in a group, in the order of the alphabet.
  std::vector<std::string> names_in(const std::string& group) const {
    std::vector<std::string> names;
    const Handle open(H5Oopen(file_, group.c_str(), access_), H5Oclose);
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
      static_cast<std::vector<std::string>*>(to)->emplace_back(name);
      return 0;
    };
    if (open < 0 || H5Literate(open, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) < 0)
      fail("the group " + group + " cannot be read");
    return names;
  }

  struct Shape {
    std::vector<std::uint64_t> size;
    bool whole = false, numbers = false;
  };
  Shape shape(const std::string& name) const {
    const Handle set(H5Oopen(file_, name.c_str(), access_), H5Oclose);
    if (set < 0 || H5Iget_type(set) != H5I_DATASET) fail(name + " cannot be opened as a data set");
    return shape_of(name, set);
  }

  // The numbers of a data set, of one index of its first axis if that is given. Whole numbers that
  // double rounds are noted in `remarks`.
  std::vector<double> numbers(const std::string& name, std::optional<std::uint64_t> index,
                              std::vector<std::string>& remarks) const {
    const Handle set(H5Oopen(file_, name.c_str(), access_), H5Oclose);
    if (set < 0 || H5Iget_type(set) != H5I_DATASET) fail(name + " cannot be opened as a data set");
    const Shape shape = shape_of(name, set);
    if (!shape.numbers) fail(name + " holds no numbers");
    check_storage(name, set, shape);
    const Handle space(H5Dget_space(set), H5Sclose);
    std::uint64_t count = 1;
    std::vector<hsize_t> start(shape.size.size(), 0), block(shape.size.begin(), shape.size.end());
    if (index) {
      if (shape.size.empty() || *index >= shape.size[0])
        fail(name + " has nothing for frame " + std::to_string(*index));
      start[0] = *index;
      block[0] = 1;
      if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr) <
          0)
        fail(name + " cannot be read");
    }
    for (const hsize_t along : block) count *= along;
    const hsize_t length = count;
    const Handle memory(H5Screate_simple(1, &length, nullptr), H5Sclose);
    if (count == 0) return {};
    std::vector<double> values(static_cast<std::size_t>(count));
    if (!shape.whole) {
      if (H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()) < 0)
        fail(name + " cannot be read: it is damaged, or filtered in a way that is not known");
      return values;
    }
    std::vector<std::int64_t> whole(values.size());
    if (H5Dread(set, H5T_NATIVE_INT64, memory, space, H5P_DEFAULT, whole.data()) < 0)
      fail(name + " cannot be read: it is damaged, or filtered in a way that is not known");
    constexpr std::int64_t most = std::int64_t{1} << 53;
    bool exact = true;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      exact = exact && whole[i] <= most && whole[i] >= -most;
      values[i] = static_cast<double>(whole[i]);
    }
    if (!exact) remarks.push_back(name + " has whole numbers beyond 2^53, which are rounded");
    return values;
  }

  // Throws unless the bytes of a data set may hold what its shape promises.
  void require_stored(const std::string& name) const {
    const Handle set(H5Oopen(file_, name.c_str(), access_), H5Oclose);
    if (set < 0 || H5Iget_type(set) != H5I_DATASET) fail(name + " cannot be opened as a data set");
    check_storage(name, set, shape_of(name, set));
  }

  // An attribute as numbers, or as texts; empty where it is not there or is of another kind.
  std::vector<double> attribute(const std::string& object, const char* name) const {
    if (H5Aexists_by_name(file_, object.c_str(), name, access_) <= 0) return {};
    const Handle at(H5Aopen_by_name(file_, object.c_str(), name, H5P_DEFAULT, access_), H5Aclose);
    if (at < 0) fail("the attribute " + std::string(name) + " of " + object + " cannot be read");
    const Handle type(H5Aget_type(at), H5Tclose), space(H5Aget_space(at), H5Sclose);
    const H5T_class_t kind = H5Tget_class(type);
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    constexpr hssize_t most = 1000;
    if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || count < 1 || count > most) return {};
    std::vector<double> values(static_cast<std::size_t>(count));
    if (H5Aread(at, H5T_NATIVE_DOUBLE, values.data()) < 0)
      fail("the attribute " + std::string(name) + " of " + object + " cannot be read");
    return values;
  }
  std::vector<std::string> texts(const std::string& object, const char* name) const {
    std::vector<std::string> out;
    if (H5Aexists_by_name(file_, object.c_str(), name, access_) <= 0) return out;
    const Handle at(H5Aopen_by_name(file_, object.c_str(), name, H5P_DEFAULT, access_), H5Aclose);
    const Handle type(H5Aget_type(at), H5Tclose), space(H5Aget_space(at), H5Sclose);
    const hssize_t count = at < 0 ? 0 : H5Sget_simple_extent_npoints(space);
    constexpr hssize_t most = 1000;
    if (H5Tget_class(type) != H5T_STRING || count < 1 || count > most) return out;
    if (H5Tis_variable_str(type) > 0) {
      const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
      H5Tset_size(memory, H5T_VARIABLE);
      H5Tset_cset(memory, H5Tget_cset(type));
      std::vector<char*> words(static_cast<std::size_t>(count), nullptr);
      if (H5Aread(at, memory, words.data()) < 0)
        fail("the attribute " + std::string(name) + " of " + object + " cannot be read");
      for (const char* word : words) out.emplace_back(word == nullptr ? "" : word);
      H5Dvlen_reclaim(memory, space, H5P_DEFAULT, words.data());
      return out;
    }
    const std::size_t size = H5Tget_size(type);
    constexpr std::size_t longest = 1000;
    if (size == 0 || size > longest) return out;
    std::string bytes(size * static_cast<std::size_t>(count), '\0');
    if (H5Aread(at, type, bytes.data()) < 0)
      fail("the attribute " + std::string(name) + " of " + object + " cannot be read");
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      std::string word = bytes.substr(i * size, size);
      word.resize(std::min(word.size(), word.find('\0')));
      while (word.ends_with(' ')) word.pop_back();
      out.push_back(word);
    }
    return out;
  }

 private:
  static hid_t open(const fs::path& path, std::string& image) {
    if (image.empty()) return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    constexpr std::size_t grow = 1 << 20;
    if (H5Pset_fapl_core(access, grow, false) < 0 ||
        H5Pset_file_image(access, image.data(), image.size()) < 0)
      return -1;
    return H5Fopen("memory", H5F_ACC_RDONLY, access);
  }

  Shape shape_of(const std::string& name, hid_t set) const {
    const Handle type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose);
    const H5T_class_t kind = H5Tget_class(type);
    Shape shape;
    shape.whole = kind == H5T_INTEGER;
    shape.numbers = kind == H5T_INTEGER || kind == H5T_FLOAT;
    const H5S_class_t extent = H5Sget_simple_extent_type(space);
    if (extent == H5S_SCALAR) return shape;
    hsize_t size[H5S_MAX_RANK] = {};
    const int axes = H5Sget_simple_extent_dims(space, size, nullptr);
    if (extent != H5S_SIMPLE || axes < 0) fail(name + " has no shape that can be read");
    shape.size.assign(size, size + axes);
    return shape;
  }

  void check_storage(const std::string& name, hid_t set, const Shape& shape) const {
    const Handle creation(H5Dget_create_plist(set), H5Pclose), type(H5Dget_type(set), H5Tclose);
    const H5D_layout_t layout = H5Pget_layout(creation);
    if (H5Pget_external_count(creation) != 0 || layout == H5D_VIRTUAL)
      fail(name + " is stored in other files, which are not read");
    std::uint64_t wanted = H5Tget_size(type);
    // One byte that gzip has compressed makes at most 1032.
    const std::uint64_t most = (layout == H5D_CHUNKED ? 1032 : 1) * bytes_;
    for (const std::uint64_t along : shape.size) {
      if (along > 0 && wanted > most / along)
        fail(name + " promises more numbers than its bytes can hold");
      wanted *= along;
    }
    const std::uint64_t stored = H5Dget_storage_size(set);
    if (wanted > 0 && wanted / (layout == H5D_CHUNKED ? 1032 : 1) > stored)
      fail(name + " promises more numbers than its bytes can hold");
  }

  fs::path path_;
  std::string image_;
  Handle file_, access_;
  std::uint64_t bytes_ = 0;
};

constexpr std::uint64_t most_particles = 4294967294;  // a table numbers its rows with 32 bits

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// The group that the options ask for, or the only one.
std::string choose_group(const Hdf5File& file, const std::vector<std::string>& names,
                         const std::string& asked, const std::string& where) {
  if (names.empty()) file.fail(where + " has no group of particles");
  if (asked.empty() && names.size() > 1)
    file.fail(where + " has several groups of particles, and one must be named: " + listed(names));
  if (asked.empty()) return names.front();
  if (std::find(names.begin(), names.end(), asked) == names.end())
    file.fail(where + " has no group " + quote(asked) + "; it has " + listed(names));
  return asked;
}

// What the frames of both layouts share.
class Hdf5Frames : public FrameSource {
 public:
  Hdf5Frames(const fs::path& path, std::string image, const ReadOptions& options)
      : options_(options), file_(path, std::move(image)) {}

  bool next() override {
    if (at_ + 1 >= frames() + 1) return false;
    current_ = at_++;
    const QuietHdf5 quiet;
    info_ = describe(current_);
    return true;
  }
  const FrameInfo& info() const override { return info_; }
  void skip() override {}
  ParticleTable read() override {
    const QuietHdf5 quiet;
    ParticleTable table = read_frame(current_);
    for (const std::string& marker : options_.missing) table.declare_missing(marker);
    table.step = info_.step;
    table.time = info_.time;
    return table;
  }
  void go_to(std::size_t frame) override { at_ = frame; }
  bool is_series() const override { return true; }
  double progress() const override {
    return static_cast<double>(at_) / static_cast<double>(std::max<std::size_t>(frames(), 1));
  }

 protected:
  virtual std::size_t frames() const = 0;
  virtual FrameInfo describe(std::size_t frame) = 0;
  virtual ParticleTable read_frame(std::size_t frame) = 0;

  static ParticleTable table_of(std::vector<ReadColumn> columns, std::vector<std::string> remarks) {
    ParticleTable table;
    table.add_read_columns(std::move(columns));
    table.remarks = std::move(remarks);
    if (const auto repeated = table.repeated_names(); !repeated.empty())
      table.remarks.push_back("names of several columns, which can therefore not be used: " +
                              listed(repeated));
    return table;
  }

  ReadOptions options_;
  Hdf5File file_;

 private:
  std::size_t at_ = 0, current_ = 0;
  FrameInfo info_;
};

// --- H5MD ----------------------------------------------------------------------------------------

class H5mdFrames : public Hdf5Frames {
 public:
  H5mdFrames(const fs::path& path, std::string image, const ReadOptions& options)
      : Hdf5Frames(path, std::move(image), options) {
    std::vector<std::string> groups;
    for (const std::string& name : file_.names_in("/particles"))
      if (file_.has("/particles/" + name + "/position")) groups.push_back(name);
    group_ = "/particles/" + choose_group(file_, groups, options.group, "/particles");
    position_ = open_element("position");
    particles_ = position_.shape[0];
    if (particles_ > most_particles)
      file_.fail(position_.set + " has more particles than a table can number");
    for (const std::string& name : file_.names_in(group_)) {
      if (name == "box" || name == "position") continue;
      if (is_element(name)) add_element(name);
    }
    open_box();
  }

 private:
  // An element, and the box's edges are one too.
  struct Element {
    std::string name, set;
    bool changes = false;              // has values for each frame
    std::vector<std::uint64_t> shape;  // of one frame
    std::vector<std::int64_t> steps;   // of the frames
    std::vector<double> times;         // may be empty
  };

  bool is_element(const std::string& name) const {
    const std::string path = group_ + "/" + name;
    return file_.is_dataset(path) || file_.is_dataset(path + "/value");
  }

  Element open_element(const std::string& name) {
    const std::string path = group_ + "/" + name;
    Element element{name, path, false, {}, {}, {}};
    if (file_.is_group(path)) {
      element.set += "/value";
      element.changes = true;
    }
    if (!file_.is_dataset(element.set)) file_.fail(element.set + ", a data set, is missing");
    element.shape = file_.shape(element.set).size;
    if (!element.changes) {
      if (element.shape.empty())
        file_.fail(element.set + " is a single number, and needs one for each particle");
      return element;
    }
    if (element.shape.size() < 2) file_.fail(element.set + " needs the axes frame and particle");
    const std::uint64_t frames = element.shape.front();
    element.shape.erase(element.shape.begin());
    const std::vector<double> steps = series(path + "/step", frames);
    if (steps.empty()) file_.fail(path + "/step, a data set, is missing");
    for (const double step : steps) {
      constexpr double most = 9007199254740992;  // 2^53
      if (!(std::abs(step) <= most) || step != std::floor(step))
        file_.fail(path + "/step holds " + to_text(step) + ", which is no whole number below 2^53");
      element.steps.push_back(static_cast<std::int64_t>(step));
    }
    element.times = series(path + "/time", frames);
    for (const double time : element.times)
      if (!std::isfinite(time)) file_.fail(path + "/time holds " + to_text(time));
    return element;
  }

  // A number for each frame, or the first one and the distance from frame to frame.
  std::vector<double> series(const std::string& set, std::uint64_t frames) {
    if (!file_.is_dataset(set)) return {};
    const std::vector<std::uint64_t> shape = file_.shape(set).size;
    std::vector<std::string> ignored;
    std::vector<double> values = file_.numbers(set, {}, ignored);
    if (shape.empty()) {
      const double distance = values.at(0);
      const std::vector<double> offset = file_.attribute(set, "offset");
      values.clear();
      constexpr std::uint64_t most = 1000000000;
      if (frames > most) file_.fail(set + " is for more frames than any file has");
      for (std::uint64_t f = 0; f < frames; ++f)
        values.push_back((offset.empty() ? 0 : offset[0]) + static_cast<double>(f) * distance);
    }
    if (values.size() != frames)
      file_.fail(set + " has " + std::to_string(values.size()) + " numbers for " +
                 std::to_string(frames) + " frames");
    return values;
  }

  void add_element(const std::string& name) {
    Element element = open_element(name);
    if (!file_.shape(element.set).numbers) {
      remarks_.push_back(element.set + " holds no numbers and is left out");
      return;
    }
    if (element.shape.empty() || element.shape[0] != particles_) {
      remarks_.push_back(element.set + " has no value for each particle and is left out");
      return;
    }
    components_of(element);
    elements_.push_back(std::move(element));
  }

  int components_of(const Element& element) const {
    std::uint64_t components = 1;
    for (std::size_t axis = 1; axis < element.shape.size(); ++axis) {
      constexpr std::uint64_t most = 10000;
      if (element.shape[axis] == 0 || element.shape[axis] > most ||
          components * element.shape[axis] > most)
        file_.fail(element.set + " needs 1 to 10000 components");
      components *= element.shape[axis];
    }
    return static_cast<int>(components);
  }

  int axes() const {
    const int axes = components_of(position_);
    if (axes > max_dimension) file_.fail(position_.set + " needs 1 to 3 coordinates");
    return axes;
  }

  void open_box() {
    const std::string box = group_ + "/box";
    if (!file_.is_group(box)) return;
    const std::vector<std::string> boundary = file_.texts(box, "boundary");
    const std::vector<double> dimension = file_.attribute(box, "dimension");
    if (dimension.size() != 1 || !(dimension[0] == 1 || dimension[0] == 2 || dimension[0] == 3))
      file_.fail(box + " needs the attribute dimension: 1, 2 or 3");
    box_dimension_ = static_cast<int>(dimension[0]);
    for (std::size_t d = 0; d < boundary.size() && d < max_dimension; ++d) {
      if (boundary[d] != "periodic" && boundary[d] != "none")
        file_.fail(box + " has the boundary " + quote(boundary[d]) +
                   "; periodic and none are known");
      periodic_[d] = boundary[d] == "periodic";
    }
    if (boundary.size() != static_cast<std::size_t>(box_dimension_))
      file_.fail(box + " needs the attribute boundary, of " + std::to_string(box_dimension_) +
                 " words");
    // Edges may also be an attribute, as version 1.0 had it.
    fixed_edges_ = file_.attribute(box, "edges");
    if (file_.has(box + "/edges")) edges_ = open_element("box/edges");
    if (file_.has(box + "/offset")) corner_ = open_element("box/offset");
    if (!fixed_edges_.empty()) return;
    const auto axes = static_cast<std::uint64_t>(box_dimension_);
    if (!edges_) {
      if (periodic_ != std::array<bool, max_dimension>{})
        file_.fail(box + " is periodic and has no edges");
      return;
    }
    const std::vector<std::uint64_t> lengths{axes}, vectors{axes, axes};
    if (edges_->shape != lengths && edges_->shape != vectors)
      file_.fail(edges_->set + " needs " + std::to_string(axes) + " lengths or as many vectors");
    if (corner_ && corner_->shape != lengths)
      file_.fail(corner_->set + " needs " + std::to_string(axes) + " coordinates");
  }

  // Which index of an element belongs to the step of a frame.
  std::optional<std::uint64_t> index_at(const Element& element, std::size_t frame) const {
    if (position_.steps.empty())
      return element.changes ? std::optional<std::uint64_t>(0) : std::nullopt;
    const std::int64_t step = position_.steps[frame];
    if (frame < element.steps.size() && element.steps[frame] == step) return frame;
    const auto found = std::find(element.steps.begin(), element.steps.end(), step);
    if (found == element.steps.end()) return {};
    return static_cast<std::uint64_t>(found - element.steps.begin());
  }

  std::size_t frames() const override { return position_.changes ? position_.steps.size() : 1; }

  FrameInfo describe(std::size_t frame) override {
    FrameInfo info;
    info.particles = static_cast<std::size_t>(particles_);
    if (position_.changes) info.step = position_.steps[frame];
    if (!position_.times.empty()) info.time = position_.times[frame];
    const auto add = [&](const Element& element) {
      const int components = components_of(element);
      for (int c = 0; c < components; ++c)
        info.columns.push_back(column_name(element.name, c, components));
    };
    for (int axis = 0; axis < axes(); ++axis) info.columns.emplace_back(1, "xyz"[axis]);
    for (const Element& element : elements_) add(element);
    return info;
  }

  ParticleTable read_frame(std::size_t frame) override {
    std::vector<std::string> remarks = remarks_;
    std::vector<ReadColumn> columns;
    const auto add = [&](const Element& element) {
      const std::optional<std::uint64_t> index = index_at(element, frame);
      if (element.changes && !index) {
        remarks.push_back(element.set + " has nothing for step " +
                          std::to_string(position_.steps[frame]) + " and is left out");
        return;
      }
      add_columns(
          {element.name, components_of(element), file_.numbers(element.set, index, remarks), {}},
          columns);
    };
    axes();
    add(position_);
    columns.front().name = "x";
    for (const Element& element : elements_) add(element);
    ParticleTable table = table_of(std::move(columns), std::move(remarks));
    add_box(table, frame);
    return table;
  }

  void add_box(ParticleTable& table, std::size_t frame) const {
    if (box_dimension_ == 0 || (!edges_ && fixed_edges_.empty())) return;
    std::vector<double> edges = fixed_edges_;
    SimulationCell cell;
    for (const std::optional<Element>* part : {&edges_, &corner_}) {
      if (!*part || (part == &edges_ && !edges.empty())) continue;
      const std::optional<std::uint64_t> index = index_at(**part, frame);
      if ((*part)->changes && !index) {
        table.remarks.push_back((*part)->set + " has nothing for this step: the box is not known");
        return;
      }
      const std::vector<double> values = file_.numbers((*part)->set, index, table.remarks);
      if (part == &edges_) edges = values;
      if (part == &corner_) std::copy(values.begin(), values.end(), cell.origin.begin());
    }
    const auto axes = static_cast<std::size_t>(box_dimension_);
    if (edges.size() != axes && edges.size() != axes * axes)
      file_.fail(group_ + "/box has " + std::to_string(edges.size()) + " numbers as edges");
    for (std::size_t i = 0; i < edges.size(); ++i)
      cell.edges[edges.size() == axes ? i : i / axes][edges.size() == axes ? i : i % axes] =
          edges[i];
    set_cell_or_box(table, cell, periodic_);
  }

  std::string group_;
  Element position_;
  std::uint64_t particles_ = 0;
  std::vector<Element> elements_;
  int box_dimension_ = 0;  // 0: no box
  std::array<bool, max_dimension> periodic_{};
  std::optional<Element> edges_, corner_;
  std::vector<double> fixed_edges_;
  std::vector<std::string> remarks_;
};

// --- openPMD -------------------------------------------------------------------------------------

class OpenPmdFrames : public Hdf5Frames {
 public:
  OpenPmdFrames(const fs::path& path, std::string image, const ReadOptions& options)
      : Hdf5Frames(path, std::move(image), options) {
    for (const std::string& name : file_.names_in("/data")) {
      const std::optional<std::int64_t> iteration = parse_integer(name);
      if (iteration && file_.is_group("/data/" + name + "/particles"))
        iterations_.emplace_back(*iteration, name);
    }
    std::sort(iterations_.begin(), iterations_.end());
    if (iterations_.empty()) file_.fail("/data has no iteration with particles");
  }

 private:
  std::size_t frames() const override { return iterations_.size(); }

  FrameInfo describe(std::size_t frame) override {
    FrameInfo info;
    info.step = iterations_[frame].first;
    const std::string iteration = "/data/" + iterations_[frame].second;
    const std::vector<double> time = file_.attribute(iteration, "time"),
                              unit = file_.attribute(iteration, "timeUnitSI");
    if (!time.empty() && std::isfinite(time[0])) info.time = time[0] * (unit.empty() ? 1 : unit[0]);
    info.units = "si";
    const std::vector<std::string> groups = file_.names_in(iteration + "/particles");
    species_ = iteration + "/particles/" +
               choose_group(file_, groups, options_.group, iteration + "/particles");
    info.particles = static_cast<std::size_t>(count());
    for (const std::string& record : records())
      for (const std::string& part : components(record))
        info.columns.push_back(name_of(record, part));
    return info;
  }

  // The records of the species; those that only shift or describe others do not count.
  std::vector<std::string> records() const {
    std::vector<std::string> names;
    for (const std::string& name : file_.names_in(species_))
      if (name != "positionOffset" && name != "particlePatches") names.push_back(name);
    return names;
  }
  bool is_constant(const std::string& path) const {
    return file_.is_group(path) && !file_.attribute(path, "value").empty();
  }
  // The parts of a record: x, y, z, or one without a name.
  std::vector<std::string> components(const std::string& record) const {
    const std::string path = species_ + "/" + record;
    if (file_.is_dataset(path) || is_constant(path)) return {""};
    return file_.is_group(path) ? file_.names_in(path) : std::vector<std::string>();
  }
  static std::string name_of(const std::string& record, const std::string& part) {
    if (part.empty()) return record;
    const bool axis = part == "x" || part == "y" || part == "z";
    return axis ? column_name(record, part[0] - 'x', max_dimension) : record + "_" + part;
  }

  std::uint64_t count() const {
    const std::string position = species_ + "/position";
    if (!file_.is_group(position) || is_constant(position))
      file_.fail(position + ", a group of x, y, z, is missing");
    std::optional<std::uint64_t> count;
    for (const std::string& part : file_.names_in(position)) {
      const std::uint64_t here = count_of(position + "/" + part);
      if (count && *count != here)
        file_.fail(position + "/" + part + " has " + std::to_string(here) +
                   " values, the others have " + std::to_string(*count));
      count = here;
    }
    if (!count) file_.fail(position + " is empty");
    if (*count > most_particles)
      file_.fail(position + " has more particles than a table can number");
    return *count;
  }
  std::uint64_t count_of(const std::string& path) const {
    if (is_constant(path)) {
      const std::vector<double> shape = file_.attribute(path, "shape");
      if (shape.size() != 1 || !(shape[0] >= 0 && shape[0] <= static_cast<double>(most_particles)))
        file_.fail(path + " needs the attribute shape: the number of particles");
      return static_cast<std::uint64_t>(shape[0]);
    }
    if (!file_.is_dataset(path)) file_.fail(path + " is neither a data set nor constant");
    const std::vector<std::uint64_t> shape = file_.shape(path).size;
    if (shape.size() != 1) file_.fail(path + " needs one axis, the particles");
    return shape[0];
  }

  std::vector<double> values(const std::string& path, std::size_t wanted,
                             std::vector<std::string>& remarks) const {
    std::vector<double> values;
    if (is_constant(path))
      values.assign(wanted, file_.attribute(path, "value")[0]);
    else
      values = file_.numbers(path, {}, remarks);
    const std::vector<double> unit = file_.attribute(path, "unitSI");
    if (!unit.empty() && unit[0] != 1)
      for (double& value : values) value *= unit[0];
    return values;
  }

  // What is constant takes no bytes in the file: something must be there that does, so that a few
  // bytes cannot ask for all memory.
  void require_stored(std::size_t wanted) const {
    std::vector<std::string> all = records();
    all.emplace_back("positionOffset");
    for (const std::string& record : all)
      for (const std::string& part : components(record)) {
        const std::string path = species_ + "/" + record + (part.empty() ? "" : "/" + part);
        if (is_constant(path) || !file_.is_dataset(path) || count_of(path) != wanted) continue;
        return file_.require_stored(path);
      }
    if (wanted > 0) file_.fail(species_ + " has no record with a value for each particle");
  }

  ParticleTable read_frame(std::size_t) override {
    std::vector<std::string> remarks;
    std::vector<ReadColumn> columns;
    const std::size_t wanted = info().particles;
    bool offset_is_known = false;
    require_stored(wanted);
    for (const std::string& record : records()) {
      for (const std::string& part : components(record)) {
        const std::string path = species_ + "/" + record + (part.empty() ? "" : "/" + part);
        if (!is_constant(path) && !file_.is_dataset(path)) continue;
        if (!is_constant(path) && !file_.shape(path).numbers) {
          remarks.push_back(path + " holds no numbers and is left out");
          continue;
        }
        if (count_of(path) != wanted) {
          if (record == "position") file_.fail(path + " has no value for each particle");
          remarks.push_back(path + " has no value for each particle and is left out");
          continue;
        }
        ReadColumn column{name_of(record, part), values(path, wanted, remarks), {}};
        const std::string offset = species_ + "/positionOffset/" + part;
        if (record == "position" && file_.has(offset)) {
          offset_is_known = true;
          if (count_of(offset) != wanted) file_.fail(offset + " has no value for each particle");
          const std::vector<double> shift = values(offset, wanted, remarks);
          for (std::size_t i = 0; i < wanted; ++i) column.values[i] += shift[i];
        }
        columns.push_back(std::move(column));
      }
    }
    if (!offset_is_known) remarks.push_back(species_ + " has no positionOffset: taken as 0");
    ParticleTable table = table_of(std::move(columns), std::move(remarks));
    table.units = "si";
    return table;
  }

  std::vector<std::pair<std::int64_t, std::string>> iterations_;
  std::string species_;  // of the frame that next() found
};

}  // namespace

std::unique_ptr<FrameSource> open_hdf5_particles(const fs::path& path, std::string image,
                                                 const ReadOptions& options) {
  const QuietHdf5 quiet;
  bool h5md = false, open_pmd = false;
  {
    const Hdf5File file(path, image);
    h5md = file.is_group("/particles");
    open_pmd = !h5md && file.is_group("/data");
    if (!h5md && !open_pmd)
      file.fail("is HDF5 without the group /particles of H5MD or /data of openPMD; it has " +
                listed(file.names_in("/")));
  }
  if (h5md) return std::make_unique<H5mdFrames>(path, std::move(image), options);
  return std::make_unique<OpenPmdFrames>(path, std::move(image), options);
}

// --- writing H5MD --------------------------------------------------------------------------------

namespace {

class H5mdWriter {
 public:
  explicit H5mdWriter(const fs::path& path)
      : path_(&path), access_(H5Pcreate(H5P_FILE_ACCESS), H5Pclose), file_(create(), H5Fclose) {
    check(file_);
  }

  void write(const std::vector<H5mdFrame>& frames) {
    const hsize_t count = frames.size();
    for (const char* group : {"/h5md", "/h5md/author", "/h5md/creator", "/particles",
                              "/particles/all", "/particles/all/position"})
      make_group(group);
    const int version[2] = {1, 1};
    attribute("/h5md", "version", H5T_NATIVE_INT, 2, version);
    text("/h5md/author", "name", "unknown");
    text("/h5md/creator", "name", "recon");
    text("/h5md/creator", "version", "1");
    std::vector<std::int64_t> steps;
    std::vector<double> times;
    for (const H5mdFrame& frame : frames) {
      steps.push_back(frame.step);
      if (frame.time) times.push_back(*frame.time);
    }
    has_times_ = times.size() == frames.size();
    const std::string position = "/particles/all/position";
    dataset(position + "/step", H5T_NATIVE_INT64, {count}, steps.data());
    if (has_times_) dataset(position + "/time", H5T_NATIVE_DOUBLE, {count}, times.data());
    write_box(frames);
    for (std::size_t a = 0; a < frames.front().arrays.size(); ++a) {
      const ReadArray& first = frames.front().arrays[a];
      const std::string group = "/particles/all/" + first.name;
      if (a > 0) {
        make_group(group);
        share(position, group);
      }
      std::vector<double> values;
      for (const H5mdFrame& frame : frames)
        values.insert(values.end(), frame.arrays[a].values.begin(), frame.arrays[a].values.end());
      const auto components = static_cast<hsize_t>(first.components);
      std::vector<hsize_t> shape{count, first.values.size() / components};
      if (components > 1) shape.push_back(components);
      if (!first.whole) {
        dataset(group + "/value", H5T_NATIVE_DOUBLE, shape, values.data());
        continue;
      }
      const std::vector<std::int64_t> whole(values.begin(), values.end());
      dataset(group + "/value", H5T_NATIVE_INT64, shape, whole.data());
    }
  }

  std::string image() {
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
    const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
    check(static_cast<hid_t>(size));
    std::string bytes(static_cast<std::size_t>(size), '\0');
    check(static_cast<hid_t>(H5Fget_file_image(file_, bytes.data(), bytes.size())));
    return bytes;
  }

 private:
  // In memory: what goes to the disk goes there by an AtomicFile.
  hid_t create() const {
    constexpr std::size_t grow = 1 << 20;
    if (H5Pset_fapl_core(access_, grow, false) < 0) return -1;
    return H5Fcreate("memory", H5F_ACC_TRUNC, H5P_DEFAULT, access_);
  }
  void check(hid_t result) const {
    if (result < 0) throw FileError(*path_, 0, "the HDF5 library could not make the file");
  }
  void make_group(const std::string& name) const {
    const Handle group(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                       H5Gclose);
    check(group);
  }
  // Arrays of the same frames have the same data sets step and time.
  void share(const std::string& from, const std::string& to) const {
    for (const char* part : {"/step", "/time"})
      if (part != std::string("/time") || has_times_)
        check(H5Lcreate_hard(file_, (from + part).c_str(), file_, (to + part).c_str(), H5P_DEFAULT,
                             H5P_DEFAULT));
  }
  void attribute(const std::string& object, const char* name, hid_t type, hsize_t count,
                 const void* values) const {
    const Handle space(count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr),
                       H5Sclose);
    const Handle at(H5Acreate_by_name(file_, object.c_str(), name, type, space, H5P_DEFAULT,
                                      H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
    check(at);
    check(H5Awrite(at, type, values));
  }
  void text(const std::string& object, const char* name, const std::string& value) const {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    check(H5Tset_size(type, value.size()));
    attribute(object, name, type, 0, value.data());
  }
  void dataset(const std::string& name, hid_t type, const std::vector<hsize_t>& shape,
               const void* values) const {
    const Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       H5Sclose);
    const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);  // the same bytes for the same frames
    const Handle set(
        H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose);
    check(set);
    check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
  }

  void write_box(const std::vector<H5mdFrame>& frames) const {
    const std::string box = "/particles/all/box";
    make_group(box);
    const int dimension = max_dimension;
    attribute(box, "dimension", H5T_NATIVE_INT, 0, &dimension);
    constexpr std::size_t width = 8;
    std::string words;
    for (const bool periodic : frames.front().periodic) {
      words += periodic ? "periodic" : "none";
      words.resize((words.size() + width - 1) / width * width, '\0');
    }
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    check(H5Tset_size(type, width));
    check(H5Tset_strpad(type, H5T_STR_NULLPAD));
    attribute(box, "boundary", type, max_dimension, words.data());
    if (!frames.front().cell) return;
    make_group(box + "/edges");
    share("/particles/all/position", box + "/edges");
    std::vector<double> edges, corners;
    bool orthogonal = true;
    for (const H5mdFrame& frame : frames)
      for (int e = 0; e < max_dimension; ++e)
        for (int d = 0; d < max_dimension; ++d)
          orthogonal = orthogonal && (e == d || frame.cell->edges[e][d] == 0);
    for (const H5mdFrame& frame : frames)
      for (int e = 0; e < max_dimension; ++e)
        for (int d = 0; d < max_dimension; ++d)
          if (!orthogonal || e == d) edges.push_back(frame.cell->edges[e][d]);
    std::vector<hsize_t> shape{frames.size(), max_dimension};
    if (!orthogonal) shape.push_back(max_dimension);
    dataset(box + "/edges/value", H5T_NATIVE_DOUBLE, shape, edges.data());
    for (const H5mdFrame& frame : frames)
      corners.insert(corners.end(), frame.cell->origin.begin(), frame.cell->origin.end());
    if (std::all_of(corners.begin(), corners.end(), [](double place) { return place == 0; }))
      return;
    make_group(box + "/offset");
    share("/particles/all/position", box + "/offset");
    dataset(box + "/offset/value", H5T_NATIVE_DOUBLE, {frames.size(), max_dimension},
            corners.data());
  }

  const fs::path* path_;
  bool has_times_ = false;
  Handle access_, file_;
};

}  // namespace

std::string h5md_image(const fs::path& path, const std::vector<H5mdFrame>& frames) {
  const QuietHdf5 quiet;
  H5mdWriter writer(path);
  writer.write(frames);
  return writer.image();
}

}  // namespace recon::detail
