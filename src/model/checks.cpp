#include "model/checks.hpp"

#include "input/checks/volumetric.hpp"
#include "petsc/check.hpp"

#include <algorithm>

namespace pliant {

void require_compressible(const ElasticLawSpec& law, const Location& where) {
  if (is_incompressible(law)) throw InputError(where, std::string(incompressible_without_pressures));
}

void require_undeformed(const Config& config, Vec q) {
  PetscReal size = 0.0;
  check(VecNorm(q, NORM_INFINITY, &size));
  if (size == 0.0) return;
  const auto moves = [](const ConstraintConfig& constraint) {
    const auto* prescribed = std::get_if<ConstraintConfig::Displacement>(&constraint.kind);
    return prescribed != nullptr &&
           std::ranges::any_of(prescribed->value, [](const auto& u) { return u && !u->is_zero(); });
  };
  const auto constraint = std::ranges::find_if(config.constraints, moves);
  throw InputError(constraint != config.constraints.end() ? constraint->where : Location{config.file, 0, 0},
                   "'volumetric: mixed' must start from undeformed bodies, whose pressure is known, but a displacement "
                   "is prescribed at t = 0; let it grow from 0, or use 'volumetric: mean-dilatation'");
}

}  // namespace pliant
