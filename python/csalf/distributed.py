"""Models meshed on a cluster by dask.distributed (``pip install 'csalf[distributed]'``).

>>> from dask.distributed import Client
>>> import csalf.distributed
>>> client = Client("tcp://scheduler:8786")                                    # doctest: +SKIP
>>> mesh = csalf.distributed.mesh_model("part.step", size=5, client=client)    # doctest: +SKIP

Each worker process reads the model and discretises its edges once; that is little work and comes out the same
everywhere, which a fingerprint proves. Then batches of faces are tasks. The mesh is put together by prefix sums: the
same bytes as those of ``csalf.mesh_model``, for any number of workers and whichever of them are lost.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable

from . import _cad, _csalf
from ._errors import Cancelled
from ._model import ModelMesh, Wish, finished

if TYPE_CHECKING:
    from distributed import Client

PARTS_PER_WORKER = 4
"""Tasks per thread of the cluster: more even out the load, fewer cost less."""

KEPT = 2
"""Plans that a worker process keeps: a run needs one."""


@dataclass(frozen=True)
class Task:
    """All that a worker needs to know: the model's file, and what is asked of its mesh."""

    data: bytes
    shown: str
    name: str
    format: str | None
    feature_angle: float | None
    sewing: float | None
    wish: Wish

    def plan(self) -> _csalf.Plan:
        model = _csalf.Model.from_bytes(
            self.data, self.shown, self.name, self.format, self.feature_angle, self.sewing
        )
        return model.plan(self.wish)


def mesh_model(
    source: str | os.PathLike[str],
    /,
    *,
    client: Client | None = None,
    parts: int | None = None,
    threads: int = 1,
    retries: int = 2,
    format: str | None = None,
    feature_angle: float | None = None,
    sewing: float | None = None,
    partial: bool = False,
    progress: Callable[[int, int], object] | None = None,
    **wish: Any,
) -> ModelMesh:
    """Meshes a model as ``csalf.mesh_model`` does, its faces on the workers of ``client`` (``None``: the current one).

    ``parts`` is the number of tasks (by default four per thread of the cluster, at most one per face), ``threads`` the
    number of threads in each. A task whose worker is lost goes to another one; one that raises is tried ``retries``
    times more. ``progress`` is called with the number of finished parts and of all; ``False`` ends the run with
    ``Cancelled``. ``format``, ``feature_angle`` and ``sewing`` are those of ``csalf.Model``; all other arguments, and the
    exceptions, those of ``csalf.mesh_model``.
    """
    from distributed import as_completed, get_client

    if client is None:
        client = get_client()
    path = os.fspath(source)
    if (kind := _cad.format_of(path, format)) is not None:
        # Workers need no Open CASCADE.
        data, format = _cad.convert(path, kind).step, "step"
    else:
        with open(path, "rb") as file:
            data = file.read()
    task = Task(data, path, _cad.stem(path), format, feature_angle, sewing, Wish(**wish))
    plan = task.plan()
    if parts is None:
        parts = PARTS_PER_WORKER * max(1, sum(client.nthreads().values()))
    parts = max(1, min(parts, plan.n_faces))
    fingerprint = plan.fingerprint(parts)
    payload = pickle.dumps(task)
    key = f"csalf-{fingerprint}"
    # A task of its own, not scattered data: the scheduler can give it to a worker again when all that had it are lost.
    shared = client.submit(_same, payload, key=f"{key}-model")
    futures = client.map(
        _shard,
        range(1, parts + 1),
        key=[f"{key}-{k}of{parts}" for k in range(1, parts + 1)],
        payload=shared,
        count=parts,
        fingerprint=fingerprint,
        threads=threads,
        retries=retries,
    )
    try:
        for done, _ in enumerate(as_completed(futures), 1):
            if progress is not None and progress(done, parts) is False:
                raise Cancelled("the run was cancelled")
        shards: list[bytes] = client.gather(futures)
    except BaseException:
        client.cancel([*futures, shared])
        raise
    raw = _csalf.stitch([(f"part {k}", s) for k, s in enumerate(shards, 1)])
    return finished(ModelMesh(raw), partial)


def _same(payload: bytes) -> bytes:
    return payload


_plans: OrderedDict[str, _csalf.Plan] = OrderedDict()
_lock = threading.Lock()


def _plan(payload: bytes) -> _csalf.Plan:
    """The plan of a task, made once per process."""
    key = hashlib.sha256(payload).hexdigest()
    with _lock:
        if key not in _plans:
            task: Task = pickle.loads(payload)
            _plans[key] = task.plan()
            while len(_plans) > KEPT:
                _plans.popitem(last=False)
        _plans.move_to_end(key)
        return _plans[key]


def _shard(index: int, payload: bytes, count: int, fingerprint: str, threads: int) -> bytes:
    """Meshes one part, on a worker."""
    plan = _plan(payload)
    found = plan.fingerprint(count)
    if found != fingerprint:
        raise RuntimeError(
            "this worker discretises the edges otherwise than the client: its version of csalf or its "
            "mathematical library differs"
        )
    return plan.shard(index, count, threads)
