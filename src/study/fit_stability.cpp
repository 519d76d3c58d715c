#include "study/fit_stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr int num_samples = 200;

/// I1 - 3 of an incompressible body at the amount.
double distortion(Loading loading, double amount) {
  const Tensor3<double> H = incompressible_state(loading, amount);
  return 2.0 * trace(H) + dot(H, H);
}

/// The amount at which I1 - 3 has a value, by bisection. `factor`: from rest to the side of rest, above or below 1.
double amount_of(Loading loading, double value, double factor) {
  double near = 1.0, far = factor;
  while (distortion(loading, far) < value) far *= factor;
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (near + far);
    (distortion(loading, middle) < value ? near : far) = middle;
  }
  return near;
}

/// d tau_i / d ln l_j of the diagonal state, [Pa]: l_i l_j A_iijj + d_ij l_i P_ii.
std::array<std::array<double, 3>, 3> logarithmic_stiffness(const LoadedState& state) {
  std::array<std::array<double, 3>, 3> T{};
  const auto stretch = [&](std::size_t i) { return 1.0 + state.H.a[4 * i]; };
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) T[i][j] = stretch(i) * stretch(j) * state.A[36 * i + 4 * j];
    T[i][i] += stretch(i) * state.P.a[4 * i];
  }
  return T;
}

/// Sylvester's criterion.
bool is_positive(const std::array<std::array<double, 3>, 3>& T, std::size_t size) {
  const double first = T[0][0], second = T[0][0] * T[1][1] - T[0][1] * T[1][0];
  const Tensor3<double> whole{{T[0][0], T[0][1], T[0][2], T[1][0], T[1][1], T[1][2], T[2][0], T[2][1], T[2][2]}};
  return first > 0.0 && second > 0.0 && (size < 3 || det(whole) > 0.0);
}

/// The stiffness of a body whose volume is constant, ln l_3 = -ln l_1 - ln l_2: its first two rows and columns. The
/// pressure adds the same to all stresses, which do no work then.
std::array<std::array<double, 3>, 3> at_constant_volume(const std::array<std::array<double, 3>, 3>& T) {
  std::array<std::array<double, 3>, 3> reduced{};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) reduced[i][j] = T[i][j] - T[i][2] - T[2][j] + T[2][2];
  }
  return reduced;
}

bool is_baker_ericksen_stable(const LoadedState& state) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < i; ++j) {
      const double li = 1.0 + state.H(i, i), lj = 1.0 + state.H(j, j);
      if (std::abs(li - lj) < 1e-9) continue;
      if (!((li * state.P(i, i) - lj * state.P(j, j)) * (li - lj) > 0.0)) return false;
    }
  }
  return true;
}

/// The first failures on one side of rest.
class Walk {
 public:
  Walk(const FitMaterial& material, std::span<const double> all, Loading loading)
      : law_(material.law(all)),
        path_(law_, loading),
        loading_(loading),
        is_incompressible_(material.is_incompressible()) {}

  std::vector<std::string> to(double end) {
    std::vector<std::string> failures;
    std::array<bool, 3> has_failed{};
    const auto fail = [&](std::size_t which, const char* text, double amount) {
      if (!std::exchange(has_failed[which], true)) failures.push_back(fmt::format("{} {:.3g}", text, amount));
    };
    double before = 0.0;
    for (int n = 1; n <= num_samples; ++n) {
      const double amount = 1.0 + (end - 1.0) * n / num_samples;
      const auto state = is_incompressible_ ? loaded_incompressible(law_, loading_, amount) : path_.to(amount);
      if (!state) {
        failures.push_back(fmt::format("the law has no state of equilibrium at {:.3g}", amount));
        break;
      }
      const double stress = nominal_stress(*state, loading_);
      if (!((stress - before) * (end - 1.0) > 0.0)) fail(0, "the nominal stress falls from", amount);
      before = stress;
      if (loading_ == Loading::simple_shear) continue;  // its stretches are those of pure shear
      const auto T = logarithmic_stiffness(*state);
      if (!(is_incompressible_ ? is_positive(at_constant_volume(T), 2) : is_positive(T, 3)))
        fail(1, "Drucker's condition fails from", amount);
      if (loading_ != Loading::volumetric && !is_baker_ericksen_stable(*state)) {
        fail(2, "the Baker-Ericksen inequality fails from", amount);
      }
    }
    return failures;
  }

 private:
  ElasticLawSpec law_;
  LoadingPath path_;
  Loading loading_;
  bool is_incompressible_;
};

StabilityRange looked_at(const FitMaterial& material, std::span<const double> all, StabilityRange range) {
  for (const double end : {range.lowest, range.highest}) {
    if (std::abs(end - 1.0) < 1e-6) continue;
    const auto found = Walk(material, all, range.loading).to(end);
    range.failures.insert(range.failures.end(), found.begin(), found.end());
  }
  return range;
}

}  // namespace

std::vector<StabilityRange> stability_of(const FitMaterial& material, std::span<const double> all,
                                         std::span<const MaterialTest> tests) {
  std::array<StabilityRange, loadings.size()> measured{};
  double largest = 0.0;
  for (std::size_t n = 0; n < measured.size(); ++n) measured[n] = {static_cast<Loading>(n), 1.0, 1.0, false, {}};
  for (const MaterialTest& test : tests) {
    if (test.config.kind == TestKind::dma) continue;
    StabilityRange& range = measured[static_cast<std::size_t>(*test.config.loading)];
    range.is_measured = true;
    const std::vector<double> amounts = test.is_elastic() ? test.x : std::vector<double>{test.held_amount()};
    for (const double amount : amounts) {
      range.lowest = std::min(range.lowest, amount);
      range.highest = std::max(range.highest, amount);
      if (range.loading != Loading::volumetric) largest = std::max(largest, distortion(range.loading, amount));
    }
  }
  std::vector<StabilityRange> result;
  for (StabilityRange& range : measured) {
    if (range.is_measured) {
      result.push_back(looked_at(material, all, std::move(range)));
    } else if (largest > 0.0 && range.loading != Loading::volumetric && range.loading != Loading::simple_shear) {
      range.lowest = amount_of(range.loading, largest, 0.5);
      range.highest = amount_of(range.loading, largest, 2.0);
      result.push_back(looked_at(material, all, std::move(range)));
    }
  }
  return result;
}

std::string instability_at_rest(const FitMaterial& material, std::span<const double> all) {
  const auto rest = material.law(all).at_rest();
  if (!rest) return "";
  const bool is_stiff = rest->mu > 0.0, resists = material.is_incompressible() || bulk_modulus(*rest) > 0.0;
  if (is_stiff && resists) return "";
  return fmt::format("the law is unstable at rest: its {} modulus is {:.4g} Pa", is_stiff ? "bulk" : "shear",
                     is_stiff ? bulk_modulus(*rest) : rest->mu);
}

}  // namespace pliant
