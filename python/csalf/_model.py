"""Whole models: STEP files, facets, and IGES and BREP files by way of STEP."""

from __future__ import annotations

import logging
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _cad, _csalf
from ._errors import FaceFailure, ModelError, SizeError
from ._layers import Layer, layer_row
from ._mesh import Floats, Indices, Mesh

if TYPE_CHECKING:
    import matplotlib.axes

log = logging.getLogger("csalf")

FORMATS = ("step", "stp", "p21", "stl", "obj", "ply", *_cad.FORMATS)
"""Formats, and extensions, of models."""


class Model:
    """A CAD model or a model of facets, as it was read: instances placed, edges sewn, everything checked."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        format: str | None = None,
        *,
        feature_angle: float | None = None,
        sewing: float | None = None,
    ) -> None:
        """Reads .step, .stp, .stl, .obj or .ply, and with Open CASCADE (``pip install 'csalf[cad]'``) .igs, .iges,
        .brep or .brp. Facets fall into faces where the normal turns by more than ``feature_angle`` degrees (40).
        Edges within the length ``sewing`` become one; without it 1e-6 of the diagonal, or up to 1e-4 of it if that closes
        the model. Raises ``FormatError``, ``OSError``, ``MissingError`` without Open CASCADE, ``ValueError`` if
        ``sewing`` is not positive or more than a hundredth of the diagonal."""
        if sewing is not None and not sewing > 0:
            raise ValueError("sewing: a positive length")
        self._notes: list[str] = []
        self._has_unit = True
        given = os.fspath(path)
        kind = _cad.format_of(given, format)
        if kind is None:
            self._raw = _csalf.Model.read(given, format, feature_angle, sewing)
            return
        step, self._notes = _cad.convert(given, kind)
        self._raw = _csalf.Model.from_bytes(step, given, _cad.stem(given), "step", None, sewing)
        self._has_unit = kind != "brep"

    @property
    def name(self) -> str:
        return self._raw.name

    @property
    def unit(self) -> str:
        """Name of the unit of length; empty if unknown."""
        return self._raw.unit if self._has_unit else ""

    @property
    def notes(self) -> list[str]:
        """What the import left out or repaired, in words."""
        return self._notes + self._raw.notes

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Corners of the box around it, (2, 3)."""
        return np.array(self._raw.bounds())

    @property
    def faces(self) -> list[tuple[str, str]]:
        """Name and kind of surface (plane, cylinder, ..., facets) of each face."""
        return self._raw.faces()

    @property
    def edges(self) -> list[str]:
        """Names of the edges."""
        return self._raw.edges()

    @property
    def holes(self) -> dict[str, float]:
        """Diameter by name of holes: full circles; of slots the width."""
        return {name: d for name, _, d in self._raw.loops() if d is not None}

    @property
    def loops(self) -> list[tuple[str, str]]:
        """Name of each loop, and that of its face: what ``layers`` may name."""
        faces = self.faces
        return [(name, faces[f][0]) for name, f, _ in self._raw.loops()]

    def __repr__(self) -> str:
        return f"<csalf.Model {self.name!r}: {len(self.faces)} faces, {len(self.edges)} edges>"


Source = Union[str, "os.PathLike[str]", Model]


