#include "energy/rigid/affine_fit.hpp"

#include "material/spectral.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

namespace pliant {
namespace {

/// Nodes closer to a plane than this fraction of their size lie in it.
constexpr double flatness = 1e-6;

Vector3<double> column(const Tensor3<double>& A, int k) {
  return {A(0, k), A(1, k), A(2, k)};
}

}  // namespace

AffineFit::AffineFit(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre)
    : centre_(centre) {
  std::array<double, 4> first{};
  for (const PetscInt a : nodes) {
    const auto arm = layout.position(a) - centre;
    first[0] += 1.0;
    for (std::size_t i = 0; i < 3; ++i) first[1 + i] += arm[i];
  }
  sum_in_place(layout.comm, first);
  number_ = first[0];
  mean_arm_ = (1.0 / number_) * Vector3<double>{first[1], first[2], first[3]};
  for (const PetscInt a : nodes) {
    const auto r = layout.position(a) - centre - mean_arm_;
    second_moment_ = second_moment_ + outer(r, r);
  }
  sum_in_place(layout.comm, second_moment_.a);
  const auto eigen = eigen_decomposition(second_moment_);
  for (int k = 0; k < 3; ++k) {
    const auto n = column(eigen.vectors, k);
    const double value = eigen.values[static_cast<std::size_t>(k)];
    if (value > flatness * flatness * eigen.values[0]) {
      inverse_ = inverse_ + (1.0 / value) * outer(n, n);
    } else {
      in_plane_ = in_plane_ - outer(n, n);
    }
  }
}

AffineFit::AffineFit(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre,
                     const Vector3<double>& axis)
    : AffineFit(layout, nodes, centre) {
  has_axis_ = true;
  in_plane_ = identity<double>();
  across_ = identity<double>() - outer(axis, axis);
  turn_ = {{0.0, -axis[2], axis[1], axis[2], 0.0, -axis[0], -axis[1], axis[0], 0.0}};
}

AffineMotion AffineFit::operator()(const NodeLayout& layout, std::span<const PetscInt> nodes, Vec u) const {
  std::array<double, 12> sums{};
  {
    const ConstArrayView values(u);
    for (const PetscInt a : nodes) {
      const auto r = layout.position(a) - centre_ - mean_arm_;
      for (std::size_t i = 0; i < 3; ++i) {
        const double u_i = values[3 * a + static_cast<PetscInt>(i)];
        sums[i] += u_i;
        for (std::size_t k = 0; k < 3; ++k) sums[3 + 3 * i + k] += u_i * r[k];
      }
    }
  }
  sum_in_place(layout.comm, sums);
  const auto moment = make_tensor([&](int i, int k) { return sums[static_cast<std::size_t>(3 + 3 * i + k)]; });
  AffineMotion motion;
  if (has_axis_) {
    const double size = dot(across_, second_moment_);
    motion.gradient = (dot(across_, moment) / size) * across_ + (dot(turn_, moment) / size) * turn_;
  } else {
    motion.gradient = matmul(moment, inverse_);
  }
  motion.translation =
      (1.0 / number_) * Vector3<double>{sums[0], sums[1], sums[2]} - matvec(motion.gradient, mean_arm_);
  return motion;
}

}  // namespace pliant
