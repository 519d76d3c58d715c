#include "model/contacts.hpp"

#include "fem/probe.hpp"
#include "fem/surface_distance.hpp"
#include "input/analysis.hpp"
#include "model/contact_defaults.hpp"
#include "model/initial_displacement.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Distance of contact points, as a fraction of the size of a facet.
constexpr double spacing_per_facet = 0.5;

constexpr double endless = std::numeric_limits<double>::infinity();

/// The signed distance of each shape at a point. Collective.
struct DistanceOf {
  MPI_Comm comm;
  const Vector3<double>& point;
  using Result = std::unique_ptr<SignedDistance>;

  Result operator()(const ObstacleConfig::Plane& plane) const {
    return make_distance(PlaneShape{point, unit(plane.normal)});
  }
  Result operator()(const ObstacleConfig::Sphere& sphere) const {
    return make_distance(SphereShape{point, sphere.radius});
  }
  Result operator()(const ObstacleConfig::Cylinder& cylinder) const {
    return make_distance(CylinderShape{point, unit(cylinder.axis), cylinder.radius, cylinder.length.value_or(endless)});
  }
  Result operator()(const ObstacleConfig::Capsule& capsule) const {
    return make_distance(CapsuleShape{point, unit(capsule.axis), capsule.radius, capsule.length});
  }
  Result operator()(const ObstacleConfig::Box& box) const { return make_distance(BoxShape{point, box.size}); }
  Result operator()(const ObstacleConfig::Surface& surface) const {
    return make_distance(read_surface(comm, {surface.file.value, surface.file.where, {}, surface.scale}));
  }
};

/// The second largest of the extents: of a sheet the breadth, since points find its face.
double second_extent(Vector3<double> extent) {
  std::ranges::sort(extent);
  return extent[1];
}

/// The width of each shape that may pass between contact points [m].
struct WidthOf {
  const Obstacle& obstacle;

  double operator()(const ObstacleConfig::Plane&) const { return endless; }
  double operator()(const ObstacleConfig::Sphere& sphere) const { return 2.0 * sphere.radius; }
  double operator()(const ObstacleConfig::Cylinder& cylinder) const { return 2.0 * cylinder.radius; }
  double operator()(const ObstacleConfig::Capsule& capsule) const { return 2.0 * capsule.radius; }
  double operator()(const ObstacleConfig::Box& box) const { return second_extent(box.size); }
  double operator()(const ObstacleConfig::Surface&) const {
    Vector3<double> low{endless, endless, endless}, high = -1.0 * low;
    for (const TrianglePatch& triangle : obstacle.shape().drawing({}, 0.0)) {
      for (const auto& corner : triangle) {
        for (std::size_t i = 0; i < 3; ++i) {
          low[i] = std::min(low[i], corner[i]);
          high[i] = std::max(high[i], corner[i]);
        }
      }
    }
    return second_extent(high - low);
  }
};

double width_of(const ObstacleConfig& o, const Obstacle& obstacle) {
  return o.side == ObstacleConfig::Side::inside ? endless : std::visit(WidthOf{obstacle}, o.shape);
}

RigidMotion motion_of(const ObstacleConfig& o) {
  RigidMotion motion;
  motion.translation = {Expression(), Expression(), Expression()};
  motion.axis = {0.0, 0.0, 1.0};
  motion.centre = o.point;
  if (!o.motion) return motion;
  for (std::size_t i = 0; i < 3; ++i) motion.translation[i] = o.motion->translate[i];
  if (const auto& rotate = o.motion->rotate) {
    motion.axis = unit(rotate->axis);
    motion.angle = rotate->angle;
    motion.centre = rotate->center.value_or(o.point);
  }
  return motion;
}

/// The least gap of the points and nodes of a body's surface to an obstacle. Collective.
StartGap start_gap(MPI_Comm comm, const ContactSurface& surface, const ObstacleFrame& obstacle,
                   std::span<const double> q) {
  StartGap mine;
  const auto include = [&](const Vector3<double>& x) {
    mine = nearer(mine, {obstacle.distance(x) - surface.law().threshold, x});
  };
  surface.for_each_owned([&](const ContactSurface::Point& point) { include(surface.position(point, q)); });
  for (PetscInt f = 0; f < surface.facets().size(); ++f) {
    if (!surface.facets().is_owned[f]) continue;
    for (const PetscInt node : surface.nodes_of(f)) include(surface.position(node, q));
  }
  StartGap least;
  for (const StartGap& of_rank : gathered(comm, std::array{mine})) least = nearer(least, of_rank);
  return least;
}

