"""``python -m csalf.cad IN OUT.step``: an IGES or BREP file as STEP, for the command ``csalf`` and other programs.

What was done to the model goes to the standard error. Exit codes are those of ``csalf``: 2 wrong arguments or no Open
CASCADE, 3 not such a file, 5 file trouble.
"""

from __future__ import annotations

import argparse
import os
import sys

from . import _cad
from ._errors import FormatError, MissingError


def to_step(path: str | os.PathLike[str], out: str | os.PathLike[str], format: str | None = None) -> list[str]:
    """Writes an IGES or BREP file as STEP; returns what was done to the model, in words. ``format`` is ``iges`` or
    ``brep``, by default by extension. Raises ``MissingError``, ``FormatError``, ``OSError``."""
    given = os.fspath(path)
    kind = _cad.format_of(given, format)
    if kind is None:
        raise FormatError(f"{given}: neither IGES nor BREP: .igs, .iges, .brep or .brp", format or "")
    step, notes = _cad.convert(given, kind)
    with open(out, "wb") as file:
        file.write(step)
    return notes


def main(arguments: list[str] | None = None) -> int:
    """The command; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m csalf.cad", description="Converts IGES and BREP to STEP.")
    parser.add_argument("path", metavar="IN", help="an .igs, .iges, .brep or .brp file")
    parser.add_argument("out", metavar="OUT.step")
    parser.add_argument("--format", choices=("iges", "brep"), help="where the extension does not tell")
    given = parser.parse_args(arguments)
    try:
        notes = to_step(given.path, given.out, given.format)
    except (MissingError, FormatError, OSError) as e:
        print(f"error: {e}", file=sys.stderr)
        return 2 if isinstance(e, MissingError) else 3 if isinstance(e, FormatError) else 5
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
