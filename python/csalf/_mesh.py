"""The mesh as Python sees it."""

from __future__ import annotations

import base64
import html
import json
import os
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _csalf

if TYPE_CHECKING:
    import matplotlib.axes
    import meshio
    import pyvista

Floats = NDArray[np.float64]
Indices = NDArray[np.uint32]
Sets = Mapping[str, Indices]

SVG_LIMIT = 5_000  # more quads than this are shown as pixels in notebooks


@dataclass(frozen=True)
class Check:
    """The outcome of a check; true if all is well."""

    findings: tuple[str, ...]
    quality: Mapping[str, Any]

    @property
    def ok(self) -> bool:
        return not self.findings

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
        return "\n".join(self.findings) or "all well"


class Mesh:
    """A mesh of quads. It does not change: its arrays are read-only and lie in the memory of the mesher.

    Made by ``csalf.mesh`` and ``csalf.read``, or from arrays by ``Mesh.from_arrays``.
    """

    def __init__(self, raw: _csalf.Mesh, report: dict[str, Any] | None = None) -> None:
        self._raw = raw
        if report is not None:
            self.__dict__["report"] = report

    @classmethod
    def from_arrays(
        cls,
        points: ArrayLike,
        quads: ArrayLike,
        triangles: ArrayLike = (),
        *,
        node_sets: Mapping[str, ArrayLike] | None = None,
        edge_sets: Mapping[str, ArrayLike] | None = None,
        quad_sets: Mapping[str, ArrayLike] | None = None,
    ) -> Mesh:
        """A mesh of (n, 2) points, (m, 4) quads and (k, 3) triangles, counter-clockwise. Arrays are copied."""
        return cls(_raw(points, quads, triangles, node_sets or {}, edge_sets or {}, quad_sets or {}))

    # Arrays

    @cached_property
    def points(self) -> Floats:
        """Coordinates, (n, 2), of models (n, 3). The nodes of the input come first, in input order."""
        return self._raw.points

    @cached_property
    def quads(self) -> Indices:
        """Four vertices per quad, (m, 4), counter-clockwise."""
        return self._raw.quads

    @cached_property
    def triangles(self) -> Indices:
        """Three vertices per triangle, (k, 3); none unless they were allowed."""
        return self._raw.triangles

    @cached_property
    def boundary(self) -> Indices:
        """The edges of the boundary, (b, 2), the material on their left."""
        return self._raw.boundary()

    @cached_property
    def node_sets(self) -> Sets:
        """Vertices by name of loop, scar or point, in order along the curve."""
        return self._raw.node_sets()

    @cached_property
    def edge_sets(self) -> Sets:
        """Edges (k, 2) by name of loop or scar."""
        return self._raw.edge_sets()

    @cached_property
    def quad_sets(self) -> Sets:
        """Quads by name: ``hole0_layer1``, ..."""
        return self._raw.quad_sets()

    @cached_property
    def cell_data(self) -> Mapping[str, Floats]:
        """Values per element that came with a file; quads first, then triangles."""
        return self._raw.cell_data()

    # Quality

    def metric(self, name: str) -> Floats:
        """A metric per element, quads first, then triangles (NaN where it is not defined): scaled_jacobian, shape,
        skew, aspect_ratio, jacobian_ratio, min_angle, max_angle, area, edge_ratio, min_edge,
        warpage, size_ratio."""
        return self._raw.metric(name)

    @cached_property
    def scaled_jacobian(self) -> Floats:
        """-1 to 1; 1 is a rectangle."""
        return self.metric("scaled_jacobian")

    @cached_property
    def shape(self) -> Floats:
        """Verdict's shape, 0 to 1; 1 is a square."""
        return self.metric("shape")

    @cached_property
    def skew(self) -> Floats:
        """0 to 1; 0 is a rectangle or a rhombus along its axes."""
        return self.metric("skew")

    @cached_property
    def aspect_ratio(self) -> Floats:
        """1 and more."""
        return self.metric("aspect_ratio")

    @cached_property
    def min_angle(self) -> Floats:
        """Smallest interior angle, degrees."""
        return self.metric("min_angle")

    @cached_property
    def max_angle(self) -> Floats:
        """Largest interior angle, degrees."""
        return self.metric("max_angle")

    @cached_property
    def area(self) -> Floats:
        """Signed area."""
        return self.metric("area")

    @cached_property
    def size_ratio(self) -> Floats:
        """Root of the area over the wanted size; NaN of a mesh that was read."""
        return self.metric("size_ratio")

    @cached_property
    def report(self) -> dict[str, Any]:
        """Counts, quality, layers asked and made, warnings, times: what ``csalf mesh --report`` writes."""
        report: dict[str, Any] = json.loads(self._raw.report_json())
        return report

    @property
    def quality(self) -> dict[str, Any]:
        """The quality figures of the report."""
        quality: dict[str, Any] = self.report["quality"]
        return quality

    @property
    def name(self) -> str:
        return str(self.report["name"]) if "report" in self.__dict__ else self._raw.name

    def check(self, min_sj: float | None = None) -> Check:
        """Convex, conforming, no element below ``min_sj``?"""
        findings = self._raw.findings()
        least = self.quality["min_sj"]
        if min_sj is not None and not least >= min_sj:
            findings.append(f"the smallest scaled Jacobian is {least:.4f}, less than {min_sj}")
        return Check(tuple(findings), self.quality)

    # Files and other programs

    def write(
        self,
        path: str | os.PathLike[str],
        format: str | None = None,
        *,
        order: int = 1,
        centres: bool = False,
        element: str = "shell",
        cell_data: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Writes a file: .vtu, .msh (``format="msh22"`` for Gmsh 2.2), .inp, .bdf, .exo, .unv, .su2, .obj, .foam (a
        case of OpenFOAM beside it), .vtkhdf, .mesh (ISM-v2), .svg, .png. ``cell_data``
        goes with formats that hold values; without it, the scaled Jacobian.

        ``order=2`` gives quadratic elements, with mid-side nodes on the curves where loops were given as curves, of models
        on their edges and surfaces (not of stitched, unpickled and read meshes, which know none); with ``centres`` quads have
        nine nodes. ``element`` is that of .inp: shell, plane-stress, plane-strain, axisymmetric.
        """
        if order not in (1, 2) or (centres and order == 1):
            raise ValueError("order is 1 or 2, and centres go with order 2")
        nodes = 4 if order == 1 else 9 if centres else 8
        self._raw.write(os.fspath(path), format, self._values(cell_data), nodes, element)

    def svg(self) -> str:
        """The picture as SVG."""
        return self._raw.encode("svg", []).decode()

    def png(self) -> bytes:
        """The picture as PNG, coloured by the scaled Jacobian."""
        return self._raw.encode("png", [])

    def to_meshio(self) -> meshio.Mesh:
        """As ``meshio.Mesh``, with point and cell sets; edge sets are sets of a block of lines."""
        import meshio

        edges = [e for e in self.edge_sets.values() if len(e)]
        blocks: list[Any] = [("quad", self.quads)]
        if len(self.triangles):
            blocks.append(("triangle", self.triangles))
        if edges:
            blocks.append(("line", np.concatenate(edges)))

        def only(block: int, members: Any) -> list[Any]:
            empty = np.empty(0, dtype=np.int64)
            return [np.asarray(members, dtype=np.int64) if k == block else empty for k in range(len(blocks))]

        cell_sets = {name: only(0, members) for name, members in self.quad_sets.items()}
        start = 0
        for name, members in self.edge_sets.items():
            key = name if name not in cell_sets else f"{name}_edges"
            cell_sets[key] = only(len(blocks) - 1, np.arange(start, start + len(members)))
            start += len(members)
        return meshio.Mesh(
            self._points3(),
            blocks,
            point_sets={n: np.asarray(v, dtype=np.int64) for n, v in self.node_sets.items()},
            cell_sets=cell_sets,
        )

    def to_pyvista(self) -> pyvista.UnstructuredGrid:
        """As ``pyvista.UnstructuredGrid``, with the scaled Jacobian per cell."""
        import pyvista

        cells = {pyvista.CellType.QUAD: self.quads.astype(np.int64)}
        if len(self.triangles):
            cells[pyvista.CellType.TRIANGLE] = self.triangles.astype(np.int64)
        grid = pyvista.UnstructuredGrid(cells, self._points3())
        grid.cell_data["scaled_jacobian"] = self.scaled_jacobian
        return grid

    def plot(
        self, metric: str | None = "scaled_jacobian", *, ax: matplotlib.axes.Axes | None = None, **style: Any
    ) -> matplotlib.axes.Axes:
        """Draws the mesh by matplotlib, coloured by a metric or (``None``) plain. ``style`` goes to the collection."""
        import matplotlib.pyplot as plt
        from matplotlib.collections import PolyCollection

        if ax is None:
            ax = plt.figure().add_subplot()
        polygons = [*self.points[self.quads], *self.points[self.triangles]]
        style = {"edgecolors": "0.25", "linewidths": 0.3, **style}
        if metric is None:
            drawn = PolyCollection(polygons, **{"facecolors": "white", **style})
        else:
            limits = {"clim": (0.0, 1.0)} if metric in ("scaled_jacobian", "shape", "skew") else {}
            drawn = PolyCollection(polygons, array=self.metric(metric), **{**limits, "cmap": "RdYlGn", **style})
            ax.figure.colorbar(drawn, ax=ax, label=metric.replace("_", " "))
        ax.add_collection(drawn)
        ax.autoscale_view()
        ax.set_aspect("equal")
        return ax

    # Python

    @property
    def has_warnings(self) -> bool:
        """Whether the report has warnings; costs nothing."""
        return self._raw.n_warnings > 0

    def __repr__(self) -> str:
        triangles = f", {len(self.triangles)} triangles" if len(self.triangles) else ""
        return f"<csalf.Mesh {self.name!r}: {len(self.points)} points, {len(self.quads)} quads{triangles}>"

    def _repr_html_(self) -> str:
        q = self.quality
        if len(self.quads) <= SVG_LIMIT:
            picture = self.svg()
            picture = picture[picture.index("<svg") :]
        else:
            data = base64.b64encode(self.png()).decode()
            picture = f'<img style="max-width:100%" alt="the mesh" src="data:image/png;base64,{data}">'
        text = (
            f"{self.name or 'mesh'}: {q['n_vertices']} points, {q['n_quads']} quads; scaled Jacobian at least "
            f"{q['min_sj']:.3f}, {q['mean_sj']:.3f} in the mean"
        )
        if "n_irregular" in q:
            text += f"; {q['n_irregular']} irregular vertices"
        return f'<div style="max-width:640px">{picture}<div>{html.escape(text)}</div></div>'

    def __reduce__(self) -> tuple[Any, ...]:
        sets = [{n: np.asarray(a) for n, a in s.items()} for s in (self.node_sets, self.edge_sets, self.quad_sets)]
        return _unpickled, (np.array(self.points), np.array(self.quads), np.array(self.triangles), *sets, self.report)

    def _points3(self) -> Floats:
        return np.column_stack([self.points, np.zeros(len(self.points))])

    def _values(self, cell_data: Mapping[str, ArrayLike] | None) -> list[tuple[str, Floats]]:
        if cell_data is None:
            cell_data = self.cell_data or {"scaled_jacobian": self.scaled_jacobian}
        n = len(self.quads) + len(self.triangles)
        out = []
        for name, values in cell_data.items():
            array = np.ascontiguousarray(values, dtype=np.float64)
            if array.shape != (n,):
                raise ValueError(f"{name}: expected {n} values, one per element, not the shape {array.shape}")
            out.append((name, array))
        return out


def _raw(
    points: ArrayLike,
    quads: ArrayLike,
    triangles: ArrayLike,
    node_sets: Mapping[str, ArrayLike],
    edge_sets: Mapping[str, ArrayLike],
    quad_sets: Mapping[str, ArrayLike],
) -> _csalf.Mesh:
    def ids(a: ArrayLike, *shape: int) -> Indices:
        array = np.asarray(a)
        if array.size and (array.min() < 0 or array.max() >= 2**32):
            raise ValueError("indices are 0 to 2^32 - 1")
        return np.ascontiguousarray(array, dtype=np.uint32).reshape(-1, *shape)

    sets = (
        [(n, ids(a).tolist()) for n, a in node_sets.items()],
        [(n, ids(a, 2).tolist()) for n, a in edge_sets.items()],
        [(n, ids(a).tolist()) for n, a in quad_sets.items()],
    )
    xy = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 2)
    return _csalf.Mesh(xy, ids(quads, 4), ids(triangles, 3), sets)


def _unpickled(
    points: Floats, quads: Indices, triangles: Indices, nodes: Sets, edges: Sets, faces: Sets, report: dict[str, Any]
) -> Mesh:
    return Mesh(_raw(points, quads, triangles, nodes, edges, faces), report)


def joined(parts: Sequence[Mesh]) -> Mesh:
    """One mesh of several that do not touch. Sets are called ``part/set``; each part is a set of quads."""
    names: list[str] = []
    for k, m in enumerate(parts):
        name = m.name or f"part{k}"
        names.append(name if name not in names else f"{name}_{k}")
    node_sets: dict[str, Any] = {}
    edge_sets: dict[str, Any] = {}
    quad_sets: dict[str, Any] = {}
    n_points = n_quads = 0
    quads, triangles = [], []
    for name, m in zip(names, parts):
        quad_sets[name] = np.arange(n_quads, n_quads + len(m.quads))
        node_sets |= {f"{name}/{n}": a.astype(np.int64) + n_points for n, a in m.node_sets.items()}
        edge_sets |= {f"{name}/{n}": a.astype(np.int64) + n_points for n, a in m.edge_sets.items()}
        quad_sets |= {f"{name}/{n}": a.astype(np.int64) + n_quads for n, a in m.quad_sets.items()}
        quads.append(m.quads.astype(np.int64) + n_points)
        triangles.append(m.triangles.astype(np.int64) + n_points)
        n_points, n_quads = n_points + len(m.points), n_quads + len(m.quads)
    points = np.concatenate([m.points for m in parts])
    raw = _raw(points, np.concatenate(quads), np.concatenate(triangles), node_sets, edge_sets, quad_sets)
    report = json.loads(raw.report_json())
    report["parts"] = [m.report for m in parts]
    report["warnings"] = [w for m in parts for w in m.report.get("warnings", ())]
    return Mesh(raw, report)
