#include "input/foreign_keys.hpp"

#include <algorithm>
#include <array>

namespace pliant {
namespace foreign {  // whose names are those of many variables

struct Word {
  std::string_view section;  ///< without the number of an entry
  std::string_view word;
  std::string_view meaning;  ///< a key of the section, or what to do
};

constexpr std::array synonyms{
    Word{"", "order", "element"},
    Word{"", "element_type", "element"},
    Word{"", "elements", "element"},
    Word{"", "mechanisms", "joints"},
    Word{"mesh", "path", "file"},
    Word{"mesh", "name", "file"},
    Word{"mesh", "filename", "file"},
    Word{"mesh", "units", "scale"},
    Word{"mesh", "unit", "scale"},
    Word{"mesh", "factor", "scale"},
    Word{"mesh", "element_size", "size"},
    Word{"mesh", "h", "size"},
    Word{"bodies", "rho", "density"},
    Word{"bodies", "material_model", "elasticity"},
    Word{"bodies", "material", "elasticity"},
    Word{"bodies", "name", "volume"},
    Word{"viscosity", "g", "ratio"},
    Word{"viscosity", "g1", "ratio"},
    Word{"viscosity", "g_i", "ratio"},
    Word{"viscosity", "weight", "ratio"},
    Word{"viscosity", "tau", "relaxation_time"},
    Word{"viscosity", "tau1", "relaxation_time"},
    Word{"viscosity", "time_constant", "relaxation_time"},
    Word{"viscosity", "eta", "shear"},
    Word{"viscosity", "viscosity", "shear"},
    Word{"constraints", "ux", "displacement"},
    Word{"constraints", "uy", "displacement"},
    Word{"constraints", "uz", "displacement"},
    Word{"constraints", "u", "displacement"},
    Word{"constraints", "clamp", "displacement"},
    Word{"constraints", "clamped", "displacement"},
    Word{"constraints", "fixed", "displacement"},
    Word{"constraints", "encastre", "displacement"},
    Word{"constraints", "tie", "tied_to"},
    Word{"constraints", "tied", "tied_to"},
    Word{"constraints", "periodic", "periodic_with"},
    Word{"loads", "moment", "torque"},
    Word{"loads", "body_force", "force_density"},
    Word{"obstacles", "center", "point"},
    Word{"obstacles", "centre", "point"},
    Word{"obstacles", "position", "point"},
    Word{"obstacles", "origin", "point"},
    Word{"obstacles", "type", "shape"},
    Word{"obstacles", "mu", "friction"},
    Word{"obstacles", "friction_coefficient", "friction"},
    Word{"obstacles", "velocity", "motion"},
    Word{"contact", "mu", "friction"},
    Word{"contact", "friction_coefficient", "friction"},
    Word{"contact", "penalty", "stiffness"},
    Word{"contact", "dhat", "width"},
    Word{"pairs", "mu", "friction"},
    Word{"pairs", "friction_coefficient", "friction"},
    Word{"pairs", "penalty", "stiffness"},
    Word{"pairs", "dhat", "width"},
    Word{"pairs", "master", "with"},
    Word{"pairs", "slave", "surface"},
    Word{"time", "dt", "step"},
    Word{"time", "timestep", "step"},
    Word{"time", "time_step", "step"},
    Word{"time", "duration", "end"},
    Word{"time", "final_time", "end"},
    Word{"time", "total_time", "end"},
    Word{"time", "t_end", "end"},
    Word{"time", "tend", "end"},
    Word{"time", "integrator", "method"},
    Word{"time", "scheme", "method"},
    Word{"output", "frequency", "every"},
    Word{"output", "interval", "every"},
    Word{"output", "dir", "directory"},
    Word{"output", "folder", "directory"},
    Word{"output", "path", "directory"},
    Word{"output", "variables", "fields"},
    Word{"probes", "coordinates", "point"},
    Word{"probes", "position", "point"},
    Word{"probes", "location", "point"},
    Word{"probes", "at", "point"},
    Word{"tendons", "force", "tension"},
    Word{"tendons", "route", "points"},
    Word{"tendons", "path", "points"},
    Word{"springs", "k", "stiffness"},
    Word{"springs", "c", "damping"},
    Word{"springs", "length", "rest"},
    Word{"springs", "rest_length", "rest"},
    Word{"joints", "bodies", "between"},
    Word{"joints", "location", "point"},
    Word{"joints", "position", "point"},
    Word{"joints", "stops", "limits"},
    Word{"rigid_bodies", "position", "center"},
    Word{"rigid_bodies", "centre", "center"},
    Word{"rigid_bodies", "com", "center"},
    Word{"rigid_bodies", "shape", "surface"},
    Word{"rigid_bodies", "m", "mass"},
};

constexpr std::string_view damping =
    "damping of a body is its 'viscosity', as in {model: kelvin-voigt, shear: ..} or, for Rayleigh damping, [{model: "
    "mass-proportional, decay_rate: alpha}, {model: stiffness-proportional, time: beta}]";
constexpr std::string_view rayleigh =
    "Rayleigh damping is [{model: mass-proportional, decay_rate: alpha}, {model: stiffness-proportional, time: beta}]";
constexpr std::string_view ratio =
    "the 'ratio' of a branch is that of its modulus to the one that stays: g of FEBio, and g/(1 - the sum of all g) "
    "where these "
    "are parts of the modulus at once, as in Abaqus";
constexpr std::string_view velocity = "velocities at time 0 are given by 'initial: {velocity: [..]}'";
constexpr std::string_view displacement = "displacements at time 0 are given by 'initial: {displacement: [..]}'";
constexpr std::string_view material = "the material of a body is given by its 'elasticity', 'density' and 'viscosity'";
constexpr std::string_view conditions =
    "displacements are prescribed in 'constraints', forces and pressures in 'loads'";
constexpr std::string_view follower = "a 'pressure' follows the surface, a 'traction' keeps its direction";
constexpr std::string_view threads = "a run on several cores is started by 'mpirun -n 4 pliant run ..'";

constexpr std::array explanations{
    Word{"bodies", "damping", damping},
    Word{"bodies", "rayleigh", damping},
    Word{"bodies", "rayleigh_damping", damping},
    Word{"bodies", "initial_velocity", velocity},
    Word{"bodies", "velocity", velocity},
    Word{"viscosity", "alpha", rayleigh},
    Word{"viscosity", "beta", rayleigh},
    Word{"viscosity", "g", ratio},
    Word{"viscosity", "g1", ratio},
    Word{"viscosity", "g_i", ratio},
    Word{"constraints", "velocity", "write its integral over the time as the 'displacement', as in \"0.1*t\""},
    Word{"loads", "follower", follower},
    Word{"loads", "following", follower},
    Word{"output", "format", "results are result.xdmf and result.h5, which ParaView opens"},
    Word{"solver", "threads", threads},
    Word{"solver", "tolerance", "the tolerance is 'newton: {relative: ..}'"},
    Word{"solver", "tol", "the tolerance is 'newton: {relative: ..}'"},
    Word{"", "threads", threads},
    Word{"", "damping", damping},
    Word{"", "rayleigh", damping},
    Word{"", "initial_velocity", velocity},
    Word{"", "initial_displacement", displacement},
    Word{"", "initial_conditions", velocity},
    Word{"", "material", material},
    Word{"", "materials", material},
    Word{"", "boundary_conditions", conditions},
    Word{"", "boundary", conditions},
};

template <std::size_t size>
std::string_view meaning_of(std::string_view word, std::string_view section, const std::array<Word, size>& words) {
  section = section.substr(0, section.find('['));
  const auto* const found =
      std::ranges::find_if(words, [&](const Word& one) { return one.section == section && one.word == word; });
  return found == words.end() ? "" : found->meaning;
}

}  // namespace foreign

std::string_view key_for(std::string_view word, std::string_view section) {
  return foreign::meaning_of(word, section, foreign::synonyms);
}

std::string_view instead_of(std::string_view word, std::string_view section) {
  return foreign::meaning_of(word, section, foreign::explanations);
}

}  // namespace pliant
