// A quarter of an indented block: the unit cube in millimetres, y up, in bricks of six tetrahedra.
// Groups: volume `block`; surface `patch`, the quarter x < 0.5, z < 0.5 of the top.
DefineConstant[ n = {4, Name "Bricks along each side, even"} ];

Point(1) = {0, 0, 0};
near[] = Extrude {0.5, 0, 0} { Point{1}; Layers{n / 2}; };
far[] = Extrude {0.5, 0, 0} { Point{near[0]}; Layers{n / 2}; };
a[] = Extrude {0, 0, 0.5} { Line{near[1]}; Layers{n / 2}; };
b[] = Extrude {0, 0, 0.5} { Line{far[1]}; Layers{n / 2}; };
c[] = Extrude {0, 0, 0.5} { Line{a[0]}; Layers{n / 2}; };
d[] = Extrude {0, 0, 0.5} { Line{b[0]}; Layers{n / 2}; };
under[] = Extrude {0, 1, 0} { Surface{a[1]}; Layers{n}; };
beside[] = Extrude {0, 1, 0} { Surface{b[1]}; Layers{n}; };
behind[] = Extrude {0, 1, 0} { Surface{c[1]}; Layers{n}; };
corner[] = Extrude {0, 1, 0} { Surface{d[1]}; Layers{n}; };

Physical Volume("block") = {under[1], beside[1], behind[1], corner[1]};
Physical Surface("patch") = {under[0]};
