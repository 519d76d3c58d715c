/// Bodies with constraints and the solver of their stages, for the tests of constraints.
#pragma once

#include "energy/tied_body.hpp"
#include "solver/newton.hpp"
#include "solver/problem.hpp"

#include <functional>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test {

/// A tied body and its solver.
struct TiedProblem {
  TiedProblem(MPI_Comm on, const std::string& file, const TiedSpec& spec, LinearKind linear = LinearKind::cholesky)
      : body(on, file, spec), equation(body.equation(), body.map()), solver(equation, {.relative = 1e-12}, linear) {}

  /// The equilibrium at t = 1 from rest, in `steps` equal parts.
  Handle<Vec> equilibrium(int steps = 1) {
    Handle<Vec> q = body.solid().vector(at_rest);
    for (int s = 1; s <= steps; ++s) {
      const auto q0 = moved(q.get(), 0.0, q.get()), v0 = body.solid().vector(at_rest);
      const StagePoint stage{1.0, 1.0, q0.get(), v0.get(), static_cast<double>(s) / steps};
      body.motion().start_stage(stage, q.get());
      const StageReport report = solver.solve(stage, q.get());
      EXPECT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    }
    EXPECT_LE(body.violation(q.get(), 1.0), 1e-14);
    return q;
  }

  TiedBody body;
  ConstrainedEquation equation;
  NewtonSolver solver;
};

/// Cubes of 1 m.
class Tied : public ::testing::Test {
 protected:
  /// A cube; `map` moves its nodes.
  std::string cube(int n, const std::function<Point(Point)>& map = nullptr) const {
    return scratch_.file("cube.msh", [&](const std::string& f) {
      BoxOptions options;
      options.map = map;
      write_box_msh(f, {1.0, 1.0, 1.0}, {n, n, n}, options);
    });
  }

  Scratch scratch_{MPI_COMM_WORLD};
};

/// Rotations by 0.7 rad about the axis (1, 2, 2) / 3.
inline const Point turned_by{0.7 / 3.0, 1.4 / 3.0, 1.4 / 3.0};
inline Point turned(const Point& x) {
  return turn(turned_by, x);
}
inline Point turned_back(const Point& x) {
  return turn(-1.0 * turned_by, x);
}
inline Region turned(const Region& region) {
  return [=](const Point& x) { return region(turned_back(x)); };
}

}  // namespace pliant::test
