#include "model/warnings.hpp"

#include "base/error.hpp"
#include "base/text.hpp"
#include "input/analysis.hpp"
#include "input/elasticity.hpp"
#include "input/loads.hpp"
#include "material/fibre_stability.hpp"
#include "material/library.hpp"
#include "material/stability.hpp"
#include "material/volume_split.hpp"
#include "model/events.hpp"
#include "model/loads.hpp"
#include "model/viscosity.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>

namespace pliant {
namespace {

/// A list of warnings that grows.
class Warnings {
 public:
  explicit Warnings(std::vector<Diagnostic> first = {}) : found_(std::move(first)) {}
  void add(const Location& where, std::string message) {
    found_.push_back({Severity::warning, where, std::move(message)});
  }
  std::vector<Diagnostic> found() && { return std::move(found_); }

 private:
  std::vector<Diagnostic> found_;
};

/// Does the load act on surfaces, curves or points, not in the volume?
bool is_local(const LoadConfig& load) {
  return !std::holds_alternative<LoadConfig::Gravity>(load.kind) &&
         !std::holds_alternative<LoadConfig::ForceDensity>(load.kind);
}

bool is_zero(const VectorExpression& vector) {
  return std::ranges::all_of(vector, [](const Expression& component) { return component.is_zero(); });
}

void check_time(const Config& config, Warnings& warnings) {
  const auto& method = config.time.method;
  const bool is_static = analysis_of(config) == Analysis::static_equilibrium;
  const auto changes = [](const DrivingFormula& of) { return of.formula->depends_on_time(); };
  if (!is_static && config.time.load_steps > 1) {
    warnings.add(method.where,
                 fmt::format("'load_steps' has an effect only with 'method: static'; with '{}' loads follow "
                             "their formulas of t",
                             method_name(method)));
  }
  if (is_static && config.time.end == 0.0 && std::ranges::any_of(driving_formulas(config), changes)) {
    warnings.add(method.where,
                 "a static analysis evaluates formulas of t at 'end', which is 0; set 'end', or use 'method: "
                 "quasistatic' to follow them in time");
  }
}

/// Limits for real materials; beyond them the numbers are probably not in SI units.
constexpr double slowest_shear_wave = 0.05;  // [m/s]; of the softest gels
constexpr double softest_gel = 0.5;          // shear modulus [Pa]
constexpr double no_stiffness = 1e-4;        // shear modulus of bodies that are meant to be purely viscous [Pa]
constexpr double softest_solid = 150.0;      // shear modulus [Pa]; of brain 1e3, of silicone 1e5
constexpr double lightest = 20.0, heaviest = 25000.0;  // [kg/m^3]; foam 30, osmium 22600
constexpr double fastest_shear_wave = 1e4;             // [m/s]; of diamond 12000, of steel 3200
constexpr double locking_ratio = 0.49;                 // Poisson's, of linear elements
/// Stretches that runs of soft bodies reach; a law may become unstable beyond them without a word.
constexpr double strongest_compression = 0.3, largest_stretch = 4.0;
/// Stretches of tissue, which laws with fibres describe.
constexpr double strongest_compression_of_tissue = 0.7, largest_stretch_of_tissue = 1.4;

/// Warns of densities that no solid has: a unit is forgotten, or one too many.
void check_density(double density, const Location& where, Warnings& warnings) {
  if (density == 0.0 || (density >= lightest && density <= heaviest)) return;
  const double meant = density < lightest ? 1e3 * density : 1e-3 * density;
  const bool is_likely = meant >= lightest && meant <= heaviest;
  warnings.add(
      where, fmt::format("the density is {:.4g} kg/m^3, and solids have 20 (foam) to 22600 (osmium); {}", density,
                         is_likely ? fmt::format("is {:.4g} kg/m^3 meant, which is {:.4g} g/cm^3?", meant, 1e-3 * meant)
                                   : "a number without a unit is in kg/m^3"));
}

/// Whether the laws of all bodies have the volumetric part that `volumetric: mixed` needs.
bool may_be_mixed(const Config& config) {
  return std::ranges::all_of(config.bodies, [](const BodyConfig& body) {
    return !body.elasticity || volumetric_form_of(ElasticityRule(*body.elasticity).kind());
  });
}

/// Whether density and shear modulus are those of no material, but of a problem without units.
bool is_without_units(double density, double shear_modulus) {
  return density == 1.0 && shear_modulus < softest_solid;
}

/// The moduli at rest of a body that has the same everywhere.
std::optional<Lame> moduli_at_rest(const BodyConfig& body) {
  if (!body.elasticity) return std::nullopt;
  const ElasticityRule rule(*body.elasticity);
  return rule.is_uniform() ? rule.law_at(0, {}).at_rest() : std::nullopt;
}

/// Warns of constants that are probably not in SI units.
void check_units(const BodyConfig& body, Warnings& warnings) {
  if (body.is_rigid && body.density) check_density(*body.density, body.where, warnings);
  const auto rest = moduli_at_rest(body);
  if (!rest) return;
  const auto add = [&](const std::string& text) { warnings.add(body.elasticity->where, text); };
  const double speed = std::sqrt(rest->mu / body.density.value_or(rest->mu));
  // A purely viscous body has almost no stiffness, which nobody types by forgetting a unit.
  const bool may_be_soft = !body.viscosity.empty() && rest->mu < no_stiffness;
  if (!body.density && rest->mu < softest_gel && !may_be_soft) {
    add(
        fmt::format("the shear modulus at rest is {:.2g} Pa, less than any gel has (silicone: 1e5 Pa, brain: 1e3 Pa); "
                    "a number without a unit is in Pa: is MPa or kPa meant?",
                    rest->mu));
  }
  const bool is_slow = speed < slowest_shear_wave && !may_be_soft;
  if (body.density && (is_slow || speed > fastest_shear_wave)) {
    add(
        fmt::format("with this density shear waves travel at {:.2g} m/s (silicone: 10, steel: 3000); are 'density' and "
                    "the moduli in SI? A number without a unit is in kg/m^3 and Pa",
                    speed));
  } else if (body.density && !may_be_soft && !is_without_units(*body.density, rest->mu)) {
    check_density(*body.density, body.where, warnings);
    if (rest->mu < softest_solid && *body.density >= lightest) {
      add(
          fmt::format("the shear modulus at rest is {:.3g} Pa, that of the softest gels (silicone: 1e5 Pa, brain: 1e3 "
                      "Pa); a number without a unit is in Pa: is MPa or kPa meant?",
                      rest->mu));
    }
  }
}

void check_body(const Config& config, const BodyConfig& body, Warnings& warnings) {
  check_units(body, warnings);
  const auto rest = moduli_at_rest(body);
  if (!rest) return;
  const auto add = [&](const std::string& text) { warnings.add(body.elasticity->where, text); };
  const double ratio = poissons_ratio(*rest);
  const auto is_ratio = [](const GivenConstant& c) { return c.key == "poissons_ratio"; };
  if (ratio < 0.0 && std::ranges::none_of(body.elasticity->constants, is_ratio)) {
    add(fmt::format(
        "these constants give a Poisson's ratio of {:.3g}: the body would thicken when it is stretched; is the bulk "
        "modulus meant to be so small compared with the shear modulus?",
        ratio));
  }
  if (ratio >= locking_ratio && config.element == ElementOrder::p1 &&
      config.volumetric == VolumetricTreatment::standard) {
    add(fmt::format(
        "Poisson's ratio is {:.4g}, and linear elements lock (are far too stiff) where it is near 1/2; use "
        "{}",
        ratio, may_be_mixed(config) ? "'volumetric: mixed'" : "'element: P2' and 'volumetric: mean-dilatation'"));
  }
}

/// Warns of constants with which the law softens until it cannot carry its force.
void check_stability(const BodyConfig& body, Warnings& warnings) {
  if (!body.elasticity) return;
  const auto law = ElasticityRule(*body.elasticity).up_to_rotation();
  if (!law) return;
  if (const auto of_fibres = stable_fibre_stretches(*law)) {
    const std::string words = in_words(*of_fibres, strongest_compression_of_tissue, largest_stretch_of_tissue);
    if (words.empty()) return;
    warnings.add(
        body.elasticity->where,
        fmt::format("with these constants '{}' is stable only {}; beyond, shear bands may form, or the force of "
                    "a specimen falls while its strain grows, and solutions depend on the mesh; check signs "
                    "and units, or fit the constants to several kinds of test",
                    body.elasticity->model, words));
    return;
  }
  const auto stable = stable_stretches(*law);
  if (!stable) return;
  const LibraryMaterial* material = find_material(body.elasticity->library);
  const double largest = material != nullptr ? std::min(material->highest_stretch, largest_stretch) : largest_stretch;
  const std::string words = in_words(*stable, std::max(strongest_compression, 1.0 / largest), largest);
  if (words.empty()) return;
  warnings.add(
      body.elasticity->where,
      fmt::format("with these constants '{}' is stable only {}; beyond, the force of a specimen falls while it "
                  "is stretched on; check signs and units, or fit the constants to several kinds of test",
                  body.elasticity->model, words));
}

/// Warns of degrees typed as radians: whole numbers of several turns.
void check_angles(const Config& config, Warnings& warnings) {
  const auto look = [&](const Expression& angle, const Location& where) {
    const double value = angle(0.0, 0.0, 0.0, 0.0);
    if (angle.depends_on_time() || std::abs(value) < 10.0 || value != std::round(value)) return;
    warnings.add(where, fmt::format("an angle of {:g} rad is {:.3g} turns; if degrees are meant, write '{:g} deg'",
                                    value, value / (2.0 * std::numbers::pi), value));
  };
  for (const ConstraintConfig& c : config.constraints) {
    const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&c.kind);
    const auto* about = rigid != nullptr ? std::get_if<RotationConfig::AboutAxis>(&rigid->rotation.kind) : nullptr;
    if (about != nullptr && about->angle) look(*about->angle, rigid->rotation.where);
  }
  for (const JointConfig& j : config.joints) {
    for (int k = 0; j.type == JointType::hinge && j.limits && k < 2; ++k) look(Expression((*j.limits)[k]), j.where);
  }
  if (!config.contact) return;
  for (const ObstacleConfig& o : config.contact->obstacles) {
    if (o.motion && o.motion->rotate) look(o.motion->rotate->angle, o.where);
  }
}

/// Warns of gravity typed in mm/s^2.
void check_gravity(const Config& config, Warnings& warnings) {
  for (const LoadConfig& load : config.loads) {
    const auto* gravity = std::get_if<LoadConfig::Gravity>(&load.kind);
    if (gravity == nullptr) continue;
    std::array<double, 3> g{};
    for (std::size_t i = 0; i < 3; ++i) g[i] = gravity->acceleration[i](0.0, 0.0, 0.0, 0.0);
    const double size = std::hypot(g[0], g[1], g[2]);
    if (std::abs(size - 9810.0) > 20.0) continue;
    warnings.add(load.where,
                 fmt::format("gravity is {:g} m/s^2, a thousand times the Earth's; if mm/s^2 is meant, write '{:g} "
                             "mm/s^2'",
                             size, size));
  }
}

/// Whether it is so of the drag of any contact.
template <class IsSo>
bool any_drag(const ContactConfig& contact, const IsSo& is_so) {
  const auto is_so_of = [&](const auto& of) { return is_so(of.drag); };
  return is_so_of(contact) || std::ranges::any_of(contact.obstacles, is_so_of) ||
         std::ranges::any_of(contact.pairs.list, is_so_of);
}

bool has_friction(const ContactConfig& contact) {
  return any_drag(contact, [&](const ContactDragConfig& drag) { return contact.friction(drag).acts(); });
}

void check_rods(const Config& config, Warnings& warnings) {
  const bool rubs = config.contact && has_friction(*config.contact);
  for (const RodConfig& rod : config.rods) {
    const double shear_modulus = 0.5 * rod.youngs_modulus / (1.0 + rod.poissons_ratio);
    if (!is_without_units(rod.density, shear_modulus)) check_density(rod.density, rod.where, warnings);
    const bool may_turn = rod.curve.empty() && rod.start.value.empty() && rod.end.value.empty();
    if (!rubs || !may_turn) continue;
    warnings.add(
        rod.where,
        fmt::format("friction acts on rod '{}' at its axis and not at its surface: the rod slides or sticks, and "
                    "does not roll; mesh it as a solid if rolling matters",
                    rod.name));
  }
}

}  // namespace

