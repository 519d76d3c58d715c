#include "energy/volume/activation.hpp"

#include "energy/given_motion.hpp"

#include <utility>

namespace pliant {

GivenAmount::GivenAmount(Expression amount, std::vector<PackPlaces> places, double at_rest)
    : amount_(std::move(amount)), places_(std::move(places)), at_rest_(at_rest) {}

template <class F>
PerPoint<Pack> GivenAmount::at_points(const F& f) const {
  if (!amount_.depends_on_space()) return {{Pack(f(std::array<double, 3>{}))}};
  PerPoint<Pack> result;
  result.values.reserve(places_.size());
  for (const PackPlaces& place : places_) {
    result.values.emplace_back([&](auto lane) { return f(place.X[lane]); });
  }
  return result;
}

PerPoint<Pack> GivenAmount::amounts(const Instant& at) const {
  return at_points(
      [&](const std::array<double, 3>& X) { return at.load_factor * (amount_(X[0], X[1], X[2], at.time) - at_rest_); });
}

PerPoint<Pack> GivenAmount::rates(const Instant& at, double time_scale) const {
  const GivenDisplacement given{{amount_, std::nullopt, std::nullopt}};
  const GivenKinematics around(given, at.time, time_scale, at.load_factor);
  return at_points([&](const std::array<double, 3>& X) { return around(0, X).v; });
}

template <int Order>
Activation make_activation(const Expression& amount, const FibreField& fibres, const NodeLayout& layout,
                           const CellGroups<Order>& groups, int body) {
  std::vector<PackPlaces> places = places_of_points<Order>(layout, groups, body);
  PerPoint<PackDirection> directions;
  if (fibres.kind == FibreField::Kind::parallel) {
    const auto f = fibres.at(0, {});
    directions.values.push_back({Pack(f[0]), Pack(f[1]), Pack(f[2])});
  } else {
    for (const PackPlaces& place : places) {
      PackDirection& direction = directions.values.emplace_back();
      for (int lane = 0; lane < pack_size; ++lane) {
        const auto f = fibres.at(place.cell[lane], place.X[lane]);
        for (int i = 0; i < 3; ++i) direction[i][lane] = f[i];
      }
    }
  }
  return {{amount, std::move(places)}, std::move(directions)};
}

template Activation make_activation<1>(const Expression&, const FibreField&, const NodeLayout&, const CellGroups<1>&,
                                       int);
template Activation make_activation<2>(const Expression&, const FibreField&, const NodeLayout&, const CellGroups<2>&,
                                       int);

}  // namespace pliant
