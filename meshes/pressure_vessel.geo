// A quarter of a slice of a thick-walled cylinder, radii 7 and 18.625, as hollow_cylinder.geo with its groups.
inner = 7;
outer = 18.625;
radial = 8;
around = 12;
Include "hollow_cylinder.geo";
