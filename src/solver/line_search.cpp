#include "solver/line_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr double armijo = 1e-4;
constexpr double wolfe = 0.9;
/// A step was too long if the slope at its end exceeds this fraction of the slope at its start, with the opposite sign.
constexpr double overshoot = 0.1;
constexpr int max_backtracks = 40;
/// On a residual: a direction that does not help at 1e-6 of its length does not stem from an approximation of K.
constexpr int max_residual_backtracks = 20;
/// The fraction of the decrease predicted by the linear model that a step must reach. An approximation of K may thus
/// converge linearly by a factor of 0.9.
constexpr double required_part = 0.1;
/// Rounding error of a potential, in units in the last place.
constexpr double last_places = 1e3;
/// A search without success whose residual is below this multiple of the rounding floor has reached rounding errors.
constexpr double near_rounding = 100.0 * rounding_safety;

LineOutcome::Status without_success(const LineStart& start) {
  const bool is_rounding = start.residual <= near_rounding * start.residual_rounding;
  return is_rounding ? LineOutcome::Status::at_rounding : LineOutcome::Status::stalled;
}

/// Rounding error of the difference of Phi(q + alpha d) and Phi(q): the rounding errors of the forces times the
/// displacement from the stage's start, which are of first order while Phi is of second; and a few units in the last
/// place of Phi.
double rounding_of_potential(const LineStart& start, double alpha, double phi) {
  return rounding_safety * start.residual_rounding * (start.displacement + alpha * start.step) +
         last_places * std::numeric_limits<double>::epsilon() * (std::abs(phi) + std::abs(start.measure));
}

}  // namespace

LineOutcome LineSearch::lower_potential(SearchLine& line, const LineStart& start) {
  const double slope = start.slope;
  LineOutcome outcome;
  double alpha = start.first_length;
  bool is_beyond = false;
  for (int i = 0; i < max_backtracks; ++i) {
    const double phi = line.potential(alpha);
    const bool decreases = phi <= start.measure + armijo * alpha * slope;
    const bool undecided =
        !decreases && std::isfinite(phi) && std::abs(phi - start.measure) <= rounding_of_potential(start, alpha, phi);
    if (decreases || undecided) {
      const SearchLine::Residual after = line.residual(alpha);
      const bool wolfe_holds = after.slope >= wolfe * slope && after.slope <= (2 * armijo - 1) * slope;
      const bool is_too_long = decreases && after.slope > -overshoot * slope;
      is_beyond = is_beyond || is_too_long;
      if (went_beyond_ && is_too_long) {
        // Beyond the minimum along the line for the second time: the iteration may oscillate, for instance across the
        // point where friction changes its sign. The minimum of the parabola through the two slopes lies between.
        ++outcome.backtracks;
        alpha *= slope / (slope - after.slope);
        continue;
      }
      if (std::isfinite(after.norm) && (decreases || after.norm < start.residual || wolfe_holds)) {
        went_beyond_ = is_beyond;
        return {LineOutcome::Status::accepted, alpha, phi, after.norm, outcome.backtracks};
      }
    }
    ++outcome.backtracks;
    // Minimum of the parabola through Phi(0), its slope and Phi(alpha), between a tenth and a half of alpha.
    const double parabola =
        std::isfinite(phi) ? -slope * alpha / (2.0 * ((phi - start.measure) / alpha - slope)) : 0.5 * alpha;
    alpha = std::clamp(parabola, 0.1 * alpha, 0.5 * alpha);
  }
  outcome.status = without_success(start);
  return outcome;
}

LineOutcome LineSearch::lower_residual(SearchLine& line, const LineStart& start, Demand demand) {
  const double slope = start.slope;
  LineOutcome outcome;
  double alpha = start.first_length;
  bool is_beyond = false;
  for (int i = 0; i < max_residual_backtracks; ++i) {
    const double length = alpha;
    const SearchLine::Residual after = line.residual(length);
    // With or without a potential, the slope at the end shows whether the step went too far along the direction.
    const bool is_too_long = slope < 0.0 && after.slope > -overshoot * slope;
    is_beyond = is_beyond || is_too_long;
    if ((went_beyond_ || demand == Demand::descent) && is_too_long) {
      ++outcome.backtracks;
      alpha *= slope / (slope - after.slope);
      continue;
    }
    const bool falls = line.merit() <= std::pow(1.0 - required_part * length, 2) * start.measure;
    const bool is_possible = std::isfinite(after.norm) && line.is_admissible();
    bool is_accepted =
        is_possible && (demand != Demand::decrease || falls || after.norm <= rounding_safety * start.residual_rounding);
    if (!is_accepted && is_possible) {
      is_accepted = shortens_correction(line, alpha);
    } else {
      alpha *= 0.5;
    }
    if (is_accepted) {
      went_beyond_ = is_beyond;
      return {LineOutcome::Status::accepted, length, 0.0, after.norm, outcome.backtracks};
    }
    ++outcome.backtracks;
  }
  outcome.status = without_success(start);
  return outcome;
}

bool LineSearch::shortens_correction(SearchLine& line, double& alpha) {
  const double after = line.merit_of_correction(), before = line.merit_of_direction();
  const bool is_usable = std::isfinite(after);
  if (is_usable && after <= std::pow(1.0 - required_part * alpha, 2) * before) return true;
  // A linear equation would leave (1 - alpha) d; the rest grows with alpha^2. This length keeps half of the predicted
  // decrease.
  const double rest = is_usable ? line.merit_of_nonlinear_part(alpha) : 0.0;
  const double next = rest > 0.0 ? 0.5 * alpha * alpha * std::sqrt(before / rest) : 0.0;
  alpha = std::clamp(next, 0.1 * alpha, 0.5 * alpha);
  return false;
}

}  // namespace pliant
