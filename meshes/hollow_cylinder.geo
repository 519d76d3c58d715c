// A quarter of a slice of a hollow cylinder about z, radii 5 and 10.
// Groups: volume `tube`; surfaces `inner`, `outer`, `xz` (y = 0), `yz` (x = 0) and `ends` (both sides of the slice).
DefineConstant[ radial = {4, Name "Elements through the wall"} ];
DefineConstant[ around = {6, Name "Elements around the quarter"} ];
DefineConstant[ inner = {5, Name "Inner radius"}, outer = {10, Name "Outer radius"} ];
Mesh.ElementOrder = 2;  // edges follow the circles

Point(1) = {0, 0, 0};
Point(2) = {inner, 0, 0};
Point(3) = {outer, 0, 0};
Point(4) = {0, outer, 0};
Point(5) = {0, inner, 0};
Line(1) = {2, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = radial + 1;
Transfinite Curve {2, 4} = around + 1;
Transfinite Surface {1} = {2, 3, 4, 5} Alternate;
slice[] = Extrude {0, 0, 1} { Surface{1}; Layers{1}; };

Physical Volume("tube") = {slice[1]};
Physical Surface("xz") = {slice[2]};
Physical Surface("outer") = {slice[3]};
Physical Surface("yz") = {slice[4]};
Physical Surface("inner") = {slice[5]};
Physical Surface("ends") = {1, slice[0]};
