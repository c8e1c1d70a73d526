"""A goal compiled for the kernel, and the tree of stretches from a box of starts."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from fractions import Fraction
from typing import TypeVar

from haverify.analyses.hybrid.conserved import Conserved
from haverify.analyses.hybrid.goal import Asked, asked_of, judged_of
from haverify.analyses.hybrid.inputs import Chosen
from haverify.analyses.hybrid.listing import Judged, listings
from haverify.analyses.hybrid.model import HybridModel, Start
from haverify.analyses.hybrid.options import tuned
from haverify.analyses.hybrid.shared import Trees
from haverify.analyses.hybrid.starts import Box
from haverify.maths.interval import Fault, Interval
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import (
    Budget,
    ModeListing,
    Pair,
    RecordedStretch,
    Settings,
    Stretch,
    Tree,
    enclosed,
    grown,
    judged,
    reach,
    recorded,
    stretches,
)
from haverify.text.record import field, holder, record, replace

Q = Fraction
STEPS = 4000
# Where inputs drive a flow with jumps: sets that come to more have spread, and leave no work for other attempts.
STEPS_DRIVEN = 1200
STRETCHES = 400
CUTS = 6
RECORDED = 4  # times the stretches of a proof that its record may have: it is not to take much longer
LAPS, RETURNS = 600, 60  # steps and stretches after which sets do not seem to return
LOOKS = 32  # what is looked at is at most this part of the horizon
DRIVEN = 8  # times as many steps where inputs drive the flow: what they do in a step is taken as a box
CLOSER = 4  # times as many where instants count: windows of formulas begin and end there
FINER = 1e-3  # times the error aimed at, where the usual one did not do
INSTANT = Q(1, 10**9)  # a horizon of 0 s is looked at for a little longer
BEYOND = Q(1, 10**4)  # of the horizon is recorded more: instants of jumps are known with an error
FAR = 100.0  # s; where there are jumps, a longer horizon does not make steps longer


T = TypeVar("T", Stretch, RecordedStretch)


class OpenModesError(OutsideFragmentError):
    """Runs come to modes of a system whose edges are not listed: `modes`, by name."""

    def __init__(self, modes: frozenset[str]) -> None:
        super().__init__("runs come to modes of a system whose edges are not listed")
        self.modes = modes


@record
class Piece:
    """A box of starts in a mode, and the tree that encloses all runs from it."""

    start: Start
    box: Box
    tree: list[Stretch] = field(default_factory=list)
    # Whether its steps are finer than usual.
    is_finer: bool = False
    # How often a box was halved to get it.
    cuts: int = 0


@holder
class Question:
    """A goal compiled for the kernel, and what is known of it so far."""

    model: HybridModel
    claim: Claim
    asked: Asked
    modes: list[ModeListing]
    # For each mode, the comparisons of the claim and of the window: quantity, sign, position among what is watched.
    compared: list[list[tuple[Expr, str, int]]]
    judged: Judged
    reached: float | None = None
    trouble: str = ""
    pieces: int = 0
    # Steps followed so far, those in more than a few variables counted as several.
    work: Q = Q(0)
    # Times the usual work.
    budget: Q = Q(1)
    # What to draw: the trees that decide, or the first one that did not.
    shown: list[Piece] = field(default_factory=list)
    # The numbers chosen for what drives flows, where single runs are followed.
    driven: Chosen = field(default_factory=dict)
    # Whether the run that decides it takes edges that may wait at their first instant: its record does not say so.
    hurried: bool = False
    # The trees that all claims share.
    trees: Trees = field(default_factory=Trees)
    # The trees of single starts, by mode and start.
    points: dict[tuple[int, Box], list[Stretch]] = field(default_factory=dict)


def question_of(model: HybridModel, claim: Claim, goal: Goal, laws: Conserved | None = None) -> Question:
    """A goal of a claim, compiled; comparisons of what is kept by `laws` are decided by the starts.

    Raises
    ------
    OutsideFragmentError    if it is none that flowpipes speak of, or a number in it is none that they can compute with
    """
    asked = asked_of(model, claim, goal)
    judged = judged_of(model, asked, laws)
    compared: list[list[tuple[Expr, str, int]]] = []
    for q in (asked.last, *(end for s in model.starts for ends in s.box for end in ends)):
        enclosed(q)
    return Question(model, claim, asked, listings(model, judged, compared), compared, judged)


def follow(question: Question, start: Start, box: Box, until: str, is_finer: bool = False) -> list[Stretch]:
    """The tree that encloses all runs from a box of starts: up to the horizon it is grown once for all claims."""
    if until == "horizon":
        tree, is_new = _tree(question, start, box, is_finer)
        return _listed(question, stretches(tree) if is_new else _judged_again(question, start, box, is_finer, tree))
    horizon = Interval.at(max(question.asked.last, INSTANT)).high
    given = start.mode, sides(box), _known(question, start, box)
    settings, budget = settings_of(question, box, is_finer), _budget(question)
    if until == "passed":
        settings, budget = replace(settings, steps=LAPS), replace(budget, stretches=RETURNS)
    return _listed(question, reach(question.modes, given, horizon, until, settings, budget))


def _judged_again(question: Question, start: Start, box: Box, is_finer: bool, tree: Tree) -> list[Stretch]:
    """A tree of another claim with this one; where this may have no value on the way, the tree grown for it ends."""
    try:
        return judged(tree, question.modes, _known(question, start, box))
    except Fault:
        horizon = Interval.at(max(question.asked.last, INSTANT)).high
        settings, budget = settings_of(question, box, is_finer), _budget(question)
        return stretches(_wanted(question, start, box, horizon, settings, budget)[1]())


def _listed(question: Question, tree: list[T]) -> list[T]:
    """The stretches.

    Raises
    ------
    OpenModesError    where they come to modes whose edges are not listed
    """
    model = question.model
    found = frozenset(model.places[s.mode].mode for s in tree)
    if found & model.open:
        raise OpenModesError(found & model.open)
    question.trees.seen |= found
    return tree


def _budget(question: Question) -> Budget:
    return Budget(question.asked.jumps - question.asked.last_jump, STRETCHES, CUTS)


def _tree(question: Question, start: Start, box: Box, is_finer: bool) -> tuple[Tree, bool]:
    """The tree up to the horizon, and whether it was grown for this question: for the first of all that share it."""
    horizon = Interval.at(max(question.asked.last, INSTANT)).high
    return _grown(question, start, box, horizon, settings_of(question, box, is_finer), _budget(question))


def _grown(
    question: Question, start: Start, box: Box, horizon: float, settings: Settings, budget: Budget
) -> tuple[Tree, bool]:
    return question.trees.get(*_wanted(question, start, box, horizon, settings, budget))


def _wanted(
    question: Question, start: Start, box: Box, horizon: float, settings: Settings, budget: Budget
) -> tuple[Hashable, Callable[[], Tree]]:
    """What a tree depends on, and how to grow it."""
    given = start.mode, sides(box), _known(question, start, box)

    def grow() -> Tree:
        return grown(question.modes, given, horizon, "horizon", settings, budget)

    model = question.model
    about = model.automaton.name, model.names, model.assumed, model.used, tuple(sorted(question.driven.items()))
    return (*about, start.mode, box, horizon, settings, budget), grow


def grow_all(question: Question, pieces: Sequence[Piece]) -> None:
    """Grow the trees of some pieces up to the horizon at the same time."""
    horizon, budget = Interval.at(max(question.asked.last, INSTANT)).high, _budget(question)
    question.trees.grow([
        _wanted(question, p.start, p.box, horizon, settings_of(question, p.box, p.is_finer), budget) for p in pieces
    ])  # fmt: skip


def from_the_middle(question: Question, piece: Piece) -> list[Stretch]:
    """What the tree of a piece shows of the runs from its middle."""
    tree, _ = _tree(question, piece.start, piece.box, piece.is_finer)
    known = _known(question, piece.start, piece.box)
    return _listed(question, judged(tree, question.modes, known, is_middle=True))


def follow_record(question: Question, piece: Piece, until: Q) -> list[RecordedStretch]:
    """The polynomials of the same tree; where there are jumps, a little beyond an instant, and without cuts."""
    if not question.model.jumps and until == question.asked.last:
        return _listed(question, recorded(_tree(question, piece.start, piece.box, piece.is_finer)[0]))
    most = RECORDED * len(piece.tree) or STRETCHES
    budget = replace(_budget(question), stretches=most, cuts=0)
    settings = recorded_settings(question, piece, until)
    return _listed(question, recorded(_grown(question, piece.start, piece.box, _beyond(until), settings, budget)[0]))


def _known(question: Question, start: Start, box: Box) -> list[tuple[int, str]]:
    """The comparisons of the claim and the window in a mode that hold on a box of starts exactly."""
    model = question.model
    sides = dict(zip(model.names, box, strict=True))
    found = []
    for quantity, op, place in question.compared[start.mode]:
        ends = exact_range(quantity, sides, model.definitions[start.mode])
        if ends is not None and ((op == "<=" and ends[1] <= 0) or (op == ">=" and ends[0] >= 0)):
            found.append((place, op))
    return found


def exact_range(e: Expr, sides: Mapping[str, tuple[Q, Q]], known: Mapping[tuple[str, str], Expr]) -> tuple[Q, Q] | None:
    """The exact range of a sum of multiples of variables over a box, by interval arithmetic; None for other forms."""
    if e.op == "num":
        return Q(str(e.args[0])), Q(str(e.args[0]))
    if e.op in ("var", "param"):
        return sides.get(e.name)
    if e.op in ("let", "const"):
        inner = known.get((e.op, e.name))
        return None if inner is None else exact_range(inner, sides, known)
    if e.op not in ("+", "-", "neg"):
        return None
    ends = [exact_range(c, sides, known) for c in e.children]
    if any(x is None for x in ends):
        return None
    first, *rest = (x for x in ends if x is not None)
    if e.op == "neg":
        return -first[1], -first[0]
    low, high = first
    for x in rest:
        low, high = (low + x[0], high + x[1]) if e.op == "+" else (low - x[1], high - x[0])
    return low, high


def sides(box: Box) -> list[Pair]:
    """Enclosures of the sides of a box."""
    found = [Interval.between(low, high) for low, high in box]
    return [(x.low, x.high) for x in found]


def settings_of(question: Question, box: Box, is_finer: bool) -> Settings:
    """Few variables can afford a high degree; the error aimed at follows the size of the state."""
    wide = sum(low < high for low, high in box)
    degree = 1 if wide == 0 else 5 if wide <= 2 else 4 if wide <= 3 else 3 if wide <= 4 else 2
    size = max([float(abs(end)) for ends in box for end in ends], default=1.0) or 1.0
    horizon = float(max(question.asked.last, INSTANT))
    horizon = min(horizon, FAR) if question.model.jumps else horizon
    tolerance = 1e-7 * min(max(size, 1e-6), 1e6)
    is_driven = any(driven for _, driven, *_ in question.modes)
    looks = LOOKS * DRIVEN if is_driven else LOOKS
    looks *= CLOSER if question.asked.kind == "signal" and not is_driven else 1
    steps = STEPS_DRIVEN if is_driven and question.model.jumps else STEPS
    settings = Settings(8, degree, tolerance, min(horizon, 0.02), horizon / looks, min(horizon, FAR) * 1e-9, steps, 4)
    settings = tuned(settings, question.claim, wide)
    return replace(settings, tolerance=settings.tolerance * FINER) if is_finer else settings


def _beyond(until: Q) -> float:
    return Interval.at(max(until, INSTANT) * (1 + BEYOND)).high


def recorded_settings(question: Question, piece: Piece, until: Q) -> Settings:
    """Steps follow the horizon of the record, where they may."""
    settings = settings_of(question, piece.box, piece.is_finer)
    return settings if question.model.jumps else replace(settings, longest=_beyond(until) / LOOKS)
