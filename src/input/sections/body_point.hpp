/// How a place in a body is typed.
#pragma once

#include "input/body_point.hpp"
#include "input/schema.hpp"

namespace pliant {

/// `[x, y, z]`, or `{body: name, point: [x, y, z]}`.
Format<BodyPoint> body_point();

}  // namespace pliant
