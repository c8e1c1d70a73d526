"""The summary on the terminal: a line per claim, what needs attention, counts, what the exit code means."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from haverify.report import unrecorded
from haverify.report.exit_codes import MEANING
from haverify.report.numbers import decimal
from haverify.report.report import Claim, Margin, Part, Report, Run

_PARTS = 60  # violated parts of one claim that are printed
_LINES = 100  # claims that have a line of their own; what is not as expected always has

_ROUNDING = {
    "proved": "holds within rounding",
    "refuted": "refuted for every rounding",
    "unknown": "rounding: unknown",
}

_COLOUR = {"proved": "\x1b[32m", "refuted": "\x1b[31m", "unknown": "\x1b[33m"}
_RESET = "\x1b[0m"


def summary(report: Report, colour: bool = False) -> str:
    """What one spec's report says, for people."""
    head = f'{report.spec}: "{report.title}"' if report.title else report.spec
    blocks = [head, *([_table(report.claims, colour)] if report.claims else [])]
    alone = len(report.claims) == 1
    blocks += [text for claim in report.claims if (text := details(claim, alone))]
    blocks += [unrecorded.advice(report)] if any(map(unrecorded.is_so, report.claims)) else []
    return "\n\n".join([*blocks, _counts(report)]) + "\n"


def closing(exit_code: int, folders: Iterable[str], faulty: Iterable[str] = ()) -> str:
    """The last lines: where the reports are, what the exit code means, and for which claims haverify failed."""
    lines = [f"report: {folder}" for folder in folders]
    names = ", ".join(faulty)
    about = f" (about {names})" if names else ""
    return "\n".join([*lines, f"exit code {exit_code}: {MEANING[exit_code]}{about}"]) + "\n"


def _table(claims: list[Claim], colour: bool) -> str:
    shown = claims if len(claims) <= _LINES else [c for c in claims if not c.ok][:_LINES]
    width = max((len(c.name) for c in shown), default=0)
    rows = [_row(c, min(width, 40), colour) for c in shown]
    if len(shown) < len(claims):
        rows.append(f"  ... and {len(claims) - len(shown)} more claims in the report")
    return "\n".join(rows)


def _row(c: Claim, width: int, colour: bool) -> str:
    word = f"{c.verdict:<7}"
    if colour:
        word = f"{_COLOUR[c.verdict]}{word}{_RESET}"
    mark = "ok" if c.ok else "!!"
    remark = ""
    if not c.ok:
        remark = f"expected {c.expected}" if c.verdict != c.expected else c.problems[0] if c.problems else "see below"
    elif c.verdict != "proved":
        remark = "as expected"
    rounding = _ROUNDING[c.rounding.verdict] if c.rounding else ""
    tail = [text for text in (remark, _margin(c.margin), rounding) if text]
    return f"  {mark} {word}  {c.name:<{width}}  {'; '.join(tail)}".rstrip()


def with_unit(m: Margin) -> str:
    """A margin as a decimal with its unit, which a plain number has not."""
    return m.decimal if m.unit in ("", "1") else f"{m.decimal} {m.unit}"


def _margin(m: Margin | None) -> str:
    if m is None:
        return ""
    at = f" at {m.at}" if m.at else ""
    return f"margin {with_unit(m)}{at}"


def details(c: Claim, is_alone: bool = False) -> str:
    """What there is to say beyond the line in the table; of a claim that is proved as expected only if it is alone."""
    if c.ok and c.verdict == "proved":
        notes = _notes(c) if is_alone else []
        return "\n".join([f"{c.name}:", *notes]) if notes else ""
    if c.ok:
        return _as_expected(c)
    bad = [p for p in c.parts if p.verdict == "refuted"]
    place = f" ({c.path}:{c.line})" if c.path else ""
    lines = [f"{c.name}{place}: {c.verdict}, expected {c.expected}"]
    if c.text:
        lines += [f"    {line.strip()}" for line in c.text.strip().splitlines()]
    lines += [f"  problem: {p}" for p in c.problems]
    lines += _why_unknown(c) if c.verdict == "unknown" else []
    for part in bad[:_PARTS]:
        lines += _part(part)
    lines += _more(bad)
    lines += _run(c.run) if c.run and c.verdict == "refuted" else []
    lines += _witness(c)
    return "\n".join(lines + _notes(c))


