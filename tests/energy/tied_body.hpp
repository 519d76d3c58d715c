/// A body with prescribed displacements and ties, for the tests of constraints.
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "energy/constraint/prescribed.hpp"
#include "energy/constraint/rigid_part.hpp"
#include "energy/constraint/surface_ties.hpp"
#include "energy/constraint/velocity_projection.hpp"
#include "energy/equation/constrained_equation.hpp"
#include "energy/equation/mixed_equation.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace pliant::test {

/// One constraint: prescribed components of `given` at the nodes of the region, or ties that refer to it.
struct TestConstraint {
  GivenDisplacement given;
  Region prescribed = nullptr;
  /// From the nodes of this rank; `source` is the constraint's number.
  std::function<std::vector<LinearConstraint>(const NodeLayout&, std::size_t source)> ties = nullptr;
  /// Nodes of a rigid part that turns freely, as far as `given.rigid` says.
  Region turning = nullptr;
  FreeRotation rotation = FreeRotation::about_all_axes;
  /// Dependent nodes of another kind.
  std::function<std::unique_ptr<DependentNodes>(const NodeLayout&)> dependent = nullptr;
};

struct TiedSpec {
  int order = 1;
  ElasticLawSpec law;
  double density = 0.0;  ///< 0: static [kg/m^3]
  std::vector<TestConstraint> constraints;
  std::optional<CavityContent> surroundings = std::nullopt;
  Rigidity rigidity = Rigidity::of_configurations;
  bool has_pressures = false;  ///< as unknowns
};

class TiedBody {
 public:
  TiedBody(MPI_Comm comm, const std::string& file, const TiedSpec& spec)
      : solid_(comm, file, spec.order, elastic_quadrature_degree(spec.law.traits(), spec.order)),
        elastic_(spec.has_pressures ? nullptr : solid_.elastic(spec.law)),
        pressures_(spec.has_pressures ? solid_.pressure_field() : nullptr),
        mixed_(spec.has_pressures ? solid_.mixed(make_mixed_law(*split_volume(spec.law)), *pressures_) : nullptr),
        inertia_(spec.density > 0.0 ? solid_.inertia(spec.density, Mass::consistent) : nullptr),
        surroundings_(spec.surroundings ? solid_.cavity_around(*spec.surroundings) : nullptr),
        prescribed_(layout(), parts(spec), HUGE_VAL),
        potential_(layout(), solid_.pattern(), terms(), prescribed_.flags()) {
    if (mixed_) {
      mixed_equation_.emplace(potential_, layout(), std::vector<const MixedTerm*>{mixed_.get()}, *pressures_);
    }
    std::vector<LinearConstraint> ties;
    std::vector<GivenDisplacement> given;
    for (std::size_t c = 0; c < spec.constraints.size(); ++c) {
      given.push_back(spec.constraints[c].given);
      if (!spec.constraints[c].ties) continue;
      for (auto& tie : spec.constraints[c].ties(layout(), c)) ties.push_back(std::move(tie));
    }
    ties = gathered(comm, ties);
    std::set<PetscInt> named;
    for (const auto& tie : ties) {
      for (const auto& e : tie.entries) named.insert(e.entry);
    }
    auto all = gathered(comm, prescribed_.constraints(layout(), named));
    const auto num_prescribed = static_cast<std::ptrdiff_t>(all.size());
    all.insert(all.end(), ties.begin(), ties.end());
    auto result = eliminate(all, given, std::array{0.0, 0.4, 1.0});
    EXPECT_TRUE(result.conflicts.empty());
    result.slaves.erase(result.slaves.begin(), result.slaves.begin() + num_prescribed);
    std::vector<std::unique_ptr<DependentNodes>> dependents;
    for (const auto& c : spec.constraints) {
      if (c.dependent) dependents.push_back(c.dependent(layout()));
      if (!c.turning) continue;
      const auto nodes = nodes_in_region(layout(), c.turning);
      EXPECT_EQ(why_not_rigid(layout(), nodes, *c.given.rigid, c.rotation), std::nullopt);
      dependents.push_back(std::make_unique<RigidPart>(layout(), nodes, *c.given.rigid, c.rotation));
      turning_.push_back({nodes, *c.given.rigid});
    }
    map_ = std::make_unique<ConstraintMap>(layout(), result.slaves, given, std::move(dependents));
    map_->set_rigidity(spec.rigidity);
    ties_ = std::move(all);
    given_ = std::move(given);
  }

  const Solid& solid() const { return solid_; }
  const NodeLayout& layout() const { return solid_.layout(); }
  IncrementalPotential& potential() { return potential_; }
  /// Of the body without its constraints.
  StageEquation& equation() { return mixed_equation_ ? static_cast<StageEquation&>(*mixed_equation_) : potential_; }
  ConstraintMap& map() { return *map_; }
  const Inertia& inertia() const { return *inertia_; }
  PrescribedMotion motion() const {
    PrescribedMotion motion = map_->motion(prescribed_.motion());
    if (!inertia_) return motion;
    return with_projected_velocities(std::move(motion), {layout(), *inertia_, prescribed_.flags(), map_.get()},
                                     EndVelocities::projected);
  }
  double strain_energy(Vec q) const { return sum(layout().comm, elastic().energy(local_values(q), {})); }

