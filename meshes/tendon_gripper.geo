// A rigid palm with two soft fingers, and a ball between them. Lengths in millimetres.
SetFactory("OpenCASCADE");
Box(1) = {-32, -10, 62, 64, 20, 10};  // palm
Box(2) = {-30, -10, 2, 8, 20, 60};    // fingers
Box(3) = {22, -10, 2, 8, 20, 60};
BooleanFragments{ Volume{1, 2, 3}; Delete; }{}
Physical Volume("palm") = {1};
Physical Volume("fingers") = {2, 3};
MeshSize{ PointsOf{ Volume{1, 2, 3}; } } = 5;
