// The laws' functions, compiled once for the tests.
#include "material/states.hpp"

namespace pliant::testing_states {

double energy(const ElasticLawVariant& law, const Matrix& H) {
  return std::visit([&](const auto& of) { return of.psi(H); }, law);
}

Matrix stress(const ElasticLawVariant& law, const Matrix& H) {
  return std::visit([&](const auto& of) { return of.P(H); }, law);
}

Linearized linearized(const ElasticLawVariant& law, const Matrix& H, const Matrix& dH) {
  return std::visit(
      [&](const auto& of) {
        const auto linearization = of.linearize(H);
        return Linearized{linearization.P, linearization(dH)};
      },
      law);
}

Matrix increment(const ElasticLawVariant& law, const Matrix& H, const Matrix& dH) {
  return linearized(law, H, dH).dP;
}

Tangent<double> stiffness_tensor(const ElasticLawVariant& law, const Matrix& H) {
  return std::visit([&](const auto& of) { return tangent(of, H); }, law);
}

double stiffness(const ElasticLawVariant& law) {
  double largest = 0;
  for (const double a : stiffness_tensor(law, Matrix{})) largest = std::max(largest, std::abs(a));
  return largest;
}

}  // namespace pliant::testing_states
