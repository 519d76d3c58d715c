#include "input/sections/shells.hpp"

#include "input/formats.hpp"
#include "input/sections/elasticity.hpp"

namespace pliant {

namespace {

Section<ClampedEdgeConfig> clamped_edge_keys() {
  using C = ClampedEdgeConfig;
  return {{
              selector<C>("curve", Selection::Kind::curve, "curve at the edge of the layer"),
              field("normal", &C::normal, direction_of_any_length(),
                    "normal of the plane of symmetry that the curve lies in, where it is one")
                  .otherwise_in_words("none; the edge is clamped"),
          },
          {{{"curve"}}},
          &C::where};
}

/// A law of viscosity that layers know, with its own keys alone.
struct LayerLawConfig {
  std::string model;
  std::optional<double> shear, bulk, time;  // [Pa s], [Pa s], [s]
  Location where;

  LayerLawConfig() = default;
  explicit LayerLawConfig(const ViscosityConfig& of) : model(name_of(of.law)), where(of.where) {
    if (const auto* newtonian = std::get_if<KelvinVoigt>(&of.law)) {
      shear = newtonian->shear;
      bulk = newtonian->bulk;
    } else if (const auto* proportional = std::get_if<StiffnessProportional>(&of.law)) {
      time = proportional->time;
    }
  }
  ViscosityConfig config() const {
    if (model == KelvinVoigt::name) return {KelvinVoigt{shear.value_or(0.0), bulk.value_or(0.0)}, {}, where};
    return {StiffnessProportional{time.value_or(0.0)}, {}, where};
  }
};

Section<LayerLawConfig> layer_law_keys() {
  using L = LayerLawConfig;
  using Need = KeyGroup::Need;
  const std::string newtonian(KelvinVoigt::name), proportional(StiffnessProportional::name);
  return {{
              field("model", &L::model, choice({newtonian, proportional}), "law of viscosity").required(),
              field("shear", &L::shear, quantity("Pa*s", Range::at_least(0)), "viscosity in shear"),
              field("bulk", &L::bulk, quantity("Pa*s", Range::at_least(0)), "viscosity against volume change")
                  .otherwise_in_words("0"),
              field("time", &L::time, quantity("s", Range::at_least(0)),
                    "resistance to rates of strain, as this time multiplied by the stiffness at rest: `damping`"),
          },
          {{{"shear"}, Need::all, {{"model", newtonian}}},
           {{"bulk"}, Need::any, {{"model", newtonian}}},
           {{"time"}, Need::all, {{"model", proportional}}}},
          &L::where};
}

Format<ViscosityConfig> layer_viscosity() {
  const Format<LayerLawConfig> own = map_of(layer_law_keys());
  Format<ViscosityConfig> format{own.type, own.schema, {}, {}, own.children, own.groups};
  format.read = [own](const InputNode& node, const std::string& key, Diagnostics& diagnostics, ViscosityConfig& into) {
    LayerLawConfig law;
    const bool is_read = own.read(node, key, diagnostics, law);
    into = law.config();
    return is_read;
  };
  format.write = [own](const ViscosityConfig& mechanism) { return own.write(LayerLawConfig(mechanism)); };
  return format;
}

}  // namespace

Section<ShellConfig> shell_keys() {
  using S = ShellConfig;
  using SelectionKind = Selection::Kind;
  return {
      {
          field("name", &S::name, column_name(), "name of the layer").required(),
          selector<S>("surface", SelectionKind::surface,
                      "surface of bodies, outer or between them, that has the layer"),
          selector<S>("box", SelectionKind::box, "instead of `surface`: boundary facets inside this box"),
          selector<S>("where", SelectionKind::where,
                      "instead of `surface`: boundary facets that satisfy this condition"),
          field("thickness", &S::thickness, quantity("m", Range::above(0)),
                "thickness of the layer, before it is stretched by `prestretch`")
              .required(),
          field("density", &S::density, quantity("kg/m^3", Range::at_least(0)), "mass density")
              .otherwise_in_words("that of the elasticity's `library`, else 0"),
          field("elasticity", &S::elasticity, elasticity_format(),
                "elastic law, with which the layer is in plane stress")
              .required(),
          field("prestretch", &S::prestretch, one_or_list_of(quantity("1", Range::above(0))),
                "by how much the layer is stretched in its plane where it is put on: in all directions, or [along, "
                "across] `direction`")
              .otherwise_in_words("1")
              .left_out_if([](const S& shell) { return shell.prestretch.empty(); }),
          field("direction", &S::direction, direction_of_any_length(), "direction of the first of two prestretches")
              .otherwise_in_words("none; two prestretches need one")
              .only_with({{"prestretch"}}),
          field("damping", &S::damping, quantity("s", Range::at_least(0)),
                "viscosity: resistance to rates of strain in the layer, and of bending if it bends, as this time "
                "multiplied by the stiffness at rest")
              .otherwise("0"),
          field("viscosity", &S::viscosity, one_or_list_of(layer_viscosity()),
                "law of viscosity of the layer, `kelvin-voigt` or `stiffness-proportional`; several act in parallel")
              .otherwise_in_words("none")
              .left_out_if([](const S& shell) { return shell.viscosity.empty(); }),
          field("bending", &S::bends, truth(), "whether the layer resists bending too, as a shell").otherwise("false"),
          field("clamped", &S::clamped, list_of(map_of(clamped_edge_keys()), 0),
                "curves at the edge of a layer that bends, across which it keeps its direction: clamped edges, and "
                "planes of symmetry")
              .left_out_if([](const S& shell) { return shell.clamped.empty(); }),
          field("free", &S::is_free, truth(),
                "whether the triangles of `surface` are a body of their own, and bound no tetrahedron")
              .otherwise("false"),
      },
      {{{"surface", "box", "where"}}},
      &S::where};
}

}  // namespace pliant
