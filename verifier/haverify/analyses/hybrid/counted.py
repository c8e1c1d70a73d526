"""Jumps that change neither the flow nor the state are only counted: one flowpipe carries all runs through them.

All modes have one field, and are told apart by the sign of one quantity `g`: in a mode either `g >= 0` or `g <= 0`
holds, and its urgent edges lead, where `g` goes beyond zero, to modes of the other sign. So a run of the field makes
the jumps that the changes of sign of `g` along it force. Parts of the flowpipe where `g` has one sign certainly leave
the modes of that sign. Over a connected part where it may be zero:

- with `g' < 0` (`> 0`) throughout, `g` changes its sign at most once, downwards (upwards);
- with `g'' > 0` (`< 0`), `g` is convex (concave) along every run: it is below (above) zero on one interval at most.

A run that only touches zero makes no jump: guards are strict, and do not hold right after (LANGUAGE S8). What of it is
open is followed as it may be: the modes possible after a part are a set, and no tangency splits the flow.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, atoms, closed, condition
from haverify.analyses.hybrid.inputs import fields
from haverify.analyses.hybrid.listing import Watched
from haverify.analyses.hybrid.options import cuts
from haverify.analyses.hybrid.question import Question, settings_of, sides
from haverify.analyses.hybrid.rates import rate
from haverify.analyses.hybrid.starts import cut, halves, is_point
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, nodes
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Budget, ModeListing, Pair, Stage, Tape, reach
from haverify.text.record import record, replace

Q = Fraction
FINER = 8  # times as many parts of the flowpipe as usual
PIECES = 64  # boxes of starts that are followed, at most
DEEPEST = 6
ABOUT_JUMPS = ("pre", "jump", "jumped", "at")

Modes = frozenset[int]


@record
class Counted:
    """The quantity that tells modes apart, the sign it has in each, and the modes that edges lead to from each."""

    quantity: Expr
    signs: tuple[int, ...]
    following: tuple[Modes, ...]


def proved_by_counting(question: Question) -> bool | None:
    """Whether flowpipes show the goal, jumps being counted; None where it is not of that kind."""
    counted = counted_of(question)
    if counted is None:
        return None
    try:
        alone, places = _without_jumps(question, counted)
    except OutsideFragmentError:
        return None
    waiting = [(s, b, 0) for s in question.model.starts for b in cut(s.box, cuts(question.claim))]
    while waiting and question.pieces < PIECES:
        start, box, depth = waiting.pop()
        question.pieces += 1
        settings = settings_of(question, box, is_finer=False)
        settings = replace(settings, longest=settings.longest / FINER)
        horizon = Interval.at(question.asked.last).high
        tree = reach([alone], (0, sides(box), []), horizon, "horizon", settings, Budget(0, 1, 0))
        if tree[0].end == "horizon" and _is_shown(question, counted, tree[0].stages, start.mode, places):
            continue
        if depth >= DEEPEST or is_point(box):
            return False
        waiting += [(start, b, depth + 1) for b in halves(box)[1:]]
    return not waiting


def counted_of(question: Question) -> Counted | None:
    """How modes are told apart, where jumps change nothing but the mode; None for other automata and goals."""
    model, judged = question.model, question.judged
    is_asked = question.asked.kind == "always" and not (
        question.asked.last_jump or question.asked.endless or question.asked.to_the_end
    )
    reads_jumps = any(n.op in ABOUT_JUMPS for n in nodes(question.asked.condition))
    is_free = any(judged.facts) or any(judged.assumed) or any(given[1] for given in question.modes)
    alike = all(given[0] == question.modes[0][0] for given in question.modes)
    known = all(of == model.definitions[0] for of in model.definitions)
    is_over = question.driven or any(m.terminal for m in model.modes) or not model.jumps or bool(model.open)
    if not is_asked or reads_jumps or is_free or not alike or not known or is_over:
        return None
    borders = [_border(question, k) for k in range(len(model.modes))]
    quantities = {b[0] for b in borders if b is not None}
    if None in borders or len(quantities) != 1:
        return None
    signs = tuple(b[1] for b in borders if b is not None)
    following: list[Modes] = []
    for number in range(len(model.modes)):
        found = _following(question, number, signs, next(iter(quantities)))
        if found is None:
            return None
        following.append(found)
    return Counted(next(iter(quantities)), signs, tuple(following))


def _border(question: Question, number: int) -> tuple[Expr, int] | None:
    """The one quantity that a mode's domain compares with zero, and the sign it has there."""
    model = question.model
    at = Situation(model.places[number].mode)
    domain = closed(condition(residual(model.modes[number].domain, at), model.definitions[number]))
    if isinstance(domain, Every) and len(domain.members) == 1:
        domain = domain.members[0]
    if not isinstance(domain, Atom) or domain.op not in ("<=", ">="):
        return None
    return domain.quantity, 1 if domain.op == ">=" else -1