def _as_expected(c: Claim) -> str:
    """A claim that is refuted or unknown as expected: why it is, and where."""
    place = f" ({c.path}:{c.line})" if c.path else ""
    because = f' because "{c.because}"' if c.because else ""
    bad = [p for p in c.parts if p.verdict == "refuted"]
    lines = [f"{c.name}{place}: {c.verdict} as expected{because}"]
    lines += _why_unknown(c) if c.verdict == "unknown" else []
    for part in bad[:_PARTS]:
        lines += _short_part(part)
    lines += _witness(c)
    return "\n".join(lines + _more(bad) + _notes(c))


def _more(bad: list[Part]) -> list[str]:
    left = len(bad) - _PARTS
    return [f"  ... and {left} more violated parts in the report"] if left > 0 else []


def _notes(c: Claim) -> list[str]:
    """The notes, without those that `summary` sums up."""
    return [f"  note: {n}" for n in c.notes if not unrecorded.is_note(n)]


def _short_part(p: Part) -> list[str]:
    """A violated part in a line or two: the extreme with its instant, then the table rows."""
    where = f"{p.mode}, {p.output}" if p.output else p.mode
    fact = "; ".join(p.facts) or _margin(p.margin) or f"violated: {p.text}"
    lines = [f"  {where}: {fact}" if where else f"  {fact}"]
    return lines + ([f"      reads {', '.join(p.cells)}"] if p.cells else [])


def _why_unknown(c: Claim) -> list[str]:
    facts = (("why", c.reason), ("reached", c.reached), ("nearest", c.nearest), ("try", c.next_step))
    return [f"  {name}: {text}" for name, text in facts if text]


def _part(p: Part) -> list[str]:
    where = f"{p.mode}, {p.output}" if p.output else p.mode
    place = f" in {where}" if where else ""
    lines = [f"  violated{place}: {p.text}" if p.text else f"  violated{place}"]
    lines += [f"      {fact}" for fact in p.facts]
    if not p.facts and p.margin:
        lines.append(f"      {_margin(p.margin)}")
    if p.cells:
        lines.append(f"      reads {', '.join(p.cells)}")
    return lines


def _run(run: Run) -> list[str]:
    """The run in one line per mode."""
    params = ", ".join(_quantity(run, name, decimal(Fraction(q))) for name, q in run.params.items())
    lines = [f"  a run that violates it, for {params}:" if params else "  a run that violates it:"]
    for mode, time, state in zip(run.mode_path, run.times_decimal, run.states_decimal, strict=False):
        values = ", ".join(_quantity(run, name, value) for name, value in state.items())
        lines.append(f"    t = {time} s: {mode}" + (f" with {values}" if values else ""))
    if run.times_decimal and len(run.times_decimal) > len(run.mode_path):
        lines.append(f"    violated at t = {run.times_decimal[-1]} s")
    return lines


def _witness(c: Claim) -> list[str]:
    values = ", ".join(f"{name} = {value}" for name, value in (c.witness or {}).items())
    return [f"  for {values}"] if values else []


def _quantity(run: Run, name: str, value: str) -> str:
    unit = run.units.get(name)
    return f"{name} = {value} {unit}" if unit else f"{name} = {value}"


def _counts(report: Report) -> str:
    s = report.summary
    counts = [f"{n} {word}" for n, word in ((s.proved, "proved"), (s.refuted, "refuted"), (s.unknown, "unknown")) if n]
    total = len(report.claims)
    lines = (
        [f"{', '.join(counts) or 'no claims'}; {s.ok} of {total} as expected"] if total else ["no claim was decided"]
    )
    findings = [f"{n} {word}{'s' * (n > 1)}" for n, word in ((s.errors, "error"), (s.warnings, "warning")) if n]
    accepted = f"{s.accepted} accepted with a reason" if s.accepted else ""
    if findings or accepted:
        lines.append("findings: " + ", ".join([*findings, *([accepted] if accepted else [])]))
    checked = sum(c.trust == "checked" for c in report.claims)
    if checked:
        lines.append(f"{checked} of {s.proved + s.refuted} verdicts re-checked by the independent checker, hacheck")
    return "\n".join(lines if report.complete else [*lines, "INCOMPLETE: the run was interrupted"])
