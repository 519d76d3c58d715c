// What strain energy must do beyond having the right derivatives.
#include "energy/reference.hpp"
#include "energy/solid.hpp"
#include "energy/volume/elastic.hpp"
#include "energy/volume/step_bound.hpp"
#include "material/states.hpp"

#include <ostream>

#include <fmt/format.h>

namespace pliant::test_elastic {
namespace {

using test::BodySpec;
using test::Dilatation;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

struct ElasticCase {
  ElasticLawSpec law;
  BodySpec body;
  Dilatation dilatation;
};

std::string name_of(const ElasticCase& c) {
  return test::name_of(c.law) + test::name_of(c.dilatation) + test::name_of(c.body);
}

std::ostream& operator<<(std::ostream& out, const ElasticCase& c) {
  return out << name_of(c);
}

std::vector<ElasticCase> every_case() {
  std::vector<ElasticCase> cases;
  for (const BodySpec body :
       {BodySpec{1, Shape::jittered, 2}, BodySpec{2, Shape::jittered, 2}, BodySpec{2, Shape::curved, 2}}) {
    for (const auto& law : test::every_law(1e9, 0.3)) {
      for (const auto dilatation : test::every_dilatation(law, body.order)) cases.push_back({law, body, dilatation});
    }
  }
  return cases;
}

class Elastic : public ::testing::TestWithParam<ElasticCase> {
 protected:
  bool is_barrier() const { return test::is_barrier(GetParam().law) || GetParam().dilatation == Dilatation::mean; }
  int degree() const { return elastic_quadrature_degree(GetParam().law.traits(), GetParam().body.order); }

  Handle<Vec> gradient(const Handle<Vec>& q) {
    Handle<Vec> r = potential_.make_vector();
    potential_.gradient(q.get(), r.get());
    return r;
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, GetParam().body.order, degree()};
  std::unique_ptr<ElasticTerm> term_ = solid_.elastic(GetParam().law, GetParam().dilatation);
  IncrementalPotential potential_{solid_.layout(), solid_.pattern(), {term_.get()}, solid_.nothing_prescribed()};
};

INSTANTIATE_TEST_SUITE_P(Registry, Elastic, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return name_of(of.param); });

Point rigidly_moved(const Point& x) {
  const auto Q = testing_states::rotation(0.7, -1.9, 1.1);
  Point u{100.0, -20.0, 7.0};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) u[i] += Q(i, k) * x[k];
    u[i] -= x[i];
  }
  return u;
}

// Rounding of the positions after the motion, 1e-14 of some 100 m, strains the cells by as much.
TEST_P(Elastic, RigidMotionsCostNothing) {
  const TestStage stage(solid_, 0.0, 1.0);
  potential_.begin_stage(stage.point);
  const double modulus = 1e9;
  const auto translated = solid_.vector([](const Point&) { return Point{100.0, -20.0, 7.0}; });
  EXPECT_EQ(potential_.value(translated.get()), 0.0);
  EXPECT_EQ(test::norm(gradient(translated).get()), 0.0);
  const auto rotated = solid_.vector(rigidly_moved);
  if (test::is_linear(GetParam().law)) {
    EXPECT_GT(potential_.value(rotated.get()), 0.1 * modulus);
    return;
  }
  EXPECT_LE(test::norm(gradient(rotated).get()), 1e-12 * modulus);
  EXPECT_LE(std::abs(potential_.value(rotated.get())), 1e-24 * modulus);
}

// The internal forces balance: no net force, and no net moment about the origin of the deformed body.
TEST_P(Elastic, InternalForcesBalance) {
  const TestStage stage(solid_, 0.0, 1.0);
  potential_.begin_stage(stage.point);
  const auto q = solid_.vector(test::strained);
  const auto r = gradient(q);
  const double size = test::norm(r.get());
  ASSERT_GT(size, 1.0);
  // About the places at rest for the law that knows no others.
  const auto [force, moment] =
      test::resultant(solid_, r.get(), test::is_linear(GetParam().law) ? stage.q0.get() : q.get());
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(force[i], 0.0, 1e-13 * size);
    EXPECT_NEAR(moment[i], 0.0, 1e-13 * size);
  }
}

