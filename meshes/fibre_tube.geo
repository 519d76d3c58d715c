// A closed soft tube with eight sides, 100 mm long and 20 mm across, with a wall of 3 mm, in millimetres, and lines on its
// outside along which fibres can be wound.
// Groups: volume `tube`; surfaces `mount` (z = 0), `chamber` (the wall of the hollow); curves `right0` ... `right3` and
// `left0` ... `left3`, helices of both hands that cross one another, and `straight`, along the tube at x > 0.
sides = 8; outer = 10; inner = 7; length = 100; cap = 5;
levels = 32;      // of crossings: the pitch is length * sides / levels
size = 5;
rise = length / levels;

// Outside: corners at every other level along each edge, so that slanted lines join them; all corners at both ends.
For i In {0:sides-1}
  a = 2 * Pi * i / sides;
  For k In {0:levels}
    If ((i + k) % 2 == 0 || k == 0 || k == levels)
      p~{i}~{k} = newp; Point(p~{i}~{k}) = {outer * Cos(a), outer * Sin(a), k * rise, size};
    EndIf
  EndFor
EndFor
For i In {0:sides-1}
  n = (i + 1) % sides;
  For k In {0:levels-1}
    If ((i + k) % 2 == 0)
      up~{i}~{k} = newc; Line(up~{i}~{k}) = {p~{i}~{k}, p~{n}~{k+1}};       // right-handed
    Else
      down~{i}~{k} = newc; Line(down~{i}~{k}) = {p~{n}~{k}, p~{i}~{k+1}};   // left-handed
    EndIf
  EndFor
  // The edges along the tube: two levels each, and one at the ends of every other edge.
  If (i % 2 == 1)
    first~{i} = newc; Line(first~{i}) = {p~{i}~{0}, p~{i}~{1}};
    last~{i} = newc; Line(last~{i}) = {p~{i}~{levels-1}, p~{i}~{levels}};
  EndIf
  For k In {(i % 2):levels-2:2}
    along~{i}~{k} = newc; Line(along~{i}~{k}) = {p~{i}~{k}, p~{i}~{k+2}};
  EndFor
  bottom~{i} = newc; Line(bottom~{i}) = {p~{i}~{0}, p~{n}~{0}};
  top~{i} = newc; Line(top~{i}) = {p~{i}~{levels}, p~{n}~{levels}};
EndFor
outside[] = {};
For i In {0:sides-1}
  n = (i + 1) % sides;
  // Triangles of the side between the edges i and n: each slanted line has one below it and one above it.
  For k In {0:levels-2}
    l = newll;
    If ((i + k) % 2 == 0)
      // (i, k), (n, k + 1), (i, k + 2)
      Curve Loop(l) = {up~{i}~{k}, down~{i}~{k+1}, -along~{i}~{k}};
    Else
      // (n, k), (n, k + 2), (i, k + 1)
      Curve Loop(l) = {along~{n}~{k}, -up~{i}~{k+1}, -down~{i}~{k}};
    EndIf
    s = news; Plane Surface(s) = {l}; outside[] += s;
  EndFor
  // The halves of triangles at both ends.
  l = newll; s = news;
  If (i % 2 == 0)
    Curve Loop(l) = {bottom~{i}, first~{n}, -up~{i}~{0}};
  Else
    Curve Loop(l) = {bottom~{i}, down~{i}~{0}, -first~{i}};
  EndIf
  Plane Surface(s) = {l}; outside[] += s;
  l = newll; s = news;
  If ((i + levels - 1) % 2 == 0)
    Curve Loop(l) = {up~{i}~{levels-1}, -top~{i}, -last~{i}};
  Else
    Curve Loop(l) = {last~{n}, -top~{i}, -down~{i}~{levels-1}};
  EndIf
  Plane Surface(s) = {l}; outside[] += s;
EndFor
bottoms[] = {}; tops[] = {};
For i In {0:sides-1}
  bottoms[] += bottom~{i}; tops[] += top~{i};
EndFor
l = newll; Curve Loop(l) = {bottoms[]}; mount = news; Plane Surface(mount) = {l};
l = newll; Curve Loop(l) = {tops[]}; end = news; Plane Surface(end) = {l};

// The hollow.
For i In {0:sides-1}
  a = 2 * Pi * i / sides;
  q~{i} = newp; Point(q~{i}) = {inner * Cos(a), inner * Sin(a), cap, size};
  r~{i} = newp; Point(r~{i}) = {inner * Cos(a), inner * Sin(a), length - cap, size};
EndFor
For i In {0:sides-1}
  n = (i + 1) % sides;
  low~{i} = newc; Line(low~{i}) = {q~{i}, q~{n}};
  high~{i} = newc; Line(high~{i}) = {r~{i}, r~{n}};
  wall~{i} = newc; Line(wall~{i}) = {q~{i}, r~{i}};
EndFor
hollow[] = {}; lows[] = {}; highs[] = {};
For i In {0:sides-1}
  n = (i + 1) % sides;
  l = newll; Curve Loop(l) = {low~{i}, wall~{n}, -high~{i}, -wall~{i}};
  s = news; Plane Surface(s) = {l}; hollow[] += s;
  lows[] += low~{i}; highs[] += high~{i};
EndFor
l = newll; Curve Loop(l) = {lows[]}; s = news; Plane Surface(s) = {l}; hollow[] += s;
l = newll; Curve Loop(l) = {highs[]}; s = news; Plane Surface(s) = {l}; hollow[] += s;

l = newsl; Surface Loop(l) = {outside[], mount, end};
h = newsl; Surface Loop(h) = {hollow[]};
v = newv; Volume(v) = {l, h};
Physical Volume("tube") = {v};
Physical Surface("mount") = {mount};
Physical Surface("chamber") = {hollow[]};
For f In {0:sides/2-1}
  right[] = {}; left[] = {};
  For k In {0:levels-1}
    i = (2 * f + k) % sides;
    right[] += up~{i}~{k};
    j = (2 * f + 2 * levels * sides - k - 1) % sides;
    left[] += down~{j}~{k};
  EndFor
  Physical Curve(Sprintf("right%g", f)) = {right[]};
  Physical Curve(Sprintf("left%g", f)) = {left[]};
EndFor
straight[] = {};
For k In {0:levels-2:2}
  straight[] += along~{0}~{k};
EndFor
Physical Curve("straight") = {straight[]};
