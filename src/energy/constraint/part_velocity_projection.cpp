#include "energy/constraint/part_velocity_projection.hpp"

#include "energy/constraint/rigid_part.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/copy_of.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>
#include <eigen3/Eigen/QR>

namespace pliant {
namespace {

/// The most parts that others touch whose fields are kept.
constexpr std::size_t most_touched = 10;
/// Entries of fields below this part of the largest one are left out: they change no digit of a velocity.
constexpr double least_entry = 1e-17;
constexpr double relative_residual = 1e-14;
/// Inertia below this part of the largest one is none.
constexpr double without_inertia = 1e-13;

/// The twelve numbers of an affine motion about a part's centre.
template <class Motion>
Motion numbers_of(const BodyMotion<double>& motion) {
  Motion result;
  for (int i = 0; i < 3; ++i) {
    result[i] = motion.translation[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) result[3 * (1 + k) + i] = motion.gradient(i, k);
  }
  return result;
}

/// The four functions 1, r of a place r, from a part's centre.
std::array<double, 4> functions_at(const Vector3<double>& r) {
  return {1.0, r[0], r[1], r[2]};
}

double largest(Vec x) {
  PetscReal norm = 0.0;
  check(VecNorm(x, NORM_INFINITY, &norm));
  return norm;
}

}  // namespace

/// Forces on the soft nodes by each motion of a part, M_sd Phi, and what they do to them, Y. Without ties the three
/// components do not mix, and each vector holds all three at once: entry 3 a + i belongs to motion 3 k + i.
struct PartVelocityProjection::Touched {
  std::vector<Handle<Vec>> forces, solutions;
  bool holds_components = false;

