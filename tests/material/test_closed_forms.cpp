// Stresses that can be worked out by hand.
#include "states.hpp"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace pliant::test_closed_forms {
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
  const Matrix P = stress(law, diagonal(e, -nu * e, -nu * e));
  EXPECT_NEAR(P(0, 0), E * e, tolerance);
  EXPECT_NEAR(P(1, 1), 0.0, tolerance);
  EXPECT_NEAR(energy(law, diagonal(e, -nu * e, -nu * e)), 0.5 * E * e * e, tolerance);
}

/// Saint Venant-Kirchhoff, sides free: S_11 = E E_11, hence P_11 = E a (a^2 - 1) / 2 at the stretch a.
TEST(ClosedForm, SaintVenantKirchhoffUniaxialStress) {
  const auto law = law_of<SaintVenantKirchhoff<double>>(E, nu);
  const double a = 1.3;
  const double strain = 0.5 * (a * a - 1);
  const double side = std::sqrt(1 - 2 * nu * strain) - 1;
  const Matrix P = stress(law, diagonal(a - 1, side, side));
  EXPECT_NEAR(P(0, 0), E * a * strain, tolerance);
  EXPECT_NEAR(P(1, 1), 0.0, tolerance);
}

/// Code_Aster SSNV121: stretch 1.1 with blocked sides after a quarter turn, Saint Venant-Kirchhoff.
TEST(ClosedForm, SaintVenantKirchhoffStretchedAfterAQuarterTurn) {
  const auto law = law_of<SaintVenantKirchhoff<double>>(E, nu);
  const Matrix Q = rotation(0, 0, 2 * std::atan(1.0));
  const Matrix P = stress(law, rotated(Q, diagonal(0.1, 0, 0)));
  EXPECT_NEAR(P(1, 0), 31096.154, 5e-4);         // dead traction on the face that now looks along y
  EXPECT_NEAR(P(0, 1), -11013.986 * 1.1, 5e-4);  // lateral Cauchy stress times the stretched side
  EXPECT_NEAR(P(2, 2), 11013.986 * 1.1, 5e-4);
}

/// Neo-Hookean under F = a I: P = (mu (a - 1/a) + 3 lambda ln(a) / a) I.
TEST(ClosedForm, NeoHookeanHydrostatic) {
  const auto law = law_of<NeoHookean<double>>(E, nu);
  for (const double a : {0.5, 0.9, 1.1, 3.0}) {
    const Matrix P = stress(law, diagonal(a - 1, a - 1, a - 1));
    const double expected = law.mu * (a - 1 / a) + 3 * law.lambda * std::log(a) / a;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(P(i, i), expected, 10 * tolerance);
    EXPECT_NEAR(P(0, 1), 0.0, tolerance);
    const double psi =
        1.5 * law.mu * (a * a - 1) - 3 * law.mu * std::log(a) + 0.5 * law.lambda * 9 * std::log(a) * std::log(a);
    EXPECT_NEAR(energy(law, diagonal(a - 1, a - 1, a - 1)), psi, 10 * tolerance);
  }
}

/// Neo-Hookean in simple shear k: J = 1, P = mu (F - F^-T), that is k mu in both shears and nothing on the diagonal but
/// what the shear does: F^-T = [[1, 0], [-k, 1]].
TEST(ClosedForm, NeoHookeanSimpleShear) {
  const auto law = law_of<NeoHookean<double>>(E, nu);
  const double k = 0.7;
  const Matrix H{{0, k, 0, 0, 0, 0, 0, 0, 0}};
  const Matrix P = stress(law, H);
  const Matrix expected{{0, law.mu * k, 0, law.mu * k, 0, 0, 0, 0, 0}};
  for (std::size_t n = 0; n < 9; ++n) EXPECT_NEAR(P.a[n], expected.a[n], tolerance);
  EXPECT_NEAR(energy(law, H), 0.5 * law.mu * k * k, tolerance);
}

// Every isotropic law under the tests of a laboratory, against P_i = d psi / d l_i of the textbook energy, written in
// the stretches l by hand.

using Stretches = std::array<double, 3>;

double product(const Stretches& l) {
  return l[0] * l[1] * l[2];
}

