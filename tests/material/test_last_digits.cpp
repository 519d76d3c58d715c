// The laws keep their digits at strains far below 1, on stiff bodies and on rotated ones.
#include "material/registry.hpp"
#include "states.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_last_digits {
namespace {

using namespace testing_states;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

template <class L>
class LastDigits : public testing::Test {};
TYPED_TEST_SUITE(LastDigits, AlternativesOf<ElasticLawVariant>::type, NameOfLaw);

TYPED_TEST(LastDigits, StiffBodyFromTinyToLargeStrain) {
  for (const VolumetricForm form : forms_of<TypeParam>()) {
    const auto law = typical<TypeParam>(form, 1e3);
    for (const double strain : {1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.2}) {
      for (unsigned seed = 0; seed < 20; ++seed) {
        const Matrix H = random_matrix(seed, strain);
        // Below, the textbook energy, of second order, is itself at the end of the 34 digits of a Quad.
        if (strain >= 1e-8) {
          EXPECT_LE(relative_difference(energy(law, H), textbook_psi(law, converted<Quad>(H))), 32 * epsilon);
        }
        // The difference quotient of the textbook energy has an absolute error of 1e-26 of the stiffness.
        EXPECT_LE(relative_difference(stress(law, H), textbook_P(law, converted<Quad>(H))), 32 * epsilon);
      }
    }
  }
}

// The strains of soft bodies too: where the law gives the state an energy, and the volume is not so small that the
// digits of J are those of a difference.
TYPED_TEST(LastDigits, StressIsRightUpToUnitStrain) {
  for (const VolumetricForm form : forms_of<TypeParam>()) {
    const auto law = typical<TypeParam>(form, 1e3);
    for (const double strain : {1e-10, 1e-7, 1e-4, 1e-2, 0.1, 0.5, 1.0}) {
      int num_admissible = 0;
      for (unsigned seed = 0; seed < 40; ++seed) {
        const Matrix H = random_matrix(seed, strain);
        if (det(add_to_diagonal(H, 1.0)) < 0.1 || !std::isfinite(energy(law, H))) continue;
        ++num_admissible;
        EXPECT_LE(relative_difference(stress(law, H), textbook_P(law, converted<Quad>(H))), 1e-12)
            << strain << " " << seed;
      }
      EXPECT_GE(num_admissible, 10) << strain;
    }
  }
}

/// In a rotated body the entries of H are of order 1 and carry the strain to eps only: P to eps times the stiffness,
/// and psi, of second order, to eps |P|. A law evaluated from F would leave psi nothing at all: it rounds to eps times
/// the stiffness.
TYPED_TEST(LastDigits, RotatedStiffBodyLosesNoMoreThanItsGradientDoes) {
  if constexpr (!TypeParam::constant_tangent) {  // a law linear in H does not know rotations
    const auto law = typical<TypeParam>(VolumetricForm::mixed, 1e3);
    const double size = 3 * stiffness(law);
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Matrix H = rotated(rotation(1.0, 0.3 * seed, -2.0), random_matrix(seed, 1e-8));
      const Tensor3<Quad> P = textbook_P(law, converted<Quad>(H));
      ASSERT_GT(norm(P), 1.0);
      EXPECT_LE(relative_difference(stress(law, H), P) * norm(P), 4 * epsilon * size);
      const double error = static_cast<double>(energy(law, H) - textbook_psi(law, converted<Quad>(H)));
      EXPECT_LE(std::abs(error), 8 * epsilon * norm(P));
    }
  }
}

// Two states of a stiff body that differ by less and less: the change of E has the digits of the change of H.
TEST(LastDigitsOfStrainChanges, AreThoseOfTheIncrement) {
  const auto E = [](const Tensor3<Quad>& H) { return Quad(0.5) * (H + transpose(H) + matmul(transpose(H), H)); };
  for (const double strain : {1e-8, 1e-4, 0.2}) {
    for (const double change : {1.0, 1e-4, 1e-10}) {
      for (unsigned seed = 0; seed < 20; ++seed) {
        const Matrix H = random_matrix(seed, strain), dH = random_matrix(seed + 100, strain * change);
        const Tensor3<Quad> expected = E(converted<Quad>(H) + converted<Quad>(dH)) - E(converted<Quad>(H));
        EXPECT_LE(relative_difference(green_lagrange_change(H, dH), expected), 8 * epsilon);
      }
    }
  }
}

TEST(LastDigitsOfTheTextbookForm, AreLostInDouble) {
  const auto law = law_of<NeoHookean<double>>(1e9, 0.3);
  const Matrix H = random_matrix(1, 1e-8);
  const Matrix F = add_to_diagonal(H, 1.0);
  const Matrix G = (1.0 / det(F)) * cofactor(F);
  const Matrix P = law.mu * (F - G) + (law.lambda * std::log(det(F))) * G;
  EXPECT_GT(relative_difference(P, textbook_P(law, converted<Quad>(H))), 1e-10);
}

TEST(NeoHookeanBarrier, EnergyGrowsWithoutBoundTowardsInversion) {
  const auto law = law_of<NeoHookean<double>>(1.0, 0.3);
  double previous = 0;
  for (const double stretch : {0.5, 1e-1, 1e-2, 1e-4, 1e-8}) {
    const Matrix H{{stretch - 1, 0, 0, 0, 0, 0, 0, 0, 0}};
    const double psi = energy(law, H);
    EXPECT_GT(psi, previous);
    EXPECT_LE(relative_difference(psi, textbook_psi(law, converted<Quad>(H))), 1e-14);
    previous = psi;
  }
}

}  // namespace
}  // namespace pliant::test_last_digits
