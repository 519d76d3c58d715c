#include "energy/rod/rods.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

// The start of rods.

namespace pliant {

void Rods::turn_frames(Vec q) const {
  {
    update_ghosts(q);
    const ConstGhostedView view(q);
    const std::vector<double> u(view.span().begin(), view.span().end());
    const ArrayView displacements(q);
    for (const SegmentNodes& of : segments_here()) {
      const auto& axes = frames_[of.number].axes;
      const auto& corners = segments_[of.number].corners;
      const auto h = change_of_columns(of, u);
      const Vector3<double> n = unit(axes[0] + h[0]), across = axes[1] + h[1];
      const Vector3<double> first = unit(across - dot(across, n) * n);
      const std::array<Vector3<double>, 3> changes{h[0], first - axes[1], cross(n, first) - axes[2]};
      for (std::size_t a = 2; a < 4; ++a) {
        if (of.nodes[a] >= num_owned_nodes_) continue;
        const Vector3<double> arm = corners[a] - corners[0];
        for (std::size_t i = 0; i < 3; ++i) {
          double& entry = displacements[3 * of.nodes[a] + static_cast<PetscInt>(i)];
          entry = u[3 * static_cast<std::size_t>(of.nodes[0]) + i];
          for (std::size_t k = 0; k < 3; ++k) entry += dot(arm, axes[k]) * changes[k][i];
        }
      }
    }
  }
  update_ghosts(q);
  const ConstGhostedView view(q);
  const std::vector<double> u(view.span().begin(), view.span().end());
  const ArrayView displacements(q);
  for (const Middle& middle : middles_) {
    for (PetscInt i = 0; i < 3 && middle.node < num_owned_nodes_; ++i) {
      displacements[3 * middle.node + i] =
          0.5 * (u[static_cast<std::size_t>(3 * middle.a + i)] + u[static_cast<std::size_t>(3 * middle.b + i)]);
    }
  }
}

}  // namespace pliant
