#include "collision/intersection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// a + b = value + rest, and so on, exactly.
struct Exact {
  double value, rest;
};
Exact two_sum(double a, double b) {
  const double sum = a + b, b_part = sum - a, a_part = sum - b_part;
  return {sum, (a - a_part) + (b - b_part)};
}
Exact two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

/// A sum of doubles without rounding, as parts that do not overlap, in increasing order (Shewchuk's GROW-EXPANSION).
class ExactSum {
 public:
  void add(double term) {
    std::size_t kept = 0;
    for (std::size_t n = 0; n < size_; ++n) {
      const Exact sum = two_sum(term, parts_[n]);
      if (sum.rest != 0.0) parts_[kept++] = sum.rest;
      term = sum.value;
    }
    if (term != 0.0) parts_[kept++] = term;
    size_ = kept;
  }
  int sign() const { return size_ == 0 ? 0 : (parts_[size_ - 1] > 0.0 ? 1 : -1); }

 private:
  std::array<double, 200> parts_;  // of the 192 terms of a determinant
  std::size_t size_ = 0;
};

/// Adds sign * u v w of differences.
void add_product(ExactSum& sum, double sign, const Exact& u, const Exact& v, const Exact& w) {
  for (const double a : {sign * u.value, sign * u.rest}) {
    for (const double b : {v.value, v.rest}) {
      if (a == 0.0 || b == 0.0) continue;
      const Exact ab = two_product(a, b);
      for (const double c : {w.value, w.rest}) {
        for (const double part : {ab.value, ab.rest}) {
          if (part == 0.0 || c == 0.0) continue;
          const Exact product = two_product(part, c);
          sum.add(product.rest);
          sum.add(product.value);
        }
      }
    }
  }
}

using ExactVector = std::array<Exact, 3>;
ExactVector exact_difference(const Vector3<double>& a, const Vector3<double>& b) {
  return {two_sum(a[0], -b[0]), two_sum(a[1], -b[1]), two_sum(a[2], -b[2])};
}

/// u x v . w
int exact_sign(const ExactVector& u, const ExactVector& v, const ExactVector& w) {
  ExactSum sum;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    add_product(sum, 1.0, u[k], v[l], w[m]);
    add_product(sum, -1.0, u[l], v[k], w[m]);
  }
  return sum.sign();
}

/// The turn a, b, c in the plane without the coordinate `without`.
int orientation_in_plane(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c, int without) {
  ExactVector w{};
  w[without] = {1.0, 0.0};
  return exact_sign(exact_difference(b, a), exact_difference(c, a), w);
}

bool meet_in_plane(const std::array<Vector3<double>, 2>& segment, const std::array<Vector3<double>, 3>& triangle,
                   int without) {
  const auto side = [&](const auto& a, const auto& b, const auto& c) { return orientation_in_plane(a, b, c, without); };
  for (int k = 0; k < 3; ++k) {  // an edge with the segment behind it
    const auto &a = triangle[k], &b = triangle[(k + 1) % 3];
    const int inside = side(a, b, triangle[(k + 2) % 3]);
    if (inside * side(a, b, segment[0]) < 0 && inside * side(a, b, segment[1]) < 0) return false;
  }
  const int first = side(segment[0], segment[1], triangle[0]);
  return first == 0 || side(segment[0], segment[1], triangle[1]) != first ||
         side(segment[0], segment[1], triangle[2]) != first;
}

}  // namespace

int orientation(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c,
                const Vector3<double>& d) {
  const Vector3<double> u = b - a, v = c - a, w = d - a;
  double determinant = 0.0, size = 0.0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    determinant += (u[k] * v[l] - u[l] * v[k]) * w[m];
    size += (std::abs(u[k] * v[l]) + std::abs(u[l] * v[k])) * std::abs(w[m]);
  }
  // Shewchuk has 7 + 56 eps halves of epsilon for sums in his order; any order needs fewer than 8 epsilon.
  if (std::abs(determinant) > 8.0 * std::numeric_limits<double>::epsilon() * size) return determinant > 0.0 ? 1 : -1;
  return exact_sign(exact_difference(b, a), exact_difference(c, a), exact_difference(d, a));
}

bool segment_meets_triangle(const std::array<Vector3<double>, 2>& segment,
                            const std::array<Vector3<double>, 3>& triangle) {
  const auto& [p, q] = segment;
  const auto& [a, b, c] = triangle;
  for (int k = 0; k < 3; ++k) {
    if (std::max(p[k], q[k]) < std::min({a[k], b[k], c[k]}) || std::min(p[k], q[k]) > std::max({a[k], b[k], c[k]})) {
      return false;
    }
  }
  const int at_p = orientation(a, b, c, p), at_q = orientation(a, b, c, q);
  if (at_p * at_q > 0) return false;
  if (at_p == 0 && at_q == 0) {
    return meet_in_plane(segment, triangle, 0) && meet_in_plane(segment, triangle, 1) &&
           meet_in_plane(segment, triangle, 2);
  }
  const int ab = orientation(p, q, a, b), bc = orientation(p, q, b, c), ca = orientation(p, q, c, a);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

bool triangles_meet(const std::array<Vector3<double>, 3>& a, const std::array<Vector3<double>, 3>& b) {
  for (int k = 0; k < 3; ++k) {
    if (segment_meets_triangle({a[k], a[(k + 1) % 3]}, b) || segment_meets_triangle({b[k], b[(k + 1) % 3]}, a)) {
      return true;
    }
  }
  return false;
}

}  // namespace pliant
