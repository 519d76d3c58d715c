#include "model/places.hpp"

#include "base/vector3.hpp"
#include "model/rigid_bodies.hpp"
#include "petsc/check.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double longest_body = 50.0;  // [m]
constexpr double long_body = 5.0;      // [m], of those that are so soft that they sink under their own weight
constexpr double least_sinking = 0.05;
constexpr double far_away = 50.0;  // sizes of the bodies; millimetres put a place up to 1000 of them away
constexpr double millimetre = 1e-3;

/// A box around nodes; low > high without any.
struct Extent {
  Vector3<double> low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void include(const Vector3<double>& x) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], x[i]);
      high[i] = std::max(high[i], x[i]);
    }
  }
  void include(const Extent& other) {
    include(other.low);
    include(other.high);
  }
  bool is_empty() const { return low[0] > high[0]; }
  double size() const { return norm(high - low); }
  double length() const { return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }
  Vector3<double> middle() const { return 0.5 * (low + high); }
  double distance(const Vector3<double>& x) const {
    Vector3<double> outside{};
    for (std::size_t i = 0; i < 3; ++i) outside[i] = std::max({0.0, low[i] - x[i], x[i] - high[i]});
    return norm(outside);
  }
  /// From a plane with a normal of any length.
  double distance_from_plane(const Vector3<double>& x, const Vector3<double>& normal) const {
    const Vector3<double> n = unit(normal), across = 0.5 * (high - low);
    const double reach = std::abs(n[0]) * across[0] + std::abs(n[1]) * across[1] + std::abs(n[2]) * across[2];
    return std::max(0.0, std::abs(dot(n, x - middle())) - reach);
  }
};

/// One for each body of the input, and the last for cells of none. Collective.
std::vector<Extent> extents_of_bodies(const Config& config, const NodeLayout& layout,
                                      const std::vector<int>& body_of_cell) {
  const std::size_t count = config.bodies.size() + 1;
  std::vector<Extent> extents(count);
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const int body = body_of_cell[static_cast<std::size_t>(c)];
    Extent& extent = body < 0 ? extents.back() : extents[static_cast<std::size_t>(body)];
    for (const PetscInt n : layout.nodes_of_cell(c)) extent.include(layout.position(n));
  }
  std::vector<double> numbers;  // whose maxima are the extents
  for (const auto& [low, high] : extents) {
    numbers.insert(numbers.end(), {-low[0], -low[1], -low[2], high[0], high[1], high[2]});
  }
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, MPI_MAX, layout.comm));
  for (std::size_t b = 0; b < count; ++b) {
    const double* of = numbers.data() + 6 * b;
    extents[b] = {{-of[0], -of[1], -of[2]}, {of[3], of[4], of[5]}};
  }
  return extents;
}

std::string in_millimetres(const Vector3<double>& place) {
  const auto length = [](double x) { return x == 0.0 ? std::string("0") : fmt::format("{:g} mm", x); };
  return fmt::format("[{}, {}, {}]", length(place[0]), length(place[1]), length(place[2]));
}

class Places {
 public:
  explicit Places(const Extent& bodies) : bodies_(bodies) {}

  void warn(const Location& where, std::string message) {
    found_.push_back({Severity::warning, where, std::move(message)});
  }
  /// Warns of a place that is far from the bodies, and would be near them if it was in millimetres.
  void look(const std::string& what, const Vector3<double>& place, const Location& where) {
    look(what, place, bodies_.distance(place), where);
  }
  void look(const std::string& what, const Vector3<double>& place, double distance, const Location& where) {
    const double size = bodies_.size();
    if (bodies_.is_empty() || !(distance > far_away * size) || !is_meant_in_millimetres(place)) return;
    warn(where, fmt::format("{} at ({:g}, {:g}, {:g}) is {:.3g} m away from the bodies, which are {:.3g} m in size; "
                            "places are in metres: if millimetres are meant, write {}",
                            what, place[0], place[1], place[2], distance, size, in_millimetres(place)));
  }
  bool is_meant_in_millimetres(const Vector3<double>& place) const {
    return bodies_.distance(millimetre * place) <= bodies_.size();
  }
  std::vector<Diagnostic> found() && { return std::move(found_); }

