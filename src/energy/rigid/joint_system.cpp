#include "energy/rigid/joint_system.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/SVD>

namespace pliant {
namespace {

/// Singular values below this, of equations with derivatives of length 1, are those of dependent ones.
constexpr double independence = 1e-7;

/// f of each number of the motions.
template <class T, class F, class First, class... Motions>
BodyMotion<T> each(F&& f, const BodyMotion<First>& first, const Motions&... others) {
  BodyMotion<T> result{first.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = f(first.translation[i], others.translation[i]...);
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = f(first.gradient.a[i], others.gradient.a[i]...);
  return result;
}

const BodyMotion<double> at_rest{};

const BodyMotion<double>& value_of(int body, std::span<const PartMotion> parts) {
  return body < 0 ? at_rest : parts[static_cast<std::size_t>(body)].value;
}

/// The rotation about an axis through a point, as the rate of a body's motion.
BodyMotion<double> rotation_about(const Vector3<double>& axis, const Vector3<double>& point,
                                  const BodyMotion<double>& body) {
  BodyMotion<double> rate{body.centre, cross(axis, body.point(body.centre) - point), {}};
  for (std::size_t k = 0; k < 3; ++k) {
    Vector3<double> e{};
    e[k] = 1.0;
    const Vector3<double> column = cross(axis, body.direction(e));
    for (std::size_t i = 0; i < 3; ++i) rate.gradient(static_cast<int>(i), static_cast<int>(k)) = column[i];
  }
  return rate;
}

}  // namespace

BodyMotion<double> sum_of(double a, const BodyMotion<double>& x, const BodyMotion<double>& y) {
  return each<double>([a](double p, double q) { return a * p + q; }, x, y);
}

void add(double a, const BodyMotion<double>& x, BodyMotion<double>& y) {
  for (std::size_t i = 0; i < 3; ++i) y.translation[i] += a * x.translation[i];
  for (std::size_t i = 0; i < 9; ++i) y.gradient.a[i] += a * x.gradient.a[i];
}

JointSystem::JointSystem(std::vector<JointEquation> equations, std::vector<std::size_t> first)
    : equations_(std::move(equations)), scales_(equations_.size(), 1.0), first_(std::move(first)) {
  std::vector<std::array<int, 2>> bodies;
  for (const JointEquation& equation : equations_) bodies.push_back(equation.bodies);
  pattern_ = std::make_shared<JointPattern>(bodies, first_);
}

bool JointSystem::is_length(Eigen::Index equation) const {
  const auto& kind = equations_[static_cast<std::size_t>(equation)].kind;
  return !std::holds_alternative<Perpendicularity>(kind) && !std::holds_alternative<Turn>(kind);
}

bool JointSystem::is_driven() const {
  return std::ranges::any_of(equations_, [](const JointEquation& equation) { return equation.given() != nullptr; });
}

std::size_t JointSystem::num_joints() const {
  std::size_t number = 0;
  for (const JointEquation& equation : equations_) number = std::max(number, equation.joint + 1);
  return number;
}

void JointSystem::scale_rows(JointDerivative& G) {
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const double length = G.norm_of_row(j);
    if (length == 0.0) continue;
    scales_[j] /= length;
    G.scale_row(j, 1.0 / length);
  }
}

JointSystem::Given JointSystem::given(double time, double time_scale, double unit, double factor, Side side) const {
  Given result;
  for (const JointEquation& equation : equations_) {
    TimeSeries<double>& series = result.emplace_back();
    const Expression* const formula = equation.given();
    if (formula == nullptr) continue;
    const GivenDisplacement displacement{{*formula, std::nullopt, std::nullopt}};
    const Kinematics k = GivenKinematics(displacement, time, time_scale, factor, side)(0, {});
    series = {k.u, unit * k.v, unit * unit * k.a};
  }
  return result;
}

void JointSystem::put_row(std::size_t row, const JointEquation::Forces& forces, std::span<const PartMotion> parts,
                          Along along, JointDerivative& G) const {
  for (std::size_t side = 0; side < 2; ++side) {
    if (equations_[row].bodies[side] < 0) continue;
    const auto p = static_cast<std::size_t>(equations_[row].bodies[side]);
    const auto& columns = along == Along::columns ? parts[p].columns : parts[p].test_columns;
    const auto entries = G.entries(row, side);
    for (std::size_t k = 0; k < columns.size(); ++k) entries[k] = scales_[row] * forces[side].along(columns[k]);
  }
}

void JointSystem::configuration(std::span<const PartMotion> parts, Along along, const Given& given, Vector& g,
                                JointDerivative& G) const {
  g = Vector::Zero(num_equations());
  G = JointDerivative(pattern_);
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto row = static_cast<Eigen::Index>(j);
    const JointEquation::Motions bodies{&value_of(equation.bodies[0], parts), &value_of(equation.bodies[1], parts)};
    g[row] = scales_[j] * equation(*bodies[0], *bodies[1], given[j]);
    put_row(j, equation.gradient(bodies, given[j]), parts, along, G);
  }
}

