/// The terms of contact of the bodies with one another and with themselves, and what is measured of it.
#pragma once

#include "collision/overlaps.hpp"
#include "energy/contact/body_contact.hpp"
#include "energy/contact/passage.hpp"
#include "energy/pairs/pair_assembly.hpp"
#include "model/contact_summary.hpp"
#include "model/touching_surfaces.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Terms whose forces are summed in history.csv.
struct ContactGroup {
  enum class Kind {
    obstacle,          ///< the force of an obstacle on all bodies
    obstacle_on_body,  ///< the force of an obstacle on one body
    bodies             ///< the force between two parts of bodies
  };
  std::string name;
  Kind kind;
  std::vector<const EnergyTerm*> terms;
};

class BodyContacts {
 public:
  /// `shear_moduli`: of each body's stiffest part at rest [Pa]. `start`: displacements of local nodes at the start [m].
  /// Everything but the surfaces and the start outlives the object. Throws InputError where
  /// a body is thinner than the distance that its surface has to keep from itself. Collective.
  BodyContacts(const ContactConfig& config, const NodeLayout& layout, std::vector<TouchingSurfaces> surfaces,
               const std::vector<std::string>& body_names, const std::vector<double>& shear_moduli,
               std::span<const double> start);

  /// Appends the terms, and a group for each pair that has a name. `has_velocity`: there may be friction and damping.
  void make_terms(bool has_velocity, std::vector<std::unique_ptr<EnergyTerm>>& terms,
                  std::vector<ContactGroup>& groups) const;
  /// Notes of what was derived from material and mesh.
  const std::vector<Diagnostic>& description() const { return description_; }

  /// A warning for each penalty that pushes bodies at the start. Collective.
  std::vector<Diagnostic> warnings_about_push(std::span<const double> q) const;

  /// The part of this rank; distances beyond the longest edge count as infinite. Collective.
  Closeness closeness(std::span<const double> q) const;
  /// The energy of this rank's part [J]. Collective.
  double energy(std::span<const double> q) const;
  /// The gap of each owned node to what it may touch, as of `closeness`, its pressure [Pa], and its velocity along the
  /// surfaces relative to what it touches [m/s]. Collective.
  struct AtNode {
    double gap = std::numeric_limits<double>::infinity(), pressure = 0.0;
    Vector3<double> slip{};
  };
  std::vector<AtNode> at_nodes(std::span<const double> q, std::span<const double> v) const;
  /// Says which bodies a step takes too deeply into each other for a penalty to part them. Collective.
  std::optional<std::string> passage(std::span<const double> q_from, std::span<const double> q_to) const;
  /// Contacts::limit_steps.
  void limit_steps(bool is_limited) { limits_steps_ = is_limited; }
  /// Says what crosses a barrier, or touches, and where; nothing if nothing does. Collective.
  std::optional<std::string> crossing(std::span<const double> q) const;
  /// Throws InputError if surfaces cross or touch: an OverlapError with what does, the same on any number of ranks.
  /// Collective.
  void check_start(std::span<const double> q) const;
  /// Throws OverlapError if surfaces cross or touch, or a body lies in another one; for a penalty only if they are too
  /// deep in each other. Gathers all positions. Collective.
  void check_overlaps(std::span<const double> q) const;
  /// Adds the entries, or the pairs of bodies, with their gaps at q. Gathers all positions. Collective.
  void summarize(std::span<const double> q, ContactSummary& summary) const;

 private:
  /// An entry of `contact.pairs`, with a search for what is near apart from that of the solver.
  struct Part;
  enum class Role {
    main,
    guard  ///< keeps surfaces apart in addition to a main part
  };
  void add(const TouchingSurfaces& surfaces, const std::vector<double>& shear_moduli, std::span<const double> start,
           FacetVertices vertices, Role role);
  /// What overlaps; for a penalty only what is too deep. Gathers all positions. Collective.
  std::vector<SurfaceOverlap> overlaps(const Part& part, std::span<const Vector3<double>> x) const;
  /// A flag for each owned node.
  std::vector<char> nodes_of_first_side(const TouchingSurfaces& touching) const;

  const ContactConfig& config_;
  bool limits_steps_ = false;
  const NodeLayout& layout_;
  const std::vector<std::string>& body_names_;
  std::vector<std::shared_ptr<Part>> parts_;
  std::vector<Diagnostic> description_;
};

}  // namespace pliant
