#include "input/input.hpp"

#include "base/error.hpp"
#include "fuzz/targets.hpp"

#include <stdexcept>

namespace pliant::fuzz {

void read_as_input(std::string_view bytes) {
  Config config;
  try {
    config = read_input(std::string(bytes), "fuzz.yaml", {});
  } catch (const InputError& error) {
    if (error.diagnostics().empty()) throw std::logic_error("an error that tells nothing");
    return;
  }
  const std::string once = dump(config);
  try {
    if (dump(read_input(once, "fuzz.yaml", {})) != once)
      throw std::logic_error("reads back as another input:\n" + once);
  } catch (const InputError& error) {
    throw std::logic_error(std::string(error.what()) + "\nin what was written of a good input:\n" + once);
  }
}

}  // namespace pliant::fuzz
