#include "energy/equation/stage_adjoint.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace pliant {

std::vector<std::string> StageAdjoint::missing() const {
  std::vector<std::string> names;
  for (const EnergyTerm* term : terms_.all()) {
    if (term->has_adjoint() || std::ranges::find(names, term->name()) != names.end()) continue;
    names.emplace_back(term->name());
  }
  return names;
}

bool StageAdjoint::has_rest() const {
  return std::ranges::any_of(terms_.all(), [](const EnergyTerm* term) { return !term->declaration().is_potential; });
}

void StageAdjoint::add_owned(std::span<const double> rows, Vec r) const {
  const ArrayView owned(r);
  for (PetscInt i = 0; i < 3 * terms_.layout().num_owned_nodes; ++i) owned[i] += rows[i];
}

void StageAdjoint::pull_back(Vec q, Vec residual, Vec internal, const SlopeVectors& slopes) {
  const auto at = terms_.at(q);
  const auto multipliers = terms_.arrays().beside(residual);
  std::array<std::vector<double>, 3> rows;
  for (auto& row : rows) row.assign(3 * terms_.arrays().num_nodes(), 0.0);
  {
    std::optional<ArrayView> z0;
    if (slopes.z0 != nullptr) z0.emplace(slopes.z0);
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      const std::span<double> own = z0 ? terms_.internal_of(k, z0->span()) : std::span<double>{};
      terms_[k].pull_back(terms_.stage_of(k), at, {multipliers, terms_.internal_of(k, internal)},
                          {rows[0], rows[1], rows[2], own});
    }
  }
  add_owned(rows[0], slopes.q);
  add_owned(rows[1], slopes.q0);
  add_owned(rows[2], slopes.v0);
}

void StageAdjoint::pull_back_completion(Vec q, Vec z, Vec r) {
  if (z == nullptr) return;
  const auto at = terms_.arrays().at(q);
  const auto rows = terms_.empty_rows();
  {
    const ArrayView multipliers(z);
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      terms_[k].pull_back_completion(at, terms_.internal_of(k, multipliers.span()), rows);
    }
  }
  add_owned(rows, r);
}

void StageAdjoint::add_transposed_rest(Vec q, Vec d, Vec r) {
  const auto at = terms_.at(q);
  const auto direction = terms_.arrays().beside(d);
  const auto rows = terms_.empty_rows();
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    terms_[k].add_transposed_rest(terms_.stage_of(k), at, direction, rows);
  }
  add_owned(rows, r);
}

void StageAdjoint::add_cell_works(Vec q, Vec d, std::span<double> works) {
  const auto at = terms_.at(q);
  const auto direction = terms_.arrays().beside(d);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    terms_[k].add_cell_works(terms_.stage_of(k), at, direction, works);
  }
}

}  // namespace pliant
