#include "time/rotation.hpp"

namespace pliant {

Quaternion exponential(const Vector3<double>& xi) {
  const double x = 0.25 * dot(xi, xi), s = 0.5 * stumpff<1>(x);
  return {stumpff<0>(x), s * xi[0], s * xi[1], s * xi[2]};
}

Vector3<double> logarithm(const Quaternion& b) {
  const double sign = b[0] < 0.0 ? -1.0 : 1.0;  // of the two quaternions the one that turns by at most pi
  const double s = std::hypot(b[1], b[2], b[3]), c = sign * b[0];
  const double angle_per_sine = s > 0.0 ? 2.0 * std::atan2(s, c) / s : 2.0 / c;
  return (sign * angle_per_sine) * Vector3<double>{b[1], b[2], b[3]};
}

Quaternion product(const Quaternion& a, const Quaternion& b) {
  Quaternion c = {
      a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
      a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
  const double length = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3]);
  for (double& c_i : c) c_i /= length;
  return c;
}

Quaternion inverse(const Quaternion& a) {
  return {a[0], -a[1], -a[2], -a[3]};
}

Vector3<double> turn(const Quaternion& R, const Vector3<double>& a) {
  const Vector3<double> n = {R[1], R[2], R[3]}, b = cross(n, a);
  return a + 2.0 * (R[0] * b + cross(n, b));
}

Tensor3<double> rotation_matrix(const Quaternion& R) {
  const std::array<Vector3<double>, 3> columns = {turn(R, {1, 0, 0}), turn(R, {0, 1, 0}), turn(R, {0, 0, 1})};
  return make_tensor([&](int i, int j) { return columns[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)]; });
}

}  // namespace pliant
