#include "input/sections/output.hpp"

#include "base/text.hpp"
#include "input/formats.hpp"
#include "input/output_fields.hpp"

#include <nlohmann/json.hpp>

namespace pliant {
namespace {

/// A field, or a component of one, with its place.
Format<Located<std::string>> field_or_component() {
  const auto names = names_of_fields_and_components();
  Format<Located<std::string>> format{
      "one of `fields`, or a component of one, such as `displacement_z`", choice(names).schema, {}, {}};
  format.read = [names](const InputNode& node, const std::string& key, Diagnostics& diagnostics,
                        Located<std::string>& into) {
    into = {node.text, node.where};
    if (node.kind == InputNode::Kind::scalar && field_component(node.text)) return true;
    diagnostics.add(node.place(), "'" + key + "' must be a field of the result or a component of one, such as " +
                                      "von_mises_stress or displacement_z, not " + description(node) +
                                      did_you_mean(node.text, names) +
                                      "; the fields are: " + joined(names_of_fields()));
    return false;
  };
  format.write = [](const Located<std::string>& of) { return InputNode::scalar(of.value); };
  return format;
}

Section<FieldColumnConfig> field_column_keys() {
  using C = FieldColumnConfig;
  using Take = C::Take;
  return {
      {
          field("name", &C::name, column_name(), "name of the column").required(),
          field("of", &C::of, field_or_component(), "the field; of a vector without a component its magnitude")
              .required(),
          field("in", &C::in, name_of_part(),
                "where: a physical volume or surface, or the name of a shell or rod for fields of those; on a surface, "
                "cells count that have a facet there")
              .otherwise_in_words("all bodies, shells or rods"),
          field(
              "take", &C::take,
              choice_of<Take>({{"max", Take::max},
                               {"min", Take::min},
                               {"mean", Take::mean},
                               {"integral", Take::integral},
                               {"norm", Take::norm}}),
              "the largest or smallest value, the mean or the integral over the reference volume or area, or the root "
              "of the integral of the square (L2 norm)"),
          field("at", &C::at, name_of_probe(), "instead: the value at this probe"),
      },
      {{{"take", "at"}, KeyGroup::Need::exactly_one}, {{"in", "at"}, KeyGroup::Need::at_most_one}},
      &C::where};
}

}  // namespace

Section<OutputConfig> output_keys() {
  return {{
      field("directory", &OutputConfig::directory, text(), "where results go, relative to the working directory")
          .otherwise_in_words("out/<name of the input file>"),
      field("every", &OutputConfig::every, quantity("s", Range::above(0)), "time between frames of the result")
          .otherwise_in_words("every step"),
      field("fields", &OutputConfig::fields, list_of(choice(names_of_fields()), 1), "fields of the result")
          .otherwise("[displacement, velocity, cauchy_stress]"),
      field("nodal", &OutputConfig::is_nodal, truth(),
            "whether fields of cells are smoothed and written at the nodes (recovery), except `discretization_error` "
            "and those "
            "of rods")
          .otherwise("false"),
      field("history", &OutputConfig::history, list_of(map_of(field_column_keys()), 0),
            "columns of history.csv that are taken from fields"),
  }};
}

}  // namespace pliant
