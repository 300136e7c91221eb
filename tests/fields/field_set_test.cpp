#include "recon/fields/field_set.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "recon/core/error.hpp"

namespace {

using recon::FieldSet;
using recon::InvalidArgument;
using recon::NamedField;
using recon::NumberType;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(NamedField, ViewIsPointMajor) {
  const NamedField field{"v", 2, {1, 2, 3, 4}, NumberType::float64};
  EXPECT_EQ(field.size(), 2u);
  EXPECT_EQ(field.view()(1, 0), 3);
  EXPECT_EQ(field.view().components(), 2);
}

TEST(NamedField, Suffixes) {
  const NamedField scalar{"p", 1, {}, {}}, vector{"v", 2, {}, {}};
  EXPECT_EQ(recon::component_suffix(scalar, 0, 1), "");
  EXPECT_EQ(recon::component_suffix(vector, 1, 2), "_y");
  EXPECT_EQ(recon::component_suffix(vector, 1, 3), "_1");
}

TEST(FieldSet, AddAndFind) {
  FieldSet fields;
  EXPECT_TRUE(fields.empty());
  fields.add("density", 1, {1, nan});
  fields.add("rank", 1, {3, -2147483647}, NumberType::int32);
  EXPECT_EQ(fields.size(), 2u);
  EXPECT_EQ(fields["rank"].values[0], 3);
  EXPECT_NO_THROW(fields.require_size(2));
  EXPECT_THROW(fields.require_size(3), InvalidArgument);
  try {
    fields["densty"];
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'density'?"));
  }
}

TEST(FieldSet, WrongFields) {
  FieldSet fields;
  fields.add("p", 1, {1});
  EXPECT_THROW(fields.add("p", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("a\nb", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("v", 0, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("v", 2, {1, 2, 3}), InvalidArgument);
  for (const double value : {2.5, nan, 3e9, -3e9})
    EXPECT_THROW(fields.add("n", 1, {value}, NumberType::int32), InvalidArgument) << value;
  EXPECT_THROW(fields.add("f", 1, {1e300}, NumberType::float32), InvalidArgument);
  EXPECT_NO_THROW(fields.add("f", 1, {nan}, NumberType::float32));
  EXPECT_EQ(fields.size(), 2u);
}

}  // namespace
