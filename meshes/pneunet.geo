// Half of a PneuNet finger of 60 mm, cut by its plane of symmetry y = 0: hollow pleats that a channel joins, over a floor that
// stretches less. x from the mount (x = 0) to the tip, z up. Lengths in millimetres (`scale: 0.001` under `mesh:` in the
// input). Drawn by gmsh's OpenCASCADE kernel, as a CAD program does it: boxes are joined, and others are cut out.
// Groups: volume `finger`; surfaces `mount`, `middle` (the plane of symmetry), `chamber` (all walls that the air touches),
// `palm` (below, where the finger holds things).
// As a STEP file for a CAD program: gmsh meshes/pneunet.geo -0 -o pneunet.step
SetFactory("OpenCASCADE");
DefineConstant[ size = {6, Name "Element size [mm]"} ];
DefineConstant[ num_pleats = {4, Name "Pleats"} ];
DefineConstant[ wall = {1.6, Name "Walls of the pleats [mm]"} ];

pleat = 9;     // length of a pleat
gap = 3;       // between two pleats
floor = 3;     // below the chambers
spine = 8;     // height of the body between the pleats
block = 10;    // length of the mounting block
half = 9;      // half of the width
height = 18;
channel = 3;   // half of the channel's width
eps = 0.01;

pitch = pleat + gap;
length = block + num_pleats * pitch - gap + 5;
last = block + num_pleats * pitch - gap - wall;  // where the air ends

Box(1) = {0, 0, 0, length, half, spine};
Box(2) = {0, 0, 0, block, half, height};
Box(3) = {block + wall, 0, floor, last - block - wall, channel, spine - floor - wall};
solid[] = {2};
air[] = {};
For i In {0 : num_pleats - 1}
  x = block + i * pitch;
  v = newv;
  Box(v) = {x, 0, 0, pleat, half, height};
  solid[] += v;
  v = newv;
  Box(v) = {x + wall, 0, floor, pleat - 2 * wall, half - wall, height - floor - wall};
  air[] += v;
EndFor
body() = BooleanUnion{ Volume{1}; Delete; }{ Volume{solid[]}; Delete; };
hollow() = BooleanUnion{ Volume{3}; Delete; }{ Volume{air[]}; Delete; };
finger() = BooleanDifference{ Volume{body[]}; Delete; }{ Volume{hollow[]}; Delete; };

Physical Volume("finger") = {finger[]};
mount() = Surface In BoundingBox{-eps, -eps, -eps, eps, half + eps, height + eps};
middle() = Surface In BoundingBox{-eps, -eps, -eps, length + eps, eps, height + eps};
palm() = Surface In BoundingBox{-eps, -eps, -eps, length + eps, half + eps, eps};
inside() = Surface In BoundingBox{block + wall - eps, -eps, floor - eps, last + eps, half - wall + eps, height - wall + eps};
chamber[] = inside[];
chamber[] -= middle[];
Physical Surface("mount") = {mount[]};
Physical Surface("middle") = {middle[]};
Physical Surface("palm") = {palm[]};
Physical Surface("chamber") = {chamber[]};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
