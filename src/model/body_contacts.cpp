#include "model/body_contacts.hpp"

#include "collision/overlaps.hpp"
#include "collision/triangle_tree.hpp"
#include "model/body_contact_laws.hpp"
#include "model/contact_defaults.hpp"
#include "model/contact_observation.hpp"
#include "model/curved_facets.hpp"
#include "model/penalty_depth.hpp"
#include "model/start_overlap.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <ranges>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The surfaces through the nodes of quadratic facets, as they are drawn, are kept apart by a barrier of this part of
/// the width. It acts where facets are bent so much that these surfaces come closer than those of the same mean.
constexpr double guard_width = 0.1;

constexpr std::size_t most_overlaps_named = 10;

}  // namespace

struct BodyContacts::Part {
  std::shared_ptr<const TouchingBodies> bodies;
  bool is_guard = false;                      // of the part before it
  std::string name;                           // may be empty
  const ContactPairConfig* config = nullptr;  // nullptr: `all`
  ContactSets sets;
  BodyContactLaws laws;
  std::vector<std::array<bool, 2>> set_is_on_side;
  std::array<double, 2> facets_of_side{};  // over all ranks
  std::vector<double> facets_of_body;
  MeasuredNodes measured;
  Friction friction;
  NormalDamping damping;
  double distance;     // beyond which gaps do not matter, the size of a facet of the body with the smallest [m]
  double depth = 0.0;  // to which a penalty pushes bodies apart [m]
  ContactObservation close, far;

  Part(const NodeLayout& layout, std::shared_ptr<const TouchingBodies> touching, double observed)
      : bodies(std::move(touching)),
        distance(observed),
        close(layout, *bodies, std::min(bodies->reach(), observed)),
        far(layout, *bodies, observed) {}

  /// As TouchingBodies::gap of this rank, up to `distance`. What is far apart takes time to find, so it is looked for
  /// only where nothing is close. Collective.
  ContactGap gap(std::span<const double> q) {
    double threshold = 0.0;
    for (const NormalLaw& law : laws.of_bodies) threshold = std::max(threshold, law.threshold);
    const auto [near, all] = close.at(q);
    const ContactGap found = bodies->gap(near, all, close.distance);
    const bool is_close = minimum(close.layout.comm, found.least) <= close.distance - threshold;
    if (is_close || close.distance >= distance) return found;
    const auto [around, extended] = far.at(q);
    return bodies->gap(around, extended, distance);
  }
};

BodyContacts::BodyContacts(const ContactConfig& config, const NodeLayout& layout,
                           std::vector<TouchingSurfaces> surfaces, const std::vector<std::string>& body_names,
                           const std::vector<double>& shear_moduli, std::span<const double> start)
    : config_(config), layout_(layout), body_names_(body_names) {
  for (const TouchingSurfaces& touching : surfaces) {
    const bool is_quadratic = touching.facets.nodes_per_facet == 6;
    if (is_quadratic && is_too_curved(layout_, touching, body_names_.size())) {
      add(touching, shear_moduli, start, FacetVertices::nodes, Role::main);
      description_.push_back(
          {Severity::warning, touching.config != nullptr ? touching.config->where : config_.where,
           fmt::format(
               "contact of {}: facets are curved by more than the distance between the surfaces allows, so that "
               "pressures act on the triangles between their nodes, and vary from node to node; use smaller "
               "facets there, or leave a wider gap",
               name_of(touching.config))});
      continue;
    }
    add(touching, shear_moduli, start, FacetVertices::mean, Role::main);
    if (is_quadratic && config_.law_of(touching.config) == NormalKind::barrier)
      add(touching, shear_moduli, start, FacetVertices::nodes, Role::guard);
  }
}