// int P : grad(direction) along a straight path of configurations is the energy at its end.
TEST_P(Elastic, WorkAlongAPathIsTheEnergyAtItsEnd) {
  const TestStage stage(solid_, 0.0, 1.0);
  potential_.begin_stage(stage.point);
  const auto q = solid_.vector(test::strained), rest = solid_.vector(test::at_rest);
  // Gauss's rule of five points on each quarter of the path: the force along it is smooth.
  constexpr std::array<std::array<double, 2>, 3> half{
      {{0.0, 128.0 / 225.0}, {0.5384693101056831, 0.4786286704993665}, {0.9061798459386640, 0.2369268850561891}}};
  double work = 0.0;
  for (const double middle : {0.125, 0.375, 0.625, 0.875}) {
    for (const auto& [x, w] : half) {
      for (const double side : {-1.0, 1.0}) {
        if (x == 0.0 && side > 0.0) continue;
        const auto at = test::moved(rest.get(), middle + 0.125 * side * x, q.get());
        work += 0.125 * w * test::dot(gradient(at).get(), q.get());
      }
    }
  }
  const double energy = sum(comm, term_->energy(test::local_values(q.get()), {}));
  ASSERT_GT(energy, 1.0);
  EXPECT_NEAR(work, energy, 1e-8 * energy);
  EXPECT_NEAR(potential_.value(q.get()), energy, 1e-13 * energy);
}

// A strained body that hardly moves: the change of its energy, 1e-10 of the energy and less, keeps its digits.
// Simpson's rule over the path is exact here: its error is of fifth order in an increment of 1e-10.
TEST_P(Elastic, SmallChangesSurviveBesideALargeEnergy) {
  const TestStage stage(solid_, 0.0, 1.0, test::strained);
  potential_.begin_stage(stage.point);
  const double energy = sum(comm, term_->energy(test::local_values(stage.q0.get()), {}));
  for (const double size : {1e-4, 1e-7, 1e-10}) {
    const auto q = test::moved(stage.q0.get(), size, solid_.vector(test::rough_field(1.0, 8)).get());
    // As rounded: what the vectors hold.
    const auto step = test::moved(q.get(), -1.0, stage.q0.get());
    const auto middle = test::moved(stage.q0.get(), 0.5, step.get());
    const double start = test::dot(gradient(stage.q0).get(), step.get());
    const double half = test::dot(gradient(middle).get(), step.get());
    const double end = test::dot(gradient(q).get(), step.get());
    const double expected = (start + 4.0 * half + end) / 6.0;
    ASSERT_LT(std::abs(expected), 1e3 * size * energy);
    ASSERT_GT(std::abs(expected), 1e-3 * size * energy);
    const double path = size == 1e-4 ? 1e-10 : 1e-12;  // Simpson's own error at the largest increment
    EXPECT_NEAR(potential_.value(q.get()), expected, path * std::abs(expected)) << "increment " << size;
  }
}

// Where the first-order part vanishes (at equilibrium) the change is of second order: d . K d / 2.
TEST_P(Elastic, SecondOrderChangesSurviveBesideALargeEnergy) {
  const TestStage stage(solid_, 0.0, 1.0, test::strained);
  potential_.begin_stage(stage.point);
  const Handle<Mat> K = potential_.make_hessian();
  potential_.hessian(stage.q0.get(), K.get(), Projection::none);
  const double size = 1e-7;
  const Handle<Vec> d = solid_.vector(test::rough_field(size, 8)), Kd = potential_.make_vector();
  const auto ahead = test::moved(stage.q0.get(), 1.0, d.get());
  const auto step = test::moved(ahead.get(), -1.0, stage.q0.get());
  const auto behind = test::moved(stage.q0.get(), -1.0, step.get());
  check(MatMult(K.get(), step.get(), Kd.get()));
  const double expected = test::dot(step.get(), Kd.get());
  const double energy = sum(comm, term_->energy(test::local_values(stage.q0.get()), {}));
  ASSERT_GT(std::abs(expected), 0.0);
  ASSERT_LT(std::abs(expected), 1e-8 * energy);
  // The first-order parts of both sides cancel: they are larger by 1e6 or so, and each is exact to 1e-15.
  EXPECT_NEAR(potential_.value(ahead.get()) + potential_.value(behind.get()), expected, 1e-6 * std::abs(expected));
}

