// The elastic flag of Turek and Hron's structure benchmarks, one layer of elements thick, in metres. Its left end is the arc
// where it meets the cylinder with centre (0.2, 0.2) and radius 0.05; its right end lies at x = 0.6.
// Groups: volume `flag`; surfaces `root` (the arc) and `faces` (both sides of the layer).
DefineConstant[
  along = {70, Name "Elements along the flag"},
  across = {4, Name "Elements across the flag"}
];
radius = 0.05;
half = 0.01;
thickness = 0.005;
corner = 0.2 + Sqrt(radius^2 - half^2);

Point(1) = {corner, 0.2 - half, 0};
Point(2) = {0.6, 0.2 - half, 0};
Point(3) = {0.6, 0.2 + half, 0};
Point(4) = {corner, 0.2 + half, 0};
Point(5) = {0.2, 0.2, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Circle(4) = {4, 5, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = along + 1;
Transfinite Curve {2, 4} = across + 1;
Transfinite Surface {1} = {1, 2, 3, 4} Alternate;
layer[] = Extrude {0, 0, thickness} { Surface{1}; Layers{1}; };

Physical Volume("flag") = {layer[1]};
Physical Surface("root") = {layer[5]};
Physical Surface("faces") = {1, layer[0]};
