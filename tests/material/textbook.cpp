// The energies of F as textbooks write them, in Quad. A law of the registry without one does not compile.
#include "material/states.hpp"

namespace pliant::testing_states {

std::array<Quad, 3> stretches_reference(const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  std::array<Quad, 3> l = eigenvalues_reference(add_to_diagonal(matmul(transpose(F), F), -1));
  for (Quad& value : l) value = root_reference(1 + value);
  return l;
}

namespace {

template <class S>
Quad psi(const Linear<S>& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> eps = Quad(0.5) * (H + transpose(H));
  return law.mu * dot(eps, eps) + law.lambda / 2 * trace(eps) * trace(eps);
}
template <class S>
Quad psi(const SaintVenantKirchhoff<S>& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Tensor3<Quad> E = Quad(0.5) * add_to_diagonal(matmul(transpose(F), F), -1);
  return law.mu * dot(E, E) + law.lambda / 2 * trace(E) * trace(E);
}
template <class S>
Quad psi(const NeoHookean<S>& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Quad log_J = log_reference(det(F));
  return law.mu / 2 * (dot(F, F) - 3) - law.mu * log_J + law.lambda / 2 * log_J * log_J;
}

/// J and the invariants of C, the first two of its part without change of volume.
struct Invariants {
  Quad J, i1, i2;  ///< J, I1b - 3, I2b - 3
  Quad a;          ///< J^(-2/3)

