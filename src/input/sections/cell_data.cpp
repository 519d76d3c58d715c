#include "input/sections/cell_data.hpp"

namespace pliant {

Format<CellDataName> cell_data_format() {
  return map_of(Section<CellDataName>{
      {field("cell_data", &CellDataName::cell_data, text(), "name of $ElementData of the mesh file").required()}});
}

}  // namespace pliant
