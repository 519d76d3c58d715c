// Curvature of plates from angles: exact for quadratic deflections and in balance, on irregular meshes.
#include "energy/shell/hinge.hpp"
#include "energy/shell/plate_patch.hpp"
#include "energy/shell/shell_topology.hpp"

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_plate_patch {
namespace {

constexpr int n = 6;  // squares along a side
constexpr double rigidity = 3.0, nu = 0.3;
using Deflection = std::function<double(const Vector3<double>&)>;

/// A square of 1 in triangles, the diagonals of which alternate (the Union Jack), with inner nodes moved at random.
struct Plate {
  std::vector<Vector3<double>> X;
  ShellTopology topology;
  std::vector<PlateFit> fits;

  explicit Plate(std::vector<ClampedEdge> clamped = {}) {
    unsigned seed = 7;
    const auto random = [&] {
      seed = seed * 1103515245U + 12345U;
      return static_cast<double>(seed >> 8U & 0xffffU) / 65535.0 - 0.5;
    };
    std::vector<ShellTopology::Triangle> triangles;
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        const bool is_inner = i > 0 && i < n && j > 0 && j < n;
        const double jitter = is_inner ? 0.5 : 0.0;
        X.push_back({(i + jitter * random()) / n, (j + jitter * random()) / n, 0.0});
        if (i == n || j == n) continue;
        const std::int64_t a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
        if ((i + j) % 2 == 0) {
          triangles.insert(triangles.end(), {{a, b, c}, {a, d, c}});  // the second has the other orientation
        } else {
          triangles.insert(triangles.end(), {{a, b, d}, {b, c, d}});
        }
      }
    }
    topology = ShellTopology(std::move(triangles), clamped);
    for (std::size_t t = 0; t < topology.triangles().size(); ++t) fits.push_back(fit_plate(triangle(t), nu));
  }

  const Vector3<double>& corner(std::size_t t, std::size_t k) const {
    return X[static_cast<std::size_t>(topology.triangles()[t][k % 3])];
  }
  PlateTriangle triangle(std::size_t t) const {
    PlateTriangle result;
    for (std::size_t k = 0; k < 3; ++k) {
      result.corners[k] = corner(t, k);
      const auto other = topology.across(t, k);
      if (other.triangle < 0) continue;
      result.sides[k] = PlateSide::folded;
      result.others[k] = corner(static_cast<std::size_t>(other.triangle), other.k + 2);
    }
    return result;
  }
  PlateCurvature curvature(std::size_t t) const {
    std::array<PlateNeighbour, 3> neighbours;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto other = topology.across(t, k);
      if (other.triangle >= 0) neighbours[k] = {&fits[static_cast<std::size_t>(other.triangle)], other.k};
    }
    return plate_curvature(fits[t], neighbours);
  }
  /// The angle at a side of a small deflection; 0 at the rim.
  double angle(std::size_t t, std::size_t k, const Deflection& w) const {
    const auto other = topology.across(t, k);
    if (other.triangle < 0) return 0.0;
    const auto lifted = [&](const Vector3<double>& at) { return at + Vector3<double>{0.0, 0.0, w(at)}; };
    const Vector3<double> a = lifted(corner(t, k));
    return hinge_angle<double>(lifted(corner(t, k + 1)) - a, lifted(corner(t, k + 2)) - a,
                               lifted(corner(static_cast<std::size_t>(other.triangle), other.k + 2)) - a);
  }
  /// The curvature of a triangle in its own frame.
  std::array<double, 3> curvature(std::size_t t, const Deflection& w) const {
    const PlateCurvature columns = curvature(t);
    std::array<double, 3> result{};
    for (std::size_t c = 0; c < 12; ++c) {
      const auto other = c < 3 ? static_cast<std::int64_t>(t) : topology.across(t, (c - 3) / 3).triangle;
      if (other < 0) continue;
      const double theta = angle(static_cast<std::size_t>(other), c % 3, w);
      for (std::size_t i = 0; i < 3; ++i) result[i] += columns[c][i] * theta;
    }
    return result;
  }
  bool is_deep(const Vector3<double>& at, double margin) const {
    return std::min({at[0], at[1], 1.0 - at[0], 1.0 - at[1]}) > margin;
  }
};

constexpr double size = 1e-5;
Deflection quadratic(double xx, double yy, double xy) {
  return [=](const Vector3<double>& X) {
    return size * (0.5 * xx * X[0] * X[0] + 0.5 * yy * X[1] * X[1] + xy * X[0] * X[1]);
  };
}

