// The arrays of the particles (Particles::arrays()) in the memory of an executor (cuda/host.hpp).
#pragma once

#include <string_view>
#include <type_traits>
#include <vector>

#include "recon/mpm/particles.hpp"

namespace recon::mpm {

// Their addresses: vectors and matrices are numbers in a row, as on the processor.
template <int D>
struct ParticleNumbers {
  double *x, *X, *v, *F, *L, *stress, *half_edges, *mass, *volume0, *energy;
  std::int32_t* body;
  double *corners, *modes,
      *history;  // those that this method and these materials do not keep: null
};

template <class Executor, int D>
class ParticleArrays {
 public:
  void put(Executor& run, const Particles<D>& from, const Kept& kept) {
    count_ = from.size();
    arrays_.resize(0);
    from.arrays(kept, [&]<class T>(const ParticleArray& of, const std::vector<T>& values) {
      static_assert(std::is_same_v<T, std::int32_t> || sizeof(T) % sizeof(double) == 0);
      Bytes& own = arrays_.emplace_back();
      own.name = of.name;
      own.size = values.size() * sizeof(T);
      run.provide(own.memory, own.size);
      run.to_device(reinterpret_cast<const unsigned char*>(values.data()), own.memory.data(),
                    own.size);
    });
  }
  // All arrays of `to`, which has those of as many particles.
  void bring(Executor& run, Particles<D>& to, const Kept& kept) const {
    auto own = arrays_.begin();
    to.arrays(kept, [&](const ParticleArray&, auto& values) {
      run.to_host(own->memory.data(), reinterpret_cast<unsigned char*>(values.data()), own->size);
      ++own;
    });
  }

  std::size_t size() const { return count_; }
  ParticleNumbers<D> numbers() {
    return {of<double>("x"),          of<double>("X"),          of<double>("v"),
            of<double>("F"),          of<double>("L"),          of<double>("stress"),
            of<double>("half_edges"), of<double>("mass"),       of<double>("volume0"),
            of<double>("energy"),     of<std::int32_t>("body"), of<double>("corners"),
            of<double>("modes"),      of<double>("history")};
  }

 private:
  struct Bytes {
    std::string_view name;
    std::size_t size = 0;
    typename Executor::template Array<unsigned char> memory;
  };
  template <class T>
  T* of(std::string_view name) {
    for (Bytes& each : arrays_)
      if (each.name == name) return each.size ? reinterpret_cast<T*>(each.memory.data()) : nullptr;
    return nullptr;
  }

  std::size_t count_ = 0;
  std::vector<Bytes> arrays_;
};

}  // namespace recon::mpm