 private:
  Extent bodies_;
  std::vector<Diagnostic> found_;
};

void check_points(const std::string& what, std::span<const BodyPoint> points, Places& places) {
  for (const BodyPoint& point : points) {
    if (!point.body.empty()) places.look("the point of " + what, point.point, point.where);
  }
}

void check_obstacle(const ObstacleConfig& obstacle, const Extent& bodies, Places& places) {
  const double from_point = bodies.distance(obstacle.point);
  const auto distance = std::visit(
      [&](const auto& shape) {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, ObstacleConfig::Plane>) {
          return bodies.distance_from_plane(obstacle.point, shape.normal);
        } else if constexpr (std::is_same_v<Shape, ObstacleConfig::Box>) {
          return std::max(0.0, from_point - norm(Vector3<double>(shape.size)));
        } else if constexpr (std::is_same_v<Shape, ObstacleConfig::Surface>) {
          return 0.0;  // its point is not used
        } else if constexpr (std::is_same_v<Shape, ObstacleConfig::Sphere>) {
          return std::max(0.0, from_point - shape.radius);
        } else if constexpr (std::is_same_v<Shape, ObstacleConfig::Capsule>) {
          return std::max(0.0, from_point - shape.radius - shape.length);
        } else {
          return shape.length ? std::max(0.0, from_point - shape.radius - *shape.length) : 0.0;
        }
      },
      obstacle.shape);
  places.look("the obstacle '" + obstacle.name + "'", obstacle.point, distance, obstacle.where);
}

/// Warns of a rigid body whose centre is farther outside its surface than this is large.
void check_center(const RigidBodyConfig& body, const Extent& surface, Places& places) {
  const double distance = surface.distance(body.center);
  if (surface.is_empty() || !(distance > surface.size())) return;
  const auto& [x, y, z] = body.center;
  const bool is_in_millimetres = surface.distance(millimetre * Vector3<double>(body.center)) <= surface.size();
  places.warn(body.where,
              fmt::format("the center of mass of '{}' at ({:g}, {:g}, {:g}) is {:.3g} m outside its surface, which is "
                          "{:.3g} m in size; {}",
                          body.name, x, y, z, distance, surface.size(),
                          is_in_millimetres
                              ? "places are in metres: if millimetres are meant, write " + in_millimetres(body.center)
                              : "check 'center' and the 'scale' of the surface"));
}

/// How much of its length a body of elastic material would lose to its own weight if it stood upright, about.
double sinking(const BodyConfig& body, double shear_modulus, double length) {
  constexpr double gravity = 9.81, density_of_water = 1000.0;
  constexpr double softest_solid = 150.0;  // [Pa]; less is rather a model in units of its own
  if (!(shear_modulus >= softest_solid)) return 0.0;
  return 0.5 * body.density.value_or(density_of_water) * gravity * length / (3.0 * shear_modulus);
}

void check_mesh(const Config& config, const Extent& mesh, const std::vector<Extent>& of_bodies,
                std::span<const double> shear_moduli, Places& places) {
  const auto warn = [&](const std::string& why) {
    places.warn(
        config.mesh.file.where,
        fmt::format("the mesh is {:.3g} m long{}; 'scale: 0.001' converts millimetres to metres", mesh.length(), why));
  };
  if (mesh.is_empty() || mesh.length() < long_body) return;
  if (mesh.length() >= longest_body) return warn("");
  for (std::size_t b = 0; b + config.rigid_bodies.size() < config.bodies.size(); ++b) {
    const BodyConfig& body = config.bodies[b];
    if (of_bodies[b].is_empty() || body.is_rod || body.is_shell || of_bodies[b].length() < long_body) continue;
    const double lost = sinking(body, shear_moduli[b], of_bodies[b].length());
    if (lost < least_sinking) continue;
    return warn(lost < 1.0
                    ? fmt::format(", and so soft that it would sink by {:.2g} % under its own weight", 100.0 * lost)
                    : ", and so soft that it would collapse under its own weight");
  }
}