TEST(PlatePatch, HasTheCurvatureOfQuadraticDeflections) {
  const Plate plate;
  for (const auto& [xx, yy, xy] : {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, -0.5, 0.7}}) {
    int num_tested = 0;
    for (std::size_t t = 0; t < plate.fits.size(); ++t) {
      const Vector3<double> middle = (1.0 / 3.0) * (plate.corner(t, 0) + plate.corner(t, 1) + plate.corner(t, 2));
      if (!plate.is_deep(middle, 0.34)) continue;
      ++num_tested;
      const auto kappa = plate.curvature(t, quadratic(xx, yy, xy));
      // The invariants, whatever the frame.
      EXPECT_NEAR((kappa[0] + kappa[1]) / size, xx + yy, 1e-6);
      EXPECT_NEAR((kappa[0] * kappa[1] - 0.25 * kappa[2] * kappa[2]) / (size * size), xx * yy - xy * xy, 1e-6);
    }
    EXPECT_GT(num_tested, 4);
  }
}

TEST(PlatePatch, ConstantMomentsBalance) {
  const Plate plate;
  const Deflection w = quadratic(1.0, -0.5, 0.7);
  std::vector<double> forces(plate.X.size(), 0.0);
  double largest = 0.0;
  for (std::size_t t = 0; t < plate.fits.size(); ++t) {
    const auto kappa = plate.curvature(t, w);
    const auto C = plate_stiffness(plate.fits[t], rigidity, nu);
    std::array<double, 3> m{};
    for (std::size_t i = 0; i < 9; ++i) m[i / 3] += C[i] * kappa[i % 3];
    for (std::size_t node = 0; node < plate.X.size(); ++node) {
      const auto lift = [&](const Vector3<double>& X) { return norm(X - plate.X[node]) == 0.0 ? size : 0.0; };
      const auto d = plate.curvature(t, lift);
      const double force = plate.fits[t].area * (m[0] * d[0] + m[1] * d[1] + m[2] * d[2]) / (size * size);
      forces[node] += force;
      largest = std::max(largest, std::abs(force));
    }
  }
  int num_tested = 0;
  for (std::size_t node = 0; node < plate.X.size(); ++node) {
    if (!plate.is_deep(plate.X[node], 0.38)) continue;
    ++num_tested;
    EXPECT_NEAR(forces[node], 0.0, 1e-6 * largest);
  }
  EXPECT_GT(num_tested, 0);
}

TEST(PlatePatch, HasNoMomentAboutFreeSides) {
  const Plate plate;
  for (std::size_t t = 0; t < plate.fits.size(); ++t) {
    const auto C = plate_stiffness(plate.fits[t], rigidity, nu);
    for (const PlateFit::Side& side : plate.fits[t].sides) {
      const double nx = side.direction[1], ny = -side.direction[0];
      const std::array<double, 3> L{nx * nx, ny * ny, 2.0 * nx * ny};
      double moment = 0.0;
      for (std::size_t i = 0; i < 3; ++i)
        moment += std::abs(C[3 * i] * L[0] + C[3 * i + 1] * L[1] + C[3 * i + 2] * L[2]);
      if (side.kind == PlateSide::free) {
        EXPECT_LT(moment, 1e-14 * rigidity);
      } else if (plate.fits[t].is_complete) {
        EXPECT_GT(moment, 0.1 * rigidity);
      }
    }
  }
}

TEST(ShellTopology, OrientsAndListsWhatIsNear) {
  const Plate plate({{{0, 1}, {}, 0}, {{0, n + 2}, {}, 0}});  // a side of the rim, and an inner diagonal
  EXPECT_EQ(plate.topology.num_unclamped(), (std::map<std::int32_t, std::int64_t>{{0, 1}}));
  std::size_t num_clamped = 0;
  for (const auto& edge : plate.topology.edges()) {
    EXPECT_TRUE(edge.is_oriented);
    num_clamped += edge.clamped ? 1 : 0;
  }
  EXPECT_EQ(num_clamped, 1U);
  std::size_t most = 0;
  for (std::size_t t = 0; t < plate.fits.size(); ++t) most = std::max(most, plate.topology.patch(t).size());
  EXPECT_GT(most, 7U);  // fewer than 10 where neighbours of neighbours coincide
  EXPECT_LE(most, 10U);
}

TEST(HingeMap, OfAMirrorMovesTheImage) {
  const Vector3<double> m = unit(Vector3<double>{0.3, -0.2, 0.9});
  const HingeMap map = hinge_map(&m), plain = hinge_map(nullptr);
  const std::array<double, 12> nodes{0.1, 0.4, -0.3, 1.2, 0.2, 0.1, 0.5, 0.9, -0.7, 0.0, 0.0, 0.0};
  std::array<double, 9> vectors{}, without{};
  for (std::size_t i = 0; i < 108; ++i) {
    vectors[i / 12] += map[i] * nodes[i % 12];
    without[i / 12] += plain[i] * nodes[i % 12];
  }
  const Vector3<double> u{vectors[3], vectors[4], vectors[5]}, v{vectors[6], vectors[7], vectors[8]};
  EXPECT_LT(norm(v - (u - (2.0 * dot(u, m)) * m)), 1e-15);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(vectors[i], without[i]);
}

}  // namespace
}  // namespace pliant::test_plate_patch
