// The idealised left ventricle of Land et al., Proc. R. Soc. A 471 (2015) 20150641, problem 2: the space between two
// ellipsoids about the axis z, 7 x 17 mm and 10 x 20 mm, cut off at z = 5 mm; drawn in millimetres.
// Groups: volume `wall`; surfaces `base`, `endocardium`, `epicardium`.
SetFactory("OpenCASCADE");
DefineConstant[ size = {2, Name "Size of the elements"} ];
// Half of a section, drawn with the axis along x, since an ellipse has its long axis there; from the base to the apex.
Ellipse(1) = {0, 0, 0, 17, 7, Acos(5/17), Pi};
Ellipse(2) = {0, 0, 0, 20, 10, Acos(5/20), Pi};
inside() = Boundary{ Curve{1}; };
outside() = Boundary{ Curve{2}; };
Line(3) = {inside[0], outside[0]};
Line(4) = {inside[1], outside[1]};
Curve Loop(1) = {1, 4, -2, -3};
Plane Surface(1) = {1};
Rotate { {0, 1, 0}, {0, 0, 0}, -Pi/2 } { Surface{1}; }
turned() = Extrude { {0, 0, 1}, {0, 0, 0}, 2*Pi } { Surface{1}; };  // section, volume, surfaces of the curves
Physical Volume("wall") = {turned[1]};
Physical Surface("endocardium") = {turned[2]};
Physical Surface("epicardium") = {turned[3]};
Physical Surface("base") = {turned[4]};
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