void check_surfaces(const Config& config, const std::vector<Extent>& of_bodies, Places& places) {
  const std::size_t first = config.bodies.size() - config.rigid_bodies.size();
  for (std::size_t b = 0; b < config.rigid_bodies.size(); ++b) {
    const RigidBodyConfig& body = config.rigid_bodies[b];
    const Extent& extent = of_bodies[first + b];
    if (!body.surface || extent.is_empty() || extent.length() < longest_body) continue;
    places.warn(body.surface->file.where,
                fmt::format("the surface of '{}' is {:.3g} m long; 'scale: 0.001' converts millimetres to metres",
                            body.name, extent.length()));
  }
}

}  // namespace

std::vector<Diagnostic> warnings_about_places(const Config& config, const NodeLayout& layout,
                                              const std::vector<int>& body_of_cell,
                                              std::span<const double> shear_moduli) {
  const std::vector<Extent> extents = extents_of_bodies(config, layout, body_of_cell);
  const std::size_t first = config.bodies.size() - config.rigid_bodies.size();
  const std::vector<std::string> rods = names_of_rods(config);
  // What is given by places of the input is not what these are compared with.
  const auto is_given_by_places = [&](std::size_t b) {
    if (b == config.bodies.size()) return false;
    const bool is_section = std::ranges::find(rods, config.bodies[b].part.name) != rods.end();
    return (b < first && (config.bodies[b].is_rod || is_section)) ||
           (b >= first && stands_for_body(config, static_cast<int>(b)));
  };
  Extent mesh, bodies, all;
  for (std::size_t b = 0; b < extents.size(); ++b) {
    if (extents[b].is_empty()) continue;
    all.include(extents[b]);
    if (is_given_by_places(b)) continue;
    bodies.include(extents[b]);
    if (b < first || b == config.bodies.size()) mesh.include(extents[b]);
  }
  Places places(bodies);
  check_mesh(config, mesh, extents, shear_moduli, places);
  check_surfaces(config, extents, places);
  if (bodies.is_empty() && all.length() >= longest_body) {
    places.warn({config.file, 0, 0},
                fmt::format("the places of rigid bodies and rods extend over {:.3g} m; places are in metres: write "
                            "'5 mm' for millimetres",
                            all.length()));
  }
  for (std::size_t b = 0; b < config.rigid_bodies.size(); ++b) {
    const RigidBodyConfig& body = config.rigid_bodies[b];
    if (body.surface) check_center(body, extents[first + b], places);
    if (!body.surface) places.look("the center of mass of '" + body.name + "'", body.center, body.where);
  }
  for (const RodConfig& rod : config.rods) {
    const auto is_far = [&](const auto& point) { return bodies.distance(point) > far_away * bodies.size(); };
    const auto point = std::ranges::find_if(rod.points, is_far);
    if (point != rod.points.end()) places.look("the point of rod '" + rod.name + "'", *point, rod.where);
  }
  for (const JointConfig& joint : config.joints) {
    places.look("joint '" + joint.name + "'", joint.point, joint.where);
    if (joint.second_point)
      places.look("'second_point' of joint '" + joint.name + "'", *joint.second_point, joint.where);
  }
  for (const TendonConfig& tendon : config.tendons) check_points("tendon '" + tendon.name + "'", tendon.points, places);
  for (const SpringConfig& spring : config.springs) check_points("spring '" + spring.name + "'", spring.points, places);
  if (!config.contact || bodies.is_empty()) return std::move(places).found();
  for (const ObstacleConfig& obstacle : config.contact->obstacles) check_obstacle(obstacle, bodies, places);
  return std::move(places).found();
}

}  // namespace pliant
