// Cavities: what they hold in closed form, and what the sums over ranks make of it.
#include "energy/load/cavity.hpp"
#include "energy/solid.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <ostream>

namespace pliant {

void PrintTo(const CavityContent& content, std::ostream* out) {
  constexpr std::array names{"given pressure", "gas", "liquid"};
  *out << names[content.index()];
}

}  // namespace pliant

namespace pliant::test_cavity {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

class Contents : public ::testing::TestWithParam<CavityContent> {
 protected:
  double pressure(double S, const LoadState& at) const {
    return std::visit([&](const auto& of) { return of.pressure(S, at); }, GetParam());
  }
  double stiffness(double S, const LoadState& at) const {
    return std::visit([&](const auto& of) { return of.stiffness(S, at); }, GetParam());
  }
  double work(double S, double dS, const LoadState& at) const {
    return std::visit([&](const auto& of) { return of.work(S, dS, at); }, GetParam());
  }
};

INSTANTIATE_TEST_SUITE_P(All, Contents,
                         ::testing::Values(CavityContent(GivenPressure{Expression("3+t")}),
                                           CavityContent(Gas{2.0, 0.5, 4.0, 1.0, Expression("1+t")}),
                                           CavityContent(Gas{2.0, -0.5, 4.0, 1.4, Expression(1.0)}),
                                           CavityContent(Liquid{2.0, 0.3, 9.0, Expression("0.1*t"),
                                                                TimeIntegral(Expression("t"), 1.0, 0.1)})));

// The work is the integral of the pressure (Simpson's rule of many parts), the stiffness its derivative.
TEST_P(Contents, WorkPressureAndStiffnessBelongTogether) {
  const LoadState t{0.7, 0.6};
  for (const double S : {-0.8, 0.0, 0.9}) {
    for (const double dS : {-0.4, 0.3}) {
      constexpr int n = 400;
      double integral = 0.0;
      for (int i = 0; i < n; ++i) {
        const double a = S + dS * i / n, b = S + dS * (i + 1) / n;
        integral += (pressure(a, t) + 4.0 * pressure(0.5 * (a + b), t) + pressure(b, t)) * (b - a) / 6.0;
      }
      EXPECT_NEAR(work(S, dS, t), integral, 1e-10 * std::abs(integral));
    }
    constexpr double h = 1e-4;
    const double slope = (pressure(S + h, t) - pressure(S - h, t)) / (2.0 * h);
    EXPECT_NEAR(stiffness(S, t), slope, 1e-6 * (1.0 + std::abs(slope)));
    EXPECT_GE(stiffness(S, t), 0.0);
    // To the digits of a small change.
    EXPECT_NEAR(work(S, 1e-12, t), 1e-12 * pressure(S, t), 1e-11 * 1e-12 * (10.0 + std::abs(pressure(S, t))));
  }
}

TEST(GasInACavity, KeepsPVToTheN) {
  const Gas gas{2.0, 50.0, 1000.0, 1.4, Expression("1+t")};
  for (const double V : {0.5, 1.0, 2.0, 3.0}) {
    EXPECT_NEAR((gas.pressure(2.0 - V, {0.0}) + 1000.0) * std::pow(V, 1.4), 1050.0 * std::pow(2.0, 1.4), 1e-9);
    EXPECT_NEAR(gas.pressure(2.0 - V, {0.5}) + 1000.0, 1.5 * (gas.pressure(2.0 - V, {0.0}) + 1000.0), 1e-9);
  }
  EXPECT_EQ(gas.work(0.0, 2.0, {}), HUGE_VAL);  // nothing is left
  EXPECT_TRUE(std::isnan(gas.pressure(2.5, {})));
}

class Cavities : public ::testing::TestWithParam<BodySpec> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam()); });
  Solid solid_{comm, file_, GetParam().order, 2};
};

INSTANTIATE_TEST_SUITE_P(Bodies, Cavities,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

// A body stretched by F takes (det F - 1) of its volume from its surroundings, of which there are 3 m^3.
TEST_P(Cavities, ValueAndEnergyAreThoseOfTheWholeVolume) {
  const Gas gas{3.0, 0.5, 4.0, 1.4, Expression(1.0)};
  const auto term = solid_.cavity_around(gas);
  EXPECT_TRUE(term->declaration().is_potential);
  EXPECT_EQ(term->declaration().account, Account::load_potential);
  EXPECT_EQ(solid_.cavity_around(Gas{3.0, 0.5, 4.0, 1.0, Expression("1+t")})->declaration().account, Account::load);
  const auto stretched = [](double x, double y) {
    return [=](const Point& X) { return Point{(x - 1.0) * X[0] + 0.2 * X[1], (y - 1.0) * X[1], 0.0}; };
  };
  TestStage stage(solid_, 0.0, 0.1, stretched(1.1, 0.9));
  stage.point.load_factor = 0.5;
  const LoadState half{0.0, 0.5};
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {term.get()}, solid_.nothing_prescribed());
  potential.begin_stage(stage.point);
  const auto q = solid_.vector(stretched(1.3, 1.2));
  const double body = GetParam().volume(), before = (1.1 * 0.9 - 1.0) * body, after = (1.3 * 1.2 - 1.0) * body;
  EXPECT_NEAR(sum(comm, term->swept(test::local_values(q.get()))), after, 1e-12);
  EXPECT_NEAR(potential.value(q.get()), gas.work(before, after - before, half), 1e-12);
  EXPECT_NEAR(potential.accounts().energies({}, q.get(), nullptr)[0], gas.work(0.0, after, {}), 1e-12);
  // The force along x on the motion x -> x, whose rate of volume is that of the body.
  const Handle<Vec> r = potential.make_vector();
  potential.gradient(q.get(), r.get());
  const auto along_x = solid_.vector([&](const Point& X) { return Point{1.3 * X[0] + 0.2 * X[1], 0.0, 0.0}; });
  EXPECT_NEAR(test::dot(r.get(), along_x.get()), gas.pressure(after, half) * (1.0 + after / body) * body, 1e-11);
}

}  // namespace
}  // namespace pliant::test_cavity
