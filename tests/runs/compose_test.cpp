// Methods as texts: rows with other choices.
#include "recon/runs/compose.hpp"

#include <gtest/gtest.h>

#include <set>

namespace recon::mpm::test {
namespace {

template <class Work>
std::string blamed(const Work& work) {
  try {
    work();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

// A row with other choices, by key or by word.
TEST(Composition, IsARowWithOtherChoices) {
  const Method method = composed("cpdi1+velocity=affine+flip+blend=0.05+stress=musl+degree=2");
  EXPECT_EQ(method.name, "cpdi1+velocity=affine+flip+blend=0.05+stress=musl+degree=2");
  EXPECT_EQ(method.domain, Domain::cpdi1);
  EXPECT_EQ(method.velocity, VelocityMap::affine);
  EXPECT_EQ(method.update, Update::flip);
  EXPECT_EQ(method.blend, 0.05);
  EXPECT_EQ(method.stress, StressUpdate::musl);
  EXPECT_EQ(method.degree, 2);
  EXPECT_EQ(composed("cpls").velocity, VelocityMap::cpls);
  const Method flags = composed("mpm+momentum_correction=true+negative_mass=stop");
  EXPECT_TRUE(flags.momentum_correction);
  EXPECT_EQ(flags.at_negative_mass, AtNegativeMass::stop);
  for (const auto& [text, words] : std::vector<std::pair<const char*, std::vector<const char*>>>{
           {"cpdi", {"method", "cpdi1"}},
           {"cpdi1+afine", {"afine", "affine"}},
           {"cpdi1+velocty=affine", {"velocty", "velocity"}},
           {"cpdi1+velocity=afine", {"velocity", "afine", "affine"}},
           {"cpdi1+blend=much", {"blend", "much", "number"}},
           {"cpdi1+blend=1e400", {"blend", "number"}},
           {"cpdi1+degree=1.5", {"degree", "whole number"}},
           {"cpdi1+momentum_correction=1", {"momentum_correction", "true"}},
           {"cpdi1+", {"choice of a method"}},
           {"", {"method"}}}) {
    const std::string what = blamed([&, given = text] { composed(given); });
    for (const char* word : words)
      EXPECT_NE(what.find(word), std::string::npos) << text << ": " << what;
  }
}

// Every key can be read back, and short words are unique.
TEST(Composition, KeysAreComplete) {
  std::set<std::string> words;
  for (const std::string& key : method_keys()) {
    Method method = method_named("mpm");
    for (const std::string& word : words_of(key)) {
      EXPECT_TRUE(words.insert(word).second) << word;
      set_choice(method, key, word);
      EXPECT_EQ(choice_text(method, key), word);
    }
  }
  Method method;
  for (const auto& [key, value] : {std::pair{"blend", "0.125"},
                                   {"degree", "2"},
                                   {"order", "7"},
                                   {"momentum_correction", "true"}}) {
    set_choice(method, key, value);
    EXPECT_EQ(choice_text(method, key), value);
  }
  EXPECT_TRUE(words_of("blend").empty());
  EXPECT_THROW(words_of("blent"), InvalidArgument);
  EXPECT_THROW(choice_text(method, "blent"), InvalidArgument);
  for (const Method& row : methods()) {  // a row is what its keys say
    Method made = method_named("mpm");
    for (const std::string& key : method_keys()) set_choice(made, key, choice_text(row, key));
    for (const std::string& key : method_keys())
      EXPECT_EQ(choice_text(made, key), choice_text(row, key));
  }
}

}  // namespace
}  // namespace recon::mpm::test
