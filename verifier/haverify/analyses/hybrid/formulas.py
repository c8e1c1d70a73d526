"""`stl` of several temporal operators about flows: proved on all ways through all trees, refuted on one that exists.

The trees are those of all other claims; each atom of the formula is judged on them on its own (`stays.py`).
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.hybrid.goal import judged_of
from haverify.analyses.hybrid.inputs import Chosen, choices
from haverify.analyses.hybrid.listing import listings
from haverify.analyses.hybrid.model import Start
from haverify.analyses.hybrid.options import cuts
from haverify.analyses.hybrid.question import Piece, Question, follow
from haverify.analyses.hybrid.runs import Point, run_through
from haverify.analyses.hybrid.starts import Box, cut, halves, is_point
from haverify.analyses.hybrid.stays import Grid, Stays, grid_of
from haverify.analyses.signals_formula import formula_of
from haverify.evidence.run import Run
from haverify.evidence.verdict import Unknown
from haverify.text.record import holder, record, replace

Q = Fraction
PIECES = 128  # boxes of starts looked at for one formula, at most
WORK = 120_000  # stages of all their trees together, each for every atom
DEEPEST = 16  # how often a box is halved, at most
TROUBLED = 3  # trees that end for a lack of effort where inputs drive the flow: smaller boxes have hardly smaller ones
ENDS = ("horizon", "jumped", "cut", "left")


@record
class Read:
    """The trees of a box of starts."""

    piece: Piece
    stays: Stays


@holder
class Reading:
    """A formula, and questions that judge its atoms."""

    grid: Grid
    atoms: list[Question]
    pieces: int = 0
    work: int = 0

    def read(self, start: Start, box: Box, halved: int = 0) -> Read:
        """The trees of a box."""
        trees = [follow(q, start, box, "horizon") for q in self.atoms]
        self.pieces += 1
        self.work += len(trees) * sum(1 + len(s.stages) for s in trees[0])
        return Read(Piece(start, box, trees[0], cuts=halved), Stays(self.atoms[0].model, self.grid, trees))

    @property
    def is_over(self) -> bool:
        """Whether the work allowed is used up."""
        return self.pieces >= PIECES or self.work >= WORK * self.atoms[0].budget


def reading_of(question: Question, chosen: Chosen | None = None) -> Reading:
    """A question about a formula, an atom at a time; with numbers chosen for what drives flows."""
    model, asked = question.model, question.asked
    formula = formula_of(asked.condition, model.values.number)

    def alone(number: int) -> Question:
        judged = judged_of(model, replace(asked, condition=formula.atoms[number]))
        compared: list[list[tuple[object, str, int]]] = []
        modes = listings(model, judged, compared, chosen or {})  # type: ignore[arg-type]
        return replace(question, modes=modes, compared=compared, judged=judged, driven=chosen or {})

    return Reading(grid_of(formula), [alone(k) for k in range(len(formula.atoms))])


def kept_by_all(question: Question) -> bool:
    """Whether the formula holds on all runs: boxes of starts are split until it does."""
    reading = reading_of(question)
    waiting = [(s, b, 0) for s in question.model.starts for b in cut(s.box, cuts(question.claim))]
    found: list[Piece] = []
    troubled, is_driven = 0, any(driven for _, driven, *_ in question.modes)
    while waiting:
        start, box, halved = waiting.pop(0)
        read = reading.read(start, box, halved)
        question.pieces = reading.pieces
        question.shown = question.shown or [read.piece]
        if read.stays.is_kept():
            found.append(read.piece)
            continue
        troubled += is_driven and any(s.end not in ENDS for s in read.piece.tree)
        if reading.is_over or troubled >= TROUBLED or halved >= DEEPEST or is_point(box):
            return False
        waiting += [(start, half, halved + 1) for half in halves(box)[1:]]
    question.shown = found
    return True


def broken_by_one(question: Question, starts: list[Point]) -> Run | None:
    """A run from one of some starts that certainly exists and does not keep the formula."""
    for chosen in choices(question.model):
        reading = reading_of(question, chosen)
        driven = reading.atoms[0]
        for start, point in starts:
            read = reading.read(start, tuple((q, q) for q in point))
            number = next(_broken(read), None)
            if number is not None:
                question.shown = [read.piece]
                return run_through(driven, start, point, read.piece.tree, number)
    return None


def _broken(read: Read) -> Iterator[int]:
    """Stretches on the way to which all runs exist, and none keeps the formula, whatever follows."""
    tree = read.piece.tree
    for number, s in enumerate(tree):
        way = read.stays.way_to(number)
        if s.stages and all(tree[k].is_certain for k in way) and read.stays.truth(way) is False:
            yield number


def open_formula(question: Question) -> Unknown:
    """What is said where nothing decides."""
    count = f"{question.pieces} flowpipes" if question.pieces > 1 else "a flowpipe"
    reason = f"{count} did not show the formula, and no run that breaks it was found"
    return Unknown("budget", reason, next_step="a smaller initial set, or windows with more room")
