/// Values at nodes from values at points inside the cells: superconvergent patch recovery.
///
/// Around each vertex a polynomial is fitted, by least squares, to the values in those cells of one body that touch the
/// vertex. Its value at the vertex, and of the polynomials of both ends of an edge the mean of the values at the edge's
/// node, are the recovered ones. Where a patch is too small for the degree, or would magnify errors, as at corners of
/// the mesh, polynomials of the neighbours take its place; if none of these serves either, the degree is lowered.
/// Fields that are polynomials of the degree are recovered exactly. Source: Zienkiewicz & Zhu, Int. J. Numer. Methods
/// Eng. 33 (1992) 1331-1364.
#pragma once

#include "base/limits.hpp"
#include "fem/layout.hpp"

#include <array>
#include <span>
#include <vector>

namespace pliant {

class PatchRecovery {
 public:
  /// Where values are known in each cell, and what is fitted to them.
  struct Samples {
    std::vector<std::array<double, 3>> points;  ///< on the reference tetrahedron
    int degree = 1;                             ///< of the polynomials: 0, 1 or 2
    /// The largest sum of squares of the weights with which values enter a recovered one; more would magnify their
    /// errors, and a neighbour's polynomial or a lower degree is preferred.
    double trusted_gain = infinity;
  };

  /// `body_of_cell`: per local cell; cells of body -1 are left out. The layout must outlive the object. Collective.
  PatchRecovery(const NodeLayout& layout, std::span<const int> body_of_cell, Samples samples);

  struct AtNodes {
    std::vector<double> values;   ///< [local node][component], ghosts included; 0 where there is none
    std::vector<char> has_value;  ///< per local node: whether it is one of a body that was taken
  };
  /// `values`: [local cell][point][component]. At nodes that several bodies share it is the mean of what is recovered
  /// from each. `is_taken`: per body, whether its cells count. Collective.
  AtNodes at_nodes(std::span<const double> values, int components, std::span<const char> is_taken) const;

 private:
  static constexpr int most_terms = 10;
  /// Where a value at a node comes from, best first.
  enum Merit { own, of_neighbour, lowered, num_merits };

  /// The cells of one body around an owned vertex.
  struct Patch {
    int body = 0;
    std::size_t first_cell = 0, first_node = 0;  // in cells_, nodes_
    std::size_t num_cells = 0;
    std::size_t num_own = 0, num_nodes = 0;  // own: the vertex, then nodes on its edges; after them the cells' others
    std::array<double, 3> centre{};          // mean of its points [m]
    double size = 1.0;                       // the largest distance of a point from there [m]
    int num_terms = 1;
    std::size_t first_number = 0;  // in inverses_: of the matrix of the normal equations
  };

  std::vector<std::array<double, 3>> sample_positions(const Patch& patch) const;
  void colour_bodies();
  void fit(Patch& patch);
  bool has_degree(const Patch& patch) const;
  void evaluate(const Patch& patch, std::span<const double> values, std::size_t width,
                std::array<std::vector<double>, num_merits>& sums) const;
  bool can_fit(Patch& patch, std::span<const std::array<double, 3>> at, int num_terms);
  std::array<double, most_terms> terms_at(const Patch& patch, const std::array<double, 3>& X) const;

  const NodeLayout& layout_;
  Samples samples_;
  std::vector<Patch> patches_;
  std::vector<PetscInt> cells_, nodes_;
  std::vector<double> inverses_;
  std::vector<int> colour_of_body_;  // bodies that share a node have different ones
  int num_colours_ = 0;
};

}  // namespace pliant
