#include "recon/core/instruction_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "recon/core/error.hpp"

namespace {

using recon::InstructionSet;

TEST(InstructionSet, GenericIsAlwaysThereAndAutomaticIsTheLast) {
  const auto sets = recon::available_instruction_sets();
  ASSERT_FALSE(sets.empty());
  EXPECT_EQ(sets.front(), InstructionSet::generic);
  EXPECT_TRUE(std::is_sorted(sets.begin(), sets.end()));
  EXPECT_EQ(recon::resolved(InstructionSet::automatic), sets.back());
  for (const auto set : sets) EXPECT_EQ(recon::resolved(set), set);
}

TEST(InstructionSet, OneThatIsNotThereIsRefusedByName) {
  const auto sets = recon::available_instruction_sets();
  for (const auto set : {InstructionSet::avx2, InstructionSet::avx512}) {
    if (std::find(sets.begin(), sets.end(), set) != sets.end()) continue;
    try {
      recon::resolved(set);
      ADD_FAILURE() << recon::name_of(set);
    } catch (const recon::InvalidArgument& error) {
      EXPECT_EQ(error.argument(), "instruction_set");
      EXPECT_EQ(error.value(), recon::name_of(set));
      EXPECT_NE(error.rule().find("generic"), std::string::npos);
    }
  }
}

}  // namespace
