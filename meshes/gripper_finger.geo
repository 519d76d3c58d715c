// A pneumatic soft gripper finger, 120 mm long: nine hollow pleats on a flat pad, an air channel, a mounting block.
//   x from the mount (x = 0) to the tip, y across, z from the pad (z = 0) up to the pleats. Lengths in millimetres
// (`scale: 0.001` under `mesh:` in the input file turns them into metres).
// Groups: volume `finger`; surfaces `mount`, `pad` (the gripping side), `tip` (the nose), `inside` (air chambers).
// Coarser or finer: `gmsh -3 meshes/gripper_finger.geo -setnumber size 3`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {2.2, Name "Element size [mm]"} ];

num_pleats = 9;
pleat = 7;                  // length of a pleat
gap = 3.2;                  // between two pleats
wall = 1.8;                 // silicone around a chamber
floor = 3.2;                // pad thickness below the chambers
bore = 1.8;                 // radius of the air channel
spine = 9;                  // height of the body in the gaps
block = 18;                 // length of the mounting block
x_tip = 120;
width_root = 24;
width_tip = 16;
height_root = 25;
height_tip = 16;
height_block = 29;
round = 1.6;                // of the pleats' tops
fillet = 1;                 // of the outer edges
far = 200;
eps = 0.05;

// Side view, drawn at y = -far: along the pad, beyond the nose, back over pleats and gaps, up the mounting block.
r = 0.5 * gap;
p = newp;
Point(p) = {0, -far, 0};
Point(p + 1) = {far, -far, 0};
Point(p + 2) = {far, -far, spine};
Point(p + 3) = {block + num_pleats * (pleat + gap) + r, -far, spine};
start = p;
last = p + 3;
c = newc;
Line(c) = {p, p + 1};
Line(c + 1) = {p + 1, p + 2};
Line(c + 2) = {p + 2, p + 3};
side[] = {c : c + 2};
For i In {num_pleats - 1 : -1 : -1}  // -1: the mounting block
  x_right = block + (i + 1) * (pleat + gap);
  x_left = x_right - pleat;
  z_top = (i < 0) ? height_block : height_root + (height_tip - height_root) * i / (num_pleats - 1);
  p = newp;
  Point(p) = {x_right + r, -far, spine + r};
  Point(p + 1) = {x_right, -far, spine + r};
  Point(p + 2) = {x_right, -far, z_top - round};
  Point(p + 3) = {x_right - round, -far, z_top - round};
  Point(p + 4) = {x_right - round, -far, z_top};
  c = newc;
  Circle(c) = {last, p, p + 1};
  Line(c + 1) = {p + 1, p + 2};
  Circle(c + 2) = {p + 2, p + 3, p + 4};
  side[] += {c : c + 2};
  If (i >= 0)
    Point(p + 5) = {x_left + round, -far, z_top};
    Point(p + 6) = {x_left + round, -far, z_top - round};
    Point(p + 7) = {x_left, -far, z_top - round};
    Point(p + 8) = {x_left, -far, spine + r};
    Point(p + 9) = {x_left - r, -far, spine + r};
    Point(p + 10) = {x_left - r, -far, spine};
    Line(c + 3) = {p + 4, p + 5};
    Circle(c + 4) = {p + 5, p + 6, p + 7};
    Line(c + 5) = {p + 7, p + 8};
    Circle(c + 6) = {p + 8, p + 9, p + 10};
    side[] += {c + 3 : c + 6};
    last = p + 10;
  Else
    Point(p + 5) = {0, -far, z_top};
    Line(c + 3) = {p + 4, p + 5};
    Line(c + 4) = {p + 5, start};
    side[] += {c + 3, c + 4};
  EndIf
EndFor
loop = newll;
Curve Loop(loop) = {side[]};
s = news;
Plane Surface(s) = {loop};
side_view[] = Extrude {0, 2 * far, 0} { Surface{s}; };

