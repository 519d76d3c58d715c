/// Common parts of laws with fibres: the invariants of unit directions f, s of the reference body, with their gradients
/// B = di/dF and the increments dB, and the exponential energy of an invariant.
///
///   I1b - 3                                    isochoric.hpp
///   I4 - 1  = 2 f.Ef                           stretch of a fibre, squared
///   I4b - 1 = a (2 f.Ef - (x - 1))             without the change of volume; a = J^(-2/3), x = J^(2/3)
///   I8      = 2 f.Es,  f.s = 0                 shear between two directions
///
/// Written in E, they avoid cancellation when the strain is small. An energy sum_k w_k(i_k) + kappa U(J) then has
///   P  = sum_k w_k' B_k + kappa J U' G,  G = F^-T
///   dP = sum_k (w_k'' (B_k : dH) B_k + w_k' dB_k) + ...
/// Source: Holzapfel & Ogden, Phil. Trans. R. Soc. A 367 (2009) 3445-3475, sections 3 and 4.
#pragma once

#include "base/vector3.hpp"
#include "material/isochoric.hpp"

namespace pliant {

/// Keys of directions: of laws with one preferred direction, with a second one normal to it, and with two families.
inline constexpr std::array<std::string_view, 1> one_fibre{"fibre"};
inline constexpr std::array<std::string_view, 2> fibre_and_sheet{"fibre", "sheet"};
inline constexpr std::array<std::string_view, 2> two_fibres{"fibre", "fibre2"};

/// A direction in the scalar type of the state.
template <class T, class S>
PLIANT_INLINE Vector3<T> direction_as(const std::array<S, 3>& d) {
  return {T(d[0]), T(d[1]), T(d[2])};
}

/// Quantities that depend on F alone. If J <= 0, G is NaN.
template <class T>
struct FibreState {
  Distortion<T> at;
  Tensor3<T> F, G;  ///< G = F^-T

  template <class Mask>
  PLIANT_INLINE FibreState(const Tensor3<T>& H, const T& volume_change, const Mask& valid)
      : at(H, volume_change, valid), F(add_to_diagonal(H, 1.0)) {
    G = select(valid, T(1.0 / (1.0 + at.j)), T(nan)) * cofactor(F);
  }

  /// dG = -G dH^T G.
  PLIANT_INLINE Tensor3<T> change_of_G(const Tensor3<T>& dH) const {
    return -1.0 * matmul(G, matmul(transpose(dH), G));
  }
};

/// I1b - 3.
template <class T>
struct IsochoricInvariant {
  T value;
  Tensor3<T> D1, B;

  PLIANT_INLINE explicit IsochoricInvariant(const FibreState<T>& s)
      : value(s.at.i1), D1((2.0 * s.at.a) * s.at.D), B(2.0 * matmul(s.G, D1)) {}

  PLIANT_INLINE Tensor3<T> change(const FibreState<T>& s, const Tensor3<T>& dH) const {
    const Tensor3<T> dE = small_strain(matmul(transpose(s.F), dH));
    const Tensor3<T> dD = add_to_diagonal(dE, T(-1.0 / 3.0 * trace(dE)));
    const Tensor3<T> dD1 = (2.0 * s.at.a) * dD - (2.0 / 3.0 * dot(s.G, dH)) * D1;
    return matmul(s.G, 2.0 * dD1 - matmul(transpose(dH), B));
  }
};

/// I4 - 1 of a direction.
template <class T>
struct FibreInvariant {
  Vector3<T> f, Ff;
  T value;
  Tensor3<T> B;

  PLIANT_INLINE FibreInvariant(const FibreState<T>& s, const Vector3<T>& direction)
      : f(direction), Ff(matvec(s.F, f)), value(2.0 * dot(f, matvec(s.at.E, f))), B(2.0 * outer(Ff, f)) {}

  PLIANT_INLINE Tensor3<T> change(const FibreState<T>&, const Tensor3<T>& dH) const {
    return 2.0 * outer(matvec(dH, f), f);
  }
};

/// I4b - 1 of a direction.
template <class T>
struct IsochoricFibreInvariant {
  FibreInvariant<T> full;
  T value;
  Tensor3<T> B;

  PLIANT_INLINE IsochoricFibreInvariant(const FibreState<T>& s, const Vector3<T>& direction)
      : full(s, direction),
        value(s.at.a * (full.value - s.at.y)),
        B(s.at.a * (full.B - (2.0 / 3.0 * (1.0 + full.value)) * s.G)) {}

