#include "study/strained_mesh.hpp"

#include "petsc/array_view.hpp"

namespace pliant {

void strain(std::array<std::size_t, 2> entry, double amount, std::span<double> places) {
  const auto [i, j] = entry;
  for (std::size_t first = 0; first < places.size(); first += 3) {
    const double by = amount * places[first + j];  // before it changes, if i = j
    places[first + i] += by;
  }
}

StrainedMesh::StrainedMesh(const Mesh& mesh, std::array<std::size_t, 2> entry, double amount) {
  check(DMGetCoordinatesLocal(mesh.dm.get(), &coordinates_));
  check(VecDuplicate(coordinates_, before_.out()));
  check(VecCopy(coordinates_, before_.get()));
  const ArrayView x(coordinates_);
  strain(entry, amount, x.span());
}

StrainedMesh::~StrainedMesh() {
  (void)VecCopy(before_.get(), coordinates_);
}

}  // namespace pliant
