/// The rows of tied surfaces among other constraints.
#pragma once

#include "energy/constraint/linear_constraint.hpp"
#include "energy/constraint/tied_surfaces.hpp"

namespace pliant {

/// Adds the tie to other constraints, all of which are known by then. Where these make entries of the dependent surface
/// functions of one another (q = C y: partners of a periodic surface, an oblique plane), the rows are summed with C^T,
/// so that each unknown keeps one row. A node's component that is held otherwise (prescribed, or tied to something
/// else) has no row; its share of the tractions goes to its neighbours', which keeps constant averages. Where all
/// neighbours are held, too, the row remains and constrains the independent surface. Not collective.
void add_tie(Eliminator& eliminator, const SurfaceTie& tie);

}  // namespace pliant
