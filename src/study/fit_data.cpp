#include "study/fit_data.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "base/units.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

/// A cell of a line and the column of the text where it begins, from 1.
struct Cell {
  std::string text;
  int column;
};

std::vector<Cell> split_line(std::string_view line) {
  std::vector<Cell> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::string_view whole = line.substr(begin, end - begin), text = trimmed(whole);
    const std::size_t blanks = text.empty() ? 0 : static_cast<std::size_t>(text.data() - whole.data());
    cells.push_back({std::string(text), static_cast<int>(begin + blanks) + 1});
    begin = end + 1;
  }
  return cells;
}

std::string unquoted(std::string text) {
  const bool is_quoted = text.size() > 1 && text.front() == '"' && text.back() == '"';
  return is_quoted ? text.substr(1, text.size() - 2) : text;
}

/// A cell of the header: the name in the form in which names are compared, and the unit.
struct Heading {
  std::string name, unit;
};

Heading heading_of(std::string text) {
  text = unquoted(std::move(text));
  Heading heading{text, ""};
  const std::size_t open = text.find_first_of("[(");
  if (open != std::string::npos && (text.back() == ']' || text.back() == ')')) {
    heading.unit = trimmed(std::string_view(text).substr(open + 1, text.size() - open - 2));
    heading.name = trimmed(std::string_view(text).substr(0, open));
  }
  for (char& c : heading.name) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return heading;
}

/// Rubber breaks at strains of 5 to 15.
constexpr double largest_plain_strain = 20.0;

/// Where a wanted column is in the table, and how its numbers become what is wanted.
struct FoundColumn {
  std::size_t place;
  double factor, offset;
  bool is_plain_strain = false;     ///< without a unit in the header
  std::vector<FoundColumn> others;  ///< that say the same in another form

  double value(double number) const { return factor * number + offset; }
};

/// The file while it is read.
class Table {
 public:
  explicit Table(std::string file) : file_(std::move(file)) {}

  /// The columns that are wanted.
  MeasuredColumns read(std::istream& stream, std::span<const std::vector<ColumnForm>> wanted) {
    auto columns = read(stream, [&](const auto& header, int line) { return columns_of(header, line, wanted); });
    std::string note;
    if (!without_unit_.empty()) {
      note = fmt::format(
          "{}: columns without a unit in the header are read in SI units: {}; state another as in "
          "'stress [MPa]'",
          file_, joined(without_unit_));
    }
    if (largest_strain_ > largest_plain_strain) {
      note += fmt::format("{}strains of {:.3g} are {:.0f} %; if they are in per cent, write 'strain [%]' in the header",
                          note.empty() ? file_ + ": " : "; ", largest_strain_, 100.0 * largest_strain_);
    }
    return {std::move(columns), note};
  }

  NumberTable read_all(std::istream& stream) {
    NumberTable table;
    table.columns = read(stream, [&](const auto& header, int) {
      std::vector<FoundColumn> all;
      for (const Cell& cell : header) {
        table.names.push_back(unquoted(cell.text));
        all.push_back({all.size(), 1.0, 0.0, false, {}});
      }
      return all;
    });
    table.lines = lines_;
    return table;
  }

 private:
  static constexpr std::size_t most_errors = 20;

  template <class Choose>
  std::vector<std::vector<double>> read(std::istream& stream, const Choose& choose) {
    std::vector<std::vector<double>> columns;
    std::vector<FoundColumn> found;
    std::size_t width = 0;
    int number = 0;
    for (std::string line; std::getline(stream, line);) {
      ++number;
      if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
      if (line.ends_with('\r')) line.pop_back();
      if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
      const auto cells = split_line(line);
      if (width == 0) {
        width = cells.size();
        found = choose(cells, number);
        columns.resize(found.size());
      } else if (cells.size() != width) {
        fail(number, 1,
             fmt::format("this row has {} values, the header {} columns; values are separated by ',' and a decimal "
                         "point is written '.'",
                         cells.size(), width));
      } else {
        lines_.push_back(number);
        for (std::size_t k = 0; k < found.size(); ++k) {
          append(cells[found[k].place], number, found[k], columns[k]);
          compare(cells, number, found[k]);
        }
      }
      if (errors_.size() > most_errors) break;
    }
    if (width == 0) fail(0, 0, "the table is empty; its first line names the columns");
    if (errors_.empty() && columns.front().empty()) fail(0, 0, "the table has a header, but no rows");
    if (!errors_.empty()) throw InputError(std::move(errors_));
    return columns;
  }

  void fail(int line, int column, std::string message) {
    errors_.push_back({Severity::error, {file_, line, column}, std::move(message)});
  }

