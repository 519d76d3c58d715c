/// The table of time integration methods: a row holds the coefficients (alpha, beta, A, b); everything else is derived,
/// for the rows of this table and for those of users.
///
///     base      y* = sum_r alpha_r y_{n+1-r}                 (r = 1..l)
///     stage i   t_i = t_n + (1 - beta + beta c_i) dt,  dt_i = beta A_ii dt
///               Y_i0 = y* + sum_{j<i} At_ij (Y_j - y*),  Y_i = Y_i0 + dt_i f(t_i, Y_i)
///     end       y_{n+1} = y* + sum_i bt_i (Y_i - y*)
///
/// Sources: Kennedy & Carpenter 2016 (NASA/TM-2016-219173); Hairer & Wanner, Solving Ordinary Differential Equations
/// II.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace pliant {

/// A row of the table.
struct MethodRow {
  std::string name;  ///< as users type it
  std::vector<double> alpha;
  double beta = 1.0;
  std::vector<std::vector<double>> A;  ///< rows of a lower triangular matrix, with their zeros
  std::vector<double> b;
  std::string summary;  ///< when to use the method
};

/// L-stability is a notion of one-step methods; see Method::R_infinity for the damping of multistep ones.
enum class Stability { not_a_stable, a_stable, l_stable };

/// "A-stable", ...
std::string to_string(Stability stability);

/// A row with all that is derived from it (time/order_conditions.hpp, time/linear_stability.hpp). Obtained from
/// derive_method, find_method or methods.
struct Method : MethodRow {
  int num_steps = 1;                    ///< l, the number of past states
  int num_stages = 1;                   ///< s
  std::vector<double> c;                ///< row sums of A
  std::vector<std::vector<double>> At;  ///< At_i = A_{i,1:i-1} (A_{1:i-1,1:i-1})^-1; row i has i entries (i from 0)
  std::vector<double> bt;               ///< bt^T = b^T A^-1; exactly (0, ..., 0, 1) if stiffly accurate
  int order = 0;                        ///< after an exact start; determined up to 3
  Stability stability = Stability::not_a_stable;
  double R_infinity = 0.0;        ///< factor of a step on an infinitely fast decaying mode; for several past states,
                                  ///< the largest modulus
  bool stiffly_accurate = false;  ///< y_{n+1} = Y_s
  bool symplectic = false;
  double max_growth = 0.0;  ///< limit of the ratio of successive steps; the stepper takes a lower formula above it
  bool needs_equal_steps = false;  ///< alpha and beta hold for equal steps, and their form for others is unknown

  double error_constant = 0.0;  ///< C of the error y_{n+1} - y(t_{n+1}) ~ C dt^(p+1) y^(p+1) that one step adds on
                                ///< linear problems; over a motion it acts as C / beta
  std::vector<double>
      bt_embedded;         ///< weights of the stages that end the step by a formula of lower order, whose
                           ///< difference estimates the error: sum_i (bt - bt_embedded)_i (Y_i - y*); empty if none
  int embedded_order = 0;  ///< p^, order of that formula; 0 if none
  double embedded_error = 0.0;  ///< c of that difference ~ c dt^(p^+1) y^(p^+1) on linear problems

  /// The order that is left when the rate of a function E(q) in a stage is (E(q_i) - E_i0) / dt_i, E_i0 reconstructed
  /// as q_i0 is (docs/theory.md, "Strain rates and their orders"); determined up to 3.
  int reconstructed_rate_order = 0;
};

/// Why a row is not a method that this layer can run, for messages.
struct MethodRefusal {
  std::string reason;
};

/// Limits of a row.
inline constexpr std::size_t max_past_states = 6;
inline constexpr std::size_t max_stages = 10;

/// Derives a method from its row: any number of past states and of stages, each stage implicit and solved in turn.
/// Throws for coefficients that are inconsistent or not zero-stable, and for stages that are explicit or fully coupled.
std::variant<Method, MethodRefusal> derive_method(MethodRow row);

/// Why the length of the method's steps cannot follow its error, for messages; nothing if it can.
std::optional<std::string> why_not_adaptive(const Method& method);

/// Whether reconstructed rates cost the method none of its order.
bool keeps_order_with_reconstructed_rates(const Method& method);

/// For methods with adaptive steps: the estimated error of a step falls as dt^(this + 1) once enough steps are known
/// (time/error_estimate.hpp). The method's order if its last stage ends the step, else one more than that of the
/// embedded formula.
int estimate_order(const Method& method);

/// All methods, in the order in which they are to be shown.
std::span<const Method> methods();

/// The method with this name; nullptr if there is none.
const Method* find_method(std::string_view name);

}  // namespace pliant
