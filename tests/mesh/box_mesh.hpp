/// Structured test meshes: a box cut into cubes, each cube into six tetrahedra around its diagonal (Kuhn).
#pragma once

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace pliant::test {

/// Lower parts of the box that may be groups too: the curve "edge" (tag 5) along the x axis and the point "corner" (tag
/// 6) at its end.
enum class Outline { none, edge_and_corner };

struct BoxOptions {
  int order = 1;       ///< 2 writes ten-node tetrahedra
  bool groups = true;  ///< "clamp" (x = 0), "tip" (x = lx) and "body"; false: no physical names
  std::array<double, 3> origin{0.0, 0.0, 0.0};  ///< corner of the box [m]
  std::function<std::array<double, 3>(std::array<double, 3>)>
      map;      ///< moves every node (mid-edge nodes too), e.g. to bend the box
  int cut = 0;  ///< > 0: also the group "cut" (tag 4), the facets inside the box at x = cut lx / n[0]
  Outline outline = Outline::none;
  int missing = -1;  ///< >= 0: without the cubes that have this number along x, which leaves two bodies
};

/// Writes the box of `size` [m] with n[0] x n[1] x n[2] cubes as gmsh 2.2 ascii: (n0 + 1)(n1 + 1)(n2 + 1) vertices, 6
/// n0 n1 n2 tetrahedra, 2 n1 n2 triangles in each of "clamp" (tag 1) and "tip" (tag 2); "body" has tag 3. Not
/// collective: call on one rank.
inline void write_box_msh(const std::string& file, std::array<double, 3> size, std::array<int, 3> n,
                          const BoxOptions& options = {}) {
  using Lattice = std::array<int, 3>;  // twice the cube index, so that mid-edge nodes are on it
  std::map<Lattice, int> number;
  std::vector<Lattice> nodes;
  const auto node = [&](const Lattice& at) {
    const auto [it, is_new] = number.try_emplace(at, static_cast<int>(nodes.size()) + 1);
    if (is_new) nodes.push_back(at);
    return it->second;
  };
  const auto between = [](const Lattice& a, const Lattice& b) {
    return Lattice{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
  };
  for (int k = 0; k <= n[2]; ++k) {
    for (int j = 0; j <= n[1]; ++j) {
      for (int i = 0; i <= n[0]; ++i) node({2 * i, 2 * j, 2 * k});
    }
  }
  std::string elements;
  int num_elements = 0;
  const auto add = [&](int type, int physical, int entity, const std::vector<Lattice>& at) {
    elements += std::to_string(++num_elements) + " " + std::to_string(type) + " 2 " + std::to_string(physical) + " " +
                std::to_string(entity);
    for (const auto& p : at) elements += " " + std::to_string(node(p));
    elements += "\n";
  };
  const auto add_triangle = [&](int tag, const Lattice& a, const Lattice& b, const Lattice& c) {
    std::vector<Lattice> at{a, b, c};
    if (options.order == 2) at.insert(at.end(), {between(a, b), between(b, c), between(c, a)});
    add(options.order == 2 ? 9 : 2, options.groups ? tag : 0, tag, at);
  };
  std::vector<std::array<int, 2>> planes{{1, 0}, {2, 2 * n[0]}};  // tag and place
  if (options.cut > 0) planes.push_back({4, 2 * options.cut});
  for (const auto& [tag, x] : planes) {
    for (int j = 0; j < n[1]; ++j) {
      for (int k = 0; k < n[2]; ++k) {
        const Lattice a{x, 2 * j, 2 * k}, b{x, 2 * j + 2, 2 * k}, c{x, 2 * j + 2, 2 * k + 2}, d{x, 2 * j, 2 * k + 2};
        add_triangle(tag, a, b, c);
        add_triangle(tag, a, c, d);
      }
    }
  }
  const bool has_outline = options.outline == Outline::edge_and_corner;
  for (int i = 0; i < n[0] && has_outline; ++i) {
    std::vector<Lattice> at{{2 * i, 0, 0}, {2 * i + 2, 0, 0}};
    if (options.order == 2) at.push_back(between(at[0], at[1]));
    add(options.order == 2 ? 8 : 1, 5, 5, at);
  }
  if (has_outline) add(15, 6, 6, {{2 * n[0], 0, 0}});
  constexpr std::array<std::array<std::size_t, 2>, 6> edges{{{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}}};
  constexpr std::array<std::array<int, 3>, 6> axes{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  for (int i = 0; i < n[0]; ++i) {
    if (i == options.missing) continue;
    for (int j = 0; j < n[1]; ++j) {
      for (int k = 0; k < n[2]; ++k) {
        for (std::size_t p = 0; p < axes.size(); ++p) {
          std::vector<Lattice> at{{2 * i, 2 * j, 2 * k}};
          for (const int axis : axes[p]) {
            at.push_back(at.back());
            at.back()[static_cast<std::size_t>(axis)] += 2;
          }
          if (p >= 3) std::swap(at[1], at[2]);  // odd permutations are negatively oriented
          if (options.order == 2) {
            for (const auto& [a, b] : edges) {
              at.push_back(between(at[a], at[b]));
            }
          }
          add(options.order == 2 ? 11 : 4, options.groups ? 3 : 0, 3, at);
        }
      }
    }
  }
  std::ofstream out(file);
  out.precision(std::numeric_limits<double>::max_digits10);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  if (options.groups) {
    const int num_names = 3 + (options.cut > 0 ? 1 : 0) + (has_outline ? 2 : 0);
    out << "$PhysicalNames\n" << num_names << "\n2 1 \"clamp\"\n2 2 \"tip\"\n3 3 \"body\"\n";
    out << (options.cut > 0 ? "2 4 \"cut\"\n" : "") << (has_outline ? "1 5 \"edge\"\n0 6 \"corner\"\n" : "");
    out << "$EndPhysicalNames\n";
  }
  out << "$Nodes\n" << nodes.size() << "\n";
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    std::array<double, 3> x{};
    for (std::size_t d = 0; d < 3; ++d) x[d] = options.origin[d] + size[d] * nodes[i][d] / (2.0 * n[d]);
    if (options.map) x = options.map(x);
    out << i + 1 << " " << x[0] << " " << x[1] << " " << x[2] << "\n";
  }
  out << "$EndNodes\n$Elements\n" << num_elements << "\n" << elements << "$EndElements\n";
  if (!out.flush()) throw std::runtime_error("cannot write " + file);
}

}  // namespace pliant::test
