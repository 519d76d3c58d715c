/// A small body with cells, from which tests make energy terms; and vectors, stages and norms to test them with.
#pragma once

#include "energy/active_stress.hpp"
#include "energy/cavity.hpp"
#include "energy/elastic.hpp"
#include "energy/foundation.hpp"
#include "energy/incremental_potential.hpp"
#include "energy/inertia.hpp"
#include "energy/load.hpp"
#include "energy/mass_damping.hpp"
#include "energy/mean_dilatation.hpp"
#include "energy/pressure.hpp"
#include "energy/prony.hpp"
#include "energy/viscous.hpp"
#include "fem/body.hpp"
#include "material/registry.hpp"
#include "material/viscosity_registry.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

namespace pliant::testing {

using Field = std::function<Point(const Point&)>;

/// Of what is proportional to the elastic stiffness [Pa].
inline constexpr IsotropicTensor<double> stiffness_at_rest{400.0, 700.0};

/// Young's modulus of the laws whose stress branches have, unless said otherwise [Pa].
inline constexpr double prony_modulus = 1000.0;

/// Where a change of volume is resisted.
enum class Dilatation { pointwise, mean };

/// A body and its cells for the quadrature of a law.
class Solid {
 public:
  Solid(MPI_Comm comm, const std::string& file, int order, int degree) : body_(comm, file, order) {
    const std::vector<int> one_body(static_cast<std::size_t>(layout().num_local_cells), 0);
    if (order == 1) {
      groups_ = make_cell_groups<1>(layout(), pattern(), one_body, {degree});
    } else {
      groups_ = make_cell_groups<2>(layout(), pattern(), one_body, {degree});
    }
  }
  Solid(const Solid&) = delete;
  Solid& operator=(const Solid&) = delete;

  const Mesh& mesh() const { return body_.mesh; }
  const NodeLayout& layout() const { return body_.layout; }
  const BlockPattern& pattern() const { return body_.pattern; }
  const std::variant<CellGroups<1>, CellGroups<2>>& groups() const { return groups_; }

