/// A small body with cells, from which tests make energy terms; and vectors, stages and norms to test them with.
#pragma once

#include "energy/equation/incremental_potential.hpp"
#include "energy/load/cavity.hpp"
#include "energy/load/foundation.hpp"
#include "energy/load/load.hpp"
#include "energy/load/pressure.hpp"
#include "energy/shell/membrane.hpp"
#include "energy/volume/active_stress.hpp"
#include "energy/volume/elastic.hpp"
#include "energy/volume/inertia.hpp"
#include "energy/volume/mass_damping.hpp"
#include "energy/volume/mean_dilatation.hpp"
#include "energy/volume/mixed.hpp"
#include "energy/volume/prony.hpp"
#include "energy/volume/viscous.hpp"
#include "fem/body.hpp"
#include "material/registry.hpp"
#include "material/viscosity_registry.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

namespace pliant::test {

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
  Solid(MPI_Comm comm, const std::string& file, int order, int degree);
  Solid(const Solid&) = delete;
  Solid& operator=(const Solid&) = delete;

  const Mesh& mesh() const { return body_.mesh; }
  const NodeLayout& layout() const { return body_.layout; }
  const BlockPattern& pattern() const { return body_.pattern; }
  const std::variant<CellGroups<1>, CellGroups<2>>& groups() const { return groups_; }

  std::unique_ptr<ElasticTerm> elastic(const ElasticLawSpec& law, Dilatation dilatation = Dilatation::pointwise,
                                       FreeShape shape = {}) const;
  /// With the pressures of `field` (pressure_field).
  std::unique_ptr<MixedTerm> mixed(MixedLaw law, const PressureField& field, FreeShape shape = {}) const;
  /// The pressures of the body, all zero. Collective.
  std::unique_ptr<PressureField> pressure_field() const;
  std::unique_ptr<EnergyTerm> viscous(const ViscosityVariant& law,
                                      std::shared_ptr<const FreeExpansion> expansion = nullptr) const;
  std::unique_ptr<EnergyTerm> prony(const std::vector<Prony>& branches, std::string_view law,
                                    double youngs_modulus = prony_modulus, double poissons_ratio = 0.3) const;
  std::unique_ptr<EnergyTerm> prony(const std::vector<Prony>& branches, const ElasticLawSpec& law,
                                    std::shared_ptr<const FreeExpansion> expansion = nullptr) const;
  /// alpha rho [kg/(s m^3)].
  std::unique_ptr<MassDamping> mass_damping(double density, Mass mass) const;
  /// An amount of contraction along fibres that turn from place to place, or lie across all axes.
  std::shared_ptr<const Activation> activation(const Expression& amount, FibreField::Kind kind) const;
  std::unique_ptr<EnergyTerm> active_stress(const Expression& tension, FibreField::Kind kind) const;
  std::shared_ptr<const FreeExpansion> expansion(const Expression& stretch) const;
  std::unique_ptr<Inertia> inertia(double density, Mass mass) const;
  /// A force per mass on the whole body [N/kg].
  std::unique_ptr<DeadLoad> gravity(double density, const std::array<Expression, 3>& value) const;
  /// A force per area on the group "tip" [Pa].
  std::unique_ptr<DeadLoad> traction(const std::array<Expression, 3>& value) const;
  /// A force per length on the group "edge" [N/m].
  std::unique_ptr<DeadLoad> line_force(const std::array<Expression, 3>& value) const;
  /// Springs and dashpots on the group "tip" [N/m^3, N s/m^3].
  std::unique_ptr<Foundation> foundation(const FoundationStiffness& stiffness, FoundationDirection direction) const;
  /// A stretched layer with damping on the whole surface.
  MembraneTerms membrane(const ElasticLawSpec& law) const;
  /// A follower pressure on the group "tip" [Pa].
  std::unique_ptr<FollowerPressure> pressure(const Expression& value) const;

  /// The surroundings of the body as a cavity.
  std::unique_ptr<Cavity> cavity_around(const CavityContent& content) const;

  std::vector<char> nothing_prescribed() const;

  /// The field at the nodes, ghosts included. Collective.
  Handle<Vec> vector(const Field& field) const;

 private:
  Body body_;
  std::variant<CellGroups<1>, CellGroups<2>> groups_;
};

/// Local copies of vectors, as the terms see them.
std::vector<double> local_values(Vec v);

double norm(Vec v);

double dot(Vec a, Vec b);

/// |a - b|.
double distance(Vec a, Vec b);

/// a + s b, with ghosts.
Handle<Vec> moved(Vec a, double s, Vec b);

/// Net force of nodal forces, and their moment about the origin. Collective.
struct Resultant {
  Point force{}, moment{};
};

/// The nodes are displaced by u.
Resultant resultant(const Solid& solid, Vec forces, Vec u);

/// Strains of some tenths that differ from cell to cell; sound for barriers.
Point strained(const Point& x);

Field rough_field(double size, int seed);

Point at_rest(const Point&);

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
    point.z0 = point.accepted_z = z0.get();
  }
};

/// The least stiffness of the law at rest against shear along the axes.
double softest_shear(const ElasticLawSpec& law);

/// The laws of the registry with typical parameters, made as stiff at rest as E = 1000 Pa and nu = 0.3 are.
std::vector<ElasticLawSpec> every_law(double youngs_modulus = 1000.0, double poissons_ratio = 0.3);

/// One of them, without its volumetric part.
ElasticLawSpec without_volume(std::string_view name, double youngs_modulus = 1000.0, double poissons_ratio = 0.3);

/// The ways of an order of elements with a law.
std::vector<Dilatation> every_dilatation(const ElasticLawSpec& law, int order);

std::string name_of(Dilatation dilatation);

/// Name of a law without characters that GoogleTest refuses.
std::string name_of(const ElasticLawSpec& law);

/// The laws of viscosity in every form, of the size of `every_law` over some hundredths of a second; the bulk is as
/// viscous as the shape, so that nothing passes for the other.
std::vector<ViscosityVariant> every_viscosity();

/// Of a dashpot alone.
std::optional<StrainRate> rate_of(const ViscosityVariant& law);

std::string name_of(const ViscosityVariant& law);

/// Whether forces of the law are a gradient.
bool is_potential(const ViscosityVariant& law);

bool is_barrier(const ElasticLawSpec& law);
/// A law that knows no rotation.
bool is_linear(const ElasticLawSpec& law);

}  // namespace pliant::test