// Plan view: tapered, with a round nose.
x_round = x_tip - 0.5 * width_tip;
p = newp;
Point(p) = {0, -0.5 * width_root, -far};
Point(p + 1) = {x_round, -0.5 * width_tip, -far};
Point(p + 2) = {x_round, 0, -far};
Point(p + 3) = {x_tip, 0, -far};
Point(p + 4) = {x_round, 0.5 * width_tip, -far};
Point(p + 5) = {0, 0.5 * width_root, -far};
c = newc;
Line(c) = {p, p + 1};
Circle(c + 1) = {p + 1, p + 2, p + 3};
Circle(c + 2) = {p + 3, p + 2, p + 4};
Line(c + 3) = {p + 4, p + 5};
Line(c + 4) = {p + 5, p};
loop = newll;
Curve Loop(loop) = {c : c + 4};
s = news;
Plane Surface(s) = {loop};
plan_view[] = Extrude {0, 0, 2 * far} { Surface{s}; };

outer[] = BooleanIntersection{ Volume{side_view[1]}; Delete; }{ Volume{plan_view[1]}; Delete; };

// Round all edges of the two flanks and of the nose's upper side, but neither those of the mount face nor those of the
// pad, which is the open side of the mould and therefore sharp.
edges[] = Curve In BoundingBox{-eps, -far, -eps, far, -eps, far};
edges[] += Curve In BoundingBox{-eps, eps, -eps, far, far, far};
edges[] -= Curve In BoundingBox{-eps, -far, -eps, eps, far, far};
edges[] -= Curve In BoundingBox{-eps, -far, -eps, far, far, eps};
edges[] -= Curve In BoundingBox{x_round - eps, -far, -eps, far, far, spine + eps};
edges[] += Curve In BoundingBox{x_round - eps, -far, spine - eps, far, far, spine + eps};
outer[] = Fillet{ outer[0] }{ edges[] }{ fillet };

// Air: a channel from a port in the mount face through all chambers.
v = newv;
Cylinder(v) = {-1, 0, floor + bore, block + num_pleats * (pleat + gap) - wall, 0, 0, bore};
air[] = {v};
length = pleat - 2 * wall;
For i In {0 : num_pleats - 1}
  chamber_x[i] = block + gap + i * (pleat + gap) + wall;
  chamber_y[i] = 0.5 * width_root + 0.5 * (width_tip - width_root) * (chamber_x[i] + length) / x_round - wall;
  chamber_z[i] = height_root + (height_tip - height_root) * i / (num_pleats - 1) - wall;
  v = newv;
  Box(v) = {chamber_x[i], -chamber_y[i], floor, length, 2 * chamber_y[i], chamber_z[i] - floor};
  air[] += {v};
EndFor
finger[] = BooleanDifference{ Volume{outer[]}; Delete; }{ Volume{air[]}; Delete; };

inside[] = Surface In BoundingBox{-eps, -bore - eps, floor - eps, far, bore + eps, floor + 2 * bore + eps};
For i In {0 : num_pleats - 1}
  inside[] += Surface In BoundingBox{chamber_x[i] - eps, -chamber_y[i] - eps, floor - eps,
                                     chamber_x[i] + length + eps, chamber_y[i] + eps, chamber_z[i] + eps};
EndFor
// What is left of the two drawings.
Delete{ Point{Point In BoundingBox{-eps, -far - eps, -eps, far + eps, -far + eps, far}}; }
Delete{ Point{Point In BoundingBox{-eps, -far, -far - eps, far, far, -far + eps}}; }

Physical Volume("finger") = {finger[]};
Physical Surface("mount") = {Surface In BoundingBox{-eps, -far, -eps, eps, far, far}};
Physical Surface("pad") = {Surface In BoundingBox{-eps, -far, -eps, far, far, eps}};
Physical Surface("tip") = {Surface In BoundingBox{x_round - eps, -far, -eps, far, far, spine + eps}};
Physical Surface("inside") = {Unique(inside[])};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
