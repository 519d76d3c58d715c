#include "energy/volume/body_points.hpp"

#include "energy/volume/body_cells.hpp"

namespace pliant {

template <int Order>
std::vector<PackPlaces> places_of_points(const NodeLayout& layout, const CellGroups<Order>& groups, int body) {
  std::vector<PackPlaces> places;
  BodyCells<Order>(groups, body, layout.num_owned_nodes).for_each_batch([&](const CellBatch<Order>& batch) {
    for (const auto& xi : batch.group.rule.points) {
      const auto N = Tet<Order>::values(xi);
      PackPlaces& place = places.emplace_back();
      place.X = {};
      for (int lane = 0; lane < pack_size; ++lane) {
        const int real_lane = lane < batch.batch().num_lanes ? lane : 0;
        place.cell[lane] = batch.group.cells[batch.number * pack_size + real_lane];
        for (int a = 0; a < Tet<Order>::num_nodes; ++a) {
          const PetscInt node = batch.batch().nodes[a][lane];
          for (int i = 0; i < 3; ++i) place.X[lane][i] += N[a] * layout.coordinates[3 * node + i];
        }
      }
    }
  });
  return places;
}

template std::vector<PackPlaces> places_of_points<1>(const NodeLayout&, const CellGroups<1>&, int);
template std::vector<PackPlaces> places_of_points<2>(const NodeLayout&, const CellGroups<2>&, int);

}  // namespace pliant