  explicit Invariants(const Tensor3<Quad>& H) {
    const Tensor3<Quad> F = add_to_diagonal(H, 1), C = matmul(transpose(F), F);
    J = det(F);
    a = power_reference(J, Quad(-2) / 3);
    i1 = a * trace(C) - 3;
    i2 = a * a * second_invariant(C) - 3;
  }
};

Quad volumetric_energy(const Volumetric<double>& v, Quad J) {
  const Quad log_J = log_reference(J);
  switch (v.form) {
    case VolumetricForm::log:
      return v.kappa / 2 * log_J * log_J;
    case VolumetricForm::quadratic:
      return v.kappa / 2 * (J - 1) * (J - 1);
    case VolumetricForm::mixed:
      break;
  }
  return v.kappa / 4 * (J * J - 1 - 2 * log_J);
}

Quad psi(const NeoHookeanIsochoric<double>& law, const Tensor3<Quad>& H) {
  const Invariants I(H);
  return law.mu / 2 * I.i1 + volumetric_energy(law.volumetric, I.J);
}
Quad psi(const MooneyRivlin<double>& law, const Tensor3<Quad>& H) {
  const Invariants I(H);
  return law.c10 * I.i1 + law.c01 * I.i2 + volumetric_energy(law.volumetric, I.J);
}
Quad psi(const MooneyRivlin5<double>& law, const Tensor3<Quad>& H) {
  const Invariants I(H);
  return law.c10 * I.i1 + law.c01 * I.i2 + law.c20 * I.i1 * I.i1 + law.c11 * I.i1 * I.i2 + law.c02 * I.i2 * I.i2 +
         volumetric_energy(law.volumetric, I.J);
}
Quad psi(const MooneyRivlinCoupled<double>& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1), C = matmul(transpose(F), F);
  const Quad log_J = log_reference(det(F));
  return law.c1 * (trace(C) - 3) + law.c2 * (second_invariant(C) - 3) - 2 * (law.c1 + 2 * Quad(law.c2)) * log_J +
         law.lambda / 2 * log_J * log_J;
}

Quad psi(const Yeoh<double>& law, const Tensor3<Quad>& H) {
  const Invariants I(H);
  return law.c10 * I.i1 + law.c20 * I.i1 * I.i1 + law.c30 * I.i1 * I.i1 * I.i1 + volumetric_energy(law.volumetric, I.J);
}
Quad psi(const Gent<double>& law, const Tensor3<Quad>& H) {
  const Invariants I(H);
  const Quad limit = law.stretch_limit;
  return -law.mu * limit / 2 * log_reference(1 - I.i1 / limit) + volumetric_energy(law.volumetric, I.J);
}
/// With the paper's constant, from its own formula for the modulus at rest.
Quad psi(const ArrudaBoyce<double>& law, const Tensor3<Quad>& H) {
  const Invariants I(H);
  const Quad s = 1 / (Quad(law.locking_stretch) * law.locking_stretch), I1 = I.i1 + 3;
  const Quad C_R = law.mu / (1 + 3 * s / 5 + 99 * s * s / 175 + 513 * s * s * s / 875 + 42039 * s * s * s * s / 67375);
  const auto term = [&](int k) {
    Quad power = 1, rest = 1;
    for (int n = 0; n < k; ++n) {
      power *= I1;
      rest *= 3;
    }
    return power - rest;
  };
  return C_R * (term(1) / 2 + s * term(2) / 20 + 11 * s * s * term(3) / 1050 + 19 * s * s * s * term(4) / 7000 +
                519 * s * s * s * s * term(5) / 673750) +
         volumetric_energy(law.volumetric, I.J);
}
Quad psi(const StableNeoHookean<double>& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Quad m = Quad(4) / 3 * law.mu, l = law.lambda + Quad(5) / 6 * law.mu, alpha = 1 + 3 * m / (4 * l);
  const auto psi = [&](Quad I_C, Quad J) {
    return m / 2 * (I_C - 3) + l / 2 * (J - alpha) * (J - alpha) - m / 2 * log_reference(I_C + 1);
  };
  return psi(dot(F, F), det(F)) - psi(3, 1);
}

Quad psi(const Ogden<double>& law, const Tensor3<Quad>& H) {
  const Quad J = det(add_to_diagonal(H, 1)), log_J = log_reference(J);
  Quad psi = volumetric_energy(law.volumetric, J);
  for (const Quad l : stretches_reference(H)) {
    const Quad log_l = log_reference(l) - log_J / 3;
    for (std::size_t p = 0; p < law.mu.size(); ++p) {
      const Quad mu = law.mu[p], alpha = law.alpha[p];
      psi += alpha == 0 ? mu * log_l * log_l : 2 * mu / (alpha * alpha) * (exp_reference(alpha * log_l) - 1);
    }
  }
  return psi;
}
template <class S>
Quad psi(const Arap<S>& law, const Tensor3<Quad>& H) {
  Quad sum = 0;
  for (const Quad l : stretches_reference(H)) sum += (l - 1) * (l - 1);
  return law.mu * sum;
}
template <class S>
Quad psi(const FixedCorotated<S>& law, const Tensor3<Quad>& H) {
  const Quad J = det(add_to_diagonal(H, 1));
  return psi(Arap<S>{law.mu}, H) + law.lambda / 2 * (J - 1) * (J - 1);
}

/// a.(C - I)b; its digits do not depend on how exactly a and b are unit vectors.
Quad strain_between(const std::array<double, 3>& a, const std::array<double, 3>& b, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1), C = matmul(transpose(F), F);
  Quad sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) sum += Quad(a[i]) * (C(i, j) - (i == j)) * Quad(b[j]);
  }
  return sum;
}

/// a/(2 b) (exp(b i^2) - 1).
Quad exponential(double a, double b, Quad i) {
  return a / (2 * Quad(b)) * (exp_reference(b * i * i) - 1);
}

/// In the frame of the fibre and two directions across, as the papers write it.
Quad psi(const Guccione<double>& law, const Tensor3<Quad>& H) {
  const auto& f = law.fibre;
  // Across the fibre: along the axis that it is least along, and normal to both; in double, as the fibre is.
  const std::size_t k =
      static_cast<std::size_t>(std::ranges::min_element(f, {}, [](double x) { return std::abs(x); }) - f.begin());
  Vector3<double> axis{};
  axis[k] = 1.0;
  const Vector3<double> normal = cross(f, axis), s = (1.0 / std::sqrt(dot(normal, normal))) * normal, n = cross(f, s);
  const auto E = [&](const auto& a, const auto& b) { return strain_between(a, b, H) / 2; };
  const Quad Q = law.bf * E(f, f) * E(f, f) + law.bt * (E(s, s) * E(s, s) + E(n, n) * E(n, n) + 2 * E(s, n) * E(s, n)) +
                 2 * law.bfs * (E(f, s) * E(f, s) + E(f, n) * E(f, n));
  return law.C / 2 * (exp_reference(Q) - 1) + volumetric_energy(law.volumetric, Invariants(H).J);
}

