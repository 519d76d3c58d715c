#include "study/adjoint_fields.hpp"

#include "base/text.hpp"
#include "model/mesh_cell_data.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "study/neighbours.hpp"
#include "study/shape_gradient.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::string_view bodies = "bodies.", elasticity = ".elasticity.", viscosity = ".viscosity.",
                           density = ".density";

/// A key `bodies.B.SECTION.REST`.
struct KeyOfBody {
  std::size_t body;
  std::string rest;
};

std::optional<KeyOfBody> key_of_body(std::string_view key, std::string_view section) {
  if (!key.starts_with(bodies)) return std::nullopt;
  key.remove_prefix(bodies.size());
  std::size_t body = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), body);
  if (error != std::errc()) return std::nullopt;
  key.remove_prefix(static_cast<std::size_t>(end - key.data()));
  if (!key.starts_with(section)) return std::nullopt;
  return KeyOfBody{body, std::string(key.substr(section.size()))};
}

/// The key of a constant that is a single number in the input.
std::optional<KeyOfBody> key_of_number(std::string_view key) {
  if (const auto found = key_of_body(key, density); found && found->rest.empty()) return found;
  return key_of_body(key, viscosity);
}

std::vector<std::string> of_numbers(const std::vector<std::string>& keys) {
  std::vector<std::string> result;
  for (const std::string& key : keys) {
    if (key_of_number(key)) result.push_back(key);
  }
  return result;
}

}  // namespace

std::array<double, 3> centroid(const NodeLayout& layout, PetscInt cell) {
  std::array<double, 3> X{};
  for (const PetscInt node : layout.nodes_of_cell(cell).first(4)) {
    for (std::size_t i = 0; i < 3; ++i) X[i] += 0.25 * layout.position(node)[i];
  }
  return X;
}

AdjointFields::AdjointFields(std::string text, std::string file, std::vector<Override> changes,
                             const std::vector<std::string>& keys, const std::string& option)
    : varied_(std::move(text), std::move(file), std::move(changes), of_numbers(keys), option) {
  const Config& config = varied_.given();
  const Location where{option, 0, 0};
  for (const std::string& key : keys) {
    if (std::ranges::count(keys, key) > 1) throw InputError(where, fmt::format("'{}' is named twice", key));
    if (key == "initial.displacement" || key == "initial.velocity") {
      (key == "initial.velocity" ? by_velocity_ : by_displacement_) = true;
      continue;
    }
    if (key == key_of_nodes) {
      by_nodes_ = true;
      continue;
    }
    if (const auto found = key_of_number(key)) {
      const auto number = std::ranges::find(varied_.numbers(), key, &VariedNumber::key);
      if (number->value == 0.0) throw without_neighbours(varied_.file(), key);
      const auto place = static_cast<std::size_t>(number - varied_.numbers().begin());
      constants_.push_back({key, found->body, false, place, {}});
      continue;
    }
    const auto found = key_of_body(key, elasticity);
    if (!found || found->body >= config.bodies.size() || !config.bodies[found->body].elasticity) {
      throw InputError(
          where,
          fmt::format("'{}' has no value in each cell; densities and constants of elasticity and viscosity have, "
                      "such as bodies.0.elasticity.youngs_modulus, and at each node "
                      "mesh.nodes, initial.velocity and initial.displacement",
                      key));
    }
    const auto& constants = config.bodies[found->body].elasticity->constants;
    const auto constant = std::ranges::find(constants, found->rest, &GivenConstant::key);
    if (constant == constants.end()) {
      throw InputError(where, fmt::format("the elasticity of body {} has no constant '{}'", found->body, found->rest));
    }
    constants_.push_back({key, found->body, true, static_cast<std::size_t>(constant - constants.begin()), {}});
  }
}

