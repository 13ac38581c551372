"""IGES and BREP files, by Open CASCADE (``pip install 'csalf[cad]'``), as STEP, which the reader of models takes.

    file ─read─▶ shape ─edges of one face? sew─▶ faces that share edges ─closed shells─▶ solids ─▶ STEP in memory

1. The file is read. Lengths of IGES are turned into millimetres by the unit in its header; BREP has none.
2. Offset surfaces become splines.
3. If edges bound one face only, the faces are sewn: within 1e-6, 1e-5, then 1e-4 of the diagonal. The first of the
   results with the fewest such edges is kept. Edges that are shorter than the tolerance go.
4. Closed shells become solids, one in another a void.
5. STEP is written, with the names of faces that the IGES file has, and with the circles and elementary surfaces that
   stand behind its forms.

All that is done in a process of its own, which a crash or Ctrl-C ends: damaged files let Open CASCADE crash or read for
ever (that is ended, too), and it prints. Written against Open CASCADE 7.9 and 8.0.
"""

from __future__ import annotations

import faulthandler
import importlib.util
import io
import os
import pickle
import re
import subprocess
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple

from ._cad_forms import circle, elementary
from ._errors import FormatError, MissingError

if TYPE_CHECKING:
    from OCP.IGESControl import IGESControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS_Shape

FORMATS = {"igs": "iges", "iges": "iges", "brep": "brep", "brp": "brep"}
"""Format by extension, or by name."""

SEWING = (1e-6, 1e-5, 1e-4)
"""Shares of the diagonal within which faces are sewn, tried in turn."""

FORM = 1e-6
"""Share of the diagonal within which a surface of an IGES file is an elementary one."""

ARC = 1e-5
"""Share of the diagonal within which an edge of an IGES file is an arc: Open CASCADE approximates curves."""

PATIENCE, PATIENCE_PER_BYTE = 60.0, 1e-4
"""Seconds that reading a file may take. Files of 4 MB take one or two."""

BINARY = b"Open CASCADE Topology"
"""Near the beginning of binary BREP files, and of no others."""

BREP_END = re.compile(rb"\*\s+[+-]\d+ \d+\s*\Z")
"""The last sub-shape of a BREP file, and the shape itself."""


class Converted(NamedTuple):
    """A model as STEP."""

    step: bytes
    notes: list[str]
    """What was done to it, in words."""


def format_of(path: str, format: str | None) -> str | None:
    """The format, by name or extension; ``None`` if it is not one of these."""
    return FORMATS.get((format or os.path.splitext(path)[1][1:]).lower())


def stem(path: str) -> str:
    """The name of the file without its extension: that of the model."""
    return os.path.splitext(os.path.basename(path))[0]


def convert(path: str, format: str) -> Converted:
    """The model in an IGES or BREP file. Raises ``MissingError``, ``FormatError``, ``OSError``."""
    with open(path, "rb") as file:
        head = file.read(100)
        file.seek(max(0, os.path.getsize(path) - 4000))
        tail = file.read()
    if (why := _cut_off(head, tail, format)) is not None:
        raise FormatError(f"{path}: {why}", format)
    if importlib.util.find_spec("OCP") is None:
        raise _missing(path, "there is no module OCP")
    code = f"import sys; sys.path[:] = {sys.path!r}; from csalf._cad import serve; serve()"
    limit = PATIENCE + os.path.getsize(path) * PATIENCE_PER_BYTE
    command = [sys.executable, "-c", code, path, format, str(limit)]
    child = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True)
    try:
        answer = pickle.loads(child.stdout)
    except Exception as e:
        if b"Timeout (" in child.stderr:
            what = f"did not come to an end within {limit:.0f} s: the file is damaged"
        else:
            last = child.stderr.decode(errors="replace").strip().rpartition("\n")[2]
            what = f"crashed (exit code {child.returncode}) {last}".rstrip()
        raise FormatError(f"{path}: Open CASCADE {what}", format) from e
    if isinstance(answer, Exception):
        raise answer
    return Converted(*answer)


def _cut_off(head: bytes, tail: bytes, format: str) -> str | None:
    """What is missing at the end of a file: Open CASCADE reads what there is of IGES, and looks for the rest of a BREP
    file for ever."""
    if format == "iges":
        if not any(line[72:73] == b"T" for line in tail.splitlines()):
            return "not an IGES file, or cut off: it has no terminate section"
    elif BINARY not in head and not BREP_END.search(tail):
        return "not a BREP file, or cut off: its last shape is missing"
    return None