// A body compressed on all sides would rather turn: its Hessian is indefinite for every law that knows rotations.
TEST_P(Elastic, ProjectedHessianIsPositiveSemidefiniteWhereTheHessianIsNot) {
  const Solid whole(MPI_COMM_SELF, file_, GetParam().body.order, degree());
  const auto term = whole.elastic(GetParam().law, GetParam().dilatation);
  IncrementalPotential alone(whole.layout(), whole.pattern(), {term.get()}, whole.nothing_prescribed());
  const TestStage stage(whole, 0.0, 1.0);
  alone.begin_stage(stage.point);
  const auto q = whole.vector([](const Point& x) {
    return Point{-0.3 * x[0] + 0.01 * test::rough(x, 0, 2), -0.35 * x[1], -0.3 * x[2]};
  });
  const auto [lowest, highest] = test::extreme_eigenvalues(alone, q.get(), Projection::none);
  const auto [projected, projected_highest] =
      test::extreme_eigenvalues(alone, q.get(), Projection::positive_semidefinite);
  if (!test::is_linear(GetParam().law)) {
    EXPECT_LT(lowest, -1e-3 * highest);
  }
  EXPECT_GE(projected, -1e-13 * projected_highest);
  // Where the Hessian is definite, projection changes nothing.
  const auto stretched = whole.vector([](const Point& x) { return Point{0.1 * x[0], 0.1 * x[1], 0.1 * x[2]}; });
  const auto exact = test::extreme_eigenvalues(alone, stretched.get(), Projection::none);
  const auto same = test::extreme_eigenvalues(alone, stretched.get(), Projection::positive_semidefinite);
  EXPECT_NEAR(exact[1], same[1], 1e-12 * exact[1]);
}

// Gradients of the shape functions in double do not sum to zero exactly: what a rigid motion of the size of q makes of
// that, 1e-16 of q, is beyond both sides.
TEST_P(Elastic, ForcesOfStrainsOf1e8KeepTheirDigits) {
  if (GetParam().dilatation == Dilatation::mean) return;  // test_mean_dilatation
  const auto q = solid_.vector([](const Point& x) {
    return Point{1e-8 * (x[0] * x[1] + 0.1 * test::rough(x, 0, 1)), 1e-8 * (x[2] * x[2] - x[0]),
                 1e-8 * (x[1] + 0.3 * x[2] + 0.1 * test::rough(x, 2, 1))};
  });
  const TestStage stage(solid_, 0.0, 1.0);
  const auto local = test::local_values(q.get());
  const LocalStage at{0.0, 1.0, 1.0, {}, {}, {}};
  std::vector<double> r(local.size(), 0.0);
  term_->add_gradient(at, local, r);
  const auto [error, size] = test::error_and_size(solid_, degree(), r, {local}, [&](const test::Gradients& H) {
    return testing_states::textbook_P(instantiate(GetParam().law), H[0]);
  });
  ASSERT_GT(size, 0.1);  // 1e9 Pa at strains of 1e-8
  EXPECT_LE(error, 2e-14 * size);
  RecordProperty("relative_error", fmt::format("{:.1e}", error / size));
}

// Uniform strain: the stress at the centroids, and the energy in closed form.
TEST_P(Elastic, StressesOfAUniformStrainAreTheLaws) {
  Tensor3<double> H{{0.1, 0.05, 0.0, -0.02, 0.08, 0.03, 0.0, 0.01, -0.06}};
  const auto q = solid_.vector([&](const Point& x) {
    Point u{};
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) u[i] += H(i, k) * x[k];
    }
    return u;
  });
  const auto local = test::local_values(q.get());
  std::visit(
      [&](const auto& law) {
        const double psi = law.psi(H);
        const auto F = add_to_diagonal(H, 1.0);
        const auto sigma = (1.0 / det(F)) * matmul(law.P(H), transpose(F));
        EXPECT_NEAR(sum(comm, term_->energy(local, {})), psi * GetParam().body.volume(), 1e-12 * psi);
        PetscInt visited = 0;
        term_->stresses({.q = local}, [&](PetscInt cell, const CellStress& s) {
          ++visited;
          ASSERT_LT(cell, solid_.layout().num_owned_cells);
          EXPECT_NEAR(s.volume_ratio, det(F), 1e-13);
          EXPECT_NEAR(s.energy_density, psi, 1e-12 * psi);
          const std::array<double, 6> expected{sigma(0, 0), sigma(1, 1), sigma(2, 2),
                                               sigma(0, 1), sigma(1, 2), sigma(0, 2)};
          for (int i = 0; i < 6; ++i) EXPECT_NEAR(s.cauchy[i], expected[i], 1e-12 * 1e9);
          // The linear law's P F^T is not symmetric at finite strain.
          if (!test::is_linear(GetParam().law)) {
            const auto deviator = add_to_diagonal(sigma, -trace(sigma) / 3.0);
            EXPECT_NEAR(von_mises(s.cauchy), std::sqrt(1.5 * dot(deviator, deviator)), 1e-12 * 1e9);
          }
        });
        EXPECT_EQ(visited, solid_.layout().num_owned_cells);
      },
      instantiate(GetParam().law));
}

