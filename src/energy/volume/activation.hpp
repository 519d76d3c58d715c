/// Contraction of a body along its fibres as a function of time: common to active stress and active strain.
#pragma once

#include "base/expression.hpp"
#include "energy/term.hpp"
#include "energy/volume/body_points.hpp"

#include <functional>

namespace pliant {

/// Unit vectors in the reference body.
using PackDirection = std::array<Pack, 3>;

class Activation {
 public:
  /// `amount` is a function of place and time, `places` are the positions of all points of the body.
  Activation(Expression amount, std::vector<PackPlaces> places, PerPoint<PackDirection> fibres);

  const PackDirection& fibre(std::size_t n) const { return fibres_[n]; }
  /// The amounts at the instant, times its load factor.
  PerPoint<Pack> amounts(const Instant& at) const;
  /// Their time rates at the end of the stage, by differences of sixth order over its length.
  PerPoint<Pack> rates(const LocalStage& stage) const;

 private:
  template <class F>
  PerPoint<Pack> at_points(const F& f) const;

  Expression amount_;
  std::vector<PackPlaces> places_;
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
