"""Draws the parts that docs/models-benchmarks.md measures, with the OpenCASCADE kernel of gmsh.

    python python/examples/model_parts.py FOLDER

writes one .step per part, and ring.stl, a closed faceted surface of genus 1.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import gmsh

occ = gmsh.model.occ


def bracket() -> None:
    """A plate with bolt holes and a flange bent up, all 3 thick."""
    plate = occ.addBox(0, 0, 0, 80, 60, 3)
    flange = occ.addBox(80 + 5, 0, 8, 3, 60, 30)
    # The bend: a quarter of a tube round (80, y, 8).
    outer = occ.addCylinder(80, 0, 8, 0, 60, 0, 8, angle=math.pi / 2)
    inner = occ.addCylinder(80, 0, 8, 0, 60, 0, 5, angle=math.pi / 2)
    bend, _ = occ.cut([(3, outer)], [(3, inner)])
    occ.rotate(bend, 80, 0, 8, 0, 1, 0, math.pi / 2)
    occ.synchronize()
    low = gmsh.model.getBoundingBox(3, bend[0][1])
    for _ in range(4):
        if low[0] > 79 and low[2] < 1 and low[5] < 9:
            break
        occ.rotate(bend, 80, 0, 8, 0, 1, 0, math.pi / 2)
        occ.synchronize()
        low = gmsh.model.getBoundingBox(3, bend[0][1])
    body, _ = occ.fuse([(3, plate)], [(3, flange), bend[0]])
    holes = [(3, occ.addCylinder(x, y, -1, 0, 0, 5, r)) for x, y, r in
             [(12, 12, 4), (12, 48, 4), (60, 12, 4), (60, 48, 4), (36, 30, 10)]]
    holes += [(3, occ.addCylinder(80, y, 28, 20, 0, 0, 3)) for y in (15, 45)]
    occ.cut(body, holes)


def pierced() -> None:
    """A tube with a round hole through both walls."""
    outer = occ.addCylinder(0, 0, 0, 0, 0, 60, 20)
    inner = occ.addCylinder(0, 0, -1, 0, 0, 62, 17)
    drill = occ.addCylinder(-30, 0, 30, 60, 0, 0, 8)
    occ.cut([(3, outer)], [(3, inner), (3, drill)])


def sphere() -> None:
    """A ball."""
    occ.addSphere(1, 2, 3, 10)


def torus() -> None:
    """A ring."""
    occ.addTorus(0, 0, 0, 20, 6)


def fillets() -> None:
    """A block with all its edges rounded: fillets meet in spheres and blends."""
    box = occ.addBox(0, 0, 0, 40, 30, 20)
    occ.synchronize()
    edges = [e for _, e in gmsh.model.getBoundary([(3, box)], combined=False, recursive=False, oriented=False)]
    edges = [e for _, e in gmsh.model.getEntities(1)]
    occ.fillet([box], edges, [4.0])


def chain() -> None:
    """An L of two blocks, its inner edge and the edges beside it rounded with two radii."""
    a = occ.addBox(0, 0, 0, 50, 30, 10)
    b = occ.addBox(0, 0, 0, 10, 30, 40)
    body, _ = occ.fuse([(3, a)], [(3, b)])
    occ.synchronize()
    inner = [e for _, e in gmsh.model.getEntities(1)
             if all(abs(v - w) < 1e-6 for v, w in zip(gmsh.model.occ.getCenterOfMass(1, e), (10, 15, 10)))]
    occ.fillet([body[0][1]], inner, [6.0])
    occ.synchronize()
    top = [e for _, e in gmsh.model.getEntities(1)
           if abs(gmsh.model.occ.getCenterOfMass(1, e)[2] - 40) < 1e-6]
    solid = gmsh.model.getEntities(3)[0][1]
    occ.fillet([solid], top, [2.0])


def cone() -> None:
    """A cone with its apex."""
    occ.addCone(0, 0, 0, 0, 0, 30, 15, 0)


def frustum() -> None:
    """A cone cut off, with a bore."""
    body = occ.addCone(0, 0, 0, 0, 0, 30, 20, 8)
    occ.cut([(3, body)], [(3, occ.addCylinder(0, 0, -1, 0, 0, 40, 4))])


def dome() -> None:
    """Half a ball's skin with a hole at the top."""
    ball = occ.addSphere(0, 0, 0, 20, angle1=0)
    occ.cut([(3, ball)], [(3, occ.addCylinder(0, 0, -1, 0, 0, 40, 4))])


