"""Facts about a clock-driven automaton that hold whatever is claimed: for findings, cheap and exact.

`facts(spec, automaton)` explores the cells of all runs once. Nothing here rests on closing a strict bound: an edge is
said never to be enabled only where its guard, as written, leaves nothing of the cells, and a lock only where a run, as
written, is stuck.
"""

from __future__ import annotations

from fractions import Fraction

from haverify.analyses.bounds import EVERYTHING, Interval
from haverify.analyses.cell import moved
from haverify.analyses.clocked import Cells, leave, start_box
from haverify.analyses.context import Context
from haverify.analyses.counterexample import Explorer, defaults
from haverify.analyses.motion import Motion
from haverify.analyses.placement import place
from haverify.analyses.violation import stuck_after
from haverify.maths.polynomial import Polynomial
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.parts import edge_names
from haverify.obligations.translate import OutsideFragmentError, Scope
from haverify.text.record import record

Q = Fraction


@record
class Lock:
    """A state in which a run is stuck: the mode, the values of the variables, the time (s), the edges that
    fail there."""

    mode: str
    values: tuple[tuple[str, Q], ...]
    time: Q
    edges: tuple[str, ...]


@record
class OutputRange:
    """The range of an output in a mode over all reached states; ends are exact or enclosed outwards."""

    mode: str
    output: str
    low: Q
    high: Q
    at_low: Q | None  # the value of the clock there, where one variable alone moves
    at_high: Q | None


@record
class OutputJump:
    """How much an output changes at an edge (value after minus value before), over all ways to take it."""

    edge: int
    where: str
    output: str
    low: Q
    high: Q


@record
class ClockFacts:
    """What is known of the runs. `complete` is False where the cells are not those of all runs (then less is said)."""

    reached: dict[str, dict[str, tuple[Q | None, Q | None]]]  # mode -> variable -> interval of its reached values
    has_start: bool
    unreachable: tuple[str, ...]
    never_enabled: tuple[int, ...]  # edges of reached modes
    locks: tuple[Lock, ...]
    ranges: tuple[OutputRange, ...]
    jumps: tuple[OutputJump, ...]
    complete: bool


def facts(spec: Spec, automaton: HybridAutomaton) -> ClockFacts | None:
    """The facts about an automaton, None where it is not clock-driven."""
    context = Context(spec, automaton, core={})
    try:
        cells = context.cells()
        return _facts(context, cells)
    except OutsideFragmentError:
        return None


def _facts(context: Context, cells: Cells) -> ClockFacts:
    model, complete = context.model, cells.trouble is None or cells.trouble[0] == "window"
    starts = any(
        start_box(model, init, i, strict=True) is not None
        for init in context.automaton.init
        for i in (range(len(context.automaton.modes)) if init.mode is None else [model.index[init.mode]])
    )
    reached = {m.name: _reached(cells, i) for i, m in enumerate(context.automaton.modes) if cells.of_mode(i)}
    unreachable = tuple(m.name for m in context.automaton.modes if m.name not in reached) if complete else ()
    never = tuple(k for k in range(len(context.automaton.edges)) if complete and _never(cells, k))
    return ClockFacts(
        reached,
        starts and next(Motion(model, defaults(model)).starts(), None) is not None,
        unreachable,
        never,
        tuple(_locks(context)),
        tuple(_ranges(context, cells)),
        tuple(_jumps(context, cells)),
        complete,
    )


def _reached(cells: Cells, mode: int) -> dict[str, tuple[Q | None, Q | None]]:
    found: dict[str, Interval] = {}
    m = cells.model.mode(mode)
    for i in cells.of_mode(mode):
        cell = cells.cells[i]
        for v, entry in cell.entry.items():
            x = moved(entry, m.slopes[v], Q(0), cell.dwell).meet((m.allowed or {}).get(v, EVERYTHING))
            found[v] = found[v].hull(x) if v in found else x
    return {v: (x.low, x.high) for v, x in found.items()}


