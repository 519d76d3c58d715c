/// What is given inside a body as a function of place and time; contraction along its fibres, common to active stress
/// and active strain.
#pragma once

#include "base/expression.hpp"
#include "energy/term.hpp"
#include "energy/volume/body_points.hpp"

#include <functional>
#include <utility>

namespace pliant {

/// Unit vectors in the reference body.
using PackDirection = std::array<Pack, 3>;

/// A number at all points of a body.
class GivenAmount {
 public:
  /// `amount` is a function of place and time, `places` are the positions of all points of the body. `at_rest` is the
  /// amount that has no effect.
  GivenAmount(Expression amount, std::vector<PackPlaces> places, double at_rest = 0.0);

  /// The amounts at the instant less `at_rest`, times its load factor.
  PerPoint<Pack> amounts(const Instant& at) const;
  /// Their time rates at the instant, just before it (after it at 0), where they are smooth over `time_scale`.
  PerPoint<Pack> rates(const Instant& at, double time_scale) const;
  /// Likewise at the end of the stage.
  PerPoint<Pack> rates(const LocalStage& stage) const { return rates(instant_of(stage), stage.dt); }

 private:
  template <class F>
  PerPoint<Pack> at_points(const F& f) const;

  Expression amount_;
  std::vector<PackPlaces> places_;
  double at_rest_;
};

class Activation : public GivenAmount {
 public:
  Activation(GivenAmount amount, PerPoint<PackDirection> fibres)
      : GivenAmount(std::move(amount)), fibres_(std::move(fibres)) {}

  const PackDirection& fibre(std::size_t n) const { return fibres_[n]; }

 private:
  PerPoint<PackDirection> fibres_;
};

/// `fibre(local cell, reference position)`, at all points or, if the body's fibres are parallel, at an arbitrary one.
struct FibreField {
  std::function<std::array<double, 3>(PetscInt, const std::array<double, 3>&)> at;
  enum class Kind { parallel, varying } kind;
};

template <int Order>
Activation make_activation(const Expression& amount, const FibreField& fibres, const NodeLayout& layout,
                           const CellGroups<Order>& groups, int body);

}  // namespace pliant
