#include "input/defaults.hpp"

#include "material/library.hpp"

#include <algorithm>
#include <filesystem>

namespace pliant {
namespace {

constexpr double min_step_divisor = 1024;              // ten halvings
constexpr double min_adaptive_step_divisor = 1 << 20;  // what is fast at the start may last a millionth of the step
constexpr double first_step_divisor = 1000;            // parts of an adaptive run
constexpr double max_step_divisor = 10;
constexpr int load_steps_of_path = 20;  // its first step must be near the straight line along the tangent

/// The first step is the user's, or else one between the bounds that the user gives.
void complete_adaptive(TimeConfig& time, const InputNode& section) {
  AdaptiveConfig& adaptive = *time.adaptive;
  if (given(section, {"step"}) == nullptr) {
    time.step = std::max(time.end / first_step_divisor, adaptive.min_step);
    if (adaptive.max_step > 0) time.step = std::min(time.step, adaptive.max_step);
  }
  if (adaptive.max_step <= 0) adaptive.max_step = std::max(time.end / max_step_divisor, time.step);
  if (adaptive.min_step <= 0) adaptive.min_step = time.step / min_adaptive_step_divisor;
  if (adaptive.absolute_velocity <= 0 && time.step > 0) adaptive.absolute_velocity = adaptive.absolute / time.step;
  if (given(section, {"min_step"}) == nullptr) time.min_step = adaptive.min_step;
}

void complete_time(TimeConfig& time, const InputNode& root) {
  if (const InputNode* section = given(root, {"time"}); time.path && given(*section, {"load_steps"}) == nullptr) {
    time.load_steps = load_steps_of_path;
  }
  if (const InputNode* section = given(root, {"time"}); time.adaptive && section != nullptr) {
    complete_adaptive(time, *section);
  }
  if (time.min_step <= 0) time.min_step = time.step / min_step_divisor;
  if (time.startup) return;
  const Method* method = method_of(time);
  time.startup = time.adaptive && method != nullptr && method->num_steps > 1 ? Startup::dirk33 : Startup::ramp;
}

template <class Entries>
void place_whole_mesh_parts(Entries& entries) {
  for (auto& e : entries) {
    if (e.part.kind == Selection::Kind::everything) e.part.where = e.where;
  }
}

}  // namespace

void complete_defaults(Config& config, const InputNode& root) {
  namespace fs = std::filesystem;
  const fs::path input(config.file);
  const fs::path mesh(config.mesh.file.value);
  if (!mesh.empty() && mesh.is_relative()) config.mesh.file.value = (input.parent_path() / mesh).string();
  for (RigidBodyConfig& body : config.rigid_bodies) {
    if (!body.surface) continue;
    const fs::path file(body.surface->file.value);
    if (!file.empty() && file.is_relative()) body.surface->file.value = (input.parent_path() / file).string();
  }
  if (config.contact) {
    for (ObstacleConfig& o : config.contact->obstacles) {
      auto* surface = std::get_if<ObstacleConfig::Surface>(&o.shape);
      if (surface == nullptr) continue;
      const fs::path file(surface->file.value);
      if (!file.empty() && file.is_relative()) surface->file.value = (input.parent_path() / file).string();
    }
  }
  if (config.output.directory.empty()) config.output.directory = (fs::path("out") / input.stem()).string();
  if (const InputNode* every = given(root, {"output", "every"})) config.output.every_where = every->where;
  for (BodyConfig& body : config.bodies) {
    if (!body.elasticity || body.density) continue;
    if (const LibraryMaterial* material = find_material(body.elasticity->library)) body.density = material->density;
  }
  for (ShellConfig& shell : config.shells) {
    const LibraryMaterial* material = find_material(shell.elasticity.library);
    if (material != nullptr && !shell.density) shell.density = material->density;
  }
  complete_time(config.time, root);
  place_whole_mesh_parts(config.bodies);
  place_whole_mesh_parts(config.loads);
}

}  // namespace pliant