  std::unique_ptr<ElasticTerm> elastic(const ElasticLawSpec& law, Dilatation dilatation = Dilatation::pointwise) const {
    if (dilatation == Dilatation::mean) {
      return make_mean_dilatation_term(make_law_field(law), std::get<1>(groups_), 0, layout().num_owned_nodes);
    }
    if (layout().order == 1) return make_elastic_term<1>(law, std::get<0>(groups_), 0, layout().num_owned_nodes);
    return make_elastic_term<2>(law, std::get<1>(groups_), 0, layout().num_owned_nodes);
  }
  std::unique_ptr<EnergyTerm> viscous(const ViscosityVariant& law) const {
    const auto elastic = make_law_field(
        make_law("linear", {{"shear_modulus", stiffness_at_rest.shear}, {"bulk_modulus", stiffness_at_rest.bulk}}));
    const PetscInt num_owned = layout().num_owned_nodes;
    if (layout().order == 1) return make_viscous_term<1>(law, *elastic, std::get<0>(groups_), 0, num_owned);
    return make_viscous_term<2>(law, *elastic, std::get<1>(groups_), 0, num_owned);
  }
  std::unique_ptr<EnergyTerm> prony(const std::vector<Prony>& branches, std::string_view law,
                                    double youngs_modulus = prony_modulus, double poissons_ratio = 0.3) const {
    std::shared_ptr<const LawField> elastic = make_law_field(make_law(law, youngs_modulus, poissons_ratio));
    const PetscInt num_owned = layout().num_owned_nodes;
    if (layout().order == 1) return make_prony_term<1>(branches, elastic, std::get<0>(groups_), 0, num_owned);
    return make_prony_term<2>(branches, elastic, std::get<1>(groups_), 0, num_owned);
  }
  /// alpha rho [kg/(s m^3)].
  std::unique_ptr<MassDamping> mass_damping(double density, Mass mass) const {
    if (layout().order == 1) {
      return std::make_unique<MassDamping>(
          make_mass_matrix<1>(layout(), pattern(), std::get<0>(groups_), {density}, mass));
    }
    return std::make_unique<MassDamping>(
        make_mass_matrix<2>(layout(), pattern(), std::get<1>(groups_), {density}, mass));
  }
  /// An amount of contraction along fibres that turn from place to place, or lie across all axes.
  std::shared_ptr<const Activation> activation(const Expression& amount, FibreField::Kind kind) const {
    const FibreField fibres{[kind](PetscInt, const Point& X) -> Point {
                              if (kind == FibreField::Kind::parallel) return {2.0 / 7, 3.0 / 7, 6.0 / 7};
                              return {std::cos(X[0] + X[2]), std::sin(X[0] + X[2]) * 0.6, std::sin(X[0] + X[2]) * 0.8};
                            },
                            kind};
    return std::visit(
        [&]<int Order>(const CellGroups<Order>& groups) {
          return std::make_shared<const Activation>(make_activation<Order>(amount, fibres, layout(), groups, 0));
        },
        groups_);
  }
  std::unique_ptr<EnergyTerm> active_stress(const Expression& tension, FibreField::Kind kind) const {
    return std::visit(
        [&]<int Order>(const CellGroups<Order>& groups) {
          return make_active_stress_term<Order>(activation(tension, kind), groups, 0, layout().num_owned_nodes);
        },
        groups_);
  }
  /// The law under active strain.
  std::unique_ptr<ElasticTerm> shortened(const ElasticLawSpec& law, const Expression& shortening,
                                         FibreField::Kind kind) const {
    return std::visit(
        [&]<int Order>(const CellGroups<Order>& groups) {
          return make_elastic_term<Order>(make_law_field(law), groups, 0, layout().num_owned_nodes,
                                          activation(shortening, kind));
        },
        groups_);
  }
  std::unique_ptr<Inertia> inertia(double density, Mass mass) const {
    if (layout().order == 1) return make_inertia<1>(layout(), pattern(), std::get<0>(groups_), {density}, mass);
    return make_inertia<2>(layout(), pattern(), std::get<1>(groups_), {density}, mass);
  }
  /// A force per mass on the whole body [N/kg].
  std::unique_ptr<DeadLoad> gravity(double density, const std::array<Expression, 3>& value) const {
    const std::vector<double> densities(static_cast<std::size_t>(layout().num_local_cells), density);
    return std::make_unique<DeadLoad>(layout(), cell_samples(layout(), densities, variation_of(value)), value);
  }
  /// A force per area on the group "tip" [Pa].
  std::unique_ptr<DeadLoad> traction(const std::array<Expression, 3>& value) const {
    const auto facets = facets_of_group(mesh(), layout(), group_named(mesh(), "tip"));
    return std::make_unique<DeadLoad>(layout(), facet_samples(layout(), facets, variation_of(value)), value);
  }
  /// A force per length on the group "edge" [N/m].
  std::unique_ptr<DeadLoad> line_force(const std::array<Expression, 3>& value) const {
    const auto edges = edges_of_group(mesh(), layout(), group_named(mesh(), "edge"));
    return std::make_unique<DeadLoad>(layout(), edge_samples(layout(), edges, variation_of(value)), value);
  }
  /// Springs and dashpots on the group "tip" [N/m^3, N s/m^3].
  std::unique_ptr<Foundation> foundation(const FoundationStiffness& stiffness, FoundationDirection direction) const {
    const auto facets = facets_of_group(mesh(), layout(), group_named(mesh(), "tip"));
    return std::make_unique<Foundation>(surface_foundation(layout(), pattern(), facets, direction), stiffness);
  }
  /// A follower pressure on the group "tip" [Pa].
  std::unique_ptr<FollowerPressure> pressure(const Expression& value) const {
    auto facets = facets_of_group(mesh(), layout(), group_named(mesh(), "tip"));
    return std::make_unique<FollowerPressure>(layout(), pattern(), std::move(facets), value, Rim::free);
  }

  /// The surroundings of the body as a cavity.
  std::unique_ptr<Cavity> cavity_around(const CavityContent& content) const {
    auto facets = surface_facets(mesh(), layout(), [](const Point&) { return true; });
    return std::make_unique<Cavity>(WettedSurface(layout(), pattern(), std::move(facets), 0), content);
  }

