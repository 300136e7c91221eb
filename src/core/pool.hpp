// Objects with buffers that are lent to blocks of parallel loops, and kept for the next loop.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace recon::detail {

// Thread-safe. An object goes back when its loan ends, as it is then.
template <class T>
class Pool {
 public:
  class Loan {
   public:
    Loan(Pool& pool, std::unique_ptr<T> object) : pool_(pool), object_(std::move(object)) {}
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    ~Loan() { pool_.give_back(std::move(object_)); }
    T& operator*() const { return *object_; }
    T* operator->() const { return object_.get(); }

   private:
    Pool& pool_;
    std::unique_ptr<T> object_;
  };

  // An object that nobody holds, or make(), a std::unique_ptr<T>.
  template <class Make>
  Loan lend(const Make& make) {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<T> object = std::move(free_.back());
        free_.pop_back();
        return {*this, std::move(object)};
      }
      free_.reserve(++made_);  // so that going back cannot fail
    }
    return {*this, make()};
  }
  Loan lend() {
    return lend([] { return std::make_unique<T>(); });
  }

  // Destroys the objects that nobody holds.
  void clear() {
    const std::lock_guard lock(mutex_);
    made_ -= free_.size();
    free_.clear();
  }

 private:
  void give_back(std::unique_ptr<T> object) noexcept {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(object));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
  std::size_t made_ = 0;
};

}  // namespace recon::detail
