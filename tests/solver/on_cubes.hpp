/// Cubes in a file, and what tests of the solver put on them.
#pragma once

#include "petsc/collective.hpp"
#include "solver/problem.hpp"

namespace pliant::test {

class OnCubes : public ::testing::Test {
 protected:
  std::string mesh(int n, Shape shape = Shape::straight) const {
    return scratch_.file("cube" + std::to_string(n) + ".msh", [&](const std::string& f) {
      write_body(f, {1, shape, n});
    });
  }
  /// Clamped at x = 0.
  static ProblemSpec clamped(const ElasticLawSpec& law) {
    ProblemSpec spec;
    spec.law = law;
    spec.supports = {{face(0, 0.0), fixed()}};
    return spec;
  }
  static TermsOf traction(double x, double y, double z) {
    return [=](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> loads;
      loads.push_back(solid.traction({Expression(x), Expression(y), Expression(z)}));
      return loads;
    };
  }
  template <class Term, class... Arguments>
  static TermsOf with_term(Arguments... arguments) {
    return [=](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> terms;
      terms.push_back(std::make_unique<Term>(solid, arguments...));
      return terms;
    };
  }
  /// Every rank must have the same report, word for word.
  static void expect_same_everywhere(const StageReport& report) {
    EXPECT_EQ(broadcast(MPI_COMM_WORLD, report.reason), report.reason);
    const int outcome = static_cast<int>(report.outcome);
    EXPECT_EQ(maximum(MPI_COMM_WORLD, outcome), minimum(MPI_COMM_WORLD, outcome));
    EXPECT_EQ(maximum(MPI_COMM_WORLD, report.newton_iterations), minimum(MPI_COMM_WORLD, report.newton_iterations));
  }

  Scratch scratch_{MPI_COMM_WORLD};
};

}  // namespace pliant::test
