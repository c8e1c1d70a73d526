"""A replay on a robot: its checks as facts, in the shape in which `replay.json` holds them, and as a table."""

from __future__ import annotations

from typing import Literal

from haverify.report.report import Word
from haverify.text.record import record

SCHEMA: Literal["haverify.replay/1"] = "haverify.replay/1"

Basis = Literal["checked", "enclosed", "sampled"]


@record
class Check:
    """One check with its worst instant. `margin` is the signed distance to `limit`; None: no limit is known.

    `basis` tells what the verdict rests on: a claim that hacheck confirmed, an enclosure over the whole cycle, or
    samples. Of samples the verdict is always `unknown`; `met` tells whether they keep the limit, and `advice` that the
    limit is a placeholder or the check is told for information: then it decides nothing.
    """

    name: str
    what: str
    basis: Basis
    verdict: Word
    expected: Word | None
    met: bool | None
    advice: bool
    value: float | None
    limit: float | None
    margin: float | None
    unit: str
    time_s: float | None
    mode: str
    note: str


@record
class Joint:
    """The least margins of a joint that moves: `position` in deg, `speed` in rad/s, `torque` in N m; sampled."""

    name: str
    position: float
    speed: float
    torque: float


@record
class Pace:
    """The greatest multiple of the gait's own pace that keeps every speed limit: `proved`, and `refuted` beyond."""

    proved: str
    refuted: str
    is_certain: bool


@record
class Comparison:
    """Rms differences (deg) of an output: automaton and recording, robot and automaton, robot and recording."""

    output: str
    joint: str
    automaton_recording: float
    robot_automaton: float
    robot_recording: float


@record
class Replay:
    """What a replay found out, beside the claims in `report.json`. `samples` is how many instants were looked at."""

    schema: Literal["haverify.replay/1"]
    source: str
    robot: str
    map: str
    claims: str | None
    speed: str
    cycle_s: float
    samples: int
    mass_kg: float
    checks: list[Check]
    joints: list[Joint]
    pace: Pace | None
    compared: list[Comparison]
    notes: list[str]
    exit_code: int


_MARK = {True: "ok", False: "!!", None: "  "}


_GROUPS: tuple[tuple[Basis, str], ...] = (
    ("checked", "claims about the gait, with certificates that hacheck confirms"),
    ("enclosed", "enclosed over the whole cycle by interval arithmetic; no certificate"),
    ("sampled", "sampled 1000 times a second: nothing is proved"),
)


def table(r: Replay) -> str:
    """The checks as lines for people, those that rest on most first."""
    head = (
        f"{r.robot}, {r.mass_kg:.4f} kg: {r.source} at {_short(float(_fraction(r.speed)))} of its pace, "
        f"{r.cycle_s:.4g} s, {r.samples} instants\n"
    )
    width = max((len(c.name) for c in r.checks), default=0)
    lines = []
    for basis, title in _GROUPS:
        if found := [_row(c, width) for c in r.checks if c.basis == basis]:
            lines += ["", title, *found]
    return head + "\n".join([*lines, "", *(f"  {note}" for note in r.notes)]) + "\n"


def _row(c: Check, width: int) -> str:
    mark = _MARK[c.met] if not c.advice else "  "
    word = c.verdict if c.basis != "sampled" else ""
    value = f"{_short(c.value)} {c.unit}".rstrip() if c.value is not None else ""
    limit = f" of {_short(c.limit)}" if c.limit is not None else ""
    when = f"{c.time_s:.3f} s, {c.mode}" if c.time_s is not None else c.mode
    said = f"{c.what}: {value}{limit}" if value else c.what
    return f"  {mark} {word:<8} {c.name:<{width}}  {_margin(c):<22} {when:<16} {said}".rstrip()


def _margin(c: Check) -> str:
    return f"margin {_short(c.margin)} {c.unit}".rstrip() if c.margin is not None else ""


def _fraction(text: str) -> float:
    a, _, b = text.partition("/")
    return float(a) / float(b or 1)


def _short(x: float | None) -> str:
    return "" if x is None else f"{x:.4g}"
