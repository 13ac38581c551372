"""The functions of the package."""

from __future__ import annotations

import logging
import math
import os
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Mapping, Sequence, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _csalf, _size
from ._csalf import Curve, Job
from ._curves import nodes
from ._errors import GeometryError, SizeError
from ._layers import Layer, layer_row
from ._mesh import Check, Mesh, joined
from ._model import FORMATS, Model, ModelMesh, mesh_model

log = logging.getLogger("csalf")

Line = Union[ArrayLike, Curve, Sequence[Curve]]
"""Points of shape (n, 2), which become mesh nodes; or a curve or chain of curves, which get nodes by the size."""
Lines = Union[Sequence[Line], Mapping[str, Line]]
Source = Union[str, "os.PathLike[str]", Any]


@dataclass(frozen=True)
class Grid:
    """Sizes on a rectangular grid. Row 0 is at the bottom; ``extent`` is x0, y0, x1, y1."""

    values: ArrayLike
    extent: tuple[float, float, float, float]


@dataclass(frozen=True)
class Sources:
    """The minimum of ``far`` and of spots, each (x, y, h, radius, falloff): h within the radius, then rising to
    ``far`` over the falloff."""

    far: float
    spots: Sequence[Sequence[float]] = ()


Size = Union[float, Callable[..., ArrayLike], tuple[ArrayLike, ArrayLike], NDArray[np.float64], Grid, Sources, None]


def mesh(
    source: Source = None,
    /,
    *,
    loops: Lines | None = None,
    scars: Lines = (),
    points: ArrayLike | Mapping[str, Sequence[float]] = (),
    size: Size = None,
    layers: Mapping[str, Layer] | None = None,
    method: str | None = None,
    preset: str | None = None,
    gradation: float | None = None,
    threads: int | None = None,
    allow_triangles: bool | None = None,
    repair_parity: bool | None = None,
    resample: bool = False,
    local_region: tuple[float, float, float] | None = None,
    name: str = "",
    format: str | None = None,
    progress: Callable[[str], object] | None = None,
) -> Mesh:
    """Meshes an outline, or a whole model.

    ``source`` is the path of a file that csalf reads, or an object with ``__geo_interface__`` (a shapely polygon). The
    path of a model (.step, .stp, .stl, .obj, .ply, .igs, .iges, .brep) or a ``Model`` goes to ``mesh_model``, which
    knows more of models.
    Or give ``loops``: the outer one first, then holes, or by name. Nodes that are given become mesh nodes, bit for
    bit; curves get nodes by the size, and so do all lines with ``resample``.

    ``size`` is a number, a function of arrays x and y, (points, values), a grid (over the box of the outline, row 0 at
    the bottom, or a ``Grid``), ``Sources``, or ``None``: the spacing of the boundary.

    ``layers`` asks for rings by name, ``*`` stands for any characters: ``{"hole*": 2, "outer": (1, "ramp", 0.1)}``. A
    value is a count; (count, law) or (count, law, first thickness); a list of thicknesses; or a dict of ``count``,
    ``law``, ``first``, ``thicknesses``. Laws: auto, constant, ramp, parabolic, fibonacci, geometric(Q).

    ``progress`` is called with the name of each stage as it begins; ``False`` ends the run with ``Cancelled``.

    An input of several outlines gives one mesh with a set of quads for each; ``mesh_all`` keeps them apart.

    Raises ``GeometryError`` with everything that is wrong with the outline, ``SizeError``, ``FormatError``.
    """
    if _is_model(source, format):
        given = dict(loops=loops, scars=scars, points=points, local_region=local_region)
        given |= dict(allow_triangles=allow_triangles, repair_parity=repair_parity, resample=resample, name=name)
        wrong = [k for k, v in given.items() if v is not None and v is not False and v != () and v != ""]
        number = _number(size)
        if wrong or (size is not None and number is None):
            raise TypeError(f"a model takes a number as size, no {', '.join(wrong) or 'other sizes'}: see mesh_model")
        return mesh_model(
            source,
            size=number,
            layers=layers,
            method=_first(method, "csalf"),
            preset=_first(preset, "quality"),
            gradation=gradation,
            threads=_first(threads, 0),
            format=format,
            progress=progress,
        )
    made = mesh_all(
        source,
        loops=loops,
        scars=scars,
        points=points,
        size=size,
        layers=layers,
        method=method,
        preset=preset,
        gradation=gradation,
        threads=threads,
        allow_triangles=allow_triangles,
        repair_parity=repair_parity,
        resample=resample,
        local_region=local_region,
        name=name,
        format=format,
        progress=progress,
    )
    return made[0] if len(made) == 1 else joined(made)


