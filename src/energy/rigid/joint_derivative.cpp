#include "energy/rigid/joint_derivative.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

// LAPACK, which PETSc stands on; Fortran passes the lengths of texts last.
extern "C" {
void dgbtrf_(const int* m, const int* n, const int* kl, const int* ku, double* ab, const int* ldab, int* ipiv,
             int* info);
void dgbtrs_(const char* trans, const int* n, const int* kl, const int* ku, const int* nrhs, const double* ab,
             const int* ldab, const int* ipiv, double* b, const int* ldb, int* info, std::size_t length_of_trans);
}

namespace pliant {
namespace {

int leading_dimension(const JointPattern& pattern) {
  return 3 * pattern.bandwidth() + 1;
}

}  // namespace

JointPattern::JointPattern(std::span<const std::array<int, 2>> bodies, std::span<const std::size_t> first)
    : columns_(bodies.size()), num_columns_(static_cast<Eigen::Index>(first.back())), places_(bodies.size()) {
  std::vector<std::vector<std::array<std::size_t, 2>>> of_body(first.size() - 1);
  for (std::size_t row = 0; row < bodies.size(); ++row) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (bodies[row][side] < 0) continue;
      const auto p = static_cast<std::size_t>(bodies[row][side]);
      columns_[row][side] = {static_cast<Eigen::Index>(first[p]), static_cast<Eigen::Index>(first[p + 1] - first[p])};
      of_body[p].push_back({row, side});
    }
  }
  for (const auto& rows : of_body) {
    for (const auto& [row, side] : rows) {
      for (const auto& [other_row, other_side] : rows) pairs_.push_back({row, side, other_row, other_side});
    }
  }
  order();
}