// Of laws with fibres that are slack in compression: which of them pull, and the energy while these pull.

std::array<Quad, 2> family_strains(const HolzapfelGasserOgden<double>& law, const Tensor3<Quad>& H,
                                   const Invariants& I) {
  std::array<Quad, 2> strains;
  for (std::size_t n = 0; n < 2; ++n) {
    const auto& f = law.families[n];
    const Quad length = Quad(f[0]) * f[0] + Quad(f[1]) * f[1] + Quad(f[2]) * f[2], d = law.dispersion;
    strains[n] = d * I.i1 + (1 - 3 * d) * (I.a * (strain_between(f, f, H) / length + 1) - 1);
  }
  return strains;
}
std::array<bool, 2> pulling(const HolzapfelGasserOgden<double>& law, const Tensor3<Quad>& H) {
  const auto strains = family_strains(law, H, Invariants(H));
  return {strains[0] > 0, strains[1] > 0};
}
Quad psi(const HolzapfelGasserOgden<double>& law, const Tensor3<Quad>& H, const std::array<bool, 2>& pulls) {
  const Invariants I(H);
  const auto strains = family_strains(law, H, I);
  Quad psi = law.mu / 2 * I.i1 + volumetric_energy(law.volumetric, I.J);
  for (std::size_t n = 0; n < 2; ++n) {
    if (pulls[n]) psi += exponential(law.pull.a, law.pull.b, strains[n]);
  }
  return psi;
}

std::array<bool, 2> pulling(const HolzapfelOgden<double>& law, const Tensor3<Quad>& H) {
  const auto& [f, s] = law.directions;
  return {strain_between(f, f, H) > 0, strain_between(s, s, H) > 0};
}
Quad psi(const HolzapfelOgden<double>& law, const Tensor3<Quad>& H, const std::array<bool, 2>& pulls) {
  const auto& [f, s] = law.directions;
  const Invariants I(H);
  Quad psi = law.a / (2 * Quad(law.b)) * (exp_reference(law.b * I.i1) - 1) +
             exponential(law.shear.a, law.shear.b, strain_between(f, s, H)) + volumetric_energy(law.volumetric, I.J);
  if (pulls[0]) psi += exponential(law.along_f.a, law.along_f.b, strain_between(f, f, H));
  if (pulls[1]) psi += exponential(law.along_s.a, law.along_s.b, strain_between(s, s, H));
  return psi;
}

template <class L>
concept HasSlackFibres = requires(const L& law, const Tensor3<Quad>& H) {
  pulling(law, H);
};
template <HasSlackFibres L>
Quad psi(const L& law, const Tensor3<Quad>& H) {
  return psi(law, H, pulling(law, H));
}

}  // namespace

Quad textbook_psi(const ElasticLawVariant& law, const Tensor3<Quad>& H) {
  return std::visit([&](const auto& of) { return psi(of, H); }, law);
}

Tensor3<Quad> textbook_P(const ElasticLawVariant& law, const Tensor3<Quad>& H) {
  const auto gradient = [&](const auto& energy) {
    Tensor3<Quad> P;
    for (std::size_t p = 0; p < 9; ++p) P.a[p] = central_difference(energy, H, p);
    return P;
  };
  return std::visit(
      [&]<class L>(const L& of) {
        if constexpr (HasSlackFibres<L>) {
          return gradient([&, at = pulling(of, H)](const auto& X) { return psi(of, X, at); });
        } else {
          return gradient([&](const auto& X) { return psi(of, X); });
        }
      },
      law);
}

}  // namespace pliant::testing_states
