// Damaged gzip streams, and what comes behind them: the first byte says how much of the input is
// packed before it is read, the next ones which byte of the packed text is changed, and to what.
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "reader.hpp"

namespace {

std::string packed(std::string_view text) {
  z_stream stream{};
  if (deflateInit2(&stream, 1, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK) std::abort();
  std::string out(deflateBound(&stream, static_cast<uLong>(text.size())) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) std::abort();
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  recon::fuzz::read(bytes);  // as it is: seeds are gzip files
  if (size < 4) return 0;
  const std::string_view text = bytes.substr(4);
  const std::size_t part = text.size() * data[0] / 255;
  std::string file = packed(text.substr(0, part));
  recon::fuzz::read(file);
  recon::fuzz::read(file + std::string(text.substr(part)));
  file[(data[1] + 256u * data[2]) % file.size()] = static_cast<char>(data[3]);
  recon::fuzz::read(file);
  return 0;
}
