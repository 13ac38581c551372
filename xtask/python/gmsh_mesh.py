"""Meshes one job with gmsh, for `cargo xtask compare`: Frontal-Delaunay for quads (8) and Blossom recombination.

Usage: python gmsh_mesh.py INPUT.json OUTPUT.json

INPUT:  {"loops": [[[x, y], ...], ...], "scars": [...], "points": [[x, y], ...],
         "size": {"uniform": h} | {"far": h, "sources": [{"xy", "h", "radius", "falloff"}]}
               | {"points": [[x, y], ...], "triangles": [[a, b, c], ...], "values": [h, ...]}}
OUTPUT: {"version", "cpu_s", "wall_s", "rss_mb", "points", "quads", "triangles"}; times of the meshing alone, memory
        above that before it. The outer loop comes first.

gmsh runs as it is installed, through its published Python interface, in a process of its own.
"""

import json
import resource
import sys
import time

import gmsh


def size_field(size):
    """The background field; sizes come from it alone."""
    field = gmsh.model.mesh.field
    if "uniform" in size:
        tag = field.add("MathEval")
        field.setString(tag, "F", repr(float(size["uniform"])))
    elif "sources" in size:
        parts = []
        for s, at in zip(size["sources"], size["tags"]):
            distance, threshold = field.add("Distance"), field.add("Threshold")
            field.setNumbers(distance, "PointsList", [at])
            for key, value in (
                ("InField", distance),
                ("SizeMin", s["h"]),
                ("SizeMax", size["far"]),
                ("DistMin", s["radius"]),
                ("DistMax", s["radius"] + s["falloff"]),
            ):
                field.setNumber(threshold, key, value)
            parts.append(threshold)
        tag = field.add("Min")
        field.setNumbers(tag, "FieldsList", parts)
    else:
        view = gmsh.view.add("h")
        p, h = size["points"], size["values"]
        data = []
        for t in size["triangles"]:
            data += [p[v][0] for v in t] + [p[v][1] for v in t] + [0.0] * 3 + [h[v] for v in t]
        gmsh.view.addListData(view, "ST", len(size["triangles"]), data)
        tag = field.add("PostView")
        field.setNumber(tag, "ViewTag", view)
    field.setAsBackgroundMesh(tag)


def build(job):
    """Geometry with one straight transfinite curve per given segment, which keeps the boundary as it is."""
    geo, mesh = gmsh.model.geo, gmsh.model.mesh
    lines, loops = [], []
    for loop in job["loops"]:
        tags = [geo.addPoint(x, y, 0) for x, y in loop]
        sides = [geo.addLine(tags[i], tags[(i + 1) % len(tags)]) for i in range(len(tags))]
        loops.append(geo.addCurveLoop(sides))
        lines += sides
    surface = geo.addPlaneSurface(loops)
    known = {}
    for loop in job["loops"]:
        for x, y in loop:
            known.setdefault((x, y), len(known) + 1)
    inner = []
    for scar in job["scars"]:
        tags = []
        for x, y in scar:
            if (x, y) not in known:
                known[(x, y)] = geo.addPoint(x, y, 0)
            tags.append(known[(x, y)])
        inner += [geo.addLine(a, b) for a, b in zip(tags, tags[1:])]
    points = [geo.addPoint(x, y, 0) for x, y in job["points"]]
    if "sources" in job["size"]:
        job["size"]["tags"] = [geo.addPoint(*s["xy"], 0) for s in job["size"]["sources"]]
    geo.synchronize()
    for line in lines + inner:
        mesh.setTransfiniteCurve(line, 2)
    if inner:
        mesh.embed(1, inner, 2, surface)
    if points:
        mesh.embed(0, points, 2, surface)


def main():
    with open(sys.argv[1], encoding="utf-8") as f:
        job = json.load(f)
    gmsh.initialize()
    for name, value in (
        ("General.Terminal", 0),
        ("General.NumThreads", 1),
        ("Mesh.Algorithm", 8),
        ("Mesh.RecombineAll", 1),
        ("Mesh.RecombinationAlgorithm", 1),
        ("Mesh.MeshSizeFromPoints", 0),
        ("Mesh.MeshSizeExtendFromBoundary", 0),
    ):
        gmsh.option.setNumber(name, value)
    build(job)
    size_field(job["size"])
    peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    before, wall, cpu = peak(), time.perf_counter(), time.process_time()
    gmsh.model.mesh.generate(2)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    out = {"cpu_s": cpu, "wall_s": wall, "rss_mb": peak() - before}
    out["version"] = gmsh.option.getString("General.Version")
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    place = {int(t): i for i, t in enumerate(tags)}
    xyz = xyz.reshape(-1, 3)
    elements = {3: [], 2: []}
    for kind, _, nodes in zip(*gmsh.model.mesh.getElements(2)):
        n = {3: 4, 2: 3}.get(kind)
        if n:
            elements[kind] = [[place[int(t)] for t in e] for e in nodes.reshape(-1, n)]
    used = sorted({v for group in elements.values() for e in group for v in e})
    new = {v: i for i, v in enumerate(used)}
    out["points"] = [[float(xyz[v][0]), float(xyz[v][1])] for v in used]
    out["quads"] = [[new[v] for v in e] for e in elements[3]]
    out["triangles"] = [[new[v] for v in e] for e in elements[2]]
    gmsh.finalize()
    with open(sys.argv[2], "w", encoding="utf-8") as f:
        json.dump(out, f)


if __name__ == "__main__":
    main()
