/// Stresses of terms inside the bodies, cell by cell, for output.
#pragma once

#include "base/tensor.hpp"
#include "energy/term.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <span>

namespace pliant {

/// Which share of a cell's stress a term gives.
enum class StressPart { elastic, viscous, active };
inline constexpr std::size_t num_stress_parts = 3;

/// Which cells of a rank are visited.
enum class VisitedCells { owned, local };

/// A state of the body, in the local arrays of a LocalStage.
struct BodyState {
  Instant at = {};
  std::span<const double> q = {};  ///< displacement [m]
  std::span<const double> v = {};  ///< velocity [m/s]; empty: at rest
  std::span<const double> z = {};  ///< the term's own internal variables
  VisitedCells visited = VisitedCells::owned;
};

/// A term's contribution to the stress of a cell.
struct CellStress {
  std::array<double, 6> cauchy{};  ///< xx yy zz xy yz xz [Pa]
  Tensor3<double> H{};             ///< grad u at the centroid
  double volume_ratio = 1.0;       ///< J
  double energy_density = 0.0;     ///< stored per reference volume [J/m^3]
  double softening = 0.0;          ///< part of the law's stress of distortion that is lost, 1 - eta
};

/// Equivalent stress of a Cauchy stress: xx yy zz xy yz xz [Pa].
double von_mises(const std::array<double, 6>& cauchy);

/// Called with a local cell and the term's contribution there.
using StressVisitor = std::function<void(PetscInt, const CellStress&)>;

/// A term with a stress.
class StressTerm : public EnergyTerm {
 public:
  virtual StressPart part() const = 0;
  /// Calls `visit` for the cells of the term, owned ones or all that the rank has.
  virtual void stresses(const BodyState& state, const StressVisitor& visit) const = 0;
};

}  // namespace pliant
