// An eighth of a cylinder of radius 300 and length 600, as a surface: x, y, z > 0, its axis along z.
// Groups: surface `cylinder`; curves `side` (y = 0), `top` (x = 0), `middle` (z = 0), `diaphragm` (z = 300); point `loaded`, where
// the top is in the middle.
radius = 300;
n = 32;   // squares along each side
Point(1) = {0, 0, 0}; Point(2) = {radius, 0, 0}; Point(3) = {0, radius, 0};
Circle(1) = {2, 1, 3};
cylinder[] = Extrude {0, 0, 300} { Curve{1}; };
Transfinite Curve{1, cylinder[0], cylinder[2], cylinder[3]} = n + 1;
Transfinite Surface{cylinder[1]} Right;
Physical Surface("cylinder") = {cylinder[1]};
Physical Curve("middle") = {1};
Physical Curve("diaphragm") = {cylinder[0]};
Physical Curve("side") = Curve In BoundingBox {299, -1, -1, 301, 1, 301};
Physical Curve("top") = Curve In BoundingBox {-1, 299, -1, 1, 301, 301};
Physical Point("loaded") = {3};
