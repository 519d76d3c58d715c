// A pneumatic bending actuator of 78 mm: five hollow pleats joined by an air channel, on a floor that does not stretch
// as easily. x from the mount (x = 0) to the tip, y across, z up. Lengths in millimetres (`scale: 0.001` under `mesh:`
// in the input file turns them into metres).
// Groups: volume `actuator`; surfaces `mount`, `tip`, `chamber` (all walls that the air touches).
// Coarser or finer: `gmsh -3 meshes/pneumatic_actuator.geo -setnumber size 3`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {5, Name "Element size [mm]"} ];

num_pleats = 5;
pleat = 10;        // length of a pleat
gap = 4;           // between two pleats
wall = 2;          // around a chamber
floor = 4;         // below the chambers
spine = 9;         // height of the body between the pleats
block = 10;        // length of the mounting block
width = 20;
height = 22;
channel = 6;       // width of the air channel
eps = 0.01;

length = block + num_pleats * pleat + (num_pleats - 1) * gap + 2;
first = block + wall;                                              // where the air begins
last = block + num_pleats * pleat + (num_pleats - 1) * gap - wall;  // and ends

Box(1) = {0, -width / 2, 0, length, width, spine};
Box(2) = {0, -width / 2, 0, block, width, height};
Box(3) = {first, -channel / 2, floor, last - first, channel, spine - floor - wall};
solid[] = {2};
air[] = {};
For i In {0 : num_pleats - 1}
  x = block + i * (pleat + gap);
  v = newv;
  Box(v) = {x, -width / 2, 0, pleat, width, height};
  solid[] += v;
  v = newv;
  Box(v) = {x + wall, -width / 2 + wall, floor, pleat - 2 * wall, width - 2 * wall, height - floor - wall};
  air[] += v;
EndFor
body() = BooleanUnion{ Volume{1}; Delete; }{ Volume{solid[]}; Delete; };
hollow() = BooleanUnion{ Volume{3}; Delete; }{ Volume{air[]}; Delete; };
actuator() = BooleanDifference{ Volume{body[]}; Delete; }{ Volume{hollow[]}; Delete; };

Physical Volume("actuator") = {actuator[]};
mount() = Surface In BoundingBox{-eps, -width, -eps, eps, width, height + eps};
tip() = Surface In BoundingBox{length - eps, -width, -eps, length + eps, width, height};
chamber() = Surface In BoundingBox{first - eps, -width / 2 + wall - eps, floor - eps, last + eps, width / 2 - wall + eps, height - wall + eps};
Physical Surface("mount") = {mount[]};
Physical Surface("tip") = {tip[]};
Physical Surface("chamber") = {chamber[]};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
