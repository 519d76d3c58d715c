#include "run/failure_report.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace pliant {
namespace {

Failure after(const std::vector<double>& residuals) {
  Failure failure;
  failure.stage.emplace();
  failure.stage->force_scale = 1.0;
  for (const double residual : residuals) failure.stage->iterations.push_back({.residual = residual});
  return failure;
}

bool asks_for(const std::string& words, const FailureReport& report, const Failure& failure) {
  return std::ranges::any_of(advice(report, failure),
                             [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

TEST(Advice, MoreIterationsHelpWhereTheResidualFallsSteadily) {
  FailureReport report;
  report.max_iterations = 5;
  const std::string words = "max_iterations";
  EXPECT_TRUE(asks_for(words, report, after({1e3, 2e3, 500, 100, 30, 10})));
  EXPECT_FALSE(asks_for(words, report, after({1e3, 4e7, 2e3, 1e7, 5e3, 2e3})));
  EXPECT_FALSE(asks_for(words, report, after({1e3, 4e7, 1e7, 1e6, 5e5, 2e5})));
  EXPECT_FALSE(asks_for(words, report, after({1e3, 500, 100, 90, 80, 75})));
}

TEST(Advice, ADynamicAnalysisIsForThoseThatHaveNone) {
  FailureReport report;
  Failure failure = after({1e3, 500, 100});
  for (NewtonIteration& iteration : failure.stage->iterations) iteration.hessian = NewtonIteration::Hessian::projected;
  EXPECT_TRUE(asks_for("the state is unstable", report, failure));
  EXPECT_FALSE(asks_for("a dynamic analysis", report, failure));
  report.has_load_steps = true;
  EXPECT_TRUE(asks_for("or a dynamic analysis instead of load steps", report, failure));
  report.has_load_steps = false;
  report.is_quasistatic = true;
  EXPECT_TRUE(asks_for("'method: static' with time.path follows the equilibria past a limit point", report, failure));
  // No path goes through contact.
  report.has_contact = true;
  EXPECT_FALSE(asks_for("time.path", report, failure));
  EXPECT_TRUE(asks_for("a method with inertia shows where it leads", report, failure));
  report.is_quasistatic = false;
  report.has_load_steps = true;
  EXPECT_FALSE(asks_for("time.path", report, failure));
  EXPECT_TRUE(asks_for("a body that contact alone holds may slide or roll", report, failure));
}

TEST(Advice, SpeaksOfBarriersWhereThereAreSome) {
  FailureReport report;
  report.worst_cells.emplace_back();
  Failure failure;
  failure.stage.emplace();
  EXPECT_TRUE(asks_for("no starting guess fulfils the prescribed motions", report, failure));
  report.has_barriers = true;
  EXPECT_TRUE(asks_for("no starting guess is clear of all barriers", report, failure));
}

TEST(Advice, LoadsGrow) {
  FailureReport report;
  report.load_at_once = "finger.yaml:7:5";
  report.grown_load = "\"-5000*min(t/2, 1)\"";
  EXPECT_EQ(advice(report, after({1e3, 500, 100})).front(),
            "the load at finger.yaml:7:5 acts at once in its full size: let it grow, as \"-5000*min(t/2, 1)\"");
}

}  // namespace
}  // namespace pliant
