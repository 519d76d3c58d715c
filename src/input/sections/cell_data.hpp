/// Values of the input that may come from the mesh file, cell by cell.
#pragma once

#include "input/formats.hpp"

namespace pliant {

/// A value, or the name of the data in the mesh file that contains it.
template <class V>
struct ValueOrCellData {
  V value{};
  std::string cell_data;  ///< empty: `value` counts
};

struct CellDataName {
  std::string cell_data;
};
/// `{cell_data: name}`.
Format<CellDataName> cell_data_format();

/// As `plain`, or `{cell_data: name}`.
template <class V>
Format<ValueOrCellData<V>> or_cell_data(const Format<V>& plain) {
  const Format<CellDataName> named = cell_data_format();
  Format<ValueOrCellData<V>> format{
      plain.type + ", or `{cell_data: name}`", either_schema(plain.schema, named.schema), {}, {}};
  format.read = [plain, named](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                               ValueOrCellData<V>& into) {
    if (node.kind != InputNode::Kind::map) return plain.read(node, name, diagnostics, into.value);
    CellDataName data;
    named.read(node, name, diagnostics, data);
    into.cell_data = data.cell_data;
    return !data.cell_data.empty();
  };
  format.write = [plain, named](const ValueOrCellData<V>& from) {
    return from.cell_data.empty() ? plain.write(from.value) : named.write({from.cell_data});
  };
  return format;
}

/// A direction: three components or formulas of the position, or data of the mesh.
template <class T>
Field<T> direction_field(const std::string& key, std::vector<GivenDirection> T::*member,
                         const std::string& description) {
  const auto format = or_cell_data(array_of<3>(expression("1", Variables::space)));
  Field<T> result{{key, format.type, description}};
  result.info.schema = format.schema;
  result.read = [key, member, read = format.read](const InputNode& node, Diagnostics& diagnostics, T& into) {
    ValueOrCellData<VectorExpression> given;
    if (!read(node, key, diagnostics, given)) return;
    (into.*member).push_back({key, std::move(given.value), std::move(given.cell_data), node.where});
  };
  result.write = [key, member, write = format.write](const T& from) {
    for (const GivenDirection& d : from.*member) {
      if (d.key == key) return write({d.value, d.cell_data});
    }
    return InputNode{};
  };
  return result;
}

}  // namespace pliant