/// kappa J U'(J) [Pa].
double kirchhoff_pressure(const Volumetric<double>& v, double J) {
  if (v.form == VolumetricForm::log) return v.kappa * std::log(J);
  if (v.form == VolumetricForm::quadratic) return v.kappa * J * (J - 1);
  return 0.5 * v.kappa * (J * J - 1);
}

/// P_i l_i of psi = W(I1b, I2b) + kappa U(J), where W1 and W2 are W's derivatives.
Stretches from_invariants(const Stretches& l, const Volumetric<double>& volumetric,
                          const std::function<std::array<double, 2>(double I1b, double I2b)>& derivatives) {
  const double J = product(l), a = std::pow(J, -2.0 / 3.0);
  const Stretches s{a * l[0] * l[0], a * l[1] * l[1], a * l[2] * l[2]};
  const double I1 = s[0] + s[1] + s[2], I2 = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
  const auto [W1, W2] = derivatives(I1, I2);
  Stretches P;
  for (std::size_t i = 0; i < 3; ++i) {
    const double deviator = W1 * (s[i] - I1 / 3) + W2 * (s[i] * (I1 - s[i]) - 2 * I2 / 3);
    P[i] = (2 * deviator + kirchhoff_pressure(volumetric, J)) / l[i];
  }
  return P;
}

Stretches principal_stress(const Linear<double>& law, const Stretches& l) {
  const double tr = l[0] + l[1] + l[2] - 3;
  return {2 * law.mu * (l[0] - 1) + law.lambda * tr, 2 * law.mu * (l[1] - 1) + law.lambda * tr,
          2 * law.mu * (l[2] - 1) + law.lambda * tr};
}
Stretches principal_stress(const SaintVenantKirchhoff<double>& law, const Stretches& l) {
  const double tr = 0.5 * (l[0] * l[0] + l[1] * l[1] + l[2] * l[2] - 3);
  Stretches P;
  for (std::size_t i = 0; i < 3; ++i) P[i] = l[i] * (law.mu * (l[i] * l[i] - 1) + law.lambda * tr);
  return P;
}
Stretches principal_stress(const NeoHookean<double>& law, const Stretches& l) {
  Stretches P;
  for (std::size_t i = 0; i < 3; ++i) {
    P[i] = law.mu * (l[i] - 1 / l[i]) + law.lambda * std::log(product(l)) / l[i];
  }
  return P;
}
Stretches principal_stress(const NeoHookeanIsochoric<double>& law, const Stretches& l) {
  return from_invariants(l, law.volumetric, [&](double, double) { return std::array{law.mu / 2, 0.0}; });
}
Stretches principal_stress(const MooneyRivlin<double>& law, const Stretches& l) {
  return from_invariants(l, law.volumetric, [&](double, double) { return std::array{law.c10, law.c01}; });
}
Stretches principal_stress(const MooneyRivlin5<double>& law, const Stretches& l) {
  return from_invariants(l, law.volumetric, [&](double I1, double I2) {
    return std::array{law.c10 + 2 * law.c20 * (I1 - 3) + law.c11 * (I2 - 3),
                      law.c01 + law.c11 * (I1 - 3) + 2 * law.c02 * (I2 - 3)};
  });
}
Stretches principal_stress(const MooneyRivlinCoupled<double>& law, const Stretches& l) {
  const double I1 = l[0] * l[0] + l[1] * l[1] + l[2] * l[2], log_J = std::log(product(l));
  Stretches P;
  for (std::size_t i = 0; i < 3; ++i) {
    const double square = l[i] * l[i];
    P[i] = (2 * law.c1 * (square - 1) + 2 * law.c2 * (square * (I1 - square) - 2) + law.lambda * log_J) / l[i];
  }
  return P;
}
Stretches principal_stress(const Yeoh<double>& law, const Stretches& l) {
  return from_invariants(l, law.volumetric, [&](double I1, double) {
    return std::array{law.c10 + 2 * law.c20 * (I1 - 3) + 3 * law.c30 * (I1 - 3) * (I1 - 3), 0.0};
  });
}
Stretches principal_stress(const Gent<double>& law, const Stretches& l) {
  return from_invariants(l, law.volumetric, [&](double I1, double) {
    return std::array{law.mu / 2 * law.stretch_limit / (law.stretch_limit - (I1 - 3)), 0.0};
  });
}
/// dW/dI1b by Arruda & Boyce's series.
double arruda_boyce_slope(const ArrudaBoyce<double>& law, double I1) {
  const double s = 1 / (law.locking_stretch * law.locking_stretch);
  const auto series = [s](double I) {
    return 0.5 + I * s / 10 + 11 * I * I * s * s / 350 + 19 * std::pow(I * s, 3) / 1750 +
           519 * std::pow(I * s, 4) / 134750;
  };
  return law.mu * series(I1) / (2 * series(3));
}
Stretches principal_stress(const ArrudaBoyce<double>& law, const Stretches& l) {
  return from_invariants(l, law.volumetric, [&](double I1, double) {
    return std::array{arruda_boyce_slope(law, I1), 0.0};
  });
}
Stretches principal_stress(const Ogden<double>& law, const Stretches& l) {
  const double J = product(l), c = std::cbrt(J);
  Stretches P{};
  for (std::size_t p = 0; p < law.mu.size(); ++p) {
    Stretches power;
    for (std::size_t i = 0; i < 3; ++i) power[i] = std::pow(l[i] / c, law.alpha[p]);
    const double mean = (power[0] + power[1] + power[2]) / 3;
    for (std::size_t i = 0; i < 3; ++i) P[i] += 2 * law.mu[p] / law.alpha[p] * (power[i] - mean) / l[i];
  }
  for (std::size_t i = 0; i < 3; ++i) P[i] += kirchhoff_pressure(law.volumetric, J) / l[i];
  return P;
}
Stretches principal_stress(const StableNeoHookean<double>& law, const Stretches& l) {
  const double m = 4 * law.mu / 3, k = law.lambda + 5 * law.mu / 6, alpha = 1 + 0.75 * m / k;
  const double I_C = l[0] * l[0] + l[1] * l[1] + l[2] * l[2], J = product(l);
  Stretches P;
  for (std::size_t i = 0; i < 3; ++i) P[i] = m * (1 - 1 / (I_C + 1)) * l[i] + k * (J - alpha) * J / l[i];
  return P;
}
Stretches principal_stress(const FixedCorotated<double>& law, const Stretches& l) {
  Stretches P;
  for (std::size_t i = 0; i < 3; ++i) {
    P[i] = 2 * law.mu * (l[i] - 1) + law.lambda * (product(l) - 1) * product(l) / l[i];
  }
  return P;
}
Stretches principal_stress(const Arap<double>& law, const Stretches& l) {
  return {2 * law.mu * (l[0] - 1), 2 * law.mu * (l[1] - 1), 2 * law.mu * (l[2] - 1)};
}

