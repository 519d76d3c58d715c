// A cube of 1 m above one of 0.1 m above a plate, of six tetrahedra each. Groups: volumes `large`, `small`, `plate`.
SetFactory("OpenCASCADE");
Box(1) = {-0.5, -0.05, -0.5, 1, 1, 1};
Box(2) = {-0.05, -0.2, -0.05, 0.1, 0.1, 0.1};
Box(3) = {-1, -0.255, -1, 2, 0.01, 2};
Physical Volume("large") = {1};
Physical Volume("small") = {2};
Physical Volume("plate") = {3};
Transfinite Curve{:} = 2;
Transfinite Surface{:};
Transfinite Volume{:};
