#include "energy/constraint/mechanism.hpp"

#include "energy/given_motion.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/QR>
#include <eigen3/Eigen/SVD>
#include <limits>

namespace pliant {
namespace {

constexpr auto no_part = static_cast<std::size_t>(-1);
/// Relative to the size: equations that hold to this tolerance are solved.
constexpr double tolerance = 1e-14;
/// Singular values below this, of equations with derivatives of length 1, are those of dependent ones.
constexpr double independence = 1e-7;
/// Columns that keep less than this of their length give way to others.
constexpr double least_kept = 0.1;

template <class T>
BodyMotion<T> combined(const BodyMotion<double>& value, const BodyMotion<double>& slope);

template <>
BodyMotion<Dual<double>> combined(const BodyMotion<double>& value, const BodyMotion<double>& slope) {
  BodyMotion<Dual<double>> result{value.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = {value.translation[i], slope.translation[i]};
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = {value.gradient.a[i], slope.gradient.a[i]};
  return result;
}

/// f of each number of the motions.
template <class T, class F, class... Motions>
BodyMotion<T> each(F&& f, const BodyMotion<double>& first, const Motions&... others) {
  BodyMotion<T> result{first.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = f(first.translation[i], others.translation[i]...);
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = f(first.gradient.a[i], others.gradient.a[i]...);
  return result;
}

BodyMotion<double> sum_of(double a, const BodyMotion<double>& x, const BodyMotion<double>& y) {
  return each<double>([a](double p, double q) { return a * p + q; }, x, y);
}

const BodyMotion<double> at_rest{};

}  // namespace

Mechanism::Mechanism(const NodeLayout& layout, std::vector<std::unique_ptr<RigidPart>> parts,
                     std::vector<JointEquation> equations)
    : comm_(layout.comm),
      parts_(std::move(parts)),
      equations_(std::move(equations)),
      scales_(equations_.size(), 1.0),
      first_{0},
      part_of_node_(static_cast<std::size_t>(layout.num_owned_nodes), no_part) {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    first_.push_back(first_.back() + parts_[p]->hosts().size());
    hosts_.insert(hosts_.end(), parts_[p]->hosts().begin(), parts_[p]->hosts().end());
    for (const PetscInt a : parts_[p]->nodes()) {
      nodes_.push_back(a);
      part_of_node_[static_cast<std::size_t>(a)] = p;
    }
    size_ = std::max(size_, parts_[p]->size());
  }
  // The reference configuration, at the start of the run.
  reference_ = Vector::Zero(static_cast<Eigen::Index>(hosts_.size()));
  given_ = given(0.0, 1.0, 1.0, 1.0, Side::after);
  Vector g;
  evaluate_configuration(motions(reference_), Along::columns, given_, g, G_ref_);
  for (std::size_t j = 0; j < num_equations(); ++j) {
    const double length = G_ref_.row(static_cast<Eigen::Index>(j)).norm();
    if (length > 0.0) scales_[j] = 1.0 / length;
    G_ref_.row(static_cast<Eigen::Index>(j)) *= scales_[j];
  }
  choose_columns(G_ref_);
  preferred_ = columns_;
  hosts_.resize(static_cast<std::size_t>(columns_.cols()));
}

// Equations with a part in a sum that vanishes: a left singular vector of the value zero.
std::vector<std::size_t> Mechanism::dependent_joints() const {
  std::vector<std::size_t> result;
  if (equations_.empty()) return result;
  const Eigen::JacobiSVD<Matrix> svd(G_ref_, Eigen::ComputeFullU);
  for (Eigen::Index j = 0; j < G_ref_.rows(); ++j) {
    if (j < svd.singularValues().size() && svd.singularValues()[j] > independence) continue;
    for (std::size_t e = 0; e < num_equations(); ++e) {
      if (std::abs(svd.matrixU()(static_cast<Eigen::Index>(e), j)) > std::sqrt(independence)) {
        result.push_back(equations_[e].joint);
      }
    }
  }
  std::ranges::sort(result);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

void Mechanism::set_rigidity(Rigidity rigidity) {
  rigidity_ = rigidity;
  for (const auto& part : parts_) part->set_rigidity(rigidity);
}

std::span<const double> Mechanism::of_part(const Vector& xi, std::size_t part) const {
  return std::span(xi.data(), static_cast<std::size_t>(xi.size()))
      .subspan(first_[part], first_[part + 1] - first_[part]);
}

std::vector<Mechanism::PartMotion> Mechanism::motions(const Vector& xi) const {
  std::vector<PartMotion> result;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto unknowns = of_part(xi, p);
    PartMotion& motion = result.emplace_back();
    motion.value = parts_[p]->motion(unknowns);
    std::vector<Dual<double>> with_slope(unknowns.begin(), unknowns.end());
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      with_slope[k].slope = 1.0;
      const auto moved = parts_[p]->motion(std::span<const Dual<double>>(with_slope));
      with_slope[k].slope = 0.0;
      BodyMotion<double>& column = motion.columns.emplace_back(BodyMotion<double>{moved.centre, {}, {}});
      for (std::size_t i = 0; i < 3; ++i) column.translation[i] = moved.translation[i].slope;
      for (std::size_t i = 0; i < 9; ++i) column.gradient.a[i] = moved.gradient.a[i].slope;
      motion.test_columns.push_back(is_symmetric() ? column : parts_[p]->virtual_motion(k, motion.value));
    }
  }
  return result;
}

void Mechanism::evaluate_configuration(const std::vector<PartMotion>& parts, Along along,
                                       const std::vector<TimeSeries<double>>& given, Vector& g, Matrix& G) const {
  const auto value = [&](int body) -> const BodyMotion<double>& {
    return body < 0 ? at_rest : parts[static_cast<std::size_t>(body)].value;
  };
  g = Vector::Zero(static_cast<Eigen::Index>(num_equations()));
  G = Matrix::Zero(g.size(), static_cast<Eigen::Index>(first_.back()));
  for (std::size_t j = 0; j < num_equations(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto row = static_cast<Eigen::Index>(j);
    const std::array<const BodyMotion<double>*, 2> bodies{&value(equation.bodies[0]), &value(equation.bodies[1])};
    g[row] = scales_[j] * equation(*bodies[0], *bodies[1], given[j]);
    for (std::size_t side = 0; side < 2; ++side) {
      if (equation.bodies[side] < 0) continue;
      const auto p = static_cast<std::size_t>(equation.bodies[side]);
      const auto& columns = along == Along::columns ? parts[p].columns : parts[p].test_columns;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const auto moved = combined<Dual<double>>(*bodies[side], columns[k]);
        const auto other = combined<Dual<double>>(*bodies[1 - side], at_rest);
        const Dual<double> result = side == 0 ? equation(moved, other, given[j]) : equation(other, moved, given[j]);
        G(row, static_cast<Eigen::Index>(first_[p] + k)) += scales_[j] * result.slope;
      }
    }
  }
}

void Mechanism::evaluate(const std::vector<PartMotion>& parts, Vector& h, Matrix& G) const {
  if (level_ == Level::configuration) {
    evaluate_configuration(parts, Along::columns, given_, h, G);
    return;
  }
  if (level_ == Level::end_of_step) {
    std::vector<PartMotion> ends(parts.size());
    for (std::size_t p = 0; p < parts.size(); ++p) {
      ends[p].value = sum_of(end_weight_, parts[p].value, rest_[p]);
      for (const auto& column : parts[p].columns) ends[p].columns.push_back(sum_of(end_weight_, column, at_rest));
    }
    evaluate_configuration(ends, Along::columns, given_, h, G);
    return;
  }
  using Number = TimeSeries<Dual<double>>;
  const auto series = [&](int body, const BodyMotion<double>* slope) {
    if (body < 0) return BodyMotion<Number>{};
    const auto p = static_cast<std::size_t>(body);
    const auto number = [](double x, double x0, double advance, double s) {
      return Number({x, s}, {x - x0, s}, {x - x0 - advance, s});
    };
    auto result = each<Number>(number, parts[p].value, start_[p], advance_[p], slope != nullptr ? *slope : at_rest);
    result.centre = parts[p].value.centre;
    return result;
  };
  h = Vector::Zero(static_cast<Eigen::Index>(num_equations()));
  G = Matrix::Zero(h.size(), static_cast<Eigen::Index>(first_.back()));
  for (std::size_t j = 0; j < num_equations(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto row = static_cast<Eigen::Index>(j);
    const std::array<BodyMotion<Number>, 2> bodies{series(equation.bodies[0], nullptr),
                                                   series(equation.bodies[1], nullptr)};
    h[row] = scales_[j] * equation(bodies[0], bodies[1], given_[j]).acceleration.value;
    for (std::size_t side = 0; side < 2; ++side) {
      if (equation.bodies[side] < 0) continue;
      const auto p = static_cast<std::size_t>(equation.bodies[side]);
      for (std::size_t k = 0; k < parts[p].columns.size(); ++k) {
        const auto moved = series(equation.bodies[side], &parts[p].columns[k]);
        const auto result = side == 0 ? equation(moved, bodies[1], given_[j]) : equation(bodies[0], moved, given_[j]);
        G(row, static_cast<Eigen::Index>(first_[p] + k)) += scales_[j] * result.acceleration.slope;
      }
    }
  }
}

void Mechanism::choose_columns(const Matrix& G) {
  const Eigen::Index n = G.cols(), m = std::min(G.rows(), n);
  const Eigen::HouseholderQR<Matrix> qr(G.transpose());
  const Matrix complement = Matrix(qr.householderQ()).rightCols(n - m);
  columns_ = complement;
  if (preferred_.cols() != complement.cols() || preferred_.rows() != n || complement.cols() == 0) return;
  const Eigen::JacobiSVD<Matrix> svd(complement.transpose() * preferred_, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.singularValues()[complement.cols() - 1] < least_kept) return;
  columns_ = complement * (svd.matrixU() * svd.matrixV().transpose());
}

// Gauss and Newton's method from far away: steps that do not lower |h| are shortened.
bool Mechanism::approach(Vector& xi) const {
  if (equations_.empty()) return true;
  constexpr int most_iterations = 100, most_halvings = 20;
  Vector h, h_next;
  Matrix G, G_next;
  evaluate(motions(xi), h, G);
  for (int i = 0; i < most_iterations; ++i) {
    if (!h.allFinite()) return false;
    if (h.lpNorm<Eigen::Infinity>() <= tolerance * size_) return true;
    const Vector change = G.transpose() * Matrix(G * G.transpose()).partialPivLu().solve(h);
    double factor = 1.0;
    for (int k = 0;; ++k, factor *= 0.5) {
      // To rounding: nothing lowers it any more.
      if (k == most_halvings) return h.lpNorm<Eigen::Infinity>() <= std::sqrt(tolerance) * size_;
      const Vector next = xi - factor * change;
      evaluate(motions(next), h_next, G_next);
      if (!(h_next.norm() < h.norm())) continue;
      xi = next;
      h.swap(h_next);
      G.swap(G_next);
      break;
    }
  }
  return false;
}

bool Mechanism::solve(Vector& xi) const {
  if (equations_.empty()) return true;
  constexpr int most_iterations = 50;
  constexpr double slow = 0.5;
  Vector h;
  Matrix G;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_iterations; ++i) {
    evaluate(motions(xi), h, G);
    const double error = h.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(error)) return false;
    // To rounding: until it does not fall any more.
    if (error <= tolerance * size_ || (error <= std::sqrt(tolerance) * size_ && error > slow * last)) return true;
    last = error;
    const Vector z = Matrix(G * G_ref_.transpose()).partialPivLu().solve(h);
    xi -= G_ref_.transpose() * z;
    // The equations are those of motions of about this size.
    if (!(xi - reference_).allFinite()) return false;
  }
  return false;
}

