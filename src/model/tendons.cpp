#include "model/tendons.hpp"

#include "fem/straight_cell.hpp"
#include "model/tendon_curve.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

using Point = TendonConfig::Point;
using Place = std::array<double, 3>;

/// How far outside the mesh a point may lie, in units of the distance to the next one: rounding, and curved surfaces.
constexpr double slack = 1e-3;

/// The edges of a curve in Pliant's own mesh format, without their directions. Collective.
std::vector<MeshCurve::Edge> edges_of_cells(const NodeLayout& layout, const EdgeList& list) {
  std::vector<MeshCurve::Edge> mine;
  for (PetscInt e = 0; e < list.size(); ++e) {
    if (!list.is_owned[e]) continue;
    const PetscInt* nodes = &list.nodes[static_cast<std::size_t>(e * list.nodes_per_edge)];
    mine.push_back({layout.position(nodes[0]), layout.position(nodes[1])});
  }
  return gathered(layout.comm, mine);
}

/// Points of tendons as if all of them had been given one by one.
class Points {
 public:
  Points(const Config& config, const TendonMesh& on, Selections& selections)
      : config_(config), on_(on), selections_(selections) {}

  std::vector<Point> of(const TendonConfig& tendon) {
    if (tendon.curve.empty()) return tendon.points;
    Selection part;
    part.kind = Selection::Kind::curve;
    part.name = tendon.curve;
    part.where = tendon.where;
    if (!selections_.has_group(part.kind, part.name)) {
      selections_.use(part);
      return {};
    }
    Chain chain = chain_in_mesh(part);
    if (!chain.fault.empty()) {
      fail(tendon,
           fmt::format("physical curve '{}', which tendon '{}' follows, {}", tendon.curve, tendon.name, chain.fault));
      return {};
    }
    if (!tendon.pulled_at && !chain.is_directed && tendon.friction > 0.0) {
      fail(tendon, fmt::format("the edges of physical curve '{}' have no common direction: with friction it matters "
                               "where tendon '{}' is pulled; say 'pulled_at: [x, y, z]', a place near that end",
                               tendon.curve, tendon.name));
      return {};
    }
    if (tendon.pulled_at) {
      const auto far = [&](const Place& X) { return norm(Vector3<double>(X) - Vector3<double>(*tendon.pulled_at)); };
      if (far(chain.points.back()) < far(chain.points.front())) std::ranges::reverse(chain.points);
    }
    std::vector<Point> points;
    for (const Place& X : chain.points) points.push_back({X, {}, tendon.where});
    return points;
  }
  std::vector<Diagnostic>& errors() { return errors_; }

 private:
  Chain chain_in_mesh(const Selection& part) {
    const auto is_it = [&](const MeshCurve& curve) {
      return curve.group.name == part.name || std::to_string(curve.group.tag) == part.name;
    };
    const auto found = std::ranges::find_if(on_.mesh.curves, is_it);
    if (found == on_.mesh.curves.end()) {
      const auto edges = edges_of_cells(on_.layout, selections_.edges(part));
      return edges.empty() ? Chain{} : chain_of(edges);  // none has been reported
    }
    selections_.use(part);
    Chain chain = chain_of(found->edges);
    if (chain.fault.empty()) chain.points = halved(std::move(chain.points), config_.mesh.refine);
    return chain;
  }
  void fail(const TendonConfig& tendon, std::string message) {
    errors_.push_back({Severity::error, tendon.where, std::move(message)});
  }

  const Config& config_;
  const TendonMesh& on_;
  Selections& selections_;
  std::vector<Diagnostic> errors_;
};

/// The place as weights of the corners of the largest cell of a body that moves affinely. Collective.
ProbeLocation location_in_body(const TendonMesh& on, int body, const Place& X) {
  struct {
    double volume = 0.0;
    int rank = 0;
  } mine, largest;
  mine.rank = rank(on.layout.comm);
  std::array<Vector3<double>, 4> corners{};
  PetscInt cell = -1;
  for (PetscInt c = 0; c < on.layout.num_owned_cells; ++c) {
    if (on.body_of_cell[static_cast<std::size_t>(c)] != body) continue;
    std::array<Vector3<double>, 4> x;
    for (std::size_t a = 0; a < 4; ++a) x[a] = on.layout.position(on.layout.nodes_of_cell(c)[a]);
    const double volume = dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0]));
    if (volume <= mine.volume) continue;
    mine.volume = volume;
    cell = c;
    corners = x;
  }
  check_mpi(MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE_INT, MPI_MAXLOC, on.layout.comm));
  ProbeLocation result;
  if (largest.rank != mine.rank || cell < 0) return result;
  const auto gradients = linear_gradients(corners);
  for (std::size_t a = 0; a < 4; ++a) {
    result.nodes.push_back(on.layout.nodes_of_cell(cell)[a]);
    result.weights.push_back((a == 0 ? 1.0 : 0.0) + dot(gradients[a], Vector3<double>(X) - corners[0]));
  }
  return result;
}

/// The number of the rigid body of this name.
int rigid_body_named(const Config& config, const std::string& name) {
  const auto is_it = [&](const BodyConfig& body) {
    return body.is_rigid && (body.part.name.empty() ? "body" : body.part.name) == name;
  };
  return static_cast<int>(std::ranges::find_if(config.bodies, is_it) - config.bodies.begin());
}

