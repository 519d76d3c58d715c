#include "model/tendons.hpp"

#include "mesh/chain.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

using Place = std::array<double, 3>;

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
  Points(const BodiesOnMesh& bodies, const Mesh& mesh, Selections& selections)
      : bodies_(bodies), mesh_(mesh), selections_(selections) {}

  std::vector<BodyPoint> of(const TendonConfig& tendon) {
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
      const char* fault =
          directed_curve(part) != nullptr ? "no common direction" : "no directions in Pliant's own mesh format";
      fail(tendon,
           fmt::format("the edges of physical curve '{}' have {}: with friction it matters where tendon '{}' is "
                       "pulled; say 'pulled_at: [x, y, z]', a place near that end",
                       tendon.curve, fault, tendon.name));
      return {};
    }
    if (tendon.pulled_at) {
      const auto far = [&](const Place& X) { return norm(Vector3<double>(X) - Vector3<double>(*tendon.pulled_at)); };
      if (far(chain.points.back()) < far(chain.points.front())) std::ranges::reverse(chain.points);
    }
    std::vector<BodyPoint> points;
    for (const Place& X : chain.points) points.push_back({{}, X, tendon.where});
    return points;
  }
  std::vector<Diagnostic>& errors() { return errors_; }

 private:
  /// The curve with the directions of its edges, which Pliant's own mesh format does not have; nullptr without.
  const MeshCurve* directed_curve(const Selection& part) const {
    const auto is_it = [&](const MeshCurve& curve) {
      return curve.group.name == part.name || std::to_string(curve.group.tag) == part.name;
    };
    const auto found = std::ranges::find_if(mesh_.curves, is_it);
    return found == mesh_.curves.end() ? nullptr : &*found;
  }
  Chain chain_in_mesh(const Selection& part) {
    const MeshCurve* found = directed_curve(part);
    if (found == nullptr) {
      const auto edges = edges_of_cells(bodies_.layout, selections_.edges(part));
      if (edges.empty()) return {};  // has been reported
      Chain chain = chain_of(edges, "a tendon");
      chain.is_directed = false;  // whatever directions they happen to have
      return chain;
    }
    selections_.use(part);
    Chain chain = chain_of(found->edges, "a tendon");
    if (chain.fault.empty()) chain.points = halved(std::move(chain.points), bodies_.config.mesh.refine);
    return chain;
  }
  void fail(const TendonConfig& tendon, std::string message) {
    errors_.push_back({Severity::error, tendon.where, std::move(message)});
  }

  const BodiesOnMesh& bodies_;
  const Mesh& mesh_;
  Selections& selections_;
  std::vector<Diagnostic> errors_;
};

TendonDrive drive_of(const TendonConfig& tendon) {
  if (tendon.tension) return GivenTension{*tendon.tension};
  return TendonSpring{*tendon.stiffness, *tendon.pull};
}

double turn_of(const std::vector<BodyPoint>& points) {
  double turn = 0.0;
  for (std::size_t k = 2; k < points.size(); ++k) {
    const Vector3<double> X = points[k - 1].point, a = X - Vector3<double>(points[k - 2].point),
                          b = Vector3<double>(points[k].point) - X;
    turn += std::atan2(norm(cross(a, b)), dot(a, b));
  }
  return turn;
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
  const auto x = places_of(tendon.points, layout, u), d = field_at(tendon.points, layout, u);
  double sum = 0.0;
  for (std::size_t k = 1; k < x.size(); ++k) {
    const Vector3<double> now = x[k] - x[k - 1], change = d[k] - d[k - 1], then = now - change;
    sum += dot(change, now + then) / (norm(now) + norm(then));
  }
  return sum;
}

std::vector<double> tensions_of(const ModelTendon& tendon, const NodeLayout& layout, std::span<const double> u,
                                std::span<const double> v, const Instant& at) {
  const double longer = lengthening_of(tendon, layout, u);
  const double T = tension_at_pulled_end(tendon.drive, longer, at.time, at.load_factor);
  if (tendon.friction == nullptr) return std::vector<double>(tendon.points.size() - 1, T);
  return tendon.friction->tensions(T, places_of(tendon.points, layout, u), field_at(tendon.points, layout, v));
}

std::vector<ModelTendon> make_tendons(const BodiesOnMesh& bodies, const Mesh& mesh, Selections& selections) {
  std::vector<ModelTendon> result;
  Points points(bodies, mesh, selections);
  for (const TendonConfig& tendon : bodies.config.tendons) {
    const std::vector<BodyPoint> given = points.of(tendon);
    if (given.empty()) continue;
    ModelTendon made{tendon.name, {}, drive_of(tendon), {}, {}};
    for (std::size_t k = 1; k < given.size(); ++k) {
      made.length += norm(Vector3<double>(given[k].point) - Vector3<double>(given[k - 1].point));
    }
    const double apart = made.length / static_cast<double>(given.size() - 1);
    made.points = attach(bodies, given, {"tendon '" + tendon.name + "'", apart}, points.errors());
    if (!points.errors().empty()) continue;
    made.turn = turn_of(given);
    const bool rubs = tendon.friction > 0.0;
    const auto path = std::make_shared<TendonPath>(bodies.layout, made.points,
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