void Mechanism::begin_stage(const StagePoint& stage, Vec q) {
  solution_ = {};
  for (const auto& part : parts_) part->begin_stage(stage, q);
  const bool is_last = stage.end_weight != 0.0;
  level_ = rigidity_ == Rigidity::of_configurations ? Level::configuration
           : is_last                                ? Level::end_of_step
                                                    : Level::acceleration;
  end_weight_ = stage.end_weight;
  start_.clear();
  advance_.clear();
  rest_.clear();
  for (const auto& part : parts_) {
    if (level_ == Level::acceleration) {
      start_.push_back(part->motion_of(stage.q0));
      advance_.push_back(sum_of(stage.dt, part->motion_of(stage.v0), at_rest));
    } else if (level_ == Level::end_of_step) {
      rest_.push_back(stage.end_rest != nullptr ? part->motion_of(stage.end_rest) : BodyMotion<double>{});
      rest_.back().centre = part->motion_of(q).centre;
    }
  }
  const double time = level_ == Level::end_of_step ? stage.end_time : stage.time;
  const double passed = time - stage.step_start;
  given_ = given(time, passed > 0.0 ? passed : stage.dt, stage.dt, stage.load_factor,
                 passed > 0.0 ? Side::before : Side::after);
  std::vector<double> xi;
  for (const auto& part : parts_) {
    const auto nearest = part->nearest_unknowns(q);
    xi.insert(xi.end(), nearest.begin(), nearest.end());
  }
  reference_ = Eigen::Map<const Vector>(xi.data(), static_cast<Eigen::Index>(xi.size()));
  Vector h, solution = reference_;
  evaluate(motions(reference_), h, G_ref_);
  if (approach(solution)) {
    reference_ = solution;
    evaluate(motions(reference_), h, G_ref_);
  }
  choose_columns(G_ref_);
}

