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
  const Rods& rods = *model.rods().term;
  const BodyState at = model.potential().accounts().state_of(rods, record.instant(model), record.q, nullptr, nullptr);
  // Forces of segments, then moments of vertices.
  std::vector<double> numbers(rods.num_segments(), 0.0);
  for (const Rods::SegmentNodes& segment : rods.segments_here()) {
    if (segment.is_counted) numbers[segment.number] = rods.tension(segment, at.q);
  }
  if (at.at.near != nullptr) {
    for (const auto& of_vertex : rods.moments(*at.at.near, at.q)) {
      numbers.insert(numbers.end(), of_vertex.begin(), of_vertex.end());
    }
  }
  sum_in_place(model.layout().comm, numbers);
  const auto moments_of = [&](std::ptrdiff_t vertex) -> std::array<double, 3> {
    if (vertex < 0) return {};
    const double* first = &numbers[rods.num_segments() + 3 * static_cast<std::size_t>(vertex)];
    return {first[0], first[1], first[2]};
  };
  RodState state;
  for (std::size_t s = 0; s < rods.num_segments(); ++s) {
    const auto before = moments_of(s > 0 ? rods.vertex_after(s - 1) : -1), after = moments_of(rods.vertex_after(s));
    std::array<double, 3> middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * (before[k] + after[k]);
    state.middles.push_back(resultants(numbers[s], middle));
    state.ends.push_back({resultants(numbers[s], before), resultants(numbers[s], after)});
  }
  return state;
}

}  // namespace pliant