  PLIANT_INLINE Tensor3<T> change(const FibreState<T>& s, const Tensor3<T>& dH) const {
    return s.at.a * (full.change(s, dH) - (2.0 / 3.0 * dot(full.B, dH)) * s.G -
                     (2.0 / 3.0 * (1.0 + full.value)) * s.change_of_G(dH)) -
           (2.0 / 3.0 * dot(s.G, dH)) * B;
  }
};

/// I8 of two directions at right angles.
template <class T>
struct ShearInvariant {
  Vector3<T> f, s;
  T value;
  Tensor3<T> B;

  PLIANT_INLINE ShearInvariant(const FibreState<T>& state, const Vector3<T>& first, const Vector3<T>& second)
      : f(first),
        s(second),
        value(2.0 * dot(f, matvec(state.at.E, s))),
        B(outer(matvec(state.F, s), f) + outer(matvec(state.F, f), s)) {}

  PLIANT_INLINE Tensor3<T> change(const FibreState<T>&, const Tensor3<T>& dH) const {
    return outer(matvec(dH, s), f) + outer(matvec(dH, f), s);
  }
};

/// First and second derivative of an energy of one invariant [Pa].
template <class T>
struct Derivatives {
  T first, second;
};

/// f(x), a function like exp(x), for x up to 700, where exp(x) is about 1e304; `beyond` for larger x. No overflow.
template <class T, class Function>
PLIANT_INLINE T within_exponent(const T& x, double beyond, const Function& f) {
  const auto fits = x <= 700.0;
  return select(fits, f(T(select(fits, x, T(0.0)))), T(beyond));
}

/// Whether fibres are slack in compression.
enum class Compression { slack, stiff };

/// w(i) = a/(2 b) (exp(b i^2) - 1), with <i> = max(i, 0) in place of i if fibres are slack in compression.
template <class S, Compression compression = Compression::slack>
struct ExponentialFibre {
  S a;  ///< [Pa]
  S b;  ///< above 0

  template <class T>
  PLIANT_INLINE T energy(const T& i) const {
    const T m = pulled(i);
    return (0.5 * a / b) * within_exponent(T(b * (m * m)), infinity, [](const T& x) -> T { return expm1(x); });
  }
  template <class T>
  PLIANT_INLINE Derivatives<T> derivatives(const T& i) const {
    const T m = pulled(i), x = b * (m * m);
    const T scale = a * within_exponent(x, nan, [](const T& y) -> T { return exp(y); });
    const T second = scale * (1.0 + 2.0 * x);
    if constexpr (compression == Compression::stiff) return {scale * m, second};
    return {scale * m, select(i > 0.0, second, T(0.0 * scale))};
  }

 private:
  template <class T>
  PLIANT_INLINE static T pulled(const T& i) {
    if constexpr (compression == Compression::stiff) return i;
    return select(i <= 0.0, T(0.0), i);  // NaN stays
  }
};

/// Common part of the linearizations of laws with fibres; `Linearization` has dP as its operator().
template <class Linearization, class T>
struct FibreLinearization {
  FibreState<T> s;
  T pressure, slope;  ///< Kirchhoff pressure, and J d/dJ of it [Pa]
  Tensor3<T> P;       ///< [Pa]

  PLIANT_INLINE Tangent<T> tangent() const { return tangent_by_columns<T>(static_cast<const Linearization&>(*this)); }
};

/// The parts of a law with fibres that do not depend on its energy. `Law` has `volumetric`; `energy(H, change, valid)`,
/// which is psi where `valid` (J > 0; change = J - 1) and any number elsewhere; and `linearize_at(s, pressure)`, a
/// FibreLinearization at a FibreState and the VolumetricStress there.
template <class Law>
struct FibreLaw {
  static constexpr bool is_barrier = true;
  static constexpr bool constant_tangent = false;
  static constexpr int energy_degree = 2;
  static constexpr bool has_stretch_limit = true;

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    return select(valid, law().energy(H, change, valid), T(infinity));
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE auto linearize(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const FibreState<T> s(H, change, change > -1.0);
    return law().linearize_at(s, law().volumetric.stress(s.at.j));
  }

 private:
  PLIANT_INLINE const Law& law() const { return static_cast<const Law&>(*this); }
};

}  // namespace pliant
