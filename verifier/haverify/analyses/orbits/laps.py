"""An automaton cut open: runs start in one mode, and end where a quantity is zero after a given time in another.

Copied for that: the mode in which they end, from the given time on, and one in which nothing moves. With columns, the
derivative of the state after the start by variables of the start is part of the state: between jumps the variational
equations, and at a jump, whose instant depends on the state, what is known as the saltation matrix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, condition
from haverify.analyses.hybrid.expansion import Place
from haverify.analyses.hybrid.model import Definitions, HybridModel
from haverify.model.expression import TRUE, Expr, number, rebuild
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Mode, Range, Variable
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.derivative import ZERO, derivative, minus, over, plus, times
from haverify.text.record import record, replace

Q = Fraction
LATE, BACK, BEGIN = "late: ", "back", "begin"


@record
class Frame:
    """Coordinates w of a section: `x = centre + basis w` for some variables, under their names; others are given."""

    centre: Mapping[str, Q]
    basis: tuple[tuple[Q, ...], ...]
    back: tuple[tuple[Q, ...], ...]
    others: Mapping[str, Q]

    def outwards(self, old: Mapping[str, Expr]) -> dict[str, Expr]:
        """Variables as functions of coordinates."""
        moved = _mixed(self.basis, [old[v] for v in self.centre])
        found = {v: plus(number(c), m) for (v, c), m in zip(self.centre.items(), moved, strict=True)}
        return {**found, **{v: number(q) for v, q in self.others.items()}}

    def inwards(self, old: Mapping[str, Expr], is_slope: bool = False) -> dict[str, Expr]:
        """Coordinates as functions of variables; of derivatives, where they are slopes."""
        apart = [old[v] if is_slope else minus(old[v], number(c)) for v, c in self.centre.items()]
        return dict(zip(self.centre, _mixed(self.back, apart), strict=True))


def _mixed(rows: Sequence[Sequence[Q]], parts: Sequence[Expr]) -> list[Expr]:
    return [plus(*(times(number(q), e) if q else ZERO for q, e in zip(row, parts, strict=True))) for row in rows]


@record
class Cut:
    """Where runs start and end: modes, the quantity that is zero at the end, a time after which that counts.

    Where there is a frame, they start a second before time 0 with its coordinates, or end with these.
    `columns` are the variables of the start by which is derived, `borders` the quantities that are zero where an edge
    of the automaton is taken, by its number: of those on the way.
    """

    start: str
    end: str
    quantity: Expr
    after: Q
    columns: tuple[str, ...] = ()
    borders: Mapping[int, Expr] | None = None
    enters: Frame | None = None
    leaves: Frame | None = None


def derived(variable: str, by: str) -> str:
    """The name of a derivative."""
    return f"d {variable} by {by}"


def opened(model: HybridModel, cut: Cut) -> HybridAutomaton:
    """The automaton cut open; its first edges are those of the model's.

    Raises
    ------
    OutsideFragmentError    if it has choices, or no derivative is known
    """
    return _Opening(model, cut).automaton()


class _Opening:
    def __init__(self, model: HybridModel, cut: Cut) -> None:
        self.model, self.cut, self.of = model, cut, model.automaton
        self.names = [v.name for v in self.of.vars]
        self.rates = {m.name: self._rates(m) for m in model.modes}

    def automaton(self) -> HybridAutomaton:
        """The whole."""
        model, cut = self.model, self.cut
        modes = [self._mode(m, m.name) for m in model.modes]
        last = next(m for m in model.modes if m.name == cut.end)
        still = tuple(FlowLine(v, ZERO) for v in self._all())
        modes += [self._mode(last, LATE + last.name), Mode(BACK, TRUE, still, (), False)]
        modes += [Mode(BEGIN, TRUE, still, (), False)] if cut.enters else []
        leaving = [(k, e) for k, e in enumerate(self.of.edges) if e.source in self.rates]
        edges = [self._edge(k, e) for k, e in leaving]
        edges += [replace(e, source=LATE + cut.end) for (_, old), e in zip(leaving, edges, strict=True)
                  if old.source == cut.end]  # fmt: skip
        edges += [self._tick(), self._return(), *self._begin()]
        declared = {v.name: v.range for v in self.of.vars}
        variables = tuple(Variable(v, "real", None, declared.get(v)) for v in self._all())
        return replace(self.of, vars=variables, lets=(), init=(), modes=tuple(modes), edges=tuple(edges))

    def _all(self) -> list[str]:
        return [*self.names, *(derived(v, c) for c in self.cut.columns for v in self.names)]

    def _known(self, mode: str) -> Definitions:
        return self.model.definitions[self.model.mode(mode)]

    def _written(self, e: Expr, mode: str) -> Expr:
        """An expression in a mode without lets."""
        return written_out(residual(e, Situation(mode)), self._known(mode))

    def _rates(self, mode: Mode) -> dict[str, Expr]:
        found = dict.fromkeys(self.names, ZERO)
        for line in mode.flow:
            if isinstance(line.rate, Range):
                raise OutsideFragmentError("an inclusion, beside `cycle through`")
            found[line.var] = self._written(line.rate, mode.name)
        return found

    def _mode(self, mode: Mode, name: str) -> Mode:
        rates = self.rates[mode.name]
        lines = [FlowLine(v, rates[v]) for v in self.names]
        for c in self.cut.columns:
            lines += [FlowLine(derived(v, c), _along(rates[v], self._column(c))) for v in self.names]
        return Mode(name, self._written(mode.domain, mode.name), tuple(lines), (), mode.terminal)

    def _column(self, c: str) -> dict[str, Expr]:
        return {v: Expr("var", (derived(v, c),)) for v in self.names}

    def _edge(self, number_of: int, edge: Edge) -> Edge:
        resets = dict[str, Expr]()
        for a in edge.resets:
            if isinstance(a.to, Range):
                raise OutsideFragmentError("a reset with a choice, beside `cycle through`")
            resets[a.var] = self._written(a.to, edge.source)
        assigned = [Assign(v, e) for v, e in resets.items()]
        border = (self.cut.borders or {}).get(number_of)
        if border is not None:
            assigned += self._salted(edge.source, resets, self.rates[edge.target], self._written(border, edge.source))
        return replace(edge, guard=self._written(edge.guard, edge.source), resets=tuple(assigned))

    def _tick(self) -> Edge:
        """From a time on the end counts."""
        guard = Expr("==", (Expr("time"), number(self.cut.after)))
        return Edge(LATE, self.cut.end, LATE + self.cut.end, True, guard, ())

    def _return(self) -> Edge:
        cut = self.cut
        quantity = self._written(cut.quantity, cut.end)
        made = {a.var: a.to for a in self._salted(cut.end, {}, dict.fromkeys(self.names, ZERO), quantity)}
        slopes = {v: e for v, e in made.items() if isinstance(e, Expr)}
        if cut.leaves is not None:
            made |= cut.leaves.inwards(self._states())
            for c in cut.columns:
                column = cut.leaves.inwards({v: slopes[derived(v, c)] for v in self.names}, is_slope=True)
                made |= {derived(v, c): e for v, e in column.items()}
        resets = tuple(Assign(v, e) for v, e in made.items())
        return Edge(BACK, LATE + cut.end, BACK, True, Expr("==", (quantity, ZERO)), resets)

    def _begin(self) -> list[Edge]:
        """From coordinates to what they stand for."""
        frame, columns = self.cut.enters, self.cut.columns
        if frame is None:
            return []
        made = frame.outwards(self._states())
        for k, c in enumerate(columns):
            made |= {derived(v, c): number(row[k]) for v, row in zip(frame.centre, frame.basis, strict=True)}
        resets = tuple(Assign(v, e) for v, e in made.items())
        return [Edge(BEGIN, BEGIN, self.cut.start, True, Expr("==", (Expr("time"), ZERO)), resets)]

    def _states(self) -> dict[str, Expr]:
        return {v: Expr("var", (v,)) for v in self.names}

    def _salted(self, source: str, resets: Mapping[str, Expr], after: Mapping[str, Expr], border: Expr) -> list[Assign]:
        """The derivatives after a jump where `border` is zero.

        With the reset r, the rates f before and g after it: `Dr V + (Dr f - g(r)) t`, where the jump is made later by
        `t = -(D border V) / (D border f)`.
        """
        found, before = [], self.rates[source]
        wanted = {**self._states(), **resets}
        speed = _along(border, before)
        for c in self.cut.columns:
            column = self._column(c)
            later = over(Expr("neg", (_along(border, column),)), speed)
            for v in self.names:
                apart = minus(_along(wanted[v], before), _replaced(after[v], wanted))
                found.append(Assign(derived(v, c), plus(_along(wanted[v], column), times(apart, later))))
        return found


def modelled(model: HybridModel, automaton: HybridAutomaton) -> HybridModel:
    """An automaton without lets, made of another, as the flowpipe analyses see it; its starts are given elsewhere."""
    names = (*(v.name for v in automaton.vars), *model.names[len(model.automaton.vars) :])
    known = {k: e for k, e in model.definitions[0].items() if k[0] == "const"}
    variables = tuple(v.name for v in automaton.vars)
    places = tuple(Place(m.name) for m in automaton.modes)
    return HybridModel(
        model.spec, automaton, model.values, automaton.modes, names, (), (known,) * len(places), (), (), variables,
        places, tuple(range(len(automaton.edges))),
    )  # fmt: skip


def speed_of(model: HybridModel, mode: str, quantity: Expr) -> Expr:
    """How fast a quantity changes along the flow of a mode.

    Raises
    ------
    OutsideFragmentError    if no derivative of it is known
    """
    known = model.definitions[model.mode(mode)]
    of = next(m for m in model.modes if m.name == mode)
    lines = {line.var: line.rate for line in of.flow}
    rates = {v: written_out(residual(e, Situation(mode)), known) for v, e in lines.items() if isinstance(e, Expr)}
    return _along(written_out(residual(quantity, Situation(mode)), known), rates)


def _along(e: Expr, rates: Mapping[str, Expr]) -> Expr:
    return derivative(e, rates, _undefined)


def _undefined(e: Expr) -> Expr:
    raise OutsideFragmentError(f"the derivative of `{e.op}`")


def written_out(e: Expr, definitions: Definitions) -> Expr:
    """An expression with its lets and constants written out."""
    if e.op in ("let", "const") and (e.op, e.name) in definitions:
        return written_out(definitions[e.op, e.name], definitions)
    return rebuild(e, lambda c: written_out(c, definitions))


def _replaced(e: Expr, values: Mapping[str, Expr]) -> Expr:
    if e.op == "var":
        return values.get(e.name, e)
    return rebuild(e, lambda c: _replaced(c, values))


def guard_atoms(model: HybridModel, edge: Edge) -> list[Atom]:
    """The comparisons of a guard that is a conjunction.

    Raises
    ------
    OutsideFragmentError    if it is none
    """
    at = model.mode(edge.source)
    found = condition(residual(edge.guard, Situation(edge.source)), model.definitions[at])
    return list(_members(found))


def _members(c: Condition) -> list[Atom]:
    if isinstance(c, Atom):
        return [c]
    if c is True:
        return []
    if isinstance(c, Every):
        return [a for m in c.members for a in _members(m)]
    raise OutsideFragmentError("a guard on a periodic orbit that is no conjunction")
