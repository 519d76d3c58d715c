#include "run/rod_fields.hpp"

#include "petsc/collective.hpp"

#include <cmath>

namespace pliant {
namespace {

RodResultants resultants(double force, const std::array<double, 3>& moments) {
  return {force, std::hypot(moments[0], moments[1]), moments[2]};
}

}  // namespace

RodState state_of_rods(Model& model, const StepRecord& record) {
  const ModelRods& all = model.rods();
  const EnergyTerm& any = all.term ? static_cast<const EnergyTerm&>(*all.term) : *all.fibres;
  const BodyState at = model.potential().accounts().state_of(any, record.instant(model), record.q, nullptr, nullptr);
  const std::vector<double> forces = tensions_of(all, model.layout().comm, at.q);
  std::vector<double> moments;  // of vertices
  if (all.term && at.at.near != nullptr) {
    for (const auto& of_vertex : all.term->moments(*at.at.near, at.q)) {
      moments.insert(moments.end(), of_vertex.begin(), of_vertex.end());
    }
  }
  sum_in_place(model.layout().comm, moments);
  const auto moments_of = [&](std::ptrdiff_t vertex) -> std::array<double, 3> {
    if (vertex < 0) return {};
    const double* first = &moments[3 * static_cast<std::size_t>(vertex)];
    return {first[0], first[1], first[2]};
  };
  RodState state;
  for (std::size_t s = 0; s < forces.size(); ++s) {
    const bool is_bent = s < all.num_bent();  // else of a fibre, which has no moments
    const auto before = moments_of(is_bent && s > 0 ? all.term->vertex_after(s - 1) : -1),
               after = moments_of(is_bent ? all.term->vertex_after(s) : -1);
    std::array<double, 3> middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * (before[k] + after[k]);
    state.middles.push_back(resultants(forces[s], middle));
    state.ends.push_back({resultants(forces[s], before), resultants(forces[s], after)});
  }
  return state;
}

}  // namespace pliant
