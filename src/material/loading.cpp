#include "material/loading.hpp"

#include "material/law_field.hpp"
#include "material/volume_split.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace pliant {
namespace {

/// Diagonal entries of H that the loading leaves free.
std::vector<int> free_entries(Loading loading) {
  if (loading == Loading::uniaxial) return {1, 2};
  if (loading == Loading::equibiaxial) return {2};
  return {};
}

void prescribe(Tensor3<double>& H, Loading loading, double amount) {
  if (loading == Loading::simple_shear) {
    H(0, 1) = amount - 1.0;
    return;
  }
  H(0, 0) = amount - 1.0;
  if (loading == Loading::equibiaxial) H(1, 1) = amount - 1.0;
}

struct Response {
  Tensor3<double> P;  ///< [Pa]
  Tangent<double> A;  ///< dP/dH [Pa]
};

/// The law of a uniform body; all lanes of the packs are equal.
Response response(const LawField& law, const Tensor3<double>& H) {
  const auto pack = make_tensor([&](int i, int j) -> Pack { return H(i, j); });
  const Tensor3<Pack> P = law.P(0, pack);
  Tangent<Pack> A;
  law.tangent(0, pack, A);
  Response at{make_tensor([&](int i, int j) -> double { return P(i, j)[0]; }), {}};
  for (std::size_t n = 0; n < A.size(); ++n) at.A[n] = A[n][0];
  return at;
}

/// Solves P_kk = 0 for the free H_kk; false if it does not converge.
bool release(const LawField& law, const std::vector<int>& free, Tensor3<double>& H) {
  constexpr int most_iterations = 30;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const auto [P, A] = response(law, H);
    double residual = 0.0, size = 0.0;
    for (const int k : free) residual = std::max(residual, std::abs(P(k, k)));
    for (const double p : P.a) size = std::max(size, std::abs(p));
    for (const double a : A) size = std::max(size, 1e-3 * std::abs(a));
    if (!std::isfinite(size)) return false;
    if (residual <= 1e-13 * size) return true;
    const auto a = [&, &A = A](int k, int l) { return A[static_cast<std::size_t>(36 * free[k] + 4 * free[l])]; };
    std::array<double, 2> change{};
    if (free.size() == 1) {
      change[0] = -P(free[0], free[0]) / a(0, 0);
    } else {
      const double determinant = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
      const double r0 = -P(free[0], free[0]), r1 = -P(free[1], free[1]);
      change = {(r0 * a(1, 1) - r1 * a(0, 1)) / determinant, (a(0, 0) * r1 - a(1, 0) * r0) / determinant};
    }
    for (std::size_t n = 0; n < free.size(); ++n) {
      const int k = free[n];
      H(k, k) += std::max(change[n], -0.5 * (1.0 + H(k, k)));  // never through zero
    }
  }
  return false;
}

/// The state of an incompressible body, whose law without volumetric part is `rest`: its pressure follows from the free
/// face normal to z, and the sides of a bar, if they differ, from their equal pressures.
std::optional<LoadedState> loaded_at_constant_volume(const LawField& rest, Loading loading, double amount) {
  Tensor3<double> H{};
  prescribe(H, loading, amount);
  if (loading == Loading::simple_shear) return LoadedState{H, response(rest, H).P};  // the pressure has no shear
  const double along = loading == Loading::equibiaxial ? amount * amount : amount;
  double log_side = loading == Loading::equibiaxial ? 0.0 : -0.5 * std::log(along);  // ln F_yy of a bar
  constexpr int most_iterations = 50;
  constexpr double largest_change = 0.1;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    if (loading == Loading::uniaxial) H(1, 1) = std::expm1(log_side);
    H(2, 2) = std::expm1(-std::log(along) - (loading == Loading::uniaxial ? log_side : 0.0));
    auto [P, A] = response(rest, H);
    const std::array<double, 3> l{1.0 + H(0, 0), 1.0 + H(1, 1), 1.0 + H(2, 2)};
    const double tau_y = l[1] * P(1, 1), tau_z = l[2] * P(2, 2);
    const double size = std::abs(tau_y) + std::abs(tau_z) + std::abs(l[0] * P(0, 0));
    if (!std::isfinite(size)) return std::nullopt;
    if (loading == Loading::equibiaxial || std::abs(tau_y - tau_z) <= 1e-13 * size) {
      for (int i = 0; i < 3; ++i) P(i, i) -= tau_z / l[static_cast<std::size_t>(i)];
      return LoadedState{H, P};
    }
    const double slope = l[1] * l[1] * A[40] - 2.0 * l[1] * l[2] * A[44] + l[2] * l[2] * A[80] + tau_y + tau_z;
    log_side -= std::clamp((tau_y - tau_z) / slope, -largest_change, largest_change);
  }
  return std::nullopt;
}

}  // namespace

std::optional<LoadedState> loaded(const ElasticLawSpec& spec, Loading loading, double amount) {
  if (const auto split = split_volume(spec); split && std::isinf(split->kappa)) {
    return loaded_at_constant_volume(*make_law_field(split->rest), loading, amount);
  }
  const std::unique_ptr<LawField> law = make_law_field(spec);
  const auto free = free_entries(loading);
  constexpr double largest_step = 0.05;
  const int steps = static_cast<int>(std::ceil(std::abs(amount - 1.0) / largest_step));
  Tensor3<double> H{};
  for (int n = 1; n <= steps; ++n) {
    prescribe(H, loading, 1.0 + (amount - 1.0) * n / steps);
    if (!release(*law, free, H)) return std::nullopt;
  }
  return LoadedState{H, response(*law, H).P};
}

Tangent<double> tangent_at_rest(const ElasticLawSpec& law) {
  return response(*make_law_field(law), {}).A;
}

double nominal_stress(const LoadedState& state, Loading loading) {
  return loading == Loading::simple_shear ? state.P(0, 1) : state.P(0, 0);
}

}  // namespace pliant
