#include "collision/mollifier.hpp"

namespace pliant {
namespace {

constexpr double threshold_part = 1e-3;

}  // namespace

double mollifier_threshold(std::span<const Vector3<double>, 4> X) {
  const Vector3<double> U = X[1] - X[0], V = X[3] - X[2];
  return threshold_part * dot(U, U) * dot(V, V);
}

double edge_edge_mollifier_value(std::span<const Vector3<double>, 4> x, double threshold) {
  const Vector3<double> normal = cross(x[1] - x[0], x[3] - x[2]);
  const double y = dot(normal, normal) / threshold;
  return y < 1.0 ? y * y * y * (10.0 + y * (-15.0 + 6.0 * y)) : 1.0;
}

// dc/du = 2 v x (u x v) and dc/dv = 2 (u x v) x u, without cancellation; of c = u^2 v^2 - (u.v)^2
//   d2c/du2 = 2 (v^2 I - v v^T),   d2c/dv2 = 2 (u^2 I - u u^T),   d2c/du dv = 2 (2 u v^T - v u^T - u.v I)
Expansion<4> edge_edge_mollifier(std::span<const Vector3<double>, 4> x, double threshold) {
  const Vector3<double> u = x[1] - x[0], v = x[3] - x[2], normal = cross(u, v);
  const double y = dot(normal, normal) / threshold;
  Expansion<4> m;
  m.value = 1.0;
  if (y >= 1.0) return m;
  m.value = y * y * y * (10.0 + y * (-15.0 + 6.0 * y));
  const double slope = 30.0 * y * y * (1.0 - y) * (1.0 - y) / threshold;
  const double bend = 60.0 * y * (1.0 - y) * (1.0 - 2.0 * y) / (threshold * threshold);
  const Vector3<double> c_u = 2.0 * cross(v, normal), c_v = 2.0 * cross(normal, u);
  const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v);
  m.gradient = {-slope * c_u, slope * c_u, -slope * c_v, slope * c_v};
  const auto second = [&](const Vector3<double>& first, const Vector3<double>& other, const auto& c) {
    return make_tensor([&](int p, int q) { return bend * first[p] * other[q] + 2.0 * slope * c(p, q); });
  };
  const auto delta = [](int p, int q) { return p == q ? 1.0 : 0.0; };
  const Tensor3<double> m_uu = second(c_u, c_u, [&](int p, int q) { return vv * delta(p, q) - v[p] * v[q]; });
  const Tensor3<double> m_vv = second(c_v, c_v, [&](int p, int q) { return uu * delta(p, q) - u[p] * u[q]; });
  const Tensor3<double> m_uv =
      second(c_u, c_v, [&](int p, int q) { return 2.0 * u[p] * v[q] - v[p] * u[q] - uv * delta(p, q); });
  const Tensor3<double> m_vu = transpose(m_uv);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const double sign = i % 2 == j % 2 ? 1.0 : -1.0;
      m.block(i, j) = sign * (i < 2 ? (j < 2 ? m_uu : m_uv) : (j < 2 ? m_vu : m_vv));
    }
  }
  return m;
}

}  // namespace pliant
