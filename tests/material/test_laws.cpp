// What every law must satisfy, run over the registry's list.
#include "material/law_field.hpp"
#include "material/registry.hpp"
#include "material/volume_split.hpp"
#include "states.hpp"

#include <gtest/gtest.h>

namespace pliant::test_laws {
namespace {

using namespace testing_states;

template <class L>
class EveryLaw : public testing::Test {
 protected:
  static constexpr unsigned num_states = 100;
  static constexpr unsigned few_states = 10;

  /// Calls `check(law)` for the law in each of its volumetric forms.
  template <class Check>
  static void for_each_form(Check check) {
    for (const VolumetricForm form : forms_of<L>()) {
      SCOPED_TRACE(volumetric_form_names[static_cast<std::size_t>(form)]);
      check(typical<L>(form));
    }
  }
};
TYPED_TEST_SUITE(EveryLaw, AlternativesOf<ElasticLawVariant>::type, NameOfLaw);

TYPED_TEST(EveryLaw, EnergyIsTheTextbooks) {
  this->for_each_form([&](const TypeParam& law) {
    for (unsigned seed = 0; seed < this->num_states; ++seed) {
      const Matrix H = moderate_state(seed);
      const Quad expected = textbook_psi(law, converted<Quad>(H));
      EXPECT_LE(std::abs(static_cast<double>(energy(law, H) - expected)), 2e-15 * stiffness(law)) << seed;
    }
  });
}

TYPED_TEST(EveryLaw, StressIsTheGradientOfTheEnergy) {
  this->for_each_form([&](const TypeParam& law) {
    for (unsigned seed = 0; seed < this->num_states; ++seed) {
      const Matrix H = moderate_state(seed);
      const Tensor3<Quad> expected = textbook_P(law, converted<Quad>(H));
      ASSERT_GT(norm(expected), 1e-3 * stiffness(law));
      EXPECT_LE(relative_difference(stress(law, H), expected), 1e-13) << seed;
      EXPECT_LE(relative_difference(linearized(law, H, H).P, expected), 1e-13) << seed;
    }
  });
}

/// Against the energy's second differences, whose error is 1e-14 of it.
TYPED_TEST(EveryLaw, TangentIsTheGradientOfTheStress) {
  this->for_each_form([&](const TypeParam& law) {
    for (unsigned seed = 0; seed < this->few_states; ++seed) {
      const Matrix H = moderate_state(seed);
      const Tangent<double> A = stiffness_tensor(law, H);
      double size = 0;
      for (const double a : A) size = std::max(size, std::abs(a));
      for (std::size_t q = 0; q < 9; ++q) {
        const Tensor3<Quad> expected =
            central_difference([&](const Tensor3<Quad>& X) { return textbook_P(law, X); }, converted<Quad>(H), q);
        Matrix dH{};
        dH.a[q] = 1.0;
        const Matrix column = increment(law, H, dH);
        for (std::size_t p = 0; p < 9; ++p) {
          EXPECT_NEAR(A[9 * p + q], static_cast<double>(expected.a[p]), 1e-12 * size);
          EXPECT_NEAR(column.a[p], static_cast<double>(expected.a[p]), 1e-12 * size);
          EXPECT_EQ(A[9 * p + q], A[9 * q + p]);
        }
      }
    }
  });
}

/// In each of the states: the increment of the stress is the difference quotient of the stress.
TYPED_TEST(EveryLaw, IncrementIsTheDifferenceOfTheStress) {
  this->for_each_form([&](const TypeParam& law) {
    for (unsigned seed = 0; seed < this->num_states; ++seed) {
      const Matrix H = moderate_state(seed), dH = random_matrix(seed + 1000, 1.0);
      const double h = 1e-5;
      const Matrix difference = (0.5 / h) * (stress(law, H + h * dH) - stress(law, H + (-h) * dH));
      EXPECT_LE(relative_difference(increment(law, H, dH), difference), 1e-6) << seed;
    }
  });
}

TYPED_TEST(EveryLaw, RestIsFreeOfStress) {
  this->for_each_form([&](const TypeParam& law) {
    EXPECT_EQ(energy(law, Matrix{}), 0.0);
    EXPECT_EQ(norm(stress(law, Matrix{})), 0.0);
  });
}

TYPED_TEST(EveryLaw, AtRestIsHookesLaw) {
  if constexpr (IsotropicLaw<TypeParam>) {
    this->for_each_form([&](const TypeParam& law) {
      const auto [mu, lambda] = law.at_rest();
      const Tangent<double> A = stiffness_tensor(law, Matrix{});
      const auto delta = [](std::size_t i, std::size_t j) { return i == j ? 1.0 : 0.0; };
      for (std::size_t p = 0; p < 9; ++p) {
        for (std::size_t q = 0; q < 9; ++q) {
          const std::size_t i = p / 3, J = p % 3, k = q / 3, L = q % 3;
          const double expected =
              mu * (delta(i, k) * delta(J, L) + delta(i, L) * delta(J, k)) + lambda * delta(i, J) * delta(k, L);
          EXPECT_NEAR(A[9 * p + q], expected, 1e-15 * stiffness(law));
        }
      }
    });
  } else {
    // A strain costs energy in every direction.
    const TypeParam law = typical<TypeParam>();
    for (unsigned seed = 0; seed < this->num_states; ++seed) {
      const Matrix eps = small_strain(random_matrix(seed, 1.0));
      EXPECT_GT(dot(eps, increment(law, Matrix{}, eps)), 0.0);
      EXPECT_LE(norm(increment(law, Matrix{}, random_matrix(seed, 1.0) - transpose(random_matrix(seed, 1.0)))),
                1e-14 * stiffness(law));
    }
  }
}

TYPED_TEST(EveryLaw, RotationNeitherStressesNorChangesTheEnergy) {
  const Matrix Q = rotation(0.7, -1.9, 1.1);
  const Matrix rigid = add_to_diagonal(Q, -1.0);
  this->for_each_form([&](const TypeParam& law) {
    if constexpr (TypeParam::constant_tangent) {
      EXPECT_GT(norm(stress(law, rigid)), 0.1 * stiffness(law));  // a law linear in H cannot know a rotation
    } else {
      // The strain of a rounded rotation is of the order of 1e-16.
      EXPECT_LE(norm(stress(law, rigid)), 1e-14 * stiffness(law));
      EXPECT_LE(std::abs(energy(law, rigid)), 1e-30 * stiffness(law));
      for (unsigned seed = 0; seed < this->num_states; ++seed) {
        const Matrix H = moderate_state(seed);
        EXPECT_LE(std::abs(energy(law, rotated(Q, H)) - energy(law, H)), 1e-14 * stiffness(law));
        EXPECT_LE(norm(stress(law, rotated(Q, H)) - matmul(Q, stress(law, H))), 1e-13 * stiffness(law));
      }
    }
  });
}

/// An isotropic body does not know how it lay before it was stretched.
TYPED_TEST(EveryLaw, TurnedBodyIsTheSameIfIsotropic) {
  if constexpr (TypeParam::num_directions == 0) {
    const Matrix Q = rotation(-0.4, 0.9, 1.3);
    this->for_each_form([&](const TypeParam& law) {
      for (unsigned seed = 0; seed < this->few_states; ++seed) {
        const Matrix H = moderate_state(seed);
        const Matrix turned = matmul(H, transpose(Q));  // F Q^T = Q^T + H Q^T, in the frame turned back
        EXPECT_LE(std::abs(energy(law, matmul(Q, turned)) - energy(law, H)), 1e-14 * stiffness(law));
      }
    });
  }
}

TYPED_TEST(EveryLaw, PackEqualsScalarLaneByLane) {
  Tensor3<Pack> H, dH;
  for (std::size_t n = 0; n < 9; ++n) {
    H.a[n] = Pack([&](auto lane) { return moderate_state(lane).a[n]; });
    dH.a[n] = Pack([&](auto lane) { return moderate_state(lane + 100).a[n]; });
  }
  const TypeParam law = typical<TypeParam>();
  const double size = stiffness(law);
  const auto field = make_law_field(typical_spec<TypeParam>());
  const Pack psi = field->psi(0, H), change = field->psi_change(0, H, dH);
  const Tensor3<Pack> P = field->P(0, H);
  Tangent<Pack> A;
  field->tangent(0, H, A);
  for (unsigned lane = 0; lane < Pack::size(); ++lane) {
    const Matrix h = moderate_state(lane);
    // Not bit by bit: the compiler may fuse other multiplications and additions.
    EXPECT_NEAR(psi[lane], energy(law, h), 1e-14 * size);
    EXPECT_NEAR(change[lane], energy(law, h + moderate_state(lane + 100)) - energy(law, h), 1e-14 * size);
    EXPECT_LE(norm(make_tensor([&](int i, int j) -> double { return P(i, j)[lane]; }) - stress(law, h)), 1e-14 * size);
    const Tangent<double> a = stiffness_tensor(law, h);
    for (std::size_t n = 0; n < 81; ++n) EXPECT_NEAR(A[n][lane], a[n], 1e-13 * size);
  }
}

/// Each lane of each pack has its own parameters.
TYPED_TEST(EveryLaw, FieldTakesItsParametersFromThePoint) {
  const ElasticLawSpec common = typical_law(row_of<TypeParam>());
  const auto at = [&](std::size_t n, int lane) {
    ElasticLawSpec spec = common;
    for (double& p : spec.parameters) p *= 1.0 + 0.01 * (static_cast<double>(n) * pack_size + lane);
    return spec;
  };
  const auto field = make_law_field(common, 3, at);
  const Matrix h = moderate_state(7);
  const Tensor3<Pack> H = make_tensor([&](int i, int j) { return Pack(h(i, j)); });
  for (std::size_t n = 0; n < 3; ++n) {
    const Pack psi = field->psi(n, H);
    for (int lane = 0; lane < pack_size; ++lane) {
      const double expected = energy(std::get<TypeParam>(instantiate(at(n, lane))), h);
      EXPECT_LE(relative_difference(psi[lane], expected), 1e-13);
    }
  }
}

/// As on a rank that has no cell of a body with varying constants.
TYPED_TEST(EveryLaw, FieldOfNoPointAnswers) {
  ElasticLawSpec kind = typical_law(row_of<TypeParam>());
  const bool is_expected = is_isochoric(*make_law_field(kind));
  kind.parameters.clear();
  EXPECT_EQ(is_isochoric(*make_law_field(kind, 0, [&](std::size_t, int) { return kind; })), is_expected);
}

}  // namespace
}  // namespace pliant::test_laws