/// Area of the triangle of a facet's corners, or of a segment of a rod [m^2].
double corner_area(const NodeLayout& layout, std::span<const PetscInt> nodes, double thickness) {
  const auto X = layout.position(nodes[0]);
  if (is_segment(nodes)) return thickness * norm(layout.position(nodes[1]) - X);
  return 0.5 * norm(cross(layout.position(nodes[1]) - X, layout.position(nodes[2]) - X));
}

}  // namespace

Contacts::Contacts(const ContactConfig& config, Analysis analysis, const ContactBodies& bodies,
                   std::vector<TouchingSurfaces> touching)
    : config_(config),
      layout_(bodies.layout),
      body_names_(bodies.names),
      is_left_out_(bodies.is_left_out.begin(), bodies.is_left_out.end()),
      has_inertia_(analysis == Analysis::dynamic) {
  const bool has_velocity = analysis != Analysis::static_equilibrium;
  for (const auto& o : config.obstacles) {
    auto shape = std::visit(DistanceOf{layout_.comm, o.point}, o.shape);
    if (o.side == ObstacleConfig::Side::inside) shape = hollow(std::move(shape));
    obstacles_.push_back(std::make_shared<const Obstacle>(std::move(shape), motion_of(o)));
    widths_.push_back(width_of(o, *obstacles_.back()));
  }
  if (!obstacles_.empty()) add_surfaces(bodies);
  make_terms_of_obstacles(has_velocity);
  if (touching.empty()) return;
  for (TouchingSurfaces& entry : touching) {
    mark_rigid_parts(bodies.rigid_part, entry);
    if (entry.law == NormalKind::penalty) mark_planes_of_symmetry(layout_, bodies.prescribed, entry);
  }
  between_ = std::make_unique<BodyContacts>(config_, layout_, std::move(touching), body_names_, bodies.shear_moduli,
                                            bodies.start);
  for (const Diagnostic& note : between_->description()) description_.push_back(note);
  between_->make_terms(has_velocity, terms_, groups_);
}

void Contacts::add_surfaces(const ContactBodies& bodies) {
  const FacetList& all = bodies.facets;
  const auto n = static_cast<std::size_t>(all.nodes_per_facet);
  std::vector<FacetList> facets(body_names_.size());
  for (FacetList& list : facets) list.nodes_per_facet = all.nodes_per_facet;
  surface_of_node_.assign(static_cast<std::size_t>(layout_.num_owned_nodes), -1);
  const CellOfFacets cell_of(layout_, all, bodies.thin);
  std::vector<double> area(body_names_.size(), 0.0), number(body_names_.size(), 0.0);
  for (PetscInt f = 0; f < all.size(); ++f) {
    const auto nodes = std::span(all.nodes).subspan(f * n, n);
    const auto cell = cell_of(nodes);
    const int body = cell ? bodies.body_of_cell[*cell] : -1;
    const auto is_held = [&](PetscInt a) {
      return bodies.prescribed[3 * a] && bodies.prescribed[3 * a + 1] && bodies.prescribed[3 * a + 2];
    };
    if (body < 0 || std::ranges::all_of(nodes, is_held)) continue;
    FacetList& list = facets[body];
    list.nodes.insert(list.nodes.end(), nodes.begin(), nodes.end());
    list.is_owned.push_back(all.is_owned[f]);
    list.is_outer.push_back(all.is_outer[f]);
    for (const PetscInt a : nodes) {
      if (a < layout_.num_owned_nodes) surface_of_node_[a] = body;
    }
    if (!all.is_owned[f]) continue;
    area[body] += corner_area(layout_, nodes, bodies.thin.thickness[body]);
    number[body] += 1.0;
  }
  for (std::size_t b = 0; b < facets.size(); ++b) {
    const double total = sum(layout_.comm, area[b]), count = sum(layout_.comm, number[b]);
    const double size = count > 0.0 ? std::sqrt(2.0 * total / count) : 1.0;  // legs of a right triangle
    facet_sizes_.push_back(size);
    has_facets_.push_back(count > 0.0 ? 1 : 0);
    const ContactPressureConfig& given = config_.pressure;
    const double thickness = bodies.thin.thickness[b];
    const double modulus = contact_modulus(bodies.shear_moduli[b], thickness, size);
    const NormalLaw law{given.law, given.stiffness.value_or(shear_moduli_per_facet * modulus / size),
                        given.width.value_or(width_per_facet * size), given.threshold + 0.5 * thickness};
    surfaces_.push_back(std::make_shared<const ContactSurface>(layout_, bodies.pattern, std::move(facets[b]), law,
                                                               bodies.thin.is_rod[b] != 0 ? thickness : 0.0));
    if (count == 0.0) continue;
    description_.push_back(
        note(fmt::format("contact of '{}': {:.0f} facets of about {:.3g} m, stiffness {:.3g} Pa/m, width {:.3g} m",
                         body_names_[b], count, size, law.stiffness, law.width)));
  }
}

