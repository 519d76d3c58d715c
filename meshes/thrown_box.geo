// A box of 100 x 60 x 20 mm about the origin; drawn in millimetres. Group: volume `box`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {10, Name "Size of the elements"} ];
Box(1) = {-50, -30, -10, 100, 60, 20};
Physical Volume("box") = {1};
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
