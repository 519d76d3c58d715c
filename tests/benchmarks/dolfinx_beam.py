#!/usr/bin/python3
"""The beam of docs/performance.md in dolfinx 0.5.2 (Debian: python3-dolfinx, python3-petsc4py-real), the peer of whole-run benchmarks.

Cantilever 1 x 0.2 x 0.2 m clamped at x = 0, rho 1000, neo-Hookean E 1e6 nu 0.4, gravity -9.81 z, backward Euler dt 0.01,
consistent mass, quadrature degree 2(p-1) elastic and 2p mass, Newton to 1e-8 relative. Prints medians per phase.
  mpirun -n 2 /usr/bin/python3 dolfinx_beam.py --n 55 11 11 --p 1 --solver gamg [--steps 10]
  /usr/bin/python3 dolfinx_beam.py --n 55 11 11 --write beam.msh     # the same mesh as a gmsh 2.2 file (groups: beam, clamp)
Solvers: mumps_chol, mumps_lu, gamg (rigid-body near-null space), icc (block-Jacobi/ICC); CG to 1e-6 unless --ksp_rtol.
Kernels are compiled -O3 -march=native -ffast-math: the peer at its best."""
import argparse
import resource
import sys

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_matrix, assemble_vector, create_matrix, create_vector, set_bc
from mpi4py import MPI
from petsc4py import PETSc

ap = argparse.ArgumentParser()
ap.add_argument("--n", type=int, nargs=3, default=[30, 6, 6])
ap.add_argument("--p", type=int, default=1)
ap.add_argument("--steps", type=int, default=10)
ap.add_argument("--solver", default="mumps_chol")
ap.add_argument("--ksp_rtol", type=float, default=1e-6)
ap.add_argument("--E", type=float, default=1e6)  # stiff variant: --E 1e9 --nu 0.45 --dt 0.025 --rtol 1e-5
ap.add_argument("--rtol", type=float, default=1e-8)
ap.add_argument("--nu", type=float, default=0.4)
ap.add_argument("--dt", type=float, default=0.01)
ap.add_argument("--box", type=float, nargs=3, default=[1, 0.2, 0.2])  # bulky variant: --box 0.3 0.3 0.3 --n 19 19 19
ap.add_argument("--write", default="")
a = ap.parse_args()
comm = MPI.COMM_WORLD
now = MPI.Wtime

msh = mesh.create_box(comm, [np.zeros(3), np.array(a.box)], a.n, mesh.CellType.tetrahedron, ghost_mode=mesh.GhostMode.none)
if a.write:
    assert comm.size == 1
    x = msh.geometry.x
    cells = msh.geometry.dofmap.array.reshape(-1, 4)
    d = np.linalg.det(np.stack([x[cells[:, k]] - x[cells[:, 0]] for k in (1, 2, 3)], axis=2))
    cells[d < 0] = cells[d < 0][:, [0, 2, 1, 3]]
    tri = np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    tri = np.unique(tri[np.all(np.abs(x[tri][:, :, 0]) < 1e-12, axis=1)], axis=0)
    with open(a.write, "w") as o:
        o.write('$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 "clamp"\n3 2 "beam"\n$EndPhysicalNames\n')
        o.write(f"$Nodes\n{len(x)}\n" + "".join(f"{i+1} {p[0]:.17g} {p[1]:.17g} {p[2]:.17g}\n" for i, p in enumerate(x)) + "$EndNodes\n")
        o.write(f"$Elements\n{len(tri) + len(cells)}\n")
        o.write("".join(f"{i+1} 2 2 1 1 {t[0]+1} {t[1]+1} {t[2]+1}\n" for i, t in enumerate(tri)))
        o.write("".join(f"{len(tri)+i+1} 4 2 2 2 {t[0]+1} {t[1]+1} {t[2]+1} {t[3]+1}\n" for i, t in enumerate(cells)) + "$EndElements\n")
    sys.exit()