  std::vector<char> nothing_prescribed() const {
    return std::vector<char>(3 * static_cast<std::size_t>(layout().num_local_nodes), 0);
  }

  /// The field at the nodes, ghosts included. Collective.
  Handle<Vec> vector(const Field& field) const {
    Handle<Vec> v = make_vector(layout());
    {
      const ArrayView values(v.get());
      for (PetscInt a = 0; a < layout().num_owned_nodes; ++a) {
        const Point value = field(layout().position(a));
        for (int i = 0; i < 3; ++i) values[3 * a + i] = value[i];
      }
    }
    update_ghosts(v.get());
    return v;
  }

 private:
  Body body_;
  std::variant<CellGroups<1>, CellGroups<2>> groups_;
};

/// Local copies of vectors, as the terms see them.
inline std::vector<double> local_values(Vec v) {
  update_ghosts(v);
  const ConstGhostedView view(v);
  return {view.span().begin(), view.span().end()};
}

inline double norm(Vec v) {
  PetscReal result = 0.0;
  check(VecNorm(v, NORM_2, &result));
  return result;
}

inline double dot(Vec a, Vec b) {
  PetscScalar result = 0.0;
  check(VecDot(a, b, &result));
  return result;
}

/// |a - b|.
inline double distance(Vec a, Vec b) {
  Handle<Vec> d;
  check(VecDuplicate(a, d.out()));
  check(VecWAXPY(d.get(), -1.0, b, a));
  return norm(d.get());
}

/// a + s b, with ghosts.
inline Handle<Vec> moved(Vec a, double s, Vec b) {
  Handle<Vec> c;
  check(VecDuplicate(a, c.out()));
  check(VecWAXPY(c.get(), s, b, a));
  update_ghosts(c.get());
  return c;
}

/// Net force of nodal forces, and their moment about the origin. Collective.
struct Resultant {
  Point force{}, moment{};
};

/// The nodes are displaced by u.
inline Resultant resultant(const Solid& solid, Vec forces, Vec u) {
  Resultant mine;
  {
    const ConstArrayView f(forces), displacement(u);
    for (PetscInt a = 0; a < solid.layout().num_owned_nodes; ++a) {
      Point x = solid.layout().position(a);
      for (int i = 0; i < 3; ++i) x[i] += displacement[3 * a + i];
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        mine.force[i] += f[3 * a + i];
        mine.moment[i] += x[j] * f[3 * a + k] - x[k] * f[3 * a + j];
      }
    }
  }
  const auto total = [&](Point& values) {
    for (double& value : values) value = sum(solid.layout().comm, value);
  };
  total(mine.force);
  total(mine.moment);
  return mine;
}

/// Strains of some tenths that differ from cell to cell; sound for barriers.
inline Point strained(const Point& x) {
  return {0.15 * x[0] + 0.1 * x[1] * x[1] + 0.01 * rough(x, 0, 0),
          -0.1 * x[1] + 0.12 * x[2] * x[0] + 0.01 * rough(x, 1, 0), 0.08 * x[2] - 0.1 * x[0] + 0.01 * rough(x, 2, 0)};
}

inline Field rough_field(double size, int seed) {
  return [=](const Point& x) {
    return Point{size * rough(x, 0, seed), size * rough(x, 1, seed), size * rough(x, 2, seed)};
  };
}

inline Point at_rest(const Point&) {
  return {0.0, 0.0, 0.0};
}

/// A stage with vectors of its own.
struct TestStage {
  Handle<Vec> q0, v0, z0;
  StagePoint point;
  TestStage(const Solid& solid, double time, double dt, const Field& start = at_rest, const Field& velocity = at_rest)
      : q0(solid.vector(start)), v0(solid.vector(velocity)), point{time, dt, q0.get(), v0.get(), 1.0} {}

