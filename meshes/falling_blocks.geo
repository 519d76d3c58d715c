// Three blocks of 30 x 20 x 20 mm, turned, one above the other, over a plate of 80 x 60 x 10 mm; drawn in millimetres.
// Groups: volumes `plate`, `low`, `middle`, `high`; surface `bottom` of the plate.
SetFactory("OpenCASCADE");
DefineConstant[ size = {6, Name "Size of the elements"} ];
Box(1) = {-40, -30, 0, 80, 60, 10};
For i In {0:2}
  Box(2 + i) = {-15, -10, 14 + 28*i, 30, 20, 20};
  Rotate {{0.3, 0.2, 1}, {0, 0, 24 + 28*i}, 0.35*(i + 1)} { Volume{2 + i}; }
EndFor
Physical Volume("plate") = {1};
Physical Volume("low") = {2};
Physical Volume("middle") = {3};
Physical Volume("high") = {4};
Physical Surface("bottom") = {5};
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
