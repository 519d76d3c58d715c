/// gmsh's numbering of element types.
#pragma once

#include <array>
#include <string>

namespace pliant {

struct ElementType {
  const char* name = nullptr;  ///< null: unknown type
  int dimension = 0;
  int num_nodes = 0;
};

/// Indexed by gmsh's element type; the first 31 are those that its meshers write up to order 5.
inline constexpr std::array<ElementType, 32> element_types{{
    {},
    {"2-node line", 1, 2},
    {"3-node triangle", 2, 3},
    {"4-node quadrangle", 2, 4},
    {"4-node tetrahedron", 3, 4},
    {"8-node hexahedron", 3, 8},
    {"6-node prism", 3, 6},
    {"5-node pyramid", 3, 5},
    {"3-node line", 1, 3},
    {"6-node triangle", 2, 6},
    {"9-node quadrangle", 2, 9},
    {"10-node tetrahedron", 3, 10},
    {"27-node hexahedron", 3, 27},
    {"18-node prism", 3, 18},
    {"14-node pyramid", 3, 14},
    {"point", 0, 1},
    {"8-node quadrangle", 2, 8},
    {"20-node hexahedron", 3, 20},
    {"15-node prism", 3, 15},
    {"13-node pyramid", 3, 13},
    {"9-node triangle", 2, 9},
    {"10-node triangle", 2, 10},
    {"12-node triangle", 2, 12},
    {"15-node triangle", 2, 15},
    {"15-node triangle of order 5", 2, 15},
    {"21-node triangle", 2, 21},
    {"4-node line", 1, 4},
    {"5-node line", 1, 5},
    {"6-node line", 1, 6},
    {"20-node tetrahedron", 3, 20},
    {"35-node tetrahedron", 3, 35},
    {"56-node tetrahedron", 3, 56},
}};

inline constexpr int triangle_3 = 2;
inline constexpr int tetrahedron_4 = 4;
inline constexpr int tetrahedron_10 = 11;

/// Simplices of order 1 and 2, the only ones that Pliant uses.
constexpr bool is_usable(int type) {
  return type == 15 || type == 1 || type == 8 || type == 2 || type == 9 || type == tetrahedron_4 ||
         type == tetrahedron_10;
}

}  // namespace pliant
