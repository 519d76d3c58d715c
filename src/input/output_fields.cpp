#include "input/output_fields.hpp"

#include <algorithm>

namespace pliant {

std::vector<std::string> components_of(FieldShape shape) {
  switch (shape) {
    case FieldShape::vector:
      return {"x", "y", "z"};
    case FieldShape::principal:
      return {"1", "2", "3"};
    case FieldShape::symmetric:
      return {"xx", "yy", "zz", "xy", "yz", "xz"};
    case FieldShape::tensor:
      return {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"};
    default:
      return {};
  }
}

std::optional<FieldComponent> field_component(std::string_view name) {
  const auto found = std::ranges::find(output_fields, name, &OutputFieldInfo::name);
  if (found != output_fields.end()) return FieldComponent{*found, std::nullopt};
  for (const OutputFieldInfo& field : output_fields) {
    if (name.size() <= field.name.size() + 1 || !name.starts_with(field.name) || name[field.name.size()] != '_')
      continue;
    const auto components = components_of(field.shape);
    const auto component = std::ranges::find(components, name.substr(field.name.size() + 1));
    if (component != components.end()) return FieldComponent{field, static_cast<int>(component - components.begin())};
  }
  return std::nullopt;
}

std::vector<std::string> names_of_fields() {
  std::vector<std::string> names;
  for (const OutputFieldInfo& field : output_fields) names.emplace_back(field.name);
  return names;
}

std::vector<std::string> names_of_fields_and_components() {
  std::vector<std::string> names = names_of_fields();
  for (const OutputFieldInfo& field : output_fields) {
    for (const std::string& component : components_of(field.shape)) {
      names.push_back(std::string(field.name) + "_" + component);
    }
  }
  return names;
}

}  // namespace pliant
