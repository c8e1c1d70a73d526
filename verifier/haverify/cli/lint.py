"""`haverify lint`: findings only, and fixes for those that have one."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from haverify.cli.output import codes, put, wants_colour
from haverify.diagnostics.render import render_all
from haverify.errors import UsageError
from haverify.report.exit_codes import UNREADABLE, finding_code, worst
from haverify.run.examine import Examined, examine
from haverify.run.fix import apply
from haverify.run.settings import settings


def run(called: argparse.Namespace) -> int:
    """Lint each file; exit code 0, 1, 2."""
    here = settings(Path.cwd())
    lock = called.lock or here.lock
    if lock is not None and not Path(lock).is_file():
        raise UsageError(f"{lock}: there is no such lock file")
    use_cache = not called.no_cache and here.cache is not False
    results, exits, unread = list[Examined](), list[int](), list[tuple[str, str]]()
    for path in called.files:
        try:
            results.append(_examine(path, lock, called, use_cache))
        except UsageError as e:
            print(f"haverify: {e}", file=sys.stderr)
            exits.append(UNREADABLE)
            unread.append((path, str(e)))
    exits += [finding_code(e.found, e.accepted) for e in results]
    code = worst(exits)
    _show(results, called.format or here.format or "text", code, unread)
    return code


def _examine(path: str, lock: str | None, called: argparse.Namespace, use_cache: bool) -> Examined:
    """The findings of a spec, after the fixes that were asked for."""
    place = Path(lock) if lock else None
    examined = examine(path, place, codes(called.select), use_cache)
    if called.fix or called.unsafe_fixes:
        fixed = apply(examined.new, examined.sources, called.unsafe_fixes)
        for text in fixed:
            print(f"fixed: {text}", file=sys.stderr)
        if fixed:
            examined = examine(path, place, codes(called.select), use_cache)
    return examined


def _show(results: list[Examined], form: str, code: int, unread: list[tuple[str, str]]) -> None:
    """Print the findings as they are asked for; `unread` are files that could not be read, and why."""
    if form == "text":
        for e in results:
            put(_text(e))
        return
    from haverify.run.told import told

    found = [(e.path, told(e)) for e in results]
    every = [f for _, of_spec in found for f in of_spec]
    if form == "github":
        from haverify.report.as_github import findings_as_github

        put(findings_as_github(every))
    elif form == "sarif":
        from haverify.report.as_sarif import findings_as_sarif

        put(findings_as_sarif(every, code, unread))
    elif form == "junit":
        from haverify.report.as_junit import findings_as_junit

        put(findings_as_junit(found, unread))
    else:
        from haverify.report.as_json import findings_as_json

        put(findings_as_json(every))


def _text(e: Examined) -> str:
    shown = render_all(e.new, e.sources, wants_colour())
    parts = [f"{len(e.new)} finding{'s' if len(e.new) != 1 else ''}" if e.new else "no findings"]
    parts += [f"{len(e.accepted)} accepted with a reason"] if e.accepted else []
    fixable = sum(d.fix is not None and d.fix.safe for d in e.new)
    parts += [f"{fixable} can be fixed by --fix"] if fixable else []
    return (shown + "\n" if shown else "") + f"{e.path}: {', '.join(parts)}\n"
