#include "energy/shell/hinge.hpp"

#include <eigen3/Eigen/Dense>
#include <vector>

namespace pliant {
namespace {

using Plane = std::array<double, 2>;

/// What keeps M bounded where six points lie almost on one conic, relative to the area: a quadratic deflection hardly
/// folds the edges there.
constexpr double regularization = 1e-4;

/// The jump of the slope across the edge from p to q, along its outward normal, of the interpolant of
/// (x^2/2, y^2/2, x y/2) over the triangles (p, q, c) and (q, p, o).
Eigen::RowVector3d jump_of_quadratics(const Plane& p, const Plane& q, const Plane& c, const Plane& o) {
  const double ex = q[0] - p[0], ey = q[1] - p[1], length = std::hypot(ex, ey);
  const Plane n{ey / length, -ex / length};
  const auto values = [&](const Plane& x) {
    return Eigen::RowVector3d(0.5 * x[0] * x[0], 0.5 * x[1] * x[1], 0.5 * x[0] * x[1]);
  };
  // Along n from the edge, at the foot of the point on it.
  const auto slope = [&](const Plane& x) -> Eigen::RowVector3d {
    const double dx = x[0] - p[0], dy = x[1] - p[1];
    const double height = dx * n[0] + dy * n[1], foot = (dx * ex + dy * ey) / (length * length);
    return (values(x) - (1.0 - foot) * values(p) - foot * values(q)) / height;
  };
  return slope(o) - slope(c);
}

}  // namespace

std::array<double, 9> hinge_matrix(const HingePatch& patch, double rigidity, double poissons_ratio) {
  const auto& X = patch.corners;
  const Vector3<double> first = unit(X[1] - X[0]), normal = unit(cross(X[1] - X[0], X[2] - X[0])),
                        second = cross(normal, first);
  std::array<Plane, 3> plane;
  for (std::size_t k = 0; k < 3; ++k) plane[k] = {dot(X[k] - X[0], first), dot(X[k] - X[0], second)};
  const double area = 0.5 * norm(cross(X[1] - X[0], X[2] - X[0]));

  std::vector<Eigen::Index> edges;
  Eigen::Matrix<double, Eigen::Dynamic, 3> B(3, 3);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!patch.has_other[k]) continue;
    const Plane &p = plane[k], &q = plane[(k + 1) % 3];
    // Unfolded: as far along the edge and from it, on the other side of it.
    const Vector3<double> e = unit(X[(k + 1) % 3] - X[k]), v = patch.others[k] - X[k];
    const double along = dot(v, e), away = norm(v - along * e), length = std::hypot(q[0] - p[0], q[1] - p[1]);
    const Plane t{(q[0] - p[0]) / length, (q[1] - p[1]) / length};
    const Plane other{p[0] + along * t[0] + away * t[1], p[1] + along * t[1] - away * t[0]};
    B.row(static_cast<Eigen::Index>(edges.size())) = jump_of_quadratics(p, q, plane[(k + 2) % 3], other);
    edges.push_back(static_cast<Eigen::Index>(k));
  }
  std::array<double, 9> M{};
  if (edges.empty()) return M;
  const auto count = static_cast<Eigen::Index>(edges.size());
  B.conservativeResize(count, 3);
  const double nu = poissons_ratio, scale = 1.0 / (rigidity * (1.0 - nu * nu));
  Eigen::Matrix3d compliance;  // C^-1
  compliance << scale, -nu * scale, 0.0, -nu * scale, scale, 0.0, 0.0, 0.0, 2.0 / (rigidity * (1.0 - nu));
  const Eigen::MatrixXd flexibility =
      B * compliance * B.transpose() + (regularization * area / rigidity) * Eigen::MatrixXd::Identity(count, count);
  const Eigen::MatrixXd stiffness = area * flexibility.inverse();
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      M[static_cast<std::size_t>(3 * edges[i] + edges[j])] = 0.5 * (stiffness(i, j) + stiffness(j, i));
    }
  }
  return M;
}

}  // namespace pliant
