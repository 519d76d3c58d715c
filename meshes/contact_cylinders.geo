// Two half cylinders of radius 8 with axes along z, round sides towards each other, `gap` apart at the origin: a slab of one
// element, fine where they touch. The meshes do not match.
// Groups: volumes `lower`, `upper`; surfaces `bottom`, `lid` (the planes through the axes), and where the cylinders may touch
// `lower_face`, `upper_face`.
DefineConstant[ fine = {0.05, Name "Size of the elements at the contact"}, gap = 0.001 ];
R = 8;
half = 0.2;  // angle to which the faces extend on either side

Macro HalfCylinder  // on the side of the origin away from s = 1 (up) or -1 (down)
  y = -s * (R + gap / 2);
  p = newp;
  Point(p) = {0, y, 0};
  Point(p + 1) = {-R, y, 0};
  Point(p + 2) = {-R * Sin(half), y + s * R * Cos(half), 0};
  Point(p + 3) = {R * Sin(half), y + s * R * Cos(half), 0};
  Point(p + 4) = {R, y, 0};
  l = newl;
  Line(l) = {p + 4, p + 1};
  Circle(l + 1) = {p + 1, p, p + 2};
  Circle(l + 2) = {p + 2, p, p + 3};
  Circle(l + 3) = {p + 3, p, p + 4};
  Curve Loop(l + 4) = {l, l + 1, l + 2, l + 3};
  side = news;
  Plane Surface(side) = {l + 4};
  made() = Extrude {0, 0, fine} { Surface{side}; Layers{1}; };  // the far side, the volume, and a surface for each curve
Return

s = 1;
Call HalfCylinder;
Physical Volume("lower") = {made[1]};
Physical Surface("bottom") = {made[2]};
Physical Surface("lower_face") = {made[4]};
s = -1;
Call HalfCylinder;
Physical Volume("upper") = {made[1]};
Physical Surface("lid") = {made[2]};
Physical Surface("upper_face") = {made[4]};

Field[1] = MathEval;  // the upper one is finer
Field[1].F = Sprintf("%g * (1 - 0.15 * step(y)) + 0.3 * max(sqrt(x^2 + y^2) - 0.9, 0)", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
