#include "energy/constraint/prescribed.hpp"

#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {

PrescribedDisplacement::PrescribedDisplacement(const NodeLayout& layout, std::vector<PrescribedPart> parts,
                                               double time_scale)
    : parts_(std::move(parts)), time_scale_(time_scale) {
  const Handle<Vec> marks = make_vector(layout);
  {
    const ArrayView mark(marks.get());
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (int i = 0; i < 3; ++i) {
        if (!parts_[p].displacement.gives(i)) continue;
        for (const PetscInt node : parts_[p].nodes) {
          if (mark[3 * node + i] != 0.0) continue;
          mark[3 * node + i] = 1.0;
          entries_.push_back({3 * node + i, p, layout.position(node)});
        }
      }
    }
  }
  update_ghosts(marks.get());
  const ConstGhostedView mark(marks.get());
  for (const double m : mark.span()) flags_.push_back(m != 0.0);
}

std::vector<std::pair<std::size_t, std::size_t>> PrescribedDisplacement::conflicts(
    const NodeLayout& layout, const std::vector<double>& times) const {
  std::vector<std::size_t> winner(flags_.size(), parts_.size());
  for (const Entry& e : entries_) winner[e.dof] = e.part;
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    for (int i = 0; i < 3; ++i) {
      if (!parts_[p].displacement.gives(i)) continue;
      for (const PetscInt node : parts_[p].nodes) {
        const std::size_t w = winner[3 * node + i];
        if (w == p) continue;
        const auto X = layout.position(node);
        for (const double t : times) {
          const double a = parts_[w].displacement(i, X, t), b = parts_[p].displacement(i, X, t);
          if (std::abs(a - b) > 1e-12 * (std::abs(a) + std::abs(b))) result.emplace_back(w, p);
        }
      }
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

std::vector<LinearConstraint> PrescribedDisplacement::constraints(const NodeLayout& layout,
                                                                  const std::set<PetscInt>& wanted) const {
  std::vector<LinearConstraint> result;
  for (const Entry& e : entries_) {
    const PetscInt entry = 3 * layout.first_global_node + e.dof;
    if (wanted.contains(entry))
      result.push_back({{{entry, 1.0}}, {{1.0, e.part, static_cast<int>(e.dof % 3), e.X}}, e.part});
  }
  return result;
}

template <class Set>
void PrescribedDisplacement::for_each(double time, double time_scale, double factor, Side side, Set set) const {
  std::vector<GivenKinematics> given;
  for (const PrescribedPart& part : parts_) given.emplace_back(part.displacement, time, time_scale, factor, side);
  for (const Entry& e : entries_) {
    if (paths_.empty() || !paths_.contains(e.dof)) set(e.dof, given[e.part](e.dof % 3, e.X));
  }
}

double PrescribedDisplacement::Path::at(double time) const {
  const double duration = end - start;
  const double part = duration > 0.0 ? std::clamp((time - start) / duration, 0.0, 1.0) : 1.0;
  return (1.0 - part) * from + part * to;
}

void PrescribedDisplacement::follow(PetscInt dof, const Path& path) {
  if (flags_[static_cast<std::size_t>(dof)] != 0) paths_[dof] = path;
}

PrescribedMotion PrescribedDisplacement::motion() const {
  PrescribedMotion motion;
  motion.start_stage = [this](const StagePoint& stage, Vec q) {
    const ArrayView guess(q), q0(stage.q0), v0(stage.v0);
    // The time before the step may lie behind a kink.
    const double smooth = stage.time - stage.step_start;
    for_each(stage.time, std::min(time_scale_, smooth > 0.0 ? smooth : stage.dt), stage.load_factor,
             smooth > 0.0 ? Side::before : Side::after, [&](PetscInt dof, const Kinematics& k) {
               guess[dof] = k.u;
               q0[dof] = k.u - stage.dt * k.v;
               v0[dof] = k.v - stage.dt * k.a;
             });
    for (const auto& [dof, path] : paths_) guess[dof] = stage.load_factor * path.at(stage.time);
  };
  motion.complete_step = [this](const Step& step, Vec q, Vec v) {
    const ArrayView position(q), velocity(v);
    for_each(step.time, std::min(time_scale_, step.dt), 1.0, Side::before, [&](PetscInt dof, const Kinematics& k) {
      position[dof] = k.u;
      velocity[dof] = k.v;
    });
  };
  motion.restart = [this](const Step& step, Vec /*q*/, Vec v) {
    const ArrayView velocity(v);
    for_each(step.time, std::min(time_scale_, step.dt), 1.0, Side::after,
             [&](PetscInt dof, const Kinematics& k) { velocity[dof] = k.v; });
  };
  return motion;
}

}  // namespace pliant
