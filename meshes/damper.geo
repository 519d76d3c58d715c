// A rubber pad of 40 x 20 x 6 mm between two plates, in millimetres.
// Groups: volume `pad`; surfaces `fixed` (z = 0) and `moved` (z = 6).
SetFactory("OpenCASCADE");
DefineConstant[ size = {3, Name "Element size [mm]"} ];

Box(1) = {0, 0, 0, 40, 20, 6};

eps = 1e-3;
Physical Volume("pad") = {1};
Physical Surface("fixed") = {Surface In BoundingBox{-eps, -eps, -eps, 40 + eps, 20 + eps, eps}};
Physical Surface("moved") = {Surface In BoundingBox{-eps, -eps, 6 - eps, 40 + eps, 20 + eps, 6 + eps}};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
