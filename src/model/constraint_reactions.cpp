// The reactions of constraints: forces and moments of supports and joints.
#include "energy/rigid/rigid_fit.hpp"
#include "model/constraints.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <climits>

namespace pliant {

std::vector<Vector3<double>> Constraints::centres_of_supports(Vec q) const {
  std::vector<Vector3<double>> centres(supports_.size());
  std::vector<double> extremes(6 * supports_.size(), -std::numeric_limits<double>::infinity());
  {
    const ConstArrayView u(q);
    for (std::size_t s = 0; s < supports_.size(); ++s) {
      for (const PetscInt dof : supports_[s].dofs) {
        const auto X = layout_.position(dof / 3);
        for (std::size_t i = 0; i < 3; ++i) {
          const double x = X[i] + u[3 * (dof / 3) + static_cast<PetscInt>(i)];
          extremes[6 * s + i] = std::max(extremes[6 * s + i], x);
          extremes[6 * s + 3 + i] = std::max(extremes[6 * s + 3 + i], -x);
        }
      }
    }
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, extremes.data(), static_cast<int>(extremes.size()), MPI_DOUBLE, MPI_MAX,
                          layout_.comm));
  for (std::size_t s = 0; s < supports_.size(); ++s) {
    if (!supports_[s].rigid_part) {
      for (std::size_t i = 0; i < 3 && std::isfinite(extremes[6 * s]); ++i)
        centres[s][i] = 0.5 * (extremes[6 * s + i] - extremes[6 * s + 3 + i]);
      continue;
    }
    const Part& part = parts_[*supports_[s].rigid_part];
    const Vector3<double>& centre = part.displacement.rigid->centre;
    centres[s] = centre + nearest_placement(layout_, part.nodes, centre, q).translation;
  }
  return centres;
}

std::vector<Reaction> Constraints::reactions(Vec r, Vec q) const {
  const std::vector<Vector3<double>> centres = centres_of_supports(q);
  std::vector<Placement> placements(parts_.size());  // of rigid parts of supports
  const auto is_rigid = [&](std::size_t c) {
    return parts_[c].displacement.rigid.has_value() && support_of_part_[c] != no_support;
  };
  for (std::size_t c = 0; c < parts_.size(); ++c) {
    if (!is_rigid(c) || !map_ || !map_->has_ties()) continue;
    placements[c] = nearest_placement(layout_, parts_[c].nodes, parts_[c].displacement.rigid->centre, q);
  }
  std::vector<double> sums(6 * supports_.size(), 0.0);
  {
    const ConstArrayView reaction(r), u(q);
    for (std::size_t s = 0; s < supports_.size(); ++s) {
      for (const PetscInt dof : supports_[s].dofs) {
        const int i = dof % 3, j = (i + 1) % 3, k = (i + 2) % 3;
        const PetscInt node = dof / 3;
        const auto X = layout_.position(node);
        const auto arm = [&](int m) { return X[m] + u[3 * node + m] - centres[s][m]; };
        sums[6 * s + i] += reaction[dof];
        sums[6 * s + 3 + j] += arm(k) * reaction[dof];
        sums[6 * s + 3 + k] -= arm(j) * reaction[dof];
      }
    }
  }
  if (map_) {
    add_multipliers(r, sums);
    add_moments_of_ties(r, q, centres, sums);
    map_->for_each_given(r, [&](const GivenTerm& term, double force) {
      if (!is_rigid(term.source)) return;
      const std::size_t s = support_of_part_[term.source];
      const Vector3<double> at_start = term.X - parts_[term.source].displacement.rigid->centre;
      const Vector3<double> arm = term.X + placements[term.source].displacement(at_start) - centres[s];
      const auto i = static_cast<std::size_t>(term.component), j = (i + 1) % 3, k = (i + 2) % 3;
      sums[6 * s + i] += force;
      sums[6 * s + 3 + j] += arm[k] * force;
      sums[6 * s + 3 + k] -= arm[j] * force;
    });
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, layout_.comm));
  std::vector<Reaction> result(supports_.size());
  for (std::size_t s = 0; s < supports_.size(); ++s) {
    std::copy_n(sums.begin() + 6 * static_cast<std::ptrdiff_t>(s), 3, result[s].force.begin());
    std::copy_n(sums.begin() + 6 * static_cast<std::ptrdiff_t>(s) + 3, 3, result[s].torque.begin());
  }
  add_joints(r, q, centres, result);
  return result;
}

