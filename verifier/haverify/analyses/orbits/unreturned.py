"""That no run from P returns to where it started: all of them are followed, beside a memory of their starts."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, Some, condition
from haverify.analyses.hybrid.goal import window
from haverify.analyses.hybrid.listing import Judged, landing_condition, listings
from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.hybrid.starts import Box as Sides
from haverify.analyses.hybrid.starts import cut
from haverify.analyses.orbits.basin import Part
from haverify.analyses.orbits.laps import BEGIN, modelled, speed_of
from haverify.analyses.orbits.passing import Crossed
from haverify.maths.interval import Fault, Interval
from haverify.model.expression import TRUE, Expr, number
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Mode, Variable
from haverify.solvers.kernel import Budget, Settings, Stretch, grown, stretches
from haverify.text.record import replace

Q = Fraction
ZERO, TIME = number(0), Expr("time")
HALVINGS = (0, 2, 4)
FIRST = (Q(1, 20), Q(1, 200))  # of the time allowed: so long runs move away from the section
STRETCHES, JUMPS, CUTS, STEPS = 60, 60, 1, 1000
MOVED = ("horizon", "jumped", "cut", "left")  # ends of stretches that leave no run out


def never_returns(model: HybridModel, claimed: Expr, area: Part, last: Q) -> bool:
    """Whether no run from the states of an area with P returns to its start within a time."""
    begun = _remembering(model, area.mode)
    crossed = area.section if isinstance(area.section, Crossed) else None
    for first in FIRST if crossed else (Q(0),):
        for n in HALVINGS:
            if all(
                _is_gone(model, begun, claimed, crossed, area.mode, piece, first * last, last)
                for piece in cut(area.box, n)
            ):
                return True
    return False


def remembered(variable: str) -> str:
    """The name of a variable's value at the start."""
    return f"{variable} at the start"


def _remembering(model: HybridModel, mode: str) -> HybridModel:
    """The automaton with the values at the start; that is made at time 0 by an edge that follows those of the model."""
    of, names = model.automaton, [v.name for v in model.automaton.vars]
    kept = tuple(FlowLine(remembered(v), ZERO) for v in names)
    still = tuple(FlowLine(v, ZERO) for v in names) + kept
    modes = [*(replace(m, flow=(*m.flow, *kept)) for m in model.modes), Mode(BEGIN, TRUE, still, (), False)]
    made = tuple(Assign(remembered(v), Expr("var", (v,))) for v in names)
    begin = Edge(BEGIN, BEGIN, mode, True, Expr("==", (TIME, ZERO)), made)
    memory = tuple(Variable(remembered(v), "real", None, None) for v in names)
    automaton: HybridAutomaton = replace(of, vars=(*of.vars, *memory), modes=tuple(modes), edges=(*of.edges, begin))
    found = modelled(model, automaton)
    return replace(found, definitions=(*model.definitions, found.definitions[0]))


def _is_gone(
    model: HybridModel,
    begun: HybridModel,
    claimed: Expr,
    crossed: Crossed | None,
    mode: str,
    piece: Sides,
    first: Q,
    last: Q,
) -> bool:
    """Whether runs from a box of starts move away from the section at first, and meet their starts no more."""
    at = model.mode(mode)
    apart = tuple(Atom(Expr("-", (Expr("var", (v.name,)), Expr("var", (remembered(v.name),)))), "!=")
                  for v in model.automaton.vars)  # fmt: skip
    late, early = (Atom(Expr("-", (TIME, number(q))), op) for q, op in ((last, ">"), (first, "<")))
    stay = condition(model.dwelling(claimed, at), model.definitions[at], is_denied=True)
    dwelling: list[Condition] = [True] * len(begun.modes)
    dwelling[at] = Some((stay, late, early, *apart))
    landing: dict[int, Condition] = dict.fromkeys(range(len(begun.automaton.edges)), True)
    for k, e in enumerate(model.automaton.edges):
        if e.target == mode and any(m.name == e.source for m in model.modes):
            landing[k] = Some((landing_condition(begun, k, claimed, is_denied=True), late, *apart))
    return _holds(begun, dwelling, landing, piece, last) and (
        crossed is None or _moves(model, begun, crossed, at, piece, first)
    )


def _moves(model: HybridModel, begun: HybridModel, crossed: Crossed, at: int, piece: Sides, first: Q) -> bool:
    """Whether the quantity of the section moves one way, and no jump is made, for a while."""
    speed = speed_of(model, crossed.mode, crossed.quantity)
    begin = len(begun.automaton.edges) - 1
    for sign in "<>":
        dwelling: list[Condition] = [False] * len(begun.modes)
        dwelling[at], dwelling[-1] = Some((Atom(speed, sign), Atom(Expr("-", (TIME, number(first))), ">"))), True
        landing: dict[int, Condition] = {**dict.fromkeys(range(begin), False), begin: True}
        if _holds(begun, dwelling, landing, piece, first):
            return True
    return False


def _holds(
    begun: HybridModel, dwelling: Sequence[Condition], landing: dict[int, Condition], piece: Sides, last: Q
) -> bool:
    """Whether a condition holds along all runs from a box of starts, up to some time."""
    nothing = tuple(() for _ in begun.modes)
    modes = listings(begun, Judged(tuple(dwelling), landing, Every(tuple(window(begun))), nothing, nothing))
    count = len(piece) - (len(begun.names) - 1 - len(begun.automaton.vars))
    known = [*piece[:count], *[(Q(0), Q(0))] * count, *piece[count:]]
    sides = [Interval.between(*ends) for ends in known]
    given = begun.mode(BEGIN), [*((x.low, x.high) for x in sides), (-1.0, -1.0)], list[tuple[int, str]]()
    horizon = Interval.at(last).high
    settings = Settings(12, 3, 1e-9, 0.02, max(horizon / 32, 1e-3), horizon * 1e-9, STEPS, 5)
    try:
        tree = stretches(grown(modes, given, horizon, "horizon", settings, Budget(JUMPS, STRETCHES, CUTS)))
    except Fault:
        return False
    return all(_is_over(s) for s in tree)


def _is_over(s: Stretch) -> bool:
    landed = s.jump is None or s.jump.claim.holds
    return landed and s.end in MOVED and all(g.claim.holds and g.keeps_window for g in s.stages)
