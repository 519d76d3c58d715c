/// The terms of contact of the bodies with one another and with themselves, and what is measured of it.
#pragma once

#include "energy/contact/body_contact.hpp"
#include "energy/contact/passage.hpp"
#include "energy/pairs/pair_assembly.hpp"
#include "model/touching_surfaces.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

class BodyContacts {
 public:
  /// `shear_moduli`: of each body's stiffest part at rest [Pa]. Everything outlives the object. Throws InputError where
  /// a body is thinner than the distance that its surface has to keep from itself. Collective.
  BodyContacts(const ContactConfig& config, const NodeLayout& layout, std::vector<TouchingSurfaces> surfaces,
               const std::vector<std::string>& body_names, const std::vector<double>& shear_moduli);

  std::vector<const EnergyTerm*> terms() const;
  /// Whether everything may touch everything: then no body can pass through another.
  bool includes_all() const { return config_.pairs.all && config_.exclude.empty(); }
  /// Notes of what was derived from material and mesh.
  const std::vector<Diagnostic>& description() const { return description_; }

  /// The part of this rank; distances beyond the longest edge count as infinite. Collective.
  Closeness closeness(std::span<const double> q) const;
  /// The energy of this rank's part [J]. Collective.
  double energy(std::span<const double> q) const;
  /// The gap of each owned node to what it may touch, and its pressure [Pa]: both as of `closeness`. Collective.
  struct AtNode {
    double gap = std::numeric_limits<double>::infinity(), pressure = 0.0;
  };
  std::vector<AtNode> at_nodes(std::span<const double> q) const;
  /// Says what crosses, or touches, and where; nothing if nothing does. Collective.
  std::optional<std::string> crossing(std::span<const double> q) const;
  /// Throws InputError if surfaces cross or touch. Collective.
  void check_start(std::span<const double> q) const;

 private:
  /// A term with the search for what is near it, apart from that of the solver.
  struct Part;
  void add(TouchingSurfaces surfaces, const std::vector<double>& shear_moduli);
  BodyContactLaws laws_of(const CollisionSurface& surface, double triangles_per_facet, const ContactPairConfig* pair,
                          const std::vector<double>& shear_moduli);

  const ContactConfig& config_;
  const NodeLayout& layout_;
  const std::vector<std::string>& body_names_;
  std::vector<std::shared_ptr<Part>> parts_;
  std::vector<Diagnostic> description_;
};

}  // namespace pliant
