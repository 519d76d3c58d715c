/// A number that counts the operations done with it: what a template costs when it is called with it.
#pragma once

#include "base/vector_math.hpp"

#include <cmath>

namespace pliant {

/// Additions, multiplications, divisions and roots count one each, an exponential twenty (what a vectorised one takes,
/// roughly), a logarithm what its series does. Signs, comparisons and selections are free.
struct Counted {
  double value = 0.0;
  static inline long operations = 0;

  Counted() = default;
  Counted(double x) : value(x) {}

  static Counted counted(double x, long cost = 1) {
    operations += cost;
    return x;
  }
  friend Counted operator+(const Counted& a, const Counted& b) { return Counted::counted(a.value + b.value); }
  friend Counted operator-(const Counted& a, const Counted& b) { return Counted::counted(a.value - b.value); }
  friend Counted operator*(const Counted& a, const Counted& b) { return Counted::counted(a.value * b.value); }
  friend Counted operator/(const Counted& a, const Counted& b) { return Counted::counted(a.value / b.value); }
  friend Counted operator-(const Counted& a) { return -a.value; }
  Counted& operator+=(const Counted& b) { return *this = *this + b; }
  Counted& operator-=(const Counted& b) { return *this = *this - b; }
  Counted& operator*=(const Counted& b) { return *this = *this * b; }
  friend bool operator<(const Counted& a, const Counted& b) { return a.value < b.value; }
  friend bool operator>(const Counted& a, const Counted& b) { return a.value > b.value; }
  friend bool operator<=(const Counted& a, const Counted& b) { return a.value <= b.value; }
  friend bool operator>=(const Counted& a, const Counted& b) { return a.value >= b.value; }
  friend bool operator==(const Counted& a, const Counted& b) { return a.value == b.value; }
  friend bool operator!=(const Counted& a, const Counted& b) { return a.value != b.value; }

  friend Counted sqrt(const Counted& x) { return Counted::counted(std::sqrt(x.value)); }
  friend Counted exp(const Counted& x) { return Counted::counted(std::exp(x.value), 20); }
  friend Counted expm1(const Counted& x) { return Counted::counted(std::expm1(x.value), 20); }
  friend Counted x_minus_log1p(const Counted& x) { return x_minus_log1p_series(x); }
  friend Counted log1p(const Counted& x) { return x - x_minus_log1p_series(x); }
};

/// Operations of `work()`.
template <class Work>
long operations_of(const Work& work) {
  const long before = Counted::operations;
  work();
  return Counted::operations - before;
}

}  // namespace pliant
