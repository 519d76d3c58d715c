/// When frames of the result are due.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace pliant {

/// Frames are due at multiples of the output interval, at the first step at or after them.
class FrameSchedule {
 public:
  /// Multiples up to a time at which no further frame is due. Without an interval every step is a frame.
  FrameSchedule(std::optional<double> interval, double start) : interval_(interval), last_(reached(start)) {}
  bool due(double time) {
    if (!interval_) return true;
    const long long now = reached(time);
    return std::exchange(last_, std::max(last_, now)) < now;
  }

 private:
  long long reached(double time) const {
    return interval_ ? static_cast<long long>(std::floor(time / *interval_ * (1.0 + 1e-12) + 1e-9)) : 0;
  }
  std::optional<double> interval_;
  long long last_;
};

}  // namespace pliant
