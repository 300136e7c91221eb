#include "piece_files.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <vector>

#include "programs/common/errors.hpp"
#include "recon/io/atomic_file.hpp"

namespace recon::program {

namespace fs = std::filesystem;

namespace {

// The pieces that an earlier run on ranks has named in this file.
std::vector<fs::path> pieces_of(const fs::path& out) {
  std::ifstream file(out);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string begin = "Source=\"" + out.stem().string() + "_";
  std::vector<fs::path> pieces;
  for (std::size_t at = 0; (at = text.find(begin, at)) != std::string::npos;) {
    at += begin.size();
    int rank = 0;
    const auto read = std::from_chars(&text[at], text.data() + text.size(), rank);
    if (read.ec == std::errc() && std::string_view(read.ptr).starts_with(".vti\""))
      pieces.push_back(out.parent_path() / piece_name(out, rank));
  }
  return pieces;
}

fs::path unfinished(const fs::path& piece) {
  return piece.string() + ".part";
}

}  // namespace

fs::path piece_name(const fs::path& out, int rank) {
  return out.stem().string() + "_" + std::to_string(rank) + ".vti";
}

void require_same_input(const Everyone& ranks, const std::string& file) {
  constexpr std::streamoff most = 1 << 16;
  std::error_code none;
  const auto length = static_cast<std::streamoff>(fs::file_size(file, none));
  std::string seen(static_cast<std::size_t>(std::min(most, length)), '\0'), end = seen;
  std::ifstream from(file, std::ios::binary);
  from.read(seen.data(), static_cast<std::streamsize>(seen.size()));
  from.seekg(length - static_cast<std::streamoff>(end.size()));
  from.read(end.data(), static_cast<std::streamsize>(end.size()));
  const std::size_t hash = std::hash<std::string>{}(std::to_string(length) + seen + end);
  const auto number = static_cast<double>(hash >> 12);  // has it to the last bit
  const bool same = ranks.least(number) == ranks.greatest(number);
  ranks.together([&] {
    if (!same)
      fail_input(file + ": is another file for some ranks than for others: all must see the same");
  });
}

PieceFiles::PieceFiles(const fs::path& out, const Everyone& ranks)
    : out_(out), piece_(out.parent_path() / piece_name(out, ranks.rank())), ranks_(ranks) {
  on_disk([&] { const AtomicFile probe(piece_); });
}

void PieceFiles::on_disk(const std::function<void()>& work) const {
  ranks_.together([&] { with_exit_code(no_output, work); });
}

void PieceFiles::write(bool any, const std::function<void(const fs::path&)>& piece,
                       const std::function<void()>& list) const {
  const std::size_t with_piece = ranks_.sum(any ? 1 : 0);
  std::error_code ignored;
  try {
    on_disk([&] {
      if (!any) return;
      try {
        piece(unfinished(piece_));
      } catch (const FileError& error) {  // by the name that it was to have
        const std::string what = error.what(), begin = error.path().string() + ": ";
        throw FileError(piece_, 0, what.substr(what.starts_with(begin) ? begin.size() : 0));
      }
    });
    on_disk([&] {
      if (ranks_.rank() > 0) return;
      std::size_t here = 0;
      for (int rank = 0; rank < ranks_.size(); ++rank)
        here += fs::exists(unfinished(out_.parent_path() / piece_name(out_, rank)), ignored);
      if (here != with_piece)
        throw FileError(out_, 0,
                        "of " + std::to_string(with_piece) + " pieces " + std::to_string(here) +
                            " are beside it: all ranks must write to the same folder");
    });
    on_disk([&] {
      std::error_code error;
      if (any) fs::rename(unfinished(piece_), piece_, error);
      if (error) throw FileError(piece_, 0, "cannot be written: " + error.message());
    });
  } catch (const ProgramError&) {
    if (any) fs::remove(unfinished(piece_), ignored);
    throw;
  }
  on_disk([&] {
    if (ranks_.rank() > 0) return;
    const std::vector<fs::path> before = pieces_of(out_);
    list();
    const std::vector<fs::path> now = pieces_of(out_);
    for (const fs::path& each : before)
      if (std::find(now.begin(), now.end(), each) == now.end()) fs::remove(each, ignored);
  });
}

}  // namespace recon::program
