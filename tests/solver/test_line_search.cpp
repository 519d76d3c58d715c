// Line searches on functions of one number.
#include "solver/line_search.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_line_search {
namespace {

using Status = LineOutcome::Status;
using Demand = LineSearch::Demand;

const double infinity = std::numeric_limits<double>::infinity();

/// Functions of the step length along d = 1, with K = 1 and D = 1, so that the correction at a point is -r there.
class Function final : public SearchLine {
 public:
  std::function<double(double)> phi = [](double) { return 0.0; };
  std::function<double(double)> r;
  std::function<bool(double)> allowed = [](double) { return true; };
  bool solver_works = true;

  double potential(double alpha) override {
    tried.push_back(alpha);
    return phi(alpha);
  }
  Residual residual(double alpha) override {
    if (tried.empty() || tried.back() != alpha) tried.push_back(alpha);
    return {std::abs(r(alpha)), r(alpha)};
  }
  bool is_admissible() override { return allowed(tried.back()); }
  double merit() override { return scale_of_merit * 0.5 * std::pow(r(tried.back()), 2); }
  double merit_of_correction() override {
    ++corrections;
    return solver_works ? 0.5 * std::pow(r(tried.back()), 2) : infinity;
  }
  double merit_of_direction() override { return 0.5; }
  double merit_of_nonlinear_part(double alpha) override { return 0.5 * std::pow(-r(tried.back()) + (1.0 - alpha), 2); }

  LineStart start(double measure) const {
    return {.slope = r(0.0), .residual = std::abs(r(0.0)), .measure = measure, .step = 1.0};
  }
  LineStart on_potential() const { return start(phi(0.0)); }
  LineStart on_residual() const { return start(scale_of_merit * 0.5 * std::pow(r(0.0), 2)); }

