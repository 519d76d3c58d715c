// Four blocks of about 1 m above one another, 1 mm apart, each a little smaller than the one below; their meshes do not
// match. Groups: volumes `a` (the lowest), `b`, `c`, `d`; surface `ground`.
SetFactory("OpenCASCADE");
For k In {0:3}
  Box(k + 1) = {0.02 * k, 0.01 * k, 1.001 * k, 1 - 0.04 * k, 1 - 0.02 * k, 1};
  MeshSize{ PointsOf{ Volume{k + 1}; } } = 0.34 + 0.04 * k;
EndFor
Physical Volume("a") = {1};
Physical Volume("b") = {2};
Physical Volume("c") = {3};
Physical Volume("d") = {4};
Physical Surface("ground") = {5};
