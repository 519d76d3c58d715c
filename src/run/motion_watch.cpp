#include "run/motion_watch.hpp"

#include "base/tensor.hpp"
#include "base/vector3.hpp"
#include "fem/element.hpp"
#include "input/elasticity.hpp"
#include "material/library.hpp"
#include "material/spectral.hpp"
#include "model/joint_stops.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::string_view rubber_tears = "it is fitted to rubber at a stretch below 2, and rubber tears at 5 to 8";
constexpr std::string_view tissue_tears = "it is fitted to tissue at a stretch below 1.3, and tissue tears at 1.5 to 2";
constexpr std::string_view of_graphics = "it is made for computer graphics at moderate deformation";

/// Generous bounds: beyond them, a number is mistyped or the law is used outside its range. An inflated membrane has
/// small principal stretches as well as large ones; most laws therefore have practically no lower bound.
constexpr double no_bound = 0.02;
constexpr std::array<std::pair<std::string_view, TrustedStretches>, 17> trusted{{
    {"linear", {0.8, 1.2, "it is for strains of a few per cent, and treats rotation as strain"}},
    {"saint-venant-kirchhoff", {0.6, 2.0, "it is for small strain, and collapses at a stretch below 0.577"}},
    {"neo-hookean", {no_bound, 4.0, rubber_tears}},
    {"stable-neo-hookean", {no_bound, 4.0, rubber_tears}},
    {"neo-hookean-isochoric", {no_bound, 4.0, rubber_tears}},
    {"fixed-corotated", {no_bound, 4.0, of_graphics}},
    {"arap", {no_bound, 4.0, of_graphics}},
    {"mooney-rivlin", {no_bound, 5.0, "it is fitted to rubber at a stretch below 3, and rubber tears at 5 to 8"}},
    {"mooney-rivlin-5", {no_bound, 7.0, "it is fitted to rubber, which tears at 5 to 8"}},
    {"mooney-rivlin-coupled",
     {no_bound, 5.0, "it is fitted to rubber at a stretch below 3, and rubber tears at 5 to 8"}},
    {"yeoh", {no_bound, 7.0, "it is fitted to rubber, which tears at 5 to 8"}},
    {"ogden", {no_bound, 8.0, "it is fitted to rubber, which tears at 5 to 8"}},
    {"gent", {no_bound, 10.0, "it is fitted to rubber, which tears at 5 to 8"}},
    {"arruda-boyce", {no_bound, 10.0, "it is fitted to rubber, which tears at 5 to 8"}},
    {"guccione", {no_bound, 2.5, tissue_tears}},
    {"holzapfel-gasser-ogden", {no_bound, 2.5, tissue_tears}},
    {"holzapfel-ogden", {no_bound, 2.5, tissue_tears}},
}};

/// The least barycentric coordinate of x in a tetrahedron; not below 0 inside.
double least_coordinate(const std::array<Vector3<double>, 4>& corners, const Vector3<double>& x) {
  double least = infinity;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3<double>& a = corners[(i + 1) % 4];
    const auto n = cross(corners[(i + 2) % 4] - a, corners[(i + 3) % 4] - a);
    least = std::min(least, dot(n, x - a) / dot(n, corners[i] - a));
  }
  return least;
}

/// The first body that has the place x at the displacement u of local nodes, of those whose nodes are in the component.
/// Collective.
int body_at(const Model& model, int component, const Vector3<double>& x, std::span<const double> u) {
  constexpr double rounding = 1e-9;
  const NodeLayout& layout = model.layout();
  struct {
    double coordinate;
    int body;
  } mine{-infinity, std::numeric_limits<int>::max()}, best{};
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    if (model.components().of_node[nodes[0]] != component) continue;
    std::array<Vector3<double>, 4> corners{};
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t i = 0; i < 3; ++i) corners[a][i] = layout.coordinates[3 * nodes[a] + i] + u[3 * nodes[a] + i];
    }
    const double coordinate = least_coordinate(corners, x), inside = coordinate > -rounding ? 0.0 : coordinate;
    const int body = model.body_of_cell()[c];
    if (inside > mine.coordinate || (inside == mine.coordinate && body < mine.body)) mine = {inside, body};
  }
  check_mpi(MPI_Allreduce(&mine, &best, 1, MPI_DOUBLE_INT, MPI_MAXLOC, layout.comm));
  return best.body;
}

