// Cook's membrane, one layer of elements thick, in millimetres.
// Groups: volume `membrane`; surfaces `clamp` (x = 0), `end` (x = 48) and `faces` (both sides of the layer).
DefineConstant[ n = {16, Name "Elements along each side"} ];

Point(1) = {0, 0, 0};
Point(2) = {48, 44, 0};
Point(3) = {48, 60, 0};
Point(4) = {0, 44, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 2, 3, 4} = n + 1;
Transfinite Surface {1} = {1, 2, 3, 4} Alternate;
layer[] = Extrude {0, 0, 1} { Surface{1}; Layers{1}; };

Physical Volume("membrane") = {layer[1]};
Physical Surface("clamp") = {layer[5]};
Physical Surface("end") = {layer[3]};
Physical Surface("faces") = {1, layer[0]};