void JointSystem::acceleration(std::span<const PartMotion> parts, std::span<const BodyMotion<double>> start,
                               std::span<const BodyMotion<double>> advance, const Given& given, Vector& h,
                               JointDerivative& G) const {
  using Number = TimeSeries<double>;
  std::vector<BodyMotion<Number>> series;
  std::vector<BodyMotion<double>> once, twice;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    series.push_back(each<Number>([](double x, double x0, double dx) { return Number(x, x - x0, x - x0 - dx); },
                                  parts[p].value, start[p], advance[p]));
    once.push_back(each<double>([](const Number& x) { return x.value + x.rate; }, series[p]));
    twice.push_back(each<double>([](const Number& x) { return x.value + 2.0 * x.rate + x.acceleration; }, series[p]));
  }
  const BodyMotion<Number> of_ground{};
  const auto of = [](int body, const auto& motions, const auto& ground) {
    return body < 0 ? &ground : &motions[static_cast<std::size_t>(body)];
  };
  h = Vector::Zero(num_equations());
  G = JointDerivative(pattern_);
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto row = static_cast<Eigen::Index>(j);
    const auto& [a, b] = equation.bodies;
    h[row] = scales_[j] * equation(*of(a, series, of_ground), *of(b, series, of_ground), given[j]).acceleration;
    put_row(j,
            equation.gradient_of_acceleration({&value_of(a, parts), &value_of(b, parts)},
                                              {of(a, once, at_rest), of(b, once, at_rest)},
                                              {of(a, twice, at_rest), of(b, twice, at_rest)}, given[j]),
            parts, Along::columns, G);
  }
}

bool JointSystem::is_on_branch(std::span<const PartMotion> parts, const Given& given) const {
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    if (const auto* turn = std::get_if<Turn>(&equation.kind)) {
      const BodyMotion<double>& a = value_of(equation.bodies[0], parts);
      const Vector3<double> wanted =
          std::cos(given[j].value) * a.direction(turn->e) + std::sin(given[j].value) * a.direction(turn->f);
      if (!(dot(value_of(equation.bodies[1], parts).direction(turn->e), wanted) > 0.0)) return false;
    }
    const auto* distance = std::get_if<Distance>(&equation.kind);
    if (distance != nullptr && distance->given && !(distance->at_start + given[j].value > 0.0)) return false;
  }
  return true;
}

JointSystem::Vector JointSystem::rates(std::span<const BodyMotion<double>> values,
                                       std::span<const BodyMotion<double>> rates, const Given& given) const {
  using Number = TimeSeries<double>;
  const auto series = [&](int body) {
    if (body < 0) return BodyMotion<Number>{};
    const auto p = static_cast<std::size_t>(body);
    return each<Number>([](double x, double rate) { return Number(x, rate, 0.0); }, values[p], rates[p]);
  };
  Vector result = Vector::Zero(num_equations());
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const auto& [first, second] = equations_[j].bodies;
    result[static_cast<Eigen::Index>(j)] = scales_[j] * equations_[j](series(first), series(second), given[j]).rate;
  }
  return result;
}

