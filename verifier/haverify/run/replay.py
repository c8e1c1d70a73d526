"""`replay`: a gait on a robot, its joints' limits as claims, everything else by enclosures and samples."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
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
from haverify.report.replay_page import as_page
from haverify.robot import checks, mechanics
from haverify.robot.body import Description
from haverify.robot.claims import MADE, Pace, claims_text
from haverify.robot.comparison import Compared, compared
from haverify.robot.cycle import Cycle, cycle_of
from haverify.robot.folder import describe
from haverify.robot.mapping import Map, check_against, read_map
from haverify.robot.pace import greatest_pace
from haverify.robot.poses import poses
from haverify.robot.recorded import recorded
from haverify.robot.slack import slacks
from haverify.robot.tracking import followed
from haverify.robot.trajectory import Trajectory, sampled
from haverify.robot.verdicts import decided
from haverify.run import replay_rows as rows
from haverify.run.examine import read
from haverify.run.load import read_text
from haverify.run.pipeline import Options, Outcome, check
from haverify.run.replay_meshcat import require_meshcat, scene
from haverify.run.replay_pictures import pictures
from haverify.run.replay_recording import angles_of, comparison_figure, is_recording
from haverify.text.record import record, replace
from haverify.text.source import Source

Q = Fraction
_VIEWED = 121  # instants of a scene
_COMPARISON = (
    "Hips and knees: of the automaton (blue), as recorded, and as far as the robot can follow; rms differences in deg."
)


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


def replay(
    path: str, folder: str, map_path: str | None, speed: Fraction | None, options: Options, view: Path | None = None
) -> Replayed:
    """Replay the automaton of a spec; `view` is where a scene of MeshCat goes.

    Raises
    ------
    UsageError      if a file cannot be read, Pinocchio is missing, or the automaton has no cycle that can be followed
    """
    if view is not None:
        require_meshcat()
    robot, sources, found = describe(folder, read_text)
    if robot is None:
        return Replayed(found, sources, None, None, 0.0)
    m, found = _map(map_path or robot.map, robot, sources)
    m = m if m is None or speed is None else replace(m, speed=speed)
    if is_recording(path):
        return _recording(path, robot, m, sources, found, options, view)
    spec, texts, more = read(path)
    sources |= texts
    found += [d for d in more if is_error(d) and is_meaningless(d)]
    if m is None or spec is None or found:
        return Replayed(found, sources, None, None, 0.0)
    automaton = next((a for a in spec.automata if a.name == m.automaton), None)
    if automaton is None:
        known = ", ".join(a.name for a in spec.automata) or "none"
        raise UsageError(
            f"{path} has no automaton {m.automaton}, which {m.source.path} is made for (it has: {known}); "
            f"name another map with --map"
        )
    if found := check_against(m, _outputs(automaton), [mode.name for mode in automaton.modes]):
        return Replayed(found, sources, None, None, 0.0)
    try:
        cycle = cycle_of(spec, automaton, sorted({name for d in m.drives for name in d.outputs}))
    except OutsideFragmentError as e:
        raise UsageError(f"{path}: {m.automaton} cannot be replayed: {e}") from e
    return replace(_replayed(_Scene(path, robot, m, spec, automaton, cycle), options, view), sources=sources)


def _recording(
    path: str,
    robot: Description,
    m: Map | None,
    sources: dict[str, Source],
    found: list[Diagnostic],
    options: Options,
    view: Path | None,
) -> Replayed:
    """Replay a recording: it has no phases, and everything about it is sampled."""
    wanted = sorted({name for d in m.drives for name in d.outputs}) if m else []
    seen = angles_of(path, wanted, m.missing if m else {})
    if seen.source is not None:
        sources[seen.source.path] = seen.source
    if m is None or found or seen.found:
        return Replayed([*found, *seen.found], sources, None, None, 0.0)
    if any(d.unit != "deg" for d in m.drives):
        raise UsageError(f"{m.source.path} reads angles in rad, and those of a recording are in deg")
    engine = mechanics.engine(robot)
    started = time.process_time()
    t = recorded(seen.times, seen.values, m, robot.robot, engine)
    motion = mechanics.moved(engine, robot, t)
    told = [
        rows.sampled_row(c, is_claimed=False) for c in checks.checked(robot, t, motion, _followed(engine, robot, m, t))
    ]
    margins = checks.margins(robot, t, motion)
    passed = time.process_time() - started
    result = _facts(path, robot, m, t, told, margins, exit_codes.worst([exit_codes.OK, *map(rows.code, told)]))
    result = replace(result, notes=[*seen.notes, *result.notes])
    if options.report is not None:
        options.report.mkdir(parents=True, exist_ok=True)
        _write(options.report, result, pictures(robot, t, motion))
    _view(view, engine, robot, t)
    return Replayed([], sources, None, result, passed)


def _followed(e: mechanics.Engine, d: Description, m: Map, t: Trajectory) -> checks.Followed:
    return checks.Followed(followed(e, d, t, m.servo), m.servo)


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


def _replayed(s: _Scene, options: Options, view: Path | None) -> Replayed:
    engine = mechanics.engine(s.robot)
    started = time.process_time()
    t = sampled(s.cycle, s.map, s.robot.robot)
    motion = mechanics.moved(engine, s.robot, t)
    seen = checks.checked(s.robot, t, motion, _followed(engine, s.robot, s.map, t))
    margins = checks.margins(s.robot, t, motion)
    passed = time.process_time() - started
    pace = greatest_pace(s.cycle, s.map, s.robot.robot)
    outcome, written = _decided(s, pace, options)
    claimed = rows.claim_rows(outcome, s.cycle, slacks(s.cycle, s.map, s.robot.robot, pace))
    told = [rows.enclosed_row(c, s.map, s.cycle, s.robot.advice) for c in decided(s.robot, s.map, s.cycle)]
    told += [rows.sampled_row(c) for c in seen if c.name not in rows.DECIDED]
    certain = _pace(pace, outcome)
    codes = [outcome.report.summary.exit_code, *map(rows.code, told)]
    told = [*claimed, *told]
    found = _facts(s.path, s.robot, s.map, t, told, margins, exit_codes.worst(codes))
    beside = _compared(s)
    found = replace(
        found,
        claims=written if options.report else None,
        pace=certain,
        compared=[_differences(c) for c in beside],
        notes=_notes(s, certain) + without_effect(s.map, told, beside) + found.notes,
    )
    if options.report is not None:
        drawn = pictures(s.robot, t, motion)
        if beside:
            drawn.append((_COMPARISON, comparison_figure(beside)))
        _write(options.report, found, drawn)
    _view(view, engine, s.robot, t)
    return Replayed([], {}, outcome, found, passed)


def _facts(
    path: str,
    robot: Description,
    m: Map,
    t: Trajectory,
    told: list[facts.Check],
    margins: Mapping[str, Mapping[str, float]],
    code: int,
) -> facts.Replay:
    notes = ["sampled rows are what 1000 samples a second show: they prove nothing"]
    if robot.advice:
        notes.append(f"limits of speed and torque are placeholders: {robot.advice_because}")
    return facts.Replay(
        schema=facts.SCHEMA,
        source=os.path.relpath(path),
        robot=robot.robot.name,
        map=os.path.relpath(m.source.path),
        claims=None,
        speed=str(m.speed),
        cycle_s=round(float(t.times[-1] - t.times[0]), 9),
        samples=len(t.times),
        mass_kg=float(robot.robot.mass),
        checks=told,
        joints=[facts.Joint(n, **{k: round(v, 9) for k, v in row.items()}) for n, row in margins.items()],
        pace=None,
        compared=[],
        notes=notes,
        exit_code=code,
    )


def _decided(s: _Scene, pace: Pace | None, options: Options) -> tuple[Outcome, str]:
    """The claims about the joints, written to a spec of their own beside the report, and decided."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as scratch:
        beside = options.report.parent if options.report else Path(scratch)
        name = options.report.name if options.report else "replay"
        beside.mkdir(parents=True, exist_ok=True)
        file = beside / f"{name}.ha"
        _require_own(file)
        there = Path(os.path.relpath(s.path, beside)).as_posix()
        title = f"{s.spec.name or Path(s.path).stem} on {s.robot.robot.name}"
        file.write_text(claims_text(title, there, s.map, s.robot.robot, pace), encoding="utf-8")
        return check(str(file), options), os.path.relpath(file)


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
        held = "claims and enclosures hold" if s.cycle.steady else "claims hold"
        rest = "samples are" if s.cycle.steady else "forces are enclosed and sampled"
        notes.append(f"{held} for every value of the params, {rest} for {said}")
    if not s.cycle.closes:
        notes.append("the cycle does not close: the state at its end is not that at its begin")
    return notes


