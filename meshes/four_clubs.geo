// Four clubs in a row against x, each two balls of radii 40 and 24 mm on a rod, standing on z = 0 (in metres).
// Groups: volumes `club_1` to `club_4`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {0.011, Name "Size of the elements"} ];
For n In {1:4}
  x = 0.12 * (2.5 - n);
  ball = newv; Sphere(ball) = {x, 0, 0.04, 0.04};
  rod = newv; Cylinder(rod) = {x, 0, 0.05, 0, 0, 0.085, 0.014};
  top = newv; Sphere(top) = {x, 0, 0.135, 0.024};
  club() = BooleanUnion{ Volume{ball}; Delete; }{ Volume{rod, top}; Delete; };
  Physical Volume(Sprintf("club_%g", n), n) = {club[]};
EndFor
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