  double scale_of_merit = 1.0;
  std::vector<double> tried;
  int corrections = 0;
};

Function parabola() {
  Function f;
  f.phi = [](double a) { return 0.5 * (a - 1.0) * (a - 1.0); };
  f.r = [](double a) { return a - 1.0; };
  return f;
}

TEST(LineSearch, TakesTheWholeStepOfAParabola) {
  Function f = parabola();
  const LineOutcome outcome = LineSearch().lower_potential(f, f.on_potential());
  EXPECT_EQ(outcome.status, Status::accepted);
  EXPECT_EQ(outcome.length, 1.0);
  EXPECT_EQ(outcome.potential, 0.0);
  EXPECT_EQ(outcome.residual, 0.0);
  EXPECT_EQ(outcome.backtracks, 0);
  EXPECT_EQ(f.tried, std::vector<double>{1.0});
}

// -20 a - ln(1 - a / 0.1): the minimum lies at 0.05, a barrier at 0.1, and the step ends far beyond both.
TEST(LineSearch, StaysOnTheNearSideOfABarrier) {
  Function f;
  f.phi = [](double a) { return a < 0.1 ? -20.0 * a - std::log1p(-a / 0.1) : infinity; };
  f.r = [](double a) { return a < 0.1 ? -20.0 + 1.0 / (0.1 - a) : infinity; };
  const LineStart start = f.on_potential();
  ASSERT_LT(start.slope, 0.0);
  const LineOutcome outcome = LineSearch().lower_potential(f, start);
  EXPECT_EQ(outcome.status, Status::accepted);
  EXPECT_GT(outcome.length, 0.0);
  EXPECT_LT(outcome.length, 0.1);
  EXPECT_LT(outcome.potential, start.measure);
  EXPECT_EQ(outcome.potential, f.phi(outcome.length));
  EXPECT_EQ(outcome.length, f.tried.back());
  EXPECT_EQ(outcome.backtracks, static_cast<int>(f.tried.size()) - 1);
  for (std::size_t i = 1; i < f.tried.size(); ++i) {
    EXPECT_LE(f.tried[i], 0.5 * f.tried[i - 1]);
    EXPECT_GE(f.tried[i], 0.1 * f.tried[i - 1]);
  }
}

TEST(LineSearch, NeverGoesBeyondTheFirstLength) {
  Function f = parabola();
  LineStart start = f.on_potential();
  start.first_length = 0.3;
  const LineOutcome outcome = LineSearch().lower_potential(f, start);
  EXPECT_EQ(outcome.status, Status::accepted);
  EXPECT_EQ(outcome.length, 0.3);
}

// Uphill for every length, whatever the slope promises.
TEST(LineSearch, StallsWhereNothingLowersThePotential) {
  Function f;
  f.phi = [](double a) { return a; };
  f.r = [](double) { return 1.0; };
  LineStart start = f.on_potential();
  start.slope = -1.0;
  const LineOutcome outcome = LineSearch().lower_potential(f, start);
  EXPECT_EQ(outcome.status, Status::stalled);
  EXPECT_GT(outcome.backtracks, 10);
  // If the residual is nothing but rounding errors, this is the minimum.
  start.residual_rounding = 1.0;
  f.phi = [](double) { return infinity; };
  EXPECT_EQ(LineSearch().lower_potential(f, start).status, Status::at_rounding);
  start.residual_rounding = 1.0 / 500.0;
  EXPECT_EQ(LineSearch().lower_potential(f, start).status, Status::stalled);
}

// The change of the potential, 5e-13, drowns in 1e4: the gradient shows that the step helps.
TEST(LineSearch, AsksTheGradientWhereThePotentialIsRounded) {
  Function f;
  f.phi = [](double) { return std::nextafter(1e4, 2e4); };
  f.r = [](double a) { return 1e-6 * (a - 1.0); };
  LineStart start = f.start(1e4);
  const LineOutcome outcome = LineSearch().lower_potential(f, start);
  EXPECT_EQ(outcome.status, Status::accepted);
  EXPECT_EQ(outcome.length, 1.0);
  // And where the gradient is larger there, the step is refused.
  f.r = [](double a) { return a == 0.0 ? -1e-6 : 2e-6; };
  EXPECT_EQ(LineSearch().lower_potential(f, start).status, Status::stalled);
}

// The whole step ends far beyond the minimum. The first time that is progress, the second time the step goes to the
// minimum of the parabola through the two slopes.
TEST(LineSearch, DoesNotGoToAndFro) {
  Function f;
  f.phi = [](double a) { return 0.5 * std::pow(a - 0.6, 2); };
  f.r = [](double a) { return a - 0.6; };
  LineSearch search;
  EXPECT_EQ(search.lower_potential(f, f.on_potential()).length, 1.0);
  const LineOutcome second = search.lower_potential(f, f.on_potential());
  EXPECT_EQ(second.status, Status::accepted);
  EXPECT_NEAR(second.length, 0.6, 1e-14);
  EXPECT_EQ(second.backtracks, 1);
  search.begin();
  EXPECT_EQ(search.lower_potential(f, f.on_potential()).length, 1.0);
  // The same on a residual.
  search.begin();
  EXPECT_EQ(search.lower_residual(f, f.on_residual(), Demand::decrease).length, 1.0);
  EXPECT_NEAR(search.lower_residual(f, f.on_residual(), Demand::decrease).length, 0.6, 1e-14);
}

TEST(LineSearch, TakesAResidualThatFalls) {
  Function f = parabola();
  const LineOutcome outcome = LineSearch().lower_residual(f, f.on_residual(), Demand::decrease);
  EXPECT_EQ(outcome.status, Status::accepted);
  EXPECT_EQ(outcome.length, 1.0);
  EXPECT_EQ(f.corrections, 0);
}

// The merit rises tenfold, as where a strip is stretched, but the next correction is short.
TEST(LineSearch, AsksTheCorrectionWhereTheResidualRises) {
  Function f = parabola();
  f.r = [](double a) { return -1.0 + 0.8 * a; };
  LineStart start = f.on_residual();
  start.measure = 1e-3;
  const LineOutcome outcome = LineSearch().lower_residual(f, start, Demand::decrease);
  EXPECT_EQ(outcome.status, Status::accepted);
  EXPECT_EQ(outcome.length, 1.0);
  EXPECT_EQ(f.corrections, 1);
  EXPECT_NEAR(outcome.residual, 0.2, 1e-14);
}

TEST(LineSearch, RefusesWhatTheLinearSolverCannotCorrect) {
  Function f = parabola();
  f.r = [](double a) { return a == 0.0 ? -1.0 : -2.0; };
  f.solver_works = false;
  const LineOutcome outcome = LineSearch().lower_residual(f, f.on_residual(), Demand::decrease);
  EXPECT_EQ(outcome.status, Status::stalled);
  EXPECT_EQ(f.corrections, outcome.backtracks);
  for (std::size_t i = 1; i < f.tried.size(); ++i) EXPECT_NEAR(f.tried[i] / f.tried[i - 1], 0.1, 1e-12);
}

TEST(LineSearch, DescentEndsWhereTheForcesHaveDoneTheirWork) {
  // The force along the line grows before it falls: no merit of it does. It vanishes at 2.
  Function f;
  f.r = [](double a) { return a < 1.0 ? -1.0 - a : 2.0 * (a - 2.0); };
  const LineOutcome longer = LineSearch().lower_residual(f, f.on_residual(), Demand::descent);
  EXPECT_EQ(longer.status, Status::accepted);
  EXPECT_EQ(longer.length, 1.0);
  // Beyond that place by far: back to about where it vanishes.
  f.r = [](double a) { return 10.0 * (a - 0.1); };
  const LineOutcome shorter = LineSearch().lower_residual(f, f.on_residual(), Demand::descent);
  EXPECT_EQ(shorter.status, Status::accepted);
  EXPECT_NEAR(shorter.length, 0.1, 1e-12);
  EXPECT_EQ(shorter.backtracks, 1);
}

TEST(LineSearch, WholeStepsNeedOnlyBePossible) {
  Function f = parabola();
  f.r = [](double a) { return -1.0 - 10.0 * a; };
  EXPECT_EQ(LineSearch().lower_residual(f, f.on_residual(), Demand::none).length, 1.0);
  f.r = [](double a) { return a > 0.3 ? infinity : -1.0 - 10.0 * a; };
  EXPECT_EQ(LineSearch().lower_residual(f, f.on_residual(), Demand::none).length, 0.25);
  f.r = [](double a) { return -1.0 - 10.0 * a; };
  f.allowed = [](double a) { return a < 0.2; };
  EXPECT_EQ(LineSearch().lower_residual(f, f.on_residual(), Demand::none).length, 0.125);
}

}  // namespace
}  // namespace pliant::test_line_search
