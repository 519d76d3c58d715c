#include "study/relaxation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace pliant {
namespace {

constexpr int num_points = 24;

/// Gauss-Legendre quadrature in (-1, 1): the positive points with their weights. Source: Abramowitz & Stegun (1964),
/// table 25.4.
struct GaussPoint {
  double place, weight;
};
constexpr std::array<GaussPoint, 4> gauss{{{0.1834346424956498, 0.3626837833783620},
                                           {0.5255324099163290, 0.3137066458778873},
                                           {0.7966664774136267, 0.2223810344533745},
                                           {0.9602898564975363, 0.1012285362903763}}};

}  // namespace

RelaxationHistory::RelaxationHistory(double amount, const std::optional<double>& rate)
    : amount_(amount), duration_(rate ? std::abs(amount - 1.0) / *rate : 0.0) {
  if (duration_ == 0.0) {
    amounts_.push_back(amount);
    return;
  }
  for (int j = 0; j < num_points; ++j) {
    amounts_.push_back(1.0 + (amount - 1.0) * 0.5 * (1.0 - std::cos(std::numbers::pi * j / (num_points - 1))));
  }
}

double RelaxationHistory::amount_at(double t) const {
  return t >= duration_ ? amount_ : 1.0 + (amount_ - 1.0) * t / duration_;
}

void RelaxationHistory::add_stress(double t, double factor, std::vector<double>& weights) const {
  if (amounts_.size() == 1) {
    weights[0] += factor / amount_;
    return;
  }
  // The barycentric formula (Berrut & Trefethen, SIAM Rev. 46 (2004) 501-517, equation 5.4).
  const double amount = amount_at(t);
  std::array<double, num_points> part{};
  double sum = 0.0;
  for (std::size_t j = 0; j < amounts_.size(); ++j) {
    const double distance = amount - amounts_[j];
    if (distance == 0.0) {
      weights[j] += factor / amounts_[j];
      return;
    }
    const double end = j == 0 || j + 1 == amounts_.size() ? 0.5 : 1.0;
    part[j] = (j % 2 == 0 ? end : -end) / distance;
    sum += part[j];
  }
  for (std::size_t j = 0; j < amounts_.size(); ++j) weights[j] += factor * part[j] / (sum * amounts_[j]);
}

RelaxationHistory::Convolution RelaxationHistory::convolution(double t, double relaxation_time) const {
  Convolution result{std::vector<double>(amounts_.size(), 0.0), std::vector<double>(amounts_.size(), 0.0)};
  const double until = std::min(t, duration_), tau = relaxation_time;
  add_stress(until, 1.0, result.value);
  // Panels that grow with the distance from the end resolve the exponential, whatever its time.
  constexpr double first_panel = 0.5, growth = 1.6, negligible = 60.0;
  double near = 0.0, length = first_panel * tau;
  for (; near < until && near < negligible * tau; near += length, length *= growth) {
    const double far = std::min(near + length, until), half = 0.5 * (far - near);
    for (const GaussPoint& point : gauss) {
      for (const double side : {-1.0, 1.0}) {
        const double age = near + half * (1.0 + side * point.place);
        const double kernel = half * point.weight * std::exp(-age / tau) / tau;
        add_stress(until - age, -kernel, result.value);
        add_stress(until - age, -kernel * (age / tau - 1.0) / tau, result.by_time);
      }
    }
  }
  if (t > duration_) {
    const double age = t - duration_, decay = std::exp(-age / tau);
    for (std::size_t j = 0; j < amounts_.size(); ++j) {
      result.by_time[j] = decay * (result.by_time[j] + result.value[j] * age / (tau * tau));
      result.value[j] *= decay;
    }
  }
  return result;
}

RelaxationWeights RelaxationHistory::weights(double t, std::span<const PronyBranch> branches) const {
  const double amount = amount_at(t);
  RelaxationWeights result{std::vector<double>(amounts_.size(), 0.0), {}, {}};
  add_stress(t, amount, result.total);
  for (const PronyBranch& branch : branches) {
    Convolution of = convolution(t, branch.relaxation_time);
    for (std::size_t j = 0; j < amounts_.size(); ++j) {
      result.total[j] += amount * branch.ratio * of.value[j];
      of.value[j] *= amount;
      of.by_time[j] *= amount * branch.ratio;
    }
    result.by_ratio.push_back(std::move(of.value));
    result.by_time.push_back(std::move(of.by_time));
  }
  return result;
}

}  // namespace pliant
