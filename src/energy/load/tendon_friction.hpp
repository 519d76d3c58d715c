/// Friction of tendons at the points where they turn.
#pragma once

#include "energy/load/tendon.hpp"
#include "material/contact_law.hpp"

#include <memory>

namespace pliant {

/// Coulomb friction of a tendon that is anchored at its last point and turns by the angle theta_j at its point j. It
/// slips there with the velocity s_j at which the part beyond shortens, positive towards the pulled end:
///
///     ln(T_j / T_{j-1}) = -mu theta_j f(s_j / v_s),   s_j = -sum_{k>=j} n_k . (d_k - d_k0) / dt,
///
/// T_k the tension of segment k, n_k its direction, f that of Friction (material/contact_law.hpp). For |s_j| > v_s this
/// is the capstan equation (Euler & Eytelwein). Directions and the drops F_j of tension at full slip are frozen and
/// refreshed (TermDeclaration::refreezes), which leaves the potential dt sum_j F_j R(s_j), R' = f: convex, with the
/// Hessian sum_j F_j f'(s_j) g_j g_j^T / dt, g_j = ds_j/dv.
class TendonFriction final : public EnergyTerm {
 public:
  /// `path` couples all points. `friction`: of its coefficient and stick velocity.
  TendonFriction(std::shared_ptr<const TendonPath> path, TendonDrive drive, const Friction& friction)
      : path_(std::move(path)), drive_(std::move(drive)), friction_(friction) {}

  std::string_view name() const override { return "tendon-friction"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(path_.get()); }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;

  /// The tension of each segment of a tendon whose points have these places [m] and velocities [m/s], from that at the
  /// pulled end [N].
  std::vector<double> tensions(double at_pulled_end, std::span<const Vector3<double>> places,
                               std::span<const Vector3<double>> velocities) const;

 private:
  /// The point at the start of a segment.
  struct Turn {
    Vector3<double> n;      // direction of the segment
    double drop = 0.0;      // F, loss of tension at full slip [N]; 0 at the first point
    double velocity = 0.0;  // s [m/s]
  };
  /// One for each segment, with what is frozen as it is and s at q.
  std::vector<Turn> turns(const LocalStage& stage, std::span<const double> q) const;
  /// dt R, f and df/ds of a drop.
  DragResponse response(const Turn& turn) const;

  std::shared_ptr<const TendonPath> path_;
  TendonDrive drive_;
  Friction friction_;
};

}  // namespace pliant