void Contacts::make_terms_of_obstacles(bool has_velocity) {
  std::vector<ContactGroup> of_pairs;
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    const ObstacleConfig& o = config_.obstacles[k];
    ContactGroup of_obstacle{o.name, ContactGroup::Kind::obstacle, {}};
    const Friction friction = config_.friction(o.drag);
    const NormalDamping damping = config_.damping(o.drag);
    for (std::size_t b = 0; b < surfaces_.size(); ++b) {
      if (has_facets_[b] == 0) continue;
      ContactGroup of_pair{o.name + "_" + body_names_[b], ContactGroup::Kind::obstacle_on_body, {}};
      const auto add = [&](std::unique_ptr<EnergyTerm> term) {
        of_obstacle.terms.push_back(term.get());
        of_pair.terms.push_back(term.get());
        terms_.push_back(std::move(term));
      };
      auto contact = std::make_unique<Contact>(surfaces_[b], obstacles_[k]);
      pairs_.push_back({k, b, contact.get()});
      add(std::move(contact));
      if (has_velocity && friction.acts()) {
        add(make_friction(surfaces_[b], obstacles_[k], friction, damping, config_.friction_update));
      }
      if (has_velocity && damping.acts()) {
        add(make_normal_damping(surfaces_[b], obstacles_[k], damping, config_.friction_update));
      }
      of_pairs.push_back(std::move(of_pair));
    }
    groups_.push_back(std::move(of_obstacle));
  }
  if (surfaces_.size() > 1) std::ranges::move(of_pairs, std::back_inserter(groups_));
}

void Contacts::check_start(const Instant& at, std::span<const double> q) const {
  for (const auto& [obstacle, body, term] : pairs_) {
    if (std::isfinite(sum(layout_.comm, term->energy_at(at, q, {})))) continue;
    const ObstacleConfig& o = config_.obstacles[obstacle];
    const double gap = start_gap(layout_.comm, *surfaces_[body], obstacles_[obstacle]->at(at), q).gap;
    throw InputError(
        o.where,
        fmt::format("'{}' touches or overlaps the obstacle '{}' at the start (gap {:.3g} m), which a barrier "
                    "does not allow; leave a gap (from {:.2g} m on, the barrier does not push), or use 'law: penalty'",
                    body_names_[body], o.name, gap, surfaces_[body]->law().reach()));
  }
  if (between_) between_->check_start(q);
}

bool Contacts::is_within_bodies(const ObstacleConfig& o, const ObstacleFrame& frame,
                                const VectorExpression& displacement) const {
  const bool has_middle = !std::holds_alternative<ObstacleConfig::Plane>(o.shape) &&
                          !std::holds_alternative<ObstacleConfig::Surface>(o.shape);
  if (!has_middle || o.side == ObstacleConfig::Side::inside) return false;
  const Vector3<double> x = frame.place(o.point);
  Vector3<double> X = x;  // reference position, if the initial displacement is uniform
  for (std::size_t i = 0; i < 3; ++i) X[i] -= displacement[i](x[0], x[1], x[2], 0.0);
  return locate(layout_, std::span(&X, 1), is_left_out_).front().distance == 0.0;
}

