#include "recon/petsc/communicator.hpp"

#include <signal.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <exception>
#include <vector>

#include "petsc/call.hpp"
#include "recon/core/progress.hpp"

namespace recon::petsc {
namespace {

enum class Kind : int { none, invalid, cancelled, call, other };

// What a rank has thrown, as numbers and texts that can be sent.
struct Failure {
  Kind kind = Kind::none;
  int code = 0;
  std::array<std::string, 3> texts;

  static Failure of(const std::function<void()>& work) {
    try {
      work();
      return {};
    } catch (const InvalidArgument& e) {
      return {Kind::invalid, 0, {e.argument(), e.value(), e.rule()}};
    } catch (const Cancelled&) {
      return {Kind::cancelled, 0, {}};
    } catch (const Error& e) {
      const std::string what = e.what();
      const std::string before = e.call() + ": error " + std::to_string(e.code()) + ": ";
      return {Kind::call, e.code(), {e.call(), what.substr(std::min(before.size(), what.size()))}};
    } catch (const std::exception& e) {
      return {Kind::other, 0, {e.what()}};
    } catch (...) {
      return {Kind::other, 0, {"an exception without a text"}};
    }
  }

  void broadcast(MPI_Comm comm, int root) {
    std::array<int, 5> head{static_cast<int>(kind), code};
    for (std::size_t i = 0; i < texts.size(); ++i) head[2 + i] = static_cast<int>(texts[i].size());
    RECON_MPI(MPI_Bcast(head.data(), static_cast<int>(head.size()), MPI_INT, root, comm));
    kind = static_cast<Kind>(head[0]);
    code = head[1];
    for (std::size_t i = 0; i < texts.size(); ++i) {
      texts[i].resize(static_cast<std::size_t>(head[2 + i]));
      RECON_MPI(MPI_Bcast(texts[i].data(), head[2 + i], MPI_CHAR, root, comm));
    }
  }

  [[noreturn]] void raise(int rank) const {
    const std::string where = "rank " + std::to_string(rank) + ": ";
    switch (kind) {
      case Kind::invalid:
        throw InvalidArgument(where + texts[0], texts[1], texts[2]);
      case Kind::cancelled:
        throw Cancelled();
      case Kind::call:
        throw Error(where + texts[0], code, texts[1]);
      default:
        throw std::runtime_error(where + texts[0]);
    }
  }
};

// The same for equal numbers (all zeros count as equal), and hardly ever for others.
std::uint64_t fingerprint(std::initializer_list<double> numbers) {
  std::uint64_t print = numbers.size();
  for (const double number : numbers) {
    print ^= std::bit_cast<std::uint64_t>(number == 0 ? 0.0 : number);
    print *= 0x9e3779b97f4a7c15u;
    print ^= print >> 29;
  }
  return print;
}

}  // namespace

Error::Error(std::string call, int code, const std::string& text)
    : std::runtime_error(call + ": error " + std::to_string(code) + ": " + text),
      call_(std::move(call)),
      code_(code) {}

void check_mpi(const char* text, int code) {
  if (code == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> said{};
  int length = 0;
  MPI_Error_string(code, said.data(), &length);
  throw Error(text, code, std::string(said.data(), static_cast<std::size_t>(length)));
}

bool petsc_is_there() {
  PetscBool begun = PETSC_FALSE, ended = PETSC_FALSE;
  PetscInitialized(&begun);
  PetscFinalized(&ended);
  return begun && !ended;
}

namespace {

// The handlers of signals, which are put back at the end: PETSc sets its own, and leaves none when it
// takes them away.
class SignalHandlers {
 public:
  SignalHandlers() {
    for (int signal = 1; signal < count; ++signal)
      known_[at(signal)] = sigaction(signal, nullptr, &handlers_[at(signal)]) == 0;
  }
  ~SignalHandlers() {
    for (int signal = 1; signal < count; ++signal)
      if (known_[at(signal)]) sigaction(signal, &handlers_[at(signal)], nullptr);
  }
  SignalHandlers(const SignalHandlers&) = delete;
  SignalHandlers& operator=(const SignalHandlers&) = delete;

 private:
  static constexpr int count = 32;  // those that POSIX names
  static std::size_t at(int signal) { return static_cast<std::size_t>(signal); }
  std::array<struct sigaction, count> handlers_{};
  std::array<bool, count> known_{};
};

}  // namespace

Session::Session(int argc, char** argv) {
  if (petsc_is_there()) return;
  // PETSc reads no command line here: it would take a program's own options for unknown ones.
  static std::array<char, 1> no_name{};
  static std::array<char*, 2> no_arguments{no_name.data(), nullptr};
  if (argc > 0) no_arguments[0] = argv[0];
  int count = 1;
  char** arguments = no_arguments.data();
  const SignalHandlers before;
  const PetscErrorCode code = PetscInitialize(&count, &arguments, nullptr, nullptr);
  if (code) throw Error("PetscInitialize", static_cast<int>(code), "PETSc has not begun");
  finalizes_ = true;
  RECON_PETSC(PetscPopSignalHandler());
}

Session::~Session() {
  if (finalizes_ && petsc_is_there()) PetscFinalize();
}

Communicator::Communicator(MPI_Comm comm) {
  detail::require(petsc_is_there(), "PETSc", "not initialised",
                  "must be begun by PetscInitialize or a petsc::Session");
  detail::require(comm != MPI_COMM_NULL, "communicator", "MPI_COMM_NULL", "must have this rank");
  MPI_Comm own = MPI_COMM_NULL;
  RECON_MPI(MPI_Comm_dup(comm, &own));
  comm_ = std::shared_ptr<const MPI_Comm>(new MPI_Comm(own), [](const MPI_Comm* mine) {
    MPI_Comm old = *mine;
    delete mine;
    if (petsc_is_there()) MPI_Comm_free(&old);
  });
  RECON_MPI(MPI_Comm_set_errhandler(own, MPI_ERRORS_RETURN));
  RECON_MPI(MPI_Comm_rank(own, &rank_));
  RECON_MPI(MPI_Comm_size(own, &size_));
}

void Communicator::together(const std::function<void()>& work) const {
  together(work, "arguments", {});
}

void Communicator::together(const std::function<void()>& work, const char* what,
                            std::initializer_list<double> same) const {
  Failure failure = Failure::of(work);
  const std::uint64_t print = fingerprint(same);
  const int place = failure.kind == Kind::none ? size_ : rank_;
  const std::array<std::uint64_t, 3> mine{static_cast<std::uint64_t>(place), print, ~print};
  std::array<std::uint64_t, 3> least{};
  RECON_MPI(MPI_Allreduce(mine.data(), least.data(), 3, MPI_UINT64_T, MPI_MIN, get()));
  const int first = static_cast<int>(least[0]);
  if (first < size_) {
    failure.broadcast(get(), first);
    failure.raise(first);
  }
  detail::require(least[1] == ~least[2], what, "different on some ranks",
                  "must be the same on all ranks");
}

long long Communicator::sum(long long number) const {
  long long all = 0;
  RECON_MPI(MPI_Allreduce(&number, &all, 1, MPI_LONG_LONG, MPI_SUM, get()));
  return all;
}

double Communicator::largest(double number) const {
  double all = 0;
  RECON_MPI(MPI_Allreduce(&number, &all, 1, MPI_DOUBLE, MPI_MAX, get()));
  return all;
}

}  // namespace recon::petsc