  std::vector<FoundColumn> columns_of(const std::vector<Cell>& header, int line,
                                      std::span<const std::vector<ColumnForm>> wanted) {
    if (header.size() == 1 && header[0].text.find_first_of(";\t") != std::string::npos) {
      fail(line, 1,
           fmt::format("the header '{}' is a single column; columns are separated by ',' and a decimal point is "
                       "written '.'",
                       excerpt(header[0].text)));
      throw InputError(std::move(errors_));  // every row would say it again
    }
    std::vector<FoundColumn> found;
    for (const auto& forms : wanted) {
      if (const auto column = column_of(header, line, forms)) found.push_back(*column);
    }
    if (found.size() != wanted.size()) found.clear();
    return found;
  }

  std::optional<FoundColumn> column_of(const std::vector<Cell>& header, int line,
                                       const std::vector<ColumnForm>& forms) {
    std::vector<std::string> given, names;
    std::optional<FoundColumn> found;
    for (const Cell& cell : header) given.push_back(heading_of(cell.text).name);
    for (const ColumnForm& form : forms) {
      names.emplace_back(form.name);
      const auto place = static_cast<std::size_t>(std::ranges::find(given, form.name) - given.begin());
      if (place == given.size()) continue;
      if (std::ranges::count(given, form.name) > 1) {
        fail(line, header[place].column,
             fmt::format("the table has more than one column '{}'; leave one of them in it", form.name));
        return std::nullopt;
      }
      const std::string unit = heading_of(header[place].text).unit;
      try {
        const double factor = unit.empty() ? 1.0 : parse_quantity("1 " + unit, std::string(form.unit));
        const bool is_angular = form.name == "frequency" && unit.starts_with("rad");  // 1 rad is 1
        if (unit.empty() && form.unit != "1") without_unit_.push_back(fmt::format("{} in {}", form.name, form.unit));
        const bool is_plain_strain = unit.empty() && form.name == "strain";
        FoundColumn column{place, is_angular ? factor : form.factor * factor, form.offset, is_plain_strain, {}};
        if (found) {
          found->others.push_back(std::move(column));
        } else {
          found = std::move(column);
        }
      } catch (const UnitError& error) {
        fail(line, header[place].column, fmt::format("'{}': {}", header[place].text, error.what()));
        return std::nullopt;
      }
    }
    if (found) return found;
    std::string close;
    for (const std::string& name : given) close = close.empty() ? did_you_mean(name, names) : close;
    fail(line, 1,
         fmt::format("the table has no column '{}'{}; its header names {}", fmt::join(names, "' or '"), close,
                     joined(given)));
    return std::nullopt;
  }

  void append(const Cell& cell, int line, const FoundColumn& column, std::vector<double>& to) {
    const auto value = parse_number(cell.text);
    if (!value) {
      fail(line, cell.column,
           fmt::format("'{}' is not a number; units stand in the header, such as 'stress [MPa]'", excerpt(cell.text)));
      return;
    }
    if (column.is_plain_strain) largest_strain_ = std::max(largest_strain_, std::abs(*value));
    to.push_back(column.value(*value));
  }

  /// Columns that say the same, such as stretch and strain, must do so.
  void compare(const std::vector<Cell>& cells, int line, const FoundColumn& column) {
    constexpr double of_digits = 6e-3;  // half a unit of three digits, and a little
    const auto value = parse_number(cells[column.place].text);
    for (const FoundColumn& other : column.others) {
      const Cell& cell = cells[other.place];
      const auto same = parse_number(cell.text);
      if (!value || !same ||
          std::abs(other.value(*same) - column.value(*value)) <= of_digits * std::abs(column.value(*value))) {
        continue;
      }
      fail(
          line, cell.column,
          fmt::format("'{}' here contradicts '{}' of another column, which says the same in another form; leave one of "
                      "the columns out",
                      cell.text, cells[column.place].text));
    }
  }

  std::string file_;
  std::vector<Diagnostic> errors_;
  std::vector<int> lines_;  // of the rows
  std::vector<std::string> without_unit_;
  double largest_strain_ = 0.0;  // of columns of strain without a unit
};

bool is_directory(const std::string& file) {
  std::error_code ignored;
  return std::filesystem::is_directory(file, ignored);
}

}  // namespace

MeasuredColumns read_measurements(const std::string& file, const Location& named,
                                  std::span<const std::vector<ColumnForm>> wanted) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || is_directory(file)) {
    throw InputError(named,
                     fmt::format("'data': cannot read '{}'{}; give the path of a CSV file, relative to this file",
                                 excerpt(file, 200), similar_file(file)));
  }
  return Table(file).read(stream, wanted);
}

NumberTable read_numbers(const std::string& file, const Location& named) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || is_directory(file)) throw InputError(named, "cannot read it; give the path of a CSV file");
  return Table(file).read_all(stream);
}

}  // namespace pliant