def serve() -> None:
    """The process beside: converts a file, and writes what came of it to the standard output."""
    out = os.dup(1)
    os.dup2(2, 1)  # what Open CASCADE prints
    path, format, limit = sys.argv[1:]
    # Ends the process, even if Open CASCADE does not let Python run.
    faulthandler.dump_traceback_later(float(limit), exit=True)
    answer: object
    try:
        answer = tuple(_converted(path, format))
    except ImportError as e:
        answer = _missing(path, str(e))
    except FormatError as e:
        answer = FormatError(f"{path}: {e}", format)
    except OSError as e:
        answer = e
    except Exception as e:  # whatever Open CASCADE throws
        answer = FormatError(f"{path}: Open CASCADE stopped: {type(e).__name__}: {e}", format)
    with os.fdopen(out, "wb") as pipe:
        pickle.dump(answer, pipe)


def _missing(path: str, why: str) -> MissingError:
    return MissingError(f"{path}: IGES and BREP need Open CASCADE: pip install 'csalf[cad]' ({why})")


def _converted(path: str, format: str) -> Converted:
    import OCP
    from OCP.TopAbs import TopAbs_ShapeEnum as Kind

    # 7.8 crashes where entities are added to a model of STEP.
    if re.match(r"[0-6]\.|7\.[0-8]\b", version := str(getattr(OCP, "__version__", ""))):
        raise ImportError(f"version {version} is there, it takes 7.9 or newer")
    notes = []
    if format == "iges":
        shape, names = _of_iges(path)
    else:
        shape, names = _of_brep(path), []
        notes.append("a BREP file has no unit of length: the numbers are taken as they are")
    faulthandler.cancel_dump_traceback_later()
    n_faces = len(_Shapes(_parts(shape, Kind.TopAbs_FACE)))
    if n_faces == 0:
        raise FormatError("there is no face in it", format)
    if n_curves := sum(1 for _ in _parts(shape, Kind.TopAbs_EDGE, Kind.TopAbs_FACE)):
        notes.append(f"{n_curves} curves that bound no face were left out")
    shape, n_offset, names = _without_offsets(shape, names)
    if n_offset:
        notes.append(f"{n_offset} offset surfaces became splines")
    n_free = _n_free(shape)
    if n_free:
        shape, tolerance, n_left, names = _sewn(shape, n_free, names)
        if tolerance is not None:
            notes.append(f"faces were sewn within {tolerance:.3g}: of {n_free} free edges {n_left} are left")
        else:
            notes.append(f"{n_free} edges are free: nothing to sew them to")
    return Converted(_step(_bodies(shape), stem(path), names, format == "iges"), notes)


Names = list[tuple["TopoDS_Shape", str]]


def _of_iges(path: str) -> tuple[TopoDS_Shape, Names]:
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESControl import IGESControl_Reader

    reader = IGESControl_Reader()
    if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise FormatError("not an IGES file", "iges")
    reader.TransferRoots()
    shape = reader.OneShape()
    if shape.IsNull():
        raise FormatError("there is no shape in it", "iges")
    return shape, _names(reader)


def _names(reader: IGESControl_Reader) -> Names:
    """Faces with the name that their entity has."""
    from OCP.TopAbs import TopAbs_ShapeEnum as Kind
    from OCP.TopLoc import TopLoc_Location

    model, results = reader.IGESModel(), reader.WS().TransferReader()
    if not any(model.Entity(k).HasName() for k in range(1, model.NbEntities() + 1)):
        return []
    names: Names = []
    for face, _ in _Shapes(_parts(reader.OneShape(), Kind.TopAbs_FACE)):
        # Recorded as made, before it was placed; 1: all entities, not the roots alone.
        entity = results.EntityFromShapeResult(face.Located(TopLoc_Location()), 1)
        if entity is not None and entity.HasName():
            with suppress(UnicodeDecodeError):
                names.append((face, entity.NameValue().ToCString().strip()))
    return names


def _of_brep(path: str) -> TopoDS_Shape:
    from OCP.BinTools import BinTools
    from OCP.BRep import BRep_Builder
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS_Shape

    shape = TopoDS_Shape()
    with open(path, "rb") as file:
        binary = BINARY in file.read(100)
    if binary:
        read = BinTools.Read_s(shape, path)
    else:
        read = BRepTools.Read_s(shape, path, BRep_Builder())
    if not read or shape.IsNull():
        raise FormatError("not a BREP file", "brep")
    return shape


