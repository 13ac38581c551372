"""Files, read back by the programs that people use."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import csalf

BLOCK = Path(__file__).parents[2] / "crates/csalf-step/tests/data/block.step"

FORMATS = [name for name, _ in csalf._csalf.formats()]


@pytest.mark.parametrize("suffix", ["vtu", "msh", "msh2", "inp", "bdf", "obj"])
def test_what_csalf_writes_csalf_reads(plate: csalf.Mesh, tmp_path, suffix: str) -> None:
    path = tmp_path / f"plate.{suffix}"
    plate.write(path)
    again = csalf.read(path)
    assert np.array_equal(again.quads, plate.quads)
    # .bdf has as many digits as fit in its columns.
    assert again.points == pytest.approx(plate.points, abs=1e-9)
    assert again.check()
    if suffix != "obj":
        assert set(again.quad_sets) >= {"bolt_layer1", "bolt_layer2", "slot_layer1"}
        assert np.array_equal(np.sort(again.quad_sets["bolt_layer2"]), np.sort(plate.quad_sets["bolt_layer2"]))
    if suffix == "vtu":
        assert again.cell_data["scaled_jacobian"] == pytest.approx(plate.scaled_jacobian)


@pytest.mark.parametrize(
    "suffix, kind", [("vtu", "vtu"), ("msh", "gmsh"), ("msh2", "gmsh"), ("inp", "abaqus"), ("bdf", "nastran"), ("obj", "obj")]
)
def test_meshio(plate: csalf.Mesh, tmp_path, suffix: str, kind: str) -> None:
    meshio = pytest.importorskip("meshio")
    path = tmp_path / f"plate.{suffix}"
    plate.write(path)
    m = meshio.read(path, file_format=kind)
    quads = np.concatenate([c.data for c in m.cells if c.type == "quad"])
    assert np.array_equal(quads, plate.quads)
    assert m.points[:, :2] == pytest.approx(plate.points, abs=1e-6)
    if kind == "gmsh":
        assert set(m.field_data) >= {"outer", "bolt", "slot", "weld", "spot", "bolt_layer1"}
        lines = np.concatenate([c.data for c in m.cells if c.type == "line"])
        assert len(lines) == 80 + 16 + 20 + 2
    if kind == "abaqus":
        assert set(m.point_sets) >= {"outer", "bolt", "slot", "weld", "spot"}
        assert np.array_equal(np.sort(m.point_sets["bolt"]), np.sort(plate.node_sets["bolt"]))
        assert set(m.cell_sets) >= {"bolt_layer1", "slot_layer2"}


@pytest.mark.parametrize("suffix", ["msh", "msh2", "bdf"])
def test_gmsh(plate: csalf.Mesh, tmp_path, suffix: str) -> None:
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    path = tmp_path / f"plate.{suffix}"
    plate.write(path)
    if suffix == "msh2":
        path = path.rename(tmp_path / "plate22.msh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        tags, _ = gmsh.model.mesh.getElementsByType(3)
        assert len(tags) == len(plate.quads)
        if not suffix.startswith("msh"):
            return
        names = {gmsh.model.getPhysicalName(*g): g for g in gmsh.model.getPhysicalGroups()}
        assert set(names) >= {"outer", "bolt", "slot", "weld", "spot", "bolt_layer1", "slot_layer2"}
        nodes, _ = gmsh.model.mesh.getNodesForPhysicalGroup(*names["bolt"])
        assert sorted(int(n) - 1 for n in nodes) == sorted(plate.node_sets["bolt"].tolist())
        areas = gmsh.model.mesh.getElementQualities(tags, "volume")
        assert np.sort(areas) == pytest.approx(np.sort(plate.area), rel=1e-6)
    finally:
        gmsh.finalize()


def test_vtk(plate: csalf.Mesh, tmp_path) -> None:
    pytest.importorskip("vtk", exc_type=(ImportError, OSError))
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    path = tmp_path / "plate.vtu"
    plate.write(path, cell_data={"area": plate.area, "twice": 2 * plate.area})
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfPoints() == len(plate.points)
    types = vtk_to_numpy(grid.GetCellTypes() if hasattr(grid, "GetCellTypes") else grid.GetCellTypesArray())
    assert (types == 9).sum() == len(plate.quads)
    assert vtk_to_numpy(grid.GetPoints().GetData())[:, :2] == pytest.approx(plate.points)
    data = grid.GetCellData()
    names = {data.GetArrayName(k) for k in range(data.GetNumberOfArrays())}
    assert {"area", "twice"} <= names


@pytest.fixture(scope="module")
def ring() -> csalf.Mesh:
    return csalf.mesh(loops=[csalf.circle((1, 2), 3), csalf.circle((1, 2), 1)], size=0.5, name="ring")


def off_circles(points: np.ndarray) -> np.ndarray:
    r = np.hypot(*(points[:, :2] - (1, 2)).T)
    return np.minimum(np.abs(r - 1), np.abs(r - 3))


@pytest.mark.parametrize(
    "suffix, kind, cell",
    [("inp", "abaqus", "quad8"), ("msh", "gmsh", "quad8"), ("msh", "gmsh", "quad9"), ("msh2", "gmsh", "quad8"), ("vtu", "vtu", "quad8"), ("vtu", "vtu", "quad9")],
)
def test_quadratic_elements_by_meshio(ring: csalf.Mesh, tmp_path, suffix: str, kind: str, cell: str) -> None:
    meshio = pytest.importorskip("meshio")
    path = tmp_path / f"ring.{suffix}"
    # meshio knows S8R, but not CPS8.
    ring.write(path, order=2, centres=cell == "quad9")
    m = meshio.read(path, file_format=kind)
    quads = np.concatenate([c.data for c in m.cells if c.type == cell])
    assert np.array_equal(quads[:, :4], ring.quads)
    corners, middles = m.points[quads[:, :4]], m.points[quads[:, 4:8]]
    chords = 0.5 * (corners + np.roll(corners, -1, axis=1))
    moved = np.unique(quads[:, 4:8][np.abs(middles - chords).max(2) > 1e-6])
    assert len(moved) == len(ring.boundary)
    assert off_circles(m.points[moved]).max() < 1e-12
    inner = np.setdiff1d(quads[:, 4:8], moved)
    assert off_circles(m.points[inner]).min() > 0.1
    if kind == "abaqus":
        rim = m.point_sets["hole0"]
        assert len(rim) == 2 * len(ring.edge_sets["hole0"])
        assert np.abs(np.hypot(*(m.points[rim][:, :2] - (1, 2)).T) - 1).max() < 1e-12
    if cell == "quad9":
        centre = m.points[quads[:, 8]]
        assert np.abs(centre - corners.mean(1)).max() < 0.1


@pytest.mark.parametrize("suffix, kind, n", [("msh", 16, 8), ("msh", 10, 9), ("bdf", 16, 8)])
def test_quadratic_elements_by_gmsh(ring: csalf.Mesh, tmp_path, suffix: str, kind: int, n: int) -> None:
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    ring.write(tmp_path / f"ring.{suffix}", order=2, centres=n == 9)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / f"ring.{suffix}"))
        tags, nodes = gmsh.model.mesh.getElementsByType(kind)
        assert len(tags) == len(ring.quads) and len(nodes) == n * len(tags)
        worst = gmsh.model.mesh.getElementQualities(tags, "minDetJac")
        assert worst.min() > 0
        area = gmsh.model.mesh.getElementQualities(tags, "volume").sum()
        # The circles themselves, not polygons: 8 pi.
        assert area == pytest.approx(8 * np.pi, rel=1e-4) and ring.area.sum() < 7.996 * np.pi
    finally:
        gmsh.finalize()


def test_quadratic_elements_by_vtk(ring: csalf.Mesh, tmp_path) -> None:
    pytest.importorskip("vtk", exc_type=(ImportError, OSError))
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    for centres, kind in ((False, 23), (True, 28)):
        ring.write(tmp_path / "ring.vtu", order=2, centres=centres)
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(tmp_path / "ring.vtu"))
        reader.Update()
        grid = reader.GetOutput()
        assert {grid.GetCellType(k) for k in range(grid.GetNumberOfCells())} == {kind}
        sizes = vtkCellSizeFilter()
        sizes.SetInputData(grid)
        sizes.ComputeSumOn()
        sizes.Update()
        area = sizes.GetOutput().GetFieldData().GetArray("Area").GetValue(0)
        assert area == pytest.approx(8 * np.pi, rel=2e-4) and area > 1.0003 * ring.area.sum()


def test_formats_without_quadratic_elements_say_so(ring: csalf.Mesh, tmp_path) -> None:
    with pytest.raises(csalf.FormatError, match="no quadratic"):
        ring.write(tmp_path / "ring.obj", order=2)
    with pytest.raises(csalf.FormatError, match="nine nodes"):
        ring.write(tmp_path / "ring.inp", order=2, centres=True)
    for wrong in ({"order": 3}, {"centres": True}, {"element": "brick"}):
        with pytest.raises(ValueError):
            ring.write(tmp_path / "ring.inp", **wrong)
    assert list(tmp_path.iterdir()) == []


def test_to_meshio(plate: csalf.Mesh, tmp_path) -> None:
    meshio = pytest.importorskip("meshio")
    m = plate.to_meshio()
    assert np.array_equal(m.cells_dict["quad"], plate.quads)
    assert np.array_equal(m.point_sets["bolt"], plate.node_sets["bolt"])
    assert np.array_equal(m.cell_sets["bolt_layer1"][0], plate.quad_sets["bolt_layer1"])
    lines = m.cells[-1].data[m.cell_sets["slot"][-1]]
    assert np.array_equal(lines, plate.edge_sets["slot"])
    m.write(tmp_path / "plate.vtk")
    assert meshio.read(tmp_path / "plate.vtk").cells_dict["quad"].shape == plate.quads.shape


def test_to_pyvista(plate: csalf.Mesh) -> None:
    pyvista = pytest.importorskip("pyvista")
    grid = plate.to_pyvista()
    assert grid.n_cells == len(plate.quads) and grid.n_points == len(plate.points)
    assert isinstance(grid, pyvista.UnstructuredGrid)
    assert grid.area == pytest.approx(plate.area.sum())
    assert grid.cell_data["scaled_jacobian"].min() == pytest.approx(plate.scaled_jacobian.min())


def test_jobs_from_files(plate: csalf.Mesh, tmp_path) -> None:
    (job,) = csalf.jobs(loops=[[(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]], size=1.0, name="sq")
    (tmp_path / "square.json").write_bytes(job.to_json())
    mesh = csalf.mesh(tmp_path / "square.json")
    assert (mesh.name, len(mesh.quads)) == ("sq", 4)
    assert len(csalf.mesh(str(tmp_path / "square.json"), size=0.5, resample=True).quads) == 16
    plate.write(tmp_path / "plate.msh")
    (again,) = csalf.jobs(tmp_path / "plate.msh")
    assert {n for n, _, _ in again.loops()} == {"outer", "bolt", "slot"}


def test_exodus(plate: csalf.Mesh, tmp_path) -> None:
    pytest.importorskip("vtk", exc_type=(ImportError, OSError))
    from vtkmodules.vtkIOExodus import vtkExodusIIReader

    path = tmp_path / "plate.exo"
    plate.write(path)
    reader = vtkExodusIIReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    kinds = {"block": reader.ELEM_BLOCK, "nodes": reader.NODE_SET, "sides": reader.SIDE_SET, "quads": reader.ELEM_SET}
    names = {
        what: [reader.GetObjectName(kind, k) for k in range(reader.GetNumberOfObjects(kind))]
        for what, kind in kinds.items()
    }
    assert names["block"] == ["quads"]
    assert names["nodes"] == list(plate.node_sets)
    assert names["sides"] == list(plate.edge_sets)
    assert set(names["quads"]) == {n for n, q in plate.quad_sets.items() if len(q)}
    for k in range(len(names["sides"])):
        reader.SetObjectStatus(reader.SIDE_SET, k, 1)
    reader.Update()
    blocks = reader.GetOutput()
    quads = blocks.GetBlock(0).GetBlock(0)
    assert quads.GetNumberOfCells() == len(plate.quads) and quads.GetCellType(0) == 9
    assert quads.GetNumberOfPoints() == len(plate.points)
    sides = blocks.GetBlock(4)
    bolt = sides.GetBlock(list(plate.edge_sets).index("bolt"))
    assert bolt.GetNumberOfCells() == 16
    rim = np.array([bolt.GetPoint(k)[:2] for k in range(bolt.GetNumberOfPoints())])
    assert np.hypot(*(rim - (3, 4)).T) == pytest.approx(1)


@pytest.mark.skipif(not BLOCK.exists(), reason="not in a checkout")
@pytest.mark.parametrize("order, kind", [(1, b"SHELL4"), (2, b"SHELL8")])
def test_exodus_in_space(tmp_path, order: int, kind: bytes) -> None:
    pytest.importorskip("vtk", exc_type=(ImportError, OSError))
    from vtkmodules.vtkIOExodus import vtkExodusIIReader

    netcdf = pytest.importorskip("scipy.io")
    block = csalf.mesh_model(BLOCK, size=5)
    block.write(tmp_path / "block.exo", order=order)
    with netcdf.netcdf_file(tmp_path / "block.exo", mmap=False) as f:
        assert f.variables["connect1"].elem_type == kind
        names = [bytes(r).rstrip(b"\0").decode() for r in f.variables["ss_names"][:]]
        assert names == list(block.edge_sets)
        for k, name in enumerate(names):
            elements, sides = f.variables[f"elem_ss{k + 1}"][:] - 1, f.variables[f"side_ss{k + 1}"][:] - 3
            ends = np.stack([block.quads[elements, sides], block.quads[elements, (sides + 1) % 4]], 1)
            assert np.array_equal(np.sort(ends), np.sort(block.edge_sets[name]))
    reader = vtkExodusIIReader()
    reader.SetFileName(str(tmp_path / "block.exo"))
    reader.UpdateInformation()
    for k in range(reader.GetNumberOfObjects(reader.SIDE_SET)):
        reader.SetObjectStatus(reader.SIDE_SET, k, 1)
    reader.Update()
    shells = reader.GetOutput().GetBlock(0).GetBlock(0)
    assert shells.GetNumberOfCells() == len(block.quads)
    assert shells.GetCellType(0) == (9 if order == 1 else 23)
    points = np.array([shells.GetPoint(k) for k in range(shells.GetNumberOfPoints())])
    assert np.array_equal(points.max(axis=0), block.points.max(axis=0))
    sides = reader.GetOutput().GetBlock(4)
    for k, (name, edges) in enumerate(block.edge_sets.items()):
        assert sides.GetBlock(k).GetNumberOfCells() == len(edges), name


def test_exodus_by_netcdf(plate: csalf.Mesh, ring: csalf.Mesh, tmp_path) -> None:
    netcdf = pytest.importorskip("scipy.io")
    for mesh, kind, order, centres in ((plate, b"QUAD4", 1, False), (ring, b"QUAD8", 2, False), (ring, b"QUAD9", 2, True)):
        mesh.write(tmp_path / "mesh.e", order=order, centres=centres)
        with netcdf.netcdf_file(tmp_path / "mesh.e", mmap=False) as f:
            connect = f.variables["connect1"]
            assert connect.elem_type == kind
            assert np.array_equal(connect[:, :4] - 1, mesh.quads)
            n = len(mesh.points)
            assert np.array_equal(f.variables["coordx"][:n], mesh.points[:, 0])
            assert connect[:].max() == len(f.variables["coordy"][:])
            names = [bytes(r).rstrip(b"\0").decode() for r in f.variables["ss_names"][:]]
            assert names == list(mesh.edge_sets)
            k = names.index("outer") + 1
            elements, sides = f.variables[f"elem_ss{k}"][:] - 1, f.variables[f"side_ss{k}"][:] - 1
            ends = np.stack([mesh.quads[elements, sides], mesh.quads[elements, (sides + 1) % 4]], 1)
            assert np.array_equal(np.sort(ends), np.sort(mesh.edge_sets["outer"]))


def test_su2(plate: csalf.Mesh, tmp_path) -> None:
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "plate.su2"
    plate.write(path)
    m = meshio.read(path)
    assert np.array_equal(m.cells_dict["quad"], plate.quads)
    assert m.points[:, :2] == pytest.approx(plate.points, abs=0)
    assert len(m.cells_dict["line"]) == len(plate.boundary)
    text = path.read_text()
    markers = [line.split("= ")[1] for line in text.splitlines() if line.startswith("MARKER_TAG")]
    assert markers == ["outer", "bolt", "slot"], "the weld is not on the boundary"


def test_unv(plate: csalf.Mesh, tmp_path) -> None:
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    plate.write(tmp_path / "plate.unv")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "plate.unv"))
        tags, _ = gmsh.model.mesh.getElementsByType(3)
        assert len(tags) == len(plate.quads)
        lines, _ = gmsh.model.mesh.getElementsByType(1)
        assert len(lines) == sum(len(e) for e in plate.edge_sets.values())
        _, xyz, _ = gmsh.model.mesh.getNodes()
        assert np.sort(xyz.reshape(-1, 3)[:, 0]) == pytest.approx(np.sort(plate.points[:, 0]), abs=0)
        names = {gmsh.model.getPhysicalName(*g) for g in gmsh.model.getPhysicalGroups()}
        assert names >= {"outer", "bolt", "slot", "bolt_layer1"}
    finally:
        gmsh.finalize()


def test_openfoam(plate: csalf.Mesh, tmp_path) -> None:
    pytest.importorskip("vtk", exc_type=(ImportError, OSError))
    from vtkmodules.vtkIOGeometry import vtkOpenFOAMReader

    path = tmp_path / "case" / "plate.foam"
    plate.write(path)
    reader = vtkOpenFOAMReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.EnableAllPatchArrays()
    reader.Update()
    out = reader.GetOutput()
    cells = out.GetBlock(0)
    assert cells.GetNumberOfCells() == len(plate.quads)
    assert {cells.GetCellType(k) for k in range(cells.GetNumberOfCells())} == {12}, "hexahedra"
    names = [reader.GetPatchArrayName(k) for k in range(reader.GetNumberOfPatchArrays())]
    for patch in ("outer", "bolt", "slot", "frontAndBack"):
        assert any(patch in n for n in names), names
    # A mesh that closes: every cell's faces add up to nothing, and volumes are areas times the thickness.
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter

    sizes = vtkCellSizeFilter()
    sizes.SetInputData(cells)
    sizes.ComputeSumOn()
    sizes.Update()
    volume = sizes.GetOutput().GetFieldData().GetArray("Volume").GetValue(0)
    assert volume == pytest.approx(plate.area.sum() * 0.05 * 12)


@pytest.mark.parametrize("order, centres, kind", [(1, False, 9), (2, False, 23), (2, True, 28)])
def test_vtkhdf(plate: csalf.Mesh, ring: csalf.Mesh, tmp_path, order: int, centres: bool, kind: int) -> None:
    pytest.importorskip("vtk", exc_type=(ImportError, OSError))
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader

    mesh = plate if order == 1 else ring
    path = tmp_path / "mesh.vtkhdf"
    mesh.write(path, order=order, centres=centres)
    reader = vtkHDFReader()
    assert reader.CanReadFile(str(path))
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfCells() == len(mesh.quads)
    assert {grid.GetCellType(k) for k in range(grid.GetNumberOfCells())} == {kind}
    points = vtk_to_numpy(grid.GetPoints().GetData())
    assert np.array_equal(points[: len(mesh.points), :2], mesh.points)
    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(len(mesh.quads), -1)
    assert np.array_equal(nodes[:, :4], mesh.quads)
    values = vtk_to_numpy(grid.GetCellData().GetArray("scaled_jacobian"))
    assert np.array_equal(values, mesh.scaled_jacobian)
    field = grid.GetFieldData()
    for prefix, sets in (("nset", mesh.node_sets), ("eset", mesh.edge_sets), ("qset", mesh.quad_sets)):
        for name, members in sets.items():
            if len(members):
                array = vtk_to_numpy(field.GetArray(f"{prefix}:{name}"))
                assert np.array_equal(array.ravel(), members.ravel()), name


def test_vtkhdf_by_h5py(plate: csalf.Mesh, tmp_path) -> None:
    h5py = pytest.importorskip("h5py")
    plate.write(tmp_path / "plate.vtkhdf")
    with h5py.File(tmp_path / "plate.vtkhdf") as f:
        root = f["VTKHDF"]
        assert root.attrs["Type"] in (b"UnstructuredGrid", "UnstructuredGrid")
        assert list(root.attrs["Version"]) == [2, 0]
        assert np.array_equal(root["Points"][:, :2], plate.points)
        assert np.array_equal(root["Connectivity"][:].reshape(-1, 4), plate.quads)
        assert np.array_equal(root["FieldData/eset:bolt"], plate.edge_sets["bolt"])
        assert np.array_equal(root["FieldData/qset:bolt_layer1"], plate.quad_sets["bolt_layer1"])


def read_ism(path) -> dict:
    """ISM-v2, after *The HOHQMesh Mesh File Formats*."""
    lines = iter(path.read_text().splitlines())
    assert next(lines) == "ISM-V2"
    n_nodes, n_edges, n_elements, order = map(int, next(lines).split())
    numbers = lambda kind: [kind(w) for w in next(lines).split()]  # noqa: E731
    nodes = np.array([numbers(float) for _ in range(n_nodes)])
    edges = np.array([numbers(int) for _ in range(n_edges)])
    corners, curves, names = [], {}, []
    for k in range(n_elements):
        corners.append(numbers(int))
        for side, flag in enumerate(numbers(int)):
            if flag:
                curves[k, side] = np.array([numbers(float) for _ in range(order + 1)])
        names.append(next(lines).split())
    assert next(lines, None) is None
    return {"nodes": nodes, "edges": edges, "corners": np.array(corners), "curves": curves, "names": names, "order": order}


@pytest.mark.parametrize("order", [1, 2])
def test_ism(plate: csalf.Mesh, ring: csalf.Mesh, tmp_path, order: int) -> None:
    mesh = plate if order == 1 else ring
    mesh.write(tmp_path / "a.mesh", order=order)
    m = read_ism(tmp_path / "a.mesh")
    assert m["order"] == order and np.array_equal(m["nodes"][:, :2], mesh.points)
    assert np.array_equal(m["corners"] - 1, mesh.quads)
    sides = [(0, 1), (1, 2), (3, 2), (0, 3)]
    seen = set()
    for a, b, e1, e2, s1, s2 in m["edges"].tolist():
        first = m["corners"][e1 - 1][list(sides[s1 - 1])]
        assert first.tolist() == [a, b]
        seen.add((e1, s1))
        if e2:
            second = m["corners"][e2 - 1][list(sides[abs(s2) - 1])].tolist()
            assert (second if s2 > 0 else second[::-1]) == [a, b]
            seen.add((e2, abs(s2)))
        name = m["names"][e1 - 1][s1 - 1]
        assert (name == "---") == bool(e2) and (name == "---") == (s2 != 0)
    assert len(seen) == 4 * len(mesh.quads), "every side of every element is in one edge"
    for name in ("outer", "bolt", "slot") if order == 1 else ("outer", "hole0"):
        assert sum(row.count(name) for row in m["names"]) == len(mesh.edge_sets[name])
    if order == 1:
        assert not m["curves"]
        return
    assert len(m["curves"]) == len(mesh.boundary)
    for (k, side), curve in m["curves"].items():
        ends = m["nodes"][m["corners"][k][list(sides[side])] - 1]
        assert np.array_equal(curve[[0, 2]], ends)
        assert off_circles(curve).max() < 1e-12


def test_ism_has_quads_alone(ring: csalf.Mesh, tmp_path) -> None:
    with pytest.raises(csalf.FormatError, match="no node inside"):
        ring.write(tmp_path / "a.mesh", order=2, centres=True)
    triangle = csalf.Mesh.from_arrays([(0, 0), (1, 0), (0, 1)], np.empty((0, 4)), [(0, 1, 2)])
    with pytest.raises(csalf.FormatError, match="no triangles"):
        triangle.write(tmp_path / "a.mesh")
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_read_says_so(plate: csalf.Mesh, tmp_path) -> None:
    for suffix in ("su2", "unv", "exo", "vtkhdf", "mesh"):
        plate.write(tmp_path / f"plate.{suffix}")
        with pytest.raises(csalf.FormatError, match="not read"):
            csalf.read(tmp_path / f"plate.{suffix}")
