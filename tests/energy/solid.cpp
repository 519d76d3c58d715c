#include "energy/solid.hpp"

#include "material/volume_split.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace pliant::test {

Solid::Solid(MPI_Comm comm, const std::string& file, int order, int degree) : body_(comm, file, order) {
  const std::vector<int> one_body(static_cast<std::size_t>(layout().num_local_cells), 0);
  if (order == 1) {
    groups_ = make_cell_groups<1>(layout(), pattern(), one_body, {degree});
  } else {
    groups_ = make_cell_groups<2>(layout(), pattern(), one_body, {degree});
  }
}

std::unique_ptr<ElasticTerm> Solid::elastic(const ElasticLawSpec& law, Dilatation dilatation, FreeShape shape) const {
  if (dilatation == Dilatation::mean) {
    return make_mean_dilatation_term(make_law_field(law), std::get<1>(groups_), 0, layout().num_owned_nodes,
                                     std::move(shape));
  }
  return std::visit(
      [&]<int Order>(const CellGroups<Order>& groups) {
        return make_elastic_term<Order>(make_law_field(law), groups, 0, layout().num_owned_nodes, std::move(shape));
      },
      groups_);
}

std::unique_ptr<MixedTerm> Solid::mixed(MixedLaw law, const PressureField& field, FreeShape shape) const {
  return std::visit(
      [&]<int Order>(const CellGroups<Order>& groups) {
        return make_mixed_term<Order>(std::move(law), groups, 0, layout().num_owned_nodes, field, std::move(shape));
      },
      groups_);
}

std::unique_ptr<PressureField> Solid::pressure_field() const {
  const std::vector<int> one_body(static_cast<std::size_t>(layout().num_local_cells), 0);
  return std::make_unique<PressureField>(make_pressure_layout(layout(), one_body, 1), layout().comm);
}

std::unique_ptr<EnergyTerm> Solid::viscous(const ViscosityVariant& law,
                                           std::shared_ptr<const FreeExpansion> expansion) const {
  const auto elastic = make_law_field(
      make_law("linear", {{"shear_modulus", stiffness_at_rest.shear}, {"bulk_modulus", stiffness_at_rest.bulk}}));
  const PetscInt num_owned = layout().num_owned_nodes;
  if (layout().order == 1) return make_viscous_term<1>(law, *elastic, std::get<0>(groups_), 0, num_owned, expansion);
  return make_viscous_term<2>(law, *elastic, std::get<1>(groups_), 0, num_owned, expansion);
}

std::unique_ptr<EnergyTerm> Solid::prony(const std::vector<Prony>& branches, std::string_view law,
                                         double youngs_modulus, double poissons_ratio) const {
  return prony(branches, make_law(law, youngs_modulus, poissons_ratio));
}

std::unique_ptr<EnergyTerm> Solid::prony(const std::vector<Prony>& branches, const ElasticLawSpec& law,
                                         std::shared_ptr<const FreeExpansion> expansion) const {
  std::shared_ptr<const LawField> elastic = make_law_field(law);
  const PetscInt num_owned = layout().num_owned_nodes;
  if (layout().order == 1) return make_prony_term<1>(branches, elastic, std::get<0>(groups_), 0, num_owned, expansion);
  return make_prony_term<2>(branches, elastic, std::get<1>(groups_), 0, num_owned, expansion);
}

std::unique_ptr<MassDamping> Solid::mass_damping(double density, Mass mass) const {
  if (layout().order == 1) {
    return std::make_unique<MassDamping>(
        make_mass_matrix<1>(layout(), pattern(), std::get<0>(groups_), {density}, mass),
        make_cell_mass_products<1>(layout(), std::get<0>(groups_), {density}, mass));
  }
  return std::make_unique<MassDamping>(make_mass_matrix<2>(layout(), pattern(), std::get<1>(groups_), {density}, mass),
                                       make_cell_mass_products<2>(layout(), std::get<1>(groups_), {density}, mass));
}