def mesh_all(
    source: Source = None,
    /,
    *,
    method: str | None = None,
    preset: str | None = None,
    gradation: float | None = None,
    threads: int | None = None,
    allow_triangles: bool | None = None,
    repair_parity: bool | None = None,
    progress: Callable[[str], object] | None = None,
    **what: Any,
) -> list[Mesh]:
    """One mesh for each outline of the input; arguments as those of ``mesh``."""
    list_of_jobs, of_file = _jobs(source, **what)
    options = {
        "method": _first(method, of_file.get("method"), "csalf"),
        "preset": _first(preset, of_file.get("preset"), "quality"),
        "threads": _first(threads, of_file.get("threads"), 0),
        "gradation": _first(gradation, of_file.get("gradation"), None),
        "allow_triangles": _first(allow_triangles, of_file.get("allow_triangles"), False),
        "repair_parity": _first(repair_parity, of_file.get("repair_parity"), False),
    }
    made = []
    for job in list_of_jobs:
        m = Mesh(_csalf.mesh(job, watch=progress, **options))
        for warning in m.report["warnings"] if log.isEnabledFor(logging.WARNING) and m.has_warnings else ():
            log.warning("%s: %s", job.name or "mesh", warning)
        made.append(m)
    return made


def jobs(source: Source = None, /, **what: Any) -> list[Job]:
    """What ``mesh_all`` would mesh, as jobs: they can be pickled, and written as job files (``to_json``)."""
    return _jobs(source, **what)[0]


def discretise(
    loops: Lines,
    size: Size = None,
    *,
    scars: Lines = (),
    points: ArrayLike | Mapping[str, Sequence[float]] = (),
) -> dict[str, Any]:
    """Nodes on curves, as far apart as the size says; the total over all loops is even. Returns ``loops`` and
    ``scars`` by name, as ``mesh`` takes them: ``csalf.mesh(**csalf.discretise(loops, 0.1), size=0.1)``."""
    (job,) = _jobs(None, loops=loops, scars=scars, points=points, size=size, resample=True)[0]
    return {"loops": {n: a for n, _, a in job.loops()}, "scars": dict(job.scars())}


def read(path: str | os.PathLike[str], format: str | None = None) -> Mesh:
    """Reads a mesh: .vtu, .msh, .inp, .bdf, .obj. One in space is a ``ModelMesh``: its faces are the quad sets that have
    no quad of an earlier one, and ``other`` for what is left."""
    raw = _csalf.read(os.fspath(path), format)
    return ModelMesh(raw) if isinstance(raw, _csalf.ModelMesh) else Mesh(raw)


def check(mesh: Mesh | str | os.PathLike[str], min_sj: float | None = None) -> Check:
    """Checks a mesh or a mesh file: convex, conforming, not worse than ``min_sj``."""
    m = mesh if isinstance(mesh, Mesh) else read(mesh)
    return m.check(min_sj)


def _is_model(source: Source, format: str | None) -> bool:
    if isinstance(source, (str, os.PathLike)):
        return (format or os.path.splitext(os.fspath(source))[1][1:]).lower() in FORMATS
    return isinstance(source, Model)


