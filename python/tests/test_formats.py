"""Files, read back by the programs that people use."""

from __future__ import annotations

import numpy as np
import pytest

import csalf

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
    m.write(tmp_path / "plate.xdmf")
    assert meshio.read(tmp_path / "plate.xdmf").cells_dict["quad"].shape == plate.quads.shape


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
