// What the laws do in flat and inverted bodies, and at a limit of stretch.
#include "base/limits.hpp"
#include "material/energy_change.hpp"
#include "material/registry.hpp"
#include "states.hpp"

#include <cfenv>
#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_inversion {
namespace {

using namespace testing_states;

/// A typical state in all lanes but the last, which has `bad`.
Tensor3<Pack> with_bad_lane(const Matrix& good, const Matrix& bad) {
  Tensor3<Pack> H;
  for (std::size_t n = 0; n < 9; ++n) {
    H.a[n] = Pack([&](auto lane) { return lane + 1 == Pack::size() ? bad.a[n] : good.a[n]; });
  }
  return H;
}

/// psi is +inf and everything else is NaN in the last lane alone; no floating-point exception is raised.
void expect_infinite_alone_and_quietly(const ElasticLawSpec& spec, const Matrix& bad) {
  const ElasticLawVariant law = instantiate(spec);
  const auto field = make_law_field(spec);
  const Matrix good = moderate_state(5);
  const Tensor3<Pack> H = with_bad_lane(good, bad);
  std::feclearexcept(FE_ALL_EXCEPT);
  const Pack psi = field->psi(0, H);
  const Tensor3<Pack> P = field->P(0, H);
  Tangent<Pack> A;
  field->tangent(0, H, A);
  const double psi_alone = energy(law, bad);
  EXPECT_EQ(std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW), 0);

  EXPECT_EQ(psi_alone, infinity);
  EXPECT_EQ(psi[pack_size - 1], infinity);
  EXPECT_LE(relative_difference(psi[0], energy(law, good)), 1e-14);
  const auto expect_bad_alone = [](const Pack& x) {
    EXPECT_TRUE(std::isnan(static_cast<double>(x[pack_size - 1])));
    EXPECT_TRUE(std::isfinite(static_cast<double>(x[0])));
  };
  for (const Pack& x : P.a) expect_bad_alone(x);
  for (const Pack& x : A) expect_bad_alone(x);
}

template <class L>
class Inversion : public testing::Test {};
TYPED_TEST_SUITE(Inversion, AlternativesOf<ElasticLawVariant>::type, NameOfLaw);

TYPED_TEST(Inversion, BarrierGrowsWithoutBound) {
  if constexpr (TypeParam::is_barrier) {
    const auto law = typical<TypeParam>();
    double previous = 0;
    for (const double stretch : {0.5, 1e-1, 1e-2, 1e-4, 1e-8}) {
      const double psi = energy(law, Matrix{{stretch - 1, 0, 0, 0, 0, 0, 0, 0, 0}});
      EXPECT_TRUE(psi > previous || psi == infinity) << stretch;
      previous = psi;
    }
    EXPECT_GT(previous, 4 * energy(law, Matrix{{-0.5, 0, 0, 0, 0, 0, 0, 0, 0}}));
  }
}

TYPED_TEST(Inversion, InvertedLanesOfABarrierAreInfiniteAloneAndQuietly) {
  if constexpr (TypeParam::is_barrier) {
    for (const VolumetricForm form : forms_of<TypeParam>()) {
      for (const double stretch : {0.0, -0.3, -2.0}) {  // 0 is flat
        expect_infinite_alone_and_quietly(typical_spec<TypeParam>(form),
                                          Matrix{{stretch - 1, 0, 0, 0, 0.1, 0, 0, 0, 0}});
      }
    }
  }
}

TYPED_TEST(Inversion, UndefinedGradientCountsAsInverted) {
  if constexpr (TypeParam::is_barrier) {
    const auto law = typical<TypeParam>();
    Matrix H = moderate_state(1);
    H(1, 2) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(energy(law, H), infinity);
    EXPECT_TRUE(std::isnan(stress(law, H)(0, 0)));
  }
}

/// Whatever was done to the body: thrown to a point, a thread, a sheet, turned inside out.
TYPED_TEST(Inversion, WithoutABarrierEverythingIsFinite) {
  if constexpr (!TypeParam::is_barrier) {
    const auto law = typical<TypeParam>();
    std::vector<Matrix> states{{{-1, 0, 0, 0, -1, 0, 0, 0, -1}}, {{-2, 0, 0, 0, -2, 0, 0, 0, -2}},
                               {{0, 0, 0, 0, -1, 0, 0, 0, -1}},  {{0, 0, 0, 0, 0, 0, 0, 0, -1}},
                               {{0, 0, 0, 0, 0, 0, 0, 0, -2}},   {{0, 0, 0, 0, -0.5, 0, 0, 0, -1.5}}};
    for (unsigned seed = 0; seed < 20; ++seed) states.push_back(random_matrix(seed, 3.0));
    for (const Matrix& H : states) {
      EXPECT_TRUE(std::isfinite(energy(law, H)));
      EXPECT_GE(energy(law, H), 0.0);
      EXPECT_TRUE(std::isfinite(norm(stress(law, H))));
      for (const double a : stiffness_tensor(law, H)) EXPECT_TRUE(std::isfinite(a));
    }
  }
}

