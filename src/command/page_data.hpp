/// What a page of the viewer carries: a JSON text, and large data in elements of their own.
#pragma once

#include "io/packed_result.hpp"

#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace pliant {

using Json = nlohmann::ordered_json;

/// Throws FileError if the program was built without the viewer.
void require_viewer();

/// The page under construction: large data are identified by number.
class Page {
 public:
  /// Adds data and returns their number.
  int block(const std::string& text);
  int block(std::span<const double> numbers);
  /// The whole page of the viewer with this report. require_viewer() has been called.
  std::string filled(const Json& report) const;

 private:
  std::string blocks_;
  int count_ = 0;
};

/// Bodies, frames and fields, whose data are added to the page.
Json json_of(const PackedResult& result, Page& page);

/// Adds when the page is written, and by which program.
void add_origin(Json& report);

}  // namespace pliant
