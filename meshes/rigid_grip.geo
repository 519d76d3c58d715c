// A soft bar between two blocks that the input makes rigid.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.2, 0.1, 0.1};
Box(2) = {0.2, 0, 0, 0.4, 0.1, 0.1};
Box(3) = {0.6, 0, 0, 0.2, 0.1, 0.1};
BooleanFragments{ Volume{1, 2, 3}; Delete; }{}
MeshSize{ PointsOf{ Volume{1, 2, 3}; } } = 0.06;
Physical Volume("palm") = {1};
Physical Volume("bar") = {2};
Physical Volume("tip") = {3};