def without_effect(m: Map, told: list[facts.Check], beside: list[Compared]) -> list[str]:
    """What the map names and nothing came of: a check that there is none of, a recording that cannot be read."""
    known = {c.name for c in told if c.basis != "sampled"}
    notes = [f"[expect] of {m.source.path}: `{name}` is no check here" for name in m.expected if name not in known]
    if m.recording is not None and not beside:
        notes.append(f"the recording {m.recording} cannot be read, so nothing is compared with it")
    return notes


def _decimal(text: str) -> str:
    return f"{float(Q(text)):.4f}"


def _view(file: Path | None, e: mechanics.Engine, robot: Description, t: Trajectory) -> None:
    if file is None:
        return
    page = scene(poses(e, robot, t, _VIEWED))
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page, encoding="utf-8")
    except OSError as problem:
        raise UsageError(f"{file}: cannot be written: {problem.strerror}") from problem


def _write(folder: Path, found: facts.Replay, drawn: list[tuple[str, str]]) -> None:
    (folder / "replay.json").write_text(facts_as_json(found), encoding="utf-8")
    (folder / "replay.html").write_text(as_page(found, drawn), encoding="utf-8")


def _require_own(file: Path) -> None:
    """What somebody wrote is not overwritten."""
    problem, source = read_text(str(file))
    if file.exists() and (problem or source is None or not source.text.startswith(MADE)):
        raise UsageError(f"{file} is there already and was not made by replay; name another folder with --report")


def _compared(s: _Scene) -> list[Compared]:
    """Automaton, recording and robot side by side, where the map names a recording that can be read."""
    if s.map.recording is None:
        return []
    path = os.path.normpath(os.path.join(os.path.dirname(s.map.source.path), s.map.recording))
    wanted = sorted({name for d in s.map.drives for name in d.outputs})
    seen = angles_of(path, wanted)
    return compared(s.cycle, s.map, s.robot.robot, seen.times, seen.values) if seen.times else []


def _differences(c: Compared) -> facts.Comparison:
    one, two, three = (round(x, 6) for x in (c.fit_rms, c.robot_rms, c.whole_rms))
    return facts.Comparison(c.output, c.joint, one, two, three)
