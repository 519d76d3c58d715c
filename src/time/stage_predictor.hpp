/// The acceleration of a stage before it is solved.
#pragma once

#include "petsc/archive.hpp"
#include "petsc/work_vector.hpp"

#include <array>
#include <vector>

namespace pliant {

/// Predicts the acceleration (v_i - v_i0) / dt_i of a stage from the polynomial in time through those of the same stage
/// in the last steps. (Stages of different number have errors of their own of order dt^2, which a curve through all of
/// them would take for motion; from step to step they change smoothly.) What the polynomial missed at the stage before,
/// in the same step, it is expected to miss again.
///
/// The caller's own prediction takes part: whichever was closer for the same stage of the last step predicts the next
/// one.
///
/// Invariant: an attempt leaves no trace unless it is accepted, or a prediction was withdrawn.
class StagePredictor {
 public:
  /// Vectors are made like `like`, which outlives the object. Collective.
  StagePredictor(int num_stages, Vec like);

  /// Begins an attempt.
  void begin();
  /// Replaces the prediction of the caller by that of the polynomial if it promises to be closer. Collective.
  void predict(std::size_t stage, double time, Vec a);
  /// The stage has no solution from the last prediction. If that was the polynomial's, forgets the past, sets `a` to
  /// the caller's prediction and returns true. Collective.
  bool withdraw(Vec a);
  /// Learns from the acceleration of the stage that was predicted last. Collective.
  void end_stage(std::size_t stage, Vec a);
  /// The last attempt became a step; if it was not complete, as `restart`.
  void accept();
  /// Forgets the past, which says nothing about what follows.
  void restart();
  /// Collective.
  void keep(Archive& archive);

 private:
  void forget();

  /// Most past accelerations.
  static constexpr std::size_t depth = 4;

  /// What an attempt teaches about a stage.
  struct Lesson {
    bool is_known = false;
    double error_of_polynomial = 0.0, error_of_caller = 0.0;  ///< norms
  };

  struct Stage {
    std::vector<WorkVector> a;              // accelerations: of the attempt, then of past steps, newest first
    std::array<double, depth + 1> times{};  // of the stages
    std::size_t num_past = 0;
    Lesson tried, accepted;
  };

  /// polynomial_ = that through the past accelerations, at `time`.
  void extrapolate(const Stage& stage, double time);

  std::vector<Stage> stages_;
  std::size_t num_ended_ = 0;       // stages of the attempt
  bool has_polynomial_ = false;     // for the present stage
  bool is_by_polynomial_ = false;   // the present prediction
  WorkVector missed_;               // by the polynomial at the stage before
  WorkVector polynomial_, caller_;  // predictions for the present stage
};

}  // namespace pliant
