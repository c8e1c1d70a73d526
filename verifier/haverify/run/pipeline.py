"""The arrows joined: from the path of a spec to a report, in the folder where it belongs."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from haverify.diagnostics.codes import severity
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.diagnostics.order import settle
from haverify.errors import UsageError
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Trust, Unknown
from haverify.model.claim import Claim
from haverify.model.spec import Spec
from haverify.report import exit_codes, gate, report, unrecorded
from haverify.report.as_json import as_json
from haverify.report.as_junit import as_junit
from haverify.report.as_markdown import as_markdown
from haverify.report.as_sarif import as_sarif
from haverify.report.assemble import Assembler
from haverify.report.baseline import RefutedEntry
from haverify.report.findings import finding
from haverify.report.version import VERSION
from haverify.run.decide import Decided, Plan, decide
from haverify.run.examine import Examined, examine
from haverify.run.folder import ReportFolder, certificate_file, flowpipe_file, obligation_file
from haverify.run.keys import reproducibility
from haverify.run.lockfile import refuted_text
from haverify.run.page import page
from haverify.run.told import told
from haverify.text.record import record, replace


@record
class Options:
    """What a call of `check` asks for; `report` None: the report is not kept."""

    only: str | None
    budget: Fraction
    jobs: int
    report: Path | None
    use_cache: bool
    lock: Path | None
    grade: Trust
    crosscheck: bool = True


@record
class Outcome:
    """A checked spec: what was read, the evidence and the report on it, the problems it adds, faults of ours.

    `known` are the names of all claims of the spec, selected or not.
    """

    examined: Examined
    evidence: dict[str, Evidence]
    report: report.Report
    problems: list[Diagnostic]
    folder: Path | None
    faults: list[str]
    known: list[str]


def check(path: str, options: Options) -> Outcome:
    """Check one spec and write its report.

    Raises
    ------
    UsageError      if the spec, the lock file or the report folder cannot be used
    """
    started = _clock()
    whole = examine(path, options.lock, use_cache=options.use_cache)
    known = [c.name for c in whole.spec.claims] if whole.spec else []
    examined = restricted(whole, options.only)
    claims = list(examined.spec.claims) if examined.spec else []
    folder = ReportFolder(options.report or Path(_scratch()))
    try:
        return replace(_checked(examined, claims, folder, options, started), known=known)
    finally:
        folder.drop()


def _scratch() -> str:
    from tempfile import gettempdir

    return os.path.join(gettempdir(), f"haverify-{os.getpid()}-{time.monotonic_ns()}")


def restricted(e: Examined, only: str | None) -> Examined:
    """The same with the claims of one name (or family) alone, and the invariants these use."""
    return e if e.spec is None or only is None else replace(e, spec=with_claims(e.spec, only))


def with_claims(spec: Spec, only: str) -> Spec:
    """The spec with the claims of one name (or family), and the invariants these use."""
    wanted = [c.name for c in spec.claims if only in (c.name, c.name.split("[")[0])]
    using = {c.name: c.using for c in spec.claims}
    for name in wanted:
        wanted += [u for u in using.get(name, ()) if u not in wanted]
    return replace(spec, claims=tuple(c for c in spec.claims if c.name in wanted))


def _checked(e: Examined, claims: list[Claim], folder: ReportFolder, options: Options, started: _Clock) -> Outcome:
    value, core = _core(e)
    if core:
        folder.add("core.json", core)
    decided = _decided(e, claims, value, folder, options)
    judged = {c.name: gate.judge(c, decided.evidence[c.name], e.record.parts(c.name)) for c in claims}
    judged = {c.name: _with_entry(e, c, decided.evidence[c.name], judged[c.name]) for c in claims}
    problems = settle(d for j in judged.values() for d in j.problems)
    assembler = Assembler(e.spec, e.sources) if e.spec else None
    entries = [_claim(assembler, c, decided, judged[c.name]) for c in claims] if assembler else []
    result = _report(e, entries, problems, decided, judged, core, options, started)
    _write(folder, result, claims, decided, options.use_cache)
    if options.report is not None:
        folder.finish()
    return Outcome(e, decided.evidence, result, problems, options.report, decided.faults, [])


def _core(e: Examined) -> tuple[Mapping[str, Any], str]:
    """The core and its canonical text, where the claims have a meaning; else both empty."""
    if e.spec is None or not e.can_decide:
        return {}, ""
    from haverify.model.core import canonical, to_core

    core = to_core(e.spec)
    return core, canonical(core).decode()


def _decided(
    e: Examined, claims: list[Claim], core: Mapping[str, Any], folder: ReportFolder, options: Options
) -> Decided:
    if e.spec is None or not core:
        reason = "the spec has errors that leave a part of it without meaning"
        return Decided(
            {c.name: Evidence(Unknown("meaning", reason, next_step="repair these errors"), (), "") for c in claims}
        )
    plan = Plan(options.budget, options.jobs, options.use_cache, options.grade, Path(e.path).parent, options.crosscheck)
    return decide(e.spec, [c.name for c in claims], core, folder, plan)


def _with_entry(e: Examined, claim: Claim, evidence: Evidence, j: gate.Judgement) -> gate.Judgement:
    """The judgement with a note that shows the entry to add, where a known violation has none."""
    parts = gate.violated(claim, evidence)
    is_open = gate.expected(claim) == "refuted" and gate.word(evidence.verdict) == "refuted"
    if not is_open or not parts or e.record.parts(claim.name) is not None:
        return j
    because = claim.expect.because if claim.expect and claim.expect.because else "why this is known"
    entry = refuted_text(RefutedEntry(e.name or Path(e.path).name, claim.name, parts, because))
    return replace(j, notes=(*j.notes, unrecorded.note(entry)))


def _claim(assembler: Assembler, claim: Claim, decided: Decided, judgement: gate.Judgement) -> report.Claim:
    evidence = decided.evidence[claim.name]
    wall, cpu = decided.seconds.get(claim.name, (0.0, 0.0))
    is_decided = evidence.certificate is not None and not isinstance(evidence.verdict, Unknown)
    certificate = certificate_file(claim.name) if is_decided else None
    return assembler.claim(claim, evidence, judgement, certificate, (round(wall, 6), round(cpu, 6)))


def _report(
    e: Examined,
    entries: list[report.Claim],
    problems: Sequence[Diagnostic],
    decided: Decided,
    judged: dict[str, gate.Judgement],
    core: str,
    options: Options,
    started: _Clock,
) -> report.Report:
    findings = told(e) + [finding(d, e.sources) for d in problems]
    code = exit_code(e, [j.exit_code for j in judged.values()], decided)
    sources = sorted(e.sources.values(), key=lambda s: s.path)
    inputs = [report.InputFile(os.path.normpath(s.path), s.sha256) for s in sources]  # `a/../b` is the checker's `b`
    inputs = [i for i in inputs if not i.path.endswith("haverify.lock")]
    said = {"budget": f"{options.budget} s", "grade": options.grade.name.lower(), "property": options.only or ""}
    if not options.crosscheck:
        said["crosscheck"] = "off"
    versions = {"kernel": _kernel()}
    wall, cpu = started.passed()
    return report.Report(
        schema="haverify.report/1",
        spec=os.path.relpath(e.path),
        title=e.spec.name if e.spec else "",
        tool=report.Tool("haverify", VERSION, versions["kernel"], {}),
        inputs=inputs,
        options=said,
        hash=reproducibility(core, [i.sha256 for i in inputs], said, versions),
        complete=not decided.is_interrupted,
        wall_s=wall,
        cpu_s=cpu,
        findings=findings,
        claims=entries,
        summary=_summary(entries, [*e.new, *problems], len(e.accepted), code),
    )


def exit_code(e: Examined, judged: Sequence[int], decided: Decided) -> int:
    """The exit code of one spec; 5 where no claim was looked at."""
    codes = [*judged] or [exit_codes.NOTHING]
    codes.append(exit_codes.finding_code(e.found, e.accepted))
    codes += [exit_codes.FAULT] if decided.faults else []
    codes += [exit_codes.INTERRUPTED] if decided.is_interrupted else []
    return exit_codes.worst(codes)


def _summary(entries: Sequence[report.Claim], new: Sequence[Diagnostic], accepted: int, code: int) -> report.Summary:
    words = [c.verdict for c in entries]
    return report.Summary(
        proved=words.count("proved"),
        refuted=words.count("refuted"),
        unknown=words.count("unknown"),
        ok=sum(c.ok for c in entries),
        errors=sum(severity(d) is Severity.ERROR for d in new),
        warnings=sum(severity(d) is Severity.WARNING for d in new),
        accepted=accepted,
        exit_code=code,
    )


def _kernel() -> str:
    """The hash of the kernel's source, where the source is beside it."""
    from haverify.maths.freshness import CRATE, source_hash

    return source_hash(CRATE) or VERSION


