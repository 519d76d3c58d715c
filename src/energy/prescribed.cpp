#include "energy/prescribed.hpp"

#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

// Weights of f(t - k h), k = 0..6, for f'(t) h (sixth order) and f''(t) h^2 (fifth order): Fornberg 1988, table 3.
constexpr std::array<double, 7> first{49.0 / 20, -6.0, 15.0 / 2, -20.0 / 3, 15.0 / 4, -6.0 / 5, 1.0 / 6};
constexpr std::array<double, 7> second{203.0 / 45, -87.0 / 5, 117.0 / 4, -254.0 / 9, 33.0 / 2, -27.0 / 5, 137.0 / 180};

}  // namespace

PrescribedDisplacement::Kinematics PrescribedDisplacement::kinematics(const Expression& formula,
                                                                      const std::array<double, 3>& X, double time,
                                                                      double time_scale) {
  const auto& [x, y, z] = X;
  Kinematics result{formula(x, y, z, time), 0.0, 0.0};
  if (!formula.depends_on_time()) return result;
  // Backward from t, not beyond the start of the run; at the start itself forward, which is a negative h. The last
  // point is the end of the range itself: rounding must not carry it across.
  const double end = time > 0.0 ? std::max(0.0, time - time_scale) : time_scale;
  const double h = (time - end) / 6.0;
  for (int k = 0; k < 7; ++k) {
    const double f = formula(x, y, z, k < 6 ? time - k * h : end);
    result.v += first[k] * f / h;
    result.a += second[k] * f / (h * h);
  }
  return result;
}

PrescribedDisplacement::PrescribedDisplacement(const NodeLayout& layout, std::vector<PrescribedPart> parts,
                                               double time_scale)
    : parts_(std::move(parts)), time_scale_(time_scale) {
  const Handle<Vec> marks = make_vector(layout);
  {
    const ArrayView mark(marks.get());
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (int i = 0; i < 3; ++i) {
        if (!parts_[p].displacement[i]) continue;
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
      if (!parts_[p].displacement[i]) continue;
      for (const PetscInt node : parts_[p].nodes) {
        const std::size_t w = winner[3 * node + i];
        if (w == p) continue;
        const auto [x, y, z] = layout.position(node);
        for (const double t : times) {
          const double a = (*parts_[w].displacement[i])(x, y, z, t), b = (*parts_[p].displacement[i])(x, y, z, t);
          if (std::abs(a - b) > 1e-12 * (std::abs(a) + std::abs(b))) result.emplace_back(w, p);
        }
      }
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

template <class Set>
void PrescribedDisplacement::for_each(double time, double time_scale, Set set) const {
  // Entries come part by part and component by component: a formula without space is evaluated once per run of them.
  const Entry* previous = nullptr;
  Kinematics value;
  for (const Entry& e : entries_) {
    const Expression& formula = *parts_[e.part].displacement[e.dof % 3];
    const bool same = previous != nullptr && previous->part == e.part && previous->dof % 3 == e.dof % 3;
    if (!same || formula.depends_on_space()) value = kinematics(formula, e.X, time, time_scale);
    set(e.dof, value);
    previous = &e;
  }
}

PrescribedMotion PrescribedDisplacement::motion() const {
  PrescribedMotion motion;
  motion.start_stage = [this](const StagePoint& stage, Vec q) {
    const ArrayView guess(q), q0(stage.q0), v0(stage.v0);
    // What came before the step may lie behind a kink.
    const double smooth = stage.time - stage.step_start;
    for_each(stage.time, std::min(time_scale_, smooth > 0.0 ? smooth : stage.dt),
             [&](PetscInt dof, const Kinematics& k) {
               const double f = stage.load_factor;
               guess[dof] = f * k.u;
               q0[dof] = f * (k.u - stage.dt * k.v);
               v0[dof] = f * (k.v - stage.dt * k.a);
             });
  };
  motion.complete_step = [this](const Step& step, Vec q, Vec v) {
    const ArrayView position(q), velocity(v);
    for_each(step.time, std::min(time_scale_, step.dt), [&](PetscInt dof, const Kinematics& k) {
      position[dof] = k.u;
      velocity[dof] = k.v;
    });
  };
  return motion;
}

}  // namespace pliant
