// A drum that lies along y [m].
SetFactory("OpenCASCADE");
Cylinder(1) = {0, -0.06, 0, 0, 0.12, 0, 0.04};
Physical Volume("drum") = {1};
Physical Surface("ends") = {2, 3};
Mesh.MeshSizeMin = 0.012;
Mesh.MeshSizeMax = 0.012;
