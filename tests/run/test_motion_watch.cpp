// Every law says how far it may be stretched; runs that go beyond: tests/program/test_errors.py.
#include "material/elastic_law.hpp"
#include "run/motion_watch.hpp"

#include <gtest/gtest.h>

namespace pliant::test_motion_watch {
namespace {

TEST(TrustedStretches, AreKnownOfEveryLaw) {
  for (const LawInfo& law : elastic_laws()) {
    const auto range = trusted_stretches(law.name);
    ASSERT_TRUE(range.has_value()) << law.name;
    EXPECT_LT(range->low, 1.0) << law.name;
    EXPECT_GT(range->high, 1.0) << law.name;
    EXPECT_FALSE(range->why.empty()) << law.name;
  }
  EXPECT_FALSE(trusted_stretches("none").has_value());
}

}  // namespace
}  // namespace pliant::test_motion_watch
