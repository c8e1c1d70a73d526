"""`haverify fmt`: the one layout; a file with syntax errors is left as it is."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.render import render_all
from haverify.report.exit_codes import OK, UNREADABLE, WRONG, worst


def run(called: argparse.Namespace) -> int:
    """Format each file; exit code 0, 1 (with --check or --diff, something would change), 2 (cannot be read)."""
    return worst([_one(path, called.check or called.diff, called.diff) for path in called.files])


def _one(path: str, is_dry: bool, shows: bool) -> int:
    from haverify.run.load import read_text
    from haverify.syntax.format import format as laid_out
    from haverify.syntax.parse import parse

    problem, source = read_text(path)
    if source is None:
        print(f"haverify: cannot read {path}: {problem}", file=sys.stderr)
        return UNREADABLE
    tree, found = parse(source)
    if found:
        put(render_all(found, {source.path: source}, wants_colour()))
        return UNREADABLE
    text = laid_out(tree, source)
    if text == source.text:
        return OK
    if shows:
        put(_difference(path, source.text, text))
    if is_dry:
        print(f"{path}: would be laid out anew", file=sys.stderr)
        return WRONG
    file = Path(path)
    beside = file.with_name(f".{file.name}.fmt")
    beside.write_text(text, encoding="utf-8")
    beside.chmod(file.stat().st_mode)
    beside.replace(file)
    print(f"{path}: laid out anew", file=sys.stderr)
    return OK


def _difference(path: str, old: str, new: str) -> str:
    from difflib import unified_diff

    lines = unified_diff(old.splitlines(keepends=True), new.splitlines(keepends=True), path, f"{path} (formatted)")
    return "".join(lines)
