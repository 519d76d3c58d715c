/// A specimen that is stretched and then held, and whose stress relaxes by Prony's branches (material/viscosity.hpp).
///
/// With S_e(t) the stress of the elastic law along x (second Piola-Kirchhoff), whose sides are free at all times,
///     S(t) = S_e(t) + sum_i g_i int_0^t exp(-(t - s)/tau_i) dS_e(s),
/// so that the free sides remain free and the specimen deforms as the elastic law alone would. In an incompressible
/// body the branches follow the law's stresses alone, along x and across the free sides, S_x and S_f, and the pressure
/// takes the traction from these: S(t) = S_x(t) - (lambda_f/lambda)^2 S_f(t). The nominal stress is the stretch times S
/// (for simple shear, which is only applied at once, the nominal stress itself relaxes). Integrated by parts,
///     int_0^t exp(-(t - s)/tau) dS_e = S_e(t) - 1/tau int_0^t exp(-(t - s)/tau) S_e(s) ds,
/// which is linear in S_e: weights times its values at some stretches. Source: Simo, Comput. Methods Appl. Mech. Eng.
/// 60 (1987) 153-173.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace pliant {

struct PronyBranch {
  double ratio;            ///< g
  double relaxation_time;  ///< tau [s]
};

/// What the nominal stress at a time is, in the nominal elastic stresses at the amounts: weights, one for each.
struct RelaxationWeights {
  std::vector<double> total;
  std::vector<std::vector<double>> by_ratio;  ///< derivatives by each branch's ratio
  std::vector<std::vector<double>> by_time;   ///< and by its relaxation time [1/s]
};

class RelaxationHistory {
 public:
  /// The specimen is brought to `amount` (a stretch, or 1 + the amount of shear) at once, or at a constant `rate` of
  /// the stretch [1/s].
  RelaxationHistory(double amount, const std::optional<double>& rate);

  /// Where the elastic stress has to be known: Chebyshev's points between rest and the amount, which interpolate it to
  /// rounding; of a sudden stretch the amount alone.
  std::span<const double> amounts() const { return amounts_; }
  /// The amount at the time t >= 0 [s] after the stretch begins.
  double amount_at(double t) const;
  /// At the time t.
  RelaxationWeights weights(double t, std::span<const PronyBranch> branches) const;

 private:
  struct Convolution {
    std::vector<double> value, by_time;
  };
  Convolution convolution(double t, double relaxation_time) const;
  /// Adds `factor` times S_e at the time t on the way, as interpolated, to the weights of the nominal stresses.
  void add_stress(double t, double factor, std::vector<double>& weights) const;

  double amount_;
  double duration_;  ///< of the stretching [s]
  std::vector<double> amounts_;
};

}  // namespace pliant
