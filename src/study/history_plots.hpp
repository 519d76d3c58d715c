/// Histories of several runs in common plots.
#pragma once

#include "study/labelled_history.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Names of all columns, in the order in which the histories bring them.
std::vector<std::string> columns_of(std::span<const LabelledHistory> histories);

/// Whether a column describes the computation (numbers of steps and iterations), not the bodies.
bool is_bookkeeping(const std::string& column);

/// A name that every file system takes.
std::string file_name_of(std::string text);

/// Writes DIRECTORY/COLUMN.svg, the column of all histories over what they count as time, unless it varies in none of
/// them. Returns whether it did. Not collective.
bool draw_column(std::span<const LabelledHistory> histories, const std::string& column,
                 const std::filesystem::path& directory);

}  // namespace pliant