std::vector<AdjointRun::Parameter> AdjointFields::parameters() const {
  std::vector<AdjointRun::Parameter> parameters;
  for (std::size_t n = 0; n < constants_.size(); ++n) {
    const Constant& constant = constants_[n];
    if (constant.is_factor) {
      const auto make = [this, body = constant.body, place = constant.place](double factor) {
        Config config = varied_.given();
        config.bodies[body].elasticity->constants[place].factor = factor;
        return config;
      };
      parameters.push_back({1.0, make, true});
      continue;
    }
    const auto make = [this, place = constant.place](double value) {
      std::vector<double> values;
      for (const VariedNumber& number : varied_.numbers()) values.push_back(number.value);
      values[place] = value;
      return varied_.at(values);
    };
    parameters.push_back({numbers_value(n), make, true, {}, size_of_number(constant.key, numbers_value(n))});
  }
  if (!by_nodes_) return parameters;
  for (AdjointRun::Parameter& strain : strains_of_mesh(varied_.given())) parameters.push_back(std::move(strain));
  return parameters;
}

std::string AdjointFields::key(std::size_t n) const {
  return n < constants_.size() ? constants_[n].key : std::string(key_of_nodes);
}

void AdjointFields::find_values(const Mesh& mesh, const Model& model) {
  const NodeLayout& layout = model.layout();
  if (by_nodes_ && mesh.geometry_order > 1) {
    throw InputError(
        {varied_.file(), 0, 0},
        fmt::format("'{}' needs a mesh with straight edges, and this one has curved ones; mesh it with linear "
                    "elements",
                    key_of_nodes));
  }
  const MeshCellData data(mesh, layout);
  on_every_rank(layout.comm, [&] {
    for (std::size_t n = 0; n < constants_.size(); ++n) {
      Constant& constant = constants_[n];
      constant.values.assign(static_cast<std::size_t>(layout.num_owned_cells),
                             std::numeric_limits<double>::quiet_NaN());
      for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
        if (model.body_of_cell()[static_cast<std::size_t>(c)] != static_cast<int>(constant.body)) continue;
        double& value = constant.values[static_cast<std::size_t>(c)];
        if (!constant.is_factor) {
          value = numbers_value(n);
          continue;
        }
        const GivenConstant& given = varied_.given().bodies[constant.body].elasticity->constants[constant.place];
        const auto [x, y, z] = centroid(layout, c);
        value = given.cell_data.empty() ? given.value(x, y, z, 0.0)
                                        : data.at(data.find(given.cell_data, 1, given.where), c)[0];
        if (value == 0.0) throw without_neighbours(varied_.file(), constant.key);
      }
    }
  });
}

std::vector<AdjointFields::OnMesh> AdjointFields::on_mesh(const AdjointRun& run) const {
  std::vector<OnMesh> fields;
  for (std::size_t n = 0; n < constants_.size(); ++n) {
    const Constant& constant = constants_[n];
    std::vector<double> slopes = run.parameter(n).derivatives_of_cells();
    slopes.resize(constant.values.size());
    for (std::size_t c = 0; c < slopes.size(); ++c) {
      if (std::isnan(constant.values[c])) {
        slopes[c] = 0.0;
      } else if (constant.is_factor) {
        slopes[c] /= constant.values[c];
      }
    }
    fields.push_back({constant.key, FieldLocation::cell, 1, constant.values});
    fields.push_back({fmt::format("derivative({})", constant.key), FieldLocation::cell, 1, std::move(slopes)});
  }
  const auto add_nodes = [&](bool is_wanted, const char* name, Vec x) {
    if (!is_wanted) return;
    const ConstArrayView values(x);
    fields.push_back({name, FieldLocation::node, 3, {values.span().begin(), values.span().end()}});
  };
  if (by_nodes_) {
    const Handle<Vec> slopes = derivatives_by_nodes(run, constants_.size());
    add_nodes(true, "derivative(mesh.nodes)", slopes.get());
  }
  add_nodes(by_displacement_, "derivative(initial.displacement)", run.by_displacement());
  add_nodes(by_velocity_, "derivative(initial.velocity)", run.by_velocity());
  return fields;
}

}  // namespace pliant