V = fem.VectorFunctionSpace(msh, ("Lagrange", a.p))
u, un, vn = fem.Function(V), fem.Function(V), fem.Function(V)
w, du = ufl.TestFunction(V), ufl.TrialFunction(V)
E, nu, rho, g, dt_ = a.E, a.nu, 1000.0, 9.81, a.dt
mu, lam = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
F = ufl.Identity(3) + ufl.grad(u)
J = ufl.det(F)
psi = mu / 2 * (ufl.tr(F.T * F) - 3) - mu * ufl.ln(J) + lam / 2 * ufl.ln(J) ** 2
dxe, dxm = ufl.dx(metadata={"quadrature_degree": 2 * (a.p - 1)}), ufl.dx(metadata={"quadrature_degree": 2 * a.p})
dt, b = fem.Constant(msh, dt_), fem.Constant(msh, PETSc.ScalarType((0, 0, -rho * g)))
R = ufl.derivative(psi, u, w) * dxe + rho / dt**2 * ufl.inner(u - un - dt * vn, w) * dxm - ufl.inner(b, w) * dxm
jit = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math"], "cffi_libraries": ["m"]}
R_form, K_form = fem.form(R, jit_params=jit), fem.form(ufl.derivative(R, u, du), jit_params=jit)
clamp = mesh.locate_entities_boundary(msh, 2, lambda x: np.isclose(x[0], 0))
bc = fem.dirichletbc(np.zeros(3), fem.locate_dofs_topological(V, 2, clamp), V)
K, r, d = create_matrix(K_form), create_vector(R_form), create_vector(R_form)


def rigid_modes():
    x = V.tabulate_dof_coordinates()[: V.dofmap.index_map.size_local]
    z, o = np.zeros(len(x)), np.ones(len(x))
    fields = [[o, z, z], [z, o, z], [z, z, o], [-x[:, 1], x[:, 0], z], [x[:, 2], z, -x[:, 0]], [z, -x[:, 2], x[:, 1]]]
    q = []
    for f in fields:
        v = r.duplicate()
        v.setArray(np.stack(f, axis=1).ravel())
        for s in q:
            v.axpy(-v.dot(s), s)
        v.normalize()
        q.append(v)
    return PETSc.NullSpace().create(vectors=q, comm=comm)


K.setOption(PETSc.Mat.Option.SYMMETRIC, True)
K.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
ksp = PETSc.KSP().create(comm)
pc = ksp.getPC()
if a.solver.startswith("mumps"):
    ksp.setType("preonly")
    pc.setType("lu" if a.solver == "mumps_lu" else "cholesky")
    pc.setFactorSolverType("mumps")
else:
    ksp.setType("cg")
    if a.solver == "icc":
        pc.setType("bjacobi")
        PETSc.Options()["sub_pc_type"] = "icc"
    else:
        K.setNearNullSpace(rigid_modes())
        pc.setType("gamg")
    ksp.setTolerances(rtol=a.ksp_rtol, max_it=500)
    ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
ksp.setFromOptions()
ksp.setOperators(K)
t = {"residual": [], "tangent": [], "pc_setup": [], "solve": [], "step": []}
newton, cg = [], []


def residual():
    s = now()
    with r.localForm() as l:
        l.set(0)
    assemble_vector(r, R_form)
    r.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    set_bc(r, [bc], u.vector, -1.0)
    n = r.norm()
    t["residual"].append(now() - s)
    return n


for step in range(a.steps):
    s0 = now()
    r0 = rn = residual()
    k = 0
    while rn > a.rtol * r0 and k < 20:
        s = now(); K.zeroEntries(); assemble_matrix(K, K_form, bcs=[bc]); K.assemble(); t["tangent"].append(now() - s)
        s = now(); ksp.setOperators(K); ksp.setUp(); t["pc_setup"].append(now() - s)
        s = now(); ksp.solve(r, d); t["solve"].append(now() - s)
        cg.append(ksp.getIterationNumber())
        u.vector.axpy(-1, d)
        u.x.scatter_forward()
        k += 1
        rn = residual()
    newton.append(k)
    vn.vector.array[:] = (u.vector.array - un.vector.array) / dt_
    un.vector.array[:] = u.vector.array
    un.x.scatter_forward()
    vn.x.scatter_forward()
    t["step"].append(now() - s0)
x = V.tabulate_dof_coordinates()[: V.dofmap.index_map.size_local]
uz = u.vector.array.reshape(-1, 3)[:, 2]
tip = comm.allreduce(uz[np.isclose(x[:, 0], a.box[0]) & np.isclose(x[:, 1], 0) & np.isclose(x[:, 2], 0)].sum())
rss = comm.reduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
if comm.rank == 0:
    med = " ".join(f"{k}={1e3 * np.median(v):.2f}ms" for k, v in t.items())
    print(f"dolfinx p{a.p} cells={msh.topology.index_map(3).size_global} dofs={3 * V.dofmap.index_map.size_global} np={comm.size} {a.solver} "
          f"newton={np.mean(newton):.1f} cg={np.mean(cg):.1f} {med} rss={rss:.0f}MB uz(lx,0,0)={tip:.9e}")
