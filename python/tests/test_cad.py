"""IGES and BREP files, which come by Open CASCADE. The tests make the files themselves."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import csalf
import csalf.cad
from csalf import _cad

pytest.importorskip("OCP", reason="IGES and BREP need Open CASCADE")

from OCP.BRep import BRep_Builder  # noqa: E402
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing  # noqa: E402
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder  # noqa: E402
from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus  # noqa: E402
from OCP.BRepTools import BRepTools  # noqa: E402
from OCP.Geom import Geom_CylindricalSurface, Geom_OffsetSurface, Geom_RectangularTrimmedSurface  # noqa: E402
from OCP.GeomConvert import GeomConvert  # noqa: E402
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt  # noqa: E402
from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer  # noqa: E402
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer  # noqa: E402
from OCP.TCollection import TCollection_HAsciiString  # noqa: E402
from OCP.TopAbs import TopAbs_ShapeEnum  # noqa: E402
from OCP.TopExp import TopExp_Explorer  # noqa: E402
from OCP.TopoDS import TopoDS_Compound  # noqa: E402


@pytest.fixture
def here(monkeypatch) -> None:
    """Files are converted in this process, a second less for each; the other tests use the process beside."""
    monkeypatch.setattr(_cad, "convert", _cad._converted)


def block():
    """A plate of 40 by 30 by 10 with a hole of diameter 10."""
    hole = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, 15, -1), gp_Dir(0, 0, 1)), 5.0, 12.0)
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(40.0, 30.0, 10.0).Shape(), hole.Shape()).Shape()


def sheet():
    """Two sides of a box that share an edge."""
    walk = TopExp_Explorer(BRepPrimAPI_MakeBox(40.0, 30.0, 10.0).Shape(), TopAbs_ShapeEnum.TopAbs_FACE)
    faces = []
    while walk.More():
        faces.append(walk.Current())
        walk.Next()
    sewing = BRepBuilderAPI_Sewing(1e-6)
    sewing.Add(faces[0])
    sewing.Add(faces[2])
    sewing.Perform()
    return sewing.SewedShape()


def write(shape, path: Path, *, unit: str = "MM", names: str = "") -> Path:
    if path.suffix == ".brep":
        BRepTools.Write_s(shape, str(path))
    elif path.suffix == ".step":
        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
    else:
        IGESControl_Controller.Init_s()
        # Trimmed surfaces that share nothing, as most programs write.
        writer = IGESControl_Writer(unit, 0)
        writer.AddShape(shape)
        writer.ComputeModel()
        model = writer.Model()
        trimmed = [e for e in map(model.Entity, range(1, model.NbEntities() + 1)) if e.TypeNumber() == 144]
        for k, entity in enumerate(trimmed if names else []):
            entity.SetLabel(TCollection_HAsciiString(f"{names}{k}"))
        writer.Write(str(path))
    return path


@pytest.mark.parametrize("suffix", ["brep", "igs"])
def test_a_solid(suffix: str, tmp_path, capfd) -> None:
    path = write(block(), tmp_path / f"block.{suffix}")
    capfd.readouterr()
    model = csalf.Model(path)
    mesh = csalf.mesh(model, size=2.0, layers={"hole*": 2})
    assert capfd.readouterr() == ("", ""), "Open CASCADE is silent"
    assert isinstance(mesh, csalf.ModelMesh) and not mesh.failures and len(mesh.faces) == 7
    assert mesh.n_free_sides == 0 and mesh.n_branching_sides == 0, "a solid is closed"
    assert mesh.scaled_jacobian.min() > 0.3
    assert sorted(kind for _, kind in model.faces) == ["cylinder"] + ["plane"] * 6
    assert list(model.holes.values()) == pytest.approx([10.0, 10.0], abs=1e-4)
    assert any(name.startswith("layer") or "hole" in name for name in mesh.quad_sets)
    assert model.bounds == pytest.approx(np.array([[0, 0, 0], [40, 30, 10]]), abs=1e-4)
    assert model.name == "block"
    # All normals point outwards: the volume by the divergence theorem is positive.
    p = mesh.points[mesh.quads]
    flux = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    assert (flux * p.mean(1)).sum() / 6.0 == pytest.approx(40 * 30 * 10 - np.pi * 25 * 10, rel=0.01)


def test_a_brep_file_gives_the_mesh_of_the_step_file(here, tmp_path) -> None:
    brep, step = (csalf.mesh_model(write(block(), tmp_path / f"a.{s}"), size=3.0) for s in ("brep", "step"))
    assert np.array_equal(brep.points, step.points) and np.array_equal(brep.quads, step.quads)


def test_units_and_notes(here, tmp_path) -> None:
    inches = csalf.Model(write(block(), tmp_path / "inches.igs", unit="INCH"))
    assert inches.bounds == pytest.approx(np.array([[0, 0, 0], [40, 30, 10]]), abs=1e-3)
    assert "MILLI" in inches.unit.upper()
    assert "of 30 free edges 0 are left" in inches.notes[0]
    plain = csalf.Model(write(block(), tmp_path / "plain.brep"))
    assert plain.unit == "" and "no unit" in plain.notes[0]


def test_names_of_faces(here, tmp_path) -> None:
    model = csalf.Model(write(block(), tmp_path / "named.igs", names="SIDE"))
    assert sorted(name for name, _ in model.faces) == [f"SIDE{k}" for k in range(7)]


def test_a_sheet(here, tmp_path) -> None:
    for suffix in ("brep", "igs"):
        model = csalf.Model(write(sheet(), tmp_path / f"sheet.{suffix}"))
        assert any("6" in note and "free" in note for note in model.notes), model.notes
        mesh = csalf.mesh_model(model, size=2.5)
        assert len(mesh.faces) == 2 and mesh.scaled_jacobian.min() > 0.3
        assert mesh.area.sum() == pytest.approx(30 * 10 + 40 * 10)
        # Conforming: 5 x 30 + 2 x 10 + 2 x 40 of length are free, the shared side is not.
        assert 0 < mesh.n_free_sides < 100 and mesh.n_branching_sides == 0


@pytest.mark.parametrize(
    ("make", "kind", "area"),
    [
        (lambda: BRepPrimAPI_MakeSphere(10.0), "sphere", 400 * np.pi),
        (lambda: BRepPrimAPI_MakeTorus(20.0, 5.0), "torus", 400 * np.pi**2),
        (lambda: BRepPrimAPI_MakeCone(10.0, 0.0, 15.0), "cone", np.pi * (100 + 10 * np.hypot(10, 15))),
        (lambda: BRepPrimAPI_MakeCone(4.0, 10.0, 15.0), "cone", np.pi * (116 + 14 * np.hypot(6, 15))),
    ],
)
def test_what_iges_has_no_words_for(make, kind: str, area: float, here, tmp_path) -> None:
    model = csalf.Model(write(make().Shape(), tmp_path / f"{kind}.igs"))
    assert kind in {k for _, k in model.faces}
    mesh = csalf.mesh_model(model, size=2.0)
    assert mesh.n_free_sides == 0 and mesh.scaled_jacobian.min() > 0.3
    assert mesh.area.sum() == pytest.approx(area, rel=0.02)
    p = mesh.points[mesh.quads]
    assert (np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]) * p.mean(1)).sum() > 0, "normals point outwards"


def test_a_void_and_curves(here, tmp_path) -> None:
    ball = BRepPrimAPI_MakeSphere(gp_Pnt(20, 15, 5), 3.0).Shape()
    hollow = BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(40.0, 30.0, 10.0).Shape(), ball).Shape()
    both, build = TopoDS_Compound(), BRep_Builder()
    build.MakeCompound(both)
    build.Add(both, hollow)
    build.Add(both, BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 20), gp_Pnt(1, 0, 20)).Edge())
    for suffix in ("brep", "igs"):
        model = csalf.Model(write(both, tmp_path / f"hollow.{suffix}"))
        assert any("curve" in note for note in model.notes)
        mesh = csalf.mesh_model(model, size=1.0)
        assert len(mesh.faces) == 7 and mesh.n_free_sides == 0
        p = mesh.points[mesh.quads]
        volume = (np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]) * p.mean(1)).sum() / 6.0
        assert volume == pytest.approx(12000 - 36 * np.pi, rel=5e-4), "the void is turned inwards"


@pytest.mark.parametrize("suffix", ["brep", "igs"])
def test_an_offset_surface(suffix: str, here, tmp_path) -> None:
    quarter = Geom_RectangularTrimmedSurface(Geom_CylindricalSurface(gp_Ax3(), 9.0), 0.0, np.pi / 2, 0.0, 20.0)
    offset = Geom_OffsetSurface(GeomConvert.SurfaceToBSplineSurface_s(quarter), 1.0)
    face = BRepBuilderAPI_MakeFace(offset, *offset.Bounds(), 1e-6).Face()
    model = csalf.Model(write(face, tmp_path / f"offset.{suffix}"))
    assert any("offset" in note for note in model.notes), model.notes
    assert csalf.mesh_model(model, size=1.0).area.sum() == pytest.approx(100 * np.pi, rel=0.01)


def test_files_that_are_broken(tmp_path) -> None:
    with pytest.raises(FileNotFoundError):
        csalf.Model(tmp_path / "none.igs")
    for suffix in ("brep", "igs"):
        whole = write(block(), tmp_path / f"whole.{suffix}").read_bytes()
        bad = tmp_path / f"bad.{suffix}"
        for content in (b"", b"nothing", whole[: len(whole) // 2], whole[:-100]):
            bad.write_bytes(content)
            with pytest.raises(csalf.FormatError, match="bad.* cut off") as caught:
                csalf.Model(bad)
            assert caught.value.format in ("iges", "brep")
    edge = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0)).Edge()
    with pytest.raises(csalf.FormatError, match="edge.igs: there is no face in it"):
        csalf.mesh_model(write(edge, tmp_path / "edge.igs"), size=1.0)


def test_a_crash_is_an_error(tmp_path, monkeypatch) -> None:
    path = write(sheet(), tmp_path / "sheet.brep")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    (tmp_path / "OCP").mkdir()
    (tmp_path / "OCP" / "__init__.py").write_text("import os\nos.abort()\n")
    with pytest.raises(csalf.FormatError, match="crashed"):
        csalf.Model(path)
    (tmp_path / "OCP" / "__init__.py").write_text("import time\ntime.sleep(60)\n")
    monkeypatch.setattr(_cad, "PATIENCE", 0.5)
    with pytest.raises(csalf.FormatError, match="did not come to an end"):
        csalf.Model(path)


def test_without_open_cascade(tmp_path, monkeypatch, capsys) -> None:
    path = write(sheet(), tmp_path / "sheet.brep")
    monkeypatch.setitem(sys.modules, "OCP", None)
    with pytest.raises(csalf.MissingError, match=r"pip install 'csalf\[cad\]'") as caught:
        csalf.Model(path)
    assert isinstance(caught.value, csalf.Error) and isinstance(caught.value, ImportError)
    assert csalf.cad.main([str(path), str(tmp_path / "sheet.step")]) == 2
    assert "csalf[cad]" in capsys.readouterr().err


def test_the_command(tmp_path, capsys) -> None:
    path, out = write(block(), tmp_path / "block.igs"), tmp_path / "block.step"
    assert csalf.cad.main([str(path), str(out)]) == 0
    assert "sewn" in capsys.readouterr().err
    mesh = csalf.mesh(out, size=3.0)
    renamed = path.rename(tmp_path / "block.dat")
    assert csalf.cad.main([str(renamed), str(out)]) == 3
    assert np.array_equal(csalf.mesh(renamed, size=3.0, format="iges").points, mesh.points)
    assert csalf.cad.main([str(tmp_path / "none.igs"), str(out)]) == 5


def test_on_a_cluster(here, tmp_path) -> None:
    distributed = pytest.importorskip("distributed")
    import csalf.distributed

    path = write(block(), tmp_path / "block.igs")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            mesh = csalf.distributed.mesh_model(path, size=3.0, client=client)
    assert np.array_equal(mesh.points, csalf.mesh_model(path, size=3.0).points)
