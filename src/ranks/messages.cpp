#include "ranks/messages.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "petsc/call.hpp"
#include "recon/mpm/parts.hpp"

namespace recon::mpm {
namespace {

template <class T>
void put(const std::vector<T>& values, Bytes& to) {
  static_assert(std::is_trivially_destructible_v<T>);
  const std::size_t begin = to.size(), length = values.size() * sizeof(T);
  to.resize(begin + length);
  if (length > 0) std::memcpy(to.data() + begin, static_cast<const void*>(values.data()), length);
}

// Reads `count` values into those from `at` on, and moves on.
template <class T>
void take(const std::byte*& from, std::size_t count, std::size_t at, std::vector<T>& to) {
  if (count > 0) std::memcpy(static_cast<void*>(to.data() + at), from, count * sizeof(T));
  from += count * sizeof(T);
}

// Whether an array changes within a step in a way that copies need.
bool changes(const char* array) {
  for (const std::string_view name : {"x", "v", "F", "L", "stress", "corners", "modes"})
    if (name == array) return true;
  return false;
}

}  // namespace

std::vector<std::uint32_t> chosen(const std::vector<std::uint32_t>& values,
                                  const std::vector<std::size_t>& places) {
  std::vector<std::uint32_t> some;
  some.reserve(places.size());
  for (const std::size_t p : places) some.push_back(values[p]);
  return some;
}

template <int D>
Messages<D>::Messages(Votes& votes, const Kept& kept)
    : votes_(&votes), kept_(kept), size_(static_cast<std::size_t>(votes.ranks().size())) {}

template <int D>
bool Messages<D>::Arrived::any() const {
  return std::any_of(counts.begin(), counts.end(), [](std::size_t count) { return count > 0; });
}

template <int D>
template <class T>
std::vector<std::size_t> Messages<D>::counts_for_here(const std::vector<std::vector<T>>& out) {
  std::vector<std::int64_t> mine(size_), others(size_);
  for (std::size_t r = 0; r < size_; ++r) mine[r] = static_cast<std::int64_t>(out[r].size());
  RECON_MPI(MPI_Alltoall(mine.data(), 1, MPI_INT64_T, others.data(), 1, MPI_INT64_T,
                         votes_->ranks().get()));
  ++votes_->rounds;
  return {others.begin(), others.end()};
}

template <int D>
auto Messages<D>::send(const Lists& lists, const Particles<D>& particles,
                       const std::vector<std::uint32_t>& numbers) -> Arrived {
  Arrived arrived{counts_for_here(lists), std::vector<Bytes>(size_)};
  std::vector<Bytes> out(size_);
  for (std::size_t r = 0; r < size_; ++r) {
    arrived.bytes[r].resize(bytes_of(arrived.counts[r], false));
    if (lists[r].empty()) continue;
    pack(chosen(particles, kept_, lists[r]), false, out[r]);
    put(chosen(numbers, lists[r]), out[r]);
  }
  exchange(out, arrived.bytes);
  return arrived;
}

template <int D>
std::vector<std::vector<double>> Messages<D>::send(
    const std::vector<std::vector<double>>& numbers) {
  const std::vector<std::size_t> counts = counts_for_here(numbers);
  std::vector<Bytes> out(size_), in(size_);
  for (std::size_t r = 0; r < size_; ++r) {
    put(numbers[r], out[r]);
    in[r].resize(counts[r] * sizeof(double));
  }
  exchange(out, in);
  std::vector<std::vector<double>> arrived(size_);
  for (std::size_t r = 0; r < size_; ++r) {
    arrived[r].resize(counts[r]);
    const std::byte* read = in[r].data();
    take(read, arrived[r].size(), 0, arrived[r]);
  }
  return arrived;
}

template <int D>
void Messages<D>::append(const Arrived& arrived, Particles<D>& to,
                         std::vector<std::uint32_t>& numbers) const {
  for (std::size_t r = 0; r < size_; ++r) {
    const std::size_t count = arrived.counts[r], before = numbers.size();
    if (count == 0) continue;
    const std::byte* read = arrived.bytes[r].data();
    Particles<D> more;
    more.arrays(kept_, [&](const ParticleArray& array, auto& values) {
      values.resize(count * array.per_particle);
      take(read, values.size(), 0, values);
    });
    mpm::append(more, kept_, to);
    numbers.resize(before + count);
    take(read, count, before, numbers);
  }
}

template <int D>
void Messages<D>::send_changes(const Lists& lists, const std::vector<std::size_t>& counts,
                               std::size_t at, Particles<D>& particles) {
  std::vector<Bytes> out(size_), in(size_);
  for (std::size_t r = 0; r < size_; ++r) {
    if (!lists[r].empty()) pack(chosen(particles, kept_, lists[r]), true, out[r]);
    in[r].resize(bytes_of(counts[r], true));
  }
  exchange(out, in);
  for (std::size_t r = 0; r < size_; at += counts[r], ++r) {
    const std::byte* read = in[r].data();
    particles.arrays(kept_, [&](const ParticleArray& array, auto& values) {
      const std::size_t each = array.per_particle;
      if (changes(array.name)) take(read, counts[r] * each, at * each, values);
    });
  }
}

template <int D>
void Messages<D>::send_vectors(const Lists& lists, const std::vector<std::size_t>& counts,
                               std::size_t at, std::vector<Vector<D>>& vectors) {
  std::vector<Bytes> out(size_), in(size_);
  for (std::size_t r = 0; r < size_; ++r) {
    std::vector<Vector<D>> values;
    for (const std::size_t p : lists[r]) values.push_back(vectors[p]);
    put(values, out[r]);
    in[r].resize(counts[r] * sizeof(Vector<D>));
  }
  exchange(out, in);
  for (std::size_t r = 0; r < size_; at += counts[r], ++r) {
    const std::byte* read = in[r].data();
    take(read, counts[r], at, vectors);
  }
}

// All arrays of particles one after the other, or those that change alone.
template <int D>
void Messages<D>::pack(const Particles<D>& particles, bool changing, Bytes& to) const {
  particles.arrays(kept_, [&](const ParticleArray& array, const auto& values) {
    if (!changing || changes(array.name)) put(values, to);
  });
}

// Of so many particles; with their numbers where all arrays are sent.
template <int D>
std::size_t Messages<D>::bytes_of(std::size_t count, bool changing) const {
  std::size_t length = changing ? 0 : count * sizeof(std::uint32_t);
  Particles<D>().arrays(kept_, [&](const ParticleArray& array, const auto& values) {
    using T = typename std::decay_t<decltype(values)>::value_type;
    if (!changing || changes(array.name)) length += count * array.per_particle * sizeof(T);
  });
  return length;
}

// Sends to and receives from all ranks for which there is something.
template <int D>
void Messages<D>::exchange(const std::vector<Bytes>& out, std::vector<Bytes>& in) {
  constexpr std::size_t most = std::size_t{1} << 30;  // of one message, in whose int it must fit
  std::vector<MPI_Request> requests;
  const MPI_Comm comm = votes_->ranks().get();
  const auto in_pieces = [&](std::size_t length, const auto& piece) {
    for (std::size_t begin = 0; begin < length; begin += most)
      piece(begin, static_cast<int>(std::min(most, length - begin)));
  };
  for (std::size_t r = 0; r < size_; ++r)
    in_pieces(in[r].size(), [&](std::size_t begin, int length) {
      requests.emplace_back();
      RECON_MPI(MPI_Irecv(in[r].data() + begin, length, MPI_BYTE, static_cast<int>(r), 0, comm,
                          &requests.back()));
    });
  for (std::size_t r = 0; r < size_; ++r)
    in_pieces(out[r].size(), [&](std::size_t begin, int length) {
      requests.emplace_back();
      RECON_MPI(MPI_Isend(out[r].data() + begin, length, MPI_BYTE, static_cast<int>(r), 0, comm,
                          &requests.back()));
      ++messages;
      bytes += length;
    });
  RECON_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
}

template class Messages<1>;
template class Messages<2>;
template class Messages<3>;

}  // namespace recon::mpm
