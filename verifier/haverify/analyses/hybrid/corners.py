"""Functions with corners in flows and resets (`abs`, `min`, `max`, `clamp`, `if`): a mode once for each of their sides.

On its side a mode's domain says which branch is meant, and the field there is smooth. Both branches agree where a side
ends (LANGUAGE S7), so that a change of side changes nothing but the formula: it is an edge without a reset.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from haverify.analyses.hybrid.conditions import COMPARISONS, MIRRORED, Definitions, branches, in_pairs, replaced
from haverify.analyses.hybrid.expansion import Expanded, both, simplified
from haverify.maths.polynomial import variable
from haverify.model.expression import Expr, nodes, rebuild
from haverify.model.hybrid import Assign, Edge, FlowLine, Init, Mode, Range
from haverify.obligations.constants import Values
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError, Scope
from haverify.text.record import holder, record, replace

Q = Fraction
CORNERS = ("abs", "min", "max", "clamp", "if")
MOST_SIDES = 16  # of one mode or edge
BEYOND = {"<=": ">", ">=": "<"}
ZERO = Expr("num", (Q(0),))


@record
class Side:
    """A choice of branches: conditions that say where it is meant, and the formulas with these branches."""

    where: tuple[Expr, ...]
    formulas: tuple[Expr, ...]


def without_corners(found: Expanded, values: Values) -> Expanded:
    """The automaton with modes of their own for the sides of corners.

    Raises
    ------
    OutsideFragmentError    if there are too many sides, or the branches of an `if` were not shown to agree
    """
    automaton = found.automaton
    told = [e for m in automaton.modes for f in m.flow for e in _ends(f.rate)]
    told += [e for o in automaton.edges for a in o.resets for e in _ends(a.to)]
    lets = [o.expr for o in (*automaton.lets, *(o for m in automaton.modes for o in m.lets))]
    if not any(n.op in CORNERS for e in (*told, *lets) for n in nodes(e)):
        return found
    return _Work(found, values).expanded()


def _ends(to: Expr | Range) -> tuple[Expr, ...]:
    return (to.low, to.high) if isinstance(to, Range) else (to,)


@holder
class _Work:
    given: Expanded
    values: Values

    def expanded(self) -> Expanded:
        automaton = self.given.automaton
        sides = {m.name: list(self._sides(m)) for m in automaton.modes}
        places = {n.name: self.given.places[m] for m, own in sides.items() for n, _ in own}
        edges: list[Edge] = []
        origins: list[int | None] = []
        for edge, origin in zip(automaton.edges, self.given.edges, strict=True):
            made = list(self._edges(edge, sides))
            edges += made
            origins += [origin] * len(made)
        for own in sides.values():
            changes = list(_changes(own))
            edges += changes
            origins += [None] * len(changes)
        init = [s for i in automaton.init for s in _starts(i, sides)]
        modes = tuple(n for own in sides.values() for n, _ in own)
        made_of = replace(automaton, init=tuple(init), modes=modes, edges=tuple(edges))
        return Expanded(made_of, places, tuple(origins))

    def _sides(self, mode: Mode) -> Iterator[tuple[Mode, tuple[Expr, ...]]]:
        """A mode once for each side, and what says where it is meant."""
        lets, at = self._lets(mode), Situation(self.given.places[mode.name].mode)
        formulas = tuple(in_pairs(residual(e, at), lets) for f in mode.flow for e in _ends(f.rate))
        found = self._split(Side((), formulas))
        for number, side in enumerate(found):
            parts = iter(side.formulas)
            flow = tuple(
                FlowLine(f.var, Range(next(parts), next(parts)) if isinstance(f.rate, Range) else next(parts), f.span)
                for f in mode.flow
            )
            name = mode.name if len(found) == 1 else f"{mode.name} (side {number})"
            yield replace(mode, name=name, domain=both([mode.domain, *side.where]), flow=flow), side.where

    def _lets(self, mode: Mode) -> Definitions:
        at = Situation(self.given.places[mode.name].mode)
        return {("let", o.name): residual(o.expr, at) for o in (*self.given.automaton.lets, *mode.lets)}

    def _edges(self, edge: Edge, sides: Mapping[str, list[tuple[Mode, tuple[Expr, ...]]]]) -> Iterator[Edge]:
        """An edge from each side to each side, once for each side of what it writes."""
        old = next(m for m in self.given.automaton.modes if m.name == edge.source)
        lets, at = self._lets(old), Situation(self.given.places[old.name].mode)
        formulas = tuple(in_pairs(residual(e, at), lets) for a in edge.resets for e in _ends(a.to))
        for side in self._split(Side((), formulas)):
            parts = iter(side.formulas)
            resets = tuple(
                Assign(a.var, Range(next(parts), next(parts)) if isinstance(a.to, Range) else next(parts), a.span)
                for a in edge.resets
            )
            guard = both([edge.guard, *side.where])
            for source, _ in sides[edge.source]:
                for target, _ in sides[edge.target]:
                    yield replace(edge, source=source.name, target=target.name, guard=guard, resets=resets)

    def _split(self, side: Side) -> list[Side]:
        """The sides of all corners in some formulas."""
        waiting, found = [side], list[Side]()
        while waiting:
            one = waiting.pop()
            corner = next((c for e in one.formulas for c in _innermost(e)), None)
            if corner is None:
                found.append(one)
            else:
                waiting += self._branches(one, corner)
            if len(waiting) + len(found) > MOST_SIDES:
                raise OutsideFragmentError("`abs`, `min`, `max` or `if` with too many sides together, in one flow")
        return found

    def _branches(self, side: Side, corner: Expr) -> Iterator[Side]:
        for where, branch in self._cases(corner):
            if where.op != "false":
                formulas = tuple(simplified_all(replaced(e, corner, branch)) for e in side.formulas)
                yield Side(side.where if where.op == "true" else (*side.where, where), formulas)

    def _cases(self, corner: Expr) -> Iterator[tuple[Expr, Expr]]:
        """The branches of a corner, and where each is meant: both include the border, where they agree."""
        if corner.op == "if":
            yield from self._choice(corner)
            return
        if any(n.op == "input" for n in nodes(corner)):
            raise OutsideFragmentError(f"`{corner.op}` of an input, beside a flow that is not clock-driven")
        first, second = branches(corner)
        over = ZERO if corner.op == "abs" else second
        yield self._compared(first, "<=" if corner.op == "min" else ">=", over), first
        yield self._compared(first, ">=" if corner.op == "min" else "<=", over), second

    def _compared(self, left: Expr, op: str, right: Expr) -> Expr:
        """A comparison, decided where both sides are numbers."""
        made = Expr(op, (left, right))
        try:
            numbers = [Expr("num", (self.values.number(e),)) for e in (left, right)]
        except OutsideFragmentError:
            return made
        return simplified(Expr(op, tuple(numbers)))

    def _choice(self, corner: Expr) -> Iterator[tuple[Expr, Expr]]:
        condition, yes, no = corner.children
        if condition.op not in COMPARISONS or condition.op in ("==", "!="):
            raise OutsideFragmentError("an `if` in a flow or a reset whose condition is no single comparison")
        left, right = condition.children
        if any(n.op == "input" for n in nodes(condition)):
            raise OutsideFragmentError("an `if` on an input, beside a flow that is not clock-driven")
        if not self._agree(left, right, yes, no):
            raise OutsideFragmentError(
                "an `if` whose branches were not shown to agree at its border (LANGUAGE S7): switch between modes"
            )
        op = ">=" if condition.op in (">", ">=") else "<="
        yield self._compared(left, op, right), yes
        yield self._compared(left, MIRRORED[op], right), no

    def _agree(self, left: Expr, right: Expr, yes: Expr, no: Expr) -> bool:
        """Whether two branches are equal where two expressions are, of which one is a variable that the other lacks."""
        for x, meant in ((left, right), (right, left)):
            if x.op == "var" and x not in set(nodes(meant)):
                try:
                    gap = Expr("-", (replaced(yes, x, meant), replaced(no, x, meant)))
                    return self._scope(gap).polynomial(gap).constant == 0
                except OutsideFragmentError:
                    return False
        return False

    def _scope(self, e: Expr) -> Scope:
        """A scope in which variables, params and time are symbols."""
        scope = self.values.scope("an `if`")
        names = {n.name: variable(n.name) for n in nodes(e) if n.op in ("var", "param")}
        return replace(scope, variables=names)


def _changes(own: list[tuple[Mode, tuple[Expr, ...]]]) -> Iterator[Edge]:
    """The changes from each side of a mode to each other, due where the side would be left that the other lacks."""
    for source, mine in own:
        for target, its in own:
            border = next((c for c in mine if Expr(MIRRORED[c.op], c.args) in its), None)
            if source is not target and border is not None:
                guard = Expr(BEYOND[border.op], border.args)
                yield Edge("", source.name, target.name, True, guard, ())


def _starts(init: Init, sides: Mapping[str, list[tuple[Mode, tuple[Expr, ...]]]]) -> Iterator[Init]:
    for mode, own in sides.items():
        if init.mode in (None, mode):
            for side, where in own:
                yield replace(init, mode=side.name, where=both([init.where, *where]))


def _innermost(e: Expr) -> Iterator[Expr]:
    """The corners of an expression that hold no others."""
    for n in nodes(e):
        if n.op in CORNERS and not any(m.op in CORNERS for c in n.children for m in nodes(c)):
            yield n


def simplified_all(e: Expr) -> Expr:
    """An expression with all its parts simplified."""
    return simplified(rebuild(e, simplified_all))
