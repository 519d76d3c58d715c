#include "energy/constraint/part_motion.hpp"

#include <array>

namespace pliant {
namespace {

using Once = JointSystem::Once;
using Twice = JointSystem::Twice;

BodyMotion<Twice> moved_along(const RigidPart& part, const PartMotion& motion, std::span<const double> unknowns, int k,
                              int l) {
  if (part.is_symmetric()) {  // w = t
    std::vector<Twice> moved;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      const double along_k = static_cast<int>(i) == k ? 1.0 : 0.0, along_l = static_cast<int>(i) == l ? 1.0 : 0.0;
      moved.push_back({Once(unknowns[i], along_l), Once(along_k, 0.0)});
    }
    return part.motion(std::span<const Twice>(moved));
  }
  const auto once =
      with_slope(motion.value, l >= 0 ? motion.columns[static_cast<std::size_t>(l)] : BodyMotion<double>{});
  const auto along = k >= 0 ? part.virtual_motion(static_cast<std::size_t>(k), once) : BodyMotion<Once>{};
  BodyMotion<Twice> result{motion.value.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = {once.translation[i], along.translation[i]};
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = {once.gradient.a[i], along.gradient.a[i]};
  return result;
}

}  // namespace

PartMotion motion_of_part(const RigidPart& part, std::span<const double> unknowns) {
  PartMotion motion;
  motion.value = part.motion(unknowns);
  std::vector<Once> with_slopes(unknowns.begin(), unknowns.end());
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    with_slopes[k].slope = 1.0;
    const auto moved = part.motion(std::span<const Once>(with_slopes));
    with_slopes[k].slope = 0.0;
    BodyMotion<double>& column = motion.columns.emplace_back(BodyMotion<double>{moved.centre, {}, {}});
    for (std::size_t i = 0; i < 3; ++i) column.translation[i] = moved.translation[i].slope;
    for (std::size_t i = 0; i < 9; ++i) column.gradient.a[i] = moved.gradient.a[i].slope;
    motion.test_columns.push_back(part.is_symmetric() ? column : part.virtual_motion(k, motion.value));
  }
  return motion;
}

std::vector<BodyMotion<Twice>> twice_moved(const RigidPart& part, const PartMotion& motion,
                                           std::span<const double> unknowns) {
  std::vector<BodyMotion<Twice>> result;
  const auto n = static_cast<int>(unknowns.size());
  for (int k = -1; k < n; ++k) {
    for (int l = -1; l < n; ++l) result.push_back(moved_along(part, motion, unknowns, k, l));
  }
  return result;
}

std::vector<double> forces_on_unknowns(const RigidPart& part, std::span<const double> unknowns,
                                       std::span<const double> forces) {
  std::vector<double> result(unknowns.size(), 0.0);
  std::array<Vector3<double>, 6> columns{};
  const auto own = std::span(columns).first(unknowns.size());
  for (const PetscInt a : part.nodes()) {
    part.put_test_columns(unknowns, a, own);
    for (std::size_t k = 0; k < own.size(); ++k) {
      for (std::size_t i = 0; i < 3; ++i) result[k] += forces[3 * static_cast<std::size_t>(a) + i] * own[k][i];
    }
  }
  return result;
}

}  // namespace pliant
