#include "material/registry.hpp"

#include "base/limits.hpp"
#include "material/constants.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr ParameterInfo shear_modulus{"shear_modulus",      "Pa", 0.0, infinity, "stiffness in shear at small strain",
                                      LowerBound::excluded, 400e3};
constexpr ParameterInfo lame_lambda{
    "lame_lambda", "Pa", -infinity, infinity, "first Lame parameter at small strain", LowerBound::excluded, 1.6e6};
constexpr ParameterInfo bulk_modulus_at_rest{"bulk_modulus",
                                             "Pa",
                                             0.0,
                                             infinity,
                                             "stiffness against volume change at small strain",
                                             LowerBound::excluded,
                                             2e6,
                                             std::nullopt,
                                             UpperBound::included};

constexpr ParameterInfo coefficient(std::string_view name, std::string_view meaning, double typical,
                                    double lower = -infinity, std::optional<double> fallback = {}) {
  return {name, "Pa", lower, infinity, meaning, LowerBound::included, typical, fallback};
}
/// A coefficient of a higher term, which may be left out.
constexpr ParameterInfo higher(std::string_view name, std::string_view meaning, double typical) {
  return coefficient(name, meaning, typical, -infinity, 0.0);
}

constexpr std::array lame_parameters{shear_modulus, lame_lambda};
constexpr std::array split_moduli{shear_modulus, bulk_modulus_at_rest};
constexpr std::array mooney_rivlin{
    coefficient("c10", "of I1b - 3; c10 + c01 is half the shear modulus at small strain", 150e3),
    coefficient("c01", "of I2b - 3", 50e3), bulk_modulus_at_rest};
constexpr std::array mooney_rivlin_5{
    coefficient("c10", "of I1b - 3; c10 + c01 is half the shear modulus at small strain", 150e3),
    coefficient("c01", "of I2b - 3", 50e3),
    higher("c20", "of (I1b - 3)^2", 20e3),
    higher("c11", "of (I1b - 3) (I2b - 3)", 5e3),
    higher("c02", "of (I2b - 3)^2", 3e3),
    bulk_modulus_at_rest};
constexpr std::array mooney_rivlin_coupled{
    coefficient("c1", "of I1 - 3; c1 + c2 is half the shear modulus at small strain", 150e3),
    coefficient("c2", "of I2 - 3", 50e3),
    ParameterInfo{"lambda", "Pa", -infinity, infinity,
                  "of (ln J)^2/2; the first Lame parameter at small strain is lambda + 4 c2", LowerBound::excluded,
                  1.6e6}};
constexpr std::array yeoh{coefficient("c10", "of I1b - 3; half the shear modulus at small strain", 200e3),
                          higher("c20", "of (I1b - 3)^2", -10e3), higher("c30", "of (I1b - 3)^3", 5e3),
                          bulk_modulus_at_rest};
constexpr std::array gent{
    shear_modulus, bulk_modulus_at_rest,
    ParameterInfo{"stretch_limit", "1", 0.0, infinity, "upper limit of I1b - 3", LowerBound::excluded, 20.0}};
constexpr std::array arruda_boyce{shear_modulus, bulk_modulus_at_rest,
                                  ParameterInfo{"locking_stretch", "1", 1.0, infinity,
                                                "stretch at which the chains lock", LowerBound::excluded, 2.8}};

constexpr ParameterInfo ogden_modulus(std::string_view name, std::string_view meaning, double typical,
                                      std::optional<double> fallback = {}) {
  return {name, "Pa", -infinity, infinity, meaning, LowerBound::excluded, typical, fallback};
}
constexpr ParameterInfo ogden_exponent(std::string_view name, std::string_view meaning, double typical,
                                       std::string_view modulus = {}) {
  const auto fallback = modulus.empty() ? std::nullopt : std::optional(2.0);
  return {name,   "1", -infinity, infinity, meaning, LowerBound::excluded, typical, fallback, UpperBound::excluded,
          modulus};
}
constexpr std::array ogden{
    ogden_modulus("mu1", "contribution of the first term to the shear modulus at small strain", 220e3),
    ogden_exponent("alpha1", "exponent of the first term", 1.3),
    ogden_modulus("mu2", "of the second term", 100e3, 0.0),
    ogden_exponent("alpha2", "of the second term", 5.0, "mu2"),
    ogden_modulus("mu3", "of the third term", 60e3, 0.0),
    ogden_exponent("alpha3", "of the third term", -2.0, "mu3"),
    ogden_modulus("mu4", "of the fourth term", 20e3, 0.0),
    ogden_exponent("alpha4", "of the fourth term", -4.0, "mu4"),
    bulk_modulus_at_rest};