void JointPattern::order() {
  const std::size_t n = num_rows();
  if (n == 0) return;
  std::vector<std::vector<std::size_t>> near(n);
  for (const Pair& pair : pairs_) near[pair.row].push_back(pair.other_row);
  for (auto& rows : near) {
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  std::vector<std::size_t> by_degree(n), sequence;
  std::iota(by_degree.begin(), by_degree.end(), std::size_t{0});
  const auto has_fewer = [&](std::size_t a, std::size_t b) { return near[a].size() < near[b].size(); };
  std::ranges::stable_sort(by_degree, has_fewer);
  std::vector<char> is_placed(n, 0);
  for (const std::size_t start : by_degree) {
    if (is_placed[start]) continue;
    is_placed[start] = 1;
    std::size_t next = sequence.size();
    sequence.push_back(start);
    for (; next < sequence.size(); ++next) {
      std::vector<std::size_t> found;
      for (const std::size_t row : near[sequence[next]]) {
        if (!is_placed[row]) found.push_back(row);
        is_placed[row] = 1;
      }
      std::ranges::stable_sort(found, has_fewer);
      sequence.insert(sequence.end(), found.begin(), found.end());
    }
  }
  for (std::size_t k = 0; k < n; ++k) places_[sequence[k]] = static_cast<int>(k);
  for (const Pair& pair : pairs_) bandwidth_ = std::max(bandwidth_, places_[pair.row] - places_[pair.other_row]);
}

JointFactors::JointFactors(std::shared_ptr<const JointPattern> pattern, std::vector<double> band)
    : pattern_(std::move(pattern)), band_(std::move(band)), pivots_(pattern_->num_rows()) {
  const int n = static_cast<int>(pattern_->num_rows()), width = pattern_->bandwidth(),
            ld = leading_dimension(*pattern_);
  int info = 0;
  if (n > 0) dgbtrf_(&n, &n, &width, &width, band_.data(), &ld, pivots_.data(), &info);
  is_singular_ = info != 0;
}

JointFactors::Matrix JointFactors::solve(const Matrix& b, char how) const {
  if (is_singular_) return Matrix::Constant(b.rows(), b.cols(), std::numeric_limits<double>::quiet_NaN());
  if (b.rows() == 0) return b;
  const auto& places = pattern_->places();
  Matrix x(b.rows(), b.cols());
  for (Eigen::Index k = 0; k < b.cols(); ++k) {
    for (Eigen::Index j = 0; j < b.rows(); ++j) x(places[static_cast<std::size_t>(j)], k) = b(j, k);
  }
  const int n = static_cast<int>(b.rows()), width = pattern_->bandwidth(), ld = leading_dimension(*pattern_),
            num_columns = static_cast<int>(b.cols());
  int info = 0;
  dgbtrs_(&how, &n, &width, &width, &num_columns, band_.data(), &ld, pivots_.data(), x.data(), &n, &info, 1);
  Matrix result(b.rows(), b.cols());
  for (Eigen::Index k = 0; k < b.cols(); ++k) {
    for (Eigen::Index j = 0; j < b.rows(); ++j) result(j, k) = x(places[static_cast<std::size_t>(j)], k);
  }
  return result;
}

JointDerivative::JointDerivative(std::shared_ptr<const JointPattern> pattern)
    : pattern_(std::move(pattern)), values_(per_row * pattern_->num_rows(), 0.0) {}

std::span<double> JointDerivative::entries(std::size_t row, std::size_t side) {
  const auto size = static_cast<std::size_t>(pattern_->columns(row, side).size);
  return std::span(values_).subspan(per_row * row + JointPattern::most_unknowns * side, size);
}

std::span<const double> JointDerivative::entries(std::size_t row, std::size_t side) const {
  const auto size = static_cast<std::size_t>(pattern_->columns(row, side).size);
  return std::span(values_).subspan(per_row * row + JointPattern::most_unknowns * side, size);
}

void JointDerivative::fill(double value) {
  std::ranges::fill(values_, value);
}

double JointDerivative::norm_of_row(std::size_t row) const {
  double squares = 0.0;
  for (std::size_t side = 0; side < 2; ++side) {
    for (const double value : entries(row, side)) squares += value * value;
  }
  return std::sqrt(squares);
}

void JointDerivative::scale_row(std::size_t row, double factor) {
  for (std::size_t side = 0; side < 2; ++side) {
    for (double& value : entries(row, side)) value *= factor;
  }
}

JointDerivative::Matrix JointDerivative::operator*(const Matrix& x) const {
  Matrix result = Matrix::Zero(rows(), x.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    const double* const column = x.col(k).data();
    for (std::size_t row = 0; row < static_cast<std::size_t>(rows()); ++row) {
      double sum = 0.0;
      for (std::size_t side = 0; side < 2; ++side) {
        const double* at = column + pattern_->columns(row, side).first;
        for (const double value : entries(row, side)) sum += value * *at++;
      }
      result(static_cast<Eigen::Index>(row), k) = sum;
    }
  }
  return result;
}

JointDerivative::Matrix JointDerivative::transposed_times(const Matrix& z) const {
  Matrix result = Matrix::Zero(cols(), z.cols());
  for (Eigen::Index k = 0; k < z.cols(); ++k) {
    double* const column = result.col(k).data();
    for (std::size_t row = 0; row < static_cast<std::size_t>(rows()); ++row) {
      const double factor = z(static_cast<Eigen::Index>(row), k);
      for (std::size_t side = 0; side < 2; ++side) {
        double* at = column + pattern_->columns(row, side).first;
        for (const double value : entries(row, side)) *at++ += factor * value;
      }
    }
  }
  return result;
}

JointDerivative::Matrix JointDerivative::dense() const {
  return *this * Matrix(Matrix::Identity(cols(), cols()));
}

JointFactors JointDerivative::factors(const Vector& D, const JointDerivative& H) const {
  const auto ld = static_cast<std::size_t>(leading_dimension(*pattern_));
  const int diagonal = 2 * pattern_->bandwidth();
  std::vector<double> band(ld * pattern_->num_rows(), 0.0);
  for (const auto& [row, side, other_row, other_side] : pattern_->pairs()) {
    const auto of_row = entries(row, side), of_other = H.entries(other_row, other_side);
    const double* const weights = D.data() + pattern_->columns(row, side).first;
    double sum = 0.0;
    for (std::size_t c = 0; c < of_row.size(); ++c) sum += of_row[c] * weights[c] * of_other[c];
    const int i = pattern_->places()[row], j = pattern_->places()[other_row];
    band[static_cast<std::size_t>(diagonal + i - j) + ld * static_cast<std::size_t>(j)] += sum;
  }
  return {pattern_, std::move(band)};
}

JointDerivative::Vector JointDerivative::smallest_change(const Vector& h, const Vector& D) const {
  return D.asDiagonal() * Vector(transposed_times(factors(D, *this).solve(h)));
}

}  // namespace pliant
