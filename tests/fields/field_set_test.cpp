#include "recon/fields/field_set.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "recon/core/error.hpp"
#include "support/nan.hpp"

namespace {

using recon::FieldSet;
using recon::InvalidArgument;
using recon::NamedField;
using recon::nan;
using recon::NumberType;

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

TEST(FieldSet, PlacesOfComponents) {
  using recon::FieldKind;
  const auto places = [](int components, int dimension, FieldKind kind = FieldKind::by_components) {
    const auto found = recon::component_places({"f", components, {}, {}, kind}, dimension);
    return std::vector<int>(found.from.begin(), found.from.begin() + found.places);
  };
  using testing::ElementsAre;
  EXPECT_THAT(places(2, 2), ElementsAre(0, 1, -1));
  EXPECT_THAT(places(3, 3), ElementsAre(0, 1, 2));
  EXPECT_THAT(places(4, 2), ElementsAre(0, 1, -1, 2, 3, -1, -1, -1, -1));
  EXPECT_THAT(places(9, 3), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(places(3, 2), ElementsAre());
  EXPECT_THAT(places(1, 1), ElementsAre());
  EXPECT_THAT(places(1, 1, FieldKind::vector), ElementsAre(0, -1, -1));
  EXPECT_THAT(places(3, 2, FieldKind::vector), ElementsAre(0, 1, 2));
  EXPECT_THAT(places(2, 2, FieldKind::scalars), ElementsAre());
  EXPECT_THAT(places(3, 2, FieldKind::symmetric_tensor),
              ElementsAre(0, 1, -1, 1, 2, -1, -1, -1, -1));
  EXPECT_THAT(places(6, 2, FieldKind::symmetric_tensor), ElementsAre(0, 1, 2, 1, 3, 4, 2, 4, 5));
  EXPECT_THAT(places(9, 1, FieldKind::tensor), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_EQ(recon::name_of_place(2, 3), "z");
  EXPECT_EQ(recon::name_of_place(5, 9), "yz");
  EXPECT_THROW(places(1, 2, FieldKind::vector), InvalidArgument);
  EXPECT_THROW(places(3, 2, FieldKind::tensor), InvalidArgument);
  EXPECT_THROW(places(4, 2, FieldKind::symmetric_tensor), InvalidArgument);
}

TEST(FieldSet, WrongFields) {
  FieldSet fields;
  fields.add("p", 1, {1});
  EXPECT_THROW(fields.add("p", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("a\nb", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("v\xb2", 1, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("v", 0, {1}), InvalidArgument);
  EXPECT_THROW(fields.add("v", 2, {1, 2, 3}), InvalidArgument);
  for (const double value : {2.5, nan, 3e9, -3e9})
    EXPECT_THROW(fields.add("n", 1, {value}, NumberType::int32), InvalidArgument) << value;
  EXPECT_THROW(fields.add("f", 1, {1e300}, NumberType::float32), InvalidArgument);
  EXPECT_NO_THROW(fields.add("f", 1, {nan}, NumberType::float32));
  EXPECT_EQ(fields.size(), 2u);
}

}  // namespace