class ModelMesh(Mesh):
    """The mesh of a model: a ``Mesh`` with three coordinates. Made by ``csalf.mesh_model``.

    Quad sets are the faces of the model and the layers around loops, edge sets its edges.
    """

    _raw: _csalf.ModelMesh  # type: ignore[assignment]

    def __init__(self, raw: _csalf.ModelMesh) -> None:
        self._raw = raw

    @property
    def faces(self) -> list[str]:
        """Names of the faces of the model."""
        return self._raw.face_names()

    @cached_property
    def face_of_quad(self) -> Indices:
        """Which face each quad is of, (m,)."""
        return self._raw.face_of_quad()

    @cached_property
    def failures(self) -> tuple[FaceFailure, ...]:
        """Faces without a mesh."""
        return tuple(FaceFailure(*f) for f in self._raw.failures())

    @property
    def warnings(self) -> list[str]:
        """What could not be done better, and what was repaired, in words."""
        return self._raw.warnings

    @property
    def n_free_sides(self) -> int:
        """Sides of one quad only: none in the mesh of a solid."""
        return self._raw.n_sides()[0]

    @property
    def n_branching_sides(self) -> int:
        """Sides of three quads and more."""
        return self._raw.n_sides()[1]

    def plot(
        self, metric: str | None = "scaled_jacobian", *, ax: matplotlib.axes.Axes | None = None, **style: Any
    ) -> matplotlib.axes.Axes:
        """Draws the mesh by matplotlib in three dimensions, coloured by a metric or (``None``) plain."""
        import matplotlib as mpl
        import matplotlib.pyplot as plt
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        axes: Any = plt.figure().add_subplot(projection="3d") if ax is None else ax
        style = {"edgecolors": "0.25", "linewidths": 0.2, **style}
        if metric is not None:
            values = self.metric(metric)
            bounded = metric in ("scaled_jacobian", "shape", "skew")
            norm = mpl.colors.Normalize(0.0, 1.0) if bounded else mpl.colors.Normalize(values.min(), values.max())
            colours = mpl.cm.ScalarMappable(norm, style.pop("cmap", "RdYlGn"))
            style = {"facecolors": colours.to_rgba(values), **style}
            axes.figure.colorbar(colours, ax=axes, label=metric.replace("_", " "))
        axes.add_collection3d(Poly3DCollection(self.points[self.quads], **style))
        low, high = self.points.min(0), self.points.max(0)
        for k, axis in enumerate("xyz"):
            getattr(axes, f"set_{axis}lim")(low[k], high[k])
        axes.set_box_aspect(np.maximum(high - low, 1e-3 * np.ptp(self.points)))
        return axes  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        failed = f", {len(self.failures)} without a mesh" if self.failures else ""
        return (
            f"<csalf.ModelMesh {self.name!r}: {len(self.faces)} faces{failed}, {len(self.points)} points, "
            f"{len(self.quads)} quads>"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        sets = [{n: np.asarray(a) for n, a in s.items()} for s in (self.node_sets, self.edge_sets, self.quad_sets)]
        raw = self._raw
        arrays = (np.array(self.points), np.array(self.quads), np.array(self.face_of_quad))
        rest = (raw.failures(), raw.layers(), raw.warnings, raw.n_sides())
        return _unpickled, (raw.name, raw.face_names(), *arrays, sets, *rest)

    def _points3(self) -> Floats:
        return self.points

    def _values(self, cell_data: Mapping[str, ArrayLike] | None) -> list[tuple[str, Floats]]:
        if cell_data is None and not self.cell_data:
            cell_data = {"face": self.face_of_quad, "scaled_jacobian": self.scaled_jacobian}
        return super()._values(cell_data)


def _unpickled(
    name: str,
    faces: list[str],
    points: Floats,
    quads: Indices,
    face_of_quad: Indices,
    sets: list[dict[str, Any]],
    failures: list[Any],
    layers: list[Any],
    warnings: list[str],
    n_sides: tuple[int, int],
) -> ModelMesh:
    lists = tuple([(n, a.tolist()) for n, a in s.items()] for s in sets)
    raw = _csalf.ModelMesh(
        name, faces, points, quads, face_of_quad.tolist(), lists, failures, layers, warnings, n_sides
    )
    return ModelMesh(raw)


class Wish:
    """What is asked of the mesh of a model; can be pickled. Arguments as those of ``mesh_model``."""

    def __init__(
        self,
        *,
        size: float | None = None,
        min_size: float | None = None,
        per_turn: float | None = None,
        gradation: float | None = None,
        face_sizes: Mapping[str, float] | None = None,
        edge_sizes: Mapping[str, float] | None = None,
        loop_sizes: Mapping[str, float] | None = None,
        edge_counts: Mapping[str, int] | None = None,
        layers: Mapping[str, Layer] | None = None,
        points: Mapping[str, Sequence[float]] | ArrayLike = (),
        method: str = "csalf",
        preset: str = "quality",
    ) -> None:
        self.size = _length("size", size)
        self.min_size = _length("min_size", min_size)
        self.per_turn = None if per_turn is None else float(per_turn)
        self.gradation = _length("gradation", gradation)
        self.face_sizes = [(n, _given(f"face_sizes[{n!r}]", h)) for n, h in (face_sizes or {}).items()]
        self.edge_sizes = [(n, _given(f"edge_sizes[{n!r}]", h)) for n, h in (edge_sizes or {}).items()]
        self.loop_sizes = [(n, _given(f"loop_sizes[{n!r}]", h)) for n, h in (loop_sizes or {}).items()]
        self.edge_counts = [(n, int(k)) for n, k in (edge_counts or {}).items()]
        self.layers = [layer_row(pattern, layer) for pattern, layer in (layers or {}).items()]
        if not isinstance(points, Mapping):
            points = {f"point{k}": p for k, p in enumerate(_rows(points))}
        self.points = [(str(n), _place(n, p)) for n, p in points.items()]
        self.method = method
        self.preset = preset


def mesh_model(
    source: Source,
    /,
    *,
    size: float | None = None,
    min_size: float | None = None,
    per_turn: float | None = None,
    gradation: float | None = None,
    face_sizes: Mapping[str, float] | None = None,
    edge_sizes: Mapping[str, float] | None = None,
    loop_sizes: Mapping[str, float] | None = None,
    edge_counts: Mapping[str, int] | None = None,
    layers: Mapping[str, Layer] | None = None,
    points: Mapping[str, Sequence[float]] | ArrayLike = (),
    method: str = "csalf",
    preset: str = "quality",
    threads: int = 0,
    format: str | None = None,
    partial: bool = False,
    progress: Callable[[str], object] | None = None,
) -> ModelMesh:
    """Meshes all faces of a CAD model or a model of facets, conforming across shared edges.

    ``source`` is the path of a file that ``Model`` reads, or a ``Model``. ``size`` is the edge length where nothing
    asks for less (a fortieth of the diagonal); curvature asks for ``per_turn`` (12) elements per full turn,
    down to ``min_size`` (a tenth of the size); the size grows by at most ``gradation`` (0.3) per length.
    ``face_sizes``, ``edge_sizes`` and ``edge_counts`` are by pattern of names, ``points`` become nodes of the nearest
    face. ``loop_sizes`` are for all edges of a loop, by its name or diameter: ``{"hole<12": 0.5}``.

    ``layers`` are as those of ``mesh``, by names of loops, or by diameter: ``{"hole<12": 2}``.

    Raises ``ModelError`` if some faces have no mesh: it has the failures, each with the face's flat boundary as a job,
    and the mesh of the others; with ``partial`` that mesh is returned. Raises ``FormatError``, ``SizeError``.
    """
    wish = Wish(
        size=size,
        min_size=min_size,
        per_turn=per_turn,
        gradation=gradation,
        face_sizes=face_sizes,
        edge_sizes=edge_sizes,
        loop_sizes=loop_sizes,
        edge_counts=edge_counts,
        layers=layers,
        points=points,
        method=method,
        preset=preset,
    )
    model = source if isinstance(source, Model) else Model(source, format)
    mesh = ModelMesh(model._raw.plan(wish).mesh(threads, progress))
    return finished(mesh, partial)


def finished(mesh: ModelMesh, partial: bool) -> ModelMesh:
    """The mesh, or the exception of its faces without one; warnings go to the log."""
    for warning in mesh.warnings:
        log.warning("%s: %s", mesh.name, warning)
    if mesh.failures and not partial:
        first = mesh.failures[0]
        message = f"{len(mesh.failures)} of {len(mesh.faces)} faces have no mesh: {first}"
        raise ModelError(message, mesh.failures, mesh)
    return mesh


def stitch(shards: Sequence[str | os.PathLike[str] | bytes], *, partial: bool = False) -> ModelMesh:
    """One mesh out of the shards of ``csalf mesh --shard`` (paths or bytes), in any order: the same as of a run in one
    piece. Raises ``ShardError`` if they are damaged, of different runs, missing or there twice."""
    named: list[tuple[str, bytes]] = []
    for k, shard in enumerate(shards):
        if isinstance(shard, bytes):
            named.append((f"shard {k}", shard))
        else:
            with open(shard, "rb") as file:
                named.append((os.fspath(shard), file.read()))
    return finished(ModelMesh(_csalf.stitch(named)), partial)


def _length(what: str, value: float | None) -> float | None:
    return None if value is None else _given(what, value)


def _given(what: str, value: float) -> float:
    number = float(value)
    if not (number > 0.0 and np.isfinite(number)):
        raise SizeError(f"{what} is {number}, not a positive number", what, None, number)
    return number


def _rows(points: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(points, dtype=np.float64).reshape(-1, 3)


def _place(name: object, point: Sequence[float]) -> tuple[float, float, float]:
    if len(point) != 3:
        raise ValueError(f"{name}: a point of a model is (x, y, z)")
    return float(point[0]), float(point[1]), float(point[2])
