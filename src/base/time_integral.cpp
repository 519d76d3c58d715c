#include "base/time_integral.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

constexpr double quadrature_tolerance = 1e-13;
/// Bisections within a panel: a jump is located to 1e-12 of the panel.
constexpr int most_halvings = 40;
/// Most panels whose sums are kept; a longer run has longer panels.
constexpr double most_panels = 1e5;

/// f at both ends and in the middle of an interval.
struct Stretch {
  double from, to, at_from, at_middle, at_to;
  double middle() const { return 0.5 * (from + to); }
  double simpson() const { return (to - from) / 6.0 * (at_from + 4.0 * at_middle + at_to); }
};

double integral(const Expression& f, const Stretch& whole, double scale, int halvings) {
  const auto at = [&](double t) { return f(0.0, 0.0, 0.0, t); };
  const Stretch left{whole.from, whole.middle(), whole.at_from, at(0.5 * (whole.from + whole.middle())),
                     whole.at_middle};
  const Stretch right{whole.middle(), whole.to, whole.at_middle, at(0.5 * (whole.middle() + whole.to)), whole.at_to};
  scale = std::max({scale, std::abs(left.at_middle), std::abs(right.at_middle)});
  const double sum = left.simpson() + right.simpson(), error = (sum - whole.simpson()) / 15.0;
  // A NaN error never becomes small.
  if (halvings == 0 || !(std::abs(error) > quadrature_tolerance * scale * (whole.to - whole.from))) return sum + error;
  return integral(f, left, scale, halvings - 1) + integral(f, right, scale, halvings - 1);
}

double integral(const Expression& f, double from, double to) {
  if (from == to) return 0.0;
  const auto at = [&](double t) { return f(0.0, 0.0, 0.0, t); };
  const Stretch whole{from, to, at(from), at(0.5 * (from + to)), at(to)};
  const double scale = std::max({std::abs(whole.at_from), std::abs(whole.at_middle), std::abs(whole.at_to)});
  return integral(f, whole, scale, most_halvings);
}

}  // namespace

TimeIntegral::TimeIntegral(Expression rate, double end, double panel) : rate_(std::move(rate)) {
  if (!rate_.depends_on_time()) return;
  panel_ = std::max(panel, end / most_panels);
  for (int k = 1; k * panel_ <= end; ++k) {
    totals_.push_back(totals_.back() + integral(rate_, (k - 1) * panel_, k * panel_));
  }
}

double TimeIntegral::operator()(double t) const {
  if (!rate_.depends_on_time()) return rate_(0.0, 0.0, 0.0, 0.0) * t;
  const double last = static_cast<double>(totals_.size() - 1);
  const double k = std::clamp(std::floor(t / panel_), 0.0, last);
  return totals_[static_cast<std::size_t>(k)] + integral(rate_, k * panel_, t);
}

}  // namespace pliant
