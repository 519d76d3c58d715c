/// The acceleration of a stage before it is solved.
#pragma once

#include "petsc/archive.hpp"
#include "petsc/handle.hpp"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// Predicts the acceleration (v_i - v_i0) / dt_i of a stage by linear regression on those of the same stage in the last
/// steps. (Stages of different number have errors of their own of order dt^2, which a curve through all of them would
/// take for motion; from step to step they change smoothly.) What the regression missed at the stage before, in the
/// same step, it is expected to miss again.
///
/// The coefficients are those that would have predicted the same stage of the last step best, in the least-squares
/// sense: as few as there are, they also predict what a polynomial does not, such as the decay and the vibration of a
/// few modes. Directions that the past accelerations do not determine are left to the polynomial through them.
///
/// What may be had without regression, the caller's own prediction, takes part: whichever was closer for the same stage
/// of the last step predicts the next one.
///
/// Invariant: an attempt leaves no trace unless it is accepted.
class StagePredictor {
 public:
  /// Collective.
  StagePredictor(int num_stages, Vec like);

  /// Begins an attempt.
  void begin();
  /// Replaces the prediction of the caller by that of the regression if it promises to be closer. Collective.
  void predict(std::size_t stage, double time, Vec a);
  /// Learns from the acceleration of the stage that was predicted last. Collective.
  void end_stage(std::size_t stage, Vec a);
  /// The last attempt became a step; if it was not complete, as `restart`.
  void accept();
  /// Forgets the past, which says nothing about what follows.
  void restart();
  /// Collective.
  void keep(Archive& archive);

 private:
  /// Most past accelerations.
  static constexpr std::size_t depth = 4;

  using Coefficients = std::array<double, depth>;

  /// What an attempt teaches about a stage.
  struct Lesson {
    std::size_t num_past = 0;     ///< accelerations that the coefficients are for; 0 if there was no prediction
    Coefficients coefficients{};  ///< minus those of the polynomial
    double error_of_regression = 0.0, error_of_caller = 0.0;
  };

  struct Stage {
    std::vector<Handle<Vec>> a;             // accelerations: of the attempt, then of past steps, newest first
    std::array<double, depth + 1> times{};  // of the stages
    std::size_t num_past = 0;
    Lesson tried, accepted;
  };

  std::size_t num_usable(const Stage& stage, double time) const;
  /// The coefficients of the polynomial through the past accelerations.
  static Coefficients polynomial(const Stage& stage, std::size_t num_past, double time);
  /// The newest past accelerations.
  std::span<const Vec> past(std::size_t stage, std::size_t num_past);
  /// The changes of the coefficients that predict a best.
  static Coefficients fit(std::span<const Vec> past, const Coefficients& prior, Vec a);

  std::vector<Stage> stages_;
  std::size_t num_ended_ = 0;        // stages of the attempt
  std::size_t num_used_ = 0;         // past accelerations in the present prediction
  Coefficients prior_{};             // of the present prediction
  Handle<Vec> missed_;               // by the regression at the stage before
  Handle<Vec> regression_, caller_;  // predictions for the present stage
  std::array<Vec, depth> borrowed_{};
};

}  // namespace pliant