void BodyContacts::add(const TouchingSurfaces& touching, const std::vector<double>& shear_moduli,
                       std::span<const double> start, FacetVertices vertices, Role role) {
  auto surfaces = std::make_shared<const BodySurfaces>(layout_, touching.facets, touching.sides, vertices);
  const CollisionSurface& surface = surfaces->surface();
  const double triangles_per_facet = touching.facets.nodes_per_facet == 6 ? 4.0 : 1.0;
  BodyContactLaws laws = body_contact_laws(config_, touching.config, {body_names_, shear_moduli}, surface,
                                           gathered_positions(layout_, *surfaces, start), triangles_per_facet);
  const bool is_guard = role == Role::guard;
  for (NormalLaw& law : laws.of_bodies) law.width *= is_guard ? guard_width : 1.0;
  double distance = std::numeric_limits<double>::infinity();
  for (const double size : facet_sizes(surface, body_names_.size(), triangles_per_facet)) {
    if (size > 0.0) distance = std::min(distance, size);
  }
  distance = std::max(distance, laws.reach());
  const auto may_meet = bodies_that_may_meet(surface, touching.sets, body_names_.size());
  const auto [stiffest, widest] = stiffest_and_widest(laws, may_meet);
  const auto* pair = touching.config;
  const auto description =
      note(fmt::format("contact of {}: {} triangles, {}, stiffness {:.3g} Pa/m, width {:.3g} m", name_of(pair),
                       surface.triangles().size(), laws.is_penalty() ? "penalty" : "barrier", stiffest, widest));
  if (!is_guard) description_.push_back(description);
  const ContactDragConfig none;
  const ContactDragConfig& drag = pair != nullptr ? pair->drag : none;
  const Friction friction = is_guard ? Friction{} : config_.friction(drag);
  const NormalDamping damping = is_guard ? NormalDamping{} : config_.damping(drag);
  const bool has_drag = friction.acts() || damping.acts();
  const double depth = depth_of_penalty(surface, body_names_.size(), distance);
  PenaltyParts penalty;
  if (laws.is_penalty()) {
    penalty.depth = depth;
    penalty.is_mirror = touching.set_is_mirror;
    penalty.limits_steps = &limits_steps_;
    for (const auto& [first, second] : touching.set_is_on_side) penalty.has_points.push_back(first || second ? 1 : 0);
    require_two_bodies(pair, may_meet, body_names_.size());
  }
  auto bodies = std::make_shared<const TouchingBodies>(std::move(surfaces), touching.sets, laws,
                                                       has_drag ? std::optional(config_.friction_update) : std::nullopt,
                                                       std::move(penalty));
  auto part = std::make_shared<Part>(layout_, std::move(bodies), distance);
  part->depth = depth;
  part->friction = friction;
  part->damping = damping;
  part->config = pair;
  part->is_guard = is_guard;
  part->sets = touching.sets;
  part->laws = laws;
  part->set_is_on_side = touching.set_is_on_side;
  part->facets_of_body.assign(body_names_.size(), 0.0);
  for (PetscInt facet = 0; facet < touching.facets.size(); ++facet) {
    if (!touching.facets.is_owned[facet]) continue;
    const FacetSide& side = touching.sides[facet];
    part->facets_of_body[side.body] += 1.0;
    for (std::size_t k = 0; k < 2; ++k) part->facets_of_side[k] += touching.set_is_on_side[side.set][k] ? 1.0 : 0.0;
  }
  sum_in_place(layout_.comm, part->facets_of_body);
  for (double& count : part->facets_of_side) count = sum(layout_.comm, count);
  if (pair != nullptr && !pair->name.empty()) {
    part->name = pair->name;
    part->measured = std::make_shared<const std::vector<char>>(nodes_of_first_side(touching));
  }
  parts_.push_back(std::move(part));
}

std::vector<char> BodyContacts::nodes_of_first_side(const TouchingSurfaces& touching) const {
  std::vector<char> is_on_side(static_cast<std::size_t>(layout_.num_owned_nodes), 0);
  const auto n = static_cast<std::size_t>(touching.facets.nodes_per_facet);
  for (std::size_t place = 0; place < touching.facets.nodes.size(); ++place) {
    const PetscInt node = touching.facets.nodes[place];
    if (node < layout_.num_owned_nodes && touching.is_on_first_side[place / n] != 0) is_on_side[node] = 1;
  }
  return is_on_side;
}

void BodyContacts::make_terms(bool has_velocity, std::vector<std::unique_ptr<EnergyTerm>>& terms,
                              std::vector<ContactGroup>& groups) const {
  for (const auto& part : parts_) {
    ContactGroup group{part->name, ContactGroup::Kind::bodies, {}};
    const auto add = [&](std::unique_ptr<EnergyTerm> term) {
      group.terms.push_back(term.get());
      terms.push_back(std::move(term));
    };
    const FrictionUpdate update = config_.friction_update;
    add(make_body_contact(part->bodies, part->measured));
    if (has_velocity && part->friction.acts()) {
      add(make_body_friction(part->bodies, part->friction, part->damping, update, part->measured));
    }
    if (has_velocity && part->damping.acts()) {
      add(make_body_damping(part->bodies, part->damping, update, part->measured));
    }
    if (part->name.empty()) continue;
    if (part->is_guard) {
      auto& guarded = groups.back().terms;
      guarded.insert(guarded.end(), group.terms.begin(), group.terms.end());
    } else {
      groups.push_back(std::move(group));
    }
  }
}

