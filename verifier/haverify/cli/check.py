"""`haverify check`: decide every claim of some specs, write their reports, say what came out."""

from __future__ import annotations

import argparse
import sys
from fractions import Fraction
from pathlib import Path

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import severity
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.diagnostics.render import render_all
from haverify.errors import UsageError
from haverify.evidence.verdict import Trust
from haverify.report.as_github import as_github
from haverify.report.as_json import as_line
from haverify.report.as_junit import as_junit
from haverify.report.as_sarif import as_sarif
from haverify.report.exit_codes import FAULT, UNREADABLE, worst
from haverify.report.report import Report
from haverify.report.terminal import closing, summary
from haverify.run.pipeline import Options, Outcome, check, require_known
from haverify.run.settings import Settings, duration, settings


def run(called: argparse.Namespace) -> int:
    """Check each file; those that can be read go on when one cannot."""
    here = settings(Path.cwd())
    form = called.format or here.format or "text"
    options = {path: _options(called, here, path) for path in called.files}
    _require_own_folders(called, here)
    codes, folders, known, faulty = [], [], list[str](), list[str]()
    reports, unread = list[Report](), list[tuple[str, str]]()
    for path in called.files:
        try:
            outcome = check(path, options[path])
        except UsageError as e:
            print(f"haverify: {e}", file=sys.stderr)
            codes.append(UNREADABLE)
            unread.append((path, str(e)))
            continue
        reports.append(outcome.report)
        known += outcome.known
        codes.append(outcome.report.summary.exit_code)
        folders += [f"{outcome.folder}/report.json"] if outcome.folder else []
        faulty += [fault.partition(": ")[0] for fault in outcome.faults]
        _show(outcome, form)
        if not outcome.report.complete:
            break
    if called.property is not None and FAULT not in codes and UNREADABLE not in codes:
        require_known(", ".join(called.files), called.property, known)
    code = worst(codes)
    if form == "text":
        put(closing(code, folders, dict.fromkeys(faulty)))
    elif form in _DOCUMENTS:
        put(_DOCUMENTS[form](reports, unread))
    return code


_DOCUMENTS = {"sarif": as_sarif, "junit": as_junit}  # one for all specs


def _show(outcome: Outcome, form: str) -> None:
    """Print one spec's outcome as it is asked for; faults of ours always go to standard error."""
    if form == "json":
        put(as_line(outcome.report))
    elif form == "github":
        put(as_github(outcome.report))
    elif form == "text":
        put(_findings(outcome))
        put(summary(outcome.report, wants_colour()) + "\n")
    for fault in outcome.faults:
        print(f"haverify: SoundnessError: {fault}", file=sys.stderr)
    if outcome.faults:
        print("haverify: this is a fault of haverify, not of the spec; please report it", file=sys.stderr)


def _findings(outcome: Outcome) -> str:
    shown = _worth_showing(outcome)
    return render_all(shown, outcome.examined.sources, wants_colour()) + "\n" if shown else ""


def _worth_showing(outcome: Outcome) -> list[Diagnostic]:
    """The new errors and warnings; what is only information is for `lint`."""
    return [d for d in outcome.examined.new if severity(d) in (Severity.ERROR, Severity.WARNING)]


def _options(called: argparse.Namespace, here: Settings, path: str) -> Options:
    jobs = called.jobs if called.jobs is not None else here.jobs if here.jobs is not None else 1
    if jobs < 1:
        raise UsageError(f"--jobs {jobs}: at least one process is needed")
    lock = called.lock or here.lock
    if lock is not None and not Path(lock).is_file():
        raise UsageError(f"{lock}: there is no such lock file")
    return Options(
        only=called.property,
        budget=_budget(called, here),
        jobs=jobs,
        report=_folder(called, here, path),
        use_cache=not called.no_cache and here.cache is not False,
        lock=Path(lock) if lock else None,
        grade=Trust[(called.grade or here.grade or "enclosed").upper()],
        crosscheck=not called.no_crosscheck,
    )


def _budget(called: argparse.Namespace, here: Settings) -> Fraction:
    return duration(called.budget or here.budget or "60s")


def _folder(called: argparse.Namespace, here: Settings, path: str) -> Path | None:
    """`reports/<stem>`; with `--report DIR`, DIR for one file and `DIR/<stem>` for several."""
    if called.no_report:
        return None
    if called.report is not None and len(called.files) == 1:
        return Path(called.report)
    return Path(called.report or here.report or "reports") / Path(path).stem


def _require_own_folders(called: argparse.Namespace, here: Settings) -> None:
    """Two specs of one stem would share a folder."""
    seen: dict[Path, str] = {}
    for path in called.files:
        folder = _folder(called, here, path)
        if folder is None:
            continue
        if folder in seen:
            raise UsageError(
                f"{seen[folder]} and {path} both report to {folder}: check them in two calls with --report DIR"
            )
        seen[folder] = path
