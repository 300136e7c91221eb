#include "ranks/votes.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <string>
#include <string_view>

#include "petsc/call.hpp"
#include "recon/mpm/nodes.hpp"
#include "recon/runs/run.hpp"

namespace recon::mpm {
namespace {

enum class Kind : std::int64_t { failure, invalid, file, other_run, no_restart, memory, other };

// E, as all ranks throw it.
template <class E>
struct ToldAs final : E, Told {
  explicit ToldAs(E e) : E(std::move(e)) {}
};

// What a rank has thrown, in numbers and texts that can be sent.
struct Thrown {
  Kind kind = Kind::other;
  std::int64_t step = 0, number = 0, of_node = 0;
  std::array<std::string, 3> texts;

  static Thrown of(Kind kind, const FileError& e) {
    const std::string path = e.path().string(), what = e.what();
    const std::size_t place =
        path.size() + (e.line() > 0 ? 1 + std::to_string(e.line()).size() : 0);
    return {kind,
            0,
            static_cast<std::int64_t>(e.line()),
            0,
            {path, what.substr(std::min(place + 2, what.size()))}};
  }

  static Thrown current() {
    try {
      throw;
    } catch (const OtherRun& e) {
      return of(Kind::other_run, e);
    } catch (const NoRestart& e) {
      return of(Kind::no_restart, e);
    } catch (const FileError& e) {
      return of(Kind::file, e);
    } catch (const std::bad_alloc&) {
      return {Kind::memory, 0, 0, 0, {}};
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
    // Files are the first rank's, where nothing else is said.
    const FileError of_file(texts[0], static_cast<std::size_t>(number),
                            (rank == 0 ? "" : where) + texts[1]);
    switch (kind) {
      case Kind::failure:
        throw ToldAs(Failure(step, of_node ? "node" : "particle", static_cast<std::size_t>(number),
                             where + texts[0]));
      case Kind::invalid:
        throw ToldAs(InvalidArgument(where + texts[0], texts[1], texts[2]));
      case Kind::file:
        throw ToldAs(of_file);
      case Kind::other_run:
        throw ToldAs(OtherRun(of_file));
      case Kind::no_restart:
        throw ToldAs(NoRestart(of_file));
      case Kind::memory:
        throw ToldAs(std::bad_alloc());
      case Kind::other:
        break;
    }
    throw ToldAs(std::runtime_error(where + texts[0]));
  }
};

}  // namespace

void Votes::together(const std::function<void()>& work) {
  try {
    work();
  } catch (const Told&) {
    throw;
  } catch (...) {
    hold(true, 0);  // throws
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
  Thrown thrown;
  if (failed && first == ranks_.rank()) thrown = Thrown::current();
  thrown.broadcast(ranks_.get(), first);
  thrown.raise(first);
}

}  // namespace recon::mpm
