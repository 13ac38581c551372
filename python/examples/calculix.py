"""A plate with a hole in tension, solved by CalculiX on meshes of csalf: the stress concentration at the hole.

    python calculix.py [N ...]      N: nodes on the hole; needs the program ccx

A strip of width W = 10 with a hole of diameter d = 2 in its middle is pulled by a stress of 1. The largest stress, at
the hole, is 3.14 (R. C. J. Howland, Phil. Trans. R. Soc. A 229, 1930; the fit of W. D. Pilkey, Peterson's Stress
Concentration Factors, chart 4.1, is 3.133).
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import csalf

WIDTH, LENGTH, RADIUS = 10.0, 30.0, 1.0
THICKNESS = 0.01  # thin: CalculiX expands plane elements into bricks
EXACT = 3.14  # gross stress, Howland 1930 for d/W = 0.2


def plate(nodes_on_hole: int, *, rings: bool) -> csalf.Mesh:
    """The mesh; sizes grow away from the hole. Without rings: recursive subdivision alone."""
    h = 2 * np.pi * RADIUS / nodes_on_hole

    def size(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.minimum(h + 0.2 * np.maximum(np.hypot(x, y) - 1.5 * RADIUS, 0), WIDTH / 10)

    x, y = LENGTH / 2, WIDTH / 2
    outer = csalf.polyline([(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)])
    how = {"method": "csalf", "layers": {"hole0": (4, "auto")}} if rings else {"method": "tqm"}
    return csalf.mesh(loops=[outer, csalf.circle((0, 0), RADIUS)], size=size, name="plate", **how)


def concentration(mesh: csalf.Mesh, folder: Path, order: int) -> float:
    """The largest stress along the strip at the nodes of the hole, by CalculiX, for a stress of 1 at the ends."""
    mesh.write(folder / "mesh.inp", order=order, element="plane-stress")
    left = np.flatnonzero(mesh.points[:, 0] <= mesh.points[:, 0].min() + 1e-9) + 1
    pulled = []
    for k in range(4):
        ends = mesh.points[mesh.quads[:, [k, (k + 1) % 4]], 0]
        on_end = (np.abs(np.abs(ends) - LENGTH / 2) < 1e-9).all(1) & (ends[:, 0] * ends[:, 1] > 0)
        pulled += [f"{q + 1}, P{k + 1}, -1.0" for q in np.flatnonzero(on_end)]
    # Both ends are pulled; the corners of one keep the plate where it is.
    low, high = (min(left, key=lambda n: s * mesh.points[n - 1, 1]) for s in (1, -1))
    lines = [
        "*INCLUDE, INPUT=mesh.inp",
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        "210000., 0.3",
        "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL",
        f"{THICKNESS}",
        "*BOUNDARY",
        f"{low}, 1, 2",
        f"{high}, 1, 1",
        "*STEP",
        "*STATIC",
        "*DLOAD",
        *pulled,
        "*EL FILE, OUTPUT=2D",
        "S",
        "*END STEP",
    ]
    (folder / "job.inp").write_text("\n".join(lines) + "\n")
    done = subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, text=True)
    if not (folder / "job.frd").exists():
        raise RuntimeError(done.stdout[-2000:])
    stress = read_stress(folder / "job.frd")
    return max(stress[int(n) + 1] for n in mesh.node_sets["hole0"])


def read_stress(path: Path) -> dict[int, float]:
    """SXX per node of the last result in a .frd file."""
    out: dict[int, float] = {}
    inside = False
    for line in path.read_text().splitlines():
        if line.startswith(" -4"):
            inside = "STRESS" in line
        elif line.startswith(" -3"):
            inside = False
        elif inside and line.startswith(" -1"):
            out[int(line[3:13])] = float(line[13:25])
    return out


def main(sizes: list[int]) -> None:
    if shutil.which("ccx") is None:
        sys.exit("CalculiX (ccx) is not installed")
    print(f"exact: {EXACT}")
    print("| nodes on the hole | mesh | quads | smallest scaled Jacobian | K, linear | error | K, quadratic | error |")
    print("|---|---|---|---|---|---|---|---|")
    for n in sizes:
        for rings in (True, False):
            mesh = plate(n, rings=rings)
            row = [str(n), "rings" if rings else "subdivision alone", str(len(mesh.quads))]
            row.append(f"{mesh.scaled_jacobian.min():.3f}")
            for order in (1, 2):
                with tempfile.TemporaryDirectory() as folder:
                    k = concentration(mesh, Path(folder), order)
                row += [f"{k:.3f}", f"{100 * (k / EXACT - 1):+.1f} %"]
            print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main([int(a) for a in sys.argv[1:]] or [16, 24, 32, 48, 64])
