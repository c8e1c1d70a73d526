"""`replay`: a gait on a robot, its joints' limits as claims, everything else by enclosures and samples."""

from __future__ import annotations

import os
import time
from fractions import Fraction
from pathlib import Path

from haverify.diagnostics.codes import is_error, is_meaningless
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.errors import UsageError
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.report import exit_codes
from haverify.report import replay as facts
from haverify.report.as_json import facts_as_json
from haverify.report.report import Word
from haverify.robot import checks, mechanics
from haverify.robot.body import Description
from haverify.robot.claims import Pace, claims_text
from haverify.robot.cycle import Cycle, cycle_of
from haverify.robot.enclosures import enclosed_finely
from haverify.robot.folder import describe
from haverify.robot.mapping import Map, check_against, read_map
from haverify.robot.pace import greatest_pace
from haverify.robot.trajectory import sampled
from haverify.robot.verdicts import Decided, decided
from haverify.run.examine import read
from haverify.run.load import read_text
from haverify.run.pipeline import Options, Outcome, check
from haverify.text.record import record, replace
from haverify.text.source import Source

Q = Fraction


@record
class Replayed:
    """What came of a call: findings and their texts, the report on the claims, the facts; None where it stopped."""

    found: list[Diagnostic]
    sources: dict[str, Source]
    outcome: Outcome | None
    facts: facts.Replay | None
    seconds: float  # of processor time for samples and their checks, engines loaded


@record
class _Scene:
    """All that was read."""

    path: str
    robot: Description
    map: Map
    spec: Spec
    automaton: HybridAutomaton
    cycle: Cycle


def replay(path: str, folder: str, map_path: str | None, speed: Fraction | None, options: Options) -> Replayed:
    """Replay the automaton of a spec.

    Raises
    ------
    UsageError      if a file cannot be read, Pinocchio is missing, or the automaton has no cycle that can be followed
    """
    robot, sources, found = describe(folder, read_text)
    if robot is None:
        return Replayed(found, sources, None, None, 0.0)
    m, found = _map(map_path or robot.map, robot, sources)
    spec, texts, more = read(path)
    sources |= texts
    found += [d for d in more if is_error(d) and is_meaningless(d)]
    if m is None or spec is None or found:
        return Replayed(found, sources, None, None, 0.0)
    m = m if speed is None else replace(m, speed=speed)
    automaton = next((a for a in spec.automata if a.name == m.automaton), None)
    if automaton is None:
        raise UsageError(f"{path} has no automaton {m.automaton}, which {m.source.path} is made for")
    if found := check_against(m, _outputs(automaton), [mode.name for mode in automaton.modes]):
        return Replayed(found, sources, None, None, 0.0)
    try:
        cycle = cycle_of(spec, automaton, sorted({name for d in m.drives for name in d.outputs}))
    except OutsideFragmentError as e:
        raise UsageError(f"{path}: {m.automaton} cannot be replayed: {e}") from e
    return replace(_replayed(_Scene(path, robot, m, spec, automaton, cycle), options), sources=sources)


def _map(path: str | None, robot: Description, sources: dict[str, Source]) -> tuple[Map | None, list[Diagnostic]]:
    if path is None:
        raise UsageError("no map is named: `--map FILE.toml` says which output drives which joint")
    problem, source = read_text(path)
    if source is None:
        raise UsageError(f"cannot read {path}: {problem}")
    sources[source.path] = source
    return read_map(source, robot.robot)


def _outputs(a: HybridAutomaton) -> dict[str, str | None]:
    """The outputs that every mode has, with their units."""
    shared = [{o.name: o for o in (*a.lets, *mode.lets)} for mode in a.modes]
    names = set.intersection(*(set(s) for s in shared)) if shared else set()
    return {n: str(shared[0][n].unit) if shared[0][n].unit else None for n in names}


def _replayed(s: _Scene, options: Options) -> Replayed:
    engine = mechanics.engine(s.robot)
    started = time.process_time()
    t = sampled(s.cycle, s.map, s.robot.robot)
    motion = mechanics.moved(engine, s.robot, t)
    seen = checks.checked(s.robot, t, motion)
    margins = checks.margins(s.robot, t, motion)
    passed = time.process_time() - started
    pace = greatest_pace(s.cycle, s.map, s.robot.robot)
    outcome, written = _decided(s, pace, options)
    sure = decided(s.robot, s.map, s.cycle, enclosed_finely(s.robot, s.map, s.cycle))
    told = [*_claims(outcome), *(_enclosed(c, s.map) for c in sure)]
    told += [_sample(c) for c in seen if c.name not in _DECIDED]
    certain = _pace(pace, outcome)
    code = exit_codes.worst([outcome.report.summary.exit_code, *map(_code, told)])
    found = facts.Replay(
        schema=facts.SCHEMA,
        source=os.path.relpath(s.path),
        robot=s.robot.robot.name,
        map=os.path.relpath(s.map.source.path),
        claims=written if options.report else None,
        speed=str(s.map.speed),
        cycle_s=round(float(s.cycle.length / s.map.speed), 9),
        samples=len(t.times),
        mass_kg=float(s.robot.robot.mass),
        checks=told,
        joints=[facts.Joint(n, **{k: round(v, 9) for k, v in row.items()}) for n, row in margins.items()],
        pace=certain,
        notes=_notes(s, certain),
        exit_code=code,
    )
    if options.report is not None:
        _write(options.report, found)
    return Replayed([], {}, outcome, found, passed)