/// P is the gradient of the energy there too: the energy of an inverted body, downhill, leads back to a body at rest.
template <class L>
class InversionSafe : public testing::Test {};
using InversionSafeLaws = testing::Types<StableNeoHookean<double>, FixedCorotated<double>, Arap<double>>;
TYPED_TEST_SUITE(InversionSafe, InversionSafeLaws, NameOfLaw);

TYPED_TEST(InversionSafe, StressIsTheGradientOfTheEnergyOfAnInvertedBody) {
  const auto law = typical<TypeParam>();
  const Matrix Q = rotation(0.4, -0.3, 1.2);
  for (unsigned seed = 0; seed < 20; ++seed) {
    // The smallest stretch is about -0.4, far from being minus another one.
    const Matrix H = rotated(Q, Matrix{{0.3, 0, 0, 0, 0, 0, 0, 0, -1.4}} + random_matrix(seed, 0.1));
    ASSERT_LT(det(add_to_diagonal(H, 1.0)), -0.1);
    const Matrix dH = random_matrix(seed + 50, 1.0);
    const double h = 1e-5;
    const double difference = (energy(law, H + h * dH) - energy(law, H + (-h) * dH)) / (2 * h);
    EXPECT_NEAR(dot(stress(law, H), dH), difference, 1e-8 * stiffness(law));
    const Matrix stresses = (0.5 / h) * (stress(law, H + h * dH) - stress(law, H + (-h) * dH));
    EXPECT_LE(norm(increment(law, H, dH) - stresses), 1e-8 * stiffness(law));
  }
}

TYPED_TEST(InversionSafe, DescentLeadsBackToRest) {
  const auto law = typical<TypeParam>();
  const double step = 0.2 / stiffness(law);
  for (unsigned seed = 0; seed < 10; ++seed) {
    Matrix H = Matrix{{0, 0, 0, 0, 0, 0, 0, 0, -1.6}} + random_matrix(seed, 0.2);
    ASSERT_LT(det(add_to_diagonal(H, 1.0)), 0.0);
    double psi = energy(law, H);
    for (int n = 0; n < 2000; ++n) {
      H = H + (-step) * stress(law, H);
      const double next = energy(law, H);
      EXPECT_LE(next, psi * (1 + 1e-12) + 1e-20 * stiffness(law));
      psi = next;
    }
    EXPECT_LE(psi, 1e-12 * stiffness(law));
    EXPECT_NEAR(det(add_to_diagonal(H, 1.0)), 1.0, 1e-6);
  }
}

// I1b - 3 of a uniaxial stretch is l^2 + 2/l - 3; typical Jm = 20 is at l = 4.7517...

Matrix pulled(double l) {
  const double side = 1 / std::sqrt(l);
  return {{l - 1, 0, 0, 0, side - 1, 0, 0, 0, side - 1}};
}

TEST(StretchLimit, BeyondItIsInfiniteAloneAndQuietly) {
  const auto law = typical<Gent<double>>();
  EXPECT_TRUE(std::isfinite(energy(law, pulled(4.75))));
  EXPECT_GT(stress(law, pulled(4.75))(0, 0), 1e3 * law.mu);
  for (const double l : {4.76, 10.0}) expect_infinite_alone_and_quietly(typical_spec<Gent<double>>(), pulled(l));
}

/// Small steps near the limit: those that cross it, and the others to the digits of the change.
TEST(StretchLimit, ChangesOfEnergyNearIt) {
  const auto law = typical<Gent<double>>();
  EXPECT_EQ(energy_change(law, pulled(4.75), pulled(4.76) - pulled(4.75)), infinity);
  for (const double l : {2.0, 4.7, 4.75}) {
    for (const double dl : {-1e-3, 3e-4, 1e-6, 1e-9}) {
      const Matrix H = pulled(l), dH = pulled(l + dl) - H;
      const Quad expected =
          textbook_psi(law, converted<Quad>(H) + converted<Quad>(dH)) - textbook_psi(law, converted<Quad>(H));
      EXPECT_LE(relative_difference(energy_change(law, H, dH), expected), 1e-9) << l << " " << dl;
    }
  }
}

}  // namespace
}  // namespace pliant::test_inversion