constexpr std::array shear_alone{shear_modulus};

/// It may be left out together with `stiffness`, if that is given.
constexpr ParameterInfo exponent(std::string_view name, std::string_view meaning, double typical,
                                 std::string_view stiffness = {}) {
  const auto fallback = stiffness.empty() ? std::nullopt : std::optional(1.0);
  return {name, "1", 0.0, infinity, meaning, LowerBound::excluded, typical, fallback, UpperBound::excluded, stiffness};
}

constexpr std::array guccione{
    coefficient("C", "scale of the stresses", 100e3, 0.0), exponent("bf", "stiffening along the fibres", 4.0),
    exponent("bt", "stiffening across the fibres", 1.0),
    exponent("bfs", "stiffening in shear between the fibres and the directions across them", 2.0),
    bulk_modulus_at_rest};
constexpr std::array holzapfel_gasser_ogden{
    shear_modulus, bulk_modulus_at_rest, coefficient("k1", "of the fibres", 300e3, 0.0),
    exponent("k2", "stiffening of the fibres", 0.8),
    ParameterInfo{"dispersion", "1", 0.0, 1.0 / 3.0,
                  "0 if the fibres of a family are parallel, 1/3 if they run in all directions", LowerBound::included,
                  0.1, 0.0}};
constexpr std::array holzapfel_ogden{coefficient("a", "shear modulus of the ground matrix at small strain", 200e3, 0.0),
                                     exponent("b", "stiffening of the ground matrix", 1.5),
                                     coefficient("a_f", "along the fibres", 400e3, 0.0),
                                     exponent("b_f", "stiffening along the fibres", 1.2),
                                     coefficient("a_s", "along the sheets", 100e3, 0.0, 0.0),
                                     exponent("b_s", "stiffening along the sheets", 0.9, "a_s"),
                                     coefficient("a_fs", "of shear between fibres and sheets", 50e3, 0.0, 0.0),
                                     exponent("b_fs", "stiffening in shear between fibres and sheets", 1.1, "a_fs"),
                                     bulk_modulus_at_rest};

