// A neighbour list of your own: validate() accepts a right one and names what is wrong in others.
#include "recon/neighbourhood/neighbour_list.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "neighbourhood/neighbourhood_support.hpp"

namespace recon::testing {
namespace {

template <class Scalar>
NeighbourList<Scalar> good_list() {
  NeighbourList<Scalar> list;
  list.offsets = {0, 2, 2, 5};
  list.indices = {0, 3, 1, 2, 3};
  list.support = {1, Scalar(0.5), 2};
  return list;
}

template <class Scalar>
class OwnList : public ::testing::Test {
 protected:
  template <class Change>
  std::string blamed_after(Change change) {
    auto list = good_list<Scalar>();
    change(list);
    return blamed([&] { list.validate(3, 4); });
  }
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(OwnList, Scalars);

TYPED_TEST(OwnList, RightOnesAreAccepted) {
  const auto list = good_list<TypeParam>();
  EXPECT_NO_THROW(list.validate(3, 4));
  EXPECT_EQ(list.targets(), 3u);
  EXPECT_EQ(list.count(1), 0);
  EXPECT_EQ(list.of(2)[0], 1u);
  EXPECT_NO_THROW(NeighbourList<TypeParam>{}.validate(0, 0));
  EXPECT_EQ(this->blamed_after([](auto& l) { l.shifts.resize(5); }), "");
}

TYPED_TEST(OwnList, WhatIsWrongIsNamed) {
  EXPECT_EQ(this->blamed_after([](auto& l) { l.offsets.push_back(5); }), "number of offsets");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.offsets.clear(); }), "number of offsets");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.offsets[0] = 1; }), "first offset");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.offsets[2] = 1; }), "offset behind target 1");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.offsets[1] = 900; }), "offset behind target 1");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.offsets[3] = 6; }), "last offset");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.indices[3] = 4; }), "neighbour of target 2");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.shifts.resize(4); }), "number of shifts");
  EXPECT_EQ(this->blamed_after([](auto& l) { l.support.pop_back(); }), "number of supports");
  for (const TypeParam bad : {TypeParam(0), TypeParam(-1), TypeParam(NAN), TypeParam(INFINITY)})
    EXPECT_EQ(this->blamed_after([&](auto& l) { l.support[1] = bad; }), "support of target 1")
        << bad;
  for (const TypeParam bad : {TypeParam(0.5), TypeParam(-1), TypeParam(NAN), TypeParam(INFINITY)})
    EXPECT_EQ(this->blamed_after([&](auto& l) { l.support_factor = bad; }),
              "support_factor of the neighbours")
        << bad;
}

TEST(OwnListMessage, HasTargetValueAndRule) {
  auto list = good_list<double>();
  list.indices[3] = 9;
  try {
    list.validate(3, 4);
    FAIL() << "an index of 9 among 4 particles was accepted";
  } catch (const InvalidArgument& error) {
    EXPECT_STREQ(error.what(),
                 "neighbour of target 2 = 9: must be smaller than the number of particles, 4");
  }
}

}  // namespace
}  // namespace recon::testing
