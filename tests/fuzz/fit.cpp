#include "base/error.hpp"
#include "fuzz/targets.hpp"
#include "study/fit_input.hpp"

#include <stdexcept>

namespace pliant::fuzz {

void read_as_fit(std::string_view bytes) {
  try {
    const FitConfig config = read_fit(std::string(bytes), "fuzz.yaml");
    if (config.input.has_value() == !config.material.model.empty()) {
      throw std::logic_error("a fit of neither or of both a material and an input");
    }
  } catch (const InputError& error) {
    if (error.diagnostics().empty()) throw std::logic_error("an error without a diagnostic");
  }
}

}  // namespace pliant::fuzz