def _write(folder: ReportFolder, r: report.Report, claims: Sequence[Claim], decided: Decided, use_cache: bool) -> None:
    for claim in claims:
        folder.add(obligation_file(claim.name), _obligations(claim, decided.evidence[claim.name]))
        if (shown := decided.evidence[claim.name].flowpipe) is not None:
            folder.add(flowpipe_file(claim.name), json.dumps({"claim": claim.name, **shown}, separators=(",", ":")))
    text = as_json(r)
    folder.add("report.json", text)
    folder.add("summary.md", as_markdown(r))
    folder.add("report.sarif", as_sarif([r]))
    folder.add("junit.xml", as_junit([r]))
    folder.add("index.html", page(r, folder.path, text, use_cache))


def _obligations(claim: Claim, evidence: Evidence) -> str:
    """The questions that a claim comes down to, to read."""
    lines = [f"{claim.kind} {claim.name} on {claim.on or '-'}", *claim.text.strip().splitlines(), ""]
    for number, p in enumerate(evidence.parts, 1):
        lines.append(f"{number}. goal {p.goal + 1}, {p.kind}: {p.where or '-'}, {p.output or '-'}")
        lines += [f"   {p.text}"] if p.text else []
    return "\n".join(lines) + "\n"


@record
class _Clock:
    """Wall time and CPU time, children included, at the start."""

    wall: float
    cpu: float

    def passed(self) -> tuple[float, float]:
        now = _clock()
        return round(now.wall - self.wall, 3), round(now.cpu - self.cpu, 3)


def _clock() -> _Clock:
    t = os.times()
    return _Clock(time.perf_counter(), t.user + t.system + t.children_user + t.children_system)


def require_known(path: str, only: str, names: Sequence[Any]) -> None:
    """Raise UsageError if no claim has that name, with the nearest one that there is."""
    if only in names or only in {str(n).split("[")[0] for n in names}:
        return
    from difflib import get_close_matches

    near = get_close_matches(only, [str(n) for n in names], 1)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    raise UsageError(f"no claim '{only}' in {path}{hint}")