/// The stretch of the free sides, whose stress grows with it.
double free_stretch(const std::function<double(double)>& stress) {
  double low = 0.2, high = 2.0;
  for (int i = 0; i < 80; ++i) {
    const double m = 0.5 * (low + high);
    (stress(m) < 0 ? low : high) = m;
  }
  return 0.5 * (low + high);
}

template <class L>
class EveryIsotropicLaw : public testing::Test {
 protected:
  /// Calls `check(law, tolerance)` for the law in each of its volumetric forms; 1e-13: the formulas above cancel.
  template <class Check>
  static void for_each_form(Check check) {
    if constexpr (IsotropicLaw<L>) {
      for (const VolumetricForm form : forms_of<L>()) {
        SCOPED_TRACE(volumetric_form_names[static_cast<std::size_t>(form)]);
        const L law = typical<L>(form);
        check(law, 1e-13 * stiffness(law));
      }
    }
  }

  /// The law's stress at the stretches l is the textbook's, whose sides are free.
  static void expect_stress(const L& law, const Stretches& l, double allowed) {
    if constexpr (IsotropicLaw<L>) {
      const Matrix P = stress(law, diagonal(l[0] - 1, l[1] - 1, l[2] - 1));
      const Stretches expected = principal_stress(law, l);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(P(i, i), expected[static_cast<std::size_t>(i)], allowed);
      EXPECT_NEAR(P(2, 2), 0.0, allowed);
    }
  }
};
TYPED_TEST_SUITE(EveryIsotropicLaw, AlternativesOf<ElasticLawVariant>::type, NameOfLaw);

