/// Elastic laws of the input, and what a body may have in addition to its laws of elasticity and viscosity.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"
#include "material/mullins.hpp"
#include "material/volumetric_form.hpp"

#include <array>
#include <string>
#include <vector>

namespace pliant {

using VectorExpression = std::array<Expression, 3>;

/// A constant of a law, in SI: a number, a function of x, y, z, or data of the mesh file.
struct GivenConstant {
  std::string key;
  Expression value;
  std::string cell_data;  ///< name of the data; empty: `value` counts
  Location where;
  double factor = 1.0;  ///< by which all values are multiplied, for derivatives
};

/// A preferred direction, of any length: a function of x, y, z, or data of the mesh file.
struct GivenDirection {
  std::string key;  ///< fibre, sheet, fibre2
  VectorExpression value;
  std::string cell_data;  ///< name of the data; empty: `value` counts
  Location where;
};

struct ElasticityConfig {
  std::string model;                     ///< name in the registry of elastic laws
  std::string library;                   ///< the measured material (material/library.hpp) that fills in the rest, or ""
  std::vector<GivenConstant> constants;  ///< constants of the law (material/constants.hpp)
  std::vector<GivenDirection> directions;
  bool incompressible = false;  ///< in place of the constant that resists a change of volume
  VolumetricForm volumetric_energy = VolumetricForm::mixed;
  Location where;
};

/// Expansion by heat or swelling.
struct ExpansionConfig {
  Expression stretch;  ///< in all directions, free of stress; a function of x, y, z, t
  Location where;
};

/// Softening by the largest strain of the past.
struct MullinsConfig {
  Mullins law;
  Location where;
};

}  // namespace pliant
