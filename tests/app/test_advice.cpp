// What an input may mean, but seldom does, is told with its place; what is usual is not. What only a mesh tells:
// tests/program/test_errors.py.
#include "app/advice.hpp"
#include "app/bad_input.hpp"

#include <gtest/gtest.h>

namespace pliant::test_advice {
namespace {

std::vector<std::string> doubts(const std::string& time, const std::string& more, const std::string& every = "") {
  return doubts_about(
      read_input(test::with_line(5, "time: {" + time + "}") + more, "dir/a.yaml",
                 every.empty() ? std::vector<Override>{} : std::vector<Override>{{"output.every", every}}));
}

TEST(Advice, StepsShouldNotBeLongerThanTheTimeBetweenFrames) {
  const auto told = doubts("step: 0.01, end: 1", "output: {every: 4 ms}");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].find("dir/a.yaml:6:17: "), 0u) << told[0];
  EXPECT_NE(told[0].find("every 0.004 s, but a step takes 0.01 s"), std::string::npos) << told[0];
  EXPECT_EQ(doubts("method: quasistatic, step: 0.01, end: 1", "output: {every: 4 ms}").size(), 1u);
  EXPECT_EQ(doubts("step: 0.01, end: 1", "", "0.004").size(), 1u);
}

TEST(Advice, StepFilesNeedNoScale) {
  const auto told = [](const std::string& mesh) {
    return doubts_about(read_input(test::with_line(1, "mesh: {" + mesh + "}"), "a.yaml", {}));
  };
  ASSERT_EQ(told("file: a.step, scale: 0.001").size(), 1u);
  EXPECT_EQ(told("file: a.step, scale: 0.001")[0].find("a.yaml:1:14: a STEP file"), 0u);
  EXPECT_EQ(told("file: a.step"), std::vector<std::string>{});
  EXPECT_EQ(told("file: a.step, scale: 2"), std::vector<std::string>{});
  EXPECT_EQ(told("file: a.geo, scale: 0.001"), std::vector<std::string>{});
}

TEST(Advice, NothingIsSaidOfWhatIsUsual) {
  EXPECT_EQ(doubts("step: 0.01, end: 1", ""), std::vector<std::string>{});
  EXPECT_EQ(doubts("step: 0.01, end: 1", "output: {every: 0.01}"), std::vector<std::string>{});
  EXPECT_EQ(doubts("step: 0.3, end: 1", "output: {every: 100 ms, directory: b}", "0.3"), std::vector<std::string>{});
  EXPECT_EQ(doubts("adaptive: {}, step: 0.01, end: 1", "output: {every: 1 ms}"), std::vector<std::string>{});
  EXPECT_EQ(doubts("method: static", "output: {every: 1 ms}"), std::vector<std::string>{});
}

}  // namespace
}  // namespace pliant::test_advice
