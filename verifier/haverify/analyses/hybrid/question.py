"""A goal compiled for the kernel, and the tree of stretches from a box of starts."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.flow_model import Box
from haverify.analyses.flow_record import sides
from haverify.analyses.hybrid.goal import Asked, asked_of, judged_of
from haverify.analyses.hybrid.model import HybridModel, Start, listings
from haverify.analyses.taylor_options import tuned
from haverify.maths.interval import Interval
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.solvers.kernel import Budget, ModeListing, Pair, RecordedStretch, Settings, Stretch, reach, reach_record
from haverify.text.record import field, holder

Q = Fraction
STEPS = 4000
STRETCHES = 400
CUTS = 6
LOOKS = 32  # a step is at most this part of the horizon
INSTANT = Q(1, 10**9)
BEYOND = Q(1, 10**4)  # of the horizon is recorded more: instants of jumps are known with an error
FAR = 100.0  # s; a longer horizon does not make steps longer


@holder
class Question:
    """A goal compiled for the kernel."""

    model: HybridModel
    claim: Claim
    asked: Asked
    modes: list[ModeListing]
    # For each mode, the comparisons of the claim and of the window: quantity, sign, position among what is watched.
    compared: list[list[tuple[Expr, str, int]]]
    reached: float | None = None
    trouble: str = ""
    pieces: int = 0
    # What to draw: the trees that decide, or the first one that did not.
    shown: list[tuple[Box, list[Stretch]]] = field(default_factory=list)


def question_of(model: HybridModel, claim: Claim, goal: Goal) -> Question:
    asked = asked_of(model, claim, goal)
    judged = judged_of(model, asked)
    compared: list[list[tuple[Expr, str, int]]] = []
    return Question(model, claim, asked, listings(model, judged, compared), compared)


def follow(question: Question, start: Start, box: Box, until: str) -> list[Stretch]:
    sides = [pair(low, high) for low, high in box]
    horizon = Interval.at(max(question.asked.last, INSTANT)).high
    asked = question.asked
    budget = Budget(asked.jumps - asked.last_jump, STRETCHES, CUTS)
    known = _known(question, start, box)
    return reach(question.modes, (start.mode, sides, known), horizon, until, _settings(question, box), budget)


def follow_record(question: Question, start: Start, box: Box) -> list[RecordedStretch]:
    """The polynomials of the same tree, a little beyond the horizon."""
    horizon = Interval.at(max(question.asked.last, INSTANT) * (1 + BEYOND)).high
    asked = question.asked
    given = start.mode, sides(box), _known(question, start, box)
    budget = Budget(asked.jumps - asked.last_jump, STRETCHES, 0)
    return reach_record(question.modes, given, horizon, _settings(question, box), budget)


def _known(question: Question, start: Start, box: Box) -> list[tuple[int, str]]:
    """The comparisons of the claim and the window in a mode that hold on a box of starts exactly."""
    model = question.model
    sides = dict(zip(model.names, box, strict=True))
    found = []
    for quantity, op, place in question.compared[start.mode]:
        ends = _exact(quantity, sides, model.definitions[start.mode])
        if ends is not None and ((op == "<=" and ends[1] <= 0) or (op == ">=" and ends[0] >= 0)):
            found.append((place, op))
    return found


def _exact(e: Expr, sides: Mapping[str, tuple[Q, Q]], known: Mapping[tuple[str, str], Expr]) -> tuple[Q, Q] | None:
    """The exact range of a sum of multiples of variables over a box, by interval arithmetic; None for other forms."""
    if e.op == "num":
        return Q(str(e.args[0])), Q(str(e.args[0]))
    if e.op in ("var", "param"):
        return sides.get(e.name)
    if e.op in ("let", "const"):
        inner = known.get((e.op, e.name))
        return None if inner is None else _exact(inner, sides, known)
    if e.op not in ("+", "-", "neg"):
        return None
    ends = [_exact(c, sides, known) for c in e.children]
    if any(x is None for x in ends):
        return None
    first, *rest = (x for x in ends if x is not None)
    if e.op == "neg":
        return -first[1], -first[0]
    low, high = first
    for x in rest:
        low, high = (low + x[0], high + x[1]) if e.op == "+" else (low - x[1], high - x[0])
    return low, high


def pair(low: Q, high: Q) -> Pair:
    x = Interval.between(low, high)
    return x.low, x.high


def _settings(question: Question, box: Box) -> Settings:
    """Few variables can afford a high degree; the error aimed at follows the size of the state."""
    wide = sum(low < high for low, high in box)
    degree = 1 if wide == 0 else 5 if wide <= 2 else 4 if wide <= 3 else 3 if wide <= 4 else 2
    size = max([float(abs(end)) for ends in box for end in ends], default=1.0) or 1.0
    horizon = min(float(max(question.asked.last, INSTANT)), FAR)
    tolerance = 1e-7 * min(max(size, 1e-6), 1e6)
    settings = Settings(8, degree, tolerance, min(horizon, 0.02), horizon / LOOKS, horizon * 1e-9, STEPS, 4)
    return tuned(settings, question.claim, wide)
