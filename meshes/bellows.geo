// Half of a bellows, cut along y = 0, around the z axis: a wall that zigzags between two radii; drawn in millimetres.
// Groups: volume `bellows`; surfaces `foot` (z = 0), `lid` (the upper end), `cut` (y = 0).
SetFactory("OpenCASCADE");
DefineConstant[ pleats = {4, Name "Number of pleats"}, pitch = {9, Name "Height of a pleat [mm]"},
                inner = {12, Name "Inner radius [mm]"}, outer = {21, Name "Outer radius [mm]"},
                wall = {1.6, Name "Thickness of the wall [mm]"}, size = {2.4, Name "Size of the elements [mm]"} ];
half = pitch/2;
slant = Hypot(outer - inner, half);
across = wall*slant/(outer - inner)/2;  // half the thickness of the wall, measured along z
height = pleats*pitch;
// The inner side from the foot up, then the outer side from the lid down; flat ends at z = 0 and at the height.
Point(1) = {inner, 0, 0};
n = 1;
For i In {1:2*pleats - 1}
  n += 1;
  If (i % 2 == 1)
    Point(n) = {outer - wall, 0, half*i};
  Else
    Point(n) = {inner, 0, half*i};
  EndIf
EndFor
n += 1;
Point(n) = {inner, 0, height};
n += 1;
Point(n) = {inner + wall, 0, height};
For i In {2*pleats - 1:1:-1}
  n += 1;
  If (i % 2 == 1)
    Point(n) = {outer, 0, half*i};
  Else
    Point(n) = {inner + wall, 0, half*i};
  EndIf
EndFor
n += 1;
Point(n) = {inner + wall, 0, 0};
For i In {1:n}
  Line(i) = {i, i % n + 1};
EndFor
Curve Loop(1) = {1:n};
Plane Surface(1) = {1};
Extrude{ {0, 0, 1}, {0, 0, 0}, Pi }{ Surface{1}; }
eps = 1e-3;
Physical Volume("bellows") = {1};
Physical Surface("foot") = Surface In BoundingBox{-2*outer, -2*outer, -eps, 2*outer, 2*outer, eps};
Physical Surface("lid") = Surface In BoundingBox{-2*outer, -2*outer, height - eps, 2*outer, 2*outer, height + eps};
Physical Surface("cut") = Surface In BoundingBox{-2*outer, -eps, -eps, 2*outer, eps, height + eps};
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