JointSystem::Matrix JointSystem::curvature(std::span<const PartMotion> parts,
                                           std::span<const std::vector<BodyMotion<double>>> bends, const Given& given,
                                           const Vector& lambda) const {
  Matrix result = Matrix::Zero(num_unknowns(), num_unknowns());
  std::vector<MotionForce> on_parts(parts.size());
  std::vector<BodyMotion<double>> resting;
  for (const PartMotion& part : parts) resting.push_back({part.value.centre, {}, {}});
  const auto rest_of = [&](int body) { return body < 0 ? &at_rest : &resting[static_cast<std::size_t>(body)]; };
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const double force = scales_[j] * lambda[static_cast<Eigen::Index>(j)];
    const auto gradient =
        equation.gradient({&value_of(equation.bodies[0], parts), &value_of(equation.bodies[1], parts)}, given[j]);
    for (std::size_t moved = 0; moved < 2; ++moved) {
      if (equation.bodies[moved] < 0) continue;
      const auto p = static_cast<std::size_t>(equation.bodies[moved]);
      on_parts[p].add(force, gradient[moved]);
      for (std::size_t l = 0; l < parts[p].columns.size(); ++l) {
        JointEquation::Motions moves{rest_of(equation.bodies[0]), rest_of(equation.bodies[1])};
        moves[moved] = &parts[p].columns[l];
        const auto change = equation.change_of_gradient(moves, given[j]);
        for (std::size_t side = 0; side < 2; ++side) {
          if (equation.bodies[side] < 0) continue;
          const auto other = static_cast<std::size_t>(equation.bodies[side]);
          for (std::size_t k = 0; k < parts[other].test_columns.size(); ++k) {
            result(static_cast<Eigen::Index>(first_[other] + k), static_cast<Eigen::Index>(first_[p] + l)) +=
                force * change[side].along(parts[other].test_columns[k]);
          }
        }
      }
    }
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::size_t n = first_[p + 1] - first_[p];
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t l = 0; l < n; ++l) {
        result(static_cast<Eigen::Index>(first_[p] + k), static_cast<Eigen::Index>(first_[p] + l)) +=
            on_parts[p].along(bends[p][k * n + l]);
      }
    }
  }
  return result;
}

// Equations with a part in a sum that vanishes: a left singular vector of the value zero.
JointSystem::Dependent JointSystem::dependent_joints(const JointDerivative& G) const {
  Dependent result;
  if (empty()) return result;
  const Eigen::JacobiSVD<Matrix> svd(G.dense(), Eigen::ComputeFullU);
  for (Eigen::Index j = 0; j < G.rows(); ++j) {
    if (j < svd.singularValues().size() && svd.singularValues()[j] > independence) continue;
    ++result.number;
    for (Eigen::Index e = 0; e < G.rows(); ++e) {
      if (std::abs(svd.matrixU()(e, j)) <= std::sqrt(independence)) continue;
      result.joints.push_back(equations_[static_cast<std::size_t>(e)].joint);
    }
  }
  std::ranges::sort(result.joints);
  result.joints.erase(std::unique(result.joints.begin(), result.joints.end()), result.joints.end());
  return result;
}

// The work of each equation's force under translations and rotations of the second body.
std::vector<JointReaction> JointSystem::reactions(std::span<const PartMotion> parts, const Given& given,
                                                  const Vector& lambda, std::span<const Vector3<double>> points) const {
  std::vector<JointReaction> result(points.size());
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const BodyMotion<double>& b = value_of(equation.bodies[1], parts);
    const double force = scales_[j] * lambda[static_cast<Eigen::Index>(j)];
    const MotionForce on_b = equation.gradient({&value_of(equation.bodies[0], parts), &b}, given[j])[1];
    const auto work = [&](const BodyMotion<double>& rate) { return force * on_b.along(rate); };
    const Vector3<double> place = b.point(points[equation.joint]);
    for (std::size_t i = 0; i < 3; ++i) {
      Vector3<double> axis{};
      axis[i] = 1.0;
      result[equation.joint].force[i] += work({b.centre, axis, {}});
      result[equation.joint].torque[i] += work(rotation_about(axis, place, b));
    }
  }
  return result;
}

}  // namespace pliant