// A joint exerts on its first body the opposite of what it exerts on the second, at the same place.
void Constraints::add_joints(Vec r, Vec q, std::span<const Vector3<double>> centres,
                             std::vector<Reaction>& reactions) const {
  const auto is_supported = [&](std::size_t part) {
    return part != ModelJoint::ground && support_of_part_[part] != no_support;
  };
  const auto is_at_support = [&](const ModelJoint& joint) { return std::ranges::any_of(joint.parts, is_supported); };
  if (std::ranges::none_of(joints_, is_at_support)) return;
  const std::vector<JointReaction> on_second = joint_reactions(r, q);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const ModelJoint& joint = joints_[j];
    if (!is_at_support(joint)) continue;
    const auto states = joint.mechanism->states(joint.bodies, q, q);
    const Vector3<double> place = states[1].motion().point(joint.second_point);
    for (std::size_t side = 0; side < 2; ++side) {
      if (!is_supported(joint.parts[side])) continue;
      const std::size_t s = support_of_part_[joint.parts[side]];
      const double sign = side == 0 ? 1.0 : -1.0;
      const Vector3<double> moment = on_second[j].torque + cross(place - centres[s], on_second[j].force);
      for (std::size_t i = 0; i < 3; ++i) {
        reactions[s].force[i] += sign * on_second[j].force[i];
        reactions[s].torque[i] += sign * moment[i];
      }
    }
  }
}

std::vector<JointReaction> Constraints::joint_reactions(Vec r, Vec q) const {
  std::vector<JointReaction> result(joints_.size());
  std::vector<const Mechanism*> done;
  for (const ModelJoint& first : joints_) {
    if (std::ranges::find(done, first.mechanism) != done.end()) continue;
    done.push_back(first.mechanism);
    std::vector<Vector3<double>> points;
    std::vector<std::size_t> numbers;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (joints_[j].mechanism != first.mechanism) continue;
      points.push_back(joints_[j].second_point);
      numbers.push_back(j);
    }
    const auto reactions = first.mechanism->reactions(r, q, points);
    for (std::size_t k = 0; k < numbers.size(); ++k) result[numbers[k]] = reactions[k];
  }
  return result;
}

// What reaches held nodes through ties; the slave, and its rank, may be another than the node's.
void Constraints::add_moments_of_ties(Vec r, Vec q, std::span<const Vector3<double>> centres,
                                      std::vector<double>& sums) const {
  struct TiedForce {
    std::size_t support = 0;
    Vector3<double> X{};  ///< of the held node
    Vector3<double> force{};
  };
  std::vector<TiedForce> mine;
  map_->for_each_given(r, [&](const GivenTerm& term, double force) {
    if (parts_[term.source].displacement.rigid) return;
    TiedForce& tied = mine.emplace_back(TiedForce{support_of_part_[term.source], term.X, {}});
    tied.force[static_cast<std::size_t>(term.component)] = force;
  });
  const auto all = gathered(layout_.comm, mine);
  if (all.empty()) return;
  std::map<std::pair<std::size_t, std::array<double, 3>>, PetscInt> node_at;
  for (std::size_t s = 0; s < supports_.size(); ++s) {
    for (const PetscInt dof : supports_[s].dofs) node_at[{s, layout_.position(dof / 3)}] = dof / 3;
  }
  // Nodes of bodies that are not joined may coincide, on different ranks too: they move alike, and one counts.
  const auto node_of = [&](const TiedForce& tied) {
    const auto found = node_at.find({tied.support, {tied.X[0], tied.X[1], tied.X[2]}});
    return found != node_at.end() ? found->second : -1;
  };
  std::vector<int> counted_by;
  for (const TiedForce& tied : all) counted_by.push_back(node_of(tied) >= 0 ? rank(layout_.comm) : INT_MAX);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counted_by.data(), static_cast<int>(counted_by.size()), MPI_INT, MPI_MIN,
                          layout_.comm));
  const ConstArrayView u(q);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const TiedForce& tied = all[k];
    if (counted_by[k] != rank(layout_.comm)) continue;
    const PetscInt node = node_of(tied);
    const Vector3<double> arm =
        tied.X + Vector3<double>{u[3 * node], u[3 * node + 1], u[3 * node + 2]} - centres[tied.support];
    const Vector3<double> moment = cross(arm, tied.force);
    for (std::size_t i = 0; i < 3; ++i) sums[6 * tied.support + 3 + i] += moment[i];
  }
}

// The nodes of a rigid part are counted one by one.
void Constraints::add_multipliers(Vec r, std::vector<double>& sums) const {
  const auto multipliers = map_->multipliers(r);
  for (std::size_t c = 0; c < parts_.size(); ++c) {
    const Part& part = parts_[c];
    if (part.displacement.rigid) continue;
    const bool has_direction = dot(part.direction, part.direction) > 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      sums[6 * support_of_part_[c] + i] += has_direction ? multipliers[c][0] * part.direction[i] : multipliers[c][i];
    }
  }
}

}  // namespace pliant
