#include "material/projection.hpp"

#include "base/vector_math.hpp"

namespace pliant {
namespace {

/// Off-diagonal entries below this fraction of the norm of the matrix count as zero.
constexpr double negligible = 1e-16;
/// More sweeps than any matrix of at most ten rows needs.
constexpr int max_sweeps = 30;

template <std::size_t n>
using Square = std::array<Pack, n * n>;

template <std::size_t n>
Pack sum_of_squares(const Square<n>& A) {
  Pack sum = 0.0;
  for (const Pack& a : A) sum += a * a;
  return sum;
}

/// The rotation of the rows p < q (and columns) that makes A_pq zero, in the upper triangle of A; V follows.
template <std::size_t n>
void rotate(Square<n>& A, Square<n>& V, std::size_t p, std::size_t q) {
  const auto upper = [&A](std::size_t i, std::size_t j) -> Pack& { return i < j ? A[n * i + j] : A[n * j + i]; };
  const Pack apq = A[n * p + q], difference = A[n * q + q] - A[n * p + p], twice = 2.0 * apq;
  // t = tan of the smaller angle: twice / (difference + sign(difference) sqrt(difference^2 + twice^2)).
  const Pack root = sqrt(difference * difference + twice * twice);
  const Pack denominator = select(difference < 0.0, difference - root, difference + root);
  const Pack t = select(denominator == 0.0, Pack(0.0), twice / select(denominator == 0.0, Pack(1.0), denominator));
  const Pack c = 1.0 / sqrt(1.0 + t * t), s = t * c;
  A[n * p + p] -= t * apq;
  A[n * q + q] += t * apq;
  A[n * p + q] = 0.0;
  for (std::size_t r = 0; r < n; ++r) {
    if (r != p && r != q) {
      Pack &arp = upper(r, p), &arq = upper(r, q);
      const Pack old = arp;
      arp = c * old - s * arq;
      arq = s * old + c * arq;
    }
    Pack &vp = V[n * r + p], &vq = V[n * r + q];
    const Pack old = vp;
    vp = c * old - s * vq;
    vq = s * old + c * vq;
  }
}

/// Jacobi's method, lane by lane in step: A becomes diagonal (read in its upper triangle), and V, orthogonal at the
/// start, is multiplied from the right by the eigenvectors of A. Pairs that are zero in all lanes cost nothing, so that
/// a matrix that is nearly diagonal takes few rotations.
template <std::size_t n>
void diagonalize(Square<n>& A, Square<n>& V) {
  const Pack threshold = negligible * negligible * sum_of_squares<n>(A);
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    bool is_diagonal = true;
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t q = p + 1; q < n; ++q) {
        const Pack apq = A[n * p + q];
        if (!any_of(apq * apq > threshold)) continue;
        is_diagonal = false;
        rotate<n>(A, V, p, q);
      }
    }
    if (is_diagonal) return;
  }
}

template <std::size_t n>
Square<n> unit_matrix() {
  Square<n> I;
  I.fill(0.0);
  for (std::size_t k = 0; k < n; ++k) I[n * k + k] = 1.0;
  return I;
}

/// Raises the eigenvalues of M to `floor`; `reduced` = V^T M V. Lanes that are not finite keep their values.
template <std::size_t n>
void raise_eigenvalues(Square<n>& M, Square<n> reduced, Square<n> V, double floor) {
  Pack nothing = 0.0;
  for (const Pack& m : reduced) nothing += 0.0 * m;
  const auto is_finite = nothing == 0.0;
  for (Pack& m : reduced) m = select(is_finite, m, Pack(0.0));
  diagonalize<n>(reduced, V);
  for (std::size_t k = 0; k < n; ++k) {
    const Pack value = reduced[n * k + k];
    const auto is_low = value < floor && is_finite;
    if (!any_of(is_low)) continue;
    // The other eigenvalues remain exact.
    const Pack change = select(is_low, floor - value, Pack(0.0));
    for (std::size_t p = 0; p < n; ++p) {
      const Pack scaled = change * select(is_low, V[n * p + k], Pack(0.0));
      for (std::size_t q = 0; q < n; ++q) M[n * p + q] += scaled * select(is_low, V[n * q + k], Pack(0.0));
    }
  }
}

/// Rotations U and V with U^T F V diagonal, F = I + H, from the principal directions of the strain; rotations in any
/// case, if F has no such.
struct PrincipalFrames {
  Tensor3<Pack> U, V;  // columns
};

PrincipalFrames principal_frames(const Tensor3<Pack>& H) {
  Square<3> E, V = unit_matrix<3>();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      E[static_cast<std::size_t>(3 * i + j)] =
          H(i, j) + H(j, i) + H(0, i) * H(0, j) + H(1, i) * H(1, j) + H(2, i) * H(2, j);
    }
  }
  diagonalize<3>(E, V);
  PrincipalFrames frames{{}, {V}};
  const Tensor3<Pack> FV = matmul(add_to_diagonal(H, 1.0), frames.V);
  const auto column = [](const Tensor3<Pack>& A, int j) { return std::array<Pack, 3>{A(0, j), A(1, j), A(2, j)}; };
  const auto product = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  auto a = column(FV, 0), b = column(FV, 1);
  const Pack length_a = sqrt(product(a, a));
  for (Pack& x : a) x /= length_a;
  const Pack along = product(a, b);
  for (std::size_t i = 0; i < 3; ++i) b[i] -= along * a[i];
  const Pack length_b = sqrt(product(b, b));
  for (Pack& x : b) x /= length_b;
  // Where F flattens the first directions, rounding would not leave b orthogonal to a.
  const auto is_rotation = length_a > 0.0 && length_b > 0.0 && abs(product(a, b)) < 1e-15;
  const Square<3> I = unit_matrix<3>();
  const std::array<std::array<Pack, 3>, 3> columns{
      a, b, {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
  frames.U = make_tensor([&](int i, int j) -> Pack {
    return select(is_rotation, columns[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)],
                  I[static_cast<std::size_t>(3 * i + j)]);
  });
  return frames;
}

}  // namespace

void project_to_positive_semidefinite(Tangent<Pack>& A, const Tensor3<Pack>& H, double floor) {
  const auto [U, V] = principal_frames(H);
  // Columns u_a v_b of Q, and Q^T A Q index by index.
  Square<9> Q, reduced = A;
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) Q[9 * p + q] = U.a[3 * (p / 3) + q / 3] * V.a[3 * (p % 3) + q % 3];
  }
  // An index of three at the distance `stride` in the array turns into that along the columns of R.
  const auto turn = [&reduced](const Tensor3<Pack>& R, std::size_t stride) {
    for (std::size_t k = 0; k < 81; ++k) {
      if (k / stride % 3 != 0) continue;
      const Pack x = reduced[k], y = reduced[k + stride], z = reduced[k + 2 * stride];
      for (std::size_t c = 0; c < 3; ++c) reduced[k + c * stride] = R.a[c] * x + R.a[3 + c] * y + R.a[6 + c] * z;
    }
  };
  turn(V, 1);
  turn(U, 3);
  turn(V, 9);
  turn(U, 27);
  raise_eigenvalues<9>(A, reduced, Q, floor);
}

void project_to_positive_semidefinite(std::array<Pack, 100>& M) {
  raise_eigenvalues<10>(M, M, unit_matrix<10>(), 0.0);
}

void project_to_positive_semidefinite(Tensor3<Pack>& S) {
  raise_eigenvalues<3>(S.a, S.a, unit_matrix<3>(), 0.0);
}

}  // namespace pliant
