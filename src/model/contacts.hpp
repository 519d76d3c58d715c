/// The contact of the input: of the bodies with obstacles, and with one another.
#pragma once

#include "energy/contact/contact.hpp"
#include "energy/contact/passage.hpp"
#include "fem/layout.hpp"
#include "input/analysis.hpp"
#include "input/config.hpp"
#include "model/body_contacts.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// What can touch obstacles; must outlive the terms.
struct ContactBodies {
  const FacetList& facets;  ///< of the surface, and segments of rods; may touch
  const NodeLayout& layout;
  const BlockPattern& pattern;
  const std::vector<int>& body_of_cell;     ///< per local cell
  const std::vector<std::string>& names;    ///< of the bodies
  const std::vector<double>& shear_moduli;  ///< per body, of its stiffest part at rest [Pa]
  const std::vector<char>& prescribed;      ///< one flag per local entry
  const std::vector<int>& rigid_part;       ///< of each local node, from 1; 0: it is of none
  const ThinBodies& thin;
  const std::vector<double>& start;   ///< displacements of local nodes at the start [m]
  std::span<const char> is_left_out;  ///< local cells that are not of the mesh (cells_without_mesh)
};

/// Contact at a node.
struct NodalContact {
  double gap = 0.0;        ///< to the nearest obstacle's spring or wall [m]
  double pressure = 0.0;   ///< [Pa]
  Vector3<double> slip{};  ///< tangential velocity relative to the obstacle that it touches [m/s]
};

class Contacts {
 public:
  /// The facets take part unless all their entries are prescribed. A static analysis has no velocity, so neither
  /// friction nor damping. Collective.
  Contacts(const ContactConfig& config, Analysis analysis, const ContactBodies& bodies,
           std::vector<TouchingSurfaces> touching);

  std::span<const std::unique_ptr<EnergyTerm>> terms() const { return terms_; }
  /// Contact of the bodies with one another; nullptr if the input has none.
  const BodyContacts* between_bodies() const { return between_.get(); }
  /// Groups of the obstacles, in the order of the input, then, if there are several bodies, those of the obstacles on
  /// each of them, then those of the pairs of bodies that have names.
  const std::vector<ContactGroup>& groups() const { return groups_; }
  std::size_t num_obstacles() const { return obstacles_.size(); }
  std::span<const std::shared_ptr<const Obstacle>> obstacles() const { return obstacles_; }

  /// How close the bodies are to the obstacles. Collective.
  Closeness closeness(const Instant& at, std::span<const double> q) const;
  /// A message if a body passes through an obstacle between two states. Collective.
  std::optional<std::string> passage(const Instant& from, std::span<const double> q_from, const Instant& to,
                                     std::span<const double> q_to) const;
  /// Whether steps of a solver stop where a penalty between bodies would be pressed in too deeply. This takes more of
  /// them where they would come back by themselves; so it is for what has failed without. Nothing else changes.
  void limit_steps(bool is_limited) const;

  bool has_barrier() const { return config_.has_barrier(); }

  /// Throws InputError if a body overlaps a barrier. Collective.
  void check_start(const Instant& at, std::span<const double> q) const;
  /// What may touch, and how far apart it starts: the same on any number of ranks. Collective.
  ContactSummary summary(const Instant& at, std::span<const double> q) const;
  /// Warnings about surfaces that cannot touch anything, obstacles inside a body or narrower than the distance of its
  /// contact points, and bodies on which contact acts at the start. Collective.
  std::vector<Diagnostic> warnings_about_start(const Instant& at, const VectorExpression& displacement) const;
  /// The energy of this rank's part of all contacts [J]. Collective.
  double energy(const Instant& at, std::span<const double> q) const;
  /// Contact at the owned nodes; nodes inside the bodies have only a gap. `dt`: the time over which velocities of
  /// obstacles are averaged. Collective.
  std::vector<NodalContact> at_nodes(const Instant& at, double dt, std::span<const double> q,
                                     std::span<const double> v) const;
  /// Notes about what was derived from material and mesh.
  const std::vector<Diagnostic>& description() const { return description_; }

 private:
  struct Pair {
    std::size_t obstacle, body;
    const Contact* term;
  };
  void add_surfaces(const ContactBodies& bodies);
  void make_terms_of_obstacles(bool has_velocity);
  /// A warning if an obstacle pushes a body at the start. Collective.
  std::optional<Diagnostic> warning_about_push(std::size_t obstacle, std::size_t body, const Instant& at,
                                               std::span<const double> q) const;
  /// Is the middle of the obstacle in the material at the start? Collective.
  bool is_within_bodies(const ObstacleConfig& o, const ObstacleFrame& frame,
                        const VectorExpression& displacement) const;

  ContactConfig config_;
  const NodeLayout& layout_;
  std::vector<std::string> body_names_;
  std::vector<char> is_left_out_;
  std::vector<std::shared_ptr<const Obstacle>> obstacles_;
  std::vector<double> widths_;                                   // of the obstacles [m]
  std::vector<std::shared_ptr<const ContactSurface>> surfaces_;  // of the bodies
  std::vector<int> surface_of_node_;                             // per owned node: its body, -1 inside the bodies
  std::vector<double> facet_sizes_;                              // per body [m]
  std::vector<char> has_facets_;                                 // per body, on any rank
  std::vector<std::unique_ptr<EnergyTerm>> terms_;
  std::vector<Pair> pairs_;
  std::vector<ContactGroup> groups_;
  std::unique_ptr<BodyContacts> between_;
  std::vector<Diagnostic> description_;
  bool has_inertia_;
};

}  // namespace pliant
