// Contact of a body with every shape: derivatives, powers, the bound of a step, and the same numbers on any ranks.
#include "energy/contact/contact.hpp"
#include "energy/solid.hpp"
#include "fem/shapes.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <ostream>

namespace pliant::test_contact {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::ShapeCase;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double time_of_stage = 0.7, dt = 0.05;
const NormalLaw soft{NormalKind::penalty, 400.0, 0.15, 0.2};

struct ContactCase {
  ShapeCase shape;
  BodySpec body;
};

std::ostream& operator<<(std::ostream& out, const ContactCase& c) {
  return out << c.shape << c.body;
}

std::vector<ContactCase> every_case() {
  std::vector<ContactCase> cases;
  for (const auto& shape : test::every_shape()) {
    for (const BodySpec body : {BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::curved, 2}}) {
      cases.push_back({shape, body});
    }
  }
  return cases;
}

/// A motion in all of the six directions.
RigidMotion tumbling() {
  return {{Expression("0.1*t"), Expression("-0.2*t^2"), Expression("0.1*sin(t)")},
          {2.0 / 3, 1.0 / 3, -2.0 / 3},
          Expression("0.2*t^2"),
          {0.5, 0.4, 0.1}};
}

RigidMotion still() {
  return {{Expression(), Expression(), Expression()}, {0.0, 0.0, 1.0}, Expression(), {}};
}

std::shared_ptr<const ContactSurface> surface_of(const Solid& solid, const NormalLaw& law) {
  auto facets = surface_facets(solid.mesh(), solid.layout(), [](const Point&) { return true; });
  return std::make_shared<const ContactSurface>(solid.layout(), solid.pattern(), std::move(facets), law);
}

/// Contact and drags of a body with a shape that tumbles.
struct Terms {
  Terms(const Solid& solid, const ShapeCase& shape) {
    const auto surface = surface_of(solid, soft);
    const auto obstacle = std::make_shared<const Obstacle>(shape.make(), tumbling());
    contact = std::make_unique<Contact>(surface, obstacle);
    for (const auto update : {FrictionUpdate::frozen, FrictionUpdate::iterated}) {
      drags.push_back(make_friction(surface, obstacle, {0.6, 0.0, 20.0}, {}, update));    // sticking
      drags.push_back(make_friction(surface, obstacle, {0.6, 0.2, 0.2}, {0.1}, update));  // sliding
      drags.push_back(make_normal_damping(surface, obstacle, {0.1}, update));
    }
  }
  std::vector<const EnergyTerm*> all() const {
    std::vector<const EnergyTerm*> terms{contact.get()};
    for (const auto& drag : drags) terms.push_back(drag.get());
    return terms;
  }
  std::unique_ptr<Contact> contact;
  std::vector<std::unique_ptr<EnergyTerm>> drags;
};

class Contacting : public ::testing::TestWithParam<ContactCase> {
 protected:
  /// At the stage, with what refreezes frozen near its solution.
  void begin(IncrementalPotential& potential) {
    potential.begin_stage(stage_.point);
    potential.freeze(frozen_.get());
  }
  IncrementalPotential alone(const EnergyTerm& term) const {
    return {solid_.layout(), solid_.pattern(), {&term}, solid_.nothing_prescribed()};
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, GetParam().body.order, 2};
  Terms terms_{solid_, GetParam().shape};
  TestStage stage_{solid_, time_of_stage, dt, test::rough_field(0.01, 3), test::rough_field(0.3, 4)};
  Handle<Vec> q_ = solid_.vector(test::strained), frozen_ = solid_.vector([](const Point&x) {
    const Point u = test::strained(x), w = test::rough_field(0.01, 6)(x);
    return Point{u[0] + w[0], u[1] + w[1], u[2] + w[2]};
  });
};

INSTANTIATE_TEST_SUITE_P(EveryShape, Contacting, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.shape.name + test::name_of(of.param.body); });