std::vector<Diagnostic> warnings_about_units(const Config& config) {
  Warnings warnings;
  for (const BodyConfig& body : config.bodies) check_units(body, warnings);
  return std::move(warnings).found();
}

std::vector<Diagnostic> warnings_about(const Config& config) {
  Warnings warnings(config.warnings);
  const TimeConfig& time = config.time;
  const OutputConfig& output = config.output;
  constexpr double rounding = 1e-9;
  if (analysis_of(config) != Analysis::static_equilibrium && !time.adaptive && output.every &&
      time.step > *output.every * (1.0 + rounding)) {
    warnings.add(output.every_where,
                 fmt::format("frames are requested every {} s, but a step is {} s long, and a step gives at most one "
                             "frame; choose a shorter 'time.step', or leave 'every' out",
                             format_number(*output.every), format_number(time.step)));
  }
  const std::string extension = std::filesystem::path(config.mesh.file.value).extension().string();
  if (config.mesh.scale == 0.001 && (extension == ".step" || extension == ".stp")) {
    warnings.add(
        config.mesh.file.where,
        "a STEP file states its unit and is read in metres; 'scale: 0.001' makes the part a thousand times smaller "
        "than drawn: leave 'scale' out");
  }
  check_time(config, warnings);
  for (const BodyConfig& body : config.bodies) {
    check_body(config, body, warnings);
    check_stability(body, warnings);
  }
  check_rods(config, warnings);
  for (const ShellConfig& shell : config.shells) check_density(shell.density.value_or(0.0), shell.where, warnings);
  check_angles(config, warnings);
  check_gravity(config, warnings);
  return std::move(warnings).found();
}

