// A quarter of the lower half of a ball of radius 1 m that stands on the origin, fine around it.
// Groups: volume `ball`; surfaces `yz` (x = 0), `xz` (y = 0), `top` (z = 1), `skin`.
// Coarser or finer: `gmsh -3 meshes/hertz_sphere.geo -setnumber fine 0.01`.
SetFactory("OpenCASCADE");
DefineConstant[ fine = {0.006, Name "Size of the elements at the contact"} ];
Mesh.ElementOrder = 2;  // edges follow the sphere
Mesh.SecondOrderLinear = 0;
eps = 1e-4;

Sphere(1) = {0, 0, 1, 1, -Pi / 2, 0, Pi / 2};
// The seam of the sphere ends at the origin: a point to measure distances from.
Physical Volume("ball") = {1};
yz() = Surface In BoundingBox{-eps, -eps, -eps, eps, 1 + eps, 1 + eps};
xz() = Surface In BoundingBox{-eps, -eps, -eps, 1 + eps, eps, 1 + eps};
top() = Surface In BoundingBox{-eps, -eps, 1 - eps, 1 + eps, 1 + eps, 1 + eps};
Physical Surface("yz") = {yz[]};
Physical Surface("xz") = {xz[]};
Physical Surface("top") = {top[]};
rest() = Boundary{ Volume{1}; };
rest() -= {yz[], xz[], top[]};
Physical Surface("skin") = {rest[]};

tip() = Point In BoundingBox{-eps, -eps, -eps, eps, eps, eps};
Field[1] = Distance;
Field[1].PointsList = {tip[]};
Field[2] = MathEval;
Field[2].F = Sprintf("%g + 0.3 * max(F1 - 0.035, 0)", fine);
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
