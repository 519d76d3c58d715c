/// A body with supports and loads, and its solver: what the tests of the solver solve.
#pragma once

#include "energy/constraint/prescribed.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"
#include "solver/newton.hpp"
#include "time/stepper.hpp"

#include <map>
#include <optional>

namespace pliant::test {

/// Displacements of the nodes in a region.
struct Support {
  Region region;
  std::array<std::optional<Expression>, 3> displacement;
};

using TermsOf = std::function<std::vector<std::unique_ptr<EnergyTerm>>(const Solid&)>;

struct ProblemSpec {
  int order = 1;
  ElasticLawSpec law;
  std::vector<Support> supports;
  TermsOf loads = [](const Solid&) { return std::vector<std::unique_ptr<EnergyTerm>>(); };
  std::optional<double> density;  ///< none: static [kg/m^3]
  std::optional<int> degree;      ///< of the quadrature; none: as the program chooses
  NewtonOptions newton;
  LinearKind linear = LinearKind::cholesky;
};

/// Nodal forces -dU/dq that do not depend on q; a term as one outside the library would be.
class NodalForces final : public EnergyTerm {
 public:
  NodalForces(const NodeLayout& layout, std::vector<double> forces)
      : size_(3 * layout.num_owned_nodes), forces_(std::move(forces)) {}
  std::string_view name() const override { return "nodal forces"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage& stage, std::span<const double> q) const override {
    double work = 0.0;
    for (PetscInt i = 0; i < size_; ++i) work += forces_[i] * (q[i] - stage.q0[i]);
    return -stage.load_factor * work;
  }
  void add_gradient(const LocalStage& stage, std::span<const double>, std::span<double> r) const override {
    for (PetscInt i = 0; i < size_; ++i) r[i] -= stage.load_factor * forces_[i];
  }
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter&, Projection) const override {}

 private:
  PetscInt size_;
  std::vector<double> forces_;
};

class Problem {
 public:
  Problem(MPI_Comm comm, const std::string& file, const ProblemSpec& spec)
      : solid_(comm, file, spec.order, spec.degree.value_or(elastic_quadrature_degree(spec.law.traits(), spec.order))),
        elastic_(solid_.elastic(spec.law)),
        inertia_(spec.density ? solid_.inertia(*spec.density, Mass::consistent) : nullptr),
        more_(spec.loads(solid_)),
        prescribed_(solid_.layout(), parts(spec), 1.0),
        potential_(solid_.layout(), solid_.pattern(), terms(), prescribed_.flags()),
        solver_(potential_, spec.newton, spec.linear) {}

  const Solid& solid() const { return solid_; }
  const ElasticTerm& elastic() const { return *elastic_; }
  IncrementalPotential& potential() { return potential_; }
  const SolverStatistics& statistics() const { return solver_.statistics(); }
  std::optional<FailedStage> examine() { return solver_.examine(); }
  PrescribedMotion motion() const { return prescribed_.motion(); }
  /// What integrators ask of it.
  System system() {
    return {.solve = [this](const StagePoint& stage, Vec q) { return solver_.solve(stage, q); }, .motion = motion()};
  }

  /// One stage from q0 at velocity v0; the solution is left in `q`.
  StageReport solve(double time, double dt, const Handle<Vec>& q0, const Handle<Vec>& v0, const Handle<Vec>& q,
                    double load_factor = 1.0) {
    StagePoint stage{time, dt, q0.get(), v0.get(), load_factor};
    check(VecCopy(q0.get(), q.get()));
    prescribed_.motion().start_stage(stage, q.get());
    return solver_.solve(stage, q.get());
  }

  /// The equilibrium from the state of rest, in `steps` equal parts of the loads and prescribed displacements. Its
  /// report is that of the last part.
  StageReport solve_static(const Handle<Vec>& q, int steps = 1) {
    const auto v0 = solid_.vector(at_rest);
    StageReport report;
    for (int s = 1; s <= steps && report.outcome == StageOutcome::converged; ++s) {
      const auto q0 = moved(q.get(), 0.0, q.get());
      report = solve(1.0, 1.0, q0, v0, q, static_cast<double>(s) / steps);
    }
    return report;
  }

  double strain_energy(Vec q) { return sum(solid_.layout().comm, elastic_->energy(local_values(q), {})); }

  /// What holds the supports: gradient at q where it is prescribed.
  Handle<Vec> reactions(Vec q) {
    Handle<Vec> r = potential_.make_vector();
    potential_.gradient_with_reactions(q, r.get());
    return r;
  }

 private:
  std::vector<PrescribedPart> parts(const ProblemSpec& spec) const {
    std::vector<PrescribedPart> result;
    for (const auto& support : spec.supports) {
      result.push_back({nodes_in_region(solid_.layout(), support.region), support.displacement});
    }
    return result;
  }
  std::vector<const EnergyTerm*> terms() const {
    std::vector<const EnergyTerm*> result{elastic_.get()};
    if (inertia_) result.push_back(inertia_.get());
    for (const auto& term : more_) result.push_back(term.get());
    return result;
  }

  Solid solid_;
  std::unique_ptr<ElasticTerm> elastic_;
  std::unique_ptr<Inertia> inertia_;
  std::vector<std::unique_ptr<EnergyTerm>> more_;
  PrescribedDisplacement prescribed_;
  IncrementalPotential potential_;
  NewtonSolver solver_;
};

/// The face of the unit cube where coordinate `axis` is `value`.
inline Region face(int axis, double value) {
  return [=](const Point& x) { return std::abs(x[axis] - value) < 1e-9; };
}

inline bool on_the_surface(const Point& x) {
  return std::any_of(x.begin(), x.end(), [](double c) { return c < 1e-9 || c > 1.0 - 1e-9; });
}

inline std::array<std::optional<Expression>, 3> fixed() {
  return {Expression(0.0), Expression(0.0), Expression(0.0)};
}

/// Rollers on the three faces through the origin.
inline std::vector<Support> rollers() {
  std::vector<Support> supports(3);
  for (int axis = 0; axis < 3; ++axis) {
    supports[axis].region = face(axis, 0.0);
    supports[axis].displacement[axis] = Expression(0.0);
  }
  return supports;
}

/// The largest deviation of q from the field at owned nodes, over all ranks.
inline double deviation(const Solid& solid, Vec q, const Field& field) {
  const ConstArrayView u(q);
  double worst = 0.0;
  for (PetscInt a = 0; a < solid.layout().num_owned_nodes; ++a) {
    const Point expected = field(solid.layout().position(a));
    for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(u[3 * a + i] - expected[i]));
  }
  return maximum(solid.layout().comm, worst);
}

/// The field of a solution by place, to compare with one on other ranks; from a problem on MPI_COMM_SELF.
inline Field by_place(const Solid& whole, Vec q) {
  std::map<Key, Point> values;
  const ConstArrayView u(q);
  for (PetscInt a = 0; a < whole.layout().num_owned_nodes; ++a) {
    values[key_of(whole.layout().position(a))] = {u[3 * a], u[3 * a + 1], u[3 * a + 2]};
  }
  return [values](const Point& x) { return values.at(key_of(x)); };
}

}  // namespace pliant::test
