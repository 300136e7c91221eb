// The formats that read.cpp chooses from. Each reads from a file that stands at its beginning.
#pragma once

#include <memory>

#include "recon/io/read.hpp"
#include "text_file.hpp"

namespace recon::detail {

// A file as a series of frames: next(), and then either skip() or read().
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Whether there is another frame.
  virtual bool next() = 0;
  // About the frame that next() found. In delimited text skip() and read() count the particles.
  virtual const FrameInfo& info() const = 0;
  virtual void skip() = 0;
  virtual ParticleTable read() = 0;
};

// Converts names to UTF-8, with a remark where they were not.
std::vector<std::string> to_utf8(const std::vector<std::string>& names,
                                 std::vector<std::string>& remarks);

class LammpsFrames : public FrameSource {
 public:
  LammpsFrames(TextFile& file, const ReadOptions& options);
  ~LammpsFrames() override;
  bool next() override;
  const FrameInfo& info() const override;
  void skip() override;
  ParticleTable read() override;

 private:
  struct Header;
  TextFile* file_;
  const ReadOptions* options_;
  std::unique_ptr<Header> header_;
};

// Delimited text is one frame.
class DelimitedFrame : public FrameSource {
 public:
  DelimitedFrame(TextFile& file, const ReadOptions& options) : file_(&file), options_(&options) {}
  bool next() override;
  const FrameInfo& info() const override { return info_; }
  void skip() override;
  ParticleTable read() override;

 private:
  TextFile* file_;
  const ReadOptions* options_;
  FrameInfo info_;
  bool done_ = false;
};

}  // namespace recon::detail
