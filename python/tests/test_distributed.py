"""A cluster of processes gives the mesh of one process, and loses nothing when one of them is killed."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest
from conftest import boxes

import csalf

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dask")
    cluster = distributed.LocalCluster(
        n_workers=3,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,
        local_directory=str(folder),
        silence_logs=50,
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


def test_a_killed_worker_loses_nothing(client, tmp_path) -> None:
    import csalf.distributed

    path = boxes(tmp_path / "boxes.stl", 10)
    asked = {"size": 0.05, "points": {"weld": (0.3, 0.5, 1.0)}}
    whole = csalf.mesh_model(path, **asked)
    killed, seen = [], []

    def progress(done: int, of: int) -> None:
        seen.append((done, of))
        if done == of // 2:
            # One that holds finished parts, which are lost with it.
            holders = {w for who in client.who_has().values() for w in who}
            pids = client.run(os.getpid)
            victim = sorted(holders & set(pids))[0]
            killed.append(pids[victim])
            os.kill(pids[victim], signal.SIGKILL)

    mesh = csalf.distributed.mesh_model(path, client=client, parts=12, progress=progress, **asked)
    assert len(killed) == 1 and seen[-1] == (12, 12)
    assert killed[0] not in client.run(os.getpid).values()
    assert np.array_equal(mesh.points.view(np.uint64), whole.points.view(np.uint64))
    for suffix in ("inp", "vtu", "msh"):
        whole.write(tmp_path / f"a.{suffix}")
        mesh.write(tmp_path / f"b.{suffix}")
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


def test_the_exceptions_are_those_of_one_process(client, tmp_path) -> None:
    import csalf.distributed

    path = boxes(tmp_path / "boxes.stl", 2)
    model = csalf.Model(path)
    counts = {name: 2 for name in model.edges[:12]} | {model.edges[0]: 3}
    with pytest.raises(csalf.ModelError) as alone:
        csalf.mesh_model(path, size=0.5, edge_counts=counts)
    # The current client, tasks by themselves.
    with pytest.raises(csalf.ModelError) as there:
        csalf.distributed.mesh_model(path, size=0.5, edge_counts=counts)
    assert there.value.failures == alone.value.failures
    assert np.array_equal(there.value.mesh.points, alone.value.mesh.points)
    with pytest.raises(csalf.Cancelled):
        csalf.distributed.mesh_model(path, size=0.4, progress=lambda done, of: False)
    with pytest.raises(csalf.SizeError):
        csalf.distributed.mesh_model(path, size=0)
    with pytest.raises(FileNotFoundError):
        csalf.distributed.mesh_model(tmp_path / "none.step", size=1)
