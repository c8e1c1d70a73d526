"""`python -m tests.bench.records [SPEC...]`: grade, size of the evidence and time of its re-check, claim by claim.

Without names, the reachability problems of tests/peers/nln and all specs of spec/. The re-check is `python -S -m
hacheck` on a folder that has the evidence of one claim, and of the invariants it uses; user CPU, its start included.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
LIMIT_S = 600  # of one process

Json = Any


def checked(spec: Path, folder: Path) -> Json:
    """The report of a spec, decided anew into a folder."""
    command = [sys.executable, "-m", "haverify", "check", str(spec), "--no-cache", "--no-crosscheck"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "verifier")}
    subprocess.run([*command, "--report", str(folder)], env=environment, capture_output=True, timeout=LIMIT_S)
    return json.loads((folder / "report.json").read_text(encoding="utf-8"))


def evidence(folder: Path, claim: str) -> list[Path]:
    """The files of a claim's evidence: its certificate, and the files that this names."""
    certificate = folder / "certificates" / f"{claim.replace('[', '(').replace(']', ')')}.json"
    if not certificate.exists():
        return []
    text = certificate.read_text(encoding="utf-8")
    named = [f for f in sorted((folder / "certificates" / "cells").glob("*.json")) if f'"{f.stem}"' in text]
    return [certificate, *named]


def recheck(folder: Path, files: list[Path]) -> float:
    """User CPU seconds that the second checker takes for some evidence."""
    with tempfile.TemporaryDirectory() as made:
        (Path(made) / "certificates" / "cells").mkdir(parents=True)
        for f in [folder / "core.json", *files]:
            shutil.copy(f, Path(made) / f.relative_to(folder))
        shutil.copytree(ROOT / "verifier" / "hacheck", Path(made) / "hacheck")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        command = [sys.executable, "-S", "-m", "hacheck", made, "--no-report"]
        subprocess.run(command, cwd=made, env={}, capture_output=True, timeout=LIMIT_S)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def rows(spec: Path, folder: Path) -> Iterator[tuple[str, str, str, int, float | None]]:
    """For each claim its name, verdict, grade, bytes of evidence, and seconds of its re-check."""
    report = checked(spec, folder)
    uses = {c["name"]: c["using"] for c in json.loads((folder / "core.json").read_text(encoding="utf-8"))["claims"]}
    for claim in report["claims"]:
        own = evidence(folder, claim["name"])
        needed = [*own, *(f for name in uses[claim["name"]] for f in evidence(folder, name))]
        seconds = recheck(folder, needed) if claim["trust"] == "checked" else None
        yield claim["name"], claim["verdict"], claim["trust"] or "-", sum(f.stat().st_size for f in own), seconds


def main() -> None:
    """Print the table."""
    given = [Path(a) for a in sys.argv[1:]]
    specs = given or [*sorted((ROOT / "tests/peers/nln").glob("*.ha")), *sorted((ROOT / "spec").glob("*.ha"))]
    print(f"{'spec':<24} {'claim':<28} {'verdict':<8} {'grade':<9} {'bytes':>9} {'re-check s':>10}")
    for spec in specs:
        with tempfile.TemporaryDirectory() as folder:
            for name, verdict, grade, size, seconds in rows(spec, Path(folder)):
                time = "-" if seconds is None else f"{seconds:.2f}"
                print(f"{spec.stem:<24} {name:<28} {verdict:<8} {grade:<9} {size:>9} {time:>10}", flush=True)


if __name__ == "__main__":
    main()