/// F - I at the middle of a cell: the gradient of u in the reference cell, times the inverse of that of X.
template <int Order>
Tensor3<double> displacement_gradient(const NodeLayout& layout, PetscInt cell, std::span<const double> u) {
  const auto dN = Tet<Order>::gradients({0.25, 0.25, 0.25});
  const auto nodes = layout.nodes_of_cell(cell);
  Tensor3<double> of_X{}, of_u{};
  for (std::size_t a = 0; a < dN.size(); ++a) {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        of_X(i, k) += layout.coordinates[3 * nodes[a] + i] * dN[a][k];
        of_u(i, k) += u[3 * nodes[a] + i] * dN[a][k];
      }
    }
  }
  return matmul(of_u, transpose((1.0 / det(of_X)) * cofactor(of_X)));
}

std::array<double, 3> middle(const NodeLayout& layout, PetscInt cell) {
  std::array<double, 3> X{};
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t i = 0; i < 3; ++i) X[i] += 0.25 * layout.coordinates[3 * layout.nodes_of_cell(cell)[a] + i];
  }
  return X;
}

/// A stretch and its place; the one with the largest `excess` is reported.
struct Found {
  double excess = 0.0;
  double stretch = 1.0;
  std::array<double, 3> X{};

  void take(double value, double size, PetscInt cell, const NodeLayout& layout) {
    if (!(size > excess)) return;
    *this = {size, value, middle(layout, cell)};
  }
};

/// The extreme of the rank with the largest excess, on every rank. Collective.
Found of_all_ranks(MPI_Comm comm, Found found) {
  struct {
    double excess;
    int rank;
  } mine{found.excess, rank(comm)}, best{};
  check_mpi(MPI_Allreduce(&mine, &best, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm));
  std::array<double, 4> values{found.stretch, found.X[0], found.X[1], found.X[2]};
  check_mpi(MPI_Bcast(values.data(), 4, MPI_DOUBLE, best.rank, comm));
  return {best.excess, values[0], {values[1], values[2], values[3]}};
}

}  // namespace

std::optional<TrustedStretches> trusted_stretches(std::string_view law) {
  const auto row = std::ranges::find(trusted, law, &std::pair<std::string_view, TrustedStretches>::first);
  return row == trusted.end() ? std::nullopt : std::optional(row->second);
}

MotionWatch::MotionWatch(const Config& config, const Model& model)
    : model_(model),
      mesh_(config.mesh.file.where),
      is_static_(analysis_of(config) == Analysis::static_equilibrium),
      overlap_is_known_(model.overlaps_at_start()),
      are_beyond_(config.joints.size(), 0) {
  for (std::size_t b = 0; b < model.body_names().size(); ++b) {
    if (b >= config.bodies.size() || config.bodies[b].is_rigid) {
      bodies_.push_back(
          {{}, model.body_names()[b], {}, {-infinity, infinity, {}}, {}, {}, {}});  // nothing stretches it
      continue;
    }
    bodies_.push_back(watched(*config.bodies[b].elasticity, model.body_names()[b]));
    if (const auto& expansion = config.bodies[b].expansion) bodies_.back().expansion = expansion->stretch;
  }
  for (const TendonConfig& tendon : config.tendons) {
    if (tendon.tension) tendons_.push_back({tendon.name, *tendon.tension, tendon.where});
  }
}

MotionWatch::Body MotionWatch::watched(const ElasticityConfig& elasticity, const std::string& name) {
  const ElasticityRule rule(elasticity);
  Body body{elasticity.where, name, std::string(rule.kind().info().name), {no_bound, 10.0, {}}, {}, {}, {}};
  if (rule.is_uniform()) body.stable = stable_stretches(rule.law_at(0, {}));
  const auto of_law = trusted_stretches(body.law);
  if (of_law) body.trusted = *of_law;
  body.why = of_law ? of_law->why : "the range of this law is not known";
  if (const LibraryMaterial* material = find_material(elasticity.library)) {
    body.law = material->name;
    body.trusted = {1.0 / material->highest_stretch, material->highest_stretch, {}};
    body.why = fmt::format("it was measured up to a stretch of {:g}", material->highest_stretch);
  }
  return body;
}

