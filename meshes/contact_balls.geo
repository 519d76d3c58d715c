// Quarters of two half balls of radius 50 mm above one another, `gap` apart; fine where they touch. Lengths in mm.
// Groups: volumes `lower`, `upper`; surfaces `yz` (x = 0), `xz` (y = 0), `bottom`, `lid`, the planes through the centres.
SetFactory("OpenCASCADE");
DefineConstant[ fine = {2.4, Name "Size of the elements at the contact"}, gap = 0.02 ];
Mesh.ElementOrder = 2;  // edges follow the spheres
Mesh.SecondOrderLinear = 0;
R = 50;
z = R + gap / 2;
eps = 1e-3;
Sphere(1) = {0, 0, -z, R, 0, Pi / 2, Pi / 2};
Sphere(2) = {0, 0, z, R, -Pi / 2, 0, Pi / 2};
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
yz() = Surface In BoundingBox{-eps, -eps, -2 * R, eps, 2 * R, 2 * R};
xz() = Surface In BoundingBox{-eps, -eps, -2 * R, 2 * R, eps, 2 * R};
bottom() = Surface In BoundingBox{-eps, -eps, -z - eps, 2 * R, 2 * R, -z + eps};
lid() = Surface In BoundingBox{-eps, -eps, z - eps, 2 * R, 2 * R, z + eps};
Physical Surface("yz") = {yz[]};
Physical Surface("xz") = {xz[]};
Physical Surface("bottom") = {bottom[]};
Physical Surface("lid") = {lid[]};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.35 * max(sqrt(x^2 + y^2 + z^2) - 11, 0)", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