constexpr std::array<LawInfo, ElasticLaws::size> own_laws{{
    {Linear<double>::name, "psi = mu eps:eps + lambda/2 (tr eps)^2, eps = (H + H^T)/2, H = grad u", lame_parameters,
     "Hooke's law; Holzapfel, Nonlinear Solid Mechanics (2000)",
     "small strains and small rotations; a rotation by theta causes spurious strains of theta^2/2, 1.5e-4 at a degree"},
    {SaintVenantKirchhoff<double>::name, "psi = mu E:E + lambda/2 (tr E)^2, E = (F^T F - I)/2", lame_parameters,
     "Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5",
     "large rotations with small strains (slender beams, shells); not for strong compression: it softens and lets "
     "cells invert"},
    {NeoHookean<double>::name, "psi = mu/2 (tr(F^T F) - 3) - mu ln J + lambda/2 (ln J)^2, J = det F", lame_parameters,
     "Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2008), section 6.4.3",
     "large rotations and large strains, the usual choice for soft bodies; never lets a cell invert"},
    {NeoHookeanIsochoric<double>::name, "psi = mu/2 (I1b - 3) + kappa U(J), I1b = J^(-2/3) tr(F^T F)", split_moduli,
     "Simo & Hughes, Computational Inelasticity (1998), section 9.2",
     "nearly incompressible soft bodies; comparison with other programs, most of which use this split"},
    {MooneyRivlin<double>::name, "psi = c10 (I1b - 3) + c01 (I2b - 3) + kappa U(J), I2b = J^(-4/3) I2(F^T F)",
     mooney_rivlin, "Mooney (1940); Rivlin (1948); Holzapfel (2000), section 6.5",
     "rubbers up to a stretch of about 2"},
    {MooneyRivlin5<double>::name,
     "psi = c10 i1 + c01 i2 + c20 i1^2 + c11 i1 i2 + c02 i2^2 + kappa U(J), i1 = I1b - 3, i2 = I2b - 3",
     mooney_rivlin_5, "Rivlin & Saunders (1951); Holzapfel (2000), section 6.5",
     "rubbers whose stress-stretch curve has an upturn; fit to more than one kind of test"},
    {MooneyRivlinCoupled<double>::name,
     "psi = c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + lambda/2 (ln J)^2, I1, I2: invariants of F^T F",
     mooney_rivlin_coupled, "Maas et al., FEBio Theory Manual, coupled Mooney-Rivlin; Ciarlet & Geymonat (1982)",
     "compressible rubbers and foams up to a stretch of about 2; comparison with programs that do not split off the "
     "volume"},
    {Yeoh<double>::name, "psi = c10 i1 + c20 i1^2 + c30 i1^3 + kappa U(J), i1 = I1b - 3", yeoh,
     "Yeoh, Rubber Chem. Technol. 66 (1993)",
     "filled rubbers at large strain, also when only tension has been measured; c20 is usually below 0"},
    {Gent<double>::name, "psi = -mu Jm/2 ln(1 - (I1b - 3)/Jm) + kappa U(J), Jm: stretch_limit", gent,
     "Gent, Rubber Chem. Technol. 69 (1996)", "rubbers and tissues that stiffen sharply towards a limit of stretch"},
    {ArrudaBoyce<double>::name,
     "psi = C_R sum_k a_k lm^(2-2k) (I1b^k - 3^k) + kappa U(J), a = 1/2, 1/20, 11/1050, 19/7000, 519/673750, "
     "lm: locking_stretch, C_R: so that shear_modulus is the one at rest",
     arruda_boyce, "Arruda & Boyce, J. Mech. Phys. Solids 41 (1993)",
     "rubbers up to large strain in any kind of loading, from two constants"},
    {Ogden<double>::name,
     "psi = sum_p 2 mu_p/alpha_p^2 (l1b^alpha_p + l2b^alpha_p + l3b^alpha_p - 3) + kappa U(J), l_ib = J^(-1/3) l_i: "
     "stretches; Ogden's own mu_p equals 2 mu_p/alpha_p in this notation",
     ogden, "Ogden (1972); Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5",
     "rubbers and tissues up to very large strain, fitted to several kinds of test"},
    {StableNeoHookean<double>::name,
     "psi = m/2 (I1 - 3) + l/2 (J - 1 - 3/4 m/l)^2 - m/2 ln(I1 + 1) - psi(I), I1 = tr(F^T F), m = 4/3 mu, "
     "l = lambda + 5/6 mu",
     lame_parameters, "Smith, de Goes & Kim, ACM Trans. Graph. 37 (2018)",
     "bodies whose cells may invert temporarily, after a poor start or under extreme loads: they recover"},
    {FixedCorotated<double>::name, "psi = mu |F - R|^2 + lambda/2 (J - 1)^2, R: rotation of F", lame_parameters,
     "Stomakhin et al., Energetically consistent invertible elasticity (2012)",
     "animation and extreme deformation: linear in the stretches, and inverted cells recover"},
    {Arap<double>::name, "psi = mu |F - R|^2, R: rotation of F", shear_alone,
     "Smith, de Goes & Kim, ACM Trans. Graph. 38 (2019)",
     "as rigid as possible: deformation of shapes; its Poisson's ratio at rest is 0, it has no bulk modulus of its "
     "own"},
    {Guccione<double>::name,
     "psi = C/2 (exp Q - 1) + kappa U(J), Q = bf Eff^2 + bt (Ess^2 + Enn^2 + 2 Esn^2) + 2 bfs (Efs^2 + Efn^2)",
     guccione, "Guccione, McCulloch & Waldman (1991); Land et al. (2015)",
     "passive heart muscle; the law of the cardiac benchmarks", one_fibre},
    {HolzapfelGasserOgden<double>::name,
     "psi = mu/2 (I1b - 3) + k1/(2 k2) sum_i (exp(k2 <Ei>^2) - 1) + kappa U(J), "
     "Ei = d (I1b - 3) + (1 - 3 d) (I4b_i - 1), d the dispersion",
     holzapfel_gasser_ogden, "Gasser, Ogden & Holzapfel (2006)",
     "walls of arteries and other tissue with two families of fibres, which do not push", two_fibres},
    {HolzapfelOgden<double>::name,
     "psi = a/(2 b) (exp(b (I1b - 3)) - 1) + sum_i a_i/(2 b_i) (exp(b_i <I4i - 1>^2) - 1) "
     "+ a_fs/(2 b_fs) (exp(b_fs I8fs^2) - 1) + kappa U(J), i = f, s",
     holzapfel_ogden, "Holzapfel & Ogden (2009)", "passive heart muscle with fibres and sheets, which do not push",
     fibre_and_sheet},
}};