  /// Force of motion m times the solution of motion n of another part: this rank's sum.
  static double product(const Touched& of_force, std::size_t m, const Touched& of_solution, std::size_t n) {
    const bool components = of_force.holds_components;
    if (components && m % 3 != n % 3) return 0.0;
    const ConstArrayView f(of_force.forces[components ? m / 3 : m].get());
    const ConstArrayView y(of_solution.solutions[components ? n / 3 : n].get());
    double sum = 0.0;
    const std::size_t stride = components ? 3 : 1;
    for (std::size_t e = components ? m % 3 : 0; e < f.span().size(); e += stride) sum += f.span()[e] * y.span()[e];
    return sum;
  }
};

std::unique_ptr<PartVelocityProjection> PartVelocityProjection::make(const ConstrainedMass& bodies) {
  std::unique_ptr<PartVelocityProjection> projection(new PartVelocityProjection(bodies));
  projection->find_parts();
  projection->measure(bodies);
  return projection->num_touched_ <= most_touched ? std::move(projection) : nullptr;
}

PartVelocityProjection::PartVelocityProjection(const ConstrainedMass& bodies)
    : layout_(bodies.layout), map_(*bodies.map), difference_(make_vector(bodies.layout)) {}

void PartVelocityProjection::find_parts() {
  for (std::size_t d = 0; d < map_.dependents().size(); ++d) {
    const auto of_dependent = map_.dependents()[d]->parts();
    for (std::size_t n = 0; n < of_dependent.size(); ++n) {
      Part& part = parts_.emplace_back();
      part.part = of_dependent[n];
      part.dependent = d;
      part.number = n;
      part.centre = part.part->motion_of(difference_.get()).centre;
    }
  }
}

void PartVelocityProjection::put_motion(const Part& part, std::size_t k, Vec v) const {
  check(VecZeroEntries(v));
  const ArrayView entries(v);
  for (const PetscInt a : part.part->nodes()) {
    const double value = functions_at(layout_.position(a) - part.centre)[k];
    for (PetscInt i = 0; i < 3; ++i) entries[3 * a + i] = value;
  }
}

void PartVelocityProjection::measure(const ConstrainedMass& bodies) {
  std::vector<char> is_excluded(bodies.prescribed.begin(), bodies.prescribed.begin() + 3 * layout_.num_owned_nodes);
  for (std::size_t i = 0; i < is_excluded.size(); ++i) is_excluded[i] = is_excluded[i] || map_.is_slave()[i] ? 1 : 0;
  for (const Part& part : parts_) {
    for (const PetscInt a : part.part->nodes()) std::fill_n(is_excluded.begin() + 3 * a, 3, 1);
  }
  ReducedMass mass(bodies, std::move(is_excluded));
  const Handle<Vec> motion = make_vector(layout_), force = make_vector(layout_);
  for (Part& part : parts_) {
    bool touches = false;
    for (std::size_t k = 0; k < num_affine; ++k) {
      put_motion(part, k, motion.get());
      mass.multiply(motion.get(), force.get());
      const ArrayView rows(force.get());
      for (const PetscInt a : part.part->nodes()) {
        const auto functions = functions_at(layout_.position(a) - part.centre);
        for (std::size_t l = 0; l < num_affine; ++l) {
          part.mass(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) += functions[l] * rows[3 * a];
        }
        for (PetscInt i = 0; i < 3; ++i) rows[3 * a + i] = 0.0;
      }
      touches = touches || std::ranges::any_of(rows.span(), [](double f) { return f != 0.0; });
    }
    sum_in_place(layout_.comm, std::span(part.mass.data(), num_affine * num_affine));
    if (any_rank(layout_.comm, touches)) part.place = num_touched_++;
  }
  if (num_touched_ > most_touched) return;
  const auto size = static_cast<Eigen::Index>(num_motions * num_touched_);
  touched_mass_ = Matrix::Zero(size, size);
  std::vector<Touched> touched;
  for (const Part& part : parts_) {
    if (part.place != alone) add_fields(mass, touched.emplace_back());
  }
  subtract_soft_mass(touched);
  std::vector<std::size_t> together;
  for (std::size_t d = 0; d < map_.dependents().size(); ++d) {
    const auto is_touched = [&](const Part& part) { return part.dependent == d && part.place != alone; };
    if (std::ranges::any_of(parts_, is_touched)) {
      together.push_back(d);
    } else {
      groups_.push_back({d});
    }
  }
  if (!together.empty()) groups_.push_back(std::move(together));
}

void PartVelocityProjection::add_fields(ReducedMass& mass, Touched& touched) {
  const std::size_t place = fields_.size() / num_motions;
  const auto& part = *std::ranges::find(parts_, place, &Part::place);
  touched.holds_components = !map_.has_ties();
  const std::size_t per_function = touched.holds_components ? 1 : 3;
  const Handle<Vec> motion = make_vector(layout_), force = make_vector(layout_), solution = make_vector(layout_);
  std::vector<Handle<Vec>> expanded;
  for (std::size_t n = 0; n < per_function * num_affine; ++n) {
    const std::size_t k = n / per_function;
    put_motion(part, k, motion.get());
    if (!touched.holds_components) {
      const ArrayView entries(motion.get());
      for (std::size_t e = 0; e < entries.span().size(); ++e) {
        if (e % 3 != n % 3) entries.span()[e] = 0.0;
      }
    }
    mass.multiply(motion.get(), force.get());
    // The mass between this part and others, of one component.
    if (touched.holds_components || n % 3 == 0) {
      const ConstArrayView rows(force.get());
      for (const Part& other : parts_) {
        if (other.place == alone) continue;
        for (const PetscInt a : other.part->nodes()) {
          const auto functions = functions_at(layout_.position(a) - other.centre);
          for (std::size_t l = 0; l < num_affine; ++l) {
            for (std::size_t i = 0; i < 3; ++i) {
              touched_mass_(static_cast<Eigen::Index>(num_motions * other.place + 3 * l + i),
                            static_cast<Eigen::Index>(num_motions * place + 3 * k + i)) += functions[l] * rows[3 * a];
            }
          }
        }
      }
    }
    mass.reduce(force.get(), motion.get());
    mass.solve(motion.get(), solution.get(), relative_residual, 0.0);
    touched.forces.push_back(copy_of(motion.get()));
    touched.solutions.push_back(copy_of(solution.get()));
    mass.expand(solution.get(), expanded.emplace_back(make_vector(layout_)).get());
  }
  for (std::size_t m = 0; m < num_motions; ++m) {
    Vec values = expanded[touched.holds_components ? m / 3 : m].get();
    const double least = least_entry * largest(values);
    const ConstArrayView entries(values);
    Field& field = fields_.emplace_back();
    for (std::size_t e = 0; e < entries.span().size(); ++e) {
      if (touched.holds_components && e % 3 != m % 3) continue;
      if (!(std::abs(entries.span()[e]) > least)) continue;
      field.entries.push_back(static_cast<PetscInt>(e));
      field.values.push_back(entries.span()[e]);
    }
  }
}

void PartVelocityProjection::subtract_soft_mass(const std::vector<Touched>& touched) {
  for (std::size_t p = 0; p < touched.size(); ++p) {
    for (std::size_t o = 0; o < touched.size(); ++o) {
      for (std::size_t m = 0; m < num_motions; ++m) {
        for (std::size_t n = 0; n < num_motions; ++n) {
          touched_mass_(static_cast<Eigen::Index>(num_motions * p + m),
                        static_cast<Eigen::Index>(num_motions * o + n)) -=
              Touched::product(touched[p], m, touched[o], n);
        }
      }
    }
  }
  sum_in_place(layout_.comm, std::span(touched_mass_.data(), static_cast<std::size_t>(touched_mass_.size())));
}

void PartVelocityProjection::solve(std::span<const std::size_t> dependents, const std::vector<Motion>& missing,
                                   std::vector<Motion>& changes) const {
  std::vector<Eigen::Index> first;
  Eigen::Index num_unknowns = 0;
  for (const std::size_t d : dependents) {
    first.push_back(num_unknowns);
    num_unknowns += static_cast<Eigen::Index>(map_.dependents()[d]->hosts().size());
  }
  if (num_unknowns == 0) return;
  std::vector<Matrix> columns(parts_.size());
  Matrix A = Matrix::Zero(num_unknowns, num_unknowns);
  Vector b = Vector::Zero(num_unknowns);
  Matrix of_touched = Matrix::Zero(touched_mass_.rows(), num_unknowns);
  Vector missing_of_touched = Vector::Zero(touched_mass_.rows());
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    const auto found = std::ranges::find(dependents, part.dependent);
    if (found == dependents.end()) continue;
    const auto motions = map_.dependents()[part.dependent]->allowed_velocities(part.number);
    Matrix& J = columns[p] = Matrix::Zero(num_motions, num_unknowns);
    const Eigen::Index start = first[static_cast<std::size_t>(found - dependents.begin())];
    for (std::size_t k = 0; k < motions.size(); ++k) {
      J.col(start + static_cast<Eigen::Index>(k)) = numbers_of<Motion>(motions[k]);
    }
    if (part.place != alone) {
      const auto place = static_cast<Eigen::Index>(num_motions * part.place);
      of_touched.middleRows(place, num_motions) = J;
      missing_of_touched.segment(place, num_motions) = missing[p];
      continue;
    }
    Eigen::Matrix<double, num_motions, num_motions> mass = Eigen::Matrix<double, num_motions, num_motions>::Zero();
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(num_affine); ++k) {
      for (Eigen::Index l = 0; l < static_cast<Eigen::Index>(num_affine); ++l) {
        for (Eigen::Index i = 0; i < 3; ++i) mass(3 * k + i, 3 * l + i) = part.mass(k, l);
      }
    }
    const Matrix weighted = mass * J;
    A += J.transpose() * weighted;
    b += weighted.transpose() * missing[p];
  }
  const Matrix weighted = touched_mass_ * of_touched;
  A += of_touched.transpose() * weighted;
  b += weighted.transpose() * missing_of_touched;
  const double heaviest = A.diagonal().maxCoeff();
  Vector scale = A.diagonal();
  for (double& s : scale) s = s > without_inertia * heaviest ? s : heaviest > 0.0 ? heaviest : 1.0;
  scale = scale.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix> scaled(scale.asDiagonal() * A * scale.asDiagonal());
  const double least = without_inertia * scaled.eigenvalues().maxCoeff();
  Vector inverse = scaled.eigenvalues();
  for (double& value : inverse) value = value > least ? 1.0 / value : 0.0;
  const Matrix modes = scale.asDiagonal() * scaled.eigenvectors();
  Vector w = modes * inverse.cwiseProduct(modes.transpose() * b);
  // What has no inertia, as points of reference in the mean, takes the velocities that are wanted.
  const Eigen::Index num_light = (inverse.array() == 0.0).count();
  if (num_light > 0) {
    const Matrix light = modes.leftCols(num_light);  // eigenvalues ascend
    Matrix squares = Matrix::Zero(num_light, num_light);
    Vector products = Vector::Zero(num_light);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      if (columns[p].size() == 0) continue;
      Motion weights = Motion::Constant(std::pow(parts_[p].part->size(), 2));
      weights.template head<3>().setOnes();
      const Matrix motions = columns[p] * light;
      squares += motions.transpose() * weights.asDiagonal() * motions;
      products += motions.transpose() * weights.asDiagonal() * (missing[p] - columns[p] * w);
    }
    w += light * squares.completeOrthogonalDecomposition().solve(products);
  }
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    if (columns[p].size() > 0) changes[p] = columns[p] * w;
  }
}

