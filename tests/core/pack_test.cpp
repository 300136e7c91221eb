// Packs do what numbers do, lane by lane: also where the compiler's library has its faults.
#include "recon/core/pack.hpp"

#include <gtest/gtest.h>

namespace {

template <class T>
class Packs : public ::testing::Test {};
using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Packs, Types);

TYPED_TEST(Packs, SelectTakesEachLaneByItself) {
  using P = recon::Pack<TypeParam>;
  constexpr int lanes = recon::LaneTraits<P>::lanes;
  for (int chosen = 0; chosen < lanes; ++chosen) {
    P a, b, at;
    for (int l = 0; l < lanes; ++l) {
      a[l] = static_cast<TypeParam>(10 + l);
      b[l] = static_cast<TypeParam>(-10 - l);
      at[l] = static_cast<TypeParam>(l);
    }
    const auto mask = at == P(TypeParam(chosen));
    EXPECT_TRUE(recon::detail::any_lane(mask));
    EXPECT_EQ(recon::detail::all_lanes(mask), lanes == 1);
    const P one = recon::detail::select(mask, a, b), small = recon::detail::smaller(a, b),
            large = recon::detail::larger(b, a);
    for (int l = 0; l < lanes; ++l) {
      EXPECT_EQ(static_cast<TypeParam>(one[l]), l == chosen ? 10 + l : -10 - l);
      EXPECT_EQ(static_cast<TypeParam>(small[l]), -10 - l);
      EXPECT_EQ(static_cast<TypeParam>(large[l]), 10 + l);
    }
  }
}

}  // namespace