def _without_offsets(shape: TopoDS_Shape, names: Names) -> tuple[TopoDS_Shape, int, Names]:
    """The shape with splines for offset surfaces, which the reader of STEP leaves out; and how many there were."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepTools import BRepTools_Modifier
    from OCP.Geom import Geom_OffsetSurface, Geom_RectangularTrimmedSurface
    from OCP.ShapeCustom import ShapeCustom_ConvertToBSpline
    from OCP.TopAbs import TopAbs_ShapeEnum as Kind

    n_offset = 0
    for face, _ in _Shapes(_parts(shape, Kind.TopAbs_FACE)):
        surface = BRep_Tool.Surface_s(_cast(face, "Face"))
        if isinstance(surface, Geom_RectangularTrimmedSurface):
            surface = surface.BasisSurface()
        n_offset += isinstance(surface, Geom_OffsetSurface)
    if n_offset == 0:
        return shape, 0, names
    splines = ShapeCustom_ConvertToBSpline()
    splines.SetOffsetMode(True)
    for other in (splines.SetExtrusionMode, splines.SetRevolutionMode, splines.SetPlaneMode):
        other(False)
    change = BRepTools_Modifier(shape, splines)
    return change.ModifiedShape(shape), n_offset, [(change.ModifiedShape(face), name) for face, name in names]


def _sewn(shape: TopoDS_Shape, n_free: int, names: Names) -> tuple[TopoDS_Shape, float | None, int, Names]:
    """The shape with its faces sewn, within which length (``None``: it stays as it is), and its free edges."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
    from OCP.ShapeFix import ShapeFix_Wireframe

    diagonal = _diagonal(shape)
    best: tuple[TopoDS_Shape, float | None, int, Names] = (shape, None, n_free, names)
    for tolerance in (share * diagonal for share in SEWING):
        sewing = BRepBuilderAPI_Sewing(tolerance)
        sewing.Add(shape)
        sewing.Perform()
        made = sewing.SewedShape()
        # A face that is thinner than the tolerance is deleted.
        if made.IsNull() or sewing.NbDeletedFaces() > 0:
            break
        if (n_left := _n_free(made)) < best[2]:
            best = (made, tolerance, n_left, [(sewing.ModifiedSubShape(face), name) for face, name in names])
        if n_left == 0:
            break
    made, within, _, names = best
    if within is None:
        return best
    # Where vertices of neighbours are near each other, sewing cuts slivers from edges.
    fix = ShapeFix_Wireframe(made)
    fix.SetPrecision(within)
    fix.SetMaxTolerance(within)
    fix.ModeDropSmallEdges = True
    if not fix.FixSmallEdges():
        return best
    return fix.Shape(), within, _n_free(fix.Shape()), [(fix.Context().Apply(f), name) for f, name in names]


def _bodies(shape: TopoDS_Shape) -> TopoDS_Shape:
    """Its solids, shells and faces; closed shells become solids."""
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.ShapeFix import ShapeFix_Solid
    from OCP.TopAbs import TopAbs_ShapeEnum as Kind
    from OCP.TopoDS import TopoDS_Compound, TopoDS_Shell, TopoDS_Solid

    build = BRep_Builder()
    bodies = TopoDS_Compound()
    build.MakeCompound(bodies)
    for solid in _parts(shape, Kind.TopAbs_SOLID):
        build.Add(bodies, solid)
    shells = list(_parts(shape, Kind.TopAbs_SHELL, Kind.TopAbs_SOLID))
    for face in _parts(shape, Kind.TopAbs_FACE, Kind.TopAbs_SHELL):
        shell = TopoDS_Shell()
        build.MakeShell(shell)
        build.Add(shell, face)
        shells.append(shell)
    closed = TopoDS_Solid()
    build.MakeSolid(closed)
    for shell in shells:
        build.Add(closed if BRep_Tool.IsClosed_s(shell) else bodies, shell)
    n_faces = len(_Shapes(_parts(closed, Kind.TopAbs_FACE)))
    if n_faces > 0:
        fix = ShapeFix_Solid(closed)
        fix.Perform()
        whole = len(_Shapes(_parts(fix.Shape(), Kind.TopAbs_FACE))) == n_faces
        for body in [fix.Shape()] if whole else _parts(closed, Kind.TopAbs_SHELL):
            build.Add(bodies, body)
    return bodies


