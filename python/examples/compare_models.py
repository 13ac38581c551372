"""csalf and gmsh beside it on the same STEP files: faces, triangles, quality, time; prints a table in Markdown.

    python python/examples/compare_models.py CSALF FILE.step ... [--share 0.025]

CSALF is the program (`target/release/csalf`). gmsh imports with OpenCASCADE and meshes with its Frontal-Delaunay for
quads (algorithm 8) and Blossom recombination, 12 elements per turn, as csalf does by default. Both get the same size, a
share of the diagonal of the box, and one thread. Times are processor seconds of a process of its own, reading included.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np


def quality(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Least scaled Jacobian over the corners of each quad, against the normal of its mean plane."""
    p = points[quads]
    n = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    n /= np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None]
    out = np.ones(len(quads))
    for k in range(4):
        a, b = p[:, (k + 1) % 4] - p[:, k], p[:, (k + 3) % 4] - p[:, k]
        length = np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-300)
        out = np.minimum(out, np.einsum("ij,ij->i", np.cross(a, b), n) / length)
    return out


def figures(q: np.ndarray) -> dict[str, float]:
    """What the table shows of a list of scaled Jacobians."""
    return {"quads": len(q), "min": float(q.min(initial=1.0)), "mean": float(q.mean()) if len(q) else 0.0,
            "poor": int((q < 0.2).sum())}


def run_gmsh(path: str, size: float) -> dict[str, float]:
    """Meshes with gmsh; in a process of its own."""
    import gmsh

    gmsh.initialize()
    for key, value in [("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.Algorithm", 8),
                       ("Mesh.RecombineAll", 1), ("Mesh.RecombinationAlgorithm", 1), ("Mesh.MeshSizeMax", size),
                       ("Mesh.MeshSizeFromCurvature", 12), ("Mesh.MeshSizeMin", 0.1 * size)]:
        gmsh.option.setNumber(key, value)
    gmsh.model.occ.importShapes(path)
    gmsh.model.occ.synchronize()
    error = ""
    try:
        gmsh.model.mesh.generate(2)
    except Exception as e:  # gmsh raises bare exceptions
        error = str(e)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    at = np.zeros(int(tags.max()) + 1 if len(tags) else 1, dtype=int)
    at[tags] = np.arange(len(tags))
    points = xyz.reshape(-1, 3)
    faces = gmsh.model.getEntities(2)
    empty, n_triangles, quads = 0, 0, []
    for _, face in faces:
        kinds, _, nodes = gmsh.model.mesh.getElements(2, face)
        empty += not len(kinds)
        for kind, n in zip(kinds, nodes):
            if kind == 3:
                quads.append(at[n].reshape(-1, 4))
            else:
                n_triangles += len(n) // 3
    q = quality(points, np.concatenate(quads)) if quads else np.zeros(0)
    return {**figures(q), "faces": len(faces), "meshed": len(faces) - empty, "triangles": n_triangles,
            "error": error}


def run_csalf(program: str, path: str, size: float) -> dict[str, float]:
    """Meshes with csalf."""
    import meshio

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "mesh.vtu"
        command = [program, "mesh", path, "-o", str(out), "--size", repr(size), "--threads", "1", "--json", "-q"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        ran = subprocess.run(command, capture_output=True, text=True, check=False)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        line = json.loads(ran.stdout.splitlines()[-1])
        if not line["ok"]:
            return {"error": "; ".join(line["errors"]), "cpu": seconds}
        mesh = meshio.read(out)
    blocks = [c.data for c in mesh.cells if c.type == "quad"]
    n_triangles = sum(len(c.data) for c in mesh.cells if c.type == "triangle")
    return {**figures(quality(mesh.points, np.concatenate(blocks))), "faces": line["n_faces"],
            "meshed": line["n_faces"] - line["n_failures"], "triangles": n_triangles, "cpu": seconds, "error": ""}


def diagonal(program: str, path: str) -> float:
    """Of the box of a model."""
    ran = subprocess.run([program, "info", path, "--json"], capture_output=True, text=True, check=True)
    low, high = json.loads(ran.stdout.splitlines()[-1])["box"]
    return float(np.linalg.norm(np.subtract(high, low)))


def row(name: str, ours: dict[str, float], theirs: dict[str, float]) -> str:
    """One line of the table."""
    def cell(key: str, form: str) -> str:
        return " / ".join(format(r[key], form) if key in r else "-" for r in (ours, theirs))

    faces = " / ".join(f"{r.get('meshed', 0)} of {r.get('faces', '?')}" for r in (ours, theirs))
    return (f"| {name} | {faces} | {cell('quads', 'd')} | {cell('triangles', 'd')} | {cell('min', '.3f')} | "
            f"{cell('mean', '.3f')} | {cell('poor', 'd')} | {cell('cpu', '.2f')} |")


def main() -> None:
    """Runs both on all files."""
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(run_gmsh(sys.argv[2], float(sys.argv[3]))))
        return
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("files", nargs="+")
    parser.add_argument("--share", type=float, default=0.025)
    args = parser.parse_args()
    print("| part | faces | quads | triangles | min SJ | mean SJ | below 0.2 | CPU s |\n|---|---|---|---|---|---|---|---|")
    for path in args.files:
        size = args.share * diagonal(args.program, path)
        ours = run_csalf(args.program, path, size)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        ran = subprocess.run([sys.executable, __file__, "--one", path, repr(size)], capture_output=True, text=True,
                             check=False)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        theirs = json.loads(ran.stdout.splitlines()[-1]) if ran.stdout.strip() else {"error": ran.stderr[-200:]}
        theirs["cpu"] = seconds
        print(row(Path(path).stem, ours, theirs), flush=True)
        for who, r in (("csalf", ours), ("gmsh", theirs)):
            if r.get("error"):
                print(f"  {who}: {r['error']}", file=sys.stderr)


if __name__ == "__main__":
    main()