std::optional<Diagnostic> Contacts::warning_about_push(std::size_t obstacle, std::size_t body, const Instant& at,
                                                       std::span<const double> q) const {
  const ObstacleConfig& o = config_.obstacles[obstacle];
  const ContactSurface& surface = *surfaces_[body];
  const ObstacleFrame frame = obstacles_[obstacle]->at(at);
  double energy = 0.0;
  surface.for_each_near(frame, {q}, ContactSurface::Facets::owned, [&](const ContactSurface::Point& point) {
    energy += point.area * surface.law()(frame.distance(surface.position(point, q))).energy;
  });
  energy = sum(layout_.comm, energy);
  const Closeness mine = pliant::closeness(surface, frame, q);
  const double gap = minimum(layout_.comm, mine.gap), num_points = sum(layout_.comm, mine.num_points);
  // Beyond a barrier check_start throws. A surface that just touches may overlap by rounding. Without inertia a push is
  // a load like any other.
  if (!std::isfinite(energy) ||
      gap > surface.law().reach() - surface.law().threshold - least_push * surface.law().width ||
      (!has_inertia_ && -gap <= facet_sizes_[body])) {
    return std::nullopt;
  }
  const double distance = gap + surface.law().threshold;
  const std::string place = distance < 0.0
                                ? fmt::format("{:.3g} m deep in the obstacle '{}'", -distance, o.name)
                                : fmt::format("{:.3g} m from the obstacle '{}', where contact acts", distance, o.name);
  return Diagnostic{
      Severity::warning, o.where,
      fmt::format("'{}' starts {}, which pushes it at {:.0f} of its contact points and would throw it out with "
                  "{:.3g} J of energy from nowhere; move one of them{}",
                  body_names_[body], place, num_points, energy,
                  std::holds_alternative<ObstacleConfig::Plane>(o.shape) && -gap > facet_sizes_[body]
                      ? ", or reverse 'normal', which must point towards the bodies"
                      : "")};
}

std::vector<Diagnostic> Contacts::warnings_about_start(const Instant& at, const VectorExpression& displacement) const {
  std::vector<Diagnostic> warnings;
  const auto warn = [&](const Location& where, std::string message) {
    warnings.push_back({Severity::warning, where, std::move(message)});
  };
  if (!obstacles_.empty() && std::ranges::find(has_facets_, 1) == has_facets_.end()) {
    warn(
        config_.where,
        "nothing can touch the obstacles: constraints prescribe every displacement of the surface that may touch them");
  }
  const std::vector<double> q = initial_displacement(displacement, layout_);
  if (between_ && has_inertia_) std::ranges::move(between_->warnings_about_push(q), std::back_inserter(warnings));
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    const ObstacleConfig& o = config_.obstacles[k];
    const ObstacleFrame frame = obstacles_[k]->at(at);
    if (is_within_bodies(o, frame, displacement)) {
      warn(o.where, fmt::format("the obstacle '{}' starts inside a body, but contact acts only on the surface of the "
                                "body; move one of them",
                                o.name));
      continue;
    }
    for (std::size_t b = 0; b < body_names_.size(); ++b) {
      const double width = widths_[k], spacing = spacing_per_facet * facet_sizes_[b];
      if (has_facets_[b] != 0 && width < spacing) {
        warn(
            o.where,
            fmt::format(
                "the obstacle '{}' is {:.3g} m wide, but '{}' feels it at points that are up to {:.3g} m apart (facets "
                "of about {:.3g} m): it can pass between them; refine the mesh where they touch, or make it one of "
                "'rigid_bodies', with 'surface', 'contact.pairs' and a constraint that holds it: edges and facets then "
                "stop it, too",
                o.name, width, body_names_[b], spacing, facet_sizes_[b]));
      }
      if (auto warning = warning_about_push(k, b, at, q)) warnings.push_back(std::move(*warning));
    }
  }
  return warnings;
}

Closeness Contacts::closeness(const Instant& at, std::span<const double> q) const {
  Closeness result;
  for (const auto& obstacle : obstacles_) {
    const ObstacleFrame frame = obstacle->at(at);
    for (const auto& surface : surfaces_) {
      const Closeness one = pliant::closeness(*surface, frame, q);
      result.gap = std::min(result.gap, one.gap);
      result.num_points += one.num_points;
    }
  }
  if (between_) {
    const Closeness one = between_->closeness(q);
    result.gap = std::min(result.gap, one.gap);
    result.num_points += one.num_points;
  }
  return {minimum(layout_.comm, result.gap), sum(layout_.comm, result.num_points)};
}

void Contacts::limit_steps(bool is_limited) const {
  if (between_) between_->limit_steps(is_limited);
}

