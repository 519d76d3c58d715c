#include "material/loading.hpp"

#include "material/volume_split.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

void prescribe(Tensor3<double>& H, Loading loading, double amount) {
  if (loading == Loading::simple_shear) {
    H(0, 1) = amount - 1.0;
    return;
  }
  const double strain = loading == Loading::volumetric ? std::cbrt(amount) - 1.0 : amount - 1.0;
  H(0, 0) = strain;
  if (loading == Loading::equibiaxial || loading == Loading::volumetric) H(1, 1) = strain;
  if (loading == Loading::volumetric) H(2, 2) = strain;
}

/// The law of a uniform body; all lanes of the packs are equal.
LoadedState response(const LawField& law, const Tensor3<double>& H) {
  const auto pack = make_tensor([&](int i, int j) -> Pack { return H(i, j); });
  const Tensor3<Pack> P = law.P(0, pack);
  Tangent<Pack> A;
  law.tangent(0, pack, A);
  LoadedState at{H, make_tensor([&](int i, int j) -> double { return P(i, j)[0]; }), {}};
  for (std::size_t n = 0; n < A.size(); ++n) at.A[n] = A[n][0];
  return at;
}

/// Solves P_kk = 0 for the free H_kk; false if it does not converge. It has converged where what is left of P, or of
/// the changes of H_kk, is rounding: a large resistance to changes of volume multiplies that in P.
bool release(const LawField& law, const std::vector<int>& free, Tensor3<double>& H) {
  constexpr int most_iterations = 30;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const auto [at, P, A] = response(law, H);
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
    bool is_rounding = true;
    for (std::size_t n = 0; n < free.size(); ++n) {
      const int k = free[n];
      is_rounding = is_rounding && std::abs(change[n]) <= 1e-14 * (1.0 + H(k, k));
      H(k, k) += std::max(change[n], -0.5 * (1.0 + H(k, k)));  // never through zero
    }
    if (is_rounding) return true;
  }
  return false;
}

/// P - p F^-T and its derivative, for a diagonal F: d(F^-T)_iJ / dF_Ji = -1/(l_i l_J).
void subtract_pressure(double pressure, LoadedState& state) {
  const auto stretch = [&](int k) { return 1.0 + state.H(k, k); };
  for (int i = 0; i < 3; ++i) {
    state.P(i, i) -= pressure / stretch(i);
    for (int J = 0; J < 3; ++J) {
      state.A[static_cast<std::size_t>(9 * (3 * i + J) + 3 * J + i)] += pressure / (stretch(i) * stretch(J));
    }
  }
}

/// The state of an incompressible body, whose law without volumetric part is `rest`: its pressure follows from the free
/// face normal to z, and the sides of a bar, if they differ, from their equal pressures.
std::optional<LoadedState> loaded_at_constant_volume(const LawField& rest, Loading loading, double amount) {
  if (loading == Loading::volumetric) return std::nullopt;
  Tensor3<double> H{};
  prescribe(H, loading, amount);
  if (loading == Loading::simple_shear) return response(rest, H);  // the pressure has no shear
  const double along = loading == Loading::equibiaxial ? amount * amount : amount;
  double log_side = loading == Loading::equibiaxial ? 0.0 : -0.5 * std::log(along);  // ln F_yy of a bar
  constexpr int most_iterations = 50;
  constexpr double largest_change = 0.1;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    if (loading == Loading::uniaxial) H(1, 1) = std::expm1(log_side);
    H(2, 2) = std::expm1(-std::log(along) - (loading == Loading::uniaxial ? log_side : 0.0));
    LoadedState state = response(rest, H);
    const auto& [at, P, A] = state;
    const std::array<double, 3> l{1.0 + H(0, 0), 1.0 + H(1, 1), 1.0 + H(2, 2)};
    const double tau_y = l[1] * P(1, 1), tau_z = l[2] * P(2, 2);
    const double size = std::abs(tau_y) + std::abs(tau_z) + std::abs(l[0] * P(0, 0));
    if (!std::isfinite(size)) return std::nullopt;
    if (loading != Loading::uniaxial || std::abs(tau_y - tau_z) <= 1e-13 * size) {
      subtract_pressure(tau_z, state);
      return state;
    }
    const double slope = l[1] * l[1] * A[40] - 2.0 * l[1] * l[2] * A[44] + l[2] * l[2] * A[80] + tau_y + tau_z;
    log_side -= std::clamp((tau_y - tau_z) / slope, -largest_change, largest_change);
  }
  return std::nullopt;
}

}  // namespace

std::vector<int> free_entries(Loading loading) {
  if (loading == Loading::uniaxial) return {1, 2};
  if (loading == Loading::equibiaxial || loading == Loading::pure_shear) return {2};
  return {};
}

LoadingPath::LoadingPath(const ElasticLawSpec& law, Loading loading) : law_(make_law_field(law)), loading_(loading) {}

std::optional<LoadedState> LoadingPath::to(double amount) {
  const auto free = free_entries(loading_);
  constexpr double largest_step = 0.05;
  const int steps = static_cast<int>(std::ceil(std::abs(amount - amount_) / largest_step));
  const double from = amount_;
  for (int n = 1; n <= steps; ++n) {
    const double next = from + (amount - from) * n / steps;
    Tensor3<double> H = H_;
    prescribe(H, loading_, next);
    // Guess: the volume stays.
    const double side = incompressible_state(loading_, next / amount_)(2, 2) + 1.0;
    for (const int k : free) H(k, k) = side * (1.0 + H(k, k)) - 1.0;
    if (!release(*law_, free, H)) return std::nullopt;
    H_ = H;
    amount_ = next;
  }
  return response(*law_, H_);
}

std::optional<LoadedState> loaded(const ElasticLawSpec& law, Loading loading, double amount) {
  if (const auto split = split_volume(law); split && std::isinf(split->kappa)) {
    return loaded_at_constant_volume(*make_law_field(split->rest), loading, amount);
  }
  return LoadingPath(law, loading).to(amount);
}

Tensor3<double> incompressible_state(Loading loading, double amount) {
  Tensor3<double> H{};
  prescribe(H, loading, amount);
  const double side = loading == Loading::uniaxial      ? 1.0 / std::sqrt(amount)
                      : loading == Loading::equibiaxial ? 1.0 / (amount * amount)
                                                        : 1.0 / amount;
  for (const int k : free_entries(loading)) H(k, k) = side - 1.0;
  return H;
}

LoadedState loaded_incompressible(const ElasticLawSpec& law, Loading loading, double amount) {
  LoadedState state = response(*make_law_field(law), incompressible_state(loading, amount));
  const auto free = free_entries(loading);
  if (free.empty()) return state;
  const int k = free.front();
  subtract_pressure(state.P(k, k) * (1.0 + state.H(k, k)), state);
  return state;
}

Tangent<double> tangent_at_rest(const ElasticLawSpec& law) {
  return response(*make_law_field(law), {}).A;
}

double nominal_stress(const LoadedState& state, Loading loading) {
  return loading == Loading::simple_shear ? state.P(0, 1) : state.P(0, 0);
}

}  // namespace pliant