TYPED_TEST(EveryIsotropicLaw, UniaxialTensionWithFreeSides) {
  this->for_each_form([&](const auto& law, double allowed) {
    for (const double l : {0.8, 0.95, 1.2, 1.5}) {
      const double m = free_stretch([&](double s) { return principal_stress(law, {l, s, s})[2]; });
      ASSERT_LE(l > 1 ? m : 1 / m, 1.0);
      ASSERT_GT((l - 1) * principal_stress(law, {l, m, m})[0], 0.0);
      this->expect_stress(law, {l, m, m}, allowed);
    }
  });
}

TYPED_TEST(EveryIsotropicLaw, EquibiaxialTensionWithFreeFaces) {
  this->for_each_form([&](const auto& law, double allowed) {
    for (const double l : {0.9, 1.1, 1.3}) {
      const double m = free_stretch([&](double s) { return principal_stress(law, {l, l, s})[2]; });
      ASSERT_GT((l - 1) * principal_stress(law, {l, l, m})[0], 0.0);
      this->expect_stress(law, {l, l, m}, allowed);
    }
  });
}

/// F = I + k e_x e_y^T: l_1 - 1/l_1 = k, l_2 = 1/l_1, n_1 along (1, l_1), n_2 along (l_1, -1), r_i = F n_i / l_i.
TYPED_TEST(EveryIsotropicLaw, SimpleShear) {
  if constexpr (!TypeParam::constant_tangent) {  // to which a shear of k is a strain of k/2
    this->for_each_form([&](const auto& law, double allowed) {
      for (const double k : {0.1, 0.7, 1.5}) {
        const double l = 0.5 * (k + std::sqrt(k * k + 4)), c = 1 / std::sqrt(1 + l * l), s = l * c;
        const Stretches P_i = principal_stress(law, {l, 1 / l, 1});
        const std::array<std::array<double, 2>, 2> n{{{c, s}, {s, -c}}};
        const std::array<double, 2> stretch{l, 1 / l};
        Matrix expected = diagonal(0, 0, P_i[2]);
        for (std::size_t m = 0; m < 2; ++m) {
          const std::array<double, 2> r{(n[m][0] + k * n[m][1]) / stretch[m], n[m][1] / stretch[m]};
          for (int i = 0; i < 2; ++i) {
            for (int J = 0; J < 2; ++J) {
              expected(i, J) += P_i[m] * r[static_cast<std::size_t>(i)] * n[m][static_cast<std::size_t>(J)];
            }
          }
        }
        const Matrix H{{0, k, 0, 0, 0, 0, 0, 0, 0}}, P = stress(law, H);
        for (std::size_t q = 0; q < 9; ++q) EXPECT_NEAR(P.a[q], expected.a[q], 4 * allowed);
        // Rivlin: the normal stresses differ by k times the shear stress, whatever the law.
        const Matrix sigma = matmul(P, transpose(add_to_diagonal(H, 1.0)));
        EXPECT_GT(sigma(0, 1), 0.0);
        EXPECT_NEAR(sigma(0, 0) - sigma(1, 1), k * sigma(0, 1), 8 * allowed);
      }
    });
  }
}

// The same test of incompressible bodies, as published: Cauchy stress over stretch (Holzapfel, Nonlinear Solid
// Mechanics (2000), sections 6.4 and 6.5, and the papers of the laws).
template <class L>
double published_tension(const L& law, double l) {
  const double stretches = l * l - 1 / l, I1 = l * l + 2 / l;
  if constexpr (std::is_same_v<L, NeoHookeanIsochoric<double>>) return law.mu * stretches;
  if constexpr (std::is_same_v<L, MooneyRivlin<double>>) return 2 * (law.c10 + law.c01 / l) * stretches;
  if constexpr (std::is_same_v<L, Yeoh<double>>) {
    return 2 * stretches * (law.c10 + 2 * law.c20 * (I1 - 3) + 3 * law.c30 * (I1 - 3) * (I1 - 3));
  }
  if constexpr (std::is_same_v<L, Gent<double>>) {
    return law.mu * law.stretch_limit / (law.stretch_limit - I1 + 3) * stretches;
  }
  if constexpr (std::is_same_v<L, ArrudaBoyce<double>>) return 2 * arruda_boyce_slope(law, I1) * stretches;
  if constexpr (std::is_same_v<L, Ogden<double>>) {
    double sum = 0;
    for (std::size_t p = 0; p < law.mu.size(); ++p) {
      sum += 2 * law.mu[p] / law.alpha[p] * (std::pow(l, law.alpha[p]) - std::pow(l, -law.alpha[p] / 2));
    }
    return sum;
  }
}