Closeness BodyContacts::closeness(std::span<const double> q) const {
  Closeness result;
  for (const auto& part : parts_) {
    const ContactGap gap = part->gap(q);
    result.gap = std::min(result.gap, gap.least);
    if (!part->is_guard) result.num_points += gap.num_points;
  }
  return result;
}

double BodyContacts::energy(std::span<const double> q) const {
  double total = 0.0;
  for (const auto& part : parts_) {
    const auto [near, all] = part->close.at(q);
    total += part->bodies->energy(near, all);
  }
  return total;
}

std::vector<BodyContacts::AtNode> BodyContacts::at_nodes(std::span<const double> q, std::span<const double> v) const {
  std::vector<AtNode> nodes(static_cast<std::size_t>(layout_.num_owned_nodes));
  std::vector<double> touched(nodes.size(), 0.0), velocity;
  for (const auto& part : parts_) {
    const auto [near, all] = part->far.at(q);
    part->far.pairs.extend(v, velocity);
    std::vector<double> gaps(all.size() / 3, std::numeric_limits<double>::infinity());
    part->bodies->lower_gaps(near, all, part->distance, gaps);
    const std::vector<double> pressures = part->bodies->pressures(near, all);
    part->bodies->for_each_touch(near, all, [&](const Touch& touch) {
      const Vector3<double> relative = touch.combine(velocity);
      const Vector3<double> slip = relative - dot(relative, touch.normal) * touch.normal;
      for (int i = 0; i < touch.num_nodes; ++i) {
        if (!near.is_owned(touch.nodes[i])) continue;
        // The second side sees -slip.
        const double side = i < touch.num_first_nodes ? 1.0 : -1.0;
        const double share = side * std::abs(touch.weights[i]) * touch.area * touch.pressure;
        nodes[touch.nodes[i]].slip = nodes[touch.nodes[i]].slip + share * slip;
        touched[touch.nodes[i]] += std::abs(share);
      }
    });
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      nodes[a].gap = std::min(nodes[a].gap, gaps[a]);
      nodes[a].pressure += pressures[a];
    }
  }
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    if (touched[a] > 0.0) nodes[a].slip = (1.0 / touched[a]) * nodes[a].slip;
  }
  return nodes;
}

std::optional<std::string> BodyContacts::crossing(std::span<const double> q) const {
  std::vector<SurfaceCrossings> mine;
  for (const auto& part : parts_) {
    const auto [near, all] = part->close.at(q);
    const SurfaceCrossings crossings = part->bodies->crossings(near, all);
    if (crossings.count > 0) mine.push_back(crossings);
  }
  const std::vector<SurfaceCrossings> found = gathered(layout_.comm, mine);
  if (found.empty()) return std::nullopt;
  const SurfaceCrossings& first = found.front();
  const std::string& body = body_names_[static_cast<std::size_t>(first.body)];
  const auto& [x, y, z] = first.place;
  return fmt::format("{} near ({:.4g}, {:.4g}, {:.4g})",
                     first.body == first.other
                         ? fmt::format("the surface of '{}' touches or passes through itself", body)
                         : fmt::format("'{}' and '{}' touch or pass through each other", body,
                                       body_names_[static_cast<std::size_t>(first.other)]),
                     x, y, z);
}

std::vector<SurfaceOverlap> BodyContacts::overlaps(const Part& part, std::span<const Vector3<double>> x) const {
  const CollisionSurface& surface = part.bodies->surfaces().surface();
  return part.bodies->is_penalty() ? deep_overlaps(surface, x, part.sets, part.depth)
                                   : find_overlaps(surface, x, part.sets);
}

