// Two pneumatic actuators that face each other and hang down, and an egg-shaped fruit between them. The pads look at each
// other over `opening`; z = 0 at the mounts, the fingers reach down to z = -78. Lengths in millimetres (`scale: 0.001`
// under `mesh:` in the input file turns them into metres).
// Groups: volumes `fingers` and `fruit`; surfaces `peel` (of the fruit), `mount` (of both), `pad` (of both: the gripping sides), `chamber_left`
// (x < 0) and `chamber_right` (the walls that the air touches).
// Coarser or finer: `gmsh -3 meshes/gripper.geo -setnumber size 3`.
DefineConstant[ opening = {40, Name "Distance of the pads [mm]"}, thick = {34, Name "Diameter of the fruit [mm]"},
                long = {44, Name "Length of the fruit [mm]"}, height_of_fruit = {-55, Name "Where its middle is [mm]"} ];
Include "pneumatic_actuator.geo";
Delete Physicals;

right() = actuator();
Rotate{ {0, 1, 0}, {0, 0, 0}, Pi / 2 }{ Volume{right[]}; }  // the finger hangs, its pad looks towards -x
Translate{ opening / 2, 0, 0 }{ Volume{right[]}; }
left() = Rotate{ {0, 0, 1}, {0, 0, 0}, Pi }{ Duplicata{ Volume{right[]}; } };

fruit = newv;
Sphere(fruit) = {0, 0, height_of_fruit, thick / 2};
Dilate{ {0, 0, height_of_fruit}, {1, long / thick, 1} }{ Volume{fruit}; }

inner = opening / 2;
outer = inner + height;
Physical Volume("fingers") = {right[], left[]};
Physical Volume("fruit") = {fruit};
Physical Surface("peel") = Boundary{ Volume{fruit}; };
Physical Surface("mount") = {Surface In BoundingBox{-outer - eps, -width, -eps, outer + eps, width, eps}};
pads() = Surface In BoundingBox{inner - eps, -width, -length - eps, inner + eps, width, eps};
pads() += Surface In BoundingBox{-inner - eps, -width, -length - eps, -inner + eps, width, eps};
Physical Surface("pad") = {pads[]};
Physical Surface("chamber_right") = {Surface In BoundingBox{
  inner + floor - eps, -width / 2 + wall - eps, -last - eps, outer - wall + eps, width / 2 - wall + eps, -first + eps}};
Physical Surface("chamber_left") = {Surface In BoundingBox{
  -outer + wall - eps, -width / 2 + wall - eps, -last - eps, -inner - floor + eps, width / 2 - wall + eps, -first + eps}};
