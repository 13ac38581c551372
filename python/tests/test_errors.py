"""What is wrong is said with its place; runs can be followed and ended."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import rectangle, ring

import csalf

SQUARE = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]


def test_every_defect_has_its_place() -> None:
    bow = [(0, 0), (4, 0), (0, 4), (4, 4)]
    with pytest.raises(csalf.GeometryError) as caught:
        csalf.mesh(loops=[bow, [(1, 1), (2, 1)]], size=1.0)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, csalf.Error)
    by_kind = {d.kind: d for d in caught.value.defects}
    crossing = by_kind["SelfIntersection"]
    assert (crossing.fields["x"], crossing.fields["y"]) == pytest.approx((2, 2))
    assert [p.role for p in crossing.places] == ["first", "second"]
    assert {(p.name, p.index) for p in crossing.places} == {("outer", 1), ("outer", 3)}
    assert (crossing.places[0].x, crossing.places[0].y) == (4, 0)
    few = by_kind["TooFewNodes"]
    assert dict(few.fields) == {"loop_name": "hole0", "n_nodes": 2}
    assert str(few).startswith("hole0 has 2 nodes")
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.defects == caught.value.defects and str(again) == str(caught.value)


def test_other_defects() -> None:
    def kinds(**what: object) -> list[str]:
        with pytest.raises(csalf.GeometryError) as caught:
            csalf.mesh(**what)
        return [d.kind for d in caught.value.defects]

    assert kinds(loops=[SQUARE[:-1]], size=1.0) == ["OddTotal"]
    assert kinds(loops=[SQUARE, ring((5, 5), 1, 8)]) == ["Outside"]
    assert kinds(loops=[[*SQUARE[:3], (float("nan"), 1), *SQUARE[4:]]]) == ["NotFinite"]
    assert kinds(loops=[SQUARE], points=[(9, 9)]) == ["Outside"]
    assert kinds(loops=[SQUARE], points=[(1, 0.9, -1)]) == ["BadSize"]


def test_sizes() -> None:
    with pytest.raises(csalf.SizeError) as caught:
        csalf.mesh(loops=[SQUARE], size=-1.0)
    assert (caught.value.what, caught.value.value) == ("uniform size", -1.0)
    with pytest.raises(csalf.SizeError, match=r"gave nan at \("):
        csalf.mesh(loops=[SQUARE], size=lambda x, y: np.where(x > 1, np.nan, 1.0))
    with pytest.raises(csalf.SizeError):
        csalf.mesh(loops=[SQUARE], size=([(0, 0), (1, 0)], [1.0]))
    with pytest.raises(ZeroDivisionError):
        csalf.mesh(loops=[SQUARE], size=lambda x, y: 1 / 0)


def test_arguments() -> None:
    for what in ({}, {"loops": SQUARE}, {"loops": [[1, 2, 3]]}, {"loops": [SQUARE], "size": "big"}):
        with pytest.raises((TypeError, ValueError)):
            csalf.mesh(**what)
    with pytest.raises(TypeError, match="one for each loop"):
        csalf.mesh(loops=np.array(SQUARE, dtype=float))
    with pytest.raises(ValueError, match="layers of 'outer'"):
        csalf.mesh(loops=[SQUARE], layers={"outer": {"counts": 3}})
    with pytest.raises(ValueError, match="not a law"):
        csalf.mesh(loops=[SQUARE], layers={"outer": (1, "cubic")})
    assert len(csalf.mesh(loops=[np.array(SQUARE, dtype=np.float32)], size=np.float32(1)).quads) == 4
    assert len(csalf.mesh(loops=[[*SQUARE, SQUARE[0]]], size=1).quads) == 4


def test_files(tmp_path) -> None:
    with pytest.raises(FileNotFoundError) as missing:
        csalf.mesh(tmp_path / "nothing.json")
    assert missing.value.filename == str(tmp_path / "nothing.json")
    with pytest.raises(FileNotFoundError):
        csalf.read(tmp_path / "nothing.vtu")
    with pytest.raises(csalf.FormatError, match="unknown file extension"):
        csalf.read(tmp_path / "mesh.xyz")
    (tmp_path / "bad.json").write_text('{"loops": [{"nodes": [[0, 0], [1, "x"]]}]}')
    with pytest.raises(csalf.FormatError) as caught:
        csalf.mesh(tmp_path / "bad.json")
    assert caught.value.path == "loops[0].nodes[1][1]" or caught.value.line
    (tmp_path / "bad.inp").write_text("*NODE\n1, 0, zero\n")
    with pytest.raises(csalf.FormatError) as caught:
        csalf.read(tmp_path / "bad.inp")
    assert caught.value.line == 2
    with pytest.raises(OSError):
        csalf.mesh(loops=[SQUARE], size=1).write(tmp_path / "no" / "folder.vtu")
    with pytest.raises(csalf.FormatError):
        csalf.mesh(loops=[SQUARE], size=1).write(tmp_path / "mesh.xyz")
    assert not (tmp_path / "mesh.xyz").exists()


def test_wrong_arrays() -> None:
    with pytest.raises(ValueError, match="names vertex 7"):
        csalf.Mesh.from_arrays([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2, 7)])
    with pytest.raises(ValueError, match="set 'a'"):
        csalf.Mesh.from_arrays([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2, 3)], quad_sets={"a": [1]})
    inverted = csalf.Mesh.from_arrays([(0, 0), (1, 0), (1, 1), (0, 1)], [(3, 2, 1, 0)])
    found = csalf.check(inverted)
    assert not found and found.findings
    good = csalf.Mesh.from_arrays([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2, 3)])
    assert csalf.check(good, min_sj=0.5) and not csalf.check(good, min_sj=1.5)


def test_progress_and_cancel() -> None:
    seen: list[str] = []
    csalf.mesh(loops=[SQUARE], size=1, progress=seen.append)
    assert seen == ["check", "size", "fill", "collect", "clean", "certify"]
    with pytest.raises(csalf.Cancelled):
        csalf.mesh(loops=[rectangle(1, 1, 300, 300)], progress=lambda stage: stage != "fill")

    def fails(stage: str) -> None:
        raise KeyError(stage)

    with pytest.raises(KeyError, match="check"):
        csalf.mesh(loops=[SQUARE], size=1, progress=fails)


def test_the_lock_of_the_interpreter_is_free_while_meshing() -> None:
    steps = 0
    done = threading.Event()

    def count() -> None:
        nonlocal steps
        while not done.is_set():
            steps += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = steps
    csalf.mesh(loops=[rectangle(1, 1, 600, 600)], size=1 / 600)
    done.set()
    thread.join()
    assert steps - before > 5


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c() -> None:
    program = """
        import signal, sys, numpy as np, csalf
        # Of jobs in the background the shell has them ignore it.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        n = 3000
        t = np.linspace(0, 1, n, endpoint=False)
        o = np.zeros(n)
        loop = np.concatenate([np.stack(s, 1) for s in ((t, o), (o + 1, t), (1 - t, o + 1), (o, 1 - t))])
        print("go", flush=True)
        try:
            csalf.mesh(loops=[loop], size=1 / n)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
    """
    child = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE, text=True, env=os.environ
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "go\n"
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=120)
    assert out == "interrupted\n"
