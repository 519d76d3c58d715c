// The unit cube as two bodies that meet at z = 1/2 and share no node; their meshes do not match.
// Groups: volumes `lower`, `upper`; surfaces `left` (x = 0), `front` (y = 0), `bottom` (z = 0), `lid` (z = 1), and where
// the bodies meet `lower_face`, `upper_face`.
DefineConstant[ coarse = {0.3, Name "Size of the lower body's cells"}, fine = {0.22, Name "Size of the upper body's cells"} ];

SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.5};
Box(2) = {0, 0, 0.5, 1, 1, 0.5};
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
