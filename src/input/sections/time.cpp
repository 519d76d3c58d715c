#include "input/sections/time.hpp"

#include <algorithm>
#include <array>
#include <variant>

namespace pliant {
namespace {

constexpr std::array<const char*, 3> petsc_integrators{"alpha2", "bdf", "arkimex"};

/// What is typed under `method`.
struct MethodChoice {
  std::string name;
  std::optional<Method> own;
};

/// The keys of a method that is not typed as a name.
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
          field("name", &MethodKeys::name, column_name(), "what your method is called")
              .otherwise("own")
              .left_out_if(is_petsc),
      },
      {{{"petsc", "A"}},
       {{"b"}, KeyGroup::Need::all, {{"A"}}},
       {{"alpha", "beta", "name"}, KeyGroup::Need::any, {{"A"}}}}};
}

/// Derives the method that the keys describe; its name must not be one that means another.
bool derive(MethodKeys keys, const InputNode& node, Diagnostics& diagnostics, MethodChoice& into) {
  const auto taken = time_methods();
  if (std::find(taken.begin(), taken.end(), keys.name) != taken.end()) {
    diagnostics.add(node.find("name")->where,
                    "'" + keys.name + "' is a method of Pliant; call your own by another name");
    return false;
  }
  auto derived =
      derive_method({std::move(keys.name), std::move(keys.alpha), keys.beta, std::move(keys.A), std::move(keys.b), {}});
  if (const auto* refusal = std::get_if<MethodRefusal>(&derived)) {
    diagnostics.add(node.where, refusal->reason);
    return false;
  }
  into.own = std::get<Method>(std::move(derived));
  into.name = into.own->name;
  return true;
}

Format<MethodChoice> method_choice() {
  const auto by_name = choice(time_methods());
  const auto by_keys = map_of(method_keys());
  Format<MethodChoice> format{by_name.type + ", or with the keys below",
                              either_schema(by_name.schema, by_keys.schema),
                              {},
                              {},
                              by_keys.children,
                              by_keys.groups};
  format.read = [by_name, by_keys](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                   MethodChoice& into) {
    if (node.kind != InputNode::Kind::map) return by_name.read(node, name, diagnostics, into.name);
    const std::size_t before = diagnostics.num_errors();
    MethodKeys keys;
    by_keys.read(node, name, diagnostics, keys);
    if (diagnostics.num_errors() != before) return false;
    if (!is_petsc(keys)) return derive(std::move(keys), node, diagnostics, into);
    into.name = petsc_prefix;
    into.name += keys.petsc;
    return true;
  };
  format.write = [by_name, by_keys](const MethodChoice& method) {
    if (method.own) {
      const Method& m = *method.own;
      return by_keys.write({{}, m.name, m.alpha, m.beta, m.A, m.b});
    }
    if (!method.name.starts_with(petsc_prefix)) return by_name.write(method.name);
    MethodKeys keys;
    keys.petsc = method.name.substr(petsc_prefix.size());
    return by_keys.write(keys);
  };
  return format;
}

/// The method goes into two members.
Field<TimeConfig> method_field() {
  struct Holder {
    Located<MethodChoice> method;
  };
  const auto typed = field("method", &Holder::method, method_choice(),
                           "time integrator (`pliant methods`); `quasistatic`: equilibria without inertia, step by "
                           "step; `static`: one equilibrium");
  Field<TimeConfig> result{typed.info};
  result.read = [read = typed.read](const InputNode& node, Diagnostics& diagnostics, TimeConfig& into) {
    Holder holder;
    read(node, diagnostics, holder);
    into.method = {holder.method.value.name, holder.method.where};
    into.own_method = std::move(holder.method.value.own);
  };
  result.write = [write = typed.write](const TimeConfig& from) {
    return write({{{from.method.value, from.own_method}, from.method.where}});
  };
  return std::move(result).otherwise("backward-euler");
}

Section<AdaptiveConfig> adaptive_keys() {
  return {{
              field("relative", &AdaptiveConfig::relative, quantity("1", Range{0, 1, Range::Ends::high_included}),
                    "error of the whole run that is allowed, as a part of displacement and velocity")
                  .otherwise("1e-4"),
              field("absolute", &AdaptiveConfig::absolute, quantity("m", Range::above(0)),
                    "error of the displacement that is allowed beside it")
                  .otherwise("1e-6"),
              field("absolute_velocity", &AdaptiveConfig::absolute_velocity, quantity("m/s", Range::above(0)),
                    "error of the velocity that is allowed beside it")
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

}  // namespace

std::vector<std::string> time_methods() {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.push_back(method.name);
  names.emplace_back(quasistatic_method);
  names.emplace_back(static_method);
  for (const char* integrator : petsc_integrators) names.push_back(std::string(petsc_prefix) + integrator);
  return names;
}

Section<TimeConfig> time_keys() {
  return {{
      method_field(),
      field("step", &TimeConfig::step, quantity("s", Range::above(0)),
            "time step; with `adaptive` the first one that is tried; not used by `static`")
          .otherwise_in_words("with `adaptive`: end / 1000; else none, and needed unless `static`")
          .left_out_if([](const TimeConfig& t) { return t.step <= 0; }),
      field("end", &TimeConfig::end, quantity("s", Range::at_least(0)),
            "end of the simulation; for `static` the time at which formulas are evaluated")
          .otherwise_in_words("none; `static`: 0"),
      field("load_steps", &TimeConfig::load_steps, integer(Range::from_to(1, 1e6)),
            "for `static`: loads and prescribed displacements grow to their values in this many equal parts")
          .otherwise("1"),
      field("startup", &TimeConfig::startup, choice({"ramp", "dirk33"}),
            "how a method with several past states starts; `ramp`: with the methods of fewer states, which costs bdf3 "
            "one order; `dirk33`: with that method")
          .otherwise_in_words("ramp; with `adaptive`: dirk33 for methods with several past states"),
      field("adaptive", &TimeConfig::adaptive, map_of(adaptive_keys()),
            "steps follow from the error they make; `{}` takes the defaults")
          .otherwise_in_words("none: all steps are equal"),
      field(
          "events", &TimeConfig::events, list_of(quantity("s", Range::above(0)), 0),
          "times in ascending order at which loads or constraints change abruptly, besides the kinks and jumps of "
          "formulas of t, which are found: steps end exactly there, and methods with past states start anew; not used "
          "by `static`"),
      field("min_step", &TimeConfig::min_step, quantity("s", Range::above(0)),
            "smallest step that is tried when a solve fails; with `adaptive` it goes there")
          .otherwise_in_words("step / 1024")
          .left_out_if([](const TimeConfig& t) { return t.min_step <= 0 || t.adaptive; }),
  }};
}

}  // namespace pliant
