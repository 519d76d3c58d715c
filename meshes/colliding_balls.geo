// Quarters of two balls of radius 50 mm, `gap` apart; fine where they touch. Lengths in mm.
// Groups: volumes `lower`, `upper`; surfaces `yz` (x = 0), `xz` (y = 0).
SetFactory("OpenCASCADE");
DefineConstant[ fine = {3, Name "Size of the elements at the contact"}, gap = 0.05 ];
Mesh.ElementOrder = 2;  // edges follow the spheres
Mesh.SecondOrderLinear = 0;
R = 50;
z = R + gap / 2;
eps = 1e-3;
Sphere(1) = {0, 0, -z, R, -Pi / 2, Pi / 2, Pi / 2};
Sphere(2) = {0, 0, z, R, -Pi / 2, Pi / 2, Pi / 2};
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
yz() = Surface In BoundingBox{-eps, -eps, -3 * R, eps, 3 * R, 3 * R};
xz() = Surface In BoundingBox{-eps, -eps, -3 * R, 3 * R, eps, 3 * R};
Physical Surface("yz") = {yz[]};
Physical Surface("xz") = {xz[]};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.4 * max(sqrt(x^2 + y^2 + z^2) - 9, 0)", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
