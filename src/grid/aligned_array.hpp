// An array of numbers that starts at a cache line, zero at first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

namespace recon {

template <class Scalar>
class AlignedArray {
 public:
  explicit AlignedArray(std::size_t size = 0) { reset(size); }

  // Zeros, `size` of them; memory is kept if it suffices.
  void reset(std::size_t size) {
    if (size > capacity_) {
      data_.reset();
      data_.reset(static_cast<Scalar*>(::operator new(size * sizeof(Scalar), line)));
      capacity_ = size;
    }
    std::fill_n(data_.get(), size, Scalar(0));
  }
  Scalar* data() const { return data_.get(); }

 private:
  static constexpr std::align_val_t line{64};
  struct Free {
    void operator()(Scalar* memory) const { ::operator delete(memory, line); }
  };
  std::unique_ptr<Scalar[], Free> data_;
  std::size_t capacity_ = 0;
};

}  // namespace recon
