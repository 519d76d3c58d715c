// Two balls of radii 40 and 24 mm on a rod, standing on z = 0 (in metres).
// Groups: volume `body`; surface `skin`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {0.011, Name "Size of the elements"} ];
Sphere(1) = {0, 0, 0.04, 0.04};
Cylinder(2) = {0, 0, 0.05, 0, 0, 0.085, 0.014};
Sphere(3) = {0, 0, 0.135, 0.024};
body() = BooleanUnion{ Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Physical Volume("body") = {body[]};
skin() = Boundary{ Volume{body[]}; };
Physical Surface("skin") = {skin[]};
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
