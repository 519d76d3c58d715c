/// Strain energy of a nearly or fully incompressible body with a pressure of its own: quadratic displacements, linear
/// continuous pressures (Taylor & Hood).
///
///     Pi(q, p) = int psi(F) + p g(J) - p^2/(2 kappa) dX
///
/// psi is the law without its part of the volume kappa U(J), and U = g^2/2 (material/volumetric.hpp), so that p = kappa
/// g(J), in tension positive, in the weak sense. In an incompressible body 1/kappa = 0, and p holds the volume. Pi has
/// a saddle point instead of a minimum, so that a line search cannot use it (energy/equation/mixed_equation.hpp).
/// Source: Brink & Stein, Comput. Mech. 19 (1996) 105-119; Taylor & Hood, Comput. Fluids 1 (1973) 73-100.
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
  const std::array<Lanes, 10>& nodes;            ///< local nodes
  const std::array<Lanes, 4>& pressures;         ///< local pressures
  const std::array<std::array<Pack, 4>, 30>& B;  ///< d2Pi / dq dp, at [3 node + component][pressure] [m^2]
  const std::array<std::array<Pack, 4>, 4>& C;   ///< -d2Pi / dp dp [m^3/Pa]
};

/// The elastic term of one body at the present pressures.
class MixedTerm : public ElasticTerm {
 public:
  /// r_p += dPi/dp [m^3], rows of owned pressures complete.
  virtual void add_pressure_gradient(std::span<const double> q, std::span<double> r) const = 0;
  /// m_p += int N_p dX [m^3], likewise.
  virtual void add_pressure_volumes(std::span<double> m) const = 0;
  /// Calls `visit` for each batch of cells; always in the same order.
  virtual void couple(std::span<const double> q, const std::function<void(const PressureCoupling&)>& visit) const = 0;
  /// Shear stiffness at rest [Pa].
  virtual double shear_modulus() const = 0;
};

/// `pressures` must outlive the term. Uniform bodies only.
std::unique_ptr<MixedTerm> make_mixed_term(const VolumeSplit& law, const CellGroups<2>& groups, int body,
                                           PetscInt num_owned_nodes, const PressureField& pressures);

}  // namespace pliant