// Central differences over 1e-5 of a direction of 0.05: rounding of 1e-10, and what points at a kink of a third
// derivative add.
TEST_P(Contacting, DerivativesAreThoseOfTheValue) {
  constexpr double h = 1e-4;
  for (const EnergyTerm* term : terms_.all()) {
    IncrementalPotential potential = alone(*term);
    begin(potential);
    const Handle<Vec> g = potential.make_vector(), ahead = potential.make_vector(), behind = potential.make_vector(),
                      Kd = potential.make_vector();
    const Handle<Mat> K = potential.make_hessian();
    potential.gradient(q_.get(), g.get());
    potential.hessian(q_.get(), K.get(), Projection::none);
    ASSERT_GT(test::norm(g.get()), 1e-3) << term->name();
    for (const int seed : {11, 12, 13}) {
      const auto d = solid_.vector(test::rough_field(0.05, seed));
      const auto forward = test::moved(q_.get(), h, d.get()), backward = test::moved(q_.get(), -h, d.get());
      const double slope = (potential.value(forward.get()) - potential.value(backward.get())) / (2.0 * h);
      EXPECT_NEAR(slope, test::dot(g.get(), d.get()), 1e-7 * test::norm(g.get()) * test::norm(d.get())) << term->name();
      potential.gradient(forward.get(), ahead.get());
      potential.gradient(backward.get(), behind.get());
      check(VecAXPBY(ahead.get(), -0.5 / h, 0.5 / h, behind.get()));
      check(MatMult(K.get(), d.get(), Kd.get()));
      EXPECT_LE(test::distance(ahead.get(), Kd.get()), 1e-6 * test::norm(Kd.get())) << term->name();
    }
  }
}

TEST_P(Contacting, ProjectedHessianIsSemidefinite) {
  for (const EnergyTerm* term : terms_.all()) {
    IncrementalPotential potential = alone(*term);
    begin(potential);
    const Handle<Mat> K = potential.make_hessian();
    potential.hessian(q_.get(), K.get(), Projection::positive_semidefinite);
    const Handle<Vec> Kd = potential.make_vector();
    for (int seed = 0; seed < 20; ++seed) {
      const auto d = solid_.vector(test::rough_field(1.0, 20 + seed));
      check(MatMult(K.get(), d.get(), Kd.get()));
      EXPECT_GE(test::dot(Kd.get(), d.get()), -1e-12 * test::norm(Kd.get()) * test::norm(d.get()));
    }
  }
}

// The force's power at the stage's velocity is what the obstacle brings in less what is lost and stored; the supply of
// the contact alone is the change of its energy with time.
TEST_P(Contacting, PowersAddUp) {
  const auto v = test::moved(q_.get(), -1.0, stage_.q0.get());
  check(VecScale(v.get(), 1.0 / dt));
  const Handle<Vec> r = make_vector(solid_.layout()), total = make_vector(solid_.layout());
  for (const EnergyTerm* term : terms_.all()) {
    IncrementalPotential potential = alone(*term);
    begin(potential);
    const TermPower power = potential.accounts().powers(q_.get(), v.get(), r.get())[0];
    const Point force = test::resultant(solid_, r.get(), q_.get()).force;
    const double size = std::sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(power.force[i], -force[i], 1e-12 * size);
    if (term == terms_.contact.get()) {
      EXPECT_EQ(power.dissipated, 0.0);
      const double h = 1e-4, change = potential.accounts().supplied({time_of_stage - h, 1.0}, {time_of_stage + h, 1.0},
                                                                    q_.get(), EnergyAccounts::MovingObstacles::alone);
      EXPECT_NEAR(power.supplied, change / (2.0 * h), 1e-6 * std::abs(power.supplied));
    } else {
      EXPECT_GT(power.dissipated, 0.0) << term->name();
      EXPECT_NEAR(-power.exerted, power.dissipated - power.supplied, 1e-10 * power.dissipated) << term->name();
    }
  }
}