def _following(question: Question, number: int, signs: Sequence[int], quantity: Expr) -> Modes | None:
    """The modes of the other sign that edges lead to; None if an edge does anything else."""
    model = question.model
    at, known = Situation(model.places[number].mode), model.definitions[number]
    found = set[int]()
    leaves = Atom(quantity, "<" if signs[number] > 0 else ">")
    for edge in (e for e in model.automaton.edges if e.source == model.modes[number].name):
        guard, target = condition(residual(edge.guard, at), known), model.mode(edge.target)
        keeps = all(isinstance(a.to, Expr) and a.to.op == "var" and a.to.name == a.var for a in edge.resets)
        if guard != leaves or not edge.urgent or not keeps or signs[target] == signs[number]:
            return None
        found.add(target)
    return frozenset(found)


def _without_jumps(question: Question, counted: Counted) -> tuple[ModeListing, dict[Expr, int]]:
    """The field alone, and where all quantities are watched: the one that tells modes apart and its rates first.

    Raises
    ------
    OutsideFragmentError    if that is no polynomial of the state, or the field is none
    """
    model = question.model
    known = model.definitions[0]
    rates, _ = fields(model, model.modes[0])
    first = rate(counted.quantity, rates, known)
    watched = Watched(Tape({n: i for i, n in enumerate(model.names)}, known))
    places: dict[Expr, int] = {}
    outputs: list[int] = []

    def watch(quantity: Expr) -> None:
        if quantity not in places:
            places[quantity] = len(outputs)
            outputs.append(watched.tape.add(quantity))

    told = [counted.quantity, first, rate(first, rates, known)]
    for e in told:
        outputs.append(watched.tape.add(e))
    for c in (*question.judged.dwelling, question.judged.window):
        for atom in atoms(c):
            watch(atom.quantity)
    true = watched.words(True)
    return (question.modes[0][0], [], watched.tape.listing(outputs), [], [], true, true, true, []), places


def _is_shown(
    question: Question, counted: Counted, stages: Sequence[Stage], start: int, places: Mapping[Expr, int]
) -> bool:
    """Whether the claim holds in every mode that is possible at each part of a flowpipe."""
    possible = frozenset({start})
    for part in _parts(stages):
        found = _through(counted, possible, part)
        if found is None:
            return False
        visited, possible = found
        for stage in part:
            for mode in visited:
                both = Every((question.judged.dwelling[mode], question.judged.window))
                if truth(both, stage.watched, places) is not True:
                    return False
    return True


def _parts(stages: Sequence[Stage]) -> Iterator[list[Stage]]:
    """Connected parts of a flowpipe: in each the quantity has one sign certainly, or one kind of way through zero."""
    part: list[Stage] = []
    for stage in stages:
        is_sure = _sign([stage]) != 0
        if part and (is_sure or _way([*part, stage]) is None):
            yield part
            part = []
        if is_sure:
            yield [stage]
        else:
            part.append(stage)
    if part:
        yield part


def _sign(part: Sequence[Stage]) -> int:
    return _common([s.watched[0] for s in part])


def _common(ranges: Sequence[Pair]) -> int:
    """The sign that all numbers of some ranges have; 0 if there is none."""
    return 1 if all(low > 0 for low, _ in ranges) else -1 if all(high < 0 for _, high in ranges) else 0


def _way(part: Sequence[Stage]) -> tuple[str, int] | None:
    """How the quantity goes through zero, if at all: with a rate of one sign, or bent to one side."""
    slope, bend = _common([s.watched[1] for s in part]), _common([s.watched[2] for s in part])
    return ("slope", slope) if slope else ("bend", bend) if bend else None


def _through(counted: Counted, before: Modes, part: Sequence[Stage]) -> tuple[Modes, Modes] | None:
    """The modes that are visited in a part, and those possible after it; None where nothing bounds the jumps."""
    sign = _sign(part)
    if sign:
        # In a mode of the other sign no run is here: it had to jump before.
        kept = frozenset(m for m in before if counted.signs[m] == sign)
        return kept, kept
    way = _way(part)
    if way is None:
        return None
    found = set(before)
    for mode in before:
        kind, turned = way
        may_leave = counted.signs[mode] != turned if kind == "slope" else True
        once = counted.following[mode] if may_leave else frozenset()
        found |= once
        if kind == "bend" and counted.signs[mode] == turned:
            found |= {m for o in once for m in counted.following[o]}
    return frozenset(found), frozenset(found)


def truth(c: Condition, ranges: Sequence[Pair], places: Mapping[Expr, int]) -> bool | None:
    """The truth of a condition for all values in some ranges; None if it is not the same for all."""
    if isinstance(c, bool):
        return c
    if isinstance(c, Atom):
        low, high = ranges[places[c.quantity]]
        return _compared(c.op, low, high)
    found = [truth(m, ranges, places) for m in c.members]
    decisive = not isinstance(c, Every)
    if decisive in found:
        return decisive
    return None if None in found else not decisive


def _compared(op: str, low: float, high: float) -> bool | None:
    if op in ("==", "!="):
        found = True if low == high == 0 else False if low > 0 or high < 0 else None
        return found if op == "==" or found is None else not found
    if op in (">", ">="):
        low, high = -high, -low
    if op in ("<", ">"):
        return True if high < 0 else False if low >= 0 else None
    return True if high <= 0 else False if low > 0 else None
