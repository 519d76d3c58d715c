// A quarter of Scordelis and Lo's roof: a cylinder of radius 25 and length 50 over 80 degrees, as a surface. Its symmetry
// planes are x = 0 (ridge) and z = 0 (middle); the wall is at `end`, and `edge` is free.
radius = 25;
angle = 40 * Pi / 180;
size = 2.5;

Point(1) = {0, 0, 0, size};
Point(2) = {0, radius, 0, size};
Point(3) = {radius * Sin(angle), radius * Cos(angle), 0, size};
Circle(1) = {2, 1, 3};
roof[] = Extrude {0, 0, 25} { Curve{1}; };

Physical Surface("roof") = {roof[1]};
Physical Curve("middle") = {1};
Physical Curve("end") = {roof[0]};
Physical Curve("ridge") = {roof[3]};
Physical Curve("edge") = {roof[2]};
