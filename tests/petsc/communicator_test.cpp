// Failing together, and the codes of PETSc and MPI as exceptions.
#include <petscdmda.h>
#include <signal.h>

#include "petsc/petsc_support.hpp"
#include "recon/core/progress.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

TEST(Session, LeavesHandlersOfSignalsAlone) {
  struct sigaction now {};
  ASSERT_EQ(sigaction(SIGURG, nullptr, &now), 0);
  EXPECT_EQ(now.sa_handler, handler_of_before);
}

TEST(Together, NobodyThrowsWhereNobodyFails) {
  int done = 0;
  EXPECT_NO_THROW(world().together([&] { ++done; }));
  EXPECT_EQ(done, 1);
}

TEST(Together, AllThrowWhatOneThrows) {
  const int last = world().size() - 1;
  try {
    world().together([&] {
      if (world().rank() == last) detail::throw_invalid("speed", -1, "must be positive");
    });
    FAIL() << "nothing was thrown";
  } catch (const InvalidArgument& e) {
    EXPECT_EQ(e.argument(), "rank " + std::to_string(last) + ": speed");
    EXPECT_EQ(e.value(), "-1");
    EXPECT_EQ(e.rule(), "must be positive");
  }
}

TEST(Together, TheLowestRankIsHeard) {
  const auto all_fail = [] {
    world().together(
        [] { detail::throw_invalid("number", world().rank(), "must not be that of a rank"); });
  };
  EXPECT_EQ(refusal(all_fail), "rank 0: number = 0: must not be that of a rank");
}

TEST(Together, TypesAreKept) {
  const auto throws = [](const auto& what) {
    world().together([&] {
      if (world().rank() == 0) throw what;
    });
  };
  EXPECT_THROW(throws(Cancelled()), Cancelled);
  EXPECT_THROW(throws(std::bad_alloc()), std::runtime_error);
  EXPECT_THROW(throws(42), std::runtime_error);
  try {
    throws(petsc::Error("SomeCall(a)", 63, "out of range"));
    FAIL();
  } catch (const petsc::Error& e) {
    EXPECT_EQ(e.code(), 63);
    EXPECT_EQ(std::string(e.what()), "rank 0: SomeCall(a): error 63: out of range");
  }
}

TEST(Together, WhatDiffersIsRefusedOnAll) {
  const auto call = [](double number) { world().together([] {}, "answer", {1, number}); };
  EXPECT_NO_THROW(call(42));
  if (world().size() == 1) return;
  const std::string said = refusal([&] { call(world().rank() == 1 ? 41 : 42); });
  EXPECT_THAT(said, HasSubstr("answer = different on some ranks"));
}

TEST(Communicator, FailuresOfMpiAreReturned) {
  int number = 0;
  const int code = MPI_Bcast(&number, 1, MPI_INT, world().size(), world().get());
  EXPECT_NE(code, MPI_SUCCESS);
}

TEST(Communicator, NoCommunicatorIsRefused) {
  EXPECT_THAT(refusal([] { petsc::Communicator nobody(MPI_COMM_NULL); }),
              HasSubstr("communicator = MPI_COMM_NULL"));
}

TEST(Communicator, SumsAndLargest) {
  const int n = world().size();
  EXPECT_EQ(world().sum(world().rank()), n * (n - 1) / 2);
  EXPECT_EQ(world().largest(-world().rank()), 0);
}

}  // namespace
}  // namespace recon::testing
