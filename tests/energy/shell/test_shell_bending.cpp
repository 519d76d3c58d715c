// Bending of shells: derivatives, rigid motions, ranks; with clamped edges.
#include "energy/shell/shell_bending_viscosity.hpp"
#include "energy/solid.hpp"
#include "fem/body.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_shell_bending {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

TEST(HingeAngle, IsThatOfTheFold) {
  for (const double angle : {-2.5, -0.3, 0.0, 1e-9, 0.8, 3.0}) {
    const Vector3<double> e{2.0, 0.0, 0.0}, u{0.5, 1.5, 0.0}, v{1.0, -std::cos(angle), std::sin(angle)};
    EXPECT_NEAR(hinge_angle<double>(e, u, v), angle, 1e-15);
  }
}

FacetList facets_of(const Solid& solid, bool is_clamped) {
  return surface_facets(solid.mesh(), solid.layout(), [=](const Point& X) { return !is_clamped || X[2] > 1.0 - 1e-9; });
}

/// The sides of facets at x = 0, several times.
std::vector<ClampedEdges> clamped_sides(const NodeLayout& layout, const FacetList& facets,
                                        const std::optional<Vector3<double>>& normal) {
  ClampedEdges result{{}, normal};
  result.edges.nodes_per_edge = layout.order + 1;
  constexpr std::array<std::array<std::size_t, 3>, 3> sides{{{0, 1, 3}, {1, 2, 4}, {0, 2, 5}}};
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = facets.nodes_of(f);
    for (const auto& [a, b, middle] : sides) {
      if (facets.is_owned[static_cast<std::size_t>(f)] == 0) continue;
      if (std::abs(layout.position(nodes[a])[0]) + std::abs(layout.position(nodes[b])[0]) > 1e-9) continue;
      result.edges.nodes.insert(result.edges.nodes.end(), {nodes[a], nodes[b]});
      if (layout.order == 2) result.edges.nodes.push_back(nodes[middle]);
      result.edges.is_owned.push_back(1);
    }
  }
  return {result};
}

enum class Support { none, clamped, symmetric };

/// The whole surface of a body resists bending, or its top, which is clamped or symmetric at x = 0.
struct Bent {
  Solid solid;
  ShellBending term;
  IncrementalPotential potential;
  TestStage stage;

  Bent(MPI_Comm on, const std::string& file, const BodySpec& body, Support support = Support::none)
      : solid(on, file, body.order, 1),
        term(make_term(solid, support)),
        potential(solid.layout(), solid.pattern(), {&term}, solid.nothing_prescribed()),
        stage(solid, 0.7, 0.05, test::rough_field(0.01, 3), test::rough_field(0.3, 4)) {
    potential.begin_stage(stage.point);
  }
  static ShellBending make_term(const Solid& solid, Support support) {
    const FacetList facets = facets_of(solid, support != Support::none);
    std::optional<Vector3<double>> normal;
    if (support == Support::symmetric) normal = Vector3<double>{1.0, 0.0, 0.0};
    std::vector<ClampedEdges> clamped;
    if (support != Support::none) clamped = clamped_sides(solid.layout(), facets, normal);
    const auto stiffness = [](const Point& X) { return BendingStiffness{2.0 + X[0], 0.3}; };
    return ShellBending(solid.layout(), facets, stiffness, clamped);
  }
  Handle<Vec> gradient(Vec q) {
    Handle<Vec> r = potential.make_vector();
    potential.gradient(q, r.get());
    return r;
  }
};

class Bending : public ::testing::TestWithParam<BodySpec> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam()); });
  Bent bent_{comm, file_, GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Elements, Bending,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

void check_derivatives(Bent& bent) {
  IncrementalPotential& potential = bent.potential;
  const Handle<Vec> q = bent.solid.vector(test::strained), d = bent.solid.vector(test::rough_field(1.0, 11));
  constexpr double h = 1e-6;
  const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
  const Handle<Vec> r = bent.gradient(q.get()), next = bent.gradient(ahead.get()), last = bent.gradient(behind.get());
  const double slope = (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h);
  ASSERT_GT(test::norm(r.get()), 0.1);
  EXPECT_NEAR(test::dot(r.get(), d.get()), slope, 1e-7 * test::norm(r.get()) * test::norm(d.get()));
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q.get(), K.get(), Projection::none);
  const Handle<Vec> y = potential.make_vector();
  check(MatMult(K.get(), d.get(), y.get()));
  check(VecAXPY(next.get(), -1.0, last.get()));
  check(VecScale(next.get(), 0.5 / h));
  ASSERT_GT(test::norm(y.get()), 0.1);
  EXPECT_LT(test::distance(next.get(), y.get()), 1e-7 * test::norm(y.get()));
  potential.hessian(q.get(), K.get(), Projection::positive_semidefinite);
  check(MatMult(K.get(), d.get(), y.get()));
  EXPECT_GE(test::dot(y.get(), d.get()), 0.0);
}

