/// The input's constraints on the mesh.
#pragma once

#include "app/config.hpp"
#include "app/selections.hpp"
#include "energy/prescribed.hpp"

#include <memory>
#include <string>
#include <vector>

namespace pliant {

/// Owned entries whose reactions are summed under one name.
struct Support {
  std::string name;
  std::vector<PetscInt> dofs;
};

class Constraints {
 public:
  /// Throws InputError with its mistakes and those that `selections` has found before. Collective.
  Constraints(const Config& config, const NodeLayout& layout, Selections& selections);

  const PrescribedDisplacement& prescribed() const { return *prescribed_; }
  const std::vector<Support>& supports() const { return supports_; }

 private:
  void add_supports(const Config& config, const std::vector<PrescribedPart>& parts);

  std::unique_ptr<PrescribedDisplacement> prescribed_;
  std::vector<Support> supports_;
};

}  // namespace pliant