std::string MotionWatch::instant(double time) const {
  return is_static_ ? fmt::format("load factor {:.4g}", time) : fmt::format("t = {:.4g} s", time);
}

std::string MotionWatch::in_words(const Body& body, const Extreme& extreme) const {
  const auto& [x, y, z] = extreme.X;
  const std::string what = extreme.stretch < 0.0
                               ? "turned inside out"
                               : fmt::format("{} to {:.3g} times its length",
                                             extreme.stretch > 1.0 ? "stretched" : "compressed", extreme.stretch);
  return fmt::format(
      "{}: at {} '{}' is {} near X = ({:.4g}, {:.4g}, {:.4g}), beyond the range of '{}': {}; check loads and moduli: a "
      "number without a unit is in SI",
      to_string(body.where), instant(extreme.time), body.name, what, x, y, z, body.law, body.why);
}

std::string MotionWatch::instability(const Body& body, const Extreme& extreme, double limit) const {
  const auto& [x, y, z] = extreme.X;
  return fmt::format(
      "{}: at {} '{}' is stretched to {:.3g} times its length near X = ({:.4g}, {:.4g}, {:.4g}), but with these "
      "constants '{}' is stable up to {:.3g} in such a state only; what follows may depend on the mesh",
      to_string(body.where), instant(extreme.time), body.name, extreme.stretch, x, y, z, body.law, limit);
}

void MotionWatch::look_at_stretches(const StepRecord& record, std::span<const double> u,
                                    std::vector<std::string>& news) {
  const Instant at = record.instant(model_);
  const double time = progress(record);
  const NodeLayout& layout = model_.layout();
  std::vector<Found> least(bodies_.size()), most(bodies_.size()), unstable(bodies_.size());
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto body = static_cast<std::size_t>(model_.body_of_cell()[c]);
    const auto H = layout.order == 1 ? displacement_gradient<1>(layout, c, u) : displacement_gradient<2>(layout, c, u);
    auto l = principal_stretches(H).l;  // in descending order
    if (const auto& expansion = bodies_[body].expansion) {
      const auto [x, y, z] = middle(layout, c);
      const double s = 1.0 + at.load_factor * ((*expansion)(x, y, z, at.time) - 1.0);
      for (double& stretch : l) stretch /= s;
    }
    most[body].take(l[0], l[0], c, layout);
    least[body].take(l[2], 1.0 / std::max(l[2], 1e-9), c, layout);
    if (!bodies_[body].stable || !(l[2] > 0.0)) continue;
    if (const double excess = l[0] / bodies_[body].stable->limit(l); excess > 1.0) {
      unstable[body].take(l[0], excess, c, layout);
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (body.stable) {
      const Found found = of_all_ranks(layout.comm, unstable[b]);
      if (found.excess > 1.0) {
        news.push_back(instability(body, {found.stretch, 1.0, found.X, time}, found.stretch / found.excess));
        body.stable.reset();
      }
    }
    for (const auto& [found, extreme] : {std::pair{of_all_ranks(layout.comm, most[b]), &body.largest},
                                         {of_all_ranks(layout.comm, least[b]), &body.smallest}}) {
      const bool is_large = extreme == &body.largest;
      if (is_large ? found.stretch <= extreme->stretch : found.stretch >= extreme->stretch) continue;
      extreme->stretch = found.stretch;
      extreme->X = found.X;
      extreme->time = time;
      const bool is_beyond = is_large ? found.stretch > body.trusted.high : found.stretch < body.trusted.low;
      if (!is_beyond || extreme->told != 1.0) continue;
      extreme->told = found.stretch;
      news.push_back(in_words(body, *extreme));
    }
  }
}

std::vector<std::string> MotionWatch::look(const StepRecord& record) {
  std::vector<std::string> news;
  const ConstGhostedView u(record.q);
  look_at_stretches(record, u.span(), news);
  return news;
}

