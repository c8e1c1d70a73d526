"""`haverify recheck`: a report re-established by the independent checker, and its core by reading the spec again."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

from haverify.diagnostics.codes import is_meaningless
from haverify.errors import UsageError
from haverify.report.exit_codes import OK, UNREADABLE, WRONG, worst
from haverify.run.recheck import command


def run(called: argparse.Namespace) -> int:
    """Exit code 0 only if the inputs give this core and `hacheck` re-establishes every verdict; else as `hacheck`."""
    folder = Path(called.folder)
    inputs = _inputs(folder)
    sys.stdout.flush()
    answer = subprocess.run(command(folder, *(["--strict"] if called.strict else [])), check=False).returncode
    return worst([inputs, answer if answer in (0, 1, 2, 5) else 4])


def _inputs(folder: Path) -> int:
    """Read the spec of a report again, if it is there, and compare its core byte for byte."""
    try:
        report = json.loads(_bytes(folder / "report.json"))
        core = _bytes(folder / "core.json")
        path, only = Path(report["spec"]), str(report["options"]["property"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return UNREADABLE
    if not path.is_file():
        print(f"{path}: not here, so the core is taken as it is")
        return OK
    text = _core_again(str(path), only)
    if text is None:
        print(f"{path}: cannot be read as it could when the report was made")
        return WRONG
    if text != core:
        print(f"{path}: gives another core than {folder}/core.json; the report is about another version of it")
        return WRONG
    print(f"{path}: read again, gives the same core")
    return OK


def _bytes(path: Path) -> bytes:
    """The contents of a regular file; a pipe or a device could keep us for ever."""
    if not path.is_file():
        raise OSError("no regular file")
    return path.read_bytes()


def _core_again(path: str, only: str) -> bytes | None:
    """The core of a spec, with the claims that the report is about."""
    from haverify.model.core import canonical, to_core
    from haverify.run.examine import read
    from haverify.run.pipeline import with_claims

    try:
        spec, _, found = read(path)
    except UsageError:
        return None
    has_meaning = spec is not None and not any(is_meaningless(d) for d in found)
    if spec is None or not has_meaning:
        return None
    return canonical(to_core(with_claims(spec, only) if only else spec))
