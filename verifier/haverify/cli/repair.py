"""`haverify repair`: the smallest changes that make a spec good, each tried before it is shown; nothing is written."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.render import render_all
from haverify.errors import UsageError
from haverify.report.exit_codes import OK, UNREADABLE, WRONG, worst
from haverify.run.examine import Examined, examine
from haverify.run.pipeline import require_known
from haverify.run.settings import Settings, duration, settings

if TYPE_CHECKING:
    from haverify.repair.subject import Subject


def run(called: argparse.Namespace) -> int:
    """0: nothing to repair; 1: changes are proposed, or something is wrong that none mends; 2: no meaning."""
    here = settings(Path.cwd())
    lock = called.lock or here.lock
    if lock is not None and not Path(lock).is_file():
        raise UsageError(f"{lock}: there is no such lock file")
    codes = []
    for path in called.files:
        try:
            codes.append(_one(path, Path(lock) if lock else None, called, here))
        except UsageError as e:
            print(f"haverify: {e}", file=sys.stderr)
            codes.append(UNREADABLE)
    return worst(codes)


def _one(path: str, lock: Path | None, called: argparse.Namespace, here: Settings) -> int:
    from haverify.repair.repair import repair
    from haverify.repair.shown import as_diff, as_json, as_text

    examined = examine(path, lock)
    if not examined.has_meaning or examined.spec is None:
        meaningless = [d for d in examined.found if is_meaningless(d)]
        print(render_all(meaningless, examined.sources, wants_colour()), file=sys.stderr)
        print(f"haverify: {path}: has errors that leave a part of it without meaning", file=sys.stderr)
        return UNREADABLE
    if called.property is not None:
        require_known(path, called.property, [c.name for c in examined.spec.claims])
    subject, accepted = _subject(examined), _accepted(examined)
    end = time.monotonic() + float(duration(called.budget or here.budget or "60s"))
    spared = () if called.accepted else accepted
    outcome = repair(subject, spared, called.property, lambda: time.monotonic() < end)
    code = WRONG if outcome.proposals or outcome.left else OK
    if called.diff:
        put(as_diff(outcome, subject.text.sources))
    elif called.format == "json":
        put(json.dumps(as_json(path, outcome, subject.text.sources, code), ensure_ascii=False) + "\n")
    else:
        put(as_text(path, outcome, subject.text.sources))
    return code


def _accepted(e: Examined) -> frozenset[str]:
    return frozenset(f"{d.code}: {d.key or d.message}" for d in e.accepted)


def _subject(e: Examined) -> Subject:
    """The spec with its texts, read once more: what `examine` found, and what can be edited."""
    from haverify.repair.subject import Subject, Text
    from haverify.run.load import load

    loaded, found = load(os.path.relpath(e.path))
    if loaded is None:
        raise UsageError(found[0].message)
    data = {s.path: s for s in loaded.files.data.values()}
    text = Text(loaded.tree, loaded.files, {**data, **loaded.sources})
    return Subject(text, e.spec, e.found, {r.claim: r.parts for r in e.record.refuted})