bool nothing_moves(const Config& config) {
  // Bodies that start in each other are pushed apart by a penalty.
  const bool may_be_pushed = config.contact && (!config.contact->obstacles.empty() || !config.contact->has_barrier());
  const auto is_at_rest = [](const RigidBodyConfig& body) {
    const std::array<double, 3> none{};
    return body.velocity.value_or(none) == none && body.angular_velocity == none;
  };
  const auto is_loose = [](const JointConfig& joint) { return !joint.spring; };
  const auto is_relaxed = [](const SpringConfig& spring) { return !spring.rest || spring.stiffness == 0.0; };
  const auto is_slack = [](const ShellConfig& shell) {
    return std::ranges::all_of(shell.prestretch, [](double stretch) { return stretch == 1.0; });
  };
  if (!std::ranges::all_of(config.shells, is_slack)) return false;
  if (!std::ranges::all_of(config.rigid_bodies, is_at_rest) || !std::ranges::all_of(config.joints, is_loose) ||
      !std::ranges::all_of(config.springs, is_relaxed)) {
    return false;
  }
  return config.cavities.empty() && !may_be_pushed && is_zero(config.initial.displacement) &&
         is_zero(config.initial.velocity) &&
         std::ranges::all_of(driving_formulas(config), [](const DrivingFormula& of) { return of.formula->is_zero(); });
}

