/// Strain energy of a nearly or fully incompressible body with a pressure of its own, continuous and linear on
/// tetrahedra:
///
///     Pi(q, p) = int psi(F) + p g(J) - p^2/(2 kappa) dX - S(p)
///
/// psi is the law without its part of the volume kappa U(J), and U = g^2/2 (material/volumetric.hpp), so that p = kappa
/// g(J), in tension positive, in the weak sense. In an incompressible body 1/kappa = 0, and p holds the volume. Pi has
/// a saddle point instead of a minimum, so that a line search cannot use it (energy/equation/mixed_equation.hpp). In a
/// body that expands by s (energy/volume/expansion.hpp) the integrand is that of F/s, times s^3.
///
/// With quadratic displacements (Taylor & Hood) S = 0. With linear ones, whose pressures would oscillate, pressures pay
/// for what differs from their mean pm in each cell,
///
///     S(p) = int (p - pm)^2 / (2 mu) dX,   mu the shear modulus at rest,
///
/// which vanishes faster than the error of the element as the mesh is refined.
/// Sources: Brink & Stein, Comput. Mech. 19 (1996) 105-119; Taylor & Hood, Comput. Fluids 1 (1973) 73-100; Dohrmann &
/// Bochev, Int. J. Numer. Meth. Fluids 46 (2004) 183-201 (S, with the viscosity of a fluid in place of mu).
#pragma once

#include "energy/volume/elastic.hpp"
#include "fem/pressure_layout.hpp"
#include "material/volume_split.hpp"

#include <functional>
#include <memory>

namespace pliant {

/// The present pressures of the mixed terms, ghosts included [Pa]. The owner is the equation whose unknowns they are.
class PressureField {
 public:
  PressureField(PressureLayout layout, MPI_Comm comm)
      : layout_(std::move(layout)), values_(make_vector(layout_, comm)) {}
  const PressureLayout& layout() const { return layout_; }
  /// To be called after a change: update_ghosts.
  Vec values() const { return values_.get(); }

 private:
  PressureLayout layout_;
  Handle<Vec> values_;
};

/// Second derivatives of Pi that involve a pressure, for a batch of cells.
struct PressureCoupling {
  using Lanes = std::array<PetscInt, pack_size>;
  int num_lanes;
  std::span<const Lanes> nodes;                 ///< local nodes, of which the first four have pressures
  const std::array<Lanes, 4>& pressures;        ///< local pressures
  std::span<const std::array<Pack, 4>> B;       ///< d2Pi / dq dp, at [3 node + component][pressure] [m^2]
  const std::array<std::array<Pack, 4>, 4>& C;  ///< -d2Pi / dp dp [m^3/Pa]
  Pack::mask_type is_compressible;              ///< cells with 1/kappa > 0
};

/// The elastic term of one body at the present pressures.
class MixedTerm : public ElasticTerm {
 public:
  /// r_p += dPi/dp [m^3], rows of owned pressures complete.
  virtual void add_pressure_gradient(const Instant& at, std::span<const double> q, std::span<double> r) const = 0;
  /// m_p += int N_p dX [m^3], likewise.
  virtual void add_pressure_volumes(std::span<double> m) const = 0;
  /// Calls `visit` for each batch of cells; always in the same order.
  virtual void couple(const Instant& at, std::span<const double> q,
                      const std::function<void(const PressureCoupling&)>& visit) const = 0;
  /// Shear stiffness at rest [Pa].
  virtual double shear_modulus() const = 0;
};

/// A law in two parts, point by point.
struct MixedLaw {
  std::shared_ptr<const LawField> rest;  ///< with kappa = 0
  PerPoint<Pack> compliance;             ///< 1/kappa [1/Pa]
  VolumetricForm form;
};

/// The law of a uniform body.
MixedLaw make_mixed_law(const VolumeSplit& uniform);

/// The law of a body whose parameters vary in space: `at(local cell, reference position)`, all of the kind of `common`
/// and the form `form`.
template <int Order>
MixedLaw make_varying_mixed_law(const ElasticLawSpec& common, VolumetricForm form, const NodeLayout& layout,
                                const CellGroups<Order>& groups, int body,
                                const std::function<VolumeSplit(PetscInt, const std::array<double, 3>&)>& at);

/// `groups` and `pressures` must outlive the term.
template <int Order>
std::unique_ptr<MixedTerm> make_mixed_term(MixedLaw law, const CellGroups<Order>& groups, int body,
                                           PetscInt num_owned_nodes, const PressureField& pressures,
                                           FreeShape shape = {});

}  // namespace pliant
