"""Robustness: by how much all comparisons of a formula may be tightened at once before it becomes false (LANGUAGE S21).

The robustness of a run is at least r where the formula still holds when every comparison has to hold by r, and at most
r where it fails when every one has to hold by more than r. Values that comparisons take at the ends of dwells and at
their extremes are tried first: most often one of them is the robustness itself, and its instant the one that matters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from haverify.analyses.clock_model import CLOCK
from haverify.analyses.goals import rounded_down
from haverify.analyses.motion import NOW
from haverify.analyses.poly_range import Ranges
from haverify.analyses.signals_formula import TEMPORAL, Formula
from haverify.analyses.signals_runs import Followed
from haverify.analyses.telling import decimal
from haverify.evidence.verdict import Margin
from haverify.model.expression import FALSE, TRUE, Expr, nodes, number
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import COMPARISONS, OutsideFragmentError
from haverify.text.record import record

Q = Fraction
Pairs = tuple[tuple[Expr, Expr], ...]
NARROW = Q(1, 10**9)
STEPS = 10  # halvings where no value of a comparison is the robustness
EVENTS = frozenset({"at", "jump", "jumped", "true", "false"})


@record
class Critical:
    """A value that a comparison takes at an instant of a run."""

    value: Q
    dwell: int
    after: Q


def unit_of(stl: Formula) -> str | None:
    """The unit that all comparisons share; None where they differ, or where something else than comparisons counts."""
    found: set[str] = set()
    for e in (x for a in stl.atoms for x in _leaves(a)):
        if not _measured(e):
            return None
        if e.op in COMPARISONS:
            found.add(next((str(c.unit) for c in e.children if c.unit is not None), ""))
    return found.pop() if len(found) == 1 else None


def _leaves(e: Expr) -> list[Expr]:
    if e.op in ("and", "or", "not", "implies"):
        return [x for c in e.children for x in _leaves(c)]
    return [e]


def _measured(e: Expr) -> bool:
    ordinary = not any(n.op in ("sym", "true", "false", "if") for n in nodes(e))
    return e.op in EVENTS or (e.op in COMPARISONS and ordinary)


def tightened(e: Expr, r: Q, closed: bool) -> Expr:
    """The condition that holds where `e` does by at least r (by more, where not closed)."""
    if e.op == "not":
        return Expr("not", (tightened(e.children[0], -r, not closed),))
    if e.op == "implies":
        return Expr("implies", (tightened(e.children[0], -r, not closed), tightened(e.children[1], r, closed)))
    if e.op in ("and", "or"):
        return Expr(e.op, tuple(tightened(c, r, closed) for c in e.children))
    return _comparison(e, r, closed) if e.op in COMPARISONS else e


def _comparison(e: Expr, r: Q, closed: bool) -> Expr:
    a, b = e.children
    by, op = number(r, a.unit or b.unit), "<=" if closed else "<"

    def below(x: Expr, y: Expr, far: Expr) -> Expr:
        return Expr(op, (Expr("+", (x, far), x.unit), y))

    if e.op in ("<", "<="):
        return below(a, b, by)
    if e.op in (">", ">="):
        return below(b, a, by)
    if e.op == "==":
        return FALSE if r > 0 else Expr("and", (below(a, b, by), below(b, a, by)))
    near = r < 0 or (closed and r == 0)
    return TRUE if near else Expr("or", (below(a, b, by), below(b, a, by)))


def pairs(stl: Formula, r: Q, closed: bool) -> Pairs:
    """The atoms for the question whether the robustness is at least (more than) r."""
    return tuple((tightened(a, r, closed), tightened(a, -r, not closed)) for a in stl.atoms)


def robustness(
    stl: Formula, examples: Iterable[Followed], everywhere: Callable[[Pairs], bool] | None, ranges: Ranges
) -> Margin | None:
    """The least robustness of some runs, and a bound for all where `everywhere` can tell; None where there is none.

    The first run counts; others where theirs is less.
    """
    unit = unit_of(stl)
    if unit is None:
        return None
    best: tuple[Q, Q, str] | None = None
    try:
        for run in examples:
            if best is None or run.holds(stl, pairs(stl, best[0], True)) is not True:
                low, high, at = _of_run(stl, run, criticals(stl, run, ranges))
                if low is not None and high is not None and (best is None or low < best[0]):
                    best = low, high, "" if at is None else _place(run, at)
        if best is None:
            return None
        low = best[0] if everywhere is None else _of_all(stl, best[0], everywhere)
    except OutsideFragmentError:
        return None
    return Margin(rounded_down(low), -rounded_down(-best[1]), unit, best[2])


def _of_run(stl: Formula, run: Followed, listed: Sequence[Critical]) -> tuple[Q | None, Q | None, Critical | None]:
    """Bounds of the robustness of one run, and the instant where they are a value of a comparison."""
    first, last = -1, len(listed)  # above the first value it is reached, at the last it is not
    while last - first > 1:
        middle = (first + last) // 2
        if run.holds(stl, pairs(stl, listed[middle].value, False)) is False:
            last = middle
        else:
            first = middle
    if last == len(listed):
        return None, None, None
    high = listed[last]
    if run.holds(stl, pairs(stl, high.value, True)) is True:
        return high.value, high.value, high
    for wider in range(3):  # values around a root are enclosures: those next to them may be needed
        below, above = listed[max(first - wider, 0)], listed[min(last + wider, len(listed) - 1)]
        if run.holds(stl, pairs(stl, below.value, True)) and run.holds(stl, pairs(stl, above.value, False)) is False:
            return _halved(stl, run, below, above)
    return None, None, None


def _halved(stl: Formula, run: Followed, below: Critical, above: Critical) -> tuple[Q, Q, Critical | None]:
    """Closer bounds, where values of comparisons leave more than rounding between them."""
    low, high = below.value, above.value
    if high - low < NARROW:
        return low, high, above
    for _ in range(STEPS):
        middle = (low + high) / 2
        if run.holds(stl, pairs(stl, middle, True)):
            low = middle
        elif run.holds(stl, pairs(stl, middle, False)) is False:
            high = middle
    return low, high, None


def _of_all(stl: Formula, best: Q, everywhere: Callable[[Pairs], bool]) -> Q:
    """The greatest of a few bounds that hold for all runs; 0 does."""
    if everywhere(pairs(stl, best, True)):
        return best
    low, high = Q(0), best
    for _ in range(STEPS // 2):
        middle = (low + high) / 2
        low, high = (middle, high) if everywhere(pairs(stl, middle, True)) else (low, middle)
    return low


def criticals(stl: Formula, run: Followed, ranges: Ranges) -> list[Critical]:
    """The values of comparisons where a dwell or a window after a jump ends and where they are extreme, and their
    opposites, in order."""
    found: dict[Q, Critical] = {}
    windows = {q for n in nodes(stl.whole) if n.op in TEMPORAL for q in stl.ends(n)}
    moments = sorted({n.state.time + q for n in run.nodes for q in windows})
    model, motion = run.motion.model, run.motion
    for n, (node, last) in enumerate(zip(run.nodes, run.dwells(), strict=True)):
        scope, replaced = model.timed_scope(node.state.mode), motion.replaced(node.state)
        at = Situation(model.automaton.modes[node.state.mode].name)
        for e in dict.fromkeys(x for a in stl.atoms for x in _leaves(residual(a, at)) if x.op in COMPARISONS):
            a, b = e.children
            p = scope.polynomial(Expr("-", (b, a))).fix(motion.params).substitute(replaced)
            seen = [t - node.state.time for t in moments if 0 < t - node.state.time < last]
            values = [(p.value({NOW: t, CLOCK: t}), t) for t in (Q(0), *seen, last)]
            if p.variables == (NOW,) and last > 0:
                values += [(q, x.at) for x in ranges.extremes(p, {NOW: (Q(0), last)}) for q in (x.low, x.high)]
            for value, t in values:
                for q in (value, -value):
                    found.setdefault(q, Critical(q, n, t))
    return [found[q] for q in sorted(found)]


def _place(run: Followed, at: Critical) -> str:
    state = run.motion.at(run.nodes[at.dwell].state, at.after)
    shown = [f"{v} = {decimal(x)}" for v, x in state.values.items() if v in run.motion.model.reals]
    mode = run.motion.model.automaton.modes[state.mode].name
    return ", ".join([mode, *shown, f"time = {decimal(state.time)} s"])
