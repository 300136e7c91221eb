// Programs that were started several times at once.
#include "run_program.hpp"

namespace recon::test {
namespace {

class StartedByMpirun : public ProgramTest {};

TEST_F(StartedByMpirun, OtherCommandsAreForOneProcess) {
  const Outcome first =
      shell("OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=2 '" + program() + "' info \"$CHUTE\"");
  EXPECT_EQ(first.code, 1);
  EXPECT_THAT(first.err, testing::HasSubstr("recon: info is for one process, and 2 were started"));
  const Outcome second =
      shell("OMPI_COMM_WORLD_RANK=1 OMPI_COMM_WORLD_SIZE=2 '" + program() + "' info \"$CHUTE\"");
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.err, testing::HasSubstr("recon: rank 1: info is for one process"))
      << "the first may not have failed";
}

}  // namespace
}  // namespace recon::test
