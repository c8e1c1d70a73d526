"""Laws of verdicts on flows: what changes the text and not the question never turns proved into refuted.

Scaling time, permuting variables, an affine change of variables, cutting the set of starts in two, taking a part of it.
A smaller set may be proved where the larger one was refuted; nothing else may happen.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.bench.flowpipes import Enough, recorded
from tests.soak.campaign import campaign
from tests.soak.enclosures import of_call
from tests.soak.problems import Array, Field, Problem

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read
from haverify.text.record import record, replace

Q = Fraction
Box = tuple[tuple[Q, Q], tuple[Q, Q]]
SHARED_FOLDER = [HealthCheck.function_scoped_fixture]
LAWS = settings(max_examples=6, deadline=None, derandomize=True, suppress_health_check=SHARED_FOLDER)
JUMPING = settings(LAWS, max_examples=5)


@record
class System:
    """A flow in x and y, perhaps with a jump where x comes down to `wall`; starts; a bound on x for some time.

    `shift + scale * v` stands for x, with v the variable of the text, `rate` for how much faster its time runs.
    """

    fields: tuple[str, str]
    box: Box
    bound: Q
    time: Q
    wall: Q | None = None
    names: tuple[str, str] = ("x", "y")
    scale: Q = Q(1)
    shift: Q = Q(0)
    rate: Q = Q(1)
    is_swapped: bool = False


def number(q: Q) -> str:
    return f"({q.numerator} / {q.denominator})" if q >= 0 else f"(-{-q.numerator} / {q.denominator})"


def text(s: System) -> str:
    """The spec of a system."""
    x, y = s.names
    inner = f"({number(s.shift)} + {number(s.scale)} * {x})"
    of = {"X": inner, "Y": y}

    def written(f: str, factor: Q) -> str:
        return f"{number(factor)} * (" + "".join(of.get(c, c) for c in f) + ")"

    low, high = sorted((q - s.shift) / s.scale for q in s.box[0])
    lines = [f"{x}' = {written(s.fields[0], s.rate / s.scale)}", f"{y}' = {written(s.fields[1], s.rate)}"]
    variables = [f"var {x}", f"var {y}"]
    if s.is_swapped:
        lines.reverse()
        variables.reverse()
    start = f"{number(low)} <= {x} <= {number(high)} and {number(s.box[1][0])} <= {y} <= {number(s.box[1][1])}"
    mode = f"flow {{ {'; '.join(lines)} }}"
    if s.wall is not None:
        wall = number(s.wall)
        edge = f"urgent edge bounce: -> Run when {inner} <= {wall} and {y} < 0 do {y} := -0.5 * {y}"
        mode = f"domain {inner} >= {wall}\n    {mode}\n    {edge}"
    return (
        'spec "Law" version "1.0" unitless\n'
        f"automaton A {{\n  {'; '.join(variables)}\n  init Run where {start}\n  mode Run {{\n    {mode}\n  }}\n}}\n"
        f"property p on A {{ within {number(s.time / s.rate)}, 6 jumps; always {inner} <= {number(s.bound)} }}\n"
    )


def verdict(s: System, folder: Path) -> str:
    """The answer in one word."""
    path = folder / "law.ha"
    path.write_text(text(s), encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    answer = decide_all(spec)["p"].verdict
    return "proved" if isinstance(answer, Proved) else "refuted" if isinstance(answer, Refuted) else "unknown"


def escapes(s: System, folder: Path) -> list[str]:
    """Sampled runs of a system without a wall that leave the first enclosure made for its verdict."""
    with recorded(most=1) as calls, suppress(Enough):
        verdict(s, folder)
    problem = Problem(2, (field(s),), ((),), float(s.time / s.rate) / 16)
    tally = campaign(problem, of_call(next(c for c in calls if c.segments)), 12, 1)
    assert tally.looks > 12
    return tally.escapes


def field(s: System) -> Field:
    """The field in the variables of the text, for floats."""

    def rates(state: Array) -> Array:
        x, y = state[::-1] if s.is_swapped else state
        names = {"X": float(s.shift) + float(s.scale) * x, "Y": y, "sin": np.sin}
        dx, dy = (float(s.rate) * eval(f, names) + 0 * y for f in s.fields)
        dx = dx / float(s.scale)
        return np.stack([dy, dx] if s.is_swapped else [dx, dy])

    return rates


def contradict(*words: str) -> bool:
    return {"proved", "refuted"} <= set(words)


coefficients = st.integers(-4, 4).map(lambda n: Q(n, 4))
ends = st.tuples(st.integers(-4, 4), st.integers(1, 3)).map(lambda p: (Q(p[0], 4), Q(p[0] + p[1], 4)))


@st.composite
def flows(draw: st.DrawFn) -> System:
    """A pendulum with some damping and push, and a bound that about half of them keep."""
    push, damping, coupling = draw(coefficients), draw(coefficients), draw(coefficients)
    fields = ("Y", f"{number(push)} - sin(X) - {number(abs(damping))} * Y + {number(coupling)} * X * Y * Y / 8")
    box = draw(st.tuples(ends, ends))
    bound = box[0][1] + Q(draw(st.integers(1, 8)), 8)
    return System(fields, box, bound, Q(3, 2))


@st.composite
def bounces(draw: st.DrawFn) -> System:
    """A ball in a field with drag, thrown from above its wall: the bound is about its height."""
    drag = draw(st.integers(0, 3))
    low, speed = draw(st.integers(2, 4)), draw(st.integers(-4, 4))
    box = ((Q(low, 4), Q(low, 4) + Q(1, 16)), (Q(speed, 4), Q(speed, 4) + Q(1, 16)))
    bound = box[0][1] + Q(draw(st.integers(0, 6)), 16)
    return System(("Y", f"-1 - {number(Q(drag, 8))} * Y"), box, bound, Q(5, 2), wall=Q(0))


def halves(box: Box) -> list[Box]:
    (low, high), other = box
    middle = (low + high) / 2
    return [((low, middle), other), ((middle, high), other)]


def same(s: System, scale: Q, shift: Q, rate: Q) -> Sequence[System]:
    """The same question in other words."""
    return [
        replace(s, names=("b", "a"), is_swapped=True),
        replace(s, rate=rate),
        replace(s, scale=scale, shift=shift),
    ]


changes = st.tuples(
    st.integers(-8, 8).filter(bool).map(lambda n: Q(n, 3)),
    st.integers(-8, 8).map(lambda n: Q(n, 3)),
    st.sampled_from([Q(1, 100), Q(1, 3), Q(10), Q(10**6)]),
)


def assert_other_words_are_the_same_question(s: System, change: tuple[Q, Q, Q], folder: Path) -> None:
    assert not contradict(*(verdict(x, folder) for x in (s, *same(s, *change))))


def assert_parts_follow_the_whole(s: System, folder: Path) -> None:
    """Proved of all starts is proved or open of some; refuted of some is refuted or open of all."""
    whole = verdict(s, folder)
    parts = [verdict(replace(s, box=half), folder) for half in halves(s.box)]
    inner = verdict(replace(s, box=halves(halves(s.box)[0])[1]), folder)
    assert not (whole == "proved" and "refuted" in (*parts, inner))
    assert not (whole == "refuted" and parts == ["proved", "proved"])
    assert not (parts[0] == "proved" and inner == "refuted")


@given(flows(), changes)
@LAWS
def test_flows_in_other_words(tmp_path: Path, s: System, change: tuple[Q, Q, Q]) -> None:
    assert_other_words_are_the_same_question(s, change, tmp_path)
    assert [e for x in (s, same(s, *change)[-1]) for e in escapes(x, tmp_path)] == []


@given(flows())
@LAWS
def test_flows_from_parts_of_the_starts(tmp_path: Path, s: System) -> None:
    assert_parts_follow_the_whole(s, tmp_path)


@given(bounces(), changes)
@JUMPING
def test_jumps_in_other_words(tmp_path: Path, s: System, change: tuple[Q, Q, Q]) -> None:
    assert_other_words_are_the_same_question(s, change, tmp_path)


@given(bounces())
@JUMPING
def test_jumps_from_parts_of_the_starts(tmp_path: Path, s: System) -> None:
    assert_parts_follow_the_whole(s, tmp_path)


def test_the_laws_are_about_both_answers(tmp_path: Path) -> None:
    """What is drawn above is decided, and both ways."""
    ball = System(("Y", "-1"), ((Q(1), Q(17, 16)), (Q(0), Q(1, 16))), Q(9, 8), Q(5, 2), wall=Q(0))
    assert [verdict(replace(ball, bound=b), tmp_path) for b in (Q(9, 8), Q(17, 16))] == ["proved", "refuted"]
    swing = System(("Y", "-sin(X)"), ((Q(1), Q(9, 8)), (Q(0), Q(1, 8))), Q(5, 4), Q(3, 2))
    assert [verdict(replace(swing, bound=b), tmp_path) for b in (Q(5, 4), Q(9, 8))] == ["proved", "refuted"]
    assert verdict(replace(swing, scale=Q(-2), shift=Q(1), rate=Q(10**6)), tmp_path) == "proved"


@pytest.mark.parametrize("of", ["flow", "jump"])
def test_a_law_would_notice_a_wrong_answer(of: str) -> None:
    assert contradict("unknown", "refuted", "proved") and not contradict("unknown", of, "proved")
