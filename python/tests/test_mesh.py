"""Arrays in, arrays out."""

from __future__ import annotations

import pickle
import time

import numpy as np
import pytest
from conftest import rectangle, ring

import csalf


def is_sound(mesh: csalf.Mesh, area: float | None = None) -> None:
    assert mesh.check(), str(mesh.check())
    assert len(mesh.triangles) == 0
    assert mesh.scaled_jacobian.min() > 0
    if area is not None:
        assert mesh.area.sum() == pytest.approx(area, rel=1e-9)


def polygon_area(xy: np.ndarray) -> float:
    x, y = xy.T
    return 0.5 * float(np.abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def test_arrays_have_the_promised_shapes_and_the_input_comes_first(plate: csalf.Mesh) -> None:
    n, m = len(plate.points), len(plate.quads)
    assert plate.points.shape == (n, 2) and plate.points.dtype == np.float64
    assert plate.quads.shape == (m, 4) and plate.quads.dtype == np.uint32
    assert plate.quads.max() < n
    given = np.concatenate([rectangle(12, 8, 24, 16), ring((3, 4), 1, 16), ring((9, 4), 1.5, 20)])
    assert np.array_equal(plate.points[: len(given)], given)
    holes = polygon_area(ring((3, 4), 1, 16)) + polygon_area(ring((9, 4), 1.5, 20))
    is_sound(plate, 96 - holes)


def test_arrays_share_the_memory_of_rust(plate: csalf.Mesh) -> None:
    points, quads = plate._raw.addresses()
    assert plate.points.__array_interface__["data"] == (points, True)
    assert plate.quads.__array_interface__["data"] == (quads, True)
    assert np.shares_memory(plate._raw.points, plate.points)
    assert not plate.points.flags.owndata
    with pytest.raises(ValueError):
        plate.points[0, 0] = 1.0
    with pytest.raises(ValueError):
        plate.points.flags.writeable = True


def test_arrays_outlive_the_mesh() -> None:
    quads = csalf.mesh(loops=[rectangle(4, 3, 4, 3)], size=1.0).quads
    assert np.bincount(quads.ravel()).max() == 4
    assert len(quads) == 12


def test_sets_are_named_after_the_input(plate: csalf.Mesh) -> None:
    assert list(plate.edge_sets) == ["outer", "bolt", "slot", "weld"]
    assert list(plate.node_sets) == ["outer", "bolt", "slot", "weld", "spot"]
    assert np.array_equal(plate.points[plate.node_sets["spot"][0]], (6, 6))
    assert len(plate.edge_sets["bolt"]) == 16
    assert len(plate.quad_sets["bolt_layer1"]) == 16
    assert len(plate.boundary) == 80 + 16 + 20
    on_rim = np.hypot(*(plate.points[plate.node_sets["bolt"]] - (3, 4)).T)
    assert on_rim == pytest.approx(1)


def test_report_has_what_was_asked_and_made(plate: csalf.Mesh) -> None:
    r = plate.report
    layers = {entry["loops"]: entry for entry in r["layers"]}
    assert (layers["bolt"]["asked"], layers["bolt"]["made"]) == (2, 2)
    assert layers["slot"]["thickness_error"] < 1e-6
    assert r["n_quads"] == len(plate.quads) == r["quality"]["n_quads"]
    assert r["quality"]["min_sj"] == pytest.approx(plate.scaled_jacobian.min())
    assert r["name"] == plate.name == "plate"
    assert r["stages"]["fill"] >= 0


def test_metrics(plate: csalf.Mesh) -> None:
    square = csalf.mesh(loops=[rectangle(4, 3, 4, 3)], size=1.0)
    for name in csalf._csalf.Mesh.metric_names():
        assert square.metric(name).shape == (12,)
    assert square.scaled_jacobian == pytest.approx(1)
    assert square.min_angle == pytest.approx(90) and square.max_angle == pytest.approx(90)
    assert square.size_ratio == pytest.approx(1) and square.area == pytest.approx(1)
    assert 0.5 < np.median(plate.size_ratio) < 2
    with pytest.raises(ValueError, match="no metric 'x'"):
        plate.metric("x")


def test_every_kind_of_size() -> None:
    outline = rectangle(10, 10, 20, 20)

    def edge(mesh: csalf.Mesh, at: tuple[float, float]) -> float:
        near = np.hypot(*(mesh.points[mesh.quads].mean(1) - at).T).argsort()[:4]
        return float(np.sqrt(mesh.area[near].mean()))

    seen = []

    def field(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        seen.append(len(x))
        return 0.2 + 0.15 * np.maximum(np.hypot(x - 5, y - 5) - 2, 0)

    by_function = csalf.mesh(loops=[outline], size=field)
    assert len(seen) < 20 and max(seen) > 50, "asked in blocks"
    x, y = np.meshgrid(np.linspace(0, 10, 41), np.linspace(0, 10, 41))
    values = field(x.ravel(), y.ravel())
    cases = {
        "grid over the box": values.reshape(41, 41),
        "grid with an extent": csalf.Grid(values.reshape(41, 41), (0, 0, 10, 10)),
        "points and values": (np.stack([x.ravel(), y.ravel()], 1), values),
        "sources": csalf.Sources(0.95, [(5, 5, 0.2, 2.0, 5.0)]),
    }
    for mesh in [by_function, *(csalf.mesh(loops=[outline], size=size) for size in cases.values())]:
        is_sound(mesh, 100)
        assert edge(mesh, (5, 5)) == pytest.approx(0.2, rel=0.4)
        assert edge(mesh, (1, 5)) == pytest.approx(0.5, rel=0.4)
    assert edge(csalf.mesh(loops=[outline]), (5, 5)) == pytest.approx(0.5, rel=0.3)


def test_the_quadtree_fits_together_and_follows_the_function() -> None:
    from csalf import _size

    def spike(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.clip(0.01 + 0.3 * np.hypot(x - 0.31, y - 0.47), 0.01, 0.2)

    points, triangles, values = _size.of_function(spike, (0.0, 0.0, 2.0, 1.0))
    a, b, c = points[triangles].transpose(1, 0, 2)
    d, e = b - a, c - a
    area = 0.5 * (d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0])
    low, high = points.min(0), points.max(0)
    assert area.min() > 0 and area.sum() == pytest.approx(np.prod(high - low))
    assert (low <= 0).all() and (high >= (2, 1)).all()
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert set(count) == {1, 2}, "no hanging nodes"
    middle = points[triangles].mean(1)
    off = values[triangles].mean(1) / spike(*middle.T) - 1
    assert np.abs(off).max() < 0.25 and np.quantile(np.abs(off), 0.95) < 0.05
    assert np.array_equal(triangles, _size.of_function(spike, (0.0, 0.0, 2.0, 1.0))[1])


def test_curves_get_nodes_by_the_size() -> None:
    square = [csalf.line((0, 0), (4, 0)), csalf.line((4, 0), (4, 4)), csalf.line((4, 4), (0, 4)), csalf.line((0, 4), (0, 0))]
    mesh = csalf.mesh(loops=[square, csalf.circle((2, 2), 1)], size=0.2)
    is_sound(mesh)
    assert len(mesh.edge_sets["outer"]) == 80
    assert len(mesh.edge_sets["hole0"]) == pytest.approx(2 * np.pi / 0.2, abs=2)
    assert np.hypot(*(mesh.points[mesh.node_sets["hole0"]] - 2).T) == pytest.approx(1)
    made = csalf.discretise([square, csalf.circle((2, 2), 1)], 0.2)
    again = csalf.mesh(**made, size=0.2)
    assert np.array_equal(again.points, mesh.points) and np.array_equal(again.quads, mesh.quads)
    fine = csalf.discretise([csalf.ellipse((0, 0), (3, 1))], lambda x, y: np.where(x > 0, 0.05, 0.5))["loops"]["outer"]
    assert (fine[:, 0] > 0).sum() > 3 * (fine[:, 0] < 0).sum()
    spline = csalf.mesh(loops=[csalf.spline([(0, 0), (4, -1), (5, 3), (1, 4)], closed=True)], size=0.3)
    is_sound(spline)


def test_resample_places_new_nodes() -> None:
    mesh = csalf.mesh(loops=[[(0, 0), (4, 0), (4, 4), (0, 4)]], size=0.5, resample=True)
    assert len(mesh.boundary) == 32
    is_sound(mesh, 16)


def test_layers_in_every_form() -> None:
    loops = [rectangle(20, 20, 40, 40), ring((10, 10), 2, 24)]
    forms = [
        3,
        (3, "ramp"),
        (3, "constant", 0.25),
        (3, "geometric(1.2)", 0.2),
        [0.2, 0.3, 0.4],
        {"count": 3, "law": "fibonacci", "first": 0.2},
        {"thicknesses": [0.2, 0.3, 0.4]},
    ]
    for form in forms:
        mesh = csalf.mesh(loops=loops, size=0.5, layers={"hole*": form})
        (entry,) = (e for e in mesh.report["layers"] if e["loops"] == "hole0")
        assert (entry["asked"], entry["made"]) == (3, 3), form
    explicit = csalf.mesh(loops=loops, size=0.5, layers={"hole*": [0.2, 0.3, 0.4]})
    first = explicit.points[explicit.quads[explicit.quad_sets["hole0_layer1"]]].reshape(-1, 2)
    r = np.hypot(*(first - 10).T)
    # Thickness is measured between the sides of the polygon; 24 corners.
    assert r.max() == pytest.approx(2 + 0.2 / np.cos(np.pi / 24), rel=0.01)


def test_geo_interface_and_several_parts() -> None:
    shapely = pytest.importorskip("shapely")
    one = shapely.Polygon(rectangle(4, 4, 8, 8), [ring((2, 2), 1, 12)])
    mesh = csalf.mesh(one, size=0.5)
    is_sound(mesh, one.area)
    other = shapely.affinity.translate(one, 10, 0)
    both = csalf.mesh(shapely.MultiPolygon([one, other]), size=0.5)
    assert both.area.sum() == pytest.approx(2 * one.area)
    assert len(both.quads) == pytest.approx(2 * len(mesh.quads), rel=0.1)
    assert {"part0", "part1", "part1/outer_layer1"} <= set(both.quad_sets)
    assert both.points[both.node_sets["part1/hole0"]].min(0) == pytest.approx((11, 1))
    assert both.check()
    assert len(csalf.mesh_all(shapely.MultiPolygon([one, other]), size=0.5)) == 2


def test_a_mesh_and_a_job_can_be_pickled(plate: csalf.Mesh) -> None:
    again = pickle.loads(pickle.dumps(plate))
    assert np.array_equal(again.points, plate.points) and np.array_equal(again.quads, plate.quads)
    assert again.report == plate.report and again.name == "plate"
    assert {n: a.tolist() for n, a in again.quad_sets.items()} == {n: a.tolist() for n, a in plate.quad_sets.items()}
    (job,) = csalf.jobs(loops=[rectangle(4, 3, 4, 3)], size=lambda x, y: 0.5 + 0 * x, layers={"outer": (1, "ramp")})
    twin = pickle.loads(pickle.dumps(job))
    assert twin.to_json() == job.to_json()
    assert np.array_equal(csalf.mesh(twin).quads, csalf.mesh(job).quads)


def test_threads_and_repetition_change_nothing() -> None:
    what = {"loops": [rectangle(20, 20, 60, 60), ring((7, 9), 2, 40), ring((14, 12), 3, 50)], "size": 0.3}
    a, b = csalf.mesh(**what, threads=1), csalf.mesh(**what, threads=2)
    assert np.array_equal(a.points, b.points) and np.array_equal(a.quads, b.quads)


def test_methods_and_options() -> None:
    loops = [rectangle(10, 10, 10, 10), ring((5, 5), 2, 13)]
    with pytest.raises(csalf.GeometryError):
        csalf.mesh(loops=loops)
    odd = csalf.mesh(loops=loops, allow_triangles=True)
    assert len(odd.triangles) == 1 and odd.metric("skew").shape == (len(odd.quads) + 1,)
    for method in ("csalf", "paper", "tqm"):
        for preset in ("quality", "fast"):
            is_sound(csalf.mesh(loops=[loops[0], ring((5, 5), 2, 14)], method=method, preset=preset))
    with pytest.raises(ValueError, match="known are csalf"):
        csalf.mesh(loops=loops, method="x")


def test_pictures(plate: csalf.Mesh) -> None:
    assert "<svg" in plate.svg()
    assert plate.png().startswith(b"\x89PNG")
    shown = plate._repr_html_()
    assert "<svg" in shown and "<?xml" not in shown and f"{len(plate.quads)} quads" in shown
    assert repr(plate).startswith("<csalf.Mesh 'plate': ")


def test_plot(plate: csalf.Mesh) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    ax = plate.plot()
    drawn = ax.collections[0]
    assert len(drawn.get_paths()) == len(plate.quads)
    assert np.array_equal(drawn.get_array(), plate.scaled_jacobian)
    ax.figure.canvas.draw()
    plain = plate.plot(None, linewidths=1.0)
    assert plain.collections[0].get_array() is None


def test_a_million_quads_reach_numpy_at_once() -> None:
    """Honest only as an order of magnitude: the arrays are views, so there is nothing to wait for."""
    n = 1000
    mesh = csalf.mesh(loops=[rectangle(1, 1, n, n)], size=1 / n, layers={"*": 0}, preset="fast")
    assert len(mesh.quads) > 900_000
    start = time.perf_counter()
    points, quads = mesh.points, mesh.quads
    seconds = time.perf_counter() - start
    assert points.nbytes > 14_000_000 and quads.nbytes > 14_000_000
    print(f"{len(quads)} quads to numpy in {1e3 * seconds:.3f} ms")
    assert np.shares_memory(points, mesh._raw.points)
