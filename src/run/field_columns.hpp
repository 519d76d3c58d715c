/// Columns of the history that are taken from fields: `output.history`.
#pragma once

#include "base/limits.hpp"
#include "run/result_fields.hpp"

#include <string>
#include <vector>

namespace pliant {

class FieldColumns {
 public:
  /// `model` and `fields` outlive the object. Not collective.
  FieldColumns(const Config& config, const Model& model, ResultFields& fields);

  /// One number for each entry of `output.history`, the same on every rank. Collective.
  std::vector<double> values(const StepRecord& record);

 private:
  using Take = FieldColumnConfig::Take;

  struct Column {
    FieldComponent of;
    Take take;
    const FieldRegion* region;
    std::vector<double> sizes;             ///< of the region's cells [m^3] or facets [m^2]
    const ProbeLocation* probe = nullptr;  ///< instead of a region

    /// The number that the column takes from a place, where the field's components have these values.
    double number(const double* values) const;
  };
  /// This rank's share of a column.
  struct Partial {
    double integral = 0.0;
    double size = 0.0;
    double largest = -infinity;  ///< or the negative of the smallest
  };

  static void take_at_probe(const Column& column, const FieldValues& field, Partial& sum);
  void take_from_cells(const Column& column, const FieldValues& field, Partial& sum) const;
  void take_from_nodes(const Column& column, const FieldValues& field, Partial& sum) const;
  void take_from_shells(const Column& column, const StepRecord& record, Partial& sum) const;
  void take_from_rods(const Column& column, const StepRecord& record, Partial& sum) const;
  /// The square of grad u at all points of the cells, which are not only centroids.
  void take_squares_of_gradient(const Column& column, std::span<const double> u, Partial& sum) const;
  static void add(const Column& column, double weight, const double* values, Partial& sum);
  static void compare(const Column& column, const double* values, Partial& sum);

  const Model& model_;
  const NodeLayout& layout_;
  ResultFields& fields_;
  std::vector<Column> columns_;
  std::vector<std::string> names_;  // of the fields that they need
};

}  // namespace pliant
