#include "command/model_items.hpp"

#include "energy/rigid/rigid_fit.hpp"
#include "energy/term.hpp"
#include "input/input.hpp"
#include "input/parse.hpp"
#include "mesh/tetrahedron.hpp"
#include "model/rigid_bodies.hpp"
#include "model/selections.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Worst elements that are shown.
constexpr std::size_t num_worst = 20;
/// Instants at which loads are tried, to show them when they are largest.
constexpr int num_instants = 21;
/// Arrows of a load are so far apart, relative to the size of the bodies.
constexpr double spacing_of_arrows = 1.0 / 30.0;

/// What an entry of a list says, but for where it is and its name.
std::string text_of(const InputNode& entry) {
  constexpr std::array<std::string_view, 8> told_elsewhere{"surface", "volume", "curve", "point",
                                                           "box",     "where",  "name",  "surfaces"};
  std::string text;
  for (const InputNode& child : entry.children) {
    if (std::ranges::find(told_elsewhere, child.key) != told_elsewhere.end()) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", child.key, flow_text(child));
  }
  return text;
}

bool is_same(const Location& a, const Location& b) {
  return a.file == b.file && a.line == b.line && a.column == b.column;
}

class Collector {
 public:
  Collector(const Mesh& mesh, const Config& config, const Model& model, Vec q)
      : mesh_(mesh),
        config_(config),
        completed_(with_rigid_bodies(config)),
        model_(model),
        layout_(model.layout()),
        as_meshed_(make_layout(mesh, static_cast<int>(config.element))),
        selections_(mesh, as_meshed_, names_of_added_bodies(completed_)),
        at_start_(q) {
    update_ghosts(q);
    const ConstGhostedView local(q);
    q_.assign(local.span().begin(), local.span().end());
    Diagnostics ignored;
    input_ = parse_yaml(dump(config), "run.yaml", ignored);
  }

  std::vector<ModelItem> take() {
    add_constraints();
    add_attached();
    add_loads();
    add_shells();
    add_cavities();
    add_contacts();
    add_probes();
    add_worst_cells();
    add_groups();
    return std::move(items_);
  }

 private:
  Vector3<double> place(PetscInt node) const {
    const auto X = layout_.position(node);
    const auto k = 3 * static_cast<std::size_t>(node);
    return {X[0] + q_[k], X[1] + q_[k + 1], X[2] + q_[k + 2]};
  }
  /// The places of owned nodes, of all ranks.
  std::vector<double> places(const std::vector<PetscInt>& nodes) const {
    std::vector<double> mine;
    for (const PetscInt node : nodes) {
      const Vector3<double> x = place(node);
      mine.insert(mine.end(), {x[0], x[1], x[2]});
    }
    return gathered(layout_.comm, mine);
  }
  ModelItem& add(ModelItem::Kind kind, std::string name, std::string text) {
    return items_.emplace_back(ModelItem{kind, std::move(name), std::move(text), {}, {}});
  }
  /// What the k-th entry of a section says.
  std::string said(std::string_view section, std::size_t k) const {
    const InputNode* list = given(input_, {section});
    return list != nullptr && k < list->children.size() ? text_of(list->children[k]) : "";
  }
  static std::string named(const std::string& name, const std::string& part) {
    return name.empty() ? part : fmt::format("{} ({})", name, part);
  }

