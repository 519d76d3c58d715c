/// The input file as typed values in SI units. All defaults of keys are in the key table (input/keys), none is here.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"
#include "input/located.hpp"
#include "input/material_config.hpp"
#include "input/mechanism_config.hpp"
#include "input/mesh_config.hpp"
#include "input/output_config.hpp"
#include "input/selection.hpp"
#include "input/shell_config.hpp"
#include "input/viscosity_config.hpp"
#include "material/contact_law.hpp"
#include "material/foundation.hpp"
#include "material/volumetric_form.hpp"
#include "time/method.hpp"
#include "time/startup.hpp"

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

enum class ElementOrder { p1 = 1, p2 = 2 };
/// How bodies resist a change of volume: at every point, by the mean over each cell, or by pressures as unknowns.
enum class VolumetricTreatment { standard, mean_dilatation, mixed };
enum class MassKind { consistent, lumped };

/// Contraction along fibres; functions of x, y, z, t.
struct ActiveConfig {
  struct Stress {
    Expression tension;  ///< per reference area [Pa]
  };
  struct Shortening {
    Expression part;  ///< of the fibres' length
  };
  std::vector<GivenDirection> fibre;  ///< empty: that of the elastic law
  std::variant<Stress, Shortening> contraction;
  Location where;
};

struct BodyConfig {
  Selection part;                 ///< volume, or everything
  std::optional<double> density;  ///< [kg/m^3]; required for dynamics and gravity
  bool is_rigid = false;
  bool is_rod = false;                         ///< a rod, or a section of one; not from a key of the body
  bool is_shell = false;                       ///< a free shell; not from a key of the body
  std::vector<Located<std::string>> attached;  ///< of a rigid body: names of surfaces of others that move with it
  std::vector<Located<std::string>> coupled;   ///< of a rigid body: names of surfaces whose mean motion it follows
  std::optional<double> coupling_stiffness;    ///< of these [N/m]; none: from the material and the area
  std::optional<ElasticityConfig> elasticity;  ///< of a body that is not rigid
  std::vector<ViscosityConfig> viscosity;
  std::optional<ActiveConfig> active;
  std::optional<ExpansionConfig> expansion;
  std::optional<MullinsConfig> mullins;
  Location where;
};

using OptionalVectorExpression = std::array<std::optional<Expression>, 3>;  ///< an empty component is free

struct RotationConfig {
  struct Free {};
  struct Fixed {};
  struct AboutAxis {
    std::array<double, 3> axis;       ///< of any length
    std::optional<Expression> angle;  ///< [rad]; empty: free
  };
  std::variant<Free, Fixed, AboutAxis> kind;
  Location where;
};

/// coefficient times a component of the mean displacement of some nodes
struct EquationTermConfig {
  Selection part;
  int component = 0;
  double coefficient = 1;
  Location where;
};

/// A prescribed displacement (Dirichlet boundary condition), or a tie (multi-point constraint).
struct ConstraintConfig {
  struct Displacement {
    OptionalVectorExpression value;  ///< [m]
  };
  struct Symmetry {
    bool operator==(const Symmetry&) const = default;
  };
  struct Normal {
    Expression displacement;  ///< along the outward normal [m]
  };
  struct Along {
    Expression displacement;          ///< [m]
    std::array<double, 3> direction;  ///< of any length
  };
  struct Periodic {
    Selection partner;                    ///< the surface that `part` repeats
    OptionalVectorExpression difference;  ///< [m]
  };
  struct Tied {
    Selection partner;                ///< the surface whose facets the nodes of `part` follow
    std::optional<double> tolerance;  ///< [m]; empty: from the size of the facets
  };
  struct Rigid {
    OptionalVectorExpression translation;  ///< of the centre [m]
    RotationConfig rotation;
    std::optional<std::array<double, 3>> center;  ///< [m]; empty: the part's centroid
    std::vector<Selection> attached;              ///< parts that move with it; not from a key of the constraint
    std::string support;                          ///< name of its reactions; empty: by its place in the input
    bool is_implied = false;                      ///< by a rigid body: the input has no such constraint
  };
  struct Equation {
    std::vector<EquationTermConfig> terms;
    Expression value;  ///< [m]
  };
  using Kind = std::variant<Displacement, Symmetry, Normal, Along, Periodic, Tied, Rigid, Equation>;