void Mechanism::begin_end_of_step(Vec q) {
  solution_ = {};
  for (const auto& part : parts_) part->begin_end_of_step(q);
  level_ = Level::configuration;
  std::vector<double> xi;
  for (const auto& part : parts_) {
    const auto nearest = part->nearest_unknowns(q);
    xi.insert(xi.end(), nearest.begin(), nearest.end());
  }
  reference_ = Eigen::Map<const Vector>(xi.data(), static_cast<Eigen::Index>(xi.size()));
  Vector g;
  evaluate_configuration(motions(reference_), Along::columns, given_, g, G_ref_);
  choose_columns(G_ref_);
  // The configuration fulfils the equations, of whatever time.
  Solution& solution = solution_;
  solution.unknowns.assign(hosts_.size(), 0.0);
  solution.xi = reference_;
  solution.parts = motions(reference_);
  solution.columns = solution.test_columns = columns_;
}

const Mechanism::Solution& Mechanism::at(std::span<const double> unknowns) const {
  Solution& solution = solution_;
  if (solution.xi.size() > 0 && std::ranges::equal(solution.unknowns, unknowns)) return solution;
  solution.unknowns.assign(unknowns.begin(), unknowns.end());
  const Eigen::Map<const Vector> y(unknowns.data(), static_cast<Eigen::Index>(unknowns.size()));
  solution.xi = reference_ + columns_ * y;
  if (!solution.xi.allFinite() || !solve(solution.xi)) {
    solution.xi.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  solution.parts = motions(solution.xi);
  solution.columns = solution.test_columns = columns_;
  if (equations_.empty()) return solution;
  Vector h;
  Matrix G;
  evaluate(solution.parts, h, G);
  const Matrix across = G_ref_.transpose();
  solution.columns -= across * Matrix(G * across).partialPivLu().solve(G * columns_);
  evaluate_configuration(solution.parts, Along::test_columns, given_, h, G);
  solution.test.compute(G * across);
  solution.test_columns -= across * solution.test.solve(G * columns_);
  return solution;
}

void Mechanism::put_displacements(std::span<const double> unknowns, Vec q) const {
  const Solution& solution = at(unknowns);
  for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p]->put_displacements(of_part(solution.xi, p), q);
}