void PartVelocityProjection::put(const std::vector<Motion>& missing, const std::vector<Motion>& changes, Vec v) const {
  const ArrayView entries(v);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    for (const PetscInt a : part.part->nodes()) {
      const auto functions = functions_at(layout_.position(a) - part.centre);
      for (std::size_t k = 0; k < num_affine; ++k) {
        for (PetscInt i = 0; i < 3; ++i) {
          entries[3 * a + i] += functions[k] * changes[p][static_cast<Eigen::Index>(3 * k) + i];
        }
      }
    }
    if (part.place == alone) continue;
    const Motion rest = missing[p] - changes[p];
    for (std::size_t m = 0; m < num_motions; ++m) {
      const Field& field = fields_[num_motions * part.place + m];
      const double factor = rest[static_cast<Eigen::Index>(m)];
      for (std::size_t n = 0; n < field.entries.size(); ++n) entries[field.entries[n]] += factor * field.values[n];
    }
  }
}

void PartVelocityProjection::operator()(Vec q, Vec wanted, Vec v) {
  check(VecWAXPY(difference_.get(), -1.0, v, wanted));
  map_.keep_free_motion_of_dependents(difference_.get());
  if (largest(difference_.get()) == 0.0) return;
  map_.begin_end_of_step(q);
  std::vector<Motion> missing, changes(parts_.size(), Motion::Zero());
  for (const Part& part : parts_) missing.push_back(numbers_of<Motion>(part.part->motion_of(difference_.get())));
  for (const auto& group : groups_) solve(group, missing, changes);
  put(missing, changes, v);
}

}  // namespace pliant
