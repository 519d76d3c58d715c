/// Tendons: strings through points of the bodies that are pulled at their first point.
#pragma once

#include "base/expression.hpp"
#include "energy/function_of_sum.hpp"
#include "energy/load/tendon_path.hpp"
#include "energy/term.hpp"

#include <memory>
#include <variant>

namespace pliant {

/// A given force at the pulled end.
struct GivenTension {
  Expression tension;  ///< [N]; a function of t
};
/// A given pull by a spring at the pulled end, which may become slack: T = k max(0, l - l0 + pull), l0 the length in
/// the reference configuration.
struct TendonSpring {
  double stiffness = 0.0;  ///< k [N/m]
  Expression pull;         ///< [m]; a function of t
};
using TendonDrive = std::variant<GivenTension, TendonSpring>;

/// The tension at the pulled end [N] where the path is longer than in the reference configuration by `lengthening` [m].
double tension_at_pulled_end(const TendonDrive& drive, double lengthening, double time, double factor);

/// A string without friction, straight between its points x_0 .. x_n: its tension T is the same everywhere. With
/// l = sum |x_{k+1} - x_k|, its potential is T l for a given tension, k/2 max(0, l - l0 + pull)^2 for a spring. Both
/// are convex in the positions. The Hessian has T (I - n n^T) / |x_{k+1} - x_k| of each segment, n its direction, and
/// for a spring the rank-one part k dl dl^T, which couples all points (energy/function_of_sum.hpp).
class Tendon final : public EnergyTerm, public FunctionOfSum {
 public:
  Tendon(std::shared_ptr<const TendonPath> path, TendonDrive drive)
      : path_(std::move(path)), drive_(std::move(drive)) {}

  std::string_view name() const override { return "tendon"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override;
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;
  /// T pull': the work of what pulls the spring.
  double supply(const LocalStage& stage, std::span<const double> q) const override;

  /// S = l - l0.
  SumOverRanks part(const LocalStage& stage, std::span<const double> q) const override;
  double value_of_sum(const LocalStage& stage) const override;
  double energy_of_sum(const Instant& at, double S) const override;
  double curvature(const LocalStage& stage) const override;
  void add_gradient_of_sum(const LocalStage& stage, std::span<const double> q, std::span<double> g) const override;

 private:
  const TendonSpring* spring() const { return std::get_if<TendonSpring>(&drive_); }
  double tension(const LocalStage& stage) const;

  std::shared_ptr<const TendonPath> path_;
  TendonDrive drive_;
};

}  // namespace pliant
