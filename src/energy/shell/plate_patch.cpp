#include "energy/shell/plate_patch.hpp"

#include <cmath>
#include <eigen3/Eigen/Dense>
#include <vector>

namespace pliant {
namespace {

using Plane = std::array<double, 2>;

/// Curvatures that hardly fold the sides of a triangle, relative to those that fold them most, are not taken from its
/// angles: six points almost on one conic.
constexpr double faintest = 0.03;

/// (x^2/2, y^2/2, x y/2): the deflections of unit curvatures.
Eigen::RowVector3d quadratics(const Plane& x) {
  return {0.5 * x[0] * x[0], 0.5 * x[1] * x[1], 0.5 * x[0] * x[1]};
}

/// (n_x^2, n_y^2, 2 n_x n_y) of the normal n to a direction.
Eigen::Vector3d across(const std::array<double, 2>& direction) {
  const double nx = direction[1], ny = -direction[0];
  return {nx * nx, ny * ny, 2.0 * nx * ny};
}

Eigen::Matrix3d stiffness_of_plate(double nu) {
  Eigen::Matrix3d C;
  C << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu);
  return C;
}

/// d_own and d_other of the side from p to q of the triangles (p, q, c) and (q, p, o): slopes across the side, along
/// its outward normal, of the deflections, and of their interpolants.
void set_slopes(const Plane& p, const Plane& q, const Plane& c, const Plane& o, PlateFit::Side& side) {
  const double ex = q[0] - p[0], ey = q[1] - p[1];
  side.length = std::hypot(ex, ey);
  side.direction = {ex / side.length, ey / side.length};
  const Plane n{side.direction[1], -side.direction[0]}, m{0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])};
  const auto of_interpolant = [&](const Plane& x) -> Eigen::RowVector3d {
    const double dx = x[0] - p[0], dy = x[1] - p[1];
    const double height = dx * n[0] + dy * n[1], foot = (dx * ex + dy * ey) / (side.length * side.length);
    return (quadratics(x) - (1.0 - foot) * quadratics(p) - foot * quadratics(q)) / height;
  };
  const Eigen::RowVector3d at_middle(n[0] * m[0], n[1] * m[1], 0.5 * (n[0] * m[1] + n[1] * m[0]));
  Eigen::RowVector3d::Map(side.own.data()) = at_middle - of_interpolant(c);
  if (side.kind != PlateSide::free) Eigen::RowVector3d::Map(side.other.data()) = of_interpolant(o) - at_middle;
}

/// The curvature of given angles of `sides`, one row of B for each.
Eigen::MatrixXd curvature_of_angles(const Eigen::MatrixXd& B, double poissons_ratio) {
  if (B.rows() < 3) {
    const Eigen::Matrix3d compliance = stiffness_of_plate(poissons_ratio).inverse();
    const Eigen::MatrixXd flexibility = B * compliance * B.transpose();
    return compliance * B.transpose() * flexibility.inverse();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(B, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double s = svd.singularValues()[i];
    if (s > faintest * svd.singularValues()[0]) inverse[i] = 1.0 / s;
  }
  return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
}

}  // namespace

PlateFit fit_plate(const PlateTriangle& triangle, double poissons_ratio) {
  const auto& X = triangle.corners;
  const Vector3<double> normal = cross(X[1] - X[0], X[2] - X[0]), first = unit(X[1] - X[0]),
                        second = cross(unit(normal), first);
  std::array<Plane, 3> plane;
  for (std::size_t k = 0; k < 3; ++k) plane[k] = {dot(X[k] - X[0], first), dot(X[k] - X[0], second)};
  PlateFit fit;
  fit.area = 0.5 * norm(normal);
  std::vector<std::size_t> folded;
  for (std::size_t k = 0; k < 3; ++k) {
    PlateFit::Side& side = fit.sides[k];
    side.kind = triangle.sides[k];
    const Plane &p = plane[k], &q = plane[(k + 1) % 3];
    Plane other{};
    if (side.kind != PlateSide::free) {
      // Unfolded: as far along the side and from it, on the other side of it.
      const Vector3<double> e = unit(X[(k + 1) % 3] - X[k]), v = triangle.others[k] - X[k];
      const double along = dot(v, e), away = norm(v - along * e), length = std::hypot(q[0] - p[0], q[1] - p[1]);
      const Plane t{(q[0] - p[0]) / length, (q[1] - p[1]) / length};
      other = {p[0] + along * t[0] + away * t[1], p[1] + along * t[1] - away * t[0]};
      folded.push_back(k);
    }
    set_slopes(p, q, plane[(k + 2) % 3], other, side);
  }
  fit.is_complete = folded.size() == 3;
  if (folded.empty()) return fit;
  Eigen::MatrixXd B(folded.size(), 3);
  for (std::size_t f = 0; f < folded.size(); ++f) {
    const PlateFit::Side& side = fit.sides[folded[f]];
    for (std::size_t i = 0; i < 3; ++i) {
      B(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(i)) = side.own[i] + side.other[i];
    }
  }
  const Eigen::MatrixXd G = curvature_of_angles(B, poissons_ratio);
  for (std::size_t f = 0; f < folded.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      fit.curvature[3 * i + folded[f]] = G(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(f));
    }
  }
  return fit;
}

