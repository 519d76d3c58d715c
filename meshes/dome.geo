// A quarter of a rubber cap: a part of a hollow sphere about the origin, cut off at an angle from the z axis, in millimetres.
// Groups: volume `cap`; surfaces `outside`, `inside`, `rim`, `xz` (y = 0), `yz` (x = 0).
SetFactory("OpenCASCADE");
DefineConstant[ along = {10, Name "Elements from the crown to the rim"} ];
Mesh.ElementOrder = 2;  // edges follow the spheres
Mesh.SecondOrderLinear = 0;
inner = 39;
outer = 41;
half_angle = Pi / 6;
eps = 1e-3;

Point(1) = {0, 0, 0};
Point(2) = {0, 0, inner};
Point(3) = {0, 0, outer};
Point(4) = {outer * Sin(half_angle), 0, outer * Cos(half_angle)};
Point(5) = {inner * Sin(half_angle), 0, inner * Cos(half_angle)};
Line(1) = {2, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Delete{ Point{1}; }
cap[] = Extrude{ {0, 0, 1}, {0, 0, 0}, Pi / 2 }{ Surface{1}; };

Physical Volume("cap") = {cap[1]};
all() = Boundary{ Volume{cap[1]}; };
xz() = Surface In BoundingBox{-eps, -eps, -eps, outer + eps, eps, outer + eps};
yz() = Surface In BoundingBox{-eps, -eps, -eps, eps, outer + eps, outer + eps};
rim() = Surface In BoundingBox{-eps, -eps, -eps, outer + eps, outer + eps, outer * Cos(half_angle) + eps};
inside() = Surface In BoundingBox{-eps, -eps, -eps, inner * Sin(half_angle) + eps, inner * Sin(half_angle) + eps, inner + eps};
Physical Surface("xz") = {xz[]};
Physical Surface("yz") = {yz[]};
Physical Surface("rim") = {rim[]};
Physical Surface("inside") = {inside[]};
rest() = all[];
rest() -= {xz[], yz[], rim[], inside[]};
Physical Surface("outside") = {rest[]};

Mesh.MeshSizeMin = outer * half_angle / along;
Mesh.MeshSizeMax = outer * half_angle / along;