  Kind kind;
  Selection part;    ///< not of an equation
  std::string name;  ///< prefix of its columns in the history; empty: from the part or the place in the list
  Location where;
};

/// A load (Neumann boundary condition), or springs and dashpots to the ground (Robin).
struct LoadConfig {
  struct Gravity {
    VectorExpression acceleration;  ///< [m/s^2]
  };
  struct ForceDensity {
    VectorExpression value;  ///< per reference volume [N/m^3]
  };
  struct Traction {
    VectorExpression value;  ///< per reference area [Pa]
  };
  struct LineForce {
    VectorExpression value;  ///< per reference length [N/m]
  };
  struct Force {
    VectorExpression value;  ///< in all [N]
  };
  struct Torque {
    VectorExpression value;  ///< on a rigid body; functions of t [N m]
  };
  struct Pressure {
    Expression value;  ///< per current area, pushes onto the surface [Pa]
  };
  struct Foundation {
    std::optional<double> spring;   ///< per reference area [N/m^3]
    std::optional<double> dashpot;  ///< per reference area [N s/m^3]
    FoundationDirection direction;
  };
  struct PointFoundation {
    std::optional<double> spring;   ///< in all [N/m]
    std::optional<double> dashpot;  ///< in all [N s/m]
  };
  using Kind =
      std::variant<Gravity, ForceDensity, Traction, LineForce, Force, Torque, Pressure, Foundation, PointFoundation>;

  Kind kind;
  Selection part;  ///< Gravity, ForceDensity: everything or a volume; LineForce: curve; PointFoundation: point; Force:
                   ///< surface, box, where, curve, point or the volume of a rigid body; Torque: such a volume; the
                   ///< others: surface, box or where
  Location where;
};

/// A cavity in the bodies, and its content.
struct CavityConfig {
  struct GivenPressure {
    Expression value;  ///< [Pa]; a function of t
  };
  struct Gas {
    double pressure;  ///< at the start, above the ambient one [Pa]
    double ambient;   ///< absolute [Pa]
    double exponent;
    Expression amount;  ///< as a fraction of that at the start; a function of t
  };
  struct Liquid {
    double bulk_modulus;      ///< [Pa]
    double pressure;          ///< at the start [Pa]
    Expression added_volume;  ///< [m^3]; a function of t
    Expression flow;          ///< [m^3/s]; a function of t
  };
  std::string name;
  Selection part;                ///< surface, box or where
  std::optional<double> volume;  ///< of the reference configuration [m^3]; default: that behind the surface
  std::variant<GivenPressure, Gas, Liquid> content;
  Location where;
};

/// x = center + translate + R (X - center)
struct ObstacleMotionConfig {
  VectorExpression translate;  ///< [m]; a function of t
  struct Rotation {
    std::array<double, 3> axis{};                 ///< of any length
    Expression angle;                             ///< [rad]; a function of t
    std::optional<std::array<double, 3>> center;  ///< [m]; empty: the obstacle's point
  };
  std::optional<Rotation> rotate;
};

/// The pressure of a contact as a function of the distance.
struct ContactPressureConfig {
  NormalKind law = NormalKind::penalty;
  std::optional<double> stiffness;  ///< [Pa/m]; default: from material and mesh
  std::optional<double> width;      ///< [m]; default: from the mesh
  double threshold = 0;             ///< [m]
};

/// What resists the velocity in a contact, in proportion to the pressure. Default: that of the contact.
struct ContactDragConfig {
  std::optional<double> friction;
  std::optional<double> viscous_friction;  ///< [s/m]
  std::optional<double> normal_damping;    ///< [s/m]
};

