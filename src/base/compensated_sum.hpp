/// Compensated summation: keeps the digits that a long plain sum loses.
#pragma once

namespace pliant {

/// Kahan's summation of doubles or packs (Higham, Accuracy and Stability of Numerical Algorithms, 4.3).
template <class T>
class CompensatedSum {
 public:
  void add(const T& x) {
    const T y = x - error_;
    const T t = sum_ + y;
    error_ = (t - sum_) - y;
    sum_ = t;
  }
  const T& total() const { return sum_; }

 private:
  T sum_ = 0.0;
  T error_ = 0.0;
};

}  // namespace pliant