std::shared_ptr<const Activation> Solid::activation(const Expression& amount, FibreField::Kind kind) const {
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

std::unique_ptr<EnergyTerm> Solid::active_stress(const Expression& tension, FibreField::Kind kind) const {
  return std::visit(
      [&]<int Order>(const CellGroups<Order>& groups) {
        return make_active_stress_term<Order>(activation(tension, kind), groups, 0, layout().num_owned_nodes);
      },
      groups_);
}

std::shared_ptr<const FreeExpansion> Solid::expansion(const Expression& stretch) const {
  return std::visit(
      [&]<int Order>(const CellGroups<Order>& groups) { return make_expansion<Order>(stretch, layout(), groups, 0); },
      groups_);
}

std::unique_ptr<Inertia> Solid::inertia(double density, Mass mass) const {
  if (layout().order == 1) return make_inertia<1>(layout(), pattern(), std::get<0>(groups_), {density}, mass);
  return make_inertia<2>(layout(), pattern(), std::get<1>(groups_), {density}, mass);
}

std::unique_ptr<DeadLoad> Solid::gravity(double density, const std::array<Expression, 3>& value) const {
  const std::vector<double> densities(static_cast<std::size_t>(layout().num_local_cells), density);
  return std::make_unique<DeadLoad>(layout(), cell_samples(layout(), densities, variation_of(value)), value);
}

MembraneTerms Solid::membrane(const ElasticLawSpec& law) const {
  const auto facets = surface_facets(mesh(), layout(), [](const Point&) { return true; });
  const LayerShape shape{0.1, {1.1, 0.95}, Point{0.3, 0.5, 0.8}};
  return make_membrane(layout(), pattern(), facets, shape, {law, {}, {0.02, 0.7, 0.4}});
}

std::unique_ptr<DeadLoad> Solid::traction(const std::array<Expression, 3>& value) const {
  const auto facets = facets_of_group(mesh(), layout(), group_named(mesh(), "tip"));
  return std::make_unique<DeadLoad>(layout(), facet_samples(layout(), facets, variation_of(value)), value);
}

std::unique_ptr<DeadLoad> Solid::line_force(const std::array<Expression, 3>& value) const {
  const auto edges = edges_of_group(mesh(), layout(), group_named(mesh(), "edge"));
  return std::make_unique<DeadLoad>(layout(), edge_samples(layout(), edges, variation_of(value)), value);
}

std::unique_ptr<Foundation> Solid::foundation(const FoundationStiffness& stiffness,
                                              FoundationDirection direction) const {
  const auto facets = facets_of_group(mesh(), layout(), group_named(mesh(), "tip"));
  return std::make_unique<Foundation>(surface_foundation(layout(), pattern(), facets, direction), stiffness);
}

std::unique_ptr<FollowerPressure> Solid::pressure(const Expression& value) const {
  auto facets = facets_of_group(mesh(), layout(), group_named(mesh(), "tip"));
  return std::make_unique<FollowerPressure>(layout(), pattern(), std::move(facets), value, Rim::free);
}

std::unique_ptr<Cavity> Solid::cavity_around(const CavityContent& content) const {
  auto facets = surface_facets(mesh(), layout(), [](const Point&) { return true; });
  return std::make_unique<Cavity>(WettedSurface(layout(), pattern(), std::move(facets), 0), content);
}

std::vector<char> Solid::nothing_prescribed() const {
  return std::vector<char>(3 * static_cast<std::size_t>(layout().num_local_nodes), 0);
}

Handle<Vec> Solid::vector(const Field& field) const {
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

std::vector<double> local_values(Vec v) {
  update_ghosts(v);
  const ConstGhostedView view(v);
  return {view.span().begin(), view.span().end()};
}

double norm(Vec v) {
  PetscReal result = 0.0;
  check(VecNorm(v, NORM_2, &result));
  return result;
}

double dot(Vec a, Vec b) {
  PetscScalar result = 0.0;
  check(VecDot(a, b, &result));
  return result;
}

double distance(Vec a, Vec b) {
  Handle<Vec> d;
  check(VecDuplicate(a, d.out()));
  check(VecWAXPY(d.get(), -1.0, b, a));
  return norm(d.get());
}

Handle<Vec> moved(Vec a, double s, Vec b) {
  Handle<Vec> c;
  check(VecDuplicate(a, c.out()));
  check(VecWAXPY(c.get(), s, b, a));
  update_ghosts(c.get());
  return c;
}

Resultant resultant(const Solid& solid, Vec forces, Vec u) {
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

Point strained(const Point& x) {
  return {0.15 * x[0] + 0.1 * x[1] * x[1] + 0.01 * rough(x, 0, 0),
          -0.1 * x[1] + 0.12 * x[2] * x[0] + 0.01 * rough(x, 1, 0), 0.08 * x[2] - 0.1 * x[0] + 0.01 * rough(x, 2, 0)};
}

Field rough_field(double size, int seed) {
  return [=](const Point& x) {
    return Point{size * rough(x, 0, seed), size * rough(x, 1, seed), size * rough(x, 2, seed)};
  };
}

Point at_rest(const Point&) {
  return {0.0, 0.0, 0.0};
}

double softest_shear(const ElasticLawSpec& law) {
  const Tangent<double> A = std::visit([](const auto& of) { return tangent(of, Tensor3<double>{}); }, instantiate(law));
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t p : {1u, 2u, 3u, 5u, 6u, 7u}) least = std::min(least, A[9 * p + p]);
  return least;
}

std::vector<ElasticLawSpec> every_law(double youngs_modulus, double poissons_ratio) {
  const Lame wanted = lame(youngs_modulus, poissons_ratio);
  std::vector<ElasticLawSpec> laws;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    ElasticLawSpec law = typical_law(row);
    const double scale = wanted.mu / softest_shear(law);
    for (std::size_t p = 0; p < law.parameters.size(); ++p) {
      const auto& [name, unit, lower, upper, meaning, bound, typical, fallback, upper_bound, with] =
          law.info().parameters[p];
      if (unit == "Pa") law.parameters[p] *= scale;
      if (name == "lame_lambda" || name == "lambda") law.parameters[p] = wanted.lambda;
      if (name == "bulk_modulus") law.parameters[p] = bulk_modulus(wanted);
    }
    laws.push_back(law);
  }
  return laws;
}

ElasticLawSpec without_volume(std::string_view name, double youngs_modulus, double poissons_ratio) {
  for (const auto& law : every_law(youngs_modulus, poissons_ratio)) {
    if (law.info().name == name) return split_volume(law).value().rest;
  }
  throw std::invalid_argument("there is no such law");
}

std::vector<Dilatation> every_dilatation(const ElasticLawSpec& law, int order) {
  if (order == 1 || law.traits().constant_tangent) return {Dilatation::pointwise};
  return {Dilatation::pointwise, Dilatation::mean};
}

std::string name_of(Dilatation dilatation) {
  return dilatation == Dilatation::mean ? "MeanDilatation" : "";
}

std::string name_of(const ElasticLawSpec& law) {
  std::string name(law.info().name);
  std::erase(name, '-');
  return name;
}

std::vector<ViscosityVariant> every_viscosity() {
  std::vector<ViscosityVariant> laws;
  for (const auto& form : strain_rates()) laws.push_back(WithStrainRate{KelvinVoigt{20.0, 35.0}, form.rate});
  laws.push_back(Maxwell{300.0, 500.0, 0.1});
  laws.push_back(WithStrainRate{StiffnessProportional{0.05}, StrainRate::reconstructed});
  return laws;
}

std::optional<StrainRate> rate_of(const ViscosityVariant& law) {
  if (const auto* kelvin_voigt = std::get_if<WithStrainRate<KelvinVoigt>>(&law)) return kelvin_voigt->rate;
  if (const auto* proportional = std::get_if<WithStrainRate<StiffnessProportional>>(&law)) return proportional->rate;
  return std::nullopt;
}

std::string name_of(const ViscosityVariant& law) {
  std::string name = std::visit([](const auto& of) { return std::string(of.name); }, law);
  std::erase(name, '-');
  if (const auto rate = rate_of(law)) name += strain_rates()[static_cast<std::size_t>(*rate)].name;
  return name;
}

bool is_potential(const ViscosityVariant& law) {
  return rate_of(law) != StrainRate::exact;
}

bool is_barrier(const ElasticLawSpec& law) {
  return law.traits().is_barrier;
}

bool is_linear(const ElasticLawSpec& law) {
  return law.traits().constant_tangent;
}

}  // namespace pliant::test
