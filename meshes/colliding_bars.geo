// Two bars of 10 x 1 x 1 m in a row, 10 mm apart. Groups: volumes `left`, `right`.
DefineConstant[ n = {20, Name "Elements along a bar"} ];
SetFactory("OpenCASCADE");
Box(1) = {-10.005, 0, 0, 10, 1, 1};
Box(2) = {0.005, 0, 0, 10, 1, 1};
MeshSize{:} = 10.0 / n;
Physical Volume("left") = {1};
Physical Volume("right") = {2};
