#include "energy/rigid/joint_system.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/SVD>

namespace pliant {
namespace {

/// Singular values below this, of equations with derivatives of length 1, are those of dependent ones.
constexpr double independence = 1e-7;

/// f of each number of the motions.
template <class T, class F, class... Motions>
BodyMotion<T> each(F&& f, const BodyMotion<double>& first, const Motions&... others) {
  BodyMotion<T> result{first.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = f(first.translation[i], others.translation[i]...);
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = f(first.gradient.a[i], others.gradient.a[i]...);
  return result;
}

const BodyMotion<double> at_rest{};

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

BodyMotion<Dual<double>> with_slope(const BodyMotion<double>& value, const BodyMotion<double>& slope) {
  return each<Dual<double>>([](double x, double s) { return Dual<double>(x, s); }, value, slope);
}

JointSystem::JointSystem(std::vector<JointEquation> equations, std::vector<std::size_t> first)
    : equations_(std::move(equations)), scales_(equations_.size(), 1.0), first_(std::move(first)) {}

void JointSystem::scale_rows(Matrix& G) {
  for (Eigen::Index j = 0; j < num_equations(); ++j) {
    const double length = G.row(j).norm();
    if (length == 0.0) continue;
    scales_[static_cast<std::size_t>(j)] /= length;
    G.row(j) /= length;
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

void JointSystem::configuration(std::span<const PartMotion> parts, Along along, const Given& given, Vector& g,
                                Matrix& G) const {
  const auto value = [&](int body) -> const BodyMotion<double>& {
    return body < 0 ? at_rest : parts[static_cast<std::size_t>(body)].value;
  };
  g = Vector::Zero(num_equations());
  G = Matrix::Zero(num_equations(), num_unknowns());
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto row = static_cast<Eigen::Index>(j);
    const std::array<const BodyMotion<double>*, 2> bodies{&value(equation.bodies[0]), &value(equation.bodies[1])};
    g[row] = scales_[j] * equation(*bodies[0], *bodies[1], given[j]);
    for (std::size_t side = 0; side < 2; ++side) {
      if (equation.bodies[side] < 0) continue;
      const auto p = static_cast<std::size_t>(equation.bodies[side]);
      const auto& columns = along == Along::columns ? parts[p].columns : parts[p].test_columns;
      const auto other = with_slope(*bodies[1 - side], at_rest);
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const auto moved = with_slope(*bodies[side], columns[k]);
        const Once result = side == 0 ? equation(moved, other, given[j]) : equation(other, moved, given[j]);
        G(row, static_cast<Eigen::Index>(first_[p] + k)) += scales_[j] * result.slope;
      }
    }
  }
}

void JointSystem::acceleration(std::span<const PartMotion> parts, std::span<const BodyMotion<double>> start,
                               std::span<const BodyMotion<double>> advance, const Given& given, Vector& h,
                               Matrix& G) const {
  using Number = TimeSeries<Once>;
  const auto series = [&](int body, const BodyMotion<double>& slope) {
    if (body < 0) return BodyMotion<Number>{};
    const auto p = static_cast<std::size_t>(body);
    return each<Number>(
        [](double x, double x0, double dx, double s) {
          return Number({x, s}, {x - x0, s}, {x - x0 - dx, s});
        },
        parts[p].value, start[p], advance[p], slope);
  };
  h = Vector::Zero(num_equations());
  G = Matrix::Zero(num_equations(), num_unknowns());
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto row = static_cast<Eigen::Index>(j);
    const std::array<BodyMotion<Number>, 2> bodies{series(equation.bodies[0], at_rest),
                                                   series(equation.bodies[1], at_rest)};
    h[row] = scales_[j] * equation(bodies[0], bodies[1], given[j]).acceleration.value;
    for (std::size_t side = 0; side < 2; ++side) {
      if (equation.bodies[side] < 0) continue;
      const auto p = static_cast<std::size_t>(equation.bodies[side]);
      for (std::size_t k = 0; k < parts[p].columns.size(); ++k) {
        const auto moved = series(equation.bodies[side], parts[p].columns[k]);
        const Number result = side == 0 ? equation(moved, bodies[1], given[j]) : equation(bodies[0], moved, given[j]);
        G(row, static_cast<Eigen::Index>(first_[p] + k)) += scales_[j] * result.acceleration.slope;
      }
    }
  }
}

bool JointSystem::is_on_branch(std::span<const PartMotion> parts, const Given& given) const {
  const auto value = [&](int body) -> const BodyMotion<double>& {
    return body < 0 ? at_rest : parts[static_cast<std::size_t>(body)].value;
  };
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    if (const auto* turn = std::get_if<Turn>(&equation.kind)) {
      const BodyMotion<double>& a = value(equation.bodies[0]);
      const Vector3<double> wanted =
          std::cos(given[j].value) * a.direction(turn->e) + std::sin(given[j].value) * a.direction(turn->f);
      if (!(dot(value(equation.bodies[1]).direction(turn->e), wanted) > 0.0)) return false;
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

JointSystem::Matrix JointSystem::curvature(std::span<const std::vector<BodyMotion<Twice>>> moved, const Given& given,
                                           const Vector& lambda) const {
  Matrix result = Matrix::Zero(num_unknowns(), num_unknowns());
  const BodyMotion<Twice> of_ground{};
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const double force = scales_[j] * lambda[static_cast<Eigen::Index>(j)];
    const auto motion = [&](std::size_t side, std::size_t k, std::size_t l) -> const BodyMotion<Twice>& {
      const int body = equation.bodies[side];
      return body < 0 ? of_ground : moved[static_cast<std::size_t>(body)][k * (num_unknowns_of(body) + 1) + l];
    };
    for (std::size_t side = 0; side < 2; ++side) {
      for (std::size_t other = 0; other < 2; ++other) {
        if (equation.bodies[side] < 0 || equation.bodies[other] < 0) continue;
        const std::size_t row = first_[static_cast<std::size_t>(equation.bodies[side])];
        const std::size_t column = first_[static_cast<std::size_t>(equation.bodies[other])];
        for (std::size_t k = 0; k < num_unknowns_of(equation.bodies[side]); ++k) {
          for (std::size_t l = 0; l < num_unknowns_of(equation.bodies[other]); ++l) {
            const auto at = [&](std::size_t s) -> const BodyMotion<Twice>& {
              return motion(s, s == side ? k + 1 : 0, s == other ? l + 1 : 0);
            };
            result(static_cast<Eigen::Index>(row + k), static_cast<Eigen::Index>(column + l)) +=
                force * equation(at(0), at(1), given[j]).slope.slope;
          }
        }
      }
    }
  }
  return result;
}

// Equations with a part in a sum that vanishes: a left singular vector of the value zero.
std::vector<std::size_t> JointSystem::dependent_joints(const Matrix& G) const {
  std::vector<std::size_t> result;
  if (empty()) return result;
  const Eigen::JacobiSVD<Matrix> svd(G, Eigen::ComputeFullU);
  for (Eigen::Index j = 0; j < G.rows(); ++j) {
    if (j < svd.singularValues().size() && svd.singularValues()[j] > independence) continue;
    for (Eigen::Index e = 0; e < G.rows(); ++e) {
      if (std::abs(svd.matrixU()(e, j)) <= std::sqrt(independence)) continue;
      result.push_back(equations_[static_cast<std::size_t>(e)].joint);
    }
  }
  std::ranges::sort(result);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

// The work of each equation's force under translations and rotations of the second body.
std::vector<JointReaction> JointSystem::reactions(std::span<const PartMotion> parts, const Given& given,
                                                  const Vector& lambda, std::span<const Vector3<double>> points) const {
  const auto value = [&](int body) -> const BodyMotion<double>& {
    return body < 0 ? at_rest : parts[static_cast<std::size_t>(body)].value;
  };
  std::vector<JointReaction> result(points.size());
  for (std::size_t j = 0; j < equations_.size(); ++j) {
    const JointEquation& equation = equations_[j];
    const BodyMotion<double>& b = value(equation.bodies[1]);
    const auto a = with_slope(value(equation.bodies[0]), at_rest);
    const double force = scales_[j] * lambda[static_cast<Eigen::Index>(j)];
    const auto work = [&](const BodyMotion<double>& rate) {
      return force * equation(a, with_slope(b, rate), given[j]).slope;
    };
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
