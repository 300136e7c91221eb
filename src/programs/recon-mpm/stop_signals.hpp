// Signals that ask a run to stop.
#pragma once

#include <signal.h>
#include <time.h>

#include <array>

namespace recon::program {

// From catch_them() on, while it lives, SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGUSR1 (which mpirun
// passes on to all ranks) ask the run to stop; another one after half a second or more ends the
// program at once (one sooner is the same again: timeout tells a process and its group). Signals
// that were ignored before (nohup) stay so.
class StopSignals {
 public:
  StopSignals() = default;
  ~StopSignals() {
    for (std::size_t i = 0; i < signals.size() && caught_; ++i)
      sigaction(signals[i], &before_[i], nullptr);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  void catch_them() {
    caught_ = true;
    for (std::size_t i = 0; i < signals.size(); ++i) {
      sigaction(signals[i], nullptr, &before_[i]);
      if (before_[i].sa_handler == SIG_IGN) continue;
      struct sigaction action {};
      action.sa_flags = SA_RESTART;  // what is being read goes on
      action.sa_handler = [](int signal) {
        const double now = seconds();
        if (seen_ == 0) {
          seen_ = signal;
          first_ = now;
        } else if (now - first_ >= 0.5) {
          ::signal(signal, SIG_DFL);
          raise(signal);
        }
      };
      sigaction(signals[i], &action, nullptr);
    }
  }

  static int seen() { return seen_; }  // the signal, or 0

 private:
  static constexpr std::array<int, 4> signals{SIGINT, SIGTERM, SIGHUP, SIGUSR1};
  static double seconds() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  static inline volatile sig_atomic_t seen_ = 0;
  static inline volatile double first_ = 0;
  std::array<struct sigaction, 4> before_{};
  bool caught_ = false;
};

}  // namespace recon::program