struct ObstacleConfig {
  /// The boundary of half of space, through the obstacle's point.
  struct Plane {
    std::array<double, 3> normal;  ///< towards the bodies, of any length
  };
  struct Sphere {
    double radius;  ///< [m]
  };
  /// With flat ends.
  struct Cylinder {
    std::array<double, 3> axis;    ///< of any length
    double radius;                 ///< [m]
    std::optional<double> length;  ///< [m]; empty: endless
  };
  /// With round ends.
  struct Capsule {
    std::array<double, 3> axis;  ///< of any length
    double radius;               ///< [m]
    double length;               ///< between the centres of the ends [m]
  };
  struct Box {
    std::array<double, 3> size;  ///< [m]
  };
  /// Closed, of triangles.
  struct Surface {
    Located<std::string> file;  ///< resolved against the input file's directory
    double scale;
  };
  using Shape = std::variant<Plane, Sphere, Cylinder, Capsule, Box, Surface>;
  enum class Side { outside, inside };

  std::string name;
  Shape shape;
  std::array<double, 3> point{};  ///< of the plane, or the middle of the others [m]
  Side side = Side::outside;      ///< where the bodies are
  ContactDragConfig drag;
  std::optional<ObstacleMotionConfig> motion;
  Location where;
};

/// Two parts of the bodies that may touch, or one that may touch itself.
struct ContactPairConfig {
  std::string name;                          ///< prefix of its columns; empty: it has none
  Located<std::string> part;                 ///< a surface, or a volume, of which the outer surface counts
  std::optional<Located<std::string>> with;  ///< likewise; empty: itself
  std::optional<NormalKind> law;             ///< default: that of the contact
  std::optional<double> stiffness;           ///< [Pa/m]; default: that of the contact, or from material and mesh
  std::optional<double> width;               ///< [m]; likewise
  std::optional<double> thickness;           ///< distance at which the wall stands [m]; default: the threshold
  ContactDragConfig drag;
  Location where;
};

/// Which parts of the bodies may touch one another.
struct ContactPairsConfig {
  bool all = false;  ///< all outer surfaces, with each other and with themselves; then `list` is empty
  std::vector<ContactPairConfig> list;

  bool empty() const { return !all && list.empty(); }
};

/// What is done about surfaces that overlap or touch at the start.
enum class ContactStart {
  as_meshed,  ///< an error
  resolve     ///< they are moved apart in the mesh
};

struct ContactConfig {
  Selection part;  ///< facets that take part: surface, box, where, or all of the surface
  ContactPressureConfig pressure;
  ContactDragConfig drag;  ///< of all that has none of its own
  FrictionUpdate friction_update = FrictionUpdate::iterated;
  double stick_velocity = 0;  ///< [m/s]
  ContactPairsConfig pairs;
  ContactStart start = ContactStart::as_meshed;
  std::vector<std::array<Located<std::string>, 2>> exclude;  ///< surfaces or volumes that do not touch each other
  std::vector<ObstacleConfig> obstacles;
  Location where;

  /// The law of an entry of `pairs`; nullptr: of `all`.
  NormalKind law_of(const ContactPairConfig* pair) const {
    return pair != nullptr && pair->law ? *pair->law : pressure.law;
  }
  bool has_barrier() const {
    if (pressure.law == NormalKind::barrier && (pairs.all || !obstacles.empty())) return true;
    return std::ranges::any_of(pairs.list, [&](const auto& pair) { return law_of(&pair) == NormalKind::barrier; });
  }
  Friction friction(const ContactDragConfig& own) const {
    return {own.friction.value_or(drag.friction.value_or(0.0)),
            own.viscous_friction.value_or(drag.viscous_friction.value_or(0.0)), stick_velocity};
  }
  NormalDamping damping(const ContactDragConfig& own) const {
    return {own.normal_damping.value_or(drag.normal_damping.value_or(0.0))};
  }
};

struct InitialConfig {
  VectorExpression displacement;  ///< [m], function of x, y, z
  VectorExpression velocity;      ///< [m/s], function of x, y, z
};

