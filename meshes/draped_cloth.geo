// A square of fabric above a ball, and no node in common [m].
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 0.05};
Rectangle(100) = {-0.12, -0.12, 0.053, 0.24, 0.24};
Transfinite Curve {Boundary{ Surface{100}; }} = 15;
Transfinite Surface {100} Alternate;
Physical Volume("ball") = {1};
Physical Surface("sheet") = {100};
Mesh.MeshSizeMin = 0.018;
Mesh.MeshSizeMax = 0.018;
