/// `pliant report`: a result as one page of HTML that plays the deforming bodies and plots the history.
#pragma once

#include "run/console.hpp"

#include <optional>
#include <string>

namespace pliant {

/// The arguments of `pliant report`.
struct ReportOptions {
  std::string place;            ///< the directory of a result, its result.h5 or result.xdmf
  std::string other;            ///< another one, shown next to it; empty: none
  std::string output;           ///< the file to write; empty: report.html, of two results comparison.html, in the
                                ///< directory of the (first) result
  double megabytes = 10.0;      ///< largest size of the page; frames are left out if it would be larger
  std::optional<double> watch;  ///< renew the page so often until the run ends [s]
};

/// Writes the page, from the results of one or two runs that may still be active; with `watch` again and again until
/// they end. Throws FileError on every rank without a result, or if the program was built without the viewer.
/// Collective.
void report_command(MPI_Comm comm, const ReportOptions& options, Console& console);

}  // namespace pliant
