// The twisting column: [-0.5, 0.5]^2 x [0, 6] m along y, in bricks of six tetrahedra.
// Groups: volume `column`, surface `base` (y = 0).
DefineConstant[ across = {3, Name "Bricks across"}, along = {18, Name "Bricks along"} ];

Point(1) = {-0.5, 0, -0.5};
line[] = Extrude {1, 0, 0} { Point{1}; Layers{across}; };
square[] = Extrude {0, 0, 1} { Line{line[1]}; Layers{across}; };
column[] = Extrude {0, 6, 0} { Surface{square[1]}; Layers{along}; };

Physical Volume("column") = {column[1]};
Physical Surface("base") = {square[1]};