def _step(shape: TopoDS_Shape, name: str, names: Names, forms: bool) -> bytes:
    """STEP of the shape, its product and its faces named; with ``forms`` circles and elementary surfaces are found."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.StepBasic import StepBasic_Product
    from OCP.STEPConstruct import STEPConstruct
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
    from OCP.TCollection import TCollection_HAsciiString

    writer = STEPControl_Writer()
    # No curves in the parameters of surfaces: nobody reads them, and the surfaces may be others in the end.
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    status = writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    if status != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise FormatError("its shape cannot be written as STEP", "step")
    model = writer.Model()
    for k in range(1, model.NbEntities() + 1):
        if isinstance(entity := model.Value(k), StepBasic_Product):
            entity.SetName(TCollection_HAsciiString(name))
    finder = writer.WS().TransferWriter().FinderProcess()
    for face, given in names:
        if (item := STEPConstruct.FindEntity_s(finder, face)) is not None:
            item.SetName(TCollection_HAsciiString(given))
    if forms:
        for item in _found_forms(shape, finder):
            model.AddEntity(item)
    out = io.BytesIO()
    if writer.WriteStream(out) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise FormatError("its shape cannot be written as STEP", "step")
    return out.getvalue()


def _found_forms(shape: TopoDS_Shape, finder: Any) -> list[Any]:
    """Gives entities of STEP the circles and elementary surfaces that stand behind their forms; returns all that is
    new in the model."""
    from OCP.GeomToStep import GeomToStep_MakeCurve, GeomToStep_MakeSurface
    from OCP.StepData import StepData_Factors
    from OCP.STEPConstruct import STEPConstruct
    from OCP.TopAbs import TopAbs_ShapeEnum as Kind

    diagonal, factors = _diagonal(shape), StepData_Factors()
    made: list[Any] = []

    def new(item: Any, position: Any) -> None:
        made.extend((item, position, position.Location(), position.Axis(), position.RefDirection()))

    solids, shells = _parts(shape, Kind.TopAbs_SOLID), _parts(shape, Kind.TopAbs_SHELL, Kind.TopAbs_SOLID)
    for body in (*solids, *shells):
        # What is placed by a transformation has coordinates of its own in the file.
        if not body.Location().IsIdentity():
            continue
        for face, _ in _Shapes(_parts(body, Kind.TopAbs_FACE)):
            item = STEPConstruct.FindEntity_s(finder, face)
            form = elementary(_cast(face, "Face"), FORM * diagonal)
            if item is not None and form is not None:
                surface, same = form
                item.SetFaceGeometry(GeomToStep_MakeSurface(surface, factors).Value())
                item.SetSameSense(item.SameSense() == same)
                new(item.FaceGeometry(), item.FaceGeometry().Position())
        for edge, _ in _Shapes(_parts(body, Kind.TopAbs_EDGE)):
            item = STEPConstruct.FindEntity_s(finder, edge)
            curve = circle(_cast(edge, "Edge"), ARC * diagonal)
            if item is not None and curve is not None:
                item.SetEdgeGeometry(GeomToStep_MakeCurve(curve, factors).Value())
                new(item.EdgeGeometry(), item.EdgeGeometry().Position().Axis2Placement3d())
    return made


def _diagonal(shape: TopoDS_Shape) -> float:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    return float(box.CornerMin().Distance(box.CornerMax()))


def _n_free(shape: TopoDS_Shape) -> int:
    """Edges that bound one face, and that once: seams bound it twice."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_ShapeEnum as Kind
    faces = _Shapes(_parts(shape, Kind.TopAbs_FACE))
    edges = _Shapes(edge for face, _ in faces for edge in _parts(face, Kind.TopAbs_EDGE))
    return sum(1 for edge, n in edges if n == 1 and not BRep_Tool.Degenerated_s(_cast(edge, "Edge")))


def _parts(
    shape: TopoDS_Shape, kind: TopAbs_ShapeEnum, not_in: TopAbs_ShapeEnum | None = None
) -> Iterator[TopoDS_Shape]:
    """Its parts of a kind, each as often as it is used; those in parts of another kind left out."""
    from OCP.TopExp import TopExp_Explorer

    walk = TopExp_Explorer(shape, kind) if not_in is None else TopExp_Explorer(shape, kind, not_in)
    while walk.More():
        yield walk.Current()
        walk.Next()


def _cast(shape: TopoDS_Shape, kind: str) -> Any:
    """The shape as an edge or a face, of which it is known to be one."""
    from OCP.TopoDS import TopoDS

    return (getattr(TopoDS, f"{kind}_s", None) or getattr(TopoDS, kind))(shape)  # 7, 8


class _Shapes:
    """Different shapes, and how often each was there."""

    def __init__(self, shapes: Iterator[TopoDS_Shape]) -> None:
        # Python's == of shapes is identity of the wrappers.
        self._rows: dict[int, list[list[Any]]] = {}
        for shape in shapes:
            rows = self._rows.setdefault(hash(shape), [])
            row = next((r for r in rows if r[0].IsSame(shape)), None)
            if row is None:
                rows.append([shape, 1])
            else:
                row[1] += 1

    def __iter__(self) -> Iterator[tuple[TopoDS_Shape, int]]:
        return ((shape, n) for rows in self._rows.values() for shape, n in rows)

    def __len__(self) -> int:
        return sum(len(rows) for rows in self._rows.values())
