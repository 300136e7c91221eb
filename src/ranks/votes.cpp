#include "ranks/votes.hpp"

#include <array>
#include <limits>
#include <string>
#include <string_view>

#include "petsc/call.hpp"
#include "recon/mpm/nodes.hpp"

namespace recon::mpm {
namespace {

enum class Kind : std::int64_t { failure, invalid, other };

// What a rank has thrown, in numbers and texts that can be sent.
struct Thrown {
  Kind kind = Kind::other;
  std::int64_t step = 0, number = 0, of_node = 0;
  std::array<std::string, 3> texts;

  static Thrown current() {
    try {
      throw;
    } catch (const Failure& e) {
      return {Kind::failure,
              e.step(),
              static_cast<std::int64_t>(e.number()),
              std::string_view(e.place()) == "node",
              {e.reason()}};
    } catch (const InvalidArgument& e) {
      return {Kind::invalid, 0, 0, 0, {e.argument(), e.value(), e.rule()}};
    } catch (const std::exception& e) {
      return {Kind::other, 0, 0, 0, {e.what()}};
    } catch (...) {
      return {Kind::other, 0, 0, 0, {"an exception without a text"}};
    }
  }

  void broadcast(MPI_Comm comm, int root) {
    std::array<std::int64_t, 7> head{static_cast<std::int64_t>(kind), step, number, of_node};
    for (std::size_t i = 0; i < texts.size(); ++i)
      head[4 + i] = static_cast<std::int64_t>(texts[i].size());
    RECON_MPI(MPI_Bcast(head.data(), static_cast<int>(head.size()), MPI_INT64_T, root, comm));
    kind = static_cast<Kind>(head[0]);
    step = head[1];
    number = head[2];
    of_node = head[3];
    for (std::size_t i = 0; i < texts.size(); ++i) {
      texts[i].resize(static_cast<std::size_t>(head[4 + i]));
      RECON_MPI(
          MPI_Bcast(texts[i].data(), static_cast<int>(texts[i].size()), MPI_CHAR, root, comm));
    }
  }

  [[noreturn]] void raise(int rank) const {
    const std::string where = "rank " + std::to_string(rank) + ": ";
    if (kind == Kind::failure)
      throw Failure(step, of_node ? "node" : "particle", static_cast<std::size_t>(number),
                    where + texts[0]);
    if (kind == Kind::invalid) throw InvalidArgument(where + texts[0], texts[1], texts[2]);
    throw std::runtime_error(where + texts[0]);
  }
};

}  // namespace

void Votes::together(const std::function<void()>& work) {
  told_ = false;
  try {
    work();
  } catch (...) {
    if (!told_) hold(true, 0);
    throw;  // hold() has thrown what all throw, unless it was thrown before
  }
  hold(false, 0);
}

double Votes::vote(double number) {
  return hold(false, number);
}

double Votes::hold(bool failed, double number) {
  ++rounds;
  // The largest of what says who has failed first, and of the number.
  const std::array<double, 2> mine{
      failed ? static_cast<double>(ranks_.size() - ranks_.rank()) : 0.0, number};
  std::array<double, 2> most{};
  RECON_MPI(MPI_Allreduce(mine.data(), most.data(), 2, MPI_DOUBLE, MPI_MAX, ranks_.get()));
  if (most[0] == 0) return most[1];
  const int first = ranks_.size() - static_cast<int>(most[0]);
  told_ = true;
  Thrown thrown;
  if (failed && first == ranks_.rank()) thrown = Thrown::current();
  thrown.broadcast(ranks_.get(), first);
  thrown.raise(first);
}

}  // namespace recon::mpm
