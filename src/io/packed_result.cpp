#include "io/packed_result.hpp"

#include "base/error.hpp"
#include "base/limits.hpp"
#include "io/body_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

constexpr std::size_t most_frames = 240;
constexpr int most_levels = 65535;
constexpr double levels_of_displacement = 16383.0, levels_of_fields = 1023.0, least_levels = 255.0;
constexpr double unseen = 1e-3;  // share of the values at either end of a field outside the range of colours
// What a page writes around a text, and of a frame [bytes]; no less than it is.
constexpr std::size_t around_text = 150, size_of_frame = 200;

/// A field of the page, derived from one of the result.
struct Channel {
  std::string name;
  ResultField source;
  int components;  // 1 or 3
  void (*reduce)(const double* value, double* reduced);
};

/// sqrt(3/2 s:s), s the deviator; stress: xx yy zz xy yz xz
void von_mises(const double* s, double* reduced) {
  const double normal = (s[0] - s[1]) * (s[0] - s[1]) + (s[1] - s[2]) * (s[1] - s[2]) + (s[2] - s[0]) * (s[2] - s[0]);
  *reduced = std::sqrt(0.5 * normal + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

void mean(const double* s, double* reduced) {
  *reduced = (s[0] + s[1] + s[2]) / 3.0;
}

void same_vector(const double* value, double* reduced) {
  std::copy_n(value, 3, reduced);
}

template <int component>
void one_of_three(const double* value, double* reduced) {
  *reduced = value[component];
}

void same_number(const double* value, double* reduced) {
  *reduced = *value;
}

std::vector<Channel> channels_of(const std::vector<ResultField>& fields) {
  std::vector<Channel> channels;
  const auto has = [&](const char* name) {
    return std::ranges::find(fields, name, &ResultField::name) != fields.end();
  };
  for (const auto& field : fields) {
    if (field.components == 1) channels.push_back({field.name, field, 1, same_number});
    if (field.components == 3 && field.name.starts_with("principal_")) {  // no vector
      channels.push_back({field.name + "_1", field, 1, one_of_three<0>});
      channels.push_back({field.name + "_2", field, 1, one_of_three<1>});
      channels.push_back({field.name + "_3", field, 1, one_of_three<2>});
    } else if (field.components == 3) {
      channels.push_back({field.name, field, 3, same_vector});
    }
    if (field.name != "cauchy_stress" || field.components != 6) continue;
    if (!has("von_mises_stress")) channels.push_back({"von_mises_stress", field, 1, von_mises});
    channels.push_back({"mean_stress", field, 1, mean});
  }
  const auto is_displacement = [](const Channel& c) { return c.name == "displacement" && c.components == 3; };
  std::ranges::stable_partition(channels, is_displacement);
  return channels;
}

/// What rigid bodies have of a field of deformable ones; nothing for fields of everything, of contact and of shells.
std::optional<double> value_in_rigid_bodies(std::string_view field) {
  constexpr std::array<std::string_view, 9> others{"displacement",   "velocity",       "acceleration",
                                                   "contact_",       "membrane_",      "principal_membrane_",
                                                   "bending_moment", "principal_bend", "principal_curvature"};
  if (std::ranges::any_of(others, [&](std::string_view other) { return field.starts_with(other); })) return {};
  return field == "volume_ratio" || field == "principal_stretches" ? 1.0 : 0.0;
}

/// Indices 0 .. count - 1, at most `most` of them, evenly, with both ends.
std::vector<std::size_t> thinned(std::size_t count, std::size_t most) {
  std::vector<std::size_t> kept;
  most = std::max<std::size_t>(most, 2);
  if (count <= most) most = count;
  for (std::size_t i = 0; i < most; ++i) kept.push_back(most == 1 ? 0 : i * (count - 1) / (most - 1));
  return kept;
}

ElementCounts elements_of(const OutputMesh& mesh) {
  const auto is_one_of = [&](const std::vector<std::string>& names, int body) {
    return std::ranges::find(names, mesh.body_names[static_cast<std::size_t>(body)]) != names.end();
  };
  ElementCounts counts;
  for (const int body : mesh.bodies) {
    if (body >= 0 && is_one_of(mesh.rods, body)) {
      ++counts.segments;
    } else if (body >= 0 && is_one_of(mesh.shells, body)) {
      ++counts.triangles;
    } else if (body < 0 || (!is_one_of(mesh.masses, body) && !is_one_of(mesh.sections, body))) {
      ++counts.tetrahedra;
    }
  }
  return counts;
}

struct Scene {
  std::string group;
  std::size_t num_nodes = 0, num_cells = 0;
  BodySurface surface;
  std::vector<char> is_rigid;  // of each body
  EarlierNeighbours neighbours;
  PackedMesh packed;
  Companions companions;
};

std::vector<std::uint16_t> quantised(const Quantisation& scale, std::span<const float> values) {
  std::vector<std::uint16_t> q;
  q.reserve(values.size());
  for (const double value : values) q.push_back(scale(value));
  return q;
}

/// A frame as read: of each channel the values at the vertices, by component.
struct Values {
  PackedFrame frame;
  std::vector<std::vector<std::vector<float>>> of_channels;
  Companions::Frame companions;
};

class Packer {
 public:
  Packer(const ResultReader& result, std::size_t most_bytes) : result_(result), most_bytes_(most_bytes) {
    if (result.frames().empty()) throw FileError("the result holds no frame yet");
    channels_ = channels_of(result.fields(result.frames().back()));
    packed_.num_frames = result.frames().size();
    read(thinned(result.frames().size(), frames_that_fit()));
  }

  PackedResult operator()() {
    std::size_t count = frames_.size();
    for (;;) {
      encode(thinned(frames_.size(), count));
      if (packed_.size() <= most_bytes_ || count <= 2) return std::move(packed_);
      const double share = static_cast<double>(most_bytes_) / static_cast<double>(packed_.size());
      count = std::min(count - 1, static_cast<std::size_t>(0.97 * share * static_cast<double>(count)));
    }
  }

 private:
  std::size_t num_components() const {
    std::size_t n = 0;
    for (const auto& channel : channels_) n += static_cast<std::size_t>(channel.components);
    return n;
  }

  /// No value was seen to take less than a fifth of a byte; frames that cannot fit then need not be read.
  std::size_t frames_that_fit() {
    const Scene& scene = scenes_[scene_of(result_.frames().back().mesh)];
    const std::size_t values = std::max<std::size_t>(scene.surface.num_vertices() * num_components(), 1);
    return std::min(most_frames, std::max<std::size_t>(5 * most_bytes_ / values, 2));
  }

  std::size_t scene_of(const std::string& group) {
    const auto known = std::ranges::find(scenes_, group, &Scene::group);
    if (known != scenes_.end()) return static_cast<std::size_t>(known - scenes_.begin());
    const OutputMesh mesh = result_.mesh(group);
    Scene scene;
    scene.group = group;
    scene.num_nodes = packed_.num_nodes = mesh.coordinates.size() / 3;
    scene.num_cells = mesh.bodies.size();
    packed_.elements = elements_of(mesh);
    scene.surface = surface_of_bodies(mesh);
    for (const std::string& name : mesh.body_names) {
      scene.is_rigid.push_back(std::ranges::find(mesh.rigid, name) != mesh.rigid.end() ? 1 : 0);
    }
    scene.neighbours = EarlierNeighbours(scene.surface.num_vertices(), scene.surface.triangles);
    pack(mesh, scene);
    scene.companions = Companions(result_, group);
    packed_.body_names = mesh.body_names;
    packed_.unseen_bodies = mesh.sections;
    packed_.masses = mesh.masses;
    packed_.nodes_per_cell = mesh.nodes_per_cell;
    scenes_.push_back(std::move(scene));
    return scenes_.size() - 1;
  }

  static void pack(const OutputMesh& mesh, Scene& scene) {
    const BodySurface& surface = scene.surface;
    PackedMesh& packed = scene.packed;
    packed.num_vertices = surface.num_vertices();
    packed.num_triangles = surface.triangles.size() / 3;
    packed.triangles_per_facet = surface.triangles_per_facet;
    packed.triangles = packed_triangles(surface.triangles);
    packed.bodies = packed_text(std::as_bytes(std::span(surface.bodies)));
    const std::vector<double> points = at_vertices(surface, mesh.coordinates, FieldLocation::node, 3);
    for (std::size_t i = 0; i < 3; ++i) {
      std::tie(packed.positions[i], packed.scales[i]) = packed_rows({component_of(points, i)}, scene.neighbours);
    }
  }

  void read(const std::vector<std::size_t>& chosen) {
    for (const std::size_t i : chosen) {
      const ResultFrame& frame = result_.frames()[i];
      if (auto values = read(frame)) frames_.push_back(std::move(*values));
    }
    if (frames_.empty()) throw FileError("the result holds no frame with a finite displacement");
  }

  /// Reads a frame; nothing if the displacement is not finite.
  std::optional<Values> read(const ResultFrame& frame) {
    Values values;
    values.frame = {frame.time, frame.step, scene_of(frame.mesh), {}, frame.label};
    const Scene& scene = scenes_[values.frame.mesh];
    const auto fields = result_.fields(frame);
    for (const auto& channel : channels_) {
      const auto found = std::ranges::find(fields, channel.source.name, &ResultField::name);
      auto& components = values.of_channels.emplace_back();
      components.resize(static_cast<std::size_t>(channel.components));
      if (found == fields.end() || found->components != channel.source.components) {
        for (auto& one : components) one.assign(scene.surface.num_vertices(), std::numeric_limits<float>::quiet_NaN());
        continue;
      }
      read(frame, channel, scene, components);
      if (channel.name == "displacement" && !take_shift(components, values.frame.shift)) return std::nullopt;
    }
    values.companions = scene.companions.read(result_, frame);
    return values;
  }

  void read(const ResultFrame& frame, const Channel& channel, const Scene& scene,
            std::vector<std::vector<float>>& components) const {
    const BodySurface& surface = scene.surface;
    const auto source = result_.values(frame, channel.source);
    const auto width = static_cast<std::size_t>(channel.source.components);
    const std::size_t rows = channel.source.location == FieldLocation::cell ? scene.num_cells : scene.num_nodes;
    if (source.size() != rows * width) {
      throw FileError("the field '" + channel.source.name + "' of frame '" + frame.name + "' is damaged");
    }
    const std::size_t reduced_width = components.size();
    std::vector<double> reduced(rows * reduced_width);
    for (std::size_t i = 0; i < rows; ++i) channel.reduce(&source[width * i], &reduced[reduced_width * i]);
    auto at = at_vertices(surface, reduced, channel.source.location, channel.components);
    // Nodes that they share with deformable bodies have the values of these.
    const auto in_rigid = value_in_rigid_bodies(channel.source.name);
    for (std::size_t v = 0; v < surface.num_vertices() && in_rigid; ++v) {
      if (scene.is_rigid[static_cast<std::size_t>(surface.bodies[v])] == 0) continue;
      std::fill_n(at.begin() + static_cast<std::ptrdiff_t>(reduced_width * v), reduced_width, *in_rigid);
    }
    for (std::size_t c = 0; c < reduced_width; ++c) {
      for (std::size_t v = 0; v < surface.num_vertices(); ++v) {
        components[c].push_back(static_cast<float>(at[reduced_width * v + c]));
      }
    }
  }

  /// Subtracts the mean, so that far flights leave the digits to the deformation. False if it is not finite.
  static bool take_shift(std::vector<std::vector<float>>& components, std::array<double, 3>& shift) {
    for (std::size_t i = 0; i < 3; ++i) {
      double sum = 0.0;
      for (const float u : components[i]) sum += u;
      if (!std::isfinite(sum)) return false;
      shift[i] = components[i].empty() ? 0.0 : sum / static_cast<double>(components[i].size());
      for (float& u : components[i]) u = static_cast<float>(u - shift[i]);
    }
    return true;
  }

  /// Low and high of a component over all frames, without the share `cut` of the values at either end.
  std::pair<double, double> range_of(std::size_t channel, std::size_t component, double cut) const {
    std::vector<float> values;
    for (const auto& frame : frames_) {
      std::ranges::copy_if(frame.of_channels[channel][component], std::back_inserter(values),
                           [](float value) { return std::isfinite(value); });
    }
    if (values.empty()) return {0.0, 0.0};
    const auto low = static_cast<std::ptrdiff_t>(cut * static_cast<double>(values.size()));
    std::ranges::nth_element(values, values.begin() + low);
    const double lowest = values[static_cast<std::size_t>(low)];
    std::ranges::nth_element(values, values.end() - 1 - low);
    return {lowest, *(values.end() - 1 - low)};
  }

  /// Components of a vector have the same step, because they share a scale of colours, unless that would leave one of
  /// them hardly any levels. There are enough levels for the coloured range, whatever the peaks.
  std::vector<Quantisation> scales_of(std::size_t channel) const {
    const bool is_displacement = channels_[channel].name == "displacement";
    const auto size = static_cast<std::size_t>(channels_[channel].components);
    std::vector<double> widths;
    for (std::size_t c = 0; c < size; ++c) {
      const auto [low, high] = range_of(channel, c, is_displacement ? 0.0 : unseen);
      widths.push_back(high - low);
    }
    const double step =
        *std::ranges::max_element(widths) / (is_displacement ? levels_of_displacement : levels_of_fields);
    std::vector<Quantisation> scales;
    for (std::size_t c = 0; c < size; ++c) {
      const auto [low, high] = range_of(channel, c, 0.0);
      const double levels = std::ceil((high - low) / std::min(step, widths[c] / least_levels));
      scales.push_back({low, high, levels < most_levels ? std::max(static_cast<int>(levels), 1) : most_levels});
    }
    return scales;
  }

  /// Bodies on which a field is exactly 0 in all frames. What a body always has, its motion, may be 0 all the time.
  std::vector<int> bodies_without(std::size_t channel) const {
    constexpr std::array<std::string_view, 3> of_all{"displacement", "velocity", "acceleration"};
    if (std::ranges::find(of_all, channels_[channel].name) != of_all.end()) return {};
    std::set<int> drawn, with;
    for (const auto& frame : frames_) {
      const std::vector<std::int32_t>& bodies = scenes_[frame.frame.mesh].surface.bodies;
      drawn.insert(bodies.begin(), bodies.end());
      for (const auto& values : frame.of_channels[channel]) {
        for (std::size_t v = 0; v < values.size(); ++v) {
          if (values[v] != 0.0F) with.insert(bodies[v]);
        }
      }
    }
    std::vector<int> without;
    std::ranges::set_difference(drawn, with, std::back_inserter(without));
    return without;
  }

  void encode(const std::vector<std::size_t>& kept) {
    packed_.meshes.clear();
    packed_.frames.clear();
    packed_.fields.clear();
    packed_.obstacles.clear();
    packed_.mechanisms.clear();
    for (std::size_t m = 0; m < scenes_.size(); ++m) {
      packed_.meshes.push_back(scenes_[m].packed);
      std::vector<const Companions::Frame*> frames;
      for (const std::size_t i : kept) {
        if (frames_[i].frame.mesh == m) frames.push_back(&frames_[i].companions);
      }
      packed_.obstacles.push_back(scenes_[m].companions.obstacles(frames));
      packed_.mechanisms.push_back(scenes_[m].companions.mechanisms(frames));
    }
    for (const std::size_t i : kept) packed_.frames.push_back(frames_[i].frame);
    for (std::size_t k = 0; k < channels_.size(); ++k) {
      PackedField field{channels_[k].name, channels_[k].source.unit, scales_of(k), {}, bodies_without(k)};
      for (std::size_t m = 0; m < scenes_.size(); ++m) {
        auto& texts = field.values.emplace_back();
        for (std::size_t c = 0; c < field.scales.size(); ++c) {
          PackedRows rows(scenes_[m].neighbours);
          for (const std::size_t i : kept) {
            if (frames_[i].frame.mesh != m) continue;
            rows.append(quantised(field.scales[c], frames_[i].of_channels[k][c]));
          }
          texts.push_back(rows.text());
        }
      }
      packed_.fields.push_back(std::move(field));
    }
  }

  const ResultReader& result_;
  std::size_t most_bytes_;
  std::vector<Channel> channels_;
  std::vector<Scene> scenes_;
  std::vector<Values> frames_;
  PackedResult packed_;
};

}  // namespace

std::size_t PackedResult::size() const {
  std::size_t bytes = frames.size() * size_of_frame;
  const auto add = [&](const std::string& text) { bytes += text.size() + around_text; };
  std::ranges::for_each(body_names, add);
  for (const auto& mesh : meshes) {
    add(mesh.triangles);
    add(mesh.bodies);
    std::ranges::for_each(mesh.positions, add);
  }
  for (const auto& one : obstacles) for_each_text(one, add);
  for (const auto& one : mechanisms) for_each_text(one, add);
  for (const auto& field : fields) {
    for (const auto& of_mesh : field.values) std::ranges::for_each(of_mesh, add);
  }
  return bytes;
}

PackedResult pack_result(const ResultReader& result, std::size_t most_bytes) {
  return Packer(result, most_bytes)();
}

}  // namespace pliant