void Mechanism::put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const {
  const Solution& solution = at(unknowns);
  const std::size_t p = part_of_node_[static_cast<std::size_t>(node)];
  std::array<Vector3<double>, 6> own{};
  const std::size_t n = first_[p + 1] - first_[p];
  parts_[p]->put_columns(of_part(solution.xi, p), node, std::span(own).first(n));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    columns[k] = {};
    for (std::size_t l = 0; l < n; ++l) {
      columns[k] = columns[k] +
                   solution.columns(static_cast<Eigen::Index>(first_[p] + l), static_cast<Eigen::Index>(k)) * own[l];
    }
  }
}

void Mechanism::put_test_columns(std::span<const double> unknowns, PetscInt node,
                                 std::span<Vector3<double>> columns) const {
  const Solution& solution = at(unknowns);
  const std::size_t p = part_of_node_[static_cast<std::size_t>(node)];
  std::array<Vector3<double>, 6> own{};
  const std::size_t n = first_[p + 1] - first_[p];
  parts_[p]->put_test_columns(of_part(solution.xi, p), node, std::span(own).first(n));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    columns[k] = {};
    for (std::size_t l = 0; l < n; ++l) {
      columns[k] =
          columns[k] +
          solution.test_columns(static_cast<Eigen::Index>(first_[p] + l), static_cast<Eigen::Index>(k)) * own[l];
    }
  }
}