bool may_fall(const Config& config) {
  const auto holds = [](const LoadConfig& load) { return foundation_of(load).has_value(); };
  // Pressure usually acts on closed surfaces, and does not push a body away.
  const auto pushes = [](const LoadConfig& load) {
    const VectorExpression* vector = vector_of(load);
    return vector != nullptr && !is_zero(*vector);
  };
  return !config.contact && config.springs.empty() && is_zero(config.initial.velocity) &&
         std::ranges::none_of(config.loads, holds) && std::ranges::any_of(config.loads, pushes);
}

std::vector<Diagnostic> notes_of_idle_keys(const Config& config) {
  const Analysis analysis = analysis_of(config);
  const bool is_static = analysis == Analysis::static_equilibrium;
  std::vector<Diagnostic> notes;
  const char* nothing = is_static ? "no effect on a static equilibrium" : "no effect on quasi-static equilibria";
  const auto note_if = [&](bool is_there, const char* of_what, const std::string& more = "") {
    if (is_there) notes.push_back(note(fmt::format("{} {}{}", of_what, nothing, more)));
  };
  const bool has_velocity = !is_zero(config.initial.velocity);
  if (analysis == Analysis::quasistatic) note_if(has_velocity, "the initial velocity has");
  if (!is_static) return notes;
  const TimeConfig& time = config.time;
  const double parts = time.step < time.end ? std::ceil(time.end / time.step - 1e-9) : 10.0;
  const bool is_whole = time.load_steps == 1 && !time.path;
  const auto advice = fmt::format("; 'load_steps: {:.0f}' applies the loads in as many parts", parts);
  note_if(time.step > 0.0, "'step' has", is_whole ? advice : "");
  note_if(!time.events.empty(), "'events' have");
  note_if(has_viscosity(config), "viscosity has");
  note_if(has_dashpots(config), "dashpots have");
  note_if(std::ranges::any_of(config.springs, [](const SpringConfig& s) { return s.damping > 0.0; }),
          "the damping of springs has");
  note_if(std::ranges::any_of(
              config.joints, [](const JointConfig& j) { return j.damping.value_or(0) + j.friction.value_or(0) > 0.0; }),
          "damping and friction of joints have");
  const auto drags = [&](const ContactDragConfig& drag) {
    return config.contact->friction(drag).acts() || config.contact->damping(drag).acts();
  };
  note_if(config.contact && any_drag(*config.contact, drags), "friction and damping of contact have");
  const auto rubs = [](const TendonConfig& tendon) { return tendon.friction > 0.0; };
  note_if(std::ranges::any_of(config.tendons, rubs), "friction of tendons has");
  note_if(has_velocity || !is_zero(config.initial.displacement), "the initial state has");
  return notes;
}