def _never(cells: Cells, k: int) -> bool:
    """Whether the edge's mode is reached and its guard, as written, leaves nothing there."""
    edge = cells.model.edge(k)
    inside = cells.of_mode(edge.source)
    return bool(inside) and all(leave(cells.model, cells.cells[i], edge, None, strict=True) is None for i in inside)


def _locks(context: Context) -> list[Lock]:
    """Stuck states on runs under the default params, one for each mode."""
    model = context.model
    explorer = Explorer(Motion(model, defaults(model)), None, False)
    found: dict[int, Lock] = {}
    for seen, node in enumerate(explorer.everywhere()):
        if seen > 4 * len(context.automaton.modes) + 16:
            break
        state = node.state
        if state.mode in found or model.mode(state.mode).terminal:
            continue
        end = stuck_after(explorer, state)
        if end is not None:
            at = explorer.motion.at(state, end)
            names = tuple(context.automaton.edges[k].name for k in model.leaving[state.mode])
            found[state.mode] = Lock(context.automaton.modes[state.mode].name, tuple(at.values.items()), at.time, names)
    return list(found.values())


def _ranges(context: Context, cells: Cells) -> list[OutputRange]:
    found: dict[tuple[int, str], OutputRange] = {}
    for cell in cells.cells:
        scope = context.model.timed_scope(cell.mode)
        placement = place(context.model, cell, None, {})
        if not placement.bounded:
            continue
        for name, p in _polynomials(scope):
            placed = placement.apply(p)
            if len(placed.variables) > 1:
                continue
            one = _range_of(context, cell.mode, name, placed, placement.box)
            old = found.get((cell.mode, name))
            found[cell.mode, name] = one if old is None else _wider(old, one)
    return list(found.values())


def _polynomials(scope: Scope) -> list[tuple[str, Polynomial]]:
    found = []
    for name, (type_, _) in scope.lets.items():
        if type_ == "real":
            try:
                cases = scope.let(name)
            except OutsideFragmentError:
                continue
            if len(cases) == 1 and cases[0].condition is True and (d := cases[0].denominator.constant):
                found.append((name, cases[0].numerator.scaled(1 / d)))
    return found


def _range_of(context: Context, mode: int, name: str, p: Polynomial, box: object) -> OutputRange:
    where = context.automaton.modes[mode].name
    if not p.variables:
        value = p.constant or Q(0)
        return OutputRange(where, name, value, value, None, None)
    assert isinstance(box, dict), "a placement's box is a dictionary"
    low, high = context.ranges.extremes(p, box)
    return OutputRange(where, name, low.low, high.high, low.at, high.at)


def _wider(a: OutputRange, b: OutputRange) -> OutputRange:
    low = a if a.low <= b.low else b
    high = a if a.high >= b.high else b
    return OutputRange(a.mode, a.output, low.low, high.high, low.at_low, high.at_high)


def _jumps(context: Context, cells: Cells) -> list[OutputJump]:
    """The jumps of outputs that are polynomials in both modes."""
    names = edge_names(context.automaton.edges)
    found: dict[tuple[int, str], OutputJump] = {}
    for k, edge in enumerate(context.automaton.edges):
        source, target = context.model.index[edge.source], context.model.index[edge.target]
        before = dict(_polynomials(context.model.timed_scope(source)))
        exits = [(i, out) for i in cells.of_mode(source) if (out := cells.exit(i, k)) is not None]
        if not exits:
            continue
        landing = context.model.landing(k).landing
        assert landing is not None, "the scope of a jump"
        for name, p in _polynomials(context.model.timed_scope(target)):
            for i, out in exits if name in before else ():
                placement = place(context.model, cells.cells[i], out, {})
                change = placement.apply(p.substitute(landing.assigned) - before[name])
                if placement.bounded and all(v in placement.box for v in change.variables):
                    low, high = context.ranges.bounds(change, placement.box)
                    old = found.get((k, name))
                    low, high = (low, high) if old is None else (min(low, old.low), max(high, old.high))
                    found[k, name] = OutputJump(k, names[k], name, low, high)
    return list(found.values())
