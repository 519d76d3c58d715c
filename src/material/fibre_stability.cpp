#include "material/fibre_stability.hpp"

#include "base/tensor.hpp"
#include "base/vector3.hpp"
#include "material/law_field.hpp"
#include "material/volume_split.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

using Direction = Vector3<double>;

/// Directions that cover the hemisphere evenly (a Fibonacci lattice).
std::vector<Direction> hemisphere() {
  constexpr int number = 150;
  std::vector<Direction> directions;
  for (int k = 0; k < number; ++k) {
    const double z = (k + 0.5) / number, angle = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double radius = std::sqrt(1.0 - z * z);
    directions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  return directions;
}

/// Two unit vectors normal to v and to one another.
std::array<Direction, 2> normals_to(const Direction& v) {
  const std::size_t least =
      static_cast<std::size_t>(std::ranges::min_element(v, {}, [](double x) { return std::abs(x); }) - v.begin());
  Direction axis{};
  axis[least] = 1.0;
  const Direction first = unit(cross(v, axis));
  return {first, cross(unit(v), first)};
}

enum class State { stable, unstable, no_law };

/// A specimen that is stretched along a direction.
class Specimen {
 public:
  /// `special`: directions of waves that are tried too.
  Specimen(const LawField& law, Direction along, std::span<const Direction> special)
      : law_(law), along_(unit(along)), directions_(hemisphere()) {
    directions_.insert(directions_.end(), special.begin(), special.end());
  }

  State at(double l) const {
    const double narrow = 1.0 / std::sqrt(l);
    const auto along = [&](int i, int j) { return along_[index(i)] * along_[index(j)]; };
    const auto of = [&](double lengthwise, double across) {
      return make_tensor(
          [&](int i, int j) { return across * (i == j ? 1.0 : 0.0) + (lengthwise - across) * along(i, j); });
    };
    const Tensor3<double> H = of(l - 1.0, narrow - 1.0);
    const Tensor3<Pack> H_pack = make_tensor([&](int i, int j) { return Pack(H(i, j)); });
    Tangent<Pack> A;
    law_.tangent(0, H_pack, A);
    const Tensor3<Pack> P = law_.P(0, H_pack);
    // F' and F'' by l.
    const Tensor3<double> rate = of(1.0, -0.5 * narrow / l), bend = of(0.0, 0.75 * narrow / (l * l));
    double growth = 0.0;
    for (std::size_t p = 0; p < 9; ++p) {
      growth += P.a[p][0] * bend.a[p];
      for (std::size_t q = 0; q < 9; ++q) growth += rate.a[p] * A[9 * p + q][0] * rate.a[q];
    }
    const Tensor3<double> inverse = of(1.0 / l, 1.0 / narrow);
    const auto is_convex_along = [&](const Direction& N) { return is_convex(A, N, matvec(inverse, N)); };
    if (!std::isfinite(growth)) return State::no_law;  // exponentials overflow
    return growth > 0.0 && std::ranges::all_of(directions_, is_convex_along) ? State::stable : State::unstable;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  /// Whether the acoustic tensor Q_ik = A_iJkL N_J N_L is positive for waves that keep the volume: normal to n.
  static bool is_convex(const Tangent<Pack>& A, const Direction& N, const Direction& n) {
    Tensor3<double> Q{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t J = 0; J < 3; ++J) {
          for (std::size_t L = 0; L < 3; ++L) Q.a[3 * i + k] += A[9 * (3 * i + J) + 3 * k + L][0] * N[J] * N[L];
        }
      }
    }
    const auto [a, b] = normals_to(n);
    const double aa = dot(a, matvec(Q, a)), ab = dot(a, matvec(Q, b)), bb = dot(b, matvec(Q, b));
    return aa > 0.0 && aa * bb - ab * ab > 0.0;
  }

  const LawField& law_;
  Direction along_;
  std::vector<Direction> directions_;
};

/// The first stretch on the way from 1 to `end` at which the law is not stable; `end` if there is none.
double first_unstable(const Specimen& specimen, double end) {
  constexpr int num_steps = 40, num_halvings = 30;
  double stable = 1.0;
  for (int n = 1; n <= num_steps; ++n) {
    double at = std::pow(end, static_cast<double>(n) / num_steps);
    const State state = specimen.at(at);
    if (state == State::no_law) return end;
    if (state == State::stable) {
      stable = at;
      continue;
    }
    for (int k = 0; k < num_halvings; ++k) {
      const double middle = 0.5 * (stable + at);
      (specimen.at(middle) == State::stable ? stable : at) = middle;
    }
    return stable;
  }
  return end;
}

}  // namespace

std::optional<StableFibreStretches> stable_fibre_stretches(const ElasticLawSpec& law) {
  const int number = law.traits().num_directions;
  if (number == 0) return std::nullopt;
  // A volumetric part has no share in motions that keep the volume.
  const auto split = split_volume(law);
  const std::unique_ptr<LawField> field = make_law_field(split ? split->rest : law);
  const Direction first = law.directions[0], second = law.directions[1];
  std::vector<std::pair<std::string, Direction>> ways;
  if (number == 1) {
    ways = {{"along the fibres", first}, {"across the fibres", normals_to(first)[0]}};
  } else {
    const Direction normal = cross(first, second);
    const bool is_plane = dot(normal, normal) > 1e-12;
    ways = {{"along the first direction", first},
            {"along the second direction", second},
            {"normal to both directions", is_plane ? normal : normals_to(first)[0]}};
  }
  std::vector<Direction> special;
  for (const auto& way : ways) special.push_back(unit(way.second));
  StableFibreStretches stable;
  for (const auto& [name, direction] : ways) {
    const Specimen specimen(*field, direction, special);
    constexpr double far = StableFibreStretches::searched;
    stable.ways.push_back({name, first_unstable(specimen, far), first_unstable(specimen, 1.0 / far)});
  }
  return stable;
}

std::string in_words(const StableFibreStretches& stable, double low, double high) {
  std::string words;
  const auto add = [&](const std::string& along, const char* to, double stretch) {
    if (stretch < low || stretch > high || stretch == StableFibreStretches::searched ||
        stretch == 1.0 / StableFibreStretches::searched) {
      return;
    }
    words += fmt::format("{}{} {} a stretch of {:.3g}", words.empty() ? "" : ", ", along, to, stretch);
  };
  for (const StableFibreStretches::Way& way : stable.ways) {
    add(way.along, "up to", way.tension);
    add(way.along, "down to", way.compression);
  }
  return words;
}

}  // namespace pliant
