/// The fields that results may hold, and their components.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// What the numbers of a field are.
enum class FieldShape {
  scalar,
  vector,     ///< x y z
  principal,  ///< 1 2 3: the largest first
  symmetric,  ///< xx yy zz xy yz xz
  tensor      ///< xx xy xz yx yy yz zx zy zz: row by row
};

/// Names of the components, such as "xx"; none of a scalar.
std::vector<std::string> components_of(FieldShape shape);
inline constexpr int num_components(FieldShape shape) {
  constexpr std::array<int, 5> counts{1, 3, 3, 6, 9};
  return counts[static_cast<std::size_t>(shape)];
}

/// What has the field.
enum class FieldOwner {
  nodes,    ///< everything
  bodies,   ///< tetrahedra
  contact,  ///< nodes of surfaces that may touch something
  shells,
  rods
};

struct OutputFieldInfo {
  std::string_view name;
  FieldShape shape = FieldShape::scalar;
  FieldOwner owner = FieldOwner::bodies;
};

inline constexpr std::array<OutputFieldInfo, 31> output_fields{{
    {"displacement", FieldShape::vector, FieldOwner::nodes},
    {"velocity", FieldShape::vector, FieldOwner::nodes},
    {"acceleration", FieldShape::vector, FieldOwner::nodes},
    {"cauchy_stress", FieldShape::symmetric},
    {"elastic_cauchy_stress", FieldShape::symmetric},
    {"viscous_cauchy_stress", FieldShape::symmetric},
    {"active_cauchy_stress", FieldShape::symmetric},
    {"von_mises_stress"},
    {"principal_stress", FieldShape::principal},
    {"first_piola_kirchhoff_stress", FieldShape::tensor},
    {"displacement_gradient", FieldShape::tensor},
    {"green_lagrange_strain", FieldShape::symmetric},
    {"log_strain", FieldShape::symmetric},
    {"principal_stretches", FieldShape::principal},
    {"volume_ratio"},
    {"energy_density"},
    {"elastic_energy_density"},
    {"viscous_energy_density"},
    {"softening"},
    {"discretization_error"},
    {"contact_pressure", FieldShape::scalar, FieldOwner::contact},
    {"contact_gap", FieldShape::scalar, FieldOwner::contact},
    {"contact_slip", FieldShape::vector, FieldOwner::contact},
    {"membrane_force", FieldShape::symmetric, FieldOwner::shells},
    {"principal_membrane_force", FieldShape::principal, FieldOwner::shells},
    {"bending_moment", FieldShape::symmetric, FieldOwner::shells},
    {"principal_bending_moment", FieldShape::principal, FieldOwner::shells},
    {"principal_curvature", FieldShape::principal, FieldOwner::shells},
    {"rod_force", FieldShape::scalar, FieldOwner::rods},
    {"rod_bending_moment", FieldShape::scalar, FieldOwner::rods},
    {"rod_torque", FieldShape::scalar, FieldOwner::rods},
}};

/// The first columns of every history, in this order.
inline constexpr std::array<std::string_view, 17> first_columns{"step",
                                                                "time",
                                                                "dt",
                                                                "newton_iterations",
                                                                "linear_iterations",
                                                                "kinetic_energy",
                                                                "elastic_energy",
                                                                "load_potential",
                                                                "dissipated_energy",
                                                                "load_work",
                                                                "energy_balance_error",
                                                                "px",
                                                                "py",
                                                                "pz",
                                                                "Lx",
                                                                "Ly",
                                                                "Lz"};

/// A field, or a component of one: displacement, displacement_z.
struct FieldComponent {
  OutputFieldInfo field;
  std::optional<int> component;  ///< empty: all of them
};

/// What the name stands for; nothing if no field is called so.
std::optional<FieldComponent> field_component(std::string_view name);

/// Names of fields, and of their components too.
std::vector<std::string> names_of_fields();
std::vector<std::string> names_of_fields_and_components();

}  // namespace pliant
