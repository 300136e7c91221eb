// Signals that ask a run to stop.
#pragma once

#include <signal.h>

#include <array>

namespace recon::program {

// From catch_them() on, while it lives, SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGUSR1 (which mpirun
// passes on to all ranks) ask the run to stop; a second one ends the program at once. Signals that
// were ignored before (nohup) stay so.
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
      action.sa_handler = [](int signal) {
        seen_ = signal;
        for (const int each : signals) ::signal(each, SIG_DFL);
      };
      sigaction(signals[i], &action, nullptr);
    }
  }

  static int seen() { return seen_; }  // the signal, or 0

 private:
  static constexpr std::array<int, 4> signals{SIGINT, SIGTERM, SIGHUP, SIGUSR1};
  static inline volatile sig_atomic_t seen_ = 0;
  std::array<struct sigaction, 4> before_{};
  bool caught_ = false;
};

}  // namespace recon::program