// With the forces phi on the parts' unknowns and V = N - G_ref^T (G_W G_ref^T)^-1 G_W N: phi^T dV = -lambda^T dG_W V,
// lambda = (G_W G_ref^T)^-T G_ref phi.
std::vector<double> Mechanism::curvature(std::span<const double> unknowns, Vec f) const {
  const Solution& solution = at(unknowns);
  const auto all = static_cast<Eigen::Index>(first_.back());
  Matrix of_parts = Matrix::Zero(all, all);
  Vector phi = Vector::Zero(all);
  const ConstArrayView forces(f);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const std::size_t n = first_[p + 1] - first_[p];
    const auto first = static_cast<Eigen::Index>(first_[p]);
    const auto xi = of_part(solution.xi, p);
    const auto values = parts_[p]->curvature(xi, f);
    std::array<Vector3<double>, 6> own{};
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t l = 0; l < n; ++l) {
        of_parts(first + static_cast<Eigen::Index>(k), first + static_cast<Eigen::Index>(l)) = values[n * k + l];
      }
    }
    for (const PetscInt a : parts_[p]->nodes()) {
      parts_[p]->put_test_columns(xi, a, std::span(own).first(n));
      for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
          phi[first + static_cast<Eigen::Index>(k)] += forces[3 * a + static_cast<PetscInt>(i)] * own[k][i];
        }
      }
    }
  }
  Matrix result = solution.test_columns.transpose() * of_parts * solution.columns;
  if (!equations_.empty()) {
    const Vector lambda = solution.test.transpose().solve(G_ref_ * phi);
    result -= joint_curvature(solution, lambda);
  }
  std::vector<double> rows;
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    for (Eigen::Index l = 0; l < result.cols(); ++l) rows.push_back(result(k, l));
  }
  return rows;
}

