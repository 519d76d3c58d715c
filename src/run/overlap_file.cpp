#include "run/overlap_file.hpp"

#include "base/file.hpp"
#include "io/facet_file.hpp"
#include "petsc/collective.hpp"

#include <filesystem>
#include <system_error>

namespace pliant {
namespace {

std::filesystem::path overlap_file(const Config& config) {
  return std::filesystem::path(config.output.directory) / "overlap.vtu";
}

}  // namespace

InputError with_overlap_file(MPI_Comm comm, const Config& config, const OverlapError& error) {
  const OverlappingFacets& facets = error.facets();
  const std::filesystem::path file = overlap_file(config);
  std::vector<Diagnostic> diagnostics = error.diagnostics();
  std::string& message = diagnostics.back().message;
  try {
    on_root(comm, [&] {
      make_directory(config.output.directory);
      const std::vector<FacetField> fields{{"body", {facets.bodies.begin(), facets.bodies.end()}, true},
                                           {"other", {facets.others.begin(), facets.others.end()}, true},
                                           {"depth", facets.depths, false}};
      write_facets(file, facets.corners, fields);
    });
    message += ". These facets are in " + file.string() + " (open it in ParaView, colour by depth)";
  } catch (const FileError& reason) {
    message += std::string(". These facets could not be written: ") + reason.what();
  }
  return InputError(std::move(diagnostics));
}

void remove_overlap_file(MPI_Comm comm, const Config& config) {
  on_root(comm, [&] {
    std::error_code ignored;
    std::filesystem::remove(overlap_file(config), ignored);
  });
}

}  // namespace pliant
