// A ball of radius 1 m about the origin. Groups: volume `ball`; surface `skin`.
SetFactory("OpenCASCADE");
Mesh.ElementOrder = 2;  // edges follow the sphere
Mesh.SecondOrderLinear = 0;
Sphere(1) = {0, 0, 0, 1};
Physical Volume("ball") = {1};
Physical Surface("skin") = {1};
Mesh.MeshSizeMax = 0.5;