// d/dy_l of g along the virtual displacement V_k, which is held.
Mechanism::Matrix Mechanism::joint_curvature(const Solution& solution, const Vector& lambda) const {
  const auto all = static_cast<Eigen::Index>(first_.back());
  Matrix of_unknowns = Matrix::Zero(all, all);  // lambda^T d2g / (virtual k) (actual l)
  // Of each part, moved along k (or not at all) and l: row k + 1, column l + 1.
  std::vector<std::vector<BodyMotion<Twice>>> moved(parts_.size());
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto n = static_cast<int>(first_[p + 1] - first_[p]);
    for (int k = -1; k < n; ++k) {
      for (int l = -1; l < n; ++l) moved[p].push_back(twice_moved(solution, p, k, l));
    }
  }
  const BodyMotion<Twice> of_ground{};
  for (std::size_t j = 0; j < num_equations(); ++j) {
    const JointEquation& equation = equations_[j];
    const auto motion = [&](std::size_t side, std::size_t k, std::size_t l) -> const BodyMotion<Twice>& {
      if (equation.bodies[side] < 0) return of_ground;
      const auto p = static_cast<std::size_t>(equation.bodies[side]);
      return moved[p][k * (first_[p + 1] - first_[p] + 1) + l];
    };
    for (std::size_t side = 0; side < 2; ++side) {
      if (equation.bodies[side] < 0) continue;
      for (std::size_t other = 0; other < 2; ++other) {
        if (equation.bodies[other] < 0) continue;
        const auto p = static_cast<std::size_t>(equation.bodies[side]);
        const auto r = static_cast<std::size_t>(equation.bodies[other]);
        for (std::size_t k = 0; k < first_[p + 1] - first_[p]; ++k) {
          for (std::size_t l = 0; l < first_[r + 1] - first_[r]; ++l) {
            const auto at = [&](std::size_t s) -> const BodyMotion<Twice>& {
              return motion(s, s == side ? k + 1 : 0, s == other ? l + 1 : 0);
            };
            of_unknowns(static_cast<Eigen::Index>(first_[p] + k), static_cast<Eigen::Index>(first_[r] + l)) +=
                scales_[j] * lambda[static_cast<Eigen::Index>(j)] * equation(at(0), at(1), given_[j]).slope.slope;
          }
        }
      }
    }
  }
  return solution.test_columns.transpose() * of_unknowns * solution.columns;
}