/// The laws that come with Pliant, then those that a program has added.
std::vector<LawInfo>& rows() {
  static std::vector<LawInfo> all(own_laws.begin(), own_laws.end());
  return all;
}

std::size_t row_of(std::string_view name, const Location& where) {
  const auto found = std::ranges::find(rows(), name, &LawInfo::name);
  if (found == rows().end()) {
    throw InputError(where, fmt::format("unknown model '{}'; the models are {}", name, names_of(rows())));
  }
  return static_cast<std::size_t>(found - rows().begin());
}

}  // namespace

std::span<const LawInfo> elastic_laws() {
  return rows();
}

void add_row(const LawInfo& info) {
  rows().push_back(info);
}

LawTraits ElasticLawSpec::traits() const {
  return kind_of(row).traits;
}

namespace {

template <std::size_t... row>
ElasticLawVariant instantiate_one_of(std::index_sequence<row...>, const ElasticLawSpec& spec) {
  std::optional<ElasticLawVariant> law;
  const auto consider = [&](auto candidate) {
    using L = std::variant_alternative_t<candidate, ElasticLawVariant>;
    if (candidate == spec.row) law = L::of({spec.parameters, spec.volumetric, spec.directions});
  };
  (consider(std::integral_constant<std::size_t, row>{}), ...);
  return law.value();
}

}  // namespace

ElasticLawVariant instantiate(const ElasticLawSpec& spec) {
  return instantiate_one_of(std::make_index_sequence<ElasticLaws::size>{}, spec);
}

std::optional<Lame> ElasticLawSpec::at_rest() const {
  return kind_of(row).at_rest(*this);
}

ElasticLawSpec make_law(std::string_view name, const GivenConstants& constants, const Location& where) {
  const std::size_t row = row_of(name, where);
  std::vector<std::string> keys;
  std::vector<double> values;
  for (const auto& [key, value] : constants) {
    keys.push_back(key);
    values.push_back(value);
  }
  const ConstantsRule rule(row, keys, where);
  std::vector<Diagnostic> errors;
  for (const auto& text : rule.errors(values)) errors.push_back({Severity::error, where, text});
  if (!errors.empty()) throw InputError(std::move(errors));
  return {row, rule(values)};
}

ElasticLawSpec make_law(std::string_view name, double youngs_modulus, double poissons_ratio, const Location& where) {
  GivenConstants constants{{"youngs_modulus", youngs_modulus}, {"poissons_ratio", poissons_ratio}};
  for (const auto& p : rows()[row_of(name, where)].parameters) {
    if (!follows_from_constants(row_of(name, where), p.name)) constants[std::string(p.name)] = p.typical;
  }
  return make_law(name, constants, where);
}

ElasticLawSpec typical_law(std::size_t row) {
  ElasticLawSpec spec{row, {}};
  for (const auto& p : rows()[row].parameters) spec.parameters.push_back(p.typical);
  return spec;
}

}  // namespace pliant