std::optional<std::string> MotionWatch::look_for_passage(const StepRecord& record) {
  if (overlap_is_known_ || model_.components().count < 2) return std::nullopt;
  const std::vector<char>& are_kept_apart = model_.are_kept_apart();
  if (std::ranges::find(are_kept_apart, 0) == are_kept_apart.end()) return std::nullopt;
  const ConstGhostedView u(record.q);
  constexpr std::size_t most_nodes = 1000;  // costs far less than a step
  const auto overlap = deepest_overlap(model_.layout(), model_.components(), u.span(), most_nodes, are_kept_apart);
  if (!overlap) return std::nullopt;
  overlap_is_known_ = true;
  const auto& [x, y, z] = overlap->at;
  const int body = body_at(model_, overlap->of, overlap->at, u.span());
  const int other = body_at(model_, overlap->in, overlap->at, u.span());
  return to_string(Diagnostic{
      Severity::warning, mesh_,
      fmt::format("at {} {} pass through one another, {:.3g} m deep at ({:.4g}, {:.4g}, {:.4g}): {}; 'contact: "
                  "{{law: barrier, pairs: all}}' keeps bodies apart",
                  instant(progress(record)), names_of(body, other), overlap->depth, x, y, z,
                  model_.contacts() != nullptr
                      ? "no contact between them is enabled, or it leaves out parts of their surfaces"
                      : "no contact between them is enabled")});
}

std::vector<std::string> MotionWatch::look_at_joints(const StepRecord& record) {
  constexpr double far = 100.0;  // roundings of a stop: a tenth of the range, of 1 rad or of the size of the bodies
  const auto& joints = model_.constraints().joints();
  std::vector<std::string> news;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (are_beyond_[j] != 0) continue;
    for (const JointLaw& law : model_.laws_of_joint(j)) {
      const auto* stops = std::get_if<JointStops>(&law);
      if (stops == nullptr) continue;
      const double beyond = beyond_stops(*stops, joints[j], record.q, record.v);
      if (beyond < far * stops->rounding) continue;
      are_beyond_[j] = 1;
      news.push_back(
          fmt::format("{}: at {} joint '{}' is beyond its limits by {:.3g} {}: shorten the step, or give a "
                      "larger 'limit_stiffness'",
                      to_string(model_.given_joints()[j].where), instant(progress(record)), joints[j].name, beyond,
                      joints[j].angle != nullptr ? "rad" : "m"));
    }
  }
  return news;
}

std::vector<std::string> MotionWatch::look_at_tendons(const StepRecord& record) {
  constexpr double rounding = 1e-9;
  std::vector<std::string> news;
  for (auto& [name, tension, where, largest, is_told] : tendons_) {
    const double given = tension(0.0, 0.0, 0.0, record.instant(model_).time);
    largest = std::max(largest, given);
    if (is_told || !(given < -rounding * std::max(1.0, largest))) continue;
    is_told = true;
    news.push_back(
        fmt::format("{}: at {} the tension given for tendon '{}' is {:.3g} N, and a string does not push: it "
                    "is slack",
                    to_string(where), instant(progress(record)), name, given));
  }
  return news;
}

std::string MotionWatch::names_of(int body, int other) const {
  const auto name = [&](int b) { return bodies_[static_cast<std::size_t>(b)].name; };
  if (body == other) return fmt::format("two parts of '{}', which share no node,", name(body));
  return fmt::format("'{}' and '{}'", std::min(name(body), name(other)), std::max(name(body), name(other)));
}

std::vector<std::string> MotionWatch::final_warnings() const {
  constexpr double worth_telling = 1.05;
  std::vector<std::string> words;
  for (const Body& body : bodies_) {
    for (const Extreme* extreme : {&body.largest, &body.smallest}) {
      if (extreme->told == 1.0) continue;
      const double worse = extreme->stretch / extreme->told;
      if (worse < worth_telling && worse > 1.0 / worth_telling) continue;
      words.push_back(in_words(body, *extreme));
    }
  }
  return words;
}

}  // namespace pliant