def _decided(s: _Scene, pace: Pace | None, options: Options) -> tuple[Outcome, str]:
    """The claims about the joints, written to a spec of their own beside the report, and decided."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as scratch:
        beside = options.report.parent if options.report else Path(scratch)
        name = options.report.name if options.report else "replay"
        beside.mkdir(parents=True, exist_ok=True)
        file = beside / f"{name}.ha"
        there = Path(os.path.relpath(s.path, beside)).as_posix()
        title = f"{s.spec.name or Path(s.path).stem} on {s.robot.robot.name}"
        file.write_text(claims_text(title, there, s.map, s.robot.robot, pace), encoding="utf-8")
        return check(str(file), options), os.path.relpath(file)


def _claims(outcome: Outcome) -> list[facts.Check]:
    """The claims as rows of the table."""
    rows = []
    for c in outcome.report.claims:
        margin = next((p.margin for p in c.parts if p.verdict == c.verdict and p.margin), c.margin)
        margin = c.margin or margin
        violated = [p for p in c.parts if p.verdict == "refuted"]
        where = violated[0].mode if violated else ""
        note = violated[0].facts[0] if violated and violated[0].facts else ""
        rows.append(
            facts.Check(
                name=c.name,
                what=note or "whole cycle, every param",
                basis="checked" if c.trust == "checked" else "enclosed",
                verdict=c.verdict,
                expected=c.expected,
                met=c.ok,
                advice=False,
                value=None,
                limit=None,
                margin=float(Q(margin.decimal)) if margin and not violated else None,
                unit=margin.unit if margin else "",
                time_s=None,
                mode=where,
                note=note,
            )
        )
    return rows


_DECIDED = frozenset(  # by enclosures, under names that tell more
    ("swing sole above ground", "ground pushes", "friction cone", "zero moment point", "centre of mass over sole")
)
_BY_CLAIMS = frozenset(("joint position", "joint speed"))


def _enclosed(c: Decided, m: Map) -> facts.Check:
    expected: Word = "refuted" if c.name in m.expected else "proved"
    verdict: Word = "proved" if c.verdict == "proved" else "refuted" if c.verdict == "refuted" else "unknown"
    margin = c.high if verdict == "refuted" else c.low
    return facts.Check(
        name=c.name,
        what=c.what,
        basis="enclosed",
        verdict=verdict,
        expected=expected,
        met=verdict == expected,
        advice=False,
        value=None,
        limit=None,
        margin=_finite(margin),
        unit=c.unit,
        time_s=c.start,
        mode=c.mode,
        note=f"the least margin lies between {c.low:.6g} and {c.high:.6g} {c.unit}",
    )


def _sample(c: checks.Sampled) -> facts.Check:
    met = None if c.margin is None else bool(c.margin >= 0)
    return facts.Check(
        name=c.name,
        what=c.what,
        basis="sampled",
        verdict="unknown",
        expected=None,
        met=met,
        advice=c.name in _BY_CLAIMS or (bool(c.note) and c.name == "joint torque"),
        value=_finite(c.value),
        limit=c.limit,
        margin=_finite(c.margin),
        unit=c.unit,
        time_s=c.time,
        mode=c.mode,
        note=c.note,
    )


def _finite(x: float | None) -> float | None:
    return None if x is None or x != x or abs(x) == float("inf") else x


def _code(c: facts.Check) -> int:
    """What a check earns; samples that break a limit leave it undecided, and of claims the report says it."""
    if c.basis == "enclosed" and c.time_s is not None:
        return exit_codes.OK if c.met else exit_codes.UNDECIDED if c.verdict == "unknown" else exit_codes.WRONG
    is_broken = c.basis == "sampled" and c.met is False and not c.advice
    return exit_codes.UNDECIDED if is_broken else exit_codes.OK


def _pace(pace: Pace | None, outcome: Outcome) -> facts.Pace | None:
    if pace is None:
        return None
    words = {c.name: c.verdict for c in outcome.report.claims}
    certain = words.get("fastest") == "proved" and words.get("too_fast") == "refuted"
    return facts.Pace(str(pace.proved), str(pace.refuted), certain)


def _notes(s: _Scene, pace: facts.Pace | None) -> list[str]:
    notes = []
    if pace is not None and pace.is_certain:
        notes.append(
            f"every speed limit holds at {_decimal(pace.proved)} of the gait's pace, not at {_decimal(pace.refuted)}"
        )
    if s.cycle.params:
        said = ", ".join(f"{name} = {float(value):g}" for name, value in s.cycle.params.items())
        notes.append(f"claims hold for every value of the params; forces are enclosed and sampled for {said}")
    notes.append("sampled rows are what 1000 samples a second show: they prove nothing")
    if s.robot.advice:
        notes.append(f"limits of speed and torque are placeholders: {s.robot.advice_because}")
    if not s.cycle.closes:
        notes.append("the cycle does not close: the state at its end is not that at its begin")
    return notes


def _decimal(text: str) -> str:
    return f"{float(Q(text)):.4f}"


def _write(folder: Path, found: facts.Replay) -> None:
    (folder / "replay.json").write_text(facts_as_json(found), encoding="utf-8")