namespace {

/// d.kappa of a neighbour by its angles, d in the plane of the own triangle, in which the neighbour is unfolded.
std::array<double, 3> by_angles_of(const PlateNeighbour& neighbour, const std::array<double, 2>& common,
                                   const std::array<double, 3>& d) {
  // The common side has the opposite direction in the neighbour: R turns the neighbour's frame into the own one.
  const std::array<double, 2>& there = neighbour.fit->sides[neighbour.side].direction;
  const double c = -(there[0] * common[0] + there[1] * common[1]), s = -(there[0] * common[1] - there[1] * common[0]);
  Eigen::Matrix2d R, D;
  R << c, -s, s, c;
  // d.kappa = D : K with K = [xx xy; xy yy]; d has 2 xy for its third.
  D << d[0], d[2], d[2], d[1];
  const Eigen::Matrix2d turned = R.transpose() * D * R;
  const std::array<double, 3> e{turned(0, 0), turned(1, 1), turned(0, 1)};
  std::array<double, 3> result{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) result[j] += e[i] * neighbour.fit->curvature[3 * i + j];
  }
  return result;
}

}  // namespace

PlateCurvature plate_curvature(const PlateFit& own, const std::array<PlateNeighbour, 3>& neighbours) {
  PlateCurvature result{};
  for (std::size_t k = 0; k < 3; ++k) {
    const PlateFit::Side& side = own.sides[k];
    if (side.kind == PlateSide::free) continue;
    const Eigen::Vector3d factor = side.length / own.area * across(side.direction);
    const auto add = [&](std::size_t column, double part) {
      for (std::size_t i = 0; i < 3; ++i) result[column][i] += part * factor[static_cast<Eigen::Index>(i)];
    };
    add(k, 0.5);
    if (side.kind == PlateSide::mirrored) continue;
    const PlateFit* const other = neighbours[k].fit;
    const bool takes_other = other != nullptr && (other->is_complete || !own.is_complete);
    const bool takes_own = own.is_complete || other == nullptr || !other->is_complete;
    const double part = takes_own && takes_other ? 0.25 : 0.5;
    std::array<double, 3> d{};
    for (std::size_t i = 0; i < 3; ++i) d[i] = side.own[i] - side.other[i];
    for (std::size_t j = 0; takes_own && j < 3; ++j) {
      double of_angle = 0.0;
      for (std::size_t i = 0; i < 3; ++i) of_angle += d[i] * own.curvature[3 * i + j];
      add(j, part * of_angle);
    }
    if (!takes_other) continue;
    const auto of_angles = by_angles_of(neighbours[k], side.direction, d);
    for (std::size_t j = 0; j < 3; ++j) add(3 + 3 * k + j, part * of_angles[j]);
  }
  return result;
}

namespace {

/// (n_x^2, n_y^2, 2 n_x n_y) of the free sides, as columns.
Eigen::MatrixXd across_free_sides(const PlateFit& own) {
  std::vector<Eigen::Vector3d> free;
  for (const PlateFit::Side& side : own.sides) {
    if (side.kind == PlateSide::free) free.push_back(across(side.direction));
  }
  Eigen::MatrixXd L(3, free.size());
  for (std::size_t f = 0; f < free.size(); ++f) L.col(static_cast<Eigen::Index>(f)) = free[f];
  return L;
}

}  // namespace

std::array<double, 9> plate_extension(const PlateFit& own, double poissons_ratio) {
  const Eigen::MatrixXd L = across_free_sides(own);
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  // Three free sides leave no moment, and no angle to which anything could be added.
  if (L.cols() > 0 && L.cols() < 3) {
    const Eigen::MatrixXd LC = L.transpose() * stiffness_of_plate(poissons_ratio);
    T -= L * (LC * L).inverse() * LC;
  }
  std::array<double, 9> result{};
  for (std::size_t i = 0; i < 9; ++i) {
    result[i] = T(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3));
  }
  return result;
}

std::array<double, 9> plate_stiffness(const PlateFit& own, double rigidity, double poissons_ratio) {
  Eigen::Matrix3d C = stiffness_of_plate(poissons_ratio);
  const Eigen::MatrixXd L = across_free_sides(own);
  if (L.cols() > 0) {
    const Eigen::MatrixXd LC = L.transpose() * C;
    C -= LC.transpose() * (LC * L).inverse() * LC;
  }
  std::array<double, 9> result{};
  for (std::size_t i = 0; i < 9; ++i) {
    const auto row = static_cast<Eigen::Index>(i / 3), column = static_cast<Eigen::Index>(i % 3);
    result[i] = 0.5 * rigidity * (C(row, column) + C(column, row));
  }
  return result;
}

}  // namespace pliant