std::optional<std::string> BodyContacts::passage(std::span<const double> q_from, std::span<const double> q_to) const {
  for (const auto& part : parts_) {
    if (!part->bodies->is_penalty()) continue;
    double farthest = 0.0;
    for (const PetscInt node : part->bodies->patches().nodes) {
      const auto n = 3 * static_cast<std::size_t>(node);
      farthest = std::max(farthest, norm(Vector3<double>{q_to[n] - q_from[n], q_to[n + 1] - q_from[n + 1],
                                                         q_to[n + 2] - q_from[n + 2]}));
    }
    farthest = maximum(layout_.comm, farthest);
    const double threshold = part->laws.of_bodies.front().threshold;
    const double gap = std::min(part->distance, part->gap(q_from).least);
    const double distance = minimum(layout_.comm, gap) + threshold;
    if (distance - 2.0 * farthest > -too_deep * part->depth) continue;  // it costs more to look for what is there
    const auto x_from = gathered_positions(layout_, part->bodies->surfaces(), q_from);
    const auto x_to = gathered_positions(layout_, part->bodies->surfaces(), q_to);
    const auto overlap =
        deep_overlap_on_way(part->bodies->surfaces().surface(), {x_from, x_to, farthest}, part->sets, part->depth);
    if (!overlap) continue;
    return fmt::format(
        "'{}' comes {:.3g} m deep into '{}' near {}, too deep to be pushed back by a penalty; use a larger "
        "'stiffness' (the log says what it is), 'law: barrier' or a shorter 'time.step'",
        body_names_[static_cast<std::size_t>(overlap->body)], overlap->depth,
        body_names_[static_cast<std::size_t>(overlap->other)],
        place_text(without_rounding(overlap->place, part->distance)));
  }
  return std::nullopt;
}

std::vector<Diagnostic> BodyContacts::warnings_about_push(std::span<const double> q) const {
  std::vector<Diagnostic> warnings;
  for (const auto& part : parts_) {
    if (!part->bodies->is_penalty()) continue;
    const auto [near, all] = part->close.at(q);
    const double energy = sum(layout_.comm, part->bodies->energy(near, all));
    const ContactGap gap = part->gap(q);
    const double least = minimum(layout_.comm, gap.least), number = sum(layout_.comm, gap.num_points);
    // Surfaces that just touch may overlap by rounding.
    if (!(least < -least_push * part->laws.of_bodies.front().width) || !(energy > 0.0)) continue;
    warnings.push_back(
        {Severity::warning, part->config != nullptr ? part->config->where : config_.where,
         fmt::format("contact of {}: surfaces start up to {:.3g} m within the reach of the spring, which pushes at "
                     "{:.0f} contact points and would throw the bodies apart with {:.3g} J of energy from nowhere; "
                     "move one of them, or let 'start: resolve' do it",
                     name_of(part->config), -least, number, energy)});
  }
  return warnings;
}

void BodyContacts::check_overlaps(std::span<const double> q) const {
  std::vector<Diagnostic> diagnostics;
  OverlappingFacets facets;
  std::size_t num_overlaps = 0;
  for (const auto& part : parts_) {
    if (part->is_guard && !diagnostics.empty()) continue;
    const CollisionSurface& surface = part->bodies->surfaces().surface();
    const auto x = gathered_positions(layout_, part->bodies->surfaces(), q);
    for (const SurfaceOverlap& overlap : overlaps(*part, x)) {
      if (++num_overlaps <= most_overlaps_named) {
        diagnostics.push_back(
            {Severity::error, part->config != nullptr ? part->config->where : config_.where,
             describe(overlap, body_names_, surface.longest_edge(), config_.start, part->bodies->is_penalty())});
      }
      for (const OverlappingTriangle& of : overlap.triangles) {
        const auto& triangle = surface.triangles()[of.number];
        const auto [a, b, c] = triangle.vertices;
        facets.corners.push_back({x[a], x[b], x[c]});
        facets.bodies.push_back(triangle.body);
        facets.others.push_back(triangle.body == overlap.body ? overlap.other : overlap.body);
        facets.depths.push_back(of.depth);
      }
    }
  }
  if (diagnostics.empty()) return;
  if (num_overlaps > most_overlaps_named) {
    diagnostics.push_back({Severity::error, config_.where,
                           fmt::format("{} more pairs of bodies overlap", num_overlaps - most_overlaps_named)});
  }
  throw OverlapError(std::move(diagnostics), std::move(facets));
}