// x + eps w_k + eps' t_l + eps eps' dw_k / d xi_l.
BodyMotion<Mechanism::Twice> Mechanism::twice_moved(const Solution& solution, std::size_t p, int k, int l) const {
  const PartMotion& part = solution.parts[p];
  if (is_symmetric()) {
    const auto xi = of_part(solution.xi, p);
    std::vector<Twice> unknowns;
    for (std::size_t i = 0; i < xi.size(); ++i) {
      const double along_k = static_cast<int>(i) == k ? 1.0 : 0.0, along_l = static_cast<int>(i) == l ? 1.0 : 0.0;
      unknowns.push_back({Once(xi[i], along_l), Once(along_k, 0.0)});
    }
    return parts_[p]->motion(std::span<const Twice>(unknowns));
  }
  const auto moved = combined<Once>(part.value, l >= 0 ? part.columns[static_cast<std::size_t>(l)] : at_rest);
  const auto along = k >= 0 ? parts_[p]->virtual_motion(static_cast<std::size_t>(k), moved) : BodyMotion<Once>{};
  BodyMotion<Twice> result{part.value.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = {moved.translation[i], along.translation[i]};
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = {moved.gradient.a[i], along.gradient.a[i]};
  return result;
}

std::vector<double> Mechanism::nearest_unknowns(Vec q) const {
  std::vector<double> xi;
  for (const auto& part : parts_) {
    const auto nearest = part->nearest_unknowns(q);
    xi.insert(xi.end(), nearest.begin(), nearest.end());
  }
  Vector solution = Eigen::Map<const Vector>(xi.data(), static_cast<Eigen::Index>(xi.size()));
  Vector on_joints = solution;
  if (approach(on_joints)) solution = on_joints;
  const Vector y = columns_.transpose() * (solution - reference_);
  return {y.begin(), y.end()};
}

std::vector<double> Mechanism::nearest_rates(Vec v) const {
  std::vector<double> rates;
  for (const auto& part : parts_) {
    const auto nearest = part->nearest_rates(v);
    rates.insert(rates.end(), nearest.begin(), nearest.end());
  }
  const Vector w =
      columns_.transpose() * Eigen::Map<const Vector>(rates.data(), static_cast<Eigen::Index>(rates.size()));
  return {w.begin(), w.end()};
}

std::vector<TimeSeries<double>> Mechanism::given(double time, double time_scale, double unit, double factor,
                                                 Side side) const {
  std::vector<TimeSeries<double>> result;
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

void Mechanism::start_stage(const StagePoint& stage) const {
  for (const auto& part : parts_) part->start_stage(stage);
}

std::vector<RigidPart::RigidState> Mechanism::states(const Step& step, Side side, Vec q, Vec v) const {
  std::vector<RigidPart::RigidState> result;
  for (const auto& part : parts_) result.push_back(part->state(step, side, q, v));
  return result;
}

std::vector<Mechanism::PartMotion> Mechanism::motions(const std::vector<RigidPart::RigidState>& states) const {
  std::vector<PartMotion> result;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    PartMotion& motion = result.emplace_back();
    motion.value = states[p].motion();
    for (std::size_t k = 0; k < parts_[p]->hosts().size(); ++k) {
      motion.columns.push_back(parts_[p]->virtual_motion(k, motion.value));
    }
  }
  return result;
}

bool Mechanism::fit_states(const Step& step, Side side, bool with_configurations,
                           std::vector<RigidPart::RigidState>& states) const {
  if (equations_.empty()) return false;
  const auto given_now = given(step.time, step.dt, 1.0, 1.0, side);
  const std::vector<double> none(first_.back(), 0.0);
  Vector g;
  Matrix G;
  bool are_new = false;
  const auto evaluate_at = [&](const std::vector<RigidPart::RigidState>& at) {
    evaluate_configuration(motions(at), Along::columns, given_now, g, G);
  };
  evaluate_at(states);
  // As `approach` does.
  constexpr int most_iterations = 100, most_halvings = 20;
  for (int i = 0; i < most_iterations && with_configurations && g.lpNorm<Eigen::Infinity>() > tolerance * size_; ++i) {
    const double error = g.norm();
    const Vector change = -G.transpose() * Matrix(G * G.transpose()).partialPivLu().solve(g);
    bool is_lower = false;
    for (int k = 0; k < most_halvings && !is_lower; ++k) {
      const Vector part_of_it = std::ldexp(1.0, -k) * change;
      auto next = states;
      for (std::size_t p = 0; p < parts_.size(); ++p) {
        next[p] = parts_[p]->moved(states[p], of_part(part_of_it, p), std::span(none).first(first_[p + 1] - first_[p]));
      }
      evaluate_at(next);
      is_lower = g.norm() < error;
      if (is_lower) states = std::move(next);
    }
    if (!is_lower) {
      evaluate_at(states);
      break;
    }
    are_new = true;
  }
  // The rates of the equations: of the motions that the velocities are, and of what is given.
  Vector rates = Vector::Zero(g.size());
  for (std::size_t j = 0; j < num_equations(); ++j) {
    using Number = TimeSeries<double>;
    const auto series = [&](int body) {
      if (body < 0) return BodyMotion<Number>{};
      const auto& state = states[static_cast<std::size_t>(body)];
      return each<Number>([](double x, double rate) { return Number(x, rate, 0.0); }, state.motion(), state.rate());
    };
    const JointEquation& equation = equations_[j];
    rates[static_cast<Eigen::Index>(j)] =
        scales_[j] * equation(series(equation.bodies[0]), series(equation.bodies[1]), given_now[j]).rate;
  }
  const Vector change = -G.transpose() * Matrix(G * G.transpose()).partialPivLu().solve(rates);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    states[p] = parts_[p]->moved(states[p], std::span(none).first(first_[p + 1] - first_[p]), of_part(change, p));
  }
  return are_new;
}

void Mechanism::complete_step(const Step& step, Vec q, Vec v) const {
  for (const auto& part : parts_) part->complete_step(step, q, v);
  auto fitted = states(step, Side::before, q, v);
  const bool are_new = fit_states(step, Side::before, true, fitted);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    parts_[p]->put(fitted[p], are_new ? q : nullptr, v);
  }
}

