// Stresses that can be worked out by hand.
#include "states.hpp"

#include <gtest/gtest.h>

namespace pliant {
namespace {

using namespace testing_states;

constexpr double E = 2.0e5;
constexpr double nu = 0.3;
constexpr double tolerance = 1e-14 * E;  // rounding of stresses of order E

Matrix diagonal(double a, double b, double c) {
  return {{a, 0, 0, 0, b, 0, 0, 0, c}};
}

TEST(ClosedForm, LinearUniaxialStress) {
  const auto law = law_of<Linear<double>>(E, nu);
  const double e = 1e-3;
  const Matrix P = law.P(diagonal(e, -nu * e, -nu * e));
  EXPECT_NEAR(P(0, 0), E * e, tolerance);
  EXPECT_NEAR(P(1, 1), 0.0, tolerance);
  EXPECT_NEAR(law.psi(diagonal(e, -nu * e, -nu * e)), 0.5 * E * e * e, tolerance);
}

/// Saint Venant-Kirchhoff, sides free: S_11 = E E_11, hence P_11 = E a (a^2 - 1) / 2 at the stretch a.
TEST(ClosedForm, SaintVenantKirchhoffUniaxialStress) {
  const auto law = law_of<SaintVenantKirchhoff<double>>(E, nu);
  const double a = 1.3;
  const double strain = 0.5 * (a * a - 1);
  const double side = std::sqrt(1 - 2 * nu * strain) - 1;
  const Matrix P = law.P(diagonal(a - 1, side, side));
  EXPECT_NEAR(P(0, 0), E * a * strain, tolerance);
  EXPECT_NEAR(P(1, 1), 0.0, tolerance);
}

/// Code_Aster SSNV121: stretch 1.1 with blocked sides after a quarter turn, Saint Venant-Kirchhoff.
TEST(ClosedForm, SaintVenantKirchhoffStretchedAfterAQuarterTurn) {
  const auto law = law_of<SaintVenantKirchhoff<double>>(E, nu);
  const Matrix Q = rotation(0, 0, 2 * std::atan(1.0));
  const Matrix P = law.P(rotated(Q, diagonal(0.1, 0, 0)));
  EXPECT_NEAR(P(1, 0), 31096.154, 5e-4);         // dead traction on the face that now looks along y
  EXPECT_NEAR(P(0, 1), -11013.986 * 1.1, 5e-4);  // lateral Cauchy stress times the stretched side
  EXPECT_NEAR(P(2, 2), 11013.986 * 1.1, 5e-4);
}

/// Neo-Hookean under F = a I: P = (mu (a - 1/a) + 3 lambda ln(a) / a) I.
TEST(ClosedForm, NeoHookeanHydrostatic) {
  const auto law = law_of<NeoHookean<double>>(E, nu);
  for (const double a : {0.5, 0.9, 1.1, 3.0}) {
    const Matrix P = law.P(diagonal(a - 1, a - 1, a - 1));
    const double expected = law.mu * (a - 1 / a) + 3 * law.lambda * std::log(a) / a;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(P(i, i), expected, 10 * tolerance);
    EXPECT_NEAR(P(0, 1), 0.0, tolerance);
    const double psi =
        1.5 * law.mu * (a * a - 1) - 3 * law.mu * std::log(a) + 0.5 * law.lambda * 9 * std::log(a) * std::log(a);
    EXPECT_NEAR(law.psi(diagonal(a - 1, a - 1, a - 1)), psi, 10 * tolerance);
  }
}

/// Neo-Hookean in simple shear k: J = 1, P = mu (F - F^-T), that is k mu in both shears and nothing on the diagonal but
/// what the shear does: F^-T = [[1, 0], [-k, 1]].
TEST(ClosedForm, NeoHookeanSimpleShear) {
  const auto law = law_of<NeoHookean<double>>(E, nu);
  const double k = 0.7;
  const Matrix H{{0, k, 0, 0, 0, 0, 0, 0, 0}};
  const Matrix P = law.P(H);
  const Matrix expected{{0, law.mu * k, 0, law.mu * k, 0, 0, 0, 0, 0}};
  for (std::size_t n = 0; n < 9; ++n) EXPECT_NEAR(P.a[n], expected.a[n], tolerance);
  EXPECT_NEAR(law.psi(H), 0.5 * law.mu * k * k, tolerance);
}

}  // namespace
}  // namespace pliant