void BodyContacts::check_start(std::span<const double> q) const {
  if (const auto what = crossing(q)) {
    check_overlaps(q);
    throw InputError(config_.where, *what +
                                        " at the start, which the barrier does not allow; move one of them, or "
                                        "exclude them from contact ('exclude')");
  }
  for (const auto& part : parts_) {
    if (part->bodies->is_penalty()) continue;
    const double gap = minimum(layout_.comm, part->gap(q).least);
    if (gap > 0.0) continue;
    ContactSummary summary;
    summarize(q, summary);
    const auto nearest =
        std::ranges::min_element(summary.pairs, {}, [](const ContactRow& row) { return row.start.gap; });
    const std::string pair = nearest == summary.pairs.end() ? "surfaces"
                             : nearest->second.empty()      ? fmt::format("parts of '{}'", nearest->first)
                                                       : fmt::format("'{}' and '{}'", nearest->first, nearest->second);
    throw InputError(config_.where,
                     fmt::format("{} {}{}, and the barrier needs a gap between them, however small; move one of them "
                                 "away from the other",
                                 pair,
                                 gap < 0.0 ? fmt::format("start {:.3g} m nearer than their 'thickness'", -gap)
                                           : std::string("touch at the start"),
                                 nearest == summary.pairs.end() ? "" : " at " + place_text(nearest->start.place)));
  }
}

void BodyContacts::summarize(std::span<const double> q, ContactSummary& summary) const {
  for (const auto& part : parts_) {
    if (part->is_guard) continue;
    const CollisionSurface& surface = part->bodies->surfaces().surface();
    const auto x = gathered_positions(layout_, part->bodies->surfaces(), q);
    const auto triangles = surface.triangles();
    const double far = std::max(surface.longest_edge(), part->laws.reach());
    const auto may_touch = [&](std::int32_t s, std::int32_t t) {
      return part->sets(triangles[s].group, triangles[t].group) && !part->bodies->are_neighbours(s, t);
    };
    const auto tree_of = [&](const auto& belongs) {
      std::vector<std::int32_t> numbers;
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (belongs(triangles[t])) numbers.push_back(static_cast<std::int32_t>(t));
      }
      return TriangleTree(surface, x, std::move(numbers));
    };
    const auto gap_of = [&](const NearestPlaces& nearest) {
      return StartGap{nearest.distance - part->laws.of(nearest.body, nearest.other).threshold,
                      without_rounding(nearest.place, surface.longest_edge())};
    };
    ContactRow row{part->name, {}, {}, 0.0, 0.0, {}, part->friction.coefficient, {}};
    if (part->config != nullptr) {
      const auto is_on_side = [&](std::size_t side) {
        return [&, side](const CollisionSurface::Triangle& t) { return part->set_is_on_side[t.group][side]; };
      };
      // What touches itself is only asked for what comes near: all of it is near its neighbours.
      const double within = part->config->with ? std::numeric_limits<double>::infinity() : far;
      const TriangleTree first = tree_of(is_on_side(0)), second = tree_of(is_on_side(1));
      const auto nearest = nearest_places(first, second, within, may_touch);
      const auto body_of = [&](const TriangleTree& tree) {
        return std::ranges::min(tree.numbers() |
                                std::views::transform([&](std::int32_t t) { return triangles[t].body; }));
      };
      const bool is_found = std::isfinite(nearest.distance);
      row.first = part->config->part.value;
      row.second = part->config->with ? part->config->with->value : std::string();
      row.num_facets = part->facets_of_side[0];
      row.num_other_facets = part->facets_of_side[1];
      row.law = is_found ? part->laws.of(nearest.body, nearest.other) : part->laws.of(body_of(first), body_of(second));
      row.start = gap_of(nearest);
      summary.pairs.push_back(row);
      continue;
    }
    summary.far = far;
    const auto may_meet = bodies_that_may_meet(surface, part->sets, body_names_.size());
    std::vector<TriangleTree> trees;
    for (std::size_t b = 0; b < body_names_.size(); ++b) {
      trees.push_back(tree_of([&](const CollisionSurface::Triangle& t) { return t.body == static_cast<int>(b); }));
    }
    for (std::size_t a = 0; a < trees.size(); ++a) {
      for (std::size_t b = a; b < trees.size(); ++b) {
        if (may_meet[a * trees.size() + b] == 0) continue;
        row.law = part->laws.of(static_cast<int>(a), static_cast<int>(b));
        const double within = a == b ? row.law.reach() : far;
        const auto nearest = nearest_places(trees[a], trees[b], within, may_touch);
        if (!(nearest.distance < within)) {
          summary.num_far_pairs += a == b ? 0 : 1;
          continue;
        }
        row.first = body_names_[a];
        row.second = a == b ? std::string() : body_names_[b];
        row.num_facets = part->facets_of_body[a];
        row.num_other_facets = part->facets_of_body[b];
        row.start = gap_of(nearest);
        summary.pairs.push_back(row);
      }
    }
  }
}

}  // namespace pliant
