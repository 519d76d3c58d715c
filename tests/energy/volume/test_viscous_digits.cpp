// Viscous forces and potentials keep their digits where strains, or their changes, are small.
#include "energy/reference.hpp"
#include "energy/volume/viscous_body.hpp"

#include <fmt/format.h>

namespace pliant::test_viscous_digits {
namespace {

using test::at_time;
using test::Point;
using test::Quad;
using test::TestStage;

constexpr double dt = test::viscous_dt;

class ViscousDigits : public test::EveryViscosity {};

INSTANTIATE_TEST_SUITE_P(Registry, ViscousDigits, ::testing::ValuesIn(test::every_viscous_case()),
                         [](const auto& of) { return test::name_of(of.param.law) + test::name_of(of.param.body); });

/// E of H in four times the digits.
Tensor3<Quad> strain(const Tensor3<Quad>& H) {
  return Quad(0.5) * (H + transpose(H) + matmul(transpose(H), H));
}

// Strains of 1e-8 that change by as much. Gradients of the shape functions in double do not sum to zero exactly: what a
// rigid motion of the size of q makes of that is beyond both sides.
TEST_P(ViscousDigits, ForcesOfStrainsOf1e8KeepTheirDigits) {
  const auto tiny = [](int seed) {
    return [seed](const Point& x) {
      return Point{1e-8 * (x[0] * x[1] + 0.1 * test::rough(x, 0, seed)), 1e-8 * (x[2] * x[2] - seed * x[0]),
                   1e-8 * (x[1] + 0.3 * x[2] + 0.1 * test::rough(x, 2, seed))};
    };
  };
  const auto q0 = test::local_values(solid_.vector(tiny(1)).get());
  const auto q = test::local_values(solid_.vector(tiny(2)).get());
  std::vector<double> z0(body_.term->num_internal());
  constexpr std::array<double, 6> G0{1e-8, -0.5e-8, 0.2e-8, 0.3e-8, 0.0, -0.4e-8};
  for (std::size_t k = 0; k < z0.size(); ++k) z0[k] = G0[k % 6];
  const Tensor3<Quad> G{{G0[0], G0[3], G0[5], G0[3], G0[1], G0[4], G0[5], G0[4], G0[2]}};
  const auto stress = [&](const test::Gradients& H) {
    const Tensor3<Quad> F = add_to_diagonal(H[1], 1);
    Tensor3<Quad> D = strain(H[1]) - (z0.empty() ? strain(H[0]) : G);
    if (is_exact_) {
      const Tensor3<Quad> A = matmul(transpose(F), H[1] - H[0]);
      D = Quad(0.5) * (A + transpose(A));
    }
    Quad shear = 0, bulk = 0;
    if (body_.maxwell != nullptr) {
      const Quad yield = 1 + Quad(dt) / body_.maxwell->relaxation_time;
      shear = body_.maxwell->shear_modulus / yield, bulk = body_.maxwell->bulk_modulus / yield;
    } else if (const auto* kelvin_voigt = std::get_if<WithStrainRate<KelvinVoigt>>(&GetParam().law)) {
      shear = kelvin_voigt->law.shear / Quad(dt), bulk = kelvin_voigt->law.bulk / Quad(dt);
    } else {
      const auto& law = std::get<WithStrainRate<StiffnessProportional>>(GetParam().law).law;
      const auto& C0 = test::stiffness_at_rest;
      shear = law.time * Quad(C0.shear) / dt, bulk = law.time * Quad(C0.bulk) / dt;
    }
    return matmul(F, add_to_diagonal(2 * shear * D, (bulk - 2 * shear / 3) * trace(D)));
  };
  std::vector<double> r(q.size(), 0.0);
  body_.term->add_gradient({0.7, dt, 1.0, q0, q0, z0}, q, r);
  const int degree = 2 * (GetParam().body.order - 1);
  const auto [error, size] = test::error_and_size(solid_, degree, r, {q0, q}, stress);
  ASSERT_GT(size, 1e-7);  // some 100 Pa at strains of 1e-8
  EXPECT_LE(error, 2e-14 * size);
  RecordProperty("relative_error", fmt::format("{:.1e}", error / size));
}

/// The field rounded to multiples of 2^-50, so that sums and halves of such values of size one are exact.
test::Field on_grid(const test::Field& field) {
  return [field](const Point& x) {
    Point u = field(x);
    for (double& c : u) c = std::ldexp(std::round(std::ldexp(c, 50)), -50);
    return u;
  };
}

// A strained body that hardly moves while its dashpots do: the change of the potential is 1e-10 of it and less.
// Simpson's rule over the path is exact: the potential is a quartic.
TEST_P(ViscousDigits, SmallChangesOfThePotentialKeepTheirDigits) {
  if (is_exact_) return;
  TestStage stage(solid_, 0.7, dt, on_grid(test::strained));
  stage.set_internal(solid_, body_.potential, at_time(0.3));
  body_.potential.begin_stage(stage.point);
  for (const double size : {1e-4, 1e-7, 1e-10}) {
    const auto step = solid_.vector(on_grid(test::rough_field(size, 8)));
    const auto q = test::moved(stage.q0.get(), 1.0, step.get());
    const auto slope = [&](double s) {
      return test::dot(body_.gradient(test::moved(stage.q0.get(), s, step.get())).get(), step.get());
    };
    const double expected = (slope(0.0) + 4.0 * slope(0.5) + slope(1.0)) / 6.0;
    ASSERT_GT(std::abs(expected), 0.0);
    const double value = body_.potential.value(q.get());
    EXPECT_NEAR(value, expected, 1e-12 * std::abs(expected)) << "increment " << size;
  }
}

}  // namespace
}  // namespace pliant::test_viscous_digits
