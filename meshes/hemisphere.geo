// A quarter of a hemisphere of radius 10 with a hole of 18 degrees at its pole, as a surface: x, y, z > 0.
// Groups: surface `hemisphere`; curves `xz` (y = 0) and `yz` (x = 0); points `outwards` (10, 0, 0) and `inwards` (0, 10, 0).
radius = 10;
hole = 18 * Pi / 180;
n = 16;   // squares along each side
Point(1) = {0, 0, 0}; Point(2) = {radius, 0, 0}; Point(3) = {radius * Sin(hole), 0, radius * Cos(hole)};
Circle(1) = {2, 1, 3};
shell[] = Extrude {{0, 0, 1}, {0, 0, 0}, Pi / 2} { Curve{1}; };
Transfinite Curve{1, shell[0], shell[2], shell[3]} = n + 1;
Transfinite Surface{shell[1]};
Physical Surface("hemisphere") = {shell[1]};
Physical Curve("xz") = {1};
Physical Curve("yz") = {shell[0]};
Physical Point("outwards") = {2};
Physical Point("inwards") = Point In BoundingBox {-0.1, 9.9, -0.1, 0.1, 10.1, 0.1};