/// Steps chosen by their estimated error. Tolerances are for the error of the whole run.
struct AdaptiveConfig {
  double relative = 0;           ///< of displacement and velocity
  double absolute = 0;           ///< of displacement [m]
  double absolute_velocity = 0;  ///< of velocity [m/s]; default absolute / the first step
  double min_step = 0;           ///< [s]; also TimeConfig::min_step
  double max_step = 0;           ///< [s]; default end / 10
  Location where;
};

/// A number of the history at which a path ends.
struct PathStopConfig {
  std::string column;           ///< of history.csv
  std::optional<double> above;  ///< the path ends at or above this value [SI]
  std::optional<double> below;  ///< or at or below this one [SI]
  Location where;
};

/// The path of equilibria of a static problem, beyond limit points of the load.
struct PathConfig {
  enum class By { arc_length };

  By by = By::arc_length;
  double max_load = 0;             ///< load factor at which it ends
  std::optional<double> min_load;  ///< likewise; empty: none
  std::optional<double> max_step;  ///< of its length; default 10 first steps
  int max_steps = 0;
  std::vector<PathStopConfig> stop;
  Location where;
};

/// What advances time.
struct MethodConfig {
  struct Unknown {};  ///< the input is wrong
  struct PetscIntegrator {
    std::string name;  ///< alpha2, ...
  };
  struct Quasistatic {};  ///< equilibria without inertia, step by step
  struct Static {};       ///< one equilibrium
  std::variant<Unknown, Method, PetscIntegrator, Quasistatic, Static> kind;  ///< a Method of the table or of the user
  Location where;
};

struct TimeConfig {
  MethodConfig method;
  double step = 0;                 ///< [s]; adaptive: the first one tried, default end / 1000; static: unused
  double end = 0;                  ///< [s]; static: the time at which expressions are evaluated (default 0)
  int load_steps = 1;              ///< static: loads are applied in this many equal parts
  std::optional<PathConfig> path;  ///< static: followed instead; its first step is one of these parts
  std::optional<Startup> startup;  ///< default: dirk33 where steps adapt and the method has several past states
  double min_step = 0;             ///< smallest step that is tried [s]; default step / 1024
  std::optional<AdaptiveConfig> adaptive;
  std::vector<double> events;  ///< times at which loads change abruptly, ascending, in (0, end) [s]; static: unused
};

/// The method of Pliant; nullptr for quasistatic, static and PETSc's integrators.
inline const Method* method_of(const TimeConfig& time) {
  return std::get_if<Method>(&time.method.kind);
}

struct NewtonConfig {
  double relative = 0;
  double absolute = 0;  ///< [N]
  int max_iterations = 0;
};

/// What solves linear systems; `automatic`: by size.
enum class LinearSolver { automatic, cholesky, amg, p_multigrid };

struct SolverConfig {
  LinearSolver linear = LinearSolver::automatic;
  NewtonConfig newton;
};

struct Config {
  std::string file;  ///< the input file as the user named it
  std::string title;
  MeshConfig mesh;
  ElementOrder element = ElementOrder::p1;
  VolumetricTreatment volumetric = VolumetricTreatment::standard;
  MassKind mass = MassKind::consistent;
  std::vector<BodyConfig> bodies;
  std::vector<RigidBodyConfig> rigid_bodies;
  std::vector<JointConfig> joints;
  std::vector<TendonConfig> tendons;
  std::vector<SpringConfig> springs;
  std::vector<RodConfig> rods;
  std::vector<ShellConfig> shells;
  std::vector<ConstraintConfig> constraints;
  std::vector<LoadConfig> loads;
  std::vector<CavityConfig> cavities;
  std::optional<ContactConfig> contact;
  InitialConfig initial;
  TimeConfig time;
  SolverConfig solver;
  OutputConfig output;
  std::optional<CheckpointConfig> checkpoint;
  std::vector<ProbeConfig> probes;
  std::vector<Diagnostic> warnings;  ///< about the text of the input, which is not kept here
};

}  // namespace pliant
