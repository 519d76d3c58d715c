// A square of 1 m in the plane z = 0.
// Groups: surface `plate`; curves `left` (x = 0), `right` (x = 1), `front` (y = 0), `back` (y = 1); point `middle` of the
// edge `left`.
size = 1 / 16;
Point(1) = {0, 0, 0, size}; Point(2) = {1, 0, 0, size}; Point(3) = {1, 1, 0, size}; Point(4) = {0, 1, 0, size};
Point(5) = {0, 0.5, 0, size}; Point(6) = {0.5, 0.5, 0, size};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 1};
Curve Loop(1) = {1, 2, 3, 4, 5};
Plane Surface(1) = {1};
Point{6} In Surface{1};
Physical Surface("plate") = {1};
Physical Curve("left") = {4, 5};
Physical Curve("right") = {2};
Physical Curve("front") = {1};
Physical Curve("back") = {3};
Physical Point("middle") = {5};
