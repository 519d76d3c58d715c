#include "mesh/cell_block.hpp"

#include "mesh/part_search.hpp"
#include "petsc/collective.hpp"
#include "petsc/exchange.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

namespace pliant {
namespace {

void add_marks(const SerialGroup& group, int number, std::optional<PartSearch>& search, std::span<const PetscInt> cells,
               std::vector<CellMark>& marks, std::vector<std::string>& notices) {
  const auto dimension = static_cast<std::int8_t>(group.group.dimension);
  if (dimension == 3) {
    for (const PetscInt cell : group.members) marks.push_back({cell, number, dimension, 0});
    return;
  }
  if (!search) search.emplace(cells);
  const auto size = static_cast<std::size_t>(dimension) + 1;
  std::size_t num_found = 0;
  for (std::size_t i = 0; i + size <= group.members.size(); i += size) {
    const std::size_t before = marks.size();
    (*search)({&group.members[i], size}, [&](std::size_t cell, std::size_t part) {
      marks.push_back({static_cast<PetscInt>(cell), number, dimension, static_cast<std::int8_t>(part)});
    });
    num_found += marks.size() > before ? 1 : 0;
  }
  notice_left_out(group, num_found, notices);
}

std::vector<double> values_of_cells(const SerialMesh& mesh, std::size_t width) {
  std::vector<double> values;
  values.reserve(width * mesh.num_cells());
  for (std::size_t c = 0; c < mesh.num_cells() && width > 0; ++c) {
    for (const CellField& data : mesh.cell_data) {
      const auto size = static_cast<std::size_t>(data.components);
      values.insert(values.end(), &data.values[size * c], &data.values[size * c] + size);
    }
    if (mesh.geometry_order() == 1) continue;
    for (std::size_t e = 0; e < 6; ++e) {
      const double* x = mesh.node(mesh.mid_nodes[6 * c + e]);
      values.insert(values.end(), x, x + 3);
    }
  }
  return values;
}

/// `width` numbers of each of these cells.
template <class T>
std::vector<T> rows_of(const std::vector<T>& all, std::size_t width, const std::vector<std::vector<PetscInt>>& cells) {
  std::vector<T> rows;
  std::size_t num_rows = 0;
  for (const auto& list : cells) num_rows += list.size();
  rows.reserve(width * num_rows);
  for (const auto& list : cells) {
    for (const PetscInt c : list) {
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(width) * c;
      rows.insert(rows.end(), first, first + static_cast<std::ptrdiff_t>(width));
    }
  }
  return rows;
}

/// The marks of these cells, which they number from 0.
std::vector<CellMark> marks_of(std::span<const CellMark> marks, std::span<const PetscInt> cells) {
  std::vector<CellMark> result;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto of_cell = std::ranges::equal_range(marks, cells[i], {}, &CellMark::cell);
    for (CellMark mark : of_cell) {
      mark.cell = static_cast<PetscInt>(i);
      result.push_back(mark);
    }
  }
  return result;
}

std::vector<CellMark> sent_marks(MPI_Comm comm, std::span<const CellMark> marks,
                                 const std::vector<std::vector<PetscInt>>& cells, std::span<const int> num_cells_in) {
  std::vector<CellMark> out;
  std::vector<int> num_out;
  for (const auto& list : cells) {
    const std::vector<CellMark> of_list = marks_of(marks, list);
    num_out.push_back(static_cast<int>(of_list.size()));
    out.insert(out.end(), of_list.begin(), of_list.end());
  }
  const std::vector<int> num_in = exchanged_counts(comm, num_out);
  std::vector<CellMark> in = exchanged(comm, out, num_out, num_in);
  PetscInt first_cell = 0;
  auto mark = in.begin();
  for (std::size_t r = 0; r < num_in.size(); ++r) {
    for (int i = 0; i < num_in[r]; ++i) (mark++)->cell += first_cell;
    first_cell += num_cells_in[r];
  }
  return in;
}

}  // namespace

CellBlock block_of(MeshParts& parts, std::size_t width, std::vector<std::string>& notices) {
  SerialMesh& mesh = parts.mesh;
  CellBlock block;
  block.width = width;
  block.values = values_of_cells(mesh, width);
  block.numbers.resize(mesh.num_cells());
  std::iota(block.numbers.begin(), block.numbers.end(), static_cast<std::int64_t>(parts.first_cell));
  std::optional<PartSearch> search;
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    add_marks(mesh.groups[g], static_cast<int>(g), search, mesh.cells, block.marks, notices);
  }
  std::ranges::stable_sort(block.marks, {}, &CellMark::cell);
  block.corners.assign(mesh.cells.begin(), mesh.cells.end());
  mesh.cells = {};
  mesh.mid_nodes = {};
  mesh.groups = {};
  mesh.cell_data = {};
  return block;
}

CellBlock sent(MPI_Comm comm, const CellBlock& block, const std::vector<std::vector<PetscInt>>& cells,
               std::vector<int>& num_in) {
  std::vector<int> num_out;
  for (const auto& list : cells) num_out.push_back(static_cast<int>(list.size()));
  num_in = exchanged_counts(comm, num_out);
  const auto moved = [&](const auto& all, std::size_t width) {
    return exchanged(comm, rows_of(all, width, cells), num_out, num_in, width);
  };
  CellBlock result;
  result.width = block.width;
  result.corners = moved(block.corners, 4);
  result.numbers = moved(block.numbers, 1);
  if (block.width > 0) result.values = moved(block.values, block.width);
  result.marks = sent_marks(comm, block.marks, cells, num_in);
  return result;
}

void fetch_vertices(MPI_Comm comm, std::span<const double> held, CellBlock& block) {
  block.vertices = block.corners;
  std::ranges::sort(block.vertices);
  block.vertices.erase(std::unique(block.vertices.begin(), block.vertices.end()), block.vertices.end());
  const std::vector<std::int64_t> num_held = gathered(comm, std::vector{static_cast<std::int64_t>(held.size() / 3)});
  std::vector<std::int64_t> first{0};
  std::partial_sum(num_held.begin(), num_held.end(), std::back_inserter(first));
  // Each rank asks the holders, who answer in the order of the questions.
  std::vector<int> num_asked, num_answered;
  for (std::size_t r = 0; r < num_held.size(); ++r) {
    num_asked.push_back(static_cast<int>(index_of(block.vertices, first[r + 1]) - index_of(block.vertices, first[r])));
  }
  num_answered = exchanged_counts(comm, num_asked);
  const std::int64_t offset = first[static_cast<std::size_t>(rank(comm))];
  std::vector<double> answers;
  for (const std::int64_t vertex : exchanged(comm, block.vertices, num_asked, num_answered)) {
    const double* x = &held[3 * static_cast<std::size_t>(vertex - offset)];
    answers.insert(answers.end(), x, x + 3);
  }
  block.coordinates = exchanged(comm, answers, num_answered, num_asked, 3);
}

}  // namespace pliant