TEST_P(Bending, DerivativesAreThoseOfDifferences) {
  check_derivatives(bent_);
}

TEST_P(Bending, DerivativesOfHeldEdgesAre) {
  for (const Support support : {Support::clamped, Support::symmetric}) {
    Bent bent(comm, file_, GetParam(), support);
    ASSERT_TRUE(bent.term.num_unclamped().empty());
    check_derivatives(bent);
  }
}

/// The viscosity of the same layer alone.
struct Viscous {
  ShellBendingViscosity term;
  IncrementalPotential potential;

  explicit Viscous(Bent& bent)
      : term(bent.term, {0.02, -0.01, 0.06}),
        potential(bent.solid.layout(), bent.solid.pattern(), {&term}, bent.solid.nothing_prescribed()) {
    potential.begin_stage(bent.stage.point);
  }
};

TEST_P(Bending, ViscosityHasTheTangentOfItsForces) {
  for (const Support support : {Support::none, Support::clamped, Support::symmetric}) {
    Bent bent(comm, file_, GetParam(), support);
    Viscous viscous(bent);
    const Handle<Vec> q = bent.solid.vector(test::strained), d = bent.solid.vector(test::rough_field(1.0, 11));
    constexpr double h = 1e-6;
    const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get()),
                      next = viscous.potential.make_vector(), last = viscous.potential.make_vector(),
                      y = viscous.potential.make_vector();
    viscous.potential.gradient(ahead.get(), next.get());
    viscous.potential.gradient(behind.get(), last.get());
    check(VecAXPY(next.get(), -1.0, last.get()));
    check(VecScale(next.get(), 0.5 / h));
    const Handle<Mat> K = viscous.potential.make_hessian();
    viscous.potential.hessian(q.get(), K.get(), Projection::none);
    check(MatMult(K.get(), d.get(), y.get()));
    ASSERT_GT(test::norm(y.get()), 0.1);
    EXPECT_LT(test::distance(next.get(), y.get()), 1e-6 * test::norm(y.get()));
  }
}

// The power of its forces is what it dissipates, and it is zero where the body turns.
TEST_P(Bending, ViscosityDissipatesThePowerOfItsForces) {
  Viscous viscous(bent_);
  const Handle<Vec> q = bent_.solid.vector(test::strained), r = viscous.potential.make_vector(),
                    v = viscous.potential.make_vector();
  check(VecWAXPY(v.get(), -1.0, bent_.stage.point.q0, q.get()));
  check(VecScale(v.get(), 1.0 / bent_.stage.point.dt));
  const TermPower power = viscous.potential.accounts().powers(q.get(), v.get(), r.get()).front();
  ASSERT_GT(power.dissipated, 1e-3);
  EXPECT_NEAR(power.exerted, -power.dissipated, 1e-10 * power.dissipated);
}

TEST_P(Bending, RigidMotionsCostNothing) {
  const Handle<Vec> q = bent_.solid.vector([](const Point& x) -> Point {
    return {-x[0] - x[1] + 0.3, x[0] - x[1] - 0.2, 4.0};  // a quarter of a turn, and a shift
  });
  EXPECT_LT(test::norm(bent_.gradient(q.get()).get()), 1e-9);
  EXPECT_EQ(test::norm(bent_.gradient(bent_.solid.vector(test::at_rest).get()).get()), 0.0);
}

TEST_P(Bending, NumbersAreThoseOfOneRank) {
  Bent alone(MPI_COMM_SELF, file_, GetParam()), clamped(comm, file_, GetParam(), Support::clamped),
      clamped_alone(MPI_COMM_SELF, file_, GetParam(), Support::clamped);
  const auto numbers = [](Bent& bent) {
    const Handle<Vec> q = bent.solid.vector(test::strained), d = bent.solid.vector(test::rough_field(1.0, 11)),
                      y = bent.potential.make_vector(), r = bent.gradient(q.get());
    const Handle<Mat> K = bent.potential.make_hessian();
    bent.potential.hessian(q.get(), K.get(), Projection::none);
    check(MatMult(K.get(), d.get(), y.get()));
    return std::array{bent.potential.value(q.get()),
                      bent.potential.accounts().energies({0.0, 1.0, nullptr}, q.get(), nullptr).front(),
                      test::norm(r.get()), test::norm(y.get()), test::dot(r.get(), d.get())};
  };
  for (const auto& [bent, of_one] : {std::pair{&bent_, &alone}, {&clamped, &clamped_alone}}) {
    const auto here = numbers(*bent), expected = numbers(*of_one);
    for (std::size_t k = 0; k < here.size(); ++k) {
      EXPECT_NEAR(here[k], expected[k], 1e-12 * std::abs(expected[k])) << k;
    }
  }
}

}  // namespace
}  // namespace pliant::test_shell_bending
