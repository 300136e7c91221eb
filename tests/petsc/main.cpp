// All ranks run all tests. The first one reports; the others speak of their failures only. All of
// them end with the status of the worst.
#include <gtest/gtest.h>
#include <petscsys.h>
#include <signal.h>

#include <cstdio>

#include "petsc/petsc_support.hpp"

namespace {

class Failures : public testing::EmptyTestEventListener {
 public:
  explicit Failures(int rank) : rank_(rank) {}

 private:
  void OnTestPartResult(const testing::TestPartResult& part) override {
    if (part.failed())
      std::fprintf(stderr, "rank %d: %s:%d: %s\n", rank_, part.file_name() ? part.file_name() : "",
                   part.line_number(), part.message());
  }
  int rank_;
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  signal(SIGURG, recon::testing::handler_of_before);
  const recon::petsc::Session session(argc, argv);
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank > 0) {
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new Failures(rank));
  }
  int status = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &status, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return status;
}