  /// Internal variables as they are at the end of a stage as long as this one that moved the body from rest to `end`.
  void set_internal(const Solid& solid, IncrementalPotential& potential, const Field& end) {
    z0 = potential.make_internal();
    if (!z0) return;
    const Handle<Vec> rest = solid.vector(at_rest), zero = potential.make_internal();
    StagePoint earlier = point;
    earlier.q0 = earlier.v0 = rest.get();
    earlier.z0 = zero.get();
    potential.internal_variables().end_stage(earlier, solid.vector(end).get(), z0.get());
    point.z0 = z0.get();
  }
};

/// The least stiffness of the law at rest against shear along the axes.
inline double softest_shear(const ElasticLawSpec& law) {
  const Tangent<double> A = std::visit([](const auto& of) { return tangent(of, Tensor3<double>{}); }, instantiate(law));
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t p : {1u, 2u, 3u, 5u, 6u, 7u}) least = std::min(least, A[9 * p + p]);
  return least;
}

/// The laws of the registry with typical parameters, made as stiff at rest as E = 1000 Pa and nu = 0.3 are.
inline std::vector<ElasticLawSpec> every_law(double youngs_modulus = 1000.0, double poissons_ratio = 0.3) {
  const Lame wanted = lame(youngs_modulus, poissons_ratio);
  std::vector<ElasticLawSpec> laws;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    ElasticLawSpec law = typical_law(row);
    const double scale = wanted.mu / softest_shear(law);
    for (std::size_t p = 0; p < law.parameters.size(); ++p) {
      const auto& [name, unit, lower, upper, meaning, bound, typical, fallback, upper_bound] = law.info().parameters[p];
      if (unit == "Pa") law.parameters[p] *= scale;
      if (name == "lame_lambda") law.parameters[p] = wanted.lambda;
      if (name == "bulk_modulus") law.parameters[p] = bulk_modulus(wanted);
    }
    laws.push_back(law);
  }
  return laws;
}

/// The ways of an order of elements with a law.
inline std::vector<Dilatation> every_dilatation(const ElasticLawSpec& law, int order) {
  if (order == 1 || law.traits().constant_tangent) return {Dilatation::pointwise};
  return {Dilatation::pointwise, Dilatation::mean};
}

inline std::string name_of(Dilatation dilatation) {
  return dilatation == Dilatation::mean ? "MeanDilatation" : "";
}

/// Name of a law without characters that GoogleTest refuses.
inline std::string name_of(const ElasticLawSpec& law) {
  std::string name(law.info().name);
  std::erase(name, '-');
  return name;
}

/// The laws of viscosity in every form, of the size of `every_law` over some hundredths of a second; the bulk is as
/// viscous as the shape, so that nothing passes for the other.
inline std::vector<ViscosityVariant> every_viscosity() {
  std::vector<ViscosityVariant> laws;
  for (const auto& form : strain_rates()) laws.push_back(KelvinVoigt{20.0, 35.0, form.rate});
  laws.push_back(Maxwell{300.0, 500.0, 0.1});
  laws.push_back(StiffnessProportional{0.05, StrainRate::reconstructed});
  return laws;
}

/// Of a dashpot alone.
inline std::optional<StrainRate> rate_of(const ViscosityVariant& law) {
  if (const auto* kelvin_voigt = std::get_if<KelvinVoigt>(&law)) return kelvin_voigt->rate;
  if (const auto* proportional = std::get_if<StiffnessProportional>(&law)) return proportional->rate;
  return std::nullopt;
}

inline std::string name_of(const ViscosityVariant& law) {
  std::string name = std::visit([](const auto& of) { return std::string(of.name); }, law);
  std::erase(name, '-');
  if (const auto rate = rate_of(law)) name += strain_rates()[static_cast<std::size_t>(*rate)].name;
  return name;
}

/// Whether forces of the law are a gradient.
inline bool is_potential(const ViscosityVariant& law) {
  return rate_of(law) != StrainRate::exact;
}

inline bool is_barrier(const ElasticLawSpec& law) {
  return law.traits().is_barrier;
}
/// A law that knows no rotation.
inline bool is_linear(const ElasticLawSpec& law) {
  return law.traits().constant_tangent;
}

}  // namespace pliant::testing