// Between two uniform gradients: half of the difference of the stresses times that of the strains, in closed form; none
// where they differ by a rotation.
TEST_P(Elastic, ErrorsOfGradientsAreTheEnergiesOfTheirDifferences) {
  const Tensor3<double> H{{0.1, 0.05, 0.0, -0.02, 0.08, 0.03, 0.0, 0.01, -0.06}};
  const Tensor3<double> more{{0.12, 0.04, 0.01, -0.01, 0.1, 0.0, 0.02, 0.0, -0.05}};
  const Tensor3<double> turn{{0.8, -0.6, 0.0, 0.6, 0.8, 0.0, 0.0, 0.0, 1.0}};
  const Tensor3<double> turned = add_to_diagonal(matmul(turn, add_to_diagonal(H, 1.0)), -1.0);
  const auto q = solid_.vector([&](const Point& x) {
    Point u{};
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) u[i] += H(i, k) * x[k];
    }
    return u;
  });
  const auto local = test::local_values(q.get());
  const auto errors = [&](const Tensor3<double>& recovered) {
    std::vector<double> gradients;
    for (PetscInt n = 0; n < solid_.layout().num_local_nodes; ++n) {
      gradients.insert(gradients.end(), recovered.a.begin(), recovered.a.end());
    }
    std::array<double, 2> totals{};
    term_->recovery_errors({{}, solid_.layout().coordinates, local, gradients},
                           [&](PetscInt cell, const RecoveryError& error) {
                             if (cell >= solid_.layout().num_owned_cells) return;
                             totals[0] += error.energy;
                             totals[1] += error.volume;
                           });
    sum_in_place(comm, totals);
    return totals;
  };
  const double volume = GetParam().body.volume();
  std::visit(
      [&](const auto& law) {
        const bool is_linear = test::is_linear(GetParam().law);
        const auto stress = [&](const Tensor3<double>& at) {
          const auto F = add_to_diagonal(at, 1.0), G = (1.0 / det(F)) * cofactor(F);
          Tensor3<double> P = law.P(at);
          if (is_linear) return P;
          if (GetParam().dilatation == Dilatation::mean) P = P - (dot(P, F) / 3.0) * G;  // of the distortion alone
          return matmul(transpose(G), P);
        };
        const auto strain = [&](const Tensor3<double>& at) {
          return is_linear ? small_strain(at) : green_lagrange(at);
        };
        const double expected = 0.5 * dot(stress(more) - stress(H), strain(more) - strain(H)) * volume;
        const auto [energy, size] = errors(more);
        EXPECT_GT(expected, 0.0);
        EXPECT_NEAR(size, volume, 1e-12);
        EXPECT_NEAR(energy, expected, 1e-9 * expected);
        if (!is_linear) {
          EXPECT_NEAR(errors(turned)[0], 0.0, 1e-12 * std::abs(law.psi(H)) * volume);
        }
      },
      instantiate(GetParam().law));
}

// Beyond a barrier: +inf on every rank, though one cell is inverted on one rank alone.
TEST_P(Elastic, AnInvertedCellIsInfinitelyFarForEveryRank) {
  if (!is_barrier()) return;
  const TestStage stage(solid_, 0.0, 1.0);
  potential_.begin_stage(stage.point);
  const auto q = solid_.vector([](const Point& x) {
    const bool is_corner = x[0] < 1e-9 && x[1] < 1e-9 && x[2] < 1e-9;
    return is_corner ? Point{2.0, 2.0, 2.0} : Point{0.0, 0.0, 0.0};
  });
  EXPECT_EQ(potential_.value(q.get()), HUGE_VAL);
  EXPECT_TRUE(std::isnan(test::norm(gradient(q).get())));
  // And from an inverted start nothing is finite either, so that no rank goes on.
  const TestStage bad(solid_, 0.0, 1.0, [](const Point& x) { return Point{-2.0 * x[0], 0.0, 0.0}; });
  potential_.begin_stage(bad.point);
  EXPECT_EQ(potential_.value(solid_.vector(test::at_rest).get()), HUGE_VAL);
}

// The whole body is pressed flat along x at alpha = 1 / 1.25; its first cell to go is any.
TEST_P(Elastic, StepBoundIsWhereTheBodyIsFlat) {
  const TestStage stage(solid_, 0.0, 1.0);
  potential_.begin_stage(stage.point);
  const auto q = solid_.vector(test::at_rest);
  const auto d = solid_.vector([](const Point& x) { return Point{-1.25 * x[0], 0.0, 0.0}; });
  const double bound = potential_.max_step(q.get(), d.get());
  if (!is_barrier()) {
    EXPECT_EQ(bound, HUGE_VAL);
    return;
  }
  EXPECT_NEAR(bound, 0.8, 1e-12);
  EXPECT_EQ(potential_.max_step(q.get(), test::moved(q.get(), 0.5, d.get()).get()), HUGE_VAL);
}

}  // namespace
}  // namespace pliant::test_elastic
