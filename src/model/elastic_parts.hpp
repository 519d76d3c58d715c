/// The elastic term of a body, with the treatment of its volume that the input chooses.
#pragma once

#include "energy/volume/mixed.hpp"
#include "input/elasticity.hpp"
#include "model/checks.hpp"

#include <functional>
#include <memory>

namespace pliant {

/// What the term is built on; must outlive it, but for `config` and `rule`.
template <int Order>
struct ElasticBody {
  const Config& config;
  const ElasticityRule& rule;
  const NodeLayout& layout;
  const CellGroups<Order>& groups;
  int body;
  const PressureField* pressures;  ///< of `volumetric: mixed`, else nullptr
};

struct ElasticParts {
  std::unique_ptr<ElasticTerm> term;
  MixedTerm* mixed = nullptr;             ///< the term, if it has pressures
  VolumeOfPoints volume;                  ///< if the term has pressures
  std::unique_ptr<StressTerm> softening;  ///< where the body has `mullins`
  std::shared_ptr<const LawField> shape;  ///< what viscosity follows: the law, without its volumetric part if that is
                                          ///< treated apart
};

/// `law_at(local cell, reference position)`; a uniform law is asked for once. Throws InputError where the law cannot be
/// treated so.
template <int Order>
ElasticParts make_elastic_parts(const ElasticBody<Order>& on,
                                const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>& law_at,
                                FreeShape shape);

}  // namespace pliant
