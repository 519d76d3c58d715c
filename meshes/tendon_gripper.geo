// A palm with two fingers above a ball, drawn in millimetres. Groups: volumes `palm`, `fingers` and `ball`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {3.5, Name "Size of the elements of the fingers [mm]"} ];
Box(1) = {-28, -10, 62, 56, 20, 8};
// A finger becomes thinner towards its tip.
Point(101) = {18, -10, 62};
Point(102) = {28, -10, 62};
Point(103) = {23, -10, 4};
Point(104) = {18, -10, 4};
Line(101) = {101, 102};
Line(102) = {102, 103};
Line(103) = {103, 104};
Line(104) = {104, 101};
Curve Loop(101) = {101, 102, 103, 104};
Plane Surface(101) = {101};
finger[] = Extrude{0, 20, 0}{ Surface{101}; };
other[] = Symmetry{1, 0, 0, 0}{ Duplicata{ Volume{finger[1]}; } };
// Palm and fingers share the nodes between them.
BooleanFragments{ Volume{1, finger[1], other[0]}; Delete; }{}
Sphere(10) = {0, 0, 15.2, 15};
Physical Volume("palm") = {1};
Physical Volume("fingers") = {2, 3};
Physical Volume("ball") = {10};
MeshSize{ PointsOf{ Volume{1, 2, 3}; } } = size;
MeshSize{ PointsOf{ Volume{10}; } } = 6;
