// Twelve soft parts above one another: balls, blocks, drums and rings in turn, four layers of three; drawn in millimetres.
// Each layer is turned against the one below it. Groups: volumes `balls`, `blocks`, `drums`, `rings`, of three parts each.
SetFactory("OpenCASCADE");
DefineConstant[ size = {5, Name "Size of the elements"} ];
For layer In {0:3}
  For i In {0:2}
    v = newv;
    angle = 2*Pi*i/3 + 0.5*layer;
    x = 13.5*Cos(angle);
    y = 13.5*Sin(angle);
    z = 13 + 24*layer;
    kind = (i + layer) % 4;
    If (kind == 0)
      Sphere(v) = {x, y, z, 9};
      balls() += v;
    ElseIf (kind == 1)
      Box(v) = {x - 7, y - 7, z - 7, 14, 14, 14};
      blocks() += v;
    ElseIf (kind == 2)
      Cylinder(v) = {x, y, z - 8, 0, 0, 16, 7};
      drums() += v;
    Else
      Torus(v) = {x, y, z, 7, 3.5};
      rings() += v;
    EndIf
    Rotate{ {1, 0.5*i, 0.3*layer}, {x, y, z}, 0.4 + 0.7*i + 0.5*layer }{ Volume{v}; }
  EndFor
EndFor
Physical Volume("balls") = {balls[]};
Physical Volume("blocks") = {blocks[]};
Physical Volume("drums") = {drums[]};
Physical Volume("rings") = {rings[]};
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
