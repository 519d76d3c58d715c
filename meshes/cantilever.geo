// A beam of 1 x 0.2 x 0.2 m along x, in metres.
// Groups: volume `beam`; surfaces `clamp` (x = 0) and `tip` (x = 1).
SetFactory("OpenCASCADE");
DefineConstant[ size = {0.05, Name "Element size [m]"} ];

Box(1) = {0, 0, 0, 1, 0.2, 0.2};

eps = 1e-6;
Physical Volume("beam") = {1};
Physical Surface("clamp") = {Surface In BoundingBox{-eps, -eps, -eps, eps, 0.2 + eps, 0.2 + eps}};
Physical Surface("tip") = {Surface In BoundingBox{1 - eps, -eps, -eps, 1 + eps, 0.2 + eps, 0.2 + eps}};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
