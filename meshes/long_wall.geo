// A quarter of a wall's cross-section, 1 x 2 m, a layer of 0.25 m thick.
// Groups: volume `wall`; surfaces `left`, `right`, `bottom`, `top`, `faces`.
Point(1) = {0, 0, 0};
line[] = Extrude {1, 0, 0} { Point{1}; Layers{2}; };
square[] = Extrude {0, 2, 0} { Line{line[1]}; Layers{4}; };
wall[] = Extrude {0, 0, 0.25} { Surface{square[1]}; Layers{1}; };

Physical Volume("wall") = {wall[1]};
Physical Surface("bottom") = {wall[2]};
Physical Surface("right") = {wall[3]};
Physical Surface("top") = {wall[4]};
Physical Surface("left") = {wall[5]};
Physical Surface("faces") = {square[1], wall[0]};