template <class L>
class NearlyIncompressible : public testing::Test {};
using PublishedLaws = testing::Types<NeoHookeanIsochoric<double>, MooneyRivlin<double>, Yeoh<double>, Gent<double>,
                                     ArrudaBoyce<double>, Ogden<double>>;
TYPED_TEST_SUITE(NearlyIncompressible, PublishedLaws, NameOfLaw);

TYPED_TEST(NearlyIncompressible, UniaxialTensionAsPublished) {
  for (const VolumetricForm form : forms_of<TypeParam>()) {
    TypeParam law = typical<TypeParam>(form);
    law.volumetric.kappa = 1e6 * law.at_rest().mu;
    for (const double l : {0.5, 0.8, 1.3, 2.0, 3.5}) {
      const auto P = [&](double m) { return stress(law, diagonal(l - 1, m - 1, m - 1)); };
      const double m = free_stretch([&](double s) { return P(s)(1, 1); });
      const double sigma = P(m)(0, 0) / (m * m), expected = published_tension(law, l);
      // J - 1 = sigma / (3 kappa), and the stress is a power of J at most.
      EXPECT_NEAR(sigma, expected, 10 * std::abs(expected) * (1 + std::abs(expected) / law.at_rest().mu) * 1e-6) << l;
    }
  }
}

/// Terms of alpha = 2 and -2 are those of Mooney and Rivlin; alpha = 0 is where both sides of it meet.
TEST(ClosedForm, OgdenHasMooneyRivlinAndHenckyInIt) {
  const std::array<double, 9> terms{300e3, 2, 100e3, -2, 0, 2, 0, 2, 2e6};
  const auto ogden = Ogden<double>::of({terms});
  const MooneyRivlin<double> mooney(150e3, 50e3, {2e6, VolumetricForm::mixed});
  const auto single = [](double alpha) {
    const std::array<double, 9> one{400e3, alpha, 0, 2, 0, 2, 0, 2, 2e6};
    return Ogden<double>::of({one});
  };
  EXPECT_EQ(ogden.num_terms, 2u);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Matrix H = moderate_state(seed);
    EXPECT_NEAR(energy(ogden, H), energy(mooney, H), 1e-14 * stiffness(mooney));
    EXPECT_LE(norm(stress(ogden, H) - stress(mooney, H)), 1e-13 * stiffness(mooney));
    const Matrix dH = random_matrix(seed, 1.0);
    EXPECT_LE(norm(increment(ogden, H, dH) - increment(mooney, H, dH)), 1e-13 * stiffness(mooney));
    const Matrix hencky = stress(single(0), H), beside = 0.5 * (stress(single(1e-4), H) + stress(single(-1e-4), H));
    EXPECT_LE(norm(hencky - beside), 1e-8 * stiffness(mooney));  // of the order of alpha^2
    EXPECT_NEAR(energy(single(0), H), static_cast<double>(textbook_psi(single(0), converted<Quad>(H))), 1e-14 * 2e6);
  }
}

/// `arap` keeps its sides when pulled, as a body of Poisson's ratio 0.
TEST(ClosedForm, AsRigidAsPossibleKeepsItsSides) {
  const auto law = typical<Arap<double>>();
  const Matrix P = stress(law, diagonal(0.4, 0, 0));
  EXPECT_NEAR(P(0, 0), 0.8 * law.mu, 1e-14 * law.mu);
  EXPECT_NEAR(P(1, 1), 0.0, 1e-14 * law.mu);
}

}  // namespace
}  // namespace pliant::test_closed_forms