TEST_P(Contacting, NothingDependsOnTheNumberOfRanks) {
  const Solid whole(MPI_COMM_SELF, file_, GetParam().body.order, 2);
  const Terms terms(whole, GetParam().shape);
  const TestStage stage(whole, time_of_stage, dt, test::rough_field(0.01, 3), test::rough_field(0.3, 4));
  const auto q = whole.vector(test::strained);
  for (std::size_t k = 0; k < terms.all().size(); ++k) {
    IncrementalPotential here = alone(*terms_.all()[k]),
                         there(whole.layout(), whole.pattern(), {terms.all()[k]}, whole.nothing_prescribed());
    here.begin_stage(stage_.point);
    there.begin_stage(stage.point);
    const Handle<Vec> r = here.make_vector(), expected = there.make_vector();
    here.gradient(q_.get(), r.get());
    there.gradient(q.get(), expected.get());
    EXPECT_NEAR(test::norm(r.get()), test::norm(expected.get()), 1e-12 * test::norm(expected.get()));
    const double value = there.value(q.get());
    EXPECT_NEAR(here.value(q_.get()), value, 1e-12 * std::abs(value));
    const Handle<Mat> K = here.make_hessian(), K_expected = there.make_hessian();
    here.hessian(q_.get(), K.get(), Projection::none);
    there.hessian(q.get(), K_expected.get(), Projection::none);
    PetscReal size = 0.0, size_expected = 0.0;
    check(MatNorm(K.get(), NORM_FROBENIUS, &size));
    check(MatNorm(K_expected.get(), NORM_FROBENIUS, &size_expected));
    EXPECT_NEAR(size, size_expected, 1e-12 * size_expected);
  }
}

// A body thrown at the obstacle: no point passes a barrier on the way that the bound allows, and the bound is not much
// shorter than the way.
TEST_P(Contacting, BoundOfAStepKeepsPointsBeforeABarrier) {
  if (GetParam().shape.is_hollow) return;
  const auto surface = surface_of(solid_, {NormalKind::barrier, 400.0, 0.1, 0.0});
  const Contact contact(surface, std::make_shared<const Obstacle>(GetParam().shape.make(), still()));
  IncrementalPotential potential = alone(contact);
  const auto start = solid_.vector([](const Point& x) { return Point{0.05 * x[1], 0.0, 1.3 + 0.1 * x[0]}; });
  const auto way = solid_.vector([](const Point& x) { return Point{0.1 * x[2], 0.2, -1.9 + 0.3 * x[1]}; });
  TestStage stage(solid_, time_of_stage, dt);
  stage.point.q0 = start.get();
  potential.begin_stage(stage.point);
  EXPECT_EQ(potential.value(test::moved(start.get(), 1.0, way.get()).get()), HUGE_VAL);
  const double bound = potential.max_step(start.get(), way.get());
  EXPECT_GT(bound, 0.2);
  for (const double part : {0.5, 0.9, 1.0}) {
    EXPECT_TRUE(std::isfinite(potential.value(test::moved(start.get(), part * bound, way.get()).get())));
  }
  EXPECT_EQ(potential.value(test::moved(start.get(), 1.25 * bound, way.get()).get()), HUGE_VAL);
  check(VecScale(way.get(), -1.0));
  EXPECT_EQ(potential.max_step(start.get(), way.get()), HUGE_VAL);
}

// The bottom of a unit cube, pressed into a plane beyond the rounding: a spring per area, whose middle is at the plane.
TEST(Contact, OfAFlatFaceIsASpringPerArea) {
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 3});
  });
  for (const int order : {1, 2}) {
    const Solid solid(comm, file, order, 2);
    const double depth = 0.03, k = 500.0;
    auto bottom = surface_facets(solid.mesh(), solid.layout(), [](const Point& x) { return x[2] < 1e-9; });
    const auto surface = std::make_shared<const ContactSurface>(solid.layout(), solid.pattern(), std::move(bottom),
                                                                NormalLaw{NormalKind::penalty, k, 0.01, 0.01});
    const Contact contact(surface,
                          std::make_shared<const Obstacle>(make_distance(PlaneShape{{}, {0.0, 0.0, 1.0}}), still()));
    IncrementalPotential potential(solid.layout(), solid.pattern(), {&contact}, solid.nothing_prescribed());
    const TestStage stage(solid, 0.0, dt);
    const auto q = solid.vector([=](const Point&) { return Point{0.0, 0.0, -depth}; });
    potential.begin_stage(stage.point);
    const Handle<Vec> r = potential.make_vector();
    potential.gradient(q.get(), r.get());
    const Point force = test::resultant(solid, r.get(), q.get()).force;
    EXPECT_NEAR(-force[2], k * depth, 1e-12 * k);
    EXPECT_EQ(force[0], 0.0);
    // k width^2 (1/10 + y^2/2) with y = 3
    EXPECT_NEAR(potential.accounts().energies({}, q.get(), nullptr)[0], k * 1e-4 * 4.6, 1e-12 * k);
  }
}

}  // namespace
}  // namespace pliant::test_contact
