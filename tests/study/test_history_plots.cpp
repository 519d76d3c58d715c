#include "study/history_plots.hpp"

#include <gtest/gtest.h>

namespace pliant::test_history_plots {
namespace {

TEST(FileNames, AreThoseOfColumnsWithoutSignsThatFilesMayNotHave) {
  EXPECT_EQ(file_name_of("tip_z"), "tip_z");
  EXPECT_EQ(file_name_of("max(root_fz)"), "max_root_fz");
  EXPECT_EQ(file_name_of("a/b c"), "a_b_c");
  EXPECT_EQ(file_name_of("end=20 ms"), "end=20_ms");
  EXPECT_EQ(file_name_of("tip_"), "tip_");
}

}  // namespace
}  // namespace pliant::test_history_plots