  void add_constraints() {
    for (std::size_t k = 0; k < config_.constraints.size(); ++k) {
      const ConstraintConfig& constraint = config_.constraints[k];
      std::vector<Selection> parts;
      if (const auto* equation = std::get_if<ConstraintConfig::Equation>(&constraint.kind)) {
        for (const EquationTermConfig& term : equation->terms) parts.push_back(term.part);
      } else {
        parts.push_back(constraint.part);
      }
      if (const auto* periodic = std::get_if<ConstraintConfig::Periodic>(&constraint.kind)) {
        parts.push_back(periodic->partner);
      }
      if (const auto* tied = std::get_if<ConstraintConfig::Tied>(&constraint.kind)) parts.push_back(tied->partner);
      std::string names;
      std::vector<PetscInt> nodes;
      for (const Selection& part : parts) {
        names += (names.empty() ? "" : ", ") + describe(part);
        std::ranges::copy(selections_.nodes(part), std::back_inserter(nodes));
      }
      ModelItem& item = add(ModelItem::Kind::constraint, named(constraint.name, names), said("constraints", k));
      item.points = places(nodes);
      const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&constraint.kind);
      if (rigid == nullptr || rigid->center) continue;
      item.text +=
          fmt::format("; center at {} m", place_text(model_.constraints().parts()[k].displacement.rigid->centre));
    }
  }

  void add_attached() {
    const auto add_surfaces = [&](const std::string& body, const std::vector<Located<std::string>>& names, auto how) {
      for (const Located<std::string>& name : names) {
        Selection part;
        part.kind = Selection::Kind::surface;
        part.name = name.value;
        part.where = name.where;
        add(ModelItem::Kind::constraint, named(body, describe(part)), how).points = places(selections_.nodes(part));
      }
    };
    const auto add_bodies = [&](const auto& bodies, const auto& name_of) {
      for (const auto& body : bodies) {
        add_surfaces(name_of(body), body.attached, "attached");
        add_surfaces(name_of(body), body.coupled, "coupled in the mean");
      }
    };
    add_bodies(config_.bodies, [](const BodyConfig& body) { return body.part.name; });
    add_bodies(config_.rigid_bodies, [](const RigidBodyConfig& body) { return body.name; });
  }

  /// Forces of a load on the local nodes [N].
  std::vector<double> forces(const LoadConfig& load, const Instant& at) const {
    std::vector<double> sum(q_.size(), 0.0);
    const std::vector<double> rest(q_.size(), 0.0);
    LocalStage stage;
    stage.time = at.time;
    stage.dt = config_.time.step;
    stage.load_factor = at.load_factor;
    stage.q0 = q_;
    stage.v0 = rest;
    for (const LocatedTerm& term : model_.loads().terms()) {
      if (is_same(term.where, load.where)) term.term->add_gradient(stage, q_, sum);
    }
    for (double& f : sum) f = -f;
    return sum;
  }
  double total(const std::vector<double>& forces) const {
    double sum_of_sizes = 0.0;
    for (std::size_t k = 0; k < 3 * static_cast<std::size_t>(layout_.num_owned_nodes); ++k) {
      sum_of_sizes += std::abs(forces[k]);
    }
    return sum(layout_.comm, sum_of_sizes);
  }

  void add_loads() {
    for (std::size_t k = 0; k < config_.loads.size(); ++k) {
      const LoadConfig& load = config_.loads[k];
      const bool acts_on_volumes = std::holds_alternative<LoadConfig::Gravity>(load.kind) ||
                                   std::holds_alternative<LoadConfig::ForceDensity>(load.kind);
      const std::vector<PetscInt> nodes = selections_.nodes(load.part);
      ModelItem& item = add(ModelItem::Kind::load, describe(load.part), said("loads", k));
      double largest = 0.0, when = 0.0;
      for (int i = 0; i < num_instants; ++i) {
        const double time = config_.time.end * i / (num_instants - 1);
        const double size = total(forces(load, model_.instant(time, 1.0)));
        if (!(size > largest)) continue;
        largest = size;
        when = time;
      }
      if (!(largest > 0.0) || !std::isfinite(largest)) {
        item.points = places(nodes);
        continue;
      }
      const auto center = point_of_force(load, nodes);
      const auto at_largest = forces(load, model_.instant(when, 1.0));
      if (acts_on_volumes) {
        const bool acts_on_all = load.part.kind == Selection::Kind::everything;  // bodies without a mesh, too
        set_arrows(item, acts_on_all ? owned_nodes() : nodes, at_largest, bodies_of_nodes());
      } else {
        set_arrows(item, nodes, at_largest, center ? places_of_one() : places_near_each_other());
      }
      if (center) item.points.assign(center->begin(), center->end());
      if (when > 0.0) item.text += fmt::format("; arrows: at {:.4g} s, when it is largest", when);
    }
  }

  /// Where a force on a rigid body acts, at its center of mass; nothing of other loads. Collective.
  std::optional<Vector3<double>> point_of_force(const LoadConfig& load, const std::vector<PetscInt>& nodes) const {
    if (!std::holds_alternative<LoadConfig::Force>(load.kind) || load.part.kind != Selection::Kind::volume) {
      return std::nullopt;
    }
    const auto body = std::ranges::find(model_.body_names(), load.part.name) - model_.body_names().begin();
    const Vector3<double> center =
        mass_of_rigid_body(completed_, layout_, model_.body_of_cell(), model_.shells(), static_cast<int>(body)).center;
    return center + nearest_placement(layout_, nodes, center, at_start_).translation;
  }

  std::vector<PetscInt> owned_nodes() const {
    std::vector<PetscInt> nodes(static_cast<std::size_t>(layout_.num_owned_nodes));
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
  }

  /// What forces at nodes have one arrow for: those with the same key.
  using ArrowKey = std::array<double, 3>;
  using ArrowOfNode = std::function<ArrowKey(PetscInt node)>;

  static ArrowOfNode places_of_one() {
    return [](PetscInt) { return ArrowKey{}; };
  }
  ArrowOfNode places_near_each_other() const {
    const auto& b = model_.mesh_report().bounds;
    const double cell = spacing_of_arrows * std::hypot(b[3] - b[0], b[4] - b[1], b[5] - b[2]);
    return [this, cell](PetscInt node) {
      const Vector3<double> x = place(node);
      ArrowKey key{};
      for (std::size_t i = 0; i < 3 && cell > 0.0; ++i) key[i] = std::round(x[i] / cell);
      return key;
    };
  }
  ArrowOfNode bodies_of_nodes() const {
    std::vector<int> body_of(static_cast<std::size_t>(layout_.num_local_nodes), -1);
    for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
      for (const PetscInt node : layout_.nodes_of_cell(c)) {
        body_of[static_cast<std::size_t>(node)] = model_.body_of_cell()[static_cast<std::size_t>(c)];
      }
    }
    return [body_of = std::move(body_of)](PetscInt node) {
      return ArrowKey{static_cast<double>(body_of[static_cast<std::size_t>(node)])};
    };
  }

  /// Resultants of the forces with the same key, at the middles of their nodes, weighted by the forces' sizes.
  void set_arrows(ModelItem& item, const std::vector<PetscInt>& nodes, const std::vector<double>& forces,
                  const ArrowOfNode& key_of) const {
    struct Force {
      ArrowKey key;
      Vector3<double> place, force;
    };
    std::vector<Force> mine;
    for (const PetscInt node : nodes) {
      const double* const f = forces.data() + 3 * node;
      mine.push_back({key_of(node), place(node), {f[0], f[1], f[2]}});
    }
    struct Sum {
      Vector3<double> place{}, force{};
      double size = 0.0;
    };
    std::map<ArrowKey, Sum> sums;
    for (const auto& [key, x, force] : gathered(layout_.comm, mine)) {
      const double size = norm(force);
      Sum& sum = sums[key];
      sum.place = sum.place + size * x;
      sum.force = sum.force + force;
      sum.size += size;
    }
    for (const auto& [key, sum] : sums) {
      if (!(sum.size > 0.0)) continue;
      const Vector3<double> middle = (1.0 / sum.size) * sum.place;
      item.points.insert(item.points.end(), middle.begin(), middle.end());
      item.vectors.insert(item.vectors.end(), sum.force.begin(), sum.force.end());
    }
  }

  void add_shells() {
    for (std::size_t k = 0; k < config_.shells.size(); ++k) {
      const ShellConfig& shell = config_.shells[k];
      add(ModelItem::Kind::shell, named(shell.name, describe(shell.part)), said("shells", k)).points =
          places(selections_.nodes(shell.part));
    }
  }

  void add_cavities() {
    for (std::size_t k = 0; k < config_.cavities.size(); ++k) {
      const ModelCavity& cavity = model_.cavities()[k];
      add(ModelItem::Kind::cavity, cavity.name,
          fmt::format("volume {:.6g} m^3; {}", cavity.volume, said("cavities", k)))
          .points = places(selections_.nodes(config_.cavities[k].part));
    }
  }

  void add_contacts() {
    if (model_.contacts() == nullptr) return;
    const ContactSummary summary = model_.contacts()->summary(model_.instant_of_start(), q_);
    const auto add_rows = [this](const std::vector<ContactRow>& rows, bool are_obstacles) {
      for (const ContactRow& row : rows) {
        const std::string other = are_obstacles        ? "the obstacle " + row.name
                                  : row.second.empty() ? "itself"
                                                       : row.second;
        const std::string gap = std::isfinite(row.start.gap)
                                    ? fmt::format("gap {:.3g} m at {}", row.start.gap, place_text(row.start.place))
                                    : "nothing is near";
        ModelItem& item =
            add(ModelItem::Kind::contact, fmt::format("{} with {}", row.first, other),
                fmt::format("{}; {}, stiffness {:.3g} Pa/m, width {:.3g} m{}", gap,
                            row.law.kind == NormalKind::barrier ? "barrier" : "penalty", row.law.stiffness,
                            row.law.width, row.friction > 0.0 ? fmt::format(", friction {:g}", row.friction) : ""));
        if (std::isfinite(row.start.gap)) item.points.assign(row.start.place.begin(), row.start.place.end());
      }
    };
    add_rows(summary.pairs, false);
    add_rows(summary.obstacles, true);
  }

  void add_probes() {
    for (std::size_t k = 0; k < config_.probes.size(); ++k) {
      const ProbeConfig& probe = config_.probes[k];
      std::array<double, 3> x = model_.probes()[k].interpolate(q_);
      check_mpi(MPI_Allreduce(MPI_IN_PLACE, x.data(), 3, MPI_DOUBLE, MPI_SUM, layout_.comm));
      for (std::size_t i = 0; i < 3; ++i) x[i] += probe.point[i];
      add(ModelItem::Kind::probe, probe.name, fmt::format("at {} m", place_text({x[0], x[1], x[2]})))
          .points.assign(x.begin(), x.end());
    }
  }

  void add_worst_cells() {
    std::vector<std::array<double, 4>> mine;  // quality, place
    for (PetscInt c = 0; c < layout_.num_owned_cells; ++c) {
      const auto nodes = layout_.nodes_of_cell(c);
      tetrahedron::Corners corners{};
      Vector3<double> middle{};
      for (std::size_t a = 0; a < 4; ++a) {
        corners[a] = layout_.position(nodes[a]);
        middle = middle + 0.25 * place(nodes[a]);
      }
      mine.push_back({tetrahedron::mean_ratio(corners), middle[0], middle[1], middle[2]});
    }
    const auto keep_worst = [](std::vector<std::array<double, 4>>& cells) {
      std::ranges::sort(cells);
      if (cells.size() > num_worst) cells.resize(num_worst);
    };
    keep_worst(mine);
    std::vector<std::array<double, 4>> worst = gathered(layout_.comm, mine);
    keep_worst(worst);
    if (worst.empty()) return;
    ModelItem& item =
        add(ModelItem::Kind::cells, fmt::format("the worst {} elements", worst.size()),
            fmt::format("quality {:.3g} to {:.3g} (mean ratio: 1 regular, 0 flat)", worst.front()[0], worst.back()[0]));
    for (const auto& [quality, x, y, z] : worst) item.points.insert(item.points.end(), {x, y, z});
  }

  void add_groups() {
    constexpr std::array<const char*, 4> kinds{"point", "curve", "surface", "volume"};
    constexpr std::array selected{Selection::Kind::point, Selection::Kind::curve, Selection::Kind::surface,
                                  Selection::Kind::volume};
    for (const PhysicalGroup& group : mesh_.groups) {
      const auto dimension = static_cast<std::size_t>(group.dimension);
      const std::string name = group.name.empty() ? fmt::format("{}", group.tag) : group.name;
      const auto& added = names_of_added_bodies(completed_).names;
      if (std::ranges::find(added, name) != added.end()) continue;
      Selection part;
      part.kind = selected[dimension];
      part.name = name;
      std::vector<double> points = places(selections_.nodes(part));
      const auto count = points.size() / 3;
      add(ModelItem::Kind::group, name, fmt::format("{}, {} nodes", kinds[dimension], count)).points =
          std::move(points);
    }
  }

  const Mesh& mesh_;
  const Config& config_;
  Config completed_;
  const Model& model_;
  const NodeLayout& layout_;
  NodeLayout as_meshed_;
  Selections selections_;
  Vec at_start_;
  std::vector<double> q_;  // of the local nodes
  InputNode input_;        // as understood
  std::vector<ModelItem> items_;
};

}  // namespace

std::string to_string(ModelItem::Kind kind) {
  constexpr std::array names{"group", "constraint", "load", "shell", "cavity", "contact", "probe", "cells"};
  return names[static_cast<std::size_t>(kind)];
}

std::vector<ModelItem> model_items(const Mesh& mesh, const Config& config, const Model& model, Vec q) {
  return Collector(mesh, config, model, q).take();
}

}  // namespace pliant
