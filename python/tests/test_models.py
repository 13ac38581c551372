"""Whole models: from files, in one piece, in shards."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import boxes

import csalf

BLOCK = Path(__file__).parents[2] / "crates/csalf-step/tests/data/block.step"
needs_block = pytest.mark.skipif(not BLOCK.exists(), reason="not in a checkout")


@pytest.fixture(scope="module")
def block() -> csalf.ModelMesh:
    return csalf.mesh_model(BLOCK, size=5, layers={"hole*": 2})


@needs_block
def test_a_step_file_is_meshed(block: csalf.ModelMesh, tmp_path) -> None:
    model = csalf.Model(BLOCK)
    assert block.faces == [name for name, _ in model.faces] and not block.failures
    assert {kind for _, kind in model.faces} >= {"plane"}
    assert block.n_free_sides == 0 and block.n_branching_sides == 0, "a solid is closed"
    assert len(block.boundary) == 0
    assert block.points.shape[1] == 3 and not block.points.flags.writeable
    low, high = model.bounds
    assert (block.points >= low - 1e-6).all() and (block.points <= high + 1e-6).all()
    # Arrays are the memory of Rust.
    assert (block.points.ctypes.data, block.quads.ctypes.data) == block._raw.addresses()
    assert len(block.face_of_quad) == len(block.quads)
    for k, name in enumerate(block.faces):
        assert np.array_equal(block.quad_sets[name], np.flatnonzero(block.face_of_quad == k))
    assert block.scaled_jacobian.min() > 0.3 and block.check(0.3)
    assert block.area.min() > 0 and block.min_angle.min() > 10
    assert set(model.edges) >= set(block.edge_sets)
    again = pickle.loads(pickle.dumps(block))
    assert repr(again) == repr(block) and np.array_equal(again.points, block.points)
    for suffix in ("inp", "vtu", "vtkhdf"):
        for m in (block, again):
            m.write(tmp_path / f"{m is block}.{suffix}")
        assert (tmp_path / f"True.{suffix}").read_bytes() == (tmp_path / f"False.{suffix}").read_bytes()


@needs_block
@pytest.mark.parametrize("centres", [False, True])
def test_second_order(block: csalf.ModelMesh, tmp_path, centres: bool) -> None:
    meshio = pytest.importorskip("meshio")
    block.write(tmp_path / "block.vtu", order=2, centres=centres)
    read = meshio.read(tmp_path / "block.vtu")
    (cells,) = read.cells
    assert cells.type == ("quad9" if centres else "quad8")
    assert np.array_equal(cells.data[:, :4], block.quads)
    assert np.array_equal(read.points[: len(block.points)], block.points)
    flat = (cells.data[:, :4], np.roll(cells.data[:, :4], -1, axis=1))
    chords = 0.5 * (read.points[flat[0]] + read.points[flat[1]])
    rise = np.linalg.norm(read.points[cells.data[:, 4:8]] - chords, axis=2)
    kinds = np.array([kind for _, kind in csalf.Model(BLOCK).faces])
    n_round = 0
    for k in np.flatnonzero(kinds == "cylinder"):
        quads = cells.data[block.face_of_quad == k]
        vertices, middles = read.points[np.unique(quads[:, :4])], read.points[np.unique(quads[:, 4:])]
        # A whole wall, along one of the axes: all nodes are as far from it.
        for axis in range(3):
            across = [i for i in range(3) if i != axis]
            centre = (vertices.max(axis=0) + vertices.min(axis=0))[across] / 2
            radii = [np.linalg.norm(p[:, across] - centre, axis=1) for p in (vertices, middles)]
            if np.ptp(radii[0]) < 1e-6:
                n_round += 1
                assert np.ptp(np.concatenate(radii)) < 1e-6
        assert rise[block.face_of_quad == k].max() > 1e-3
    assert n_round > 0
    assert np.allclose(rise[kinds[block.face_of_quad] == "plane"].min(axis=1), 0)
    with pytest.raises(ValueError, match="stitched, unpickled"):
        pickle.loads(pickle.dumps(block)).write(tmp_path / "again.vtu", order=2)


@needs_block
@pytest.mark.parametrize("suffix", ["vtu", "msh", "inp", "bdf", "obj"])
def test_meshes_in_space_are_read(block: csalf.ModelMesh, tmp_path, suffix: str) -> None:
    block.write(tmp_path / f"block.{suffix}")
    read = csalf.read(tmp_path / f"block.{suffix}")
    assert isinstance(read, csalf.ModelMesh)
    assert np.array_equal(read.quads, block.quads) and np.allclose(read.points, block.points, rtol=0, atol=1e-9)
    assert (read.n_free_sides, read.n_branching_sides) == (0, 0) and not read.failures
    assert read.scaled_jacobian == pytest.approx(block.scaled_jacobian, abs=1e-6)
    assert csalf.check(tmp_path / f"block.{suffix}", min_sj=0.3).ok
    if suffix in ("vtu", "msh", "inp"):
        assert read.faces == block.faces and np.array_equal(read.face_of_quad, block.face_of_quad)
        assert set(read.quad_sets) == set(block.quad_sets)
    if suffix == "vtu":
        assert np.array_equal(read.cell_data["face"], block.face_of_quad)
    with pytest.raises(ValueError, match="stitched, unpickled"):
        read.write(tmp_path / "second.vtu", order=2)


@needs_block
def test_sizes_of_loops() -> None:
    coarse = csalf.mesh_model(BLOCK, size=5)
    fine = csalf.mesh_model(BLOCK, size=5, loop_sizes={"hole*": 1})
    assert not fine.failures and len(fine.quads) > len(coarse.quads)
    with pytest.raises(csalf.SizeError):
        csalf.mesh_model(BLOCK, size=5, loop_sizes={"hole*": -1})


@needs_block
def test_mesh_takes_models_too(block: csalf.ModelMesh) -> None:
    same = csalf.mesh(str(BLOCK), size=5, layers={"hole*": 2})
    assert isinstance(same, csalf.ModelMesh) and np.array_equal(same.points, block.points)
    model = csalf.Model(BLOCK)
    assert len(csalf.mesh(model, size=10).quads) < len(block.quads)
    with pytest.raises(TypeError, match="points"):
        csalf.mesh(BLOCK, points=[(0, 0)])
    with pytest.raises(csalf.SizeError):
        csalf.mesh(BLOCK, size=-1)
    with pytest.raises(TypeError):
        csalf.mesh(BLOCK, size=lambda x, y: x)


def test_facets(tmp_path) -> None:
    mesh = csalf.mesh(boxes(tmp_path / "boxes.stl", 3), size=0.5)
    assert isinstance(mesh, csalf.ModelMesh) and len(mesh.faces) == 18
    assert mesh.area.sum() == pytest.approx(18.0)
    meshio = pytest.importorskip("meshio")
    m = mesh.to_meshio()
    assert isinstance(m, meshio.Mesh) and np.array_equal(m.points, mesh.points)
    assert mesh._repr_html_().startswith("<div")


def test_points_counts_and_sizes_by_name(tmp_path) -> None:
    path = boxes(tmp_path / "boxes.stl", 1)
    model = csalf.Model(path)
    mesh = csalf.mesh_model(model, size=0.5, points={"weld": (0.5, 0.5, 1.0)}, face_sizes={model.faces[0][0]: 0.2})
    assert mesh.points[mesh.node_sets["weld"]] == pytest.approx(np.array([[0.5, 0.5, 1.0]]))
    fine, coarse = (len(mesh.quad_sets[model.faces[k][0]]) for k in (0, 3))
    assert fine > 1.5 * coarse
    fixed = csalf.mesh_model(model, size=0.5, edge_counts={model.edges[0]: 7})
    assert len(fixed.edge_sets[model.edges[0]]) == 7


def test_faces_that_fail_are_told(tmp_path) -> None:
    path = boxes(tmp_path / "boxes.stl", 2)
    model = csalf.Model(path)
    # All edges of the first box have two segments, but for one with three: the faces beside it are odd.
    counts = {name: 2 for name in model.edges[:12]} | {model.edges[0]: 3}
    with pytest.raises(csalf.ModelError) as caught:
        csalf.mesh_model(model, size=0.5, edge_counts=counts)
    failures = caught.value.failures
    assert len(failures) == 2 and isinstance(caught.value, csalf.Error)
    assert failures[0].name in str(failures[0]) and failures[0].message
    mesh = caught.value.mesh
    assert isinstance(mesh, csalf.ModelMesh) and set(mesh.face_of_quad) == set(range(12)) - {f.face for f in failures}
    partial = csalf.mesh_model(model, size=0.5, edge_counts=counts, partial=True)
    assert np.array_equal(partial.points, mesh.points) and partial.failures == failures
    assert not partial.check()
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.failures == failures and np.array_equal(again.mesh.quads, mesh.quads)


@needs_block
def test_faces_on_unknown_surfaces_fail(tmp_path) -> None:
    text = BLOCK.read_text()
    unknown = text.replace("#180=CYLINDRICAL_SURFACE('',#179,6.000000);", "#180=OFFSET_SURFACE('',#180,1.0,.F.);")
    assert unknown != text
    path = tmp_path / "unknown.step"
    path.write_text(unknown)
    assert "unread" in [kind for _, kind in csalf.Model(path).faces]
    with pytest.raises(csalf.ModelError) as caught:
        csalf.mesh_model(path, size=5)
    assert all("not read" in f.message for f in caught.value.failures)


@needs_block
def test_sewing(block: csalf.ModelMesh) -> None:
    model = csalf.Model(BLOCK, sewing=1e-3)
    assert np.array_equal(csalf.mesh_model(model, size=5, layers={"hole*": 2}).points, block.points)
    # Wider than the block.
    with pytest.raises(ValueError, match="sewing within 1000"):
        csalf.Model(BLOCK, sewing=1e3)
    with pytest.raises(ValueError, match="sewing"):
        csalf.Model(BLOCK, sewing=0.0)


def test_files_that_are_no_models(tmp_path) -> None:
    with pytest.raises(FileNotFoundError):
        csalf.Model(tmp_path / "none.step")
    (tmp_path / "bad.step").write_text("nothing")
    with pytest.raises(csalf.FormatError):
        csalf.Model(tmp_path / "bad.step")
    (tmp_path / "part.sat").write_text("")
    with pytest.raises(ValueError, match=r"\.step, \.stp"):
        csalf.Model(tmp_path / "part.sat")


def test_cancelled(tmp_path) -> None:
    with pytest.raises(csalf.Cancelled):
        csalf.mesh_model(boxes(tmp_path / "boxes.stl", 40), size=0.05, threads=1, progress=lambda stage: False)


def test_shards(tmp_path) -> None:
    path = boxes(tmp_path / "boxes.stl", 4)
    whole = csalf.mesh_model(path, size=0.25)
    plan = csalf.Model(path)._raw.plan(csalf._model.Wish(size=0.25))
    shards = [plan.shard(k, 3, 1) for k in (2, 3, 1)]
    files = [tmp_path / f"{k}.csalf-shard" for k in range(3)]
    for file, shard in zip(files, shards):
        file.write_bytes(shard)
    for given in (shards, files):
        mesh = csalf.stitch(given)
        for suffix in ("inp", "vtu"):
            whole.write(tmp_path / f"a.{suffix}")
            mesh.write(tmp_path / f"b.{suffix}")
            assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    with pytest.raises(csalf.ShardError, match="shard 3 of 3 missing") as caught:
        csalf.stitch([shards[0], shards[2]])
    assert len(caught.value.problems) == 1
    with pytest.raises(csalf.ShardError, match="checksum"):
        csalf.stitch([shards[0][:-1] + b"?", shards[1], shards[2]])
    with pytest.raises(csalf.ShardError, match="both shard 1"):
        csalf.stitch([*shards, shards[2]])
    with pytest.raises(ValueError, match="no part 4 of 3"):
        plan.shard(4, 3, 1)


@needs_block
def test_a_picture_in_space(block: csalf.ModelMesh) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    ax = block.plot()
    assert ax.name == "3d" and len(ax.collections) == 1
    block.plot(None, ax=ax)
    plt.close("all")
