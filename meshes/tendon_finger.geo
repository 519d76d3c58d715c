// A palm of 40 x 24 x 24 mm and a finger of 100 x 20 x 14 mm on its front, which share nodes [m].
SetFactory("OpenCASCADE");
Box(1) = {-0.04, -0.012, -0.012, 0.04, 0.024, 0.024};
Box(2) = {0, -0.010, -0.010, 0.1, 0.020, 0.014};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("palm") = {1};
Physical Volume("finger") = {2};
Mesh.MeshSizeMax = 0.006;
