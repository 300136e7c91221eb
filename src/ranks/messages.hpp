// What ranks send each other of their particles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ranks/votes.hpp"
#include "recon/mpm/particles.hpp"

namespace recon::mpm {

// Of some things on this rank, those for each rank.
using Lists = std::vector<std::vector<std::size_t>>;
using Bytes = std::vector<std::byte>;

// All functions that send are collective and need a vote before: a rank that has failed would not
// come.
template <int D>
class Messages {
 public:
  Messages(Votes& votes, const Kept& kept);

  // What has come from each rank, and how many particles that are.
  struct Arrived {
    std::vector<std::size_t> counts;
    std::vector<Bytes> bytes;
    bool any() const;
  };
  // Whole particles and their numbers, to each rank those of its list.
  Arrived send(const Lists& lists, const Particles<D>& particles,
               const std::vector<std::uint32_t>& numbers);
  // Puts them after those that are there.
  void append(const Arrived& arrived, Particles<D>& to, std::vector<std::uint32_t>& numbers) const;

  // What changes within a step of the particles of the lists, and of as many that come from each
  // rank as `counts` says, in the place of what is there from `at` on.
  void send_changes(const Lists& lists, const std::vector<std::size_t>& counts, std::size_t at,
                    Particles<D>& particles);
  // The same of vectors.
  void send_vectors(const Lists& lists, const std::vector<std::size_t>& counts, std::size_t at,
                    std::vector<Vector<D>>& vectors);

  // Numbers for each rank; what has come from each.
  std::vector<std::vector<double>> send(const std::vector<std::vector<double>>& numbers);

  // That this rank has sent.
  std::int64_t messages = 0, bytes = 0;

 private:
  // How many each rank has for this one, of what goes to each.
  template <class T>
  std::vector<std::size_t> counts_for_here(const std::vector<std::vector<T>>& out);
  std::size_t bytes_of(std::size_t count, bool changing) const;
  void pack(const Particles<D>& particles, bool changing, Bytes& to) const;
  void exchange(const std::vector<Bytes>& out, std::vector<Bytes>& in);

  Votes* votes_;
  Kept kept_;
  std::size_t size_;
};

// Those of `values` with these places.
std::vector<std::uint32_t> chosen(const std::vector<std::uint32_t>& values,
                                  const std::vector<std::size_t>& places);

}  // namespace recon::mpm
