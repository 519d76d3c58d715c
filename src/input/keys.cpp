#include "input/keys.hpp"

#include "input/formats.hpp"
#include "input/sections/active.hpp"
#include "input/sections/cavities.hpp"
#include "input/sections/constraints.hpp"
#include "input/sections/contact.hpp"
#include "input/sections/elasticity.hpp"
#include "input/sections/laws.hpp"
#include "input/sections/loads.hpp"
#include "input/sections/mullins.hpp"
#include "input/sections/output.hpp"
#include "input/sections/rigid_bodies.hpp"
#include "input/sections/rods.hpp"
#include "input/sections/shells.hpp"
#include "input/sections/tendons.hpp"
#include "input/sections/viscosity.hpp"
#include "material/elastic_law.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace pliant {
namespace {

using SelectionKind = Selection::Kind;

Section<LocalSizeConfig> local_size_keys() {
  using L = LocalSizeConfig;
  return {
      {
          field("surface", &L::surface, text(), "name or number of a physical surface of the geometry")
              .left_out_if([](const L& local) { return local.surface.empty(); }),
          field("curve", &L::curve, text(), "of a physical curve").left_out_if([](const L& local) {
            return local.curve.empty();
          }),
          field("point", &L::point, text(), "of a physical point").left_out_if([](const L& local) {
            return local.point.empty();
          }),
          field("size", &L::size, quantity("m", Range::above(0)), "target element size there, in metres after scaling")
              .required(),
          field("distance", &L::distance, quantity("m", Range::above(0)),
                "distance over which the size grows to that elsewhere, in metres after scaling")
              .required(),
      },
      {{{"surface", "curve", "point"}, KeyGroup::Need::exactly_one}},
      &L::where};
}

Section<MeshConfig> mesh_keys() {
  return {{
      field(
          "file", &MeshConfig::file, text(),
          "geometry or mesh, relative to the input file; .geo, .step, .brep and .stl are meshed by gmsh; .msh (2.2 or "
          "4.1, text or binary), .inp (Abaqus, CalculiX), .vtk, .vtu, .med, .bdf, .nas, .unv and .mesh (Medit) are "
          "read "
          "as they are, with their sets as groups; .h5, made by `pliant mesh convert`, is read in parts by every rank")
          .required(),
      field("size", &MeshConfig::size, quantity("m", Range::above(0)),
            "target element size for files that gmsh meshes, in metres after scaling")
          .otherwise_in_words("the geometry's own"),
      field("sizes", &MeshConfig::sizes, list_of(map_of(local_size_keys()), 0),
            "smaller elements at physical groups of geometry that gmsh meshes; the smallest size counts"),
      field("scale", &MeshConfig::scale, quantity("1", Range::above(0)), "coordinates are multiplied by it")
          .otherwise("1"),
      field("refine", &MeshConfig::refine, integer(Range::from_to(0, 6)),
            "uniform refinements; each cuts a tetrahedron into 8")
          .otherwise("0"),
      field(
          "allow_commands", &MeshConfig::allow_commands, truth(),
          "whether a .geo script, and those it loads, may run programs and write files (`SystemCall`, `Save`, `Printf "
          "... >`, ...): only for files you trust")
          .otherwise("false"),
      field("time_limit", &MeshConfig::time_limit, quantity("s", Range::from_to(0.001, 1e6)),
            "how long gmsh may take to mesh a geometry")
          .otherwise("3600"),
  }};
}

Section<BodyConfig> body_keys() {
  return {
      {
          selector<BodyConfig>("volume", SelectionKind::volume, "the volume that the body fills")
              .otherwise_in_words("the whole mesh"),
          field("density", &BodyConfig::density, quantity("kg/m^3", Range::above(0)), "mass per reference volume")
              .otherwise_in_words("that of the elasticity's `library`; needed for dynamics and for gravity"),
          field("elasticity", &BodyConfig::elasticity, elasticity_format(), "elastic law of a body that is not rigid"),
          field("attached", &BodyConfig::attached, list_of(name_of_part(), 1),
                "of a rigid body: names of surfaces of other bodies that move with it, rigidly (RBE2)")
              .otherwise_in_words("none"),
          field("coupled", &BodyConfig::coupled, list_of(name_of_part(), 1),
                "of a rigid body: names of surfaces of other bodies whose mean motion it follows, and which stay free "
                "to deform (RBE3)")
              .otherwise_in_words("none"),
          field("coupling_stiffness", &BodyConfig::coupling_stiffness, quantity("N/m", Range::above(0)),
                "force per distance between the body and the mean of a coupled surface")
              .otherwise_in_words("1000 times Young's modulus times the root of the area")
              .only_with({{"coupled"}}),
          field("rigid", &BodyConfig::is_rigid, truth(), "whether the body is rigid, and needs no elastic law")
              .otherwise("false"),
          field("viscosity", &BodyConfig::viscosity, viscosity_format(),
                "law of viscosity, in addition to the elastic law; several act in parallel")
              .otherwise_in_words("none"),
          field("active", &BodyConfig::active, map_of(active_keys()), "contraction along fibres, as in muscle")
              .otherwise_in_words("none"),
          field("expansion", &BodyConfig::expansion, map_of(expansion_keys()),
                "expansion by heat or swelling, the same in all directions")
              .otherwise_in_words("none"),
          field("mullins", &BodyConfig::mullins, map_of(mullins_keys()),
                "softening of rubber by the largest strain of the past (Mullins effect, Ogden & Roxburgh)")
              .otherwise_in_words("none"),
      },
      {},
      &BodyConfig::where};
}

Section<InitialConfig> initial_keys() {
  return {{
      field("displacement", &InitialConfig::displacement, array_of<3>(expression("m", Variables::space)),
            "displacement at time 0")
          .otherwise("[0, 0, 0]"),
      field("velocity", &InitialConfig::velocity, array_of<3>(expression("m/s", Variables::space)),
            "velocity at time 0")
          .otherwise("[0, 0, 0]"),
  }};
}

Section<NewtonConfig> newton_keys() {
  return {{
      field("relative", &NewtonConfig::relative, quantity("1", Range::from_to(0, 0.1)),
            "converged when the residual (out-of-balance force) is this fraction of the forces at work")
          .otherwise("1e-8"),
      field("absolute", &NewtonConfig::absolute, quantity("N", Range::at_least(0)),
            "converged when the residual is below this")
          .otherwise("0"),
      field("max_iterations", &NewtonConfig::max_iterations, integer(Range::from_to(1, 1e6)),
            "number of iterations after which a solve fails; where bodies meet it may take four times as many, and a "
            "step has a solve for each stage and each pass of friction")
          .otherwise("50"),
  }};
}

Section<SolverConfig> solver_keys() {
  return {{
      field(
          "linear", &SolverConfig::linear,
          choice_of<LinearSolver>({{"auto", LinearSolver::automatic},
                                   {"cholesky", LinearSolver::cholesky},
                                   {"amg", LinearSolver::amg},
                                   {"p-multigrid", LinearSolver::p_multigrid}},
                                  " (a direct solver, MUMPS: 'cholesky')"),
          "linear solver: sparse Cholesky (MUMPS), conjugate gradients with algebraic multigrid, or with multigrid of "
          "quadratic elements through linear ones; auto: by size")
          .otherwise("auto"),
      field("newton", &SolverConfig::newton, map_of(newton_keys()), "Newton's method"),
  }};
}

Section<CheckpointConfig> checkpoint_keys() {
  return {{
      field("every", &CheckpointConfig::every, integer(Range::from_to(1, 1e9)), "steps between checkpoints")
          .otherwise_in_words("none"),
      field("minutes", &CheckpointConfig::minutes, quantity("1", Range::above(0)),
            "minutes of the clock between checkpoints")
          .otherwise_in_words("none"),
  }};
}

Section<ProbeConfig> probe_keys() {
  return {
      {
          field("name", &ProbeConfig::name, column_name(), "prefix of the probe's columns in history.csv").required(),
          field("point", &ProbeConfig::point, array_of<3>(quantity("m")), "reference position").required(),
      },
      {},
      &ProbeConfig::where};
}

Section<Config> config_keys() {
  return {{
      field("title", &Config::title, text(), "free text for the log and the results"),
      field("mesh", &Config::mesh, map_of(mesh_keys()), "the mesh")
          .or_none("none; only `rigid_bodies` and `rods` need none"),
      field("element", &Config::element,
            choice_of<ElementOrder>({{"P1", ElementOrder::p1}, {"P2", ElementOrder::p2}},
                                    " (tetrahedra of 4 nodes: 'P1', of 10 nodes: 'P2')"),
            "linear or quadratic tetrahedra")
          .otherwise("P1"),
      field("volumetric", &Config::volumetric,
            choice_of<VolumetricTreatment>({{"standard", VolumetricTreatment::standard},
                                            {"mean-dilatation", VolumetricTreatment::mean_dilatation},
                                            {"mixed", VolumetricTreatment::mixed}}),
            "resistance to a change of volume: at every point; of each cell as a whole (P2), for nearly incompressible "
            "bodies; by pressures as additional unknowns, up to a Poisson's ratio of 1/2")
          .otherwise("standard"),
      field("mass", &Config::mass,
            choice_of<MassKind>({{"consistent", MassKind::consistent}, {"lumped", MassKind::lumped}}), "mass matrix")
          .otherwise("consistent"),
      field("bodies", &Config::bodies, list_of(map_of(body_keys()), 1), "the bodies and their materials"),
      field("rigid_bodies", &Config::rigid_bodies, list_of(map_of(rigid_body_keys()), 0),
            "rigid bodies by mass and inertia, without a mesh"),
      field("joints", &Config::joints, list_of(joint(), 0), "joints between rigid bodies, rigid parts and the ground"),
      field("tendons", &Config::tendons, list_of(map_of(tendon_keys()), 0),
            "strings through the bodies that are pulled"),
      field("springs", &Config::springs, list_of(map_of(spring_keys()), 0),
            "springs and dampers between two points of bodies, or one and the ground"),
      field("rods", &Config::rods, list_of(map_of(rod_keys()), 0),
            "slender elastic rods: wires, tubes and beams, alone, on rigid bodies, or along curves of the mesh"),
      field("shells", &Config::shells, list_of(map_of(shell_keys()), 0),
            "thin layers on surfaces of bodies: skins, coatings, membranes"),
      field("constraints", &Config::constraints, list_of(map_of(constraint_keys()), 0),
            "prescribed displacements (Dirichlet boundary conditions) and ties (multi-point constraints)"),
      field("loads", &Config::loads, list_of(map_of(load_keys()), 0),
            "forces and pressures (Neumann boundary conditions), springs and dashpots (Robin)"),
      field("cavities", &Config::cavities, list_of(map_of(cavity_keys()), 0),
            "cavities in the bodies that hold a gas or a liquid"),
      field("contact", &Config::contact, map_of(contact_keys()), "rigid obstacles, and the law of contact with them")
          .otherwise_in_words("none"),
      field("initial", &Config::initial, map_of(initial_keys()), "the state at time 0"),
      field("time", &Config::time, map_of(time_keys()), "how time advances").required(),
      field("solver", &Config::solver, map_of(solver_keys()), "how equations are solved"),
      field("output", &Config::output, map_of(output_keys()), "what is written"),
      field("checkpoint", &Config::checkpoint, map_of(checkpoint_keys()),
            "files from which `pliant resume` continues; `{}`: only at the end of the run; the last two are kept")
          .otherwise_in_words("only where the run is interrupted or fails"),
      field("probes", &Config::probes, list_of(map_of(probe_keys()), 0), "points whose motion history.csv follows"),
  }};
}

const Format<Config>& config_format() {
  static const Format<Config> format = map_of(config_keys());
  return format;
}

}  // namespace

const std::vector<KeyInfo>& input_keys() {
  return config_format().children;
}

Config read_config(const InputNode& root, Diagnostics& diagnostics) {
  Config config;
  config_format().read(root, "", diagnostics, config);
  return config;
}

InputNode write_config(const Config& config) {
  return config_format().write(config);
}

JsonSchema input_schema() {
  nlohmann::ordered_json schema{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Input of Pliant"}};
  schema.update(*config_format().schema);
  return std::make_shared<nlohmann::ordered_json>(std::move(schema));
}

}  // namespace pliant