void Mechanism::restart(const Step& step, Vec q, Vec v) const {
  auto fitted = states(step, Side::after, q, v);
  fit_states(step, Side::after, false, fitted);
  for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p]->put(fitted[p], nullptr, v);
}

void Mechanism::subtract_given(Vec v) const {
  for (const auto& part : parts_) part->subtract_given(v);
}

std::array<RigidPart::RigidState, 2> Mechanism::states(const std::array<int, 2>& parts, Vec q, Vec v) const {
  std::array<RigidPart::RigidState, 2> result;
  for (std::size_t side = 0; side < 2; ++side) {
    if (parts[side] < 0) continue;
    result[side] = parts_[static_cast<std::size_t>(parts[side])]->state({0.0, 1.0}, Side::after, q, v);
  }
  return result;
}

// At the step's end: the forces of the joints balance those on the unknowns of the parts, G^T lambda = phi.
std::vector<JointReaction> Mechanism::reactions(Vec r, Vec q, std::span<const Vector3<double>> points) const {
  std::vector<RigidPart::RigidState> at;
  for (const auto& part : parts_) at.push_back(part->state({0.0, 1.0}, Side::after, q, q));
  const auto motions_now = motions(at);
  Vector g;
  Matrix G;
  evaluate_configuration(motions_now, Along::columns, given_, g, G);
  std::vector<double> forces(first_.back(), 0.0);
  {
    const ConstArrayView gradient(r);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (const PetscInt a : parts_[p]->nodes()) {
        for (std::size_t k = 0; k < motions_now[p].columns.size(); ++k) {
          const BodyMotion<double>& column = motions_now[p].columns[k];
          const Vector3<double> moved = column.point(parts_[p]->reference(a)) - parts_[p]->reference(a);
          for (std::size_t i = 0; i < 3; ++i) {
            forces[first_[p] + k] += gradient[3 * a + static_cast<PetscInt>(i)] * moved[i];
          }
        }
      }
    }
  }
  sum_in_place(comm_, forces);
  const Eigen::Map<const Vector> phi(forces.data(), static_cast<Eigen::Index>(forces.size()));
  const Vector lambda = Matrix(G * G.transpose()).partialPivLu().solve(G * phi);
  std::vector<JointReaction> result(points.size());
  for (std::size_t j = 0; j < num_equations(); ++j) {
    const JointEquation& equation = equations_[j];
    // The work of the equation's force under translations and rotations of the second body about the joint's point.
    const auto body = [&](int number) -> const BodyMotion<double>& {
      return number < 0 ? at_rest : motions_now[static_cast<std::size_t>(number)].value;
    };
    const BodyMotion<double>&a = body(equation.bodies[0]), &b = body(equation.bodies[1]);
    const Vector3<double> place = b.point(points[equation.joint]);
    for (std::size_t i = 0; i < 3; ++i) {
      Vector3<double> axis{};
      axis[i] = 1.0;
      for (const bool turns : {false, true}) {
        BodyMotion<double> slope{b.centre, axis, {}};
        if (turns) {
          slope.translation = cross(axis, b.point(b.centre) - place);
          for (int c = 0; c < 3; ++c) {
            Vector3<double> e{};
            e[static_cast<std::size_t>(c)] = 1.0;
            const Vector3<double> x = cross(axis, b.direction(e));
            for (int m = 0; m < 3; ++m) slope.gradient(m, c) = x[static_cast<std::size_t>(m)];
          }
        }
        const Dual<double> work =
            equation(combined<Dual<double>>(a, at_rest), combined<Dual<double>>(b, slope), given_[j]);
        const double force = scales_[j] * lambda[static_cast<Eigen::Index>(j)] * work.slope;
        (turns ? result[equation.joint].torque : result[equation.joint].force)[i] += force;
      }
    }
  }
  return result;
}

}  // namespace pliant
