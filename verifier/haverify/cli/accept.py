"""`haverify accept`: today's findings and known violations, written to `haverify.lock` with a reason."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

from haverify.cli.output import codes
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.errors import UsageError
from haverify.evidence.verdict import Trust
from haverify.report.allow import can_be_accepted
from haverify.report.baseline import Baseline, FindingEntry, RefutedEntry, identity
from haverify.run import lockfile
from haverify.run.examine import Examined, examine
from haverify.run.pipeline import Options, check
from haverify.run.settings import duration, settings
from haverify.text.record import replace


def run(called: argparse.Namespace) -> int:
    """Write the entries; exit code 2 where the spec has no meaning, since that cannot be accepted."""
    reason = " ".join(called.reason.split())
    if not reason:
        raise UsageError("--reason is empty: say why these findings are accepted")
    here, select = settings(Path.cwd()), codes(called.select)
    spec = Path(called.file)
    lock = Path(called.lock or here.lock or lockfile.nearest(spec) or spec.parent / lockfile.NAME)
    known = lockfile.read(lock)[0] if lock.is_file() else Baseline()
    examined = examine(called.file, lock if lock.is_file() else None, select)
    if not examined.has_meaning:
        raise UsageError(f"{called.file}: has errors that leave a part of it without meaning; see `haverify lint`")
    name = lockfile.name_in(lock, spec)
    mine, others = known.of(name), [e for e in known.findings if e.spec != name]
    findings = _findings(examined, mine.findings, name, reason, select)
    refuted = (
        mine.refuted if select else _refuted(called.file, lock, mine, name, reason, duration(here.budget or "60s"))
    )
    lockfile.write(lock, Baseline((*others, *findings), (*(e for e in known.refuted if e.spec != name), *refuted)))
    print(f"{lock}: {len(findings)} findings and {len(refuted)} refuted claims of {called.file}", file=sys.stderr)
    return 0


def _findings(
    e: Examined, mine: Iterable[FindingEntry], name: str, reason: str, select: tuple[str, ...]
) -> list[FindingEntry]:
    """An entry for each finding of today; those on record keep their reason and their last day."""
    left: dict[tuple[str, str, str], list[FindingEntry]] = {}
    for entry in mine:
        left.setdefault(entry.identity(), []).append(entry)
    today = []
    for d in e.found:
        if can_be_accepted(d) and d not in _allowed(e):
            old = left.get(identity(d, e.sources))
            code, key, text = identity(d, e.sources)
            today.append(old.pop(0) if old else FindingEntry(name, code, key, text, reason))
    unselected = [entry for entry in mine if select and not entry.code.startswith(select)]
    return today + unselected


def _allowed(e: Examined) -> set[Diagnostic]:
    """The findings that an `@allow` in the spec accepts already."""
    from haverify.report.allow import allow

    return set(allow(e.found, e.spec.allowed if e.spec else ()))


def _refuted(path: str, lock: Path, mine: Baseline, name: str, reason: str, budget: Fraction) -> list[RefutedEntry]:
    """An entry for each claim that is refuted as expected, with the parts violated today."""
    from haverify.report.gate import expected, violated

    options = Options(None, budget, 1, None, True, lock if lock.is_file() else None, Trust.ENCLOSED)
    outcome = check(path, options)
    claims = outcome.examined.spec.claims if outcome.examined.spec else ()
    entries = []
    for claim in claims:
        parts = violated(claim, outcome.evidence[claim.name])
        if expected(claim) == "refuted" and parts:
            old = next((e for e in mine.refuted if e.claim == claim.name), None)
            entry = RefutedEntry(name, claim.name, parts, reason)
            entries.append(replace(entry, reason=old.reason) if old and old.parts == parts else entry)
    return entries