def _first(*values: Any) -> Any:
    return next((v for v in values if v is not None), None)


def _jobs(
    source: Source,
    *,
    loops: Lines | None = None,
    scars: Lines = (),
    points: ArrayLike | Mapping[str, Sequence[float]] = (),
    size: Size = None,
    layers: Mapping[str, Layer] | None = None,
    resample: bool = False,
    local_region: tuple[float, float, float] | None = None,
    name: str = "",
    format: str | None = None,
) -> tuple[list[Job], Mapping[str, Any]]:
    options: Mapping[str, Any] = {}
    if (source is None) == (loops is None):
        raise TypeError("give a source or loops, one of the two")
    if source is None:
        assert loops is not None
        made = [_job(name, loops, scars, points, size, resample)]
    elif isinstance(source, Job):
        made = [source]
    elif (geometry := getattr(source, "__geo_interface__", None)) is not None:
        parts = _rings(geometry)
        if not parts:
            raise GeometryError("the geometry holds no polygon")
        names = [name] if len(parts) == 1 else [f"{name or 'part'}{k}" for k in range(len(parts))]
        made = [_job(n, rings, scars, points, size, resample) for n, rings in zip(names, parts)]
    elif isinstance(source, (str, os.PathLike)):
        number = _number(size)
        made, options, notes = _csalf.read_jobs(os.fspath(source), number, resample, format)
        for note in notes:
            log.warning("%s: %s", os.fspath(source), note)
        if number is None and size is not None:
            for job in made:
                _give_size(job, size)
    else:
        raise TypeError(f"cannot mesh a {type(source).__name__}: give a path, a polygon, or loops=")
    for job in made:
        if layers is not None:
            job.clear_layers()
            for pattern, layer in layers.items():
                _give_layers(job, pattern, layer)
        if local_region is not None:
            job.set_local_region(*map(float, local_region))
    unmatched = [set(job.unmatched_layers()) for job in made]
    for pattern in sorted(set.intersection(*unmatched)) if unmatched else ():
        log.warning("layers for %r: nothing has such a name", pattern)
    return made, options


def _job(
    name: str,
    loops: Lines,
    scars: Lines,
    points: ArrayLike | Mapping[str, Sequence[float]],
    size: Size,
    resample: bool,
) -> Job:
    rims = _named(loops, ["outer"], "hole")
    cuts = _named(scars, [], "scar")
    outer = next((n for n, _ in rims if n == "outer"), rims[0][0] if rims else "")
    job = Job(name)
    for n, xy, h in _points(points):
        job.add_point(n, *xy, h)
    if not resample and not any(_is_curve(line) for _, line in rims + cuts):
        for n, line in rims:
            job.add_loop(n, n != outer, _open(nodes(_points_of(line))))
        for n, line in cuts:
            job.add_scar(n, nodes(_points_of(line)))
        _give_size(job, size)
        return job
    # Functions and grids need to know the box: that of the curves.
    like = Job(name)
    for n, line in rims:
        like.add_loop(n, n != outer, _samples(line))
    for n, xy, h in _points(points):
        like.add_point(n, *xy, h)
    _give_size(like, size)
    made, notes = _csalf.discretise(
        [(n, n != outer, _chain(line, closed=True)) for n, line in rims],
        [(n, _chain(line, closed=False)) for n, line in cuts],
        like,
    )
    for note in notes:
        log.info("%s", note.replace("--size sets it", "size= sets it"))
    _give_size(made, size)
    return made


def _named(lines: Lines, first: list[str], stem: str) -> list[tuple[str, Line]]:
    if isinstance(lines, Mapping):
        return [(str(n), line) for n, line in lines.items()]
    if isinstance(lines, np.ndarray) and lines.ndim == 2:
        raise TypeError("give a list of arrays, one for each loop or scar, not one array")
    names = (first[k] if k < len(first) else f"{stem}{k - len(first)}" for k in range(len(lines)))
    return list(zip(names, lines))


