/// The input file as typed values in SI units; every default stands in the key table (app/schema), none here.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A value and the place in the file that gave it, so that later checks (e.g. against the mesh's groups) can point at
/// it.
template <class T>
struct Located {
  T value{};
  Location where;
};

/// Which part of the mesh an entry speaks of. Exactly one way of selecting is given.
struct Selection {
  enum class Kind { everything, volume, surface, curve, point, box, where };
  Kind kind = Kind::everything;
  std::string name;                  ///< physical name, or the tag in decimal digits (volume, surface, curve, point)
  std::array<double, 6> box{};       ///< xmin ymin zmin xmax ymax zmax [m] (box)
  std::optional<Expression> region;  ///< nonzero inside (where); a function of x, y, z
  Location where;
};

using VectorExpression = std::array<Expression, 3>;

enum class ElementOrder { p1 = 1, p2 = 2 };
enum class MassKind { consistent, lumped };

struct MeshConfig {
  Located<std::string> file;   ///< resolved against the input file's directory
  std::optional<double> size;  ///< [m]
  double scale = 1.0;
  int refine = 0;
};

struct ElasticityConfig {
  std::string model;          ///< registry name: linear, saint-venant-kirchhoff, neo-hookean
  double youngs_modulus = 0;  ///< [Pa]
  double poissons_ratio = 0;
  Location where;
};

struct BodyConfig {
  Selection part;                 ///< volume, or everything
  std::optional<double> density;  ///< [kg/m^3]; required for dynamics and gravity
  ElasticityConfig elasticity;
  Location where;
};

struct ConstraintConfig {
  Selection part;
  std::array<std::optional<Expression>, 3> displacement;  ///< [m]; empty component = free
  Location where;
};

struct LoadConfig {
  enum class Kind { gravity, traction };
  Kind kind = Kind::gravity;
  Selection part;          ///< traction: surface, box or where; gravity: everything (or a volume)
  VectorExpression value;  ///< gravity [m/s^2], traction [Pa] per reference area
  Location where;
};

struct InitialConfig {
  VectorExpression displacement;  ///< [m], function of x, y, z
  VectorExpression velocity;      ///< [m/s], function of x, y, z
};

struct TimeConfig {
  Located<std::string> method;  ///< a method's name, or quasistatic, or static
  double step = 0;              ///< [s]; static: unused
  double end = 0;               ///< [s]; static: the time at which expressions are evaluated (default 0)
  int load_steps = 1;           ///< static: loads are applied in this many equal parts
  std::string startup;          ///< ramp
  double min_step = 0;          ///< smallest step that a retry may try [s]; default step / 1024
};

struct NewtonConfig {
  double relative = 0;
  double absolute = 0;  ///< [N]
  int max_iterations = 0;
};

struct SolverConfig {
  std::string linear;  ///< auto, cholesky, amg
  NewtonConfig newton;
};

struct OutputConfig {
  std::string directory;        ///< resolved against the working directory; default out/<input's stem>
  std::optional<double> every;  ///< [s]; default: the step
  std::vector<std::string> fields;
};

struct ProbeConfig {
  std::string name;
  std::array<double, 3> point{};  ///< reference position [m]
  Location where;
};

struct Config {
  std::string file;  ///< the input file as the user named it
  std::string title;
  MeshConfig mesh;
  ElementOrder element = ElementOrder::p1;
  MassKind mass = MassKind::consistent;
  std::vector<BodyConfig> bodies;
  std::vector<ConstraintConfig> constraints;
  std::vector<LoadConfig> loads;
  InitialConfig initial;
  TimeConfig time;
  SolverConfig solver;
  OutputConfig output;
  std::vector<ProbeConfig> probes;
};

}  // namespace pliant
