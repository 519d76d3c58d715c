#include "energy/constraint/mechanism.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

// The equations of the joints in a stage, and the forces in a mechanism.

namespace pliant {

void Mechanism::evaluate(const std::vector<PartMotion>& parts, Vector& h, JointDerivative& G) const {
  evaluate_all(parts, h, G);
  if (lag_ != 0.0) h -= lag_ * violation_;
}

void Mechanism::evaluate_all(const std::vector<PartMotion>& parts, Vector& h, JointDerivative& G) const {
  if (level_ == Level::acceleration) {
    joints_.acceleration(parts, start_, advance_, given_, h, G);
    return;
  }
  if (level_ == Level::configuration) {
    joints_.configuration(parts, Along::columns, given_, h, G);
    return;
  }
  std::vector<PartMotion> ends(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    ends[p].value = sum_of(end_weight_, parts[p].value, rest_[p]);
    for (const auto& column : parts[p].columns) ends[p].columns.push_back(sum_of(end_weight_, column, {}));
  }
  joints_.configuration(ends, Along::columns, given_, h, G);
}

// From h at the accepted state to 0, at whatever level the equations are.
void Mechanism::set_prescribed_fraction(double fraction) {
  if (violation_.size() == 0) return;
  solution_ = {};
  for (const auto& part : parts_) part->set_prescribed_fraction(fraction);
  lag_ = 1.0 - fraction;
}

// With the forces phi on the parts' unknowns and V = N - A (G_W A)^-1 G_W N, A = D G_ref^T: phi^T dV = -lambda^T dG_W
// V, lambda = (G_W A)^-T A^T phi.
std::vector<double> Mechanism::curvature(std::span<const double> unknowns, Vec f) const {
  const Solution& solution = at(unknowns);
  const auto all = static_cast<Eigen::Index>(first_.back());
  Matrix of_parts = Matrix::Zero(all, all);
  Vector phi = Vector::Zero(all);
  std::vector<std::vector<BodyMotion<double>>> bends;
  const ConstArrayView forces(f);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto first = static_cast<Eigen::Index>(first_[p]);
    const auto xi = of_part(solution.xi, p);
    const auto n = static_cast<Eigen::Index>(xi.size());
    const MotionForce force = parts_[p]->force_on_motion(forces.span());
    bends.push_back(parts_[p]->bends(xi, solution.parts[p].columns));
    for (Eigen::Index k = 0; k < n; ++k) {
      phi[first + k] = force.along(solution.parts[p].test_columns[static_cast<std::size_t>(k)]);
      for (Eigen::Index l = 0; l < n; ++l) {
        of_parts(first + k, first + l) = force.along(bends[p][static_cast<std::size_t>(k * n + l)]);
      }
    }
  }
  Matrix result = solution.test_columns.transpose() * of_parts * solution.columns;
  if (!joints_.empty()) {
    const Vector lambda = solution.test.solve_transposed(G_ref_ * Vector(weights_.cwiseProduct(phi)));
    const Matrix of_joints = joints_.curvature(solution.parts, bends, given_, lambda);
    result -= solution.test_columns.transpose() * of_joints * solution.columns;
  }
  std::vector<double> rows;
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    for (Eigen::Index l = 0; l < result.cols(); ++l) rows.push_back(result(k, l));
  }
  return rows;
}

void Mechanism::refreeze(std::span<const double> unknowns, Vec r) {
  if (r == nullptr) return bearings_.release();
  const Solution& solution = at(unknowns);
  std::vector<double> forces;
  {
    const ConstArrayView gradient(r);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const MotionForce force = parts_[p]->force_on_motion(gradient.span());
      for (const auto& column : solution.parts[p].test_columns) forces.push_back(force.along(column));
    }
  }
  sum_in_place(comm_, forces);
  const Eigen::Map<const Vector> phi(forces.data(), static_cast<Eigen::Index>(forces.size()));
  if (!phi.allFinite()) return bearings_.release();  // far from equilibrium
  bearings_.measure(solution.parts, joints_, given_, phi);
}

// At the step's end: the forces of the joints balance those on the unknowns of the parts, G^T lambda = phi.
std::vector<JointReaction> Mechanism::reactions(Vec r, Vec q, std::span<const Vector3<double>> points) const {
  std::vector<RigidPart::RigidState> at;
  for (const auto& part : parts_) at.push_back(part->state(q, q));
  const std::vector<PartMotion> motions_now = motions(at);
  Vector g;
  JointDerivative G;
  joints_.configuration(motions_now, Along::columns, given_, g, G);
  std::vector<double> forces(first_.back(), 0.0);
  {
    const ConstArrayView gradient(r);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const MotionForce force = parts_[p]->force_on_motion(gradient.span());
      for (std::size_t k = 0; k < motions_now[p].columns.size(); ++k) {
        forces[first_[p] + k] = force.along(motions_now[p].columns[k]);
      }
    }
  }
  sum_in_place(comm_, forces);
  const Eigen::Map<const Vector> phi(forces.data(), static_cast<Eigen::Index>(forces.size()));
  const Vector lambda = G.factors(Vector::Ones(G.cols()), G).solve(G * Vector(phi));
  return joints_.reactions(motions_now, given_, lambda, points);
}

}  // namespace pliant
