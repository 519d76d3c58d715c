// A ball of radius 0.1 m, 0.5 mm above a plate. Groups: volumes `ball`, `plate`; surfaces `skin` (of the ball), `top` (of the plate).
SetFactory("OpenCASCADE");
Mesh.ElementOrder = 2;  // edges follow the sphere
Mesh.SecondOrderLinear = 0;
Sphere(1) = {0, 0, 0.1005, 0.1};
Box(2) = {-0.15, -0.15, -0.05, 0.8, 0.3, 0.05};
Physical Volume("ball") = {1};
Physical Volume("plate") = {2};
Physical Surface("skin") = {1};
Physical Surface("top") = {7};
MeshSize{ PointsOf{ Volume{1}; } } = 0.04;
MeshSize{ PointsOf{ Volume{2}; } } = 0.2;
Mesh.MeshSizeMax = 0.2;