def _is_curve(line: Line) -> bool:
    return isinstance(line, Curve) or (isinstance(line, (list, tuple)) and bool(line) and isinstance(line[0], Curve))


def _points_of(line: Line) -> ArrayLike:
    return cast("ArrayLike", line)


def _chain(line: Line, closed: bool) -> list[Curve]:
    if isinstance(line, Curve):
        return [line]
    if _is_curve(line):
        return list(cast("Sequence[Curve]", line))
    xy = nodes(_points_of(line))
    return [Curve.polyline(np.concatenate([xy, xy[:1]]) if closed and (xy[0] != xy[-1]).any() else xy)]


def _samples(line: Line) -> NDArray[np.float64]:
    if not _is_curve(line):
        return nodes(_points_of(line))
    return np.array([c.at(t) for c in _chain(line, False) for t in np.linspace(0.0, 1.0, 33)])


def _open(xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Without a last node that repeats the first."""
    return xy[:-1] if len(xy) > 1 and (xy[0] == xy[-1]).all() else xy


def _points(
    points: ArrayLike | Mapping[str, Sequence[float]],
) -> list[tuple[str, tuple[float, float], float | None]]:
    if isinstance(points, Mapping):
        rows: Iterable[tuple[str, Any]] = points.items()
    else:
        array: Any = points
        rows = ((f"point{k}", p) for k, p in enumerate(array))
    out = []
    for n, row in rows:
        x, y, *rest = (float(v) for v in row)
        if len(rest) > 1:
            raise ValueError(f"{n}: a point is (x, y) or (x, y, size)")
        out.append((str(n), (x, y), rest[0] if rest and not math.isnan(rest[0]) else None))
    return out


def _number(size: Any) -> float | None:
    number = isinstance(size, (int, float, np.integer, np.floating)) and not isinstance(size, bool)
    return float(size) if number else None


def _give_size(job: Job, size: Size) -> None:
    if size is None:
        return
    number = _number(size)
    if number is not None:
        job.size_uniform(number)
    elif isinstance(size, Sources):
        spots = np.ascontiguousarray(size.spots, dtype=np.float64).reshape(-1, 5)
        job.size_sources(float(size.far), spots)
    elif isinstance(size, Grid):
        job.size_background(*_size.on_grid(size.values, size.extent))
    elif callable(size):
        job.size_background(*_size.of_function(size, job.bounds()))
    elif isinstance(size, tuple) and len(size) == 2:
        xy, values = nodes(size[0]), np.ascontiguousarray(size[1], dtype=np.float64)
        if values.shape != (len(xy),):
            raise SizeError(f"{len(xy)} points, but values of shape {values.shape}")
        p, t, v = _csalf.triangles(xy, values)
        job.size_background(p, t, np.asarray(v))
    else:
        array = np.asarray(size, dtype=np.float64)
        if array.ndim != 2:
            raise TypeError("size is a number, a function, (points, values), a 2D array, Grid, Sources or None")
        job.size_background(*_size.on_grid(array, job.bounds()))


def _give_layers(job: Job, pattern: str, layer: Layer) -> None:
    job.add_layers(*layer_row(pattern, layer))


def _rings(geometry: Mapping[str, Any]) -> list[list[NDArray[np.float64]]]:
    """The polygons of a GeoJSON-like mapping, each as its rings."""
    kind = geometry["type"]
    if kind == "Polygon":
        rings = [_open(nodes(np.asarray(r, dtype=np.float64)[:, :2])) for r in geometry["coordinates"]]
        return [rings] if rings else []
    if kind == "MultiPolygon":
        return [p for c in geometry["coordinates"] for p in _rings({"type": "Polygon", "coordinates": c})]
    if kind == "Feature":
        return _rings(geometry["geometry"])
    parts = geometry.get("features", geometry.get("geometries", ()))
    return [p for part in parts for p in _rings(part)]
