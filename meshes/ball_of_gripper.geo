// The ball that the gripper with tendons picks up, where it lies at the start. Lengths in millimetres.
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 15.5, 15};
MeshSize{ PointsOf{ Volume{1}; } } = 5;
Mesh.MeshSizeFromCurvature = 12;