/// Collective.
std::vector<TendonPoint> located(const Config& config, const TendonMesh& on, const std::vector<Point>& points) {
  std::vector<TendonPoint> result;
  std::vector<Place> in_cells;
  for (const Point& point : points) {
    TendonPoint& located = result.emplace_back();
    if (point.body.empty()) {
      in_cells.push_back(point.place);
    } else if (point.body == "ground") {
      located.rest = point.place;
    } else {
      located.location = location_in_body(on, rigid_body_named(config, point.body), point.place);
    }
  }
  const auto locations = locate(on.layout, in_cells, on.is_left_out);
  for (std::size_t k = 0, next = 0; k < points.size(); ++k) {
    if (points[k].body.empty()) result[k].location = locations[next++];
  }
  return result;
}

/// Collective.
void require_in_mesh(const TendonConfig& tendon, const TendonMesh& on, const std::vector<Point>& given,
                     const std::vector<TendonPoint>& points, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!given[k].body.empty() || points[k].location.distance == 0.0) continue;
    const Vector3<double> X = given[k].place, next = given[k == 0 ? 1 : k - 1].place;
    const double far = nearest_of_mesh(on.layout, given[k].place, on.is_left_out).distance;
    if (far <= slack * norm(next - X)) continue;
    errors.push_back(
        {Severity::error, given[k].where,
         fmt::format("point {} of tendon '{}' at ({:g}, {:g}, {:g}) lies {:.3g} m outside the mesh; its points are "
                     "places in the bodies, or '{{body: name, point: [..]}}' for one fixed to a rigid body or the "
                     "ground",
                     k, tendon.name, X[0], X[1], X[2], far)});
  }
}

TendonDrive drive_of(const TendonConfig& tendon) {
  if (tendon.tension) return GivenTension{*tendon.tension};
  return TendonSpring{*tendon.stiffness, *tendon.pull};
}

double turn_of(const std::vector<Point>& points) {
  double turn = 0.0;
  for (std::size_t k = 2; k < points.size(); ++k) {
    const Vector3<double> X = points[k - 1].place, a = X - Vector3<double>(points[k - 2].place),
                          b = Vector3<double>(points[k].place) - X;
    turn += std::atan2(norm(cross(a, b)), dot(a, b));
  }
  return turn;
}

/// x of each point at displacements u, or X where there are none; xyz one after another. Collective.
std::vector<Vector3<double>> places_of(const std::vector<TendonPoint>& points, const NodeLayout& layout,
                                       std::span<const double> u) {
  std::vector<double> sums;
  for (const TendonPoint& point : points) {
    const auto x = point.location.interpolate(u);
    sums.insert(sums.end(), x.begin(), x.end());
  }
  sum_in_place(layout.comm, sums);
  std::vector<Vector3<double>> places;
  for (std::size_t k = 0; k < points.size(); ++k) places.push_back({sums[3 * k], sums[3 * k + 1], sums[3 * k + 2]});
  return places;
}

}  // namespace

std::vector<std::string> curves_of_tendons(const Config& config) {
  std::vector<std::string> names;
  for (const TendonConfig& tendon : config.tendons) {
    if (!tendon.curve.empty()) names.push_back(tendon.curve);
  }
  return names;
}

double lengthening_of(const ModelTendon& tendon, const NodeLayout& layout, std::span<const double> u) {
  std::vector<Vector3<double>> X = places_of(tendon.points, layout, layout.coordinates);
  const std::vector<Vector3<double>> d = places_of(tendon.points, layout, u);
  double sum = 0.0;
  for (std::size_t k = 0; k < X.size(); ++k) X[k] = X[k] + tendon.points[k].rest;
  for (std::size_t k = 1; k < X.size(); ++k) {
    const Vector3<double> then = X[k] - X[k - 1], change = d[k] - d[k - 1], now = then + change;
    sum += dot(change, now + then) / (norm(now) + norm(then));
  }
  return sum;
}

std::vector<ModelTendon> make_tendons(const Config& config, const TendonMesh& on, Selections& selections) {
  std::vector<ModelTendon> result;
  Points points(config, on, selections);
  for (const TendonConfig& tendon : config.tendons) {
    const std::vector<Point> given = points.of(tendon);
    if (given.empty()) continue;
    ModelTendon made{tendon.name, located(config, on, given), drive_of(tendon), {}, {}};
    require_in_mesh(tendon, on, given, made.points, points.errors());
    for (std::size_t k = 1; k < given.size(); ++k) {
      made.length += norm(Vector3<double>(given[k].place) - Vector3<double>(given[k - 1].place));
    }
    made.turn = turn_of(given);
    const bool rubs = tendon.friction > 0.0;
    const auto path = std::make_shared<TendonPath>(on.layout, made.points,
                                                   rubs ? TendonPath::Couples::all : TendonPath::Couples::neighbours);
    made.term = std::make_unique<Tendon>(path, made.drive);
    if (rubs) {
      made.friction =
          std::make_unique<TendonFriction>(path, made.drive, Friction{tendon.friction, 0.0, tendon.stick_velocity});
    }
    result.push_back(std::move(made));
  }
  selections.throw_if_errors();
  if (!points.errors().empty()) throw InputError(std::move(points.errors()));
  return result;
}

}  // namespace pliant
