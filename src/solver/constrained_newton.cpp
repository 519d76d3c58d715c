#include "solver/constrained_newton.hpp"

namespace pliant {

ConstrainedNewton::ConstrainedNewton(StageEquation& equation, ConstraintMap& map, const NewtonOptions& options,
                                     LinearKind linear)
    : map_(map), equation_(equation, map), solver_(equation_, options, linear), y_(equation.make_vector()) {}

StageReport ConstrainedNewton::solve(const StagePoint& stage, Vec q) {
  const StagePoint reduced = equation_.reduce(stage, q, y_.get());
  StageReport report = solver_.solve(reduced, y_.get());
  map_.expand(y_.get(), q);
  return report;
}

}  // namespace pliant
