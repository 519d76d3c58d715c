/// Numbers of the histories of the levels of a convergence study, and how fast they converge.
#pragma once

#include "io/svg_plot.hpp"
#include "study/run_numbers.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// What is common to all levels of a study.
struct LevelScale {
  std::string label;          ///< of the axis over which errors are drawn: "mesh size [m]"
  double refinement = 2.0;    ///< from level to level
  bool has_reference = true;  ///< errors are distances from a reference; otherwise from the next level
};

/// The order p of errors that fall with h^p, when h is divided by `refinement`.
double observed_order(double coarse, double fine, double refinement);

class LevelResults {
 public:
  /// `input`: the text of a run.yaml of the study, for the units.
  LevelResults(std::vector<RunNumber> numbers, LevelScale scale, const std::string& input);

  const std::vector<RunNumber>& numbers() const { return numbers_; }
  void set_reference(std::vector<double> values) { reference_ = std::move(values); }
  /// A level of a method, after the coarser ones. `size`: where it is on the axis. `values`: one for each number; NaN
  /// where there is none.
  void add(const std::string& method, int level, double size, std::vector<double> values);

  /// A table for each number: value, error, order; without a reference also the limit that the last three values
  /// suggest (Richardson's extrapolation).
  std::vector<std::string> tables() const;
  /// Writes results.csv (method,level,size,result,value,error,order), and for each number that has an error
  /// error_NAME.svg, the error over the size. Returns their names; none without numbers. Collective.
  std::vector<std::string> write(MPI_Comm comm, const std::filesystem::path& directory, const std::string& title) const;

 private:
  std::string csv() const;
  /// Nothing if no error is above zero.
  std::optional<Plot> plot(std::size_t number, const std::string& title) const;
  struct Level {
    std::string method;
    int level;
    double size;
    std::vector<double> values;
  };

  double error(std::size_t level, std::size_t number) const;
  double order(std::size_t level, std::size_t number) const;
  /// Whether the levels belong to one method.
  bool is_finer(std::size_t level, std::size_t than) const;
  std::string limit(std::size_t last, std::size_t number) const;
  std::string label(std::size_t number) const;

  std::vector<RunNumber> numbers_;
  LevelScale scale_;
  LabelledHistory units_;
  std::vector<double> reference_;
  std::vector<Level> levels_;
};

}  // namespace pliant
