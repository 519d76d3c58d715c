// Two unit cubes above one another, 0.1 mm apart; their meshes do not match.
// Groups: volumes `lower`, `upper`; surfaces `left` (x = 0), `front` (y = 0), `bottom`, `lid`, and where the cubes meet
// `lower_face`, `upper_face`.
DefineConstant[ coarse = {0.3, Name "Size of the lower cube's cells"}, fine = {0.22, Name "Size of the upper cube's cells"} ];
SetFactory("OpenCASCADE");
gap = 1e-4;
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {0, 0, 1 + gap, 1, 1, 1};
MeshSize{ PointsOf{ Volume{1}; } } = coarse;
MeshSize{ PointsOf{ Volume{2}; } } = fine;
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
Physical Surface("left") = {1, 7};
Physical Surface("front") = {3, 9};
Physical Surface("bottom") = {5};
Physical Surface("lid") = {12};
Physical Surface("lower_face") = {6};
Physical Surface("upper_face") = {11};
