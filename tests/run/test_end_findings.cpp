// What the solves of a run as a whole show at its end.
#include "input/bad_input.hpp"
#include "run/end_findings.hpp"

#include <gtest/gtest.h>

namespace pliant::test_end_findings {
namespace {

std::string finding(const std::string& more) {
  SolverStatistics statistics;
  statistics.stages = 30;
  statistics.rounding_stops = 12;
  statistics.worst_rounding = 2.4e-4;
  const Config config = read_input(test::with_line(6, more), "a.yaml", {});
  const auto found = findings_about_solutions(config, statistics, Forces::some);
  return found.size() == 1 ? found.front().message : std::to_string(found.size()) + " findings";
}

TEST(EndFindings, InaccurateSolvesNameContactWhereThereIsSome) {
  const std::string count = "12 of 30 solves ended at the limit of double precision, one of them with 2.4e-04";
  const std::string alone = finding("");
  EXPECT_NE(alone.find(count), std::string::npos) << alone;
  EXPECT_NE(alone.find("the bodies are too stiff relative to the forces on them"), std::string::npos) << alone;
  const std::string touching = finding("contact: {obstacles: [{name: a, shape: plane, normal: [0, 0, 1]}]}");
  EXPECT_NE(touching.find(count), std::string::npos) << touching;
  EXPECT_NE(touching.find("contact or friction, or bodies that are stiff"), std::string::npos) << touching;
}

}  // namespace
}  // namespace pliant::test_end_findings
