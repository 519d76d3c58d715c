#include "input/sections/time.hpp"

#include "input/analysis.hpp"
#include "input/formats.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <variant>

namespace pliant {
namespace {

constexpr std::array<const char*, 3> petsc_integrators{"alpha2", "bdf", "arkimex"};

/// Every choice of `method` that is typed as a name.
std::vector<MethodConfig> named_methods() {
  std::vector<MethodConfig> all;
  for (const Method& method : methods()) all.push_back({method, {}});
  all.push_back({MethodConfig::Quasistatic{}, {}});
  all.push_back({MethodConfig::Static{}, {}});
  for (const char* integrator : petsc_integrators) all.push_back({MethodConfig::PetscIntegrator{integrator}, {}});
  return all;
}

/// The keys of a method that is given by keys instead of a name.
struct MethodKeys {
  std::string petsc;
  std::string name;
  std::vector<double> alpha;
  double beta = 0.0;
  std::vector<std::vector<double>> A;
  std::vector<double> b;
};

bool is_petsc(const MethodKeys& keys) {
  return !keys.petsc.empty();
}

Section<MethodKeys> method_keys() {
  const auto numbers = list_of(coefficient(), 1);
  return {
      {
          field("petsc", &MethodKeys::petsc, choice({petsc_integrators.begin(), petsc_integrators.end()}),
                "an integrator of PETSc, as a second opinion")
              .left_out_if([](const MethodKeys& keys) { return !is_petsc(keys); }),
          field("A", &MethodKeys::A, list_of(numbers, 1),
                "your own method: rows of the lower triangular matrix of its stages, each with its zeros")
              .left_out_if(is_petsc),
          field("b", &MethodKeys::b, numbers, "weights of the stages").left_out_if(is_petsc),
          field("alpha", &MethodKeys::alpha, numbers, "weights of the past states, the latest first")
              .otherwise("[1]")
              .left_out_if(is_petsc),
          field("beta", &MethodKeys::beta, coefficient(), "weight of the step").otherwise("1").left_out_if(is_petsc),
          field("name", &MethodKeys::name, column_name(), "name of your method").otherwise("own").left_out_if(is_petsc),
      },
      {{{"petsc", "A"}},
       {{"b"}, KeyGroup::Need::all, {{"A"}}},
       {{"alpha", "beta", "name"}, KeyGroup::Need::any, {{"A"}}}}};
}

/// Derives the method that the keys describe; its name must not be one that means another.
bool derive(MethodKeys keys, const InputNode& node, Diagnostics& diagnostics, MethodConfig& into) {
  const auto taken = time_methods();
  if (std::find(taken.begin(), taken.end(), keys.name) != taken.end()) {
    diagnostics.add(node.find("name")->where, "'" + keys.name + "' is a method of Pliant; give yours another name");
    return false;
  }
  auto derived =
      derive_method({std::move(keys.name), std::move(keys.alpha), keys.beta, std::move(keys.A), std::move(keys.b), {}});
  if (const auto* refusal = std::get_if<MethodRefusal>(&derived)) {
    diagnostics.add(node.where, refusal->reason);
    return false;
  }
  into.kind = std::get<Method>(std::move(derived));
  return true;
}

Format<MethodConfig> method_choice() {
  const auto by_name = choice(time_methods(), " (for motion: 'bdf2'; without inertia: 'static', 'quasistatic')");
  const auto by_keys = map_of(method_keys());
  Format<MethodConfig> format{by_name.type + ", or with the keys below",
                              either_schema(by_name.schema, by_keys.schema),
                              {},
                              {},
                              by_keys.children,
                              by_keys.groups};
  format.read = [by_name, by_keys](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                   MethodConfig& into) {
    into.where = node.where;
    if (node.kind != InputNode::Kind::map) {
      std::string chosen;
      if (!by_name.read(node, name, diagnostics, chosen)) return false;
      const auto all = named_methods();
      into.kind = std::ranges::find(all, chosen, method_name)->kind;
      return true;
    }
    const std::size_t before = diagnostics.num_errors();
    MethodKeys keys;
    by_keys.read(node, name, diagnostics, keys);
    if (diagnostics.num_errors() != before) return false;
    if (!is_petsc(keys)) return derive(std::move(keys), node, diagnostics, into);
    into.kind = MethodConfig::PetscIntegrator{keys.petsc};
    return true;
  };
  format.write = [by_name, by_keys](const MethodConfig& chosen) {
    if (const auto* petsc = std::get_if<MethodConfig::PetscIntegrator>(&chosen.kind)) {
      MethodKeys keys;
      keys.petsc = petsc->name;
      return by_keys.write(keys);
    }
    const auto* method = std::get_if<Method>(&chosen.kind);
    if (method == nullptr || find_method(method->name) != nullptr) return by_name.write(method_name(chosen));
    return by_keys.write({{}, method->name, method->alpha, method->beta, method->A, method->b});
  };
  return format;
}

Section<AdaptiveConfig> adaptive_keys() {
  return {{
              field("relative", &AdaptiveConfig::relative, quantity("1", Range{0, 1, Range::Ends::high_included}),
                    "allowed error of the whole run, as a fraction of displacement and velocity")
                  .otherwise("1e-4"),
              field("absolute", &AdaptiveConfig::absolute, quantity("m", Range::above(0)),
                    "allowed error of the displacement, in addition to `relative`")
                  .otherwise("1e-6"),
              field("absolute_velocity", &AdaptiveConfig::absolute_velocity, quantity("m/s", Range::above(0)),
                    "allowed error of the velocity, in addition to `relative`")
                  .otherwise_in_words("absolute / step"),
              field("min_step", &AdaptiveConfig::min_step, quantity("s", Range::above(0)),
                    "smallest step that is tried, for accuracy or when a solve fails")
                  .otherwise_in_words("step / 2^20"),
              field("max_step", &AdaptiveConfig::max_step, quantity("s", Range::above(0)), "largest step")
                  .otherwise_in_words("end / 10, or step if that is larger"),
          },
          {},
          &AdaptiveConfig::where};
}

Section<PathStopConfig> path_stop_keys() {
  return {
      {
          field("column", &PathStopConfig::column, text(), "a column of history.csv, such as `apex_uz`").required(),
          field("above", &PathStopConfig::above, coefficient(), "ends at the first step at or above this value, in SI"),
          field("below", &PathStopConfig::below, coefficient(), "ends at the first step at or below this value, in SI"),
      },
      {{{"above", "below"}, KeyGroup::Need::at_least_one}},
      &PathStopConfig::where};
}

Section<PathConfig> path_keys() {
  return {
      {
          field("by", &PathConfig::by, choice_of<PathConfig::By>({{"arc-length", PathConfig::By::arc_length}}),
                "what grows from step to step; `arc-length`: the length of the path in displacements and load "
                "(Riks), which takes the steps around limit points")
              .otherwise("arc-length"),
          field("max_load", &PathConfig::max_load, quantity("1", Range::above(0)),
                "load factor at which the path ends, and exactly there")
              .otherwise("1"),
          field("min_load", &PathConfig::min_load, quantity("1", Range{-infinity, 0, Range::Ends::excluded}),
                "negative load factor at which the path ends, and exactly there")
              .otherwise_in_words("none"),
          field("max_step", &PathConfig::max_step, quantity("1", Range::above(0)),
                "longest step along the path, whose length is measured as the load factor is while the response is "
                "linear")
              .otherwise_in_words("10 / load_steps"),
          field("max_steps", &PathConfig::max_steps, integer(Range::from_to(1, 1e6)), "most steps").otherwise("500"),
          field("stop", &PathConfig::stop, list_of(map_of(path_stop_keys()), 1),
                "further conditions, each on a number of the history; the path ends at the first step that meets "
                "one"),
      },
      {},
      &PathConfig::where};
}

}  // namespace

std::vector<std::string> time_methods() {
  std::vector<std::string> names;
  std::ranges::transform(named_methods(), std::back_inserter(names), method_name);
  return names;
}

Section<TimeConfig> time_keys() {
  return {{
      field("method", &TimeConfig::method, method_choice(),
            "time integrator (`pliant methods`); `quasistatic`: equilibria without inertia, step by step; `static`: "
            "one equilibrium")
          .otherwise("backward-euler"),
      field("step", &TimeConfig::step, quantity("s", Range::above(0)),
            "time step; with `adaptive` the first one that is tried; not used by `static`")
          .otherwise_in_words("with `adaptive`: end / 1000; else none, and needed unless `static`")
          .left_out_if([](const TimeConfig& t) { return t.step <= 0; }),
      field("end", &TimeConfig::end, quantity("s", Range::at_least(0)),
            "end of the simulation; for `static` the time at which formulas are evaluated")
          .otherwise_in_words("none; `static`: 0"),
      field(
          "load_steps", &TimeConfig::load_steps, integer(Range::from_to(1, 1e6)),
          "for `static`: loads and prescribed displacements grow to their values in this many equal parts; with `path` "
          "the first step adds one of them, by default one of 20")
          .otherwise("1"),
      field("path", &TimeConfig::path, map_of(path_keys()),
            "for `static`: follows the path of equilibria through limit points, where the load factor turns back "
            "(snap-through, ballooning); `{}` takes the defaults")
          .otherwise_in_words("none: the load factor grows"),
      field("startup", &TimeConfig::startup, choice_of<Startup>({{"ramp", Startup::ramp}, {"dirk33", Startup::dirk33}}),
            "how a method with several past states starts; `ramp`: with the methods of fewer states, which costs bdf3 "
            "one order; `dirk33`: with that method")
          .otherwise_in_words("ramp; with `adaptive`: dirk33 for methods with several past states"),
      field("adaptive", &TimeConfig::adaptive, map_of(adaptive_keys()),
            "steps follow from their estimated error; `{}` takes the defaults")
          .otherwise_in_words("none: all steps are equal"),
      field("events", &TimeConfig::events, list_of(quantity("s", Range::above(0)), 0),
            "times in ascending order at which loads or constraints change abruptly, in addition to the kinks and "
            "jumps of "
            "formulas of t, which are found automatically: steps end exactly there, and methods with past states "
            "restart; "
            "not used by `static`"),
      field("min_step", &TimeConfig::min_step, quantity("s", Range::above(0)),
            "smallest step that is tried when a solve fails; with `adaptive` it goes there")
          .otherwise_in_words("step / 1024")
          .left_out_if([](const TimeConfig& t) { return t.min_step <= 0 || t.adaptive; }),
  }};
}

}  // namespace pliant