std::vector<Diagnostic> warnings_about_what_is_held(const Config& config, const NodeLayout& layout,
                                                    Selections& selections, const PrescribedDisplacement& prescribed) {
  const std::vector<char>& is_given = prescribed.flags();
  Warnings warnings;
  for (const ConstraintConfig& c : config.constraints) {
    const auto* given = std::get_if<ConstraintConfig::Displacement>(&c.kind);
    const auto is_zero = [](const std::optional<Expression>& value) { return value && value->is_zero(); };
    if (given == nullptr || !std::ranges::all_of(given->value, is_zero)) continue;
    const auto nodes = selections.nodes(c.part);
    const auto is_owned = [&](PetscInt n) { return n < layout.num_owned_nodes; };
    if (any_rank(layout.comm, std::ranges::count_if(nodes, is_owned) < layout.num_owned_nodes)) continue;
    warnings.add(c.where,
                 "this holds every node, so nothing moves; if a part was meant, check its name, or its box or "
                 "condition, whose numbers are in metres");
  }
  for (const LoadConfig& load : config.loads) {
    if (!is_local(load)) continue;
    const auto nodes = selections.nodes(load.part);
    const bool moves_here = std::ranges::any_of(nodes, [&](PetscInt n) {
      const auto* node = is_given.data() + 3 * n;
      return std::any_of(node, node + 3, [](char given) { return given == 0; });
    });
    if (any_rank(layout.comm, moves_here)) continue;
    warnings.add(load.where,
                 "the load moves nothing, because constraints prescribe the displacement of everything it "
                 "acts on; it changes only reactions");
  }
  return std::move(warnings).found();
}

std::vector<Diagnostic> warnings_about_start(const Config& config, const NodeLayout& layout, Selections& selections) {
  Warnings warnings;
  for (const ConstraintConfig& c : config.constraints) {
    const auto* prescribed = std::get_if<ConstraintConfig::Displacement>(&c.kind);
    if (prescribed == nullptr) continue;
    double jump = 0.0, size = 0.0;
    for (const PetscInt node : selections.nodes(c.part)) {
      const auto X = layout.position(node);
      for (std::size_t i = 0; i < 3; ++i) {
        if (!prescribed->value[i]) continue;
        const double from = config.initial.displacement[i](X[0], X[1], X[2], 0.0);
        const double to = (*prescribed->value[i])(X[0], X[1], X[2], 0.0);
        jump = std::max(jump, std::abs(to - from));
        size = std::max({size, std::abs(X[i]), std::abs(from)});
      }
    }
    constexpr double rounding = 1e-9;
    jump = maximum(layout.comm, jump);
    if (jump <= rounding * maximum(layout.comm, size)) continue;
    warnings.add(c.where, fmt::format("at t = 0 this displaces nodes abruptly by {:.3g} m from their initial "
                                      "displacement; let it grow with t, or set 'initial' to match",
                                      jump));
  }
  return std::move(warnings).found();
}

std::optional<Diagnostic> warning_about_pressures(const Config& config) {
  const Method* method = method_of(config.time);
  if (method == nullptr || method->num_stages == 1 || analysis_of(config) != Analysis::dynamic) return std::nullopt;
  return Diagnostic{
      Severity::warning, config.time.method.where,
      fmt::format(
          "an incompressible body moves as it should with '{}', but its pressures, stresses and reactions have "
          "errors that shorter steps do not reduce, because a step of several stages determines them at the last "
          "one alone; use bdf2 or bdf3 for these",
          method->name)};
}

std::vector<Diagnostic> warnings_about_iterations(const Config& config, double iterations) {
  constexpr double many = 10.0;
  if (iterations <= many || config.volumetric == VolumetricTreatment::mixed || !may_be_mixed(config)) return {};
  for (const BodyConfig& body : config.bodies) {
    if (!body.elasticity) continue;
    const ElasticityRule rule(*body.elasticity);
    if (!rule.is_uniform() || !volumetric_form_of(rule.kind())) continue;
    const auto rest = rule.law_at(0, {}).at_rest();
    if (!rest || poissons_ratio(*rest) < locking_ratio) continue;
    return {
        {Severity::warning, body.elasticity->where,
         fmt::format("Newton's method takes {:.0f} iterations a stage, because this body resists a change of volume "
                     "much more than a change of shape; 'volumetric: mixed' needs a few",
                     iterations)}};
  }
  return {};
}

}  // namespace pliant
