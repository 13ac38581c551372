"""Exceptions. All but file trouble (``OSError``) and wrong arguments (``ValueError``) derive from ``Error``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Mapping, Sequence

if TYPE_CHECKING:
    from ._csalf import Job
    from ._model import ModelMesh


class Error(Exception):
    """Anything that csalf raises of its own."""


@dataclass(frozen=True)
class Place:
    """A node (or the segment that starts at it) of a loop, scar or point."""

    role: str
    """What it is in the defect: ``first``, ``second``, ``node``, ``segment``, ``at``, ..."""
    name: str
    """Name of the loop, scar or point."""
    index: int
    """Node, or segment by its first node, counted from 0 as in the input."""
    x: float
    y: float


@dataclass(frozen=True)
class Defect:
    """One thing that is wrong with the input."""

    kind: str
    """``SelfIntersection``, ``OddTotal``, ``RepeatedNode``, ...: the name of the variant in Rust."""
    message: str
    """What is wrong, where, and what cures it."""
    places: tuple[Place, ...] = ()
    fields: Mapping[str, Any] = field(default_factory=dict)
    """All other fields of the variant."""

    def __str__(self) -> str:
        return self.message


class GeometryError(Error, ValueError):
    """The outline cannot be meshed; ``defects`` lists everything that is wrong with it."""

    defects: tuple[Defect, ...]

    def __init__(self, message: str, defects: Sequence[Mapping[str, Any] | Defect] = ()) -> None:
        super().__init__(message)
        self.defects = tuple(d if isinstance(d, Defect) else _defect(d) for d in defects)

    def __reduce__(self) -> tuple[type[GeometryError], tuple[str, tuple[Defect, ...]]]:
        return type(self), (str(self), self.defects)


class SizeError(Error, ValueError):
    """The wanted sizes are invalid."""

    def __init__(
        self, message: str, what: str = "", index: int | None = None, value: float | None = None
    ) -> None:
        super().__init__(message)
        self.what = what
        """The list that holds the fault: ``loop node``, ``source``, ``background node``, ..."""
        self.index = index
        """Place in the list, counted from 0."""
        self.value = value
        """The wrong value."""

    def __reduce__(self) -> tuple[type[SizeError], tuple[str, str, int | None, float | None]]:
        return type(self), (str(self), self.what, self.index, self.value)


class FormatError(Error, ValueError):
    """A file is not what its format asks for, or its format is not known."""

    def __init__(
        self,
        message: str,
        format: str = "",
        line: int | None = None,
        byte: int | None = None,
        path: str | None = None,
    ) -> None:
        super().__init__(message)
        self.format = format
        self.line = line
        """Line, counted from 1."""
        self.byte = byte
        """Byte, counted from 0."""
        self.path = path
        """Path into a tree, such as ``loops[1].nodes[7]``."""

    def __reduce__(self) -> tuple[type[FormatError], tuple[str, str, int | None, int | None, str | None]]:
        return type(self), (str(self), self.format, self.line, self.byte, self.path)


@dataclass(frozen=True)
class FaceFailure:
    """A face of a model without a mesh."""

    face: int
    """Which face, from 0."""
    name: str
    """Its name."""
    message: str
    """Why."""
    case_json: bytes | None = field(default=None, repr=False)
    """Its flat boundary as a job file, if it came so far."""

    @property
    def case(self) -> Job | None:
        """Its flat boundary as a job for ``csalf.mesh``, to reproduce the failure."""
        from ._csalf import Job

        return None if self.case_json is None else Job.from_json(self.case_json)

    def __str__(self) -> str:
        return f"{self.name}: {self.message}"


class ModelError(Error, RuntimeError):
    """Some faces of a model have no mesh: ``failures`` says which and why, ``mesh`` holds the others."""

    def __init__(self, message: str, failures: Sequence[FaceFailure], mesh: ModelMesh) -> None:
        super().__init__(message)
        self.failures = tuple(failures)
        self.mesh = mesh

    def __reduce__(self) -> tuple[type[ModelError], tuple[str, tuple[FaceFailure, ...], ModelMesh]]:
        return type(self), (str(self), self.failures, self.mesh)


class ShardError(Error, ValueError):
    """Shards that do not go together: ``problems`` has one sentence for each fault, which names the shard."""

    def __init__(self, message: str, problems: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems)

    def __reduce__(self) -> tuple[type[ShardError], tuple[str, tuple[str, ...]]]:
        return type(self), (str(self), self.problems)


class MissingError(Error, ImportError):
    """An optional package is needed and not installed; the message says how to get it."""


class InternalError(Error, RuntimeError):
    """A defect of csalf: please report it with the input."""

    def __init__(self, message: str, stage: str = "", detail: str = "") -> None:
        super().__init__(message)
        self.stage = stage
        self.detail = detail

    def __reduce__(self) -> tuple[type[InternalError], tuple[str, str, str]]:
        return type(self), (str(self), self.stage, self.detail)


class Cancelled(Error):
    """The progress callback returned ``False``."""


def _defect(d: Mapping[str, Any]) -> Defect:
    return Defect(d["kind"], d["message"], tuple(Place(*p) for p in d["places"]), dict(d["fields"]))
