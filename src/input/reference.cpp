#include "input/reference.hpp"

#include "base/text.hpp"
#include "input/keys.hpp"

#include <algorithm>

namespace pliant {
namespace {

constexpr const char* input_introduction = R"md(# The input file

<!-- Written by `pliant schema --markdown` from the table in src/input/keys.cpp and src/input/sections; change it there. -->

An input is a YAML file:

```yaml
title: cantilever under gravity
mesh: {file: ../meshes/cantilever.geo, size: 20 mm}
element: P2
bodies:
  - volume: beam
    density: 1000 kg/m^3
    elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}
constraints:
  - {surface: clamp, displacement: [0, 0, 0]}
loads:
  - {gravity: [0, 0, -9.81]}
  - {surface: tip, traction: [0, 0, "-100*sin(2*pi*t)"]}
time: {method: bdf2, step: 10 ms, end: 2 s}
output: {every: 20 ms}
probes: [{name: tip, point: [1, 0.1, 0.1]}]
```

**Numbers and units.** A bare number is in SI units. A text may carry any unit of
[udunits](https://docs.unidata.ucar.edu/udunits/current/) with the right dimension: `5 ms`, `1 MPa`, `1.2 g/cm^3`,
`20 Pa*s`, `40 %`.

**Formulas.** Where a formula is allowed, a text is read as a number with a unit if it looks like one, else as a formula in
SI of the reference position `x`, `y`, `z` and the time `t` with the constant `pi`. Operators: `+ - * / ^`,
`< <= > >= == !=`, `&& ||`, `condition ? a : b`. Functions: `sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh
atanh exp ln log` (both natural) `log2 log10 sqrt abs sign rint min max sum avg`. A power is `^`, not `**`; products need
their `*`; a formula holds no units. Quote formulas: YAML reads `*` and `,` in its own ways.

**Groups.** `surface`, `volume`, `curve` and `point` take the name or the tag of a gmsh physical group; `box` and `where`
choose by reference position.

**Changes from the command line.** `--set KEY.PATH=VALUE` sets any key; entries of lists count from 0, and those
with a `name` answer to it:
`--set time.step=1ms --set bodies.0.density=900`.
)md";

/// The keys and children of a table that are nested in a heading of their own.
bool is_section(const KeyInfo& key) {
  return !key.children.empty();
}

std::string anchor(const std::string& path) {
  std::string result;
  for (const char c : path) {
    if (c != '.' && c != '[' && c != ']') result += c;
  }
  return result;
}

/// A cell of a Markdown table.
std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string capitalised(std::string text) {
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string default_of(const KeyInfo& key) {
  if (key.need == KeyInfo::Need::required) return "**required**";
  if (!key.fallback.empty()) return '`' + key.fallback + '`';
  return key.fallback_words;
}

std::string path_of(const std::string& parent, const KeyInfo& key) {
  return (parent.empty() ? "" : parent + ".") + key.key + (is_section(key) && key.has_type("array") ? "[]" : "");
}

std::string table(const std::string& path, const std::vector<KeyInfo>& keys) {
  std::string out = "\n| key | value | default | meaning |\n|---|---|---|---|\n";
  for (const KeyInfo& key : keys) {
    const std::string name = '`' + key.key + '`';
    const std::string linked = is_section(key) ? "[" + name + "](#" + anchor(path_of(path, key)) + ")" : name;
    out +=
        "| " + linked + " | " + cell(key.type) + " | " + cell(default_of(key)) + " | " + cell(key.description) + " |\n";
  }
  return out;
}

/// Keys of the group that can be given together.
std::string exceptions(const KeyGroup& group) {
  std::string text;
  for (const auto& set : group.together) {
    std::string keys;
    for (const std::string& key : set) keys += (keys.empty() ? "`" : " and `") + key + '`';
    text += " " + keys + " can be given together.";
  }
  return text;
}

std::string sentence(const KeyGroup& group) {
  std::string keys;
  for (const std::string& key : group.keys) keys += (keys.empty() ? "`" : ", `") + key + '`';
  std::string with;
  for (const Anchor& anchor : group.only_with) {
    with += (with.empty() ? "With `" : " or `") + to_string(anchor) + '`';
  }
  if (!with.empty()) with += ": ";
  switch (group.need) {
    case KeyGroup::Need::exactly_one:
      return with + "exactly one of " + keys + "." + exceptions(group);
    case KeyGroup::Need::at_least_one:
      return with + "at least one of " + keys + ".";
    case KeyGroup::Need::at_most_one:
      return with + "at most one of " + keys + ".";
    case KeyGroup::Need::all:
      return with + keys + ".";
    case KeyGroup::Need::any:
      return with + "optionally " + keys + ".";
  }
  return "";
}

void write_sections(const std::string& path, const std::vector<KeyInfo>& keys, std::string& out) {
  for (const KeyInfo& key : keys) {
    if (!is_section(key)) continue;
    const std::string own_path = path_of(path, key);
    const auto depth = std::count(own_path.begin(), own_path.end(), '.');
    out += "\n" + std::string(static_cast<std::size_t>(depth) + 2, '#') + " " + own_path + "\n\n" +
           capitalised(key.description) + ".\n";
    out += table(own_path, key.children);
    for (const KeyGroup& group : key.groups) {
      out += "\n" + capitalised(sentence(group)) + "\n";
    }
    write_sections(own_path, key.children, out);
  }
}

}  // namespace

std::string key_reference(const std::vector<KeyInfo>& keys) {
  std::string out = "\n## Top level\n" + table("", keys);
  write_sections("", keys, out);
  return out;
}

std::string input_reference() {
  return input_introduction + key_reference(input_keys());
}

}  // namespace pliant
