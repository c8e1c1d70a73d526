"""`haverify plot`: the figures of a report as files, drawn from the report folder without running anything again."""

from __future__ import annotations

import argparse
from pathlib import Path

from haverify.cli.output import put
from haverify.errors import UsageError
from haverify.report.exit_codes import NOTHING, OK
from haverify.report.figures.material import Figure
from haverify.report.figures.plots import every
from haverify.report.html.style import standalone
from haverify.run.material import material
from haverify.run.report_file import read_report

_PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")


def run(called: argparse.Namespace) -> int:
    """Write an SVG file for each figure; exit code 5 where nothing can be drawn."""
    path = Path(called.report)
    report = read_report(path)
    folder = path if path.is_dir() else path.parent
    if not (folder / "core.json").is_file():
        raise UsageError(f"{folder}: no core.json beside the report; figures are drawn from it")
    figures = [f for f in every(report, material(folder)) if called.property in (None, f.claim)]
    target = Path(called.output) if called.output else folder / "figures"
    for name, f in _files(figures).items():
        _write(target / name, standalone(f.svg))
        put(f"{target / name}: {f.title}\n")
    if not figures:
        put("nothing here can be drawn\n")
    return OK if figures else NOTHING


def _files(figures: list[Figure]) -> dict[str, Figure]:
    """File names without what a file system or a shell takes amiss, each once."""
    named: dict[str, Figure] = {}
    for f in figures:
        stem = "".join(c if c in _PLAIN else "_" for c in f.name)[:80]
        name, k = f"{stem}.svg", 2
        while name in named:
            name, k = f"{stem}_{k}.svg", k + 1
        named[name] = f
    return named


def _write(file: Path, text: str) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"{file}: cannot be written: {e.strerror}") from e
