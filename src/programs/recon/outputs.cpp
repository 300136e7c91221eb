#include "outputs.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/picture.hpp"
#include "recon/io/write.hpp"

namespace recon::program {

namespace fs = std::filesystem;

namespace {

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  if (fs::equivalent(a, b, ignored)) return true;
  return fs::weakly_canonical(fs::absolute(a), ignored) ==
         fs::weakly_canonical(fs::absolute(b), ignored);
}

}  // namespace

void check_outputs(const std::vector<std::string>& outputs, const std::string& picture,
                   const std::vector<std::string>& inputs, bool grid, bool csv_only) {
  for (const std::string& path : outputs) {
    if (csv_only && fs::path(path).extension() != ".csv")
      fail_usage("--out " + path + ": a profile is written as .csv");
    if (path == "-") continue;
    with_exit_code(wrong_usage, [&] { require_writable_extension(path, grid); });
  }
  std::vector<std::string> all = outputs;
  if (!picture.empty()) {
    with_exit_code(wrong_usage, [&] { require_picture_extension(picture); });
    all.push_back(picture);
  }
  check_files(all, inputs);
}

void check_files(const std::vector<std::string>& all, const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const std::string& input : inputs)
      if (all[i] != "-" && same_file(all[i], input))
        fail_usage(all[i] + " is an input; it would be overwritten: choose another name");
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(all[i], all[j])) fail_usage(all[i] + " is named twice as an output");
  }
  for (const std::string& path : all)
    if (path != "-") with_exit_code(no_output, [&] { const AtomicFile probe(path); });
}

OutputPlace::OutputPlace(const std::string& output) : path_(output) {
  if (output != "-") return;
  std::string folder = (fs::temp_directory_path() / "recon-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr)
    throw ProgramError(no_output, "no temporary folder " + folder + " can be made");
  folder_ = folder;
  path_ = folder + "/output";
}

OutputPlace::~OutputPlace() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

void OutputPlace::send() const {
  if (folder_.empty()) return;
  std::ifstream in(path_, std::ios::binary);
  std::string bytes(1 << 18, '\0');
  while (in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())) || in.gcount() > 0) {
    const auto got = static_cast<std::size_t>(in.gcount());
    if (std::fwrite(bytes.data(), 1, got, stdout) != got)
      throw ProgramError(no_output, "the standard output cannot be written");
  }
}

std::string file_size(const std::string& path) {
  std::error_code error;
  const double bytes = static_cast<double>(fs::file_size(path, error));
  if (error) return "";
  if (bytes < 1e3) return number(bytes, 3) + " bytes";
  if (bytes < 1e6) return number(bytes / 1e3, 3) + " kB";
  return bytes < 1e9 ? number(bytes / 1e6, 3) + " MB" : number(bytes / 1e9, 3) + " GB";
}

}  // namespace recon::program
