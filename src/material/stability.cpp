#include "material/stability.hpp"

#include "material/law_field.hpp"
#include "material/volume_split.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

namespace pliant {
namespace {

using Triple = std::array<double, 3>;

/// The second derivative of the energy in logarithmic strains, and its first, at principal stretches.
struct LogarithmicResponse {
  Triple tau;               ///< l_i P_ii [Pa]
  std::array<Triple, 3> K;  ///< [Pa]

  LogarithmicResponse(const LawField& law, const Triple& l) {
    const auto H = make_tensor([&](int i, int j) { return Pack(i == j ? l[static_cast<std::size_t>(i)] - 1.0 : 0.0); });
    const Tensor3<Pack> P = law.P(0, H);
    Tangent<Pack> A;
    law.tangent(0, H, A);
    for (std::size_t i = 0; i < 3; ++i) {
      tau[i] = l[i] * P.a[4 * i][0];
      for (std::size_t j = 0; j < 3; ++j) K[i][j] = l[i] * A[36 * i + 4 * j][0] * l[j] + (i == j ? tau[i] : 0.0);
    }
  }

  double first(const Triple& d) const { return d[0] * tau[0] + d[1] * tau[1] + d[2] * tau[2]; }
  double second(const Triple& d, const Triple& e) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) sum += d[i] * K[i][j] * e[j];
    }
    return sum;
  }
};

enum class State { stable, unstable, no_law };

/// At the stretches l^d, where d sums to 0 and d[0] = 1: l is the stretch of the specimen.
State state_at(const LawField& law, const Triple& d, double l) {
  const Triple stretches{l, std::pow(l, d[1]), std::pow(l, d[2])};
  const LogarithmicResponse at(law, stretches);
  constexpr Triple a{1.0, 0.0, -1.0}, b{0.0, 1.0, -1.0};
  const double aa = at.second(a, a), ab = at.second(a, b), bb = at.second(b, b);
  const double along = at.second(d, d);
  if (!std::isfinite(aa + ab + bb + along)) return State::no_law;
  // d2W/dl2 = (d2W/de2 - dW/de) / l^2 where e = ln l
  const bool is_stable = aa > 0.0 && aa * bb - ab * ab > 0.0 && along - at.first(d) > 0.0;
  return is_stable ? State::stable : State::unstable;
}

/// The first stretch on the way from 1 to `end` at which the law is not stable; `end` if there is none.
double first_unstable(const LawField& law, const Triple& d, double end) {
  constexpr int num_steps = 400, num_halvings = 30;
  double stable = 1.0;
  for (int n = 1; n <= num_steps; ++n) {
    double at = std::pow(end, static_cast<double>(n) / num_steps);
    const State state = state_at(law, d, at);
    if (state == State::no_law) return end;
    if (state == State::unstable) {
      for (int k = 0; k < num_halvings; ++k) {
        const double middle = 0.5 * (stable + at);
        (state_at(law, d, middle) == State::stable ? stable : at) = middle;
      }
      return stable;
    }
    stable = at;
  }
  return end;
}

constexpr Triple uniaxial{1.0, -0.5, -0.5}, planar{1.0, 0.0, -1.0}, biaxial{1.0, 1.0, -2.0};

}  // namespace

double StableStretches::limit(const Triple& stretches) const {
  const double mean = (std::log(stretches[0]) + std::log(stretches[1]) + std::log(stretches[2])) / 3.0;
  const double e1 = std::log(stretches[0]) - mean, e2 = std::log(stretches[1]) - mean;
  const double kind = e1 > 0.0 ? std::clamp(e2 / e1, -0.5, 1.0) : 0.0;
  const double at_shear = std::log(pure_shear);
  const double at_biaxial = std::log(std::min(equibiaxial, 1.0 / std::sqrt(compression)));
  const double e =
      kind < 0.0 ? at_shear + 2.0 * kind * (at_shear - std::log(tension)) : at_shear + kind * (at_biaxial - at_shear);
  return std::exp(e + mean);
}

std::optional<StableStretches> stable_stretches(const ElasticLawSpec& law) {
  const auto split = split_volume(law);
  if (!split || law.traits().num_directions > 0) return std::nullopt;
  const std::unique_ptr<LawField> rest = make_law_field(split->rest);
  constexpr double far = StableStretches::searched;
  return StableStretches{first_unstable(*rest, uniaxial, far), first_unstable(*rest, uniaxial, 1.0 / far),
                         first_unstable(*rest, planar, far), first_unstable(*rest, biaxial, far)};
}

std::string in_words(const StableStretches& stable, double low, double high) {
  std::string words;
  const auto add = [&](const char* in, const char* to, double stretch) {
    if (stretch < low || stretch > high) return;
    words += fmt::format("{}in {} {} a stretch of {:.3g}", words.empty() ? "" : ", ", in, to, stretch);
  };
  add("uniaxial tension", "up to", stable.tension);
  add("pure shear", "up to", stable.pure_shear);
  add("equibiaxial tension", "up to", stable.equibiaxial);
  add("uniaxial compression", "down to", stable.compression);
  return words;
}

}  // namespace pliant
