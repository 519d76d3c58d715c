#include "run/turn_watch.hpp"

#include "input/analysis.hpp"
#include "model/selections.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Jumps at the ends of a step do not belong to it: it begins and ends this part of its length within them.
constexpr double margin = 1e-6;
/// Larger angles have no shortest way, or have the opposite one [rad].
constexpr double half_turn = std::numbers::pi * (1.0 - 1e-3);
/// Parts of a step within which a rotation that is followed cannot turn as far.
constexpr int num_parts = 200;

}  // namespace

TurnWatch::TurnWatch(const Config& config) {
  if (analysis_of(config) == Analysis::static_equilibrium) static_time_ = config.time.end;
  for (const ConstraintConfig& constraint : config.constraints) {
    const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&constraint.kind);
    if (rigid == nullptr) continue;
    const auto* about = std::get_if<RotationConfig::AboutAxis>(&rigid->rotation.kind);
    if (about == nullptr || !about->angle) continue;
    rotations_.push_back({"the rotation of " + describe(constraint.part), &*about->angle, std::nullopt});
  }
  for (const JointConfig& joint : config.joints) {
    if (joint.type != JointType::hinge || !joint.motion) continue;
    rotations_.push_back({fmt::format("the motion of joint '{}'", joint.name), &*joint.motion, std::nullopt});
  }
}

double TurnWatch::angle_at(const Rotation& rotation, double at) const {
  return static_time_ ? at * (*rotation.angle)(0.0, 0.0, 0.0, *static_time_) : (*rotation.angle)(0.0, 0.0, 0.0, at);
}

std::optional<std::string> TurnWatch::too_far(double from, double to) const {
  const double within = margin * (to - from);
  for (const Rotation& rotation : rotations_) {
    const double angle = angle_at(rotation, to - within) - angle_at(rotation, from + within);
    if (!(std::abs(angle) >= half_turn) || jump(rotation, from + within, to - within)) continue;
    return fmt::format(
        "{} turns by {:.4g} rad, and a step can follow less than half a turn; if degrees are meant, write "
        "them with 'deg'; or take {}",
        rotation.name, angle, static_time_ ? "more 'time.load_steps'" : "a shorter 'time.step'");
  }
  return std::nullopt;
}

std::optional<double> TurnWatch::jump(const Rotation& rotation, double from, double to) const {
  double before = angle_at(rotation, from);
  for (int i = 1; i <= num_parts; ++i) {
    const double at = from + (to - from) * i / num_parts, now = angle_at(rotation, at);
    if (std::abs(now - before) >= half_turn) return at;
    before = now;
  }
  return std::nullopt;
}

std::optional<std::string> TurnWatch::accept(double from, double to) {
  const double within = margin * (to - from);
  std::optional<std::string> found;
  const auto note = [&](const Rotation& rotation, double angle, double at) {
    if (std::abs(angle) < half_turn || found) return;
    found = fmt::format(
        "{} jumps by {:.4g} rad at {} = {:.6g}{}, and bodies follow it the shortest way: whole turns are lost; let it "
        "turn in several steps",
        rotation.name, angle, static_time_ ? "load factor" : "t", at, static_time_ ? "" : " s");
  };
  for (Rotation& rotation : rotations_) {
    const double start = angle_at(rotation, from + within), end = angle_at(rotation, to - within);
    if (rotation.last) note(rotation, start - *rotation.last, from);
    if (std::abs(end - start) >= half_turn) {
      note(rotation, end - start, jump(rotation, from + within, to - within).value_or(to));
    }
    rotation.last = end;
  }
  return found;
}

void TurnWatch::forget() {
  for (Rotation& rotation : rotations_) rotation.last.reset();
}

}  // namespace pliant
