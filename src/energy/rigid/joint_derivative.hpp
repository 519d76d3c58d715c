/// The derivative of the equations of joints by the unknowns of bodies, and linear systems with it.
#pragma once

#include <array>
#include <eigen3/Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// Where the derivative of joints' equations has entries: each equation is one between two bodies at most.
class JointPattern {
 public:
  /// A body has no more unknowns than this.
  static constexpr std::size_t most_unknowns = 6;
  struct Columns {
    Eigen::Index first = 0, size = 0;
  };
  /// Two equations and a body that both have: of which of their bodies it is.
  struct Pair {
    std::size_t row = 0, side = 0, other_row = 0, other_side = 0;
  };

  /// `bodies`: of each equation, -1: none; the unknowns of body p have the numbers first[p] .. first[p + 1] - 1.
  JointPattern(std::span<const std::array<int, 2>> bodies, std::span<const std::size_t> first);

  std::size_t num_rows() const { return columns_.size(); }
  Eigen::Index num_columns() const { return num_columns_; }
  const Columns& columns(std::size_t row, std::size_t side) const { return columns_[row][side]; }
  /// In both orders, and each equation with itself.
  const std::vector<Pair>& pairs() const { return pairs_; }
  /// The place of each equation in an order in which those that share a body are close (Cuthill & McKee 1969), and how
  /// far apart they are at most.
  const std::vector<int>& places() const { return places_; }
  int bandwidth() const { return bandwidth_; }

 private:
  void order();

  std::vector<std::array<Columns, 2>> columns_;
  Eigen::Index num_columns_;
  std::vector<Pair> pairs_;
  std::vector<int> places_;
  int bandwidth_ = 0;
};

/// The LU factors of G A, A = D H^T, for two derivatives G and H of the same equations: those of a matrix with a narrow
/// band, as chains and trees of bodies have it (LAPACK's gbtrf). Solutions are NaN where it is singular.
class JointFactors {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  JointFactors() = default;
  /// `band`: the matrix as LAPACK's gbtrf takes it.
  JointFactors(std::shared_ptr<const JointPattern> pattern, std::vector<double> band);

  Matrix solve(const Matrix& b) const { return solve(b, 'N'); }
  Vector solve(const Vector& b) const { return solve(Matrix(b), 'N').col(0); }
  Vector solve_transposed(const Vector& b) const { return solve(Matrix(b), 'T').col(0); }

 private:
  Matrix solve(const Matrix& b, char how) const;

  std::shared_ptr<const JointPattern> pattern_;
  std::vector<double> band_;
  std::vector<int> pivots_;
  bool is_singular_ = false;
};

/// G = dg/dxi, a row for each equation and a column for each unknown; only what the pattern has is kept.
class JointDerivative {
 public:
  using Vector = JointFactors::Vector;
  using Matrix = JointFactors::Matrix;

  JointDerivative() = default;
  explicit JointDerivative(std::shared_ptr<const JointPattern> pattern);  ///< zero

  Eigen::Index rows() const { return pattern_ ? static_cast<Eigen::Index>(pattern_->num_rows()) : 0; }
  Eigen::Index cols() const { return pattern_ ? pattern_->num_columns() : 0; }
  /// The entries of an equation in the unknowns of one of its bodies.
  std::span<double> entries(std::size_t row, std::size_t side);
  std::span<const double> entries(std::size_t row, std::size_t side) const;
  void fill(double value);
  double norm_of_row(std::size_t row) const;
  void scale_row(std::size_t row, double factor);

  Matrix operator*(const Matrix& x) const;
  Vector operator*(const Vector& x) const { return (*this * Matrix(x)).col(0); }
  /// G^T z.
  Matrix transposed_times(const Matrix& z) const;
  Matrix dense() const;
  /// The factors of G D H^T, with the diagonal D.
  JointFactors factors(const Vector& D, const JointDerivative& H) const;
  /// The x with G x = h for which x^T D^-1 x is least.
  Vector smallest_change(const Vector& h, const Vector& D) const;

 private:
  static constexpr std::size_t per_row = 2 * JointPattern::most_unknowns;

  std::shared_ptr<const JointPattern> pattern_;
  std::vector<double> values_;
};

}  // namespace pliant
