"""Deciding `always` (and `never`, and that nothing can be reached): part by part, on cells, with margins and runs."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.clocked import Cells
from haverify.analyses.margin import Low, least
from haverify.analyses.placement import Tree, written
from haverify.analyses.poly_range import MANY, Ranges, Work, always, prove
from haverify.analyses.questions import Question, Setting, questions
from haverify.analyses.stuck import never_stuck
from haverify.obligations.formula import (
    Formula,
    Junction,
    Literal,
    by_bounds,
    conjunction,
    disjunction,
    negation,
    truth,
    variables,
)
from haverify.obligations.parts import Part
from haverify.text.record import field, holder

Q = Fraction


@holder
class Judged:
    """A part on its cells: a tree for each where there is one, and the least margin with the cell that has it.

    The trees are in the order of the mode's cells; of an edge, None stands for a cell that it is not taken from.
    """

    part: Part
    trees: list[Tree | None] = field(default_factory=list)
    proved: bool = True
    low: Low | None = None
    cell: int | None = None
    question: Question | None = None
    reason: str = ""
    touched: bool = False  # whether some cell makes its residual a question at all

    @property
    def margin_strict(self) -> bool:
        """Whether the literal that sets the margin is strict."""
        return self.low is not None and self.low.leaf is not None and self.low.leaf.op in ("<", "!=")


def judge(setting: Setting, part: Part, cells: Cells, work: Work, with_margin: bool = True) -> Judged:
    """Prove a part on every cell it concerns, as far as possible."""
    judged = Judged(part)
    if part.kind == "stuck":
        bad = [
            i for i in cells.of_mode(setting.model.index[part.mode]) if not never_stuck(cells, i, setting.time_limit())
        ]
        judged.touched = bool(cells.of_mode(setting.model.index[part.mode]))
        judged.proved = not bad
        judged.reason = f"a run may be stuck in mode {part.mode}" if bad else ""
        return judged
    trees: dict[int, Tree] = {}
    for i, q in questions(setting, part, cells):
        judged.touched = True
        low = _note_margin(judged, i, q, setting.ranges) if with_margin and _has_margin(q) else None
        violated = low is not None and low.high < 0 and not q.extra_premise
        tree = None if violated else tree_for(q, setting.ranges, work)
        if tree is None:
            judged.proved = False
            judged.reason = judged.reason or reason_for(q, work)
            judged.question = judged.question or q
        else:
            trees[i] = written(tree)
    mode = setting.model.index[part.mode] if part.edge is None else setting.model.edge(part.edge).source
    judged.trees = [trees.get(i) for i in cells.of_mode(mode)]
    return judged


def reason_for(q: Question, work: Work) -> str:
    """Why there is no tree."""
    if not (variables(q.placement.place(q.body)) <= set(q.placement.box)):
        return "the states are not bounded: a run may stay for ever, or a variable has no range"
    return "the budget of the proof search is spent" if work.left < 0 else "no proof was found"


def _has_margin(q: Question) -> bool:
    """Whether everything that the question reads is bounded."""
    if q.placement.bounded:
        return True
    read = [q.body, q.premise] if q.extra_premise else [q.body]
    return all(variables(q.placement.place(f)) <= set(q.placement.box) for f in read)


def _note_margin(judged: Judged, cell: int, q: Question, ranges: Ranges) -> Low | None:
    premise = placed(q, q.premise) if q.extra_premise else True
    low = least(placed(q, q.body), premise, q.placement.box, ranges)
    if low is not None and (judged.low is None or low.low < judged.low.low):
        judged.low, judged.cell, judged.question = low, cell, q
    return low


def placed(q: Question, f: Formula) -> Formula:
    """A formula on the box, literals that have become constant kept for their margin."""
    if isinstance(f, Literal):
        return Literal(f.op, q.placement.apply(f.polynomial))
    if isinstance(f, Junction):
        members = [placed(q, m) for m in f.members]
        return Junction(f.is_and, tuple(m for m in members if not isinstance(m, bool)))
    return f


def tree_for(q: Question, ranges: Ranges, work: Work) -> Tree | None:
    """A proof that the question's formula holds on its box."""
    body = q.placement.place(q.body)
    if body is True:
        return "b"
    box = q.placement.box
    if variables(body) <= set(box):
        quick = _quick(body, box, ranges, work)
        if quick is not None:
            return quick
    goal = disjunction([negation(q.placement.place(q.premise)), body])
    if goal is True:
        return "b"
    return prove(goal if q.placement.bounded else _about(goal, box), box, ranges, work)


def _quick(body: Formula, box: Mapping[str, tuple[Q, Q]], ranges: Ranges, work: Work) -> Tree | None:
    names = variables(body)
    if len(names) > MANY:
        return prove(body, box, ranges, work)
    known = truth(body, lambda leaf: by_bounds(leaf.op, *ranges.bounds(leaf.polynomial, box)))
    if known is not None:
        return "b" if known else None
    if len(names) == 1:
        v = next(iter(names))
        return "u" if always(body, v, box[v], ranges) else None
    return None


def _about(goal: Formula, box: Mapping[str, tuple[Q, Q]]) -> Formula:
    """The goal with what reads anything unbounded counted as false."""
    if isinstance(goal, Junction):
        return (conjunction if goal.is_and else disjunction)([_about(m, box) for m in goal.members])
    return goal if all(v in box for v in variables(goal)) else False
