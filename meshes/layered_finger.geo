// A soft finger of 80 x 16 x 16 mm with a chamber of 70 x 10 x 8 mm in it, in millimetres.
// Groups: volume `finger`; surfaces `mount` (x = 0), `chamber` (its walls), `palm_side` (z = 0, for an inextensible layer).
SetFactory("OpenCASCADE");
Box(1) = {0, -8, 0, 80, 16, 16};
Box(2) = {5, -5, 5, 70, 10, 8};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
e = 1e-3;
Physical Volume("finger") = {3};
Physical Surface("mount") = Surface In BoundingBox {-e, -9, -e, e, 9, 17};
Physical Surface("palm_side") = Surface In BoundingBox {-e, -9, -e, 81, 9, e};
Physical Surface("chamber") = Surface In BoundingBox {5 - e, -5 - e, 5 - e, 75 + e, 5 + e, 13 + e};
Mesh.MeshSizeMax = 5;
