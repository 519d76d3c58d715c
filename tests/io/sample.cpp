#include "sample.hpp"

#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "places.hpp"

#include <algorithm>
#include <array>
#include <map>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::array<int, 3> num_cubes{3, 2, 2};
constexpr double side = 0.5;

struct WholeMesh {
  std::vector<std::array<double, 3>> nodes;
  std::vector<std::vector<std::int64_t>> cells;
};

WholeMesh whole_mesh(int nodes_per_cell) {
  WholeMesh mesh;
  for (int k = 0; k <= num_cubes[2]; ++k) {
    for (int j = 0; j <= num_cubes[1]; ++j) {
      for (int i = 0; i <= num_cubes[0]; ++i) mesh.nodes.push_back({side * i, side * j, side * k});
    }
  }
  const auto node = [](std::array<int, 3> at) {
    return at[0] + (num_cubes[0] + 1) * (at[1] + (num_cubes[1] + 1) * at[2]);
  };
  // Kuhn's split of a cube: one tetrahedron for each order in which a walk along the axes reaches the far corner.
  for (int k = 0; k < num_cubes[2]; ++k) {
    for (int j = 0; j < num_cubes[1]; ++j) {
      for (int i = 0; i < num_cubes[0]; ++i) {
        std::array<int, 3> axes{0, 1, 2};
        bool even = true;
        do {
          std::array<int, 3> at{i, j, k};
          std::vector<std::int64_t> cell{node(at)};
          for (const int axis : axes) {
            ++at[static_cast<std::size_t>(axis)];
            cell.push_back(node(at));
          }
          even = (axes[1] - axes[0] + 3) % 3 == 1;
          if (!even) std::swap(cell[1], cell[2]);
          mesh.cells.push_back(cell);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  if (nodes_per_cell == 4) return mesh;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> middle;
  for (auto& cell : mesh.cells) {
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}) {
      const auto p = std::minmax(cell[static_cast<std::size_t>(a)], cell[static_cast<std::size_t>(b)]);
      const auto [at, is_new] = middle.emplace(p, std::ssize(mesh.nodes));
      if (is_new) {
        const auto x = mesh.nodes[static_cast<std::size_t>(p.first)],
                   y = mesh.nodes[static_cast<std::size_t>(p.second)];
        mesh.nodes.push_back({(x[0] + y[0]) / 2, (x[1] + y[1]) / 2, (x[2] + y[2]) / 2});
      }
      cell.push_back(at->second);
    }
  }
  return mesh;
}

}  // namespace

OutputMesh sample_mesh(MPI_Comm comm, int nodes_per_cell, Split split) {
  const WholeMesh whole = whole_mesh(nodes_per_cell);
  const std::int64_t r = rank(comm), n = num_ranks(comm);
  const std::int64_t cell_ranks = split == Split::none_on_last_rank && n > 1 ? n - 1 : n;
  const auto begin = [](std::int64_t size, std::int64_t part, std::int64_t parts) {
    return size * std::min(part, parts) / parts;
  };
  OutputMesh mesh;
  mesh.nodes_per_cell = nodes_per_cell;
  mesh.global_num_nodes = std::ssize(whole.nodes);
  mesh.first_node = begin(mesh.global_num_nodes, r, n);
  for (std::int64_t i = mesh.first_node; i < begin(mesh.global_num_nodes, r + 1, n); ++i) {
    const auto& x = whole.nodes[static_cast<std::size_t>(i)];
    mesh.coordinates.insert(mesh.coordinates.end(), x.begin(), x.end());
  }
  const std::int64_t num_cells = std::ssize(whole.cells);
  for (std::int64_t c = begin(num_cells, r, cell_ranks); c < begin(num_cells, r + 1, cell_ranks); ++c) {
    const auto& cell = whole.cells[static_cast<std::size_t>(c)];
    mesh.cells.insert(mesh.cells.end(), cell.begin(), cell.end());
    mesh.bodies.push_back(c < num_cells / 2 ? 0 : 1);
  }
  mesh.body_names = {"soft & <warm>", "hard"};
  return mesh;
}

std::vector<double> sample_displacement(const OutputMesh& mesh, double t) {
  std::vector<double> u;
  for (std::size_t i = 0; i < mesh.coordinates.size(); i += 3) {
    const double x = mesh.coordinates[i], y = mesh.coordinates[i + 1], z = mesh.coordinates[i + 2];
    u.insert(u.end(), {0.1 * t * x * y, 0.0, -t * z * z});
  }
  return u;
}

std::vector<double> sample_stress(const OutputMesh& mesh, double t) {
  std::vector<double> stress;
  for (const int body : mesh.bodies) {
    for (int i = 1; i <= 6; ++i) stress.push_back(i * t + body);
  }
  return stress;
}

void write_sample_frame(ResultWriter& writer, const OutputMesh& mesh, double t, std::int64_t step) {
  const auto displacement = sample_displacement(mesh, t);
  const auto stress = sample_stress(mesh, t);
  const std::vector<double> density(mesh.bodies.size(), 1000.0);
  const std::vector<OutputField> fields{{"displacement", "m", FieldLocation::node, 3, displacement},
                                        {"cauchy_stress", "Pa", FieldLocation::cell, 6, stress},
                                        {"density", "kg/m^3", FieldLocation::cell, 1, density}};
  writer.write_frame(t, step, fields);
}

std::filesystem::path empty_directory(MPI_Comm comm, const std::string& name) {
  std::filesystem::path directory = build_root() / "tests" / "io" / fmt::format("{}_np{}", name, num_ranks(comm));
  on_root(comm, [&] {
    std::filesystem::remove_all(directory);
    std::filesystem::create_directories(directory);
  });
  return directory;
}

}  // namespace pliant
