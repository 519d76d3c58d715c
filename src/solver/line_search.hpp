/// The line search: the step length along a direction, on a potential or, if there is none, on a merit function of the
/// residual.
#pragma once

namespace pliant {

/// The line q + alpha d as a line search sees it, in numbers alone; `alpha` is the step length relative to d.
/// Implementations may hold distributed vectors; then all methods are collective and return the same on every rank.
class SearchLine {
 public:
  struct Residual {
    double norm = 0.0;   ///< |r|; not finite beyond a barrier [N]
    double slope = 0.0;  ///< r . d [J]
  };

  virtual ~SearchLine() = default;
  /// Goes to q + alpha d and returns the potential there [J]; +inf beyond a barrier.
  virtual double potential(double alpha) = 0;
  /// Goes to q + alpha d and evaluates the residual there.
  virtual Residual residual(double alpha) = 0;
  /// Whether the body can be at the point that `residual` went to (no cell inverted, no barrier crossed).
  virtual bool is_admissible() = 0;
  /// Merit of the last evaluated residual, 1/2 r . D^-1 r [J].
  virtual double merit() = 0;
  /// Solves for the next correction c = K^-1 r with the last evaluated residual. Returns its merit
  /// 1/2 c . D c; +inf if the linear solver failed [J].
  virtual double merit_of_correction() = 0;
  /// 1/2 d . D d [J].
  virtual double merit_of_direction() = 0;
  /// 1/2 e . D e of the nonlinear part of the correction, e = c + (1 - alpha) d [J], which is zero for a linear
  /// equation. Overwrites the correction with e.
  virtual double merit_of_nonlinear_part(double alpha) = 0;
};

/// The data of a line search at q itself.
struct LineStart {
  double first_length = 1.0;       ///< the step length to try first, at most 1
  bool is_at_wall = false;         ///< a wall has cut first_length to less than half
  double slope = 0.0;              ///< r . d [J]
  double residual = 0.0;           ///< |r| [N]
  double residual_rounding = 0.0;  ///< size of the rounding errors of r [N]
  double measure = 0.0;            ///< the potential, or the merit, at q [J]
  double displacement = 0.0;       ///< |q - q_0| from the stage's start, for the rounding error of a potential [m]
  double step = 0.0;               ///< |d| [m]
};

/// The result of a line search.
struct LineOutcome {
  enum class Status {
    accepted,     ///< q + length d is better
    at_rounding,  ///< no length helps, but the residual at q is as small as its rounding errors: q is the solution
    stalled       ///< no length helps
  };
  Status status = Status::stalled;
  double length = 0.0;     ///< accepted step length, relative to d
  double potential = 0.0;  ///< there, for a search on the potential [J]
  double residual = 0.0;   ///< |r| there [N]
  int backtracks = 0;      ///< lengths that were rejected
};

/// A residual below this multiple of its rounding floor, which is an estimate, consists of rounding errors.
inline constexpr double rounding_safety = 4.0;

/// Line searches of one run of Newton's method, one after another.
///
/// On the potential: Armijo's condition. If the change of the potential is within its rounding error, the gradient
/// decides (Hager & Zhang 2005, approximate Wolfe condition). A value of +inf backtracks.
///
/// On the residual, with a K that may be an approximation of dr/dq: a step is accepted if one of two measures falls by
/// a tenth of the decrease of a linear equation, |.(q + alpha d)| <= (1 - alpha / 10) |.(q)|. The first measure is the
/// residual in the norm of D^-1. The second, for bodies whose stiff directions hide the progress of soft ones (every
/// straight step stretches a bending strip), is the correction K^-1 r in the norm of D, with the K of the iteration:
/// the natural monotonicity test (Deuflhard 2011, Newton Methods for Nonlinear Problems, 3.3).
///
/// Invariants:
/// - An accepted length lies in (0, first_length], its residual is finite, and it is the length that `line` went to
///   last: only the correction was evaluated since.
/// - The first length that is tried is first_length; each further one is shorter than the previous one.
/// - The only state kept between searches is whether the last accepted step went far beyond the minimum along its
///   line. `begin` clears it.
class LineSearch {
 public:
  /// Which residuals a search on the residual accepts.
  enum class Demand {
    decrease,  ///< those that decrease in one of the measures
    none,      ///< any finite residual: whole steps
    descent    ///< those up to where the forces along the line, r . d, vanish, or not far beyond: their work is done
  };

  /// Begins a run of Newton's method.
  void begin() { went_beyond_ = false; }

  LineOutcome lower_potential(SearchLine& line, const LineStart& start);
  LineOutcome lower_residual(SearchLine& line, const LineStart& start, Demand demand);

 private:
  /// Whether the correction at q + alpha d is shorter than d by the required fraction; otherwise sets alpha to the next
  /// length to try.
  static bool shortens_correction(SearchLine& line, double& alpha);

  bool went_beyond_ = false;
};

}  // namespace pliant
