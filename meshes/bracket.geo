// A mounting bracket of two plates with fillets, two holes for screws and one for a pin, in millimetres. It stands for a
// part from a CAD program: what the input reads is bracket.step, which knows solids and surfaces but no names:
//
//     gmsh -0 bracket.geo -o bracket.step
SetFactory("OpenCASCADE");

width = 40;
plate = 6;
foot = 70;    // along x
height = 60;  // along z

Box(1) = {0, 0, 0, foot, width, plate};
Box(2) = {0, 0, 0, plate, width, height};
bracket[] = BooleanUnion{ Volume{1}; Delete; }{ Volume{2}; Delete; };

// The inner corner, where the stress would grow without bound, then the outer one and the rims of both plates.
eps = 1e-3;
inner[] = Curve In BoundingBox{plate - eps, -eps, plate - eps, plate + eps, width + eps, plate + eps};
outer[] = Curve In BoundingBox{-eps, -eps, -eps, eps, width + eps, eps};
bracket[] = Fillet{bracket[]}{inner[], outer[]}{8, 8, 10, 10};

near[] = Curve In BoundingBox{foot - eps, -eps, -eps, foot + eps, eps, plate + eps};
far[] = Curve In BoundingBox{foot - eps, width - eps, -eps, foot + eps, width + eps, plate + eps};
low[] = Curve In BoundingBox{-eps, -eps, height - eps, plate + eps, eps, height + eps};
high[] = Curve In BoundingBox{-eps, width - eps, height - eps, plate + eps, width + eps, height + eps};
bracket[] = Fillet{bracket[]}{near[], far[], low[], high[]}{8};

Cylinder(11) = {30, width / 2, -1, 0, 0, plate + 2, 3.5};
Cylinder(12) = {55, width / 2, -1, 0, 0, plate + 2, 3.5};
Cylinder(13) = {-1, width / 2, 45, plate + 2, 0, 0, 5};
BooleanDifference{ Volume{bracket[]}; Delete; }{ Volume{11, 12, 13}; Delete; }
