/// The page of a fit: one file of HTML that needs no other, part by part.
#pragma once

#include "study/fit_plots.hpp"
#include "study/fit_problem.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A table whose cells are escaped; those of the first column are words.
class HtmlTable {
 public:
  explicit HtmlTable(const std::vector<std::string>& header) { add_row(header, "th"); }
  void add(const std::vector<std::string>& cells) { add_row(cells, "td"); }
  std::string text() const { return "<table>\n" + rows_ + "</table>\n"; }

 private:
  void add_row(const std::vector<std::string>& cells, const char* tag);
  std::string rows_;
};

struct ParameterOnPage {
  std::string name;
  double value;
  std::optional<double> standard_error;  ///< none: it was held
  std::string unit;
};

/// Up to the title, escaped, and a sentence below it.
std::string start_of_page(const std::string& title, const std::string& summary);
std::string end_of_page();
/// A heading, what the part means, and what belongs there as HTML.
std::string part_of_page(const char* heading, const char* meaning, const std::string& content);
/// To be copied as it is.
std::string text_on_page(const std::string& text);
/// Four digits; signs for what is unknown or infinite.
std::string number_on_page(double value);

std::string messages_on_page(const std::vector<std::string>& warnings, const std::vector<std::string>& notes);
std::string parameters_on_page(const std::vector<ParameterOnPage>& rows);
std::string plots_on_page(const std::vector<NamedPlot>& all, const char* meaning);
/// `names`: of the fitted parameters.
std::string determination_on_page(const std::vector<std::string>& names, const Determination& known);
std::string correlations_on_page(const std::vector<std::string>& names, const FitOutcome& outcome);

}  // namespace pliant