  std::size_t num_turning_parts() const { return turning_.size(); }
  /// The placement of the turning part of this number that is nearest to its nodes. Collective.
  Placement placement(std::size_t part, Vec q) const {
    return nearest_placement(layout(), turning_[part].nodes, turning_[part].motion.centre, q);
  }
  /// The largest distance of a node from it [m]. Collective.
  double distortion(std::size_t part, Vec q) const {
    const Placement at = placement(part, q);
    double worst = 0.0;
    const ConstArrayView u(q);
    for (const PetscInt a : turning_[part].nodes) {
      const auto rigid = at.displacement(layout().position(a) - turning_[part].motion.centre);
      for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(rigid[i] - u[3 * a + i]));
    }
    return maximum(layout().comm, worst);
  }

  /// The largest amount by which q misses a constraint at a time [m]. Collective.
  double violation(Vec q, double time) const {
    const Handle<Vec> copy = moved(q, 0.0, q);
    PetscInt first = 0, last = 0;
    check(VecGetOwnershipRange(copy.get(), &first, &last));
    std::vector<double> mine(2 * ties_.size(), 0.0);
    const ConstArrayView u(copy.get());
    for (std::size_t k = 0; k < ties_.size(); ++k) {
      for (const auto& [entry, coefficient] : ties_[k].entries) {
        if (entry >= first && entry < last) mine[k] += coefficient * u[entry - first];
      }
    }
    check_mpi(
        MPI_Allreduce(MPI_IN_PLACE, mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM, layout().comm));
    double worst = 0.0;
    for (std::size_t k = 0; k < ties_.size(); ++k) {
      for (const auto& g : ties_[k].given) mine[k] -= g.weight * given_[g.source](g.component, g.X, time);
      worst = std::max(worst, std::abs(mine[k]));
    }
    return worst;
  }

 private:
  const ElasticTerm& elastic() const { return mixed_ ? static_cast<const ElasticTerm&>(*mixed_) : *elastic_; }
  std::vector<PrescribedPart> parts(const TiedSpec& spec) const {
    std::vector<PrescribedPart> result;
    for (const auto& c : spec.constraints) {
      result.push_back({c.prescribed ? nodes_in_region(layout(), c.prescribed) : std::vector<PetscInt>(), c.given});
    }
    return result;
  }
  std::vector<const EnergyTerm*> terms() const {
    std::vector<const EnergyTerm*> result{&elastic()};
    if (inertia_) result.push_back(inertia_.get());
    if (surroundings_) result.push_back(surroundings_.get());
    return result;
  }

  Solid solid_;
  // One of the two, the second with pressures.
  std::unique_ptr<ElasticTerm> elastic_;
  std::unique_ptr<PressureField> pressures_;
  std::unique_ptr<MixedTerm> mixed_;
  std::unique_ptr<Inertia> inertia_;
  std::unique_ptr<Cavity> surroundings_;
  PrescribedDisplacement prescribed_;
  IncrementalPotential potential_;
  std::optional<MixedEquation> mixed_equation_;
  std::vector<LinearConstraint> ties_;
  std::vector<GivenDisplacement> given_;
  std::unique_ptr<ConstraintMap> map_;
  struct TurningPart {
    std::vector<PetscInt> nodes;
    RigidMotion motion;
  };
  std::vector<TurningPart> turning_;
};

/// The first component of a given displacement alone.
inline GivenDisplacement scalar(const std::string& formula) {
  return {{Expression(formula), std::nullopt, std::nullopt}};
}

inline GivenDisplacement vector(const std::string& x, const std::string& y, const std::string& z) {
  return {{Expression(x), Expression(y), Expression(z)}};
}

/// direction . u = `formula` in the region.
inline TestConstraint slide(const Region& region, const Point& direction, const std::string& formula) {
  return {scalar(formula), nullptr, [=](const NodeLayout& layout, std::size_t source) {
            return ties_along(layout, nodes_in_region(layout, region), direction, source);
          }};
}

/// The face b follows the face a.
inline TestConstraint repeat(const Region& a, const Region& b, const GivenDisplacement& difference) {
  return {difference, nullptr, [=](const NodeLayout& layout, std::size_t source) {
            const auto pairs = match_periodic(layout, nodes_in_region(layout, a), nodes_in_region(layout, b));
            EXPECT_EQ(pairs.num_unmatched_a + pairs.num_unmatched_b, 0u);
            return rank(layout.comm) == 0 ? periodic(pairs, difference, source) : std::vector<LinearConstraint>();
          }};
}

inline MeanTerm mean(const NodeLayout& layout, const Region& region, int component, double coefficient) {
  return {nodes_in_region(layout, region), component, coefficient};
}

/// The nodes of the region turn as given and are else as free as that says.
inline TestConstraint grip(const Region& region, const RigidMotion& motion) {
  const GivenDisplacement given{{}, motion};
  return {given, region, [=](const NodeLayout& layout, std::size_t source) {
            return translated_together(layout, nodes_in_region(layout, region), given, source);
          }};
}

/// The nodes of the region are rigid and turn freely; `motion` gives the translation, and a hinge's axis.
inline TestConstraint platen(const Region& region, const RigidMotion& motion, FreeRotation rotation) {
  TestConstraint result{{{}, motion}};
  result.turning = region;
  result.rotation = rotation;
  return result;
}

}  // namespace pliant::test
