// Softening after Ogden & Roxburgh, against its definition in more digits.
#include "material/mullins.hpp"

#include <ostream>

#include <gtest/gtest.h>

namespace pliant::test_mullins_law {
namespace {

using Wide = long double;

class Softening : public ::testing::TestWithParam<Mullins> {
 protected:
  Wide eta(Wide W) const {
    const Mullins law = GetParam();
    return W < largest ? 1 - std::erf((largest - W) / (Wide(law.m) + Wide(law.beta) * largest)) / law.r : Wide(1);
  }
  /// int eta - 1 dw over a length, by the midpoint rule and Richardson's extrapolation; smooth within a side of Wm.
  Wide integral(Wide from, Wide length) const {
    const auto midpoint = [&](int n) {
      Wide sum = 0;
      for (int k = 0; k < n; ++k) sum += eta(from + length * (k + Wide(0.5)) / n) - 1;
      return sum * length / n;
    };
    const Wide coarse = midpoint(2000), fine = midpoint(4000);
    return fine + (fine - coarse) / 3;
  }

  static constexpr double largest = 2.5;
  static constexpr std::array<double, 6> energies{0.0, 0.3, 1.4, 2.2, 2.4999, 3.5};
};

INSTANTIATE_TEST_SUITE_P(Constants, Softening,
                         ::testing::Values(Mullins{1.5, 0.4, 0.0}, Mullins{2.1, 0.0, 0.2}, Mullins{1.05, 0.3, 0.1},
                                           Mullins{8.0, 30.0, 1.0}));

TEST_P(Softening, IsAsDefined) {
  for (const double W : energies) {
    EXPECT_NEAR(1.0 + GetParam().eta_change(W, largest)[0], static_cast<double>(eta(W)), 1e-15);
    const double scale = GetParam().m + GetParam().beta * largest;
    const Wide h = 1e-4L * scale;
    if (std::abs(W - largest) > h) {
      const auto slope = static_cast<double>((eta(W + h) - eta(W - h)) / (2 * h));
      EXPECT_NEAR(GetParam().eta_slope(W, largest)[0], slope, 1e-7 / scale);
    }
    const Wide withheld = W < largest ? integral(largest, W - Wide(largest)) : Wide(0);
    EXPECT_NEAR(GetParam().withheld(W, largest)[0], static_cast<double>(withheld), 1e-9 * largest);
  }
}

// The changes of one Newton step near convergence are far smaller than the energies.
TEST_P(Softening, ChangesKeepTheirDigits) {
  for (const double W : {0.3, 1.4, 2.4999}) {
    for (const double dW : {1e-12, -3e-9, 1e-5, -2e-3}) {
      const auto expected = static_cast<double>(integral(W, std::min<Wide>(dW, Wide(largest) - W)));
      EXPECT_NEAR(GetParam().withheld_change(W, dW, largest)[0], expected, 2e-13 * std::abs(expected))
          << W << " " << dW;
    }
  }
  for (const double dW : {0.4, -1.0, 1.5}) {
    const double W = 1.2;
    EXPECT_NEAR(GetParam().withheld_change(W, dW, largest)[0],
                GetParam().withheld(W + dW, largest)[0] - GetParam().withheld(W, largest)[0], 1e-15 * largest);
  }
  EXPECT_EQ(GetParam().withheld_change(3.0, 0.5, largest)[0], 0.0);
  EXPECT_EQ(GetParam().withheld_change(largest, 1e-3, largest)[0], 0.0);
}

// A virgin material has lost nothing, and what is lost grows with the largest strain.
TEST_P(Softening, LosesEnergyFromTheFirstLoadingOn) {
  const auto lost = [](double Wm) { return static_cast<double>(GetParam().dissipated(Wm)[0]); };
  EXPECT_EQ(lost(0.0), 0.0);
  EXPECT_EQ(GetParam().eta_change(0.0, 0.0)[0], 0.0);
  EXPECT_EQ(GetParam().eta_slope(0.0, 0.0)[0], 0.0);
  for (const double Wm : {0.01, 0.5, 2.0, 7.0}) {
    EXPECT_GT(lost(Wm), lost(0.9 * Wm));
    EXPECT_LT(lost(Wm), Wm / GetParam().r);
  }
  EXPECT_NEAR(lost(largest), static_cast<double>(integral(largest, -Wide(largest))), 1e-9 * largest);
}

}  // namespace
}  // namespace pliant::test_mullins_law