def hat() -> None:
    """A hat section: a sheet of one thickness, bent four times, with slots in the top."""
    xs = [(0, 0), (20, 0), (26, 24), (54, 24), (60, 0), (80, 0)]
    points = [occ.addPoint(x, 0, z) for x, z in xs]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:])]
    wire = occ.addWire(lines)
    occ.synchronize()
    sheet = occ.extrude([(1, line) for line in lines], 0, 120, 0)
    del wire
    faces = [s for s in sheet if s[0] == 2]
    tool = occ.addCylinder(40, 60, 20, 0, 0, 10, 7)
    occ.cut(faces, [(3, tool)])


def blend() -> None:
    """Free-form: a surface through three splines (NURBS), thickened to a body between two of them."""
    def curve(z: float, r: float, n: int) -> int:
        points = [occ.addPoint(r * (1 + 0.15 * math.cos(3 * a)) * math.cos(a),
                               r * (1 + 0.15 * math.cos(3 * a)) * math.sin(a), z)
                  for a in (2 * math.pi * k / n for k in range(n))]
        return occ.addWire([occ.addSpline([*points, points[0]])])

    occ.addThruSections([curve(0, 10, 12), curve(15, 14, 12), curve(30, 7, 12)])


def manifold() -> None:
    """Crossing tubes with a common bore and fillets where they meet."""
    a = occ.addCylinder(-30, 0, 0, 60, 0, 0, 10)
    b = occ.addCylinder(0, 0, 0, 0, 0, 35, 8)
    body, _ = occ.fuse([(3, a)], [(3, b)])
    bores = [occ.addCylinder(-31, 0, 0, 62, 0, 0, 7), occ.addCylinder(0, 0, 0, 0, 0, 36, 5)]
    occ.cut(body, [(3, t) for t in bores])


PARTS: list[Callable[[], None]] = [
    bracket, pierced, sphere, torus, fillets, chain, cone, frustum, dome, hat, blend, manifold,
]


def ring_stl(path: Path, nu: int = 48, nv: int = 20) -> None:
    """A bent, uneven ring of facets."""
    def at(i: int, j: int) -> tuple[float, float, float]:
        u, v = 2 * math.pi * i / nu, 2 * math.pi * j / nv
        r = 6 * (1 + 0.25 * math.sin(2 * u))
        d = 20 + r * math.cos(v)
        return d * math.cos(u), 0.7 * d * math.sin(u), r * math.sin(v) + 3 * math.sin(3 * u)

    out = ["solid ring"]
    for i in range(nu):
        for j in range(nv):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            for t in ((a, b, c), (a, c, d)):
                out += ["facet normal 0 0 0", "outer loop"]
                out += [f"vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in t]
                out += ["endloop", "endfacet"]
    path.write_text("\n".join([*out, "endsolid ring", ""]), encoding="ascii")


def main(folder: Path) -> None:
    """Draws all parts."""
    folder.mkdir(parents=True, exist_ok=True)
    for part in PARTS:
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(part.__name__)
        part()
        occ.synchronize()
        gmsh.write(str(folder / f"{part.__name__}.step"))
        print(part.__name__, len(gmsh.model.getEntities(2)), "faces")
        gmsh.finalize()
    ring_stl(folder / "ring.stl")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
