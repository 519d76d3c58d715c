/// What a fit file says: a law with unknown constants, and the tests that determine them. All quantities in SI units.
#pragma once

#include "base/error.hpp"
#include "input/located.hpp"
#include "input/tree.hpp"
#include "material/loading.hpp"
#include "material/volumetric_form.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

enum class TestKind { uniaxial, equibiaxial, pure_shear, simple_shear, volumetric, relaxation, dma };

/// What the optimiser makes small.
enum class ResidualKind {
  absolute,  ///< model - measurement [Pa]
  relative,  ///< (model - measurement) / measurement
};

/// A constant of the law that is known, and not fitted.
struct HeldConstant {
  std::string key;
  double value;  ///< SI
  Location where;
};

struct FitMaterialConfig {
  std::string model;
  std::optional<int> terms;  ///< of a law with terms to choose
  bool is_incompressible = false;
  VolumetricForm volumetric = VolumetricForm::mixed;
  std::vector<HeldConstant> held;
  Location where;
};

struct FitViscosityConfig {
  std::string model;
  std::optional<int> terms;
  std::vector<double> relaxation_times;  ///< [s]; held if given, otherwise `terms` of them are fitted
  Location where;
};

struct FitTestConfig {
  TestKind kind = TestKind::uniaxial;
  Located<std::string> data;       ///< the file as it is given
  double weight = 1.0;             ///< of the squared residuals
  std::optional<Loading> loading;  ///< relaxation, dma: of the specimen; uniaxial unless given
  std::optional<double> stretch;   ///< relaxation: that is held
  std::optional<double> shear;     ///< likewise, in simple shear
  std::optional<double> rate;      ///< relaxation: of the stretch on the way there [1/s]
  Location where;
};

/// A value for a parameter that the user names; how it is typed depends on the parameter.
struct NamedNode {
  std::string name;
  InputNode node;
};

/// A column of the history of a run, and what was measured of it.
struct FitTargetConfig {
  std::string column;
  Located<std::string> data;  ///< table with the columns `time` and that one
  std::optional<InputNode> scale;
  double weight = 1.0;  ///< of the squared residuals
  Location where;
};

/// A fit of a material by itself, or of numbers of an input by runs of it: then `input`, `parameters` and `targets` are
/// there, and nothing else but `title` and `starts`.
struct FitConfig {
  std::string file;
  std::string title;
  std::optional<Located<std::string>> input;
  std::vector<NamedNode> parameters;  ///< keys of the input, each with a pair of bounds
  std::vector<FitTargetConfig> targets;
  FitMaterialConfig material;
  std::optional<FitViscosityConfig> viscosity;
  std::vector<FitTestConfig> tests;
  ResidualKind residual = ResidualKind::absolute;
  std::vector<NamedNode> bounds;   ///< a pair for each
  std::vector<NamedNode> initial;  ///< values of the first start
  std::optional<int> starts;
};

}  // namespace pliant
