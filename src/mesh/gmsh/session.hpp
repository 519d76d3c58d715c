/// The lifetime of libgmsh in the process, and its failures as exceptions.
#pragma once

#include <functional>
#include <string>

namespace pliant {

/// Initialises gmsh without output and without configuration files, and finalises it at the end of the scope. Only one
/// may exist at a time.
class GmshSession {
 public:
  GmshSession();
  ~GmshSession();
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;

  /// Runs `work`, a set of gmsh calls. If gmsh throws or logs an error, throws MeshDefect: "gmsh could not `doing`:",
  /// then gmsh's own errors.
  void run(const std::string& doing, const std::function<void()>& work) const;
};

}  // namespace pliant
