"""What P of `cycle through P` says: the sections it pins, and whether all runs of a lap pass one of them."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, Some, condition
from haverify.analyses.hybrid.listing import BEFORE, landing_condition
from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.orbits.ranges import Ranges
from haverify.analyses.orbits.returns import OPENED, Box, Landing, is_moving
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, nodes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction


@record
class Crossed:
    """A section in a mode: a quantity that is zero there, and what else holds."""

    mode: str
    quantity: Expr
    rest: Condition


@record
class Landed:
    """A section of states right after an edge, and what holds there."""

    edge: int
    rest: Condition


Section = Crossed | Landed


def sections(model: HybridModel, claimed: Expr) -> list[Section]:
    """The sections that P pins (LANGUAGE S23).

    Raises
    ------
    OutsideFragmentError    if it has states that are on none: neither an equation nor a jump is asked for
    """
    found: list[Section] = []
    for number, mode in enumerate(model.modes):
        stay = condition(model.dwelling(claimed, number), model.definitions[number])
        if stay is not False:
            found.append(_crossed(mode.name, stay))
    names = {m.name for m in model.modes}
    is_about_jumps = any(n.op in ("jump", "jumped", "pre") for n in nodes(claimed))
    for k, e in enumerate(model.automaton.edges):
        if e.source in names and is_about_jumps:
            landed = landing_condition(model, k, claimed)
            if landed is not False:
                found.append(Landed(k, landed))
    return found


def _crossed(mode: str, stay: Condition) -> Crossed:
    members = list(_flat(stay))
    for k, m in enumerate(members):
        if isinstance(m, Atom) and m.op == "==":
            return Crossed(mode, m.quantity, Every((*members[:k], *members[k + 1 :])))
    raise OutsideFragmentError(
        "`cycle through` of what is no section: an equation, or `jump(e)`, has to be one part of it"
    )


def _flat(c: Condition) -> list[Condition]:
    if isinstance(c, Every):
        return [x for m in c.members for x in _flat(m)]
    return [] if c is True else [c]


def passes_landing(model: HybridModel, section: Landed, jump: Landing) -> bool:
    """Whether a jump of all runs of a lap certainly lands in the section."""
    if jump.edge != section.edge:
        return False
    target = model.automaton.edges[jump.edge].target
    before = {BEFORE + n: x for n, x in jump.before.items()}
    return _holds(model, target, section.rest, {**jump.after, **before, "time": jump.time})


def passes_crossing(model: HybridModel, section: Crossed, state: Box, time: Interval) -> bool:
    """Whether all states at which a lap comes to the section are in it, and cross it at a certain speed."""
    box = {**state, "time": time}
    return is_moving(model, section.mode, section.quantity, box) and _holds(model, section.mode, section.rest, box)


def _holds(model: HybridModel, mode: str, c: Condition, box: Mapping[str, Interval]) -> bool:
    return Ranges(box, model.definitions[model.mode(mode)]).truth(_inner(c)) is True


def _inner(c: Condition) -> Condition:
    """The condition with its bounds opened: where it holds, it holds nearby as well."""
    if isinstance(c, bool):
        return c
    if isinstance(c, Atom):
        return Atom(c.quantity, OPENED[c.op])
    members = tuple(_inner(m) for m in c.members)
    return Every(members) if isinstance(c, Every) else Some(members)
