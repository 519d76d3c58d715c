// An eighth of a hollow sphere about the origin, radii 8 and 10, in millimetres.
// Groups: volume `shell`; surfaces `inner`, `outer`, `yz` (x = 0), `xz` (y = 0), `xy` (z = 0).
// Coarser or finer: `gmsh -3 meshes/hollow_sphere.geo -setnumber through 3`.
SetFactory("OpenCASCADE");
DefineConstant[ through = {2, Name "Elements through the wall"} ];
Mesh.ElementOrder = 2;  // edges follow the spheres
Mesh.SecondOrderLinear = 0;
inner = 8;
outer = 10;
eps = 1e-3;

Sphere(1) = {0, 0, 0, outer, 0, Pi / 2, Pi / 2};
Sphere(2) = {0, 0, 0, inner, 0, Pi / 2, Pi / 2};
shell() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };

Physical Volume("shell") = {shell[]};
yz() = Surface In BoundingBox{-eps, -eps, -eps, eps, outer + eps, outer + eps};
xz() = Surface In BoundingBox{-eps, -eps, -eps, outer + eps, eps, outer + eps};
xy() = Surface In BoundingBox{-eps, -eps, -eps, outer + eps, outer + eps, eps};
hollow() = Surface In BoundingBox{-eps, -eps, -eps, inner + eps, inner + eps, inner + eps};
all() = Boundary{ Volume{shell[]}; };
Physical Surface("yz") = {yz[]};
Physical Surface("xz") = {xz[]};
Physical Surface("xy") = {xy[]};
Physical Surface("inner") = {hollow[]};
rest() = all[];
rest() -= {yz[], xz[], xy[], hollow[]};
Physical Surface("outer") = {rest[]};

Mesh.MeshSizeMin = (outer - inner) / through;
Mesh.MeshSizeMax = (outer - inner) / through;
