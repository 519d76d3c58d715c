#include "time/error_estimate.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

namespace pliant {
namespace {

/// Most rates in a formula: those of order 3, the highest that a method reports, and more than enough beyond.
constexpr std::size_t max_rates = 8;

/// weights_r: integral over [-1, 0] of the polynomial that is 1 at nodes_r and 0 at the other nodes.
void set_integration_weights(std::span<const double> nodes, std::span<double> weights) {
  for (std::size_t r = 0; r < nodes.size(); ++r) {
    std::array<double, max_rates> coefficients{1.0};  // of 1, theta, theta^2, ...
    std::size_t degree = 0;
    for (std::size_t m = 0; m < nodes.size(); ++m) {
      if (m == r) continue;
      const double scale = 1.0 / (nodes[r] - nodes[m]);  // times (theta - nodes_m)
      ++degree;
      for (std::size_t k = degree + 1; k-- > 0;) {
        coefficients[k] = scale * ((k > 0 ? coefficients[k - 1] : 0.0) - nodes[m] * coefficients[k]);
      }
    }
    weights[r] = 0.0;
    for (std::size_t k = 0; k <= degree; ++k) {
      weights[r] += (k % 2 == 0 ? 1.0 : -1.0) * coefficients[k] / static_cast<double>(k + 1);
    }
  }
}

double rms(Vec x) {
  PetscReal norm = 0.0;
  PetscInt size = 0;
  check(VecNorm(x, NORM_2, &norm));
  check(VecGetSize(x, &size));
  return size > 0 ? norm / std::sqrt(static_cast<double>(size)) : 0.0;
}

}  // namespace

LocalError::LocalError(const Method& method, std::shared_ptr<const ConfigurationSpace> space, const StateView& like)
    : num_rates_(std::min(method.order + 1, static_cast<int>(max_rates))), space_(std::move(space)) {
  const auto num_rates = static_cast<std::size_t>(num_rates_);
  check(VecDuplicate(space_ ? like.v : like.q, q_.out()));
  check(VecDuplicate(like.v, v_.out()));
  accelerations_.resize(num_rates - 1);
  for (auto& a : accelerations_) check(VecDuplicate(like.v, a.out()));
  if (!method.stiffly_accurate) {
    for (EmbeddedDifference* e : {&tried_, &accepted_}) {
      check(VecDuplicate(q_.get(), e->q.out()));
      check(VecDuplicate(like.v, e->v.out()));
    }
  }
  if (space_) {
    check(VecDuplicate(like.v, xi_.out()));
    check(VecDuplicate(like.v, change_.out()));
    charted_.resize(num_rates);
    for (auto& rate : charted_) check(VecDuplicate(like.v, rate.out()));
  }
  nodes_.resize(num_rates);
  weights_.resize(num_rates);
  rates_.resize(num_rates);
}

void LocalError::estimate(const History& history, const Stepper& stepper, StepAttempt& attempt) {
  const Method& method = stepper.method();
  const int num_rates_q = std::min(num_rates_, 1 + history.size());
  const int num_rates_v = attempt.a == nullptr ? 0 : std::min(num_rates_q, 1 + num_accelerations_);
  const bool is_sharp = num_rates_v > method.order;
  if (!method.stiffly_accurate && !method.bt_embedded.empty()) {
    difference_embedded(stepper, attempt, attempt.time - history.newest().time);
  } else if (!is_sharp && !method.bt_embedded.empty()) {
    stepper.embedded_difference(q_.get(), v_.get());
    attempt.estimate_order = method.embedded_order;
  } else if (num_rates_v > 0) {
    compare(history, attempt, num_rates_q, num_rates_v);
    attempt.estimate_order = std::min(method.order, num_rates_v);
  } else {
    return;
  }
  attempt.error_q = q_.get();
  attempt.error_v = v_.get();
}

void LocalError::difference_embedded(const Stepper& stepper, StepAttempt& attempt, double dt) {
  stepper.embedded_difference(tried_.q.get(), tried_.v.get());
  tried_.dt = dt;
  check(VecCopy(tried_.q.get(), q_.get()));
  check(VecCopy(tried_.v.get(), v_.get()));
  attempt.estimate_order = stepper.method().embedded_order;
  if (accepted_.dt == 0.0) return;
  attempt.estimate_order += 1;
  const double growth = std::pow(dt / accepted_.dt, attempt.estimate_order);
  check(VecAXPY(q_.get(), -growth, accepted_.q.get()));
  check(VecAXPY(v_.get(), -growth, accepted_.v.get()));
}

void LocalError::compare(const History& history, StepAttempt& attempt, int num_rates_q, int num_rates_v) {
  const State& newest = history.newest();
  const double dt = attempt.time - newest.time;
  const auto subtract_integral = [&](Vec error, int num_rates) {
    const auto m = static_cast<std::size_t>(num_rates);
    nodes_[0] = 0.0;
    for (int r = 1; r < num_rates; ++r) nodes_[static_cast<std::size_t>(r)] = (history[r - 1].time - attempt.time) / dt;
    set_integration_weights(std::span(nodes_).first(m), std::span(weights_).first(m));
    for (std::size_t r = 0; r < m; ++r) weights_[r] *= -dt;
    check(VecMAXPY(error, num_rates, weights_.data(), rates_.data()));
  };
  for (int r = 0; r < num_rates_q; ++r) {
    Vec& rate = rates_[static_cast<std::size_t>(r)];
    rate = space_ ? rate_of_coordinates(history, attempt, r) : (r == 0 ? attempt.v : history[r - 1].v.get());
  }
  if (space_) {
    space_->difference(newest.q.get(), attempt.q, q_.get());
  } else {
    check(VecWAXPY(q_.get(), -1.0, newest.q.get(), attempt.q));
  }
  subtract_integral(q_.get(), num_rates_q);

  rates_[0] = attempt.a;
  for (std::size_t r = 1; r < static_cast<std::size_t>(num_rates_v); ++r) rates_[r] = accelerations_[r - 1].get();
  check(VecWAXPY(v_.get(), -1.0, newest.v.get(), attempt.v));
  subtract_integral(v_.get(), num_rates_v);
}

// xi' of the r-th newest state in coordinates around q_n, from velocity(xi, xi') = v by iteration: the velocity differs
// from xi' by O(xi xi'), so that each of the iterations gains one power of the step.
Vec LocalError::rate_of_coordinates(const History& history, const StepAttempt& attempt, int r) {
  const Vec q = r == 0 ? attempt.q : history[r - 1].q.get(), v = r == 0 ? attempt.v : history[r - 1].v.get();
  if (r == 1) return v;
  const Vec rate = charted_[static_cast<std::size_t>(r)].get();
  space_->difference(history.newest().q.get(), q, xi_.get());
  check(VecCopy(v, rate));
  for (int i = 0; i < num_rates_; ++i) {
    space_->velocity(xi_.get(), rate, change_.get());
    check(VecAYPX(change_.get(), -1.0, v));
    check(VecAXPY(rate, 1.0, change_.get()));
  }
  return rate;
}

void LocalError::accept(const StepAttempt& attempt) {
  std::swap(tried_, accepted_);
  if (attempt.a == nullptr) {
    num_accelerations_ = 0;
    return;
  }
  std::rotate(accelerations_.begin(), accelerations_.end() - 1, accelerations_.end());
  check(VecCopy(attempt.a, accelerations_.front().get()));
  num_accelerations_ = std::min(num_accelerations_ + 1, static_cast<int>(accelerations_.size()));
}

void LocalError::restart() {
  num_accelerations_ = 0;
  accepted_.dt = 0.0;
}

void LocalError::keep(Archive& archive) {
  archive.number("num_accelerations", num_accelerations_);
  for (int i = 0; i < num_accelerations_; ++i) {
    archive.vector("a" + std::to_string(i), Entries::nodes, accelerations_.at(static_cast<std::size_t>(i)).get());
  }
  archive.number("embedded_dt", accepted_.dt);
  if (accepted_.dt == 0.0) return;
  archive.vector("embedded_q", Entries::nodes, accepted_.q.get());
  archive.vector("embedded_v", Entries::nodes, accepted_.v.get());
}

ErrorNorm::ErrorNorm(const Tolerances& tolerances, const StateView& initial)
    : tolerances_(tolerances), largest_q_(rms(initial.q)), largest_v_(rms(initial.v)) {}

double ErrorNorm::operator()(const StepAttempt& attempt) const {
  assert(attempt.error_q != nullptr && attempt.error_v != nullptr);
  const auto size = [&](Vec error, double absolute, double largest) {
    const double error_rms = rms(error);
    return error_rms > 0.0 ? error_rms / (absolute + tolerances_.relative * largest) : 0.0;
  };
  return std::max(size(attempt.error_q, tolerances_.absolute, std::max(largest_q_, rms(attempt.q))),
                  size(attempt.error_v, tolerances_.absolute_velocity, std::max(largest_v_, rms(attempt.v))));
}

void ErrorNorm::accept(const StepAttempt& attempt) {
  largest_q_ = std::max(largest_q_, rms(attempt.q));
  largest_v_ = std::max(largest_v_, rms(attempt.v));
}

void ErrorNorm::keep(Archive& archive) {
  archive.number("largest_q", largest_q_);
  archive.number("largest_v", largest_v_);
}

}  // namespace pliant
