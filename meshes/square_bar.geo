// A bar of 0.2 x 0.2 x 2 m along z, in bricks of six tetrahedra.
// Groups: volume `bar`; surfaces `clamp` (z = 0), `end` (z = 2).
DefineConstant[ across = {2, Name "Bricks across"}, along = {14, Name "Bricks along"} ];

Point(1) = {-0.1, -0.1, 0};
line[] = Extrude {0.2, 0, 0} { Point{1}; Layers{across}; };
square[] = Extrude {0, 0.2, 0} { Line{line[1]}; Layers{across}; };
bar[] = Extrude {0, 0, 2} { Surface{square[1]}; Layers{along}; };

Physical Volume("bar") = {bar[1]};
Physical Surface("clamp") = {square[1]};
Physical Surface("end") = {bar[0]};
