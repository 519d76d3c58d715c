#include "input/sections/viscosity.hpp"

#include "base/text.hpp"
#include "input/formats.hpp"
#include "input/sections/laws.hpp"

#include <algorithm>
#include <string_view>

namespace pliant {
namespace {

using Need = KeyGroup::Need;

Format<std::optional<StrainRate>> strain_rate() {
  std::vector<std::pair<std::string, std::optional<StrainRate>>> choices{{"auto", std::nullopt}};
  for (const StrainRateInfo& form : strain_rates()) choices.emplace_back(form.name, form.rate);
  return choice_of(choices);
}

Format<std::string> model() {
  return choice(law_names(viscosity_laws()),
                "; Rayleigh damping is the sum of mass-proportional and stiffness-proportional");
}

constexpr const char* rate_key = "rate";

const ParameterInfo* find_parameter(const ViscosityForm& form, std::string_view name) {
  const auto found = std::ranges::find(form.parameters, name, &ParameterInfo::name);
  return found == form.parameters.end() ? nullptr : &*found;
}

/// Where the law keeps the parameter; nullptr if it has none such.
double* find_value(ViscosityLaw& law, std::string_view name) {
  const ViscosityForm& form = viscosity_forms()[law.index()];
  const ParameterInfo* parameter = find_parameter(form, name);
  return parameter == nullptr ? nullptr : &form.members[parameter - form.parameters.data()](law);
}

bool has_key(const ViscosityForm& form, std::string_view key) {
  return key == rate_key ? has_strain_rate(form.blank) : find_parameter(form, key) != nullptr;
}

/// Each key once, where the last of the forms has it.
std::vector<std::string> parameter_keys() {
  std::vector<std::string> keys;
  const auto add = [&](std::string_view key) {
    std::erase(keys, key);
    keys.emplace_back(key);
  };
  for (const ViscosityForm& form : viscosity_forms()) {
    for (const ParameterInfo& p : form.parameters) add(p.name);
    if (has_strain_rate(form.blank)) add(rate_key);
  }
  return keys;
}

/// As the first form has it that does.
const ParameterInfo& parameter_of(std::string_view key) {
  const auto owner = std::ranges::find_if(viscosity_forms(), [&](const auto& form) { return has_key(form, key); });
  return *find_parameter(*owner, key);
}

template <class V>
KeyInfo key_info(const std::string& key, const Format<V>& format, std::string_view description) {
  KeyInfo info{key, format.type, std::string(description)};
  info.schema = format.schema;
  return info;
}

std::vector<KeyInfo> keys() {
  std::vector<KeyInfo> infos{key_info("model", model(), "law of viscosity (`pliant materials`)")};
  infos.front().need = KeyInfo::Need::required;
  for (const std::string& key : parameter_keys()) {
    if (key == rate_key) {
      infos.push_back(key_info(key, strain_rate(),
                               "strain rate within a step; `auto`: the form that has a potential where it keeps the "
                               "method's order, else the exact one"));
      infos.back().fallback = "auto";
      continue;
    }
    const ParameterInfo& p = parameter_of(key);
    infos.push_back(key_info(key, format_of(p), p.meaning));
    if (p.fallback) infos.back().fallback = format_number(*p.fallback);
  }
  return infos;
}

/// The forms of one law.
std::vector<const ViscosityForm*> forms_of(std::string_view law) {
  std::vector<const ViscosityForm*> forms;
  for (const ViscosityForm& form : viscosity_forms()) {
    if (name_of(form.blank) == law) forms.push_back(&form);
  }
  return forms;
}

/// The owners of a key: every law all of whose forms have it, and the first keys of forms that are alone in having it.
std::vector<Anchor> anchors_of(std::string_view key) {
  std::vector<Anchor> anchors;
  for (const ViscosityForm& form : viscosity_forms()) {
    if (!has_key(form, key)) continue;
    const auto siblings = forms_of(name_of(form.blank));
    const bool is_common = std::ranges::all_of(siblings, [&](const auto* one) { return has_key(*one, key); });
    if (!is_common) {
      anchors.push_back({std::string(form.parameters.front().name)});
    } else if (siblings.front() == &form) {
      anchors.push_back({"model", std::string(name_of(form.blank))});
    }
  }
  return anchors;
}

std::vector<KeyGroup> groups() {
  std::vector<KeyGroup> groups;
  std::vector<std::string> choosing;  // keys that choose one of several forms of a law
  for (const LawInfo& law : viscosity_laws()) {
    const auto forms = forms_of(law.name);
    if (forms.size() < 2) continue;
    KeyGroup choice{{}, Need::exactly_one, {{"model", std::string(law.name)}}};
    for (const auto* form : forms) choice.keys.emplace_back(form->parameters.front().name);
    choosing.insert(choosing.end(), choice.keys.begin(), choice.keys.end());
    groups.push_back(std::move(choice));
  }
  for (const std::string& key : parameter_keys()) {
    if (std::ranges::find(choosing, key) != choosing.end()) continue;
    const bool is_needed = key != rate_key && !parameter_of(key).fallback;
    groups.push_back({{key}, is_needed ? Need::all : Need::any, anchors_of(key)});
  }
  return groups;
}

/// The form of the law whose first key is given.
const ViscosityForm* chosen_form(const InputNode& section, std::string_view law) {
  const auto forms = forms_of(law);
  const auto is_given = [&](const auto* form) { return given(section, {form->parameters.front().name}) != nullptr; };
  const auto found = std::ranges::find_if(forms, is_given);
  return found != forms.end() ? *found : forms.front();
}

/// Reads what is given even where the law is not known, for the errors in it.
void read_values(const InputNode& section, Diagnostics& diagnostics, ViscosityConfig& into) {
  for (const std::string& key : parameter_keys()) {
    const InputNode* node = given(section, {key});
    if (key == rate_key) {
      if (node != nullptr) strain_rate().read(*node, key, diagnostics, into.rate);
      continue;
    }
    const ParameterInfo& p = parameter_of(key);
    double value = p.fallback.value_or(0.0);
    if (node != nullptr) format_of(p).read(*node, key, diagnostics, value);
    if (double* parameter = find_value(into.law, key)) *parameter = value;
  }
}

InputNode written(const ViscosityConfig& mechanism) {
  ViscosityLaw law = mechanism.law;
  std::vector<InputNode> entries{model().write(std::string(name_of(law))).under("model")};
  for (const std::string& key : parameter_keys()) {
    if (const double* value = find_value(law, key)) {
      entries.push_back(format_of(parameter_of(key)).write(*value).under(key));
    } else if (key == rate_key && has_strain_rate(law)) {
      entries.push_back(strain_rate().write(mechanism.rate).under(key));
    }
  }
  return InputNode::map(std::move(entries));
}

Format<ViscosityConfig> mechanism() {
  KeyInfo section;
  section.children = keys();
  section.groups = groups();
  Format<ViscosityConfig> format{
      "with the keys below", object_schema(section.children, section.groups), {}, written, section.children,
      section.groups};
  format.read = [section](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                          ViscosityConfig& into) {
    into.where = node.where;
    if (!check_keys(node, name, section, diagnostics)) return true;
    std::string law;
    const InputNode* named = given(node, {"model"});
    if (named != nullptr && model().read(*named, "model", diagnostics, law)) into.law = chosen_form(node, law)->blank;
    read_values(node, diagnostics, into);
    return true;
  };
  return format;
}

}  // namespace

Format<std::vector<ViscosityConfig>> viscosity_format() {
  return one_or_list_of(mechanism());
}

}  // namespace pliant