std::optional<std::string> Contacts::passage(const Instant& from, std::span<const double> q_from, const Instant& to,
                                             std::span<const double> q_to) const {
  struct Candidate {
    Passage passage;
    std::size_t obstacle = 0, body = 0;
  };
  Candidate mine;
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const ObstacleStep step{obstacles_[o]->shape(), obstacles_[o]->at(from), obstacles_[o]->at(to), widths_[o]};
    for (std::size_t b = 0; b < surfaces_.size(); ++b) {
      const auto found = pliant::passage(*surfaces_[b], step, q_from, q_to);
      if (found && found->depth > mine.passage.depth) mine = {*found, o, b};
    }
  }
  const auto all = gathered(layout_.comm, std::array{mine});
  const Candidate& deepest =
      *std::ranges::max_element(all, {}, [](const Candidate& candidate) { return candidate.passage.depth; });
  if (!(deepest.passage.depth > 0.0)) {
    if (!between_) return std::nullopt;
    if (auto found = between_->passage(q_from, q_to)) return found;
    auto crossing = between_->crossing(q_to);
    if (crossing) *crossing += " at the end of the step; use a shorter 'time.step'";
    return crossing;
  }
  const auto& [x, y, z] = deepest.passage.place;
  return fmt::format(
      "'{}' passes through the obstacle '{}': near ({:.4g}, {:.4g}, {:.4g}) its surface is {:.3g} m deep, too deep to "
      "be pushed back; use {} or a shorter 'time.step'",
      body_names_[deepest.body], config_.obstacles[deepest.obstacle].name, x, y, z, deepest.passage.depth,
      config_.pressure.law == NormalKind::barrier
          ? "a finer mesh"
          : "a finer mesh, a larger 'contact.stiffness' (the log says what it is), 'law: barrier'");
}

ContactSummary Contacts::summary(const Instant& at, std::span<const double> q) const {
  ContactSummary summary;
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    const ObstacleFrame frame = obstacles_[k]->at(at);
    const ObstacleConfig& o = config_.obstacles[k];
    ContactRow row{o.name, {}, {}, 0.0, 0.0, {}, config_.friction(o.drag).coefficient, {}};
    for (std::size_t b = 0; b < surfaces_.size(); ++b) {
      const double count =
          sum(layout_.comm, static_cast<double>(std::ranges::count(surfaces_[b]->facets().is_owned, 1)));
      const StartGap start = start_gap(layout_.comm, *surfaces_[b], frame, q);
      const StartGap nearest = nearer(row.start, start);
      if (count == 0.0 || (nearest.gap == row.start.gap && nearest.place == row.start.place)) continue;
      row.start = {start.gap, without_rounding(start.place, facet_sizes_[b])};
      row.first = body_names_[b];
      row.num_facets = count;
      row.law = surfaces_[b]->law();
    }
    summary.obstacles.push_back(row);
  }
  if (between_) between_->summarize(q, summary);
  return summary;
}

double Contacts::energy(const Instant& at, std::span<const double> q) const {
  double total = 0.0;
  for (const auto& pair : pairs_) total += pair.term->energy_at(at, q, {});
  if (between_) total += between_->energy(q);
  return total;
}

std::vector<NodalContact> Contacts::at_nodes(const Instant& at, double dt, std::span<const double> q,
                                             std::span<const double> v) const {
  std::vector<NodalContact> result(static_cast<std::size_t>(layout_.num_owned_nodes));
  for (NodalContact& node : result) node.gap = std::numeric_limits<double>::infinity();
  const auto vector_at = [](std::span<const double> values, PetscInt a) {
    return Vector3<double>{values[3 * a], values[3 * a + 1], values[3 * a + 2]};
  };
  for (const auto& obstacle : obstacles_) {
    const ObstacleFrame frame = obstacle->at(at, dt);
    for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
      NodalContact& node = result[a];
      const auto x = layout_.position(a) + vector_at(q, a);
      const DistanceAt distance = frame.at(x);
      const int body = surface_of_node_[a];
      const double threshold = body < 0 ? config_.pressure.threshold : surfaces_[body]->law().threshold;
      node.gap = std::min(node.gap, distance.d - threshold);
      if (body < 0) continue;
      const double pressure = surfaces_[body]->law()(distance.d).pressure;
      if (pressure <= 0.0) continue;
      node.pressure += pressure;
      const auto relative = vector_at(v, a) - frame.velocity(x);
      node.slip = relative - dot(relative, distance.n) * distance.n;
    }
  }
  if (!between_) return result;
  const auto of_bodies = between_->at_nodes(q, v);
  for (std::size_t a = 0; a < result.size(); ++a) {
    result[a].gap = std::min(result[a].gap, of_bodies[a].gap);
    result[a].pressure += of_bodies[a].pressure;
    result[a].slip = result[a].slip + of_bodies[a].slip;
  }
  return result;
}

}  // namespace pliant
