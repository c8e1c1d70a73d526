"""Discrete variables beside flows: each mode once for each choice of their values that a run may have in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from itertools import product

from haverify.analyses.hybrid.chosen import choices_of
from haverify.analyses.hybrid.expansion import CONSTANT, Expanded, Known, Place, both, folded, unchanged
from haverify.model.expression import FALSE, TRUE, Expr, rebuild
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Init, Mode, Output, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, values_of
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, replace

Q = Fraction
MOST_PLACES = 128
Settled = tuple[tuple[str, Expr], ...]
Told = Callable[[Expr], Expr]
Case = tuple[Expr, Expr]  # where it holds, the value


def without_discrete(spec: Spec, automaton: HybridAutomaton) -> Expanded:
    """The automaton with modes of their own for the values of its discrete variables.

    Raises
    ------
    OutsideFragmentError    if these are too many, or one of them may get a value that its type does not have
    """
    if all(v.type == "real" for v in automaton.vars):
        return unchanged(automaton)
    types = {v.name: tuple(_values(spec, v.type)) for v in automaton.vars if v.type != "real"}
    return _Work(spec, automaton, values_of(spec, automaton), types).expanded()


def _values(spec: Spec, type_: str) -> Iterator[Expr]:
    """The values of a discrete type."""
    if type_ == "bool":
        yield from (FALSE, TRUE)
        return
    enum = next(e for e in spec.enums if e.name == type_)
    if enum.low is not None and enum.high is not None:
        yield from (Expr("num", (Q(i),)) for i in range(int(enum.low), int(enum.high) + 1))
    else:
        yield from (Expr("sym", (type_, v)) for v in enum.values)


@holder
class _Work:
    spec: Spec
    automaton: HybridAutomaton
    values: Values
    types: dict[str, tuple[Expr, ...]]
    places: dict[str, Place] = field(default_factory=dict)
    modes: list[Mode] = field(default_factory=list)

    def expanded(self) -> Expanded:
        starts = [self._start(i, m, s) for i in self.automaton.init for m in self._modes(i) for s in self._first(i)]
        edges: list[Edge] = []
        origins: list[int | None] = []
        done = 0
        while done < len(self.modes):
            mode = self.modes[done]
            done += 1
            for number, edge in enumerate(self.automaton.edges):
                if edge.source == self.places[mode.name].mode:
                    found = list(self._edges(edge, mode))
                    edges += found
                    origins += [number] * len(found)
        made = replace(
            self.automaton,
            vars=tuple(v for v in self.automaton.vars if v.type == "real"),
            lets=(),
            init=tuple(s for s in starts if s.where.op != "false"),
            modes=tuple(self.modes),
            edges=tuple(edges),
        )
        return Expanded(made, self.places, tuple(origins))

    def _modes(self, init: Init) -> list[str]:
        return [m.name for m in self.automaton.modes if init.mode in (None, m.name)]

    def _first(self, init: Init) -> Iterator[Settled]:
        """The choices of values at a start."""
        given = {a.var: a.to for a in init.assigns}
        sets = [tuple(self._given(v, given[v])) if v in given else of for v, of in self.types.items()]
        yield from (tuple(zip(self.types, chosen, strict=True)) for chosen in product(*sets))

    def _given(self, name: str, to: Expr | Range) -> Iterable[Expr]:
        if isinstance(to, Range):
            low, high = self.values.interval(to)
            return [v for v in self.types[name] if v.op == "num" and low <= Q(str(v.args[0])) <= high]
        return [self._typed(name, value) for _, value in self._cases(self._constants(to))]

    def _typed(self, name: str, value: Expr) -> Expr:
        """A value of a type, which a number may stand for."""
        known = self.types[name]
        if value not in known and value.op == "num" and known[0].op != "num":
            at = Q(str(value.args[0]))
            if at.denominator == 1 and 0 <= at < len(known):
                return known[int(at)]
        if value not in known:
            raise OutsideFragmentError(f"`{name}` may get a value that its type does not have")
        return value

    def _start(self, init: Init, mode: str, settled: Settled) -> Init:
        known = dict(settled)
        where = folded(residual(self._constants(init.where), Situation(mode)), known, {})
        if where.op == "false":
            return replace(init, mode=mode, where=where)
        assigns = tuple(self._real(a, known) for a in init.assigns if a.var not in known)
        return replace(init, mode=self._place(mode, settled), where=where, assigns=assigns)

    def _place(self, mode: str, settled: Settled) -> str:
        """The name of the mode for a choice of values, which is made where it is new."""
        name = f"{mode} ({', '.join(f'{v} = {e.args[-1] if e.args else e.op}' for v, e in settled)})"
        if name not in self.places:
            if len(self.modes) >= MOST_PLACES:
                raise OutsideFragmentError("discrete variables with too many values together, beside a flow")
            self._stay_declared(dict(settled))
            self.places[name] = Place(mode, settled)
            self.modes.append(self._mode(name, mode, dict(settled)))
        return name

    def _stay_declared(self, settled: Known) -> None:
        """Runs are followed in the declared ranges (LANGUAGE S4), which no place is to be outside of.

        Raises
        ------
        OutsideFragmentError    if a variable has a value outside of its range
        """
        for v in self.automaton.vars:
            if v.range is not None and v.name in settled:
                value, (low, high) = settled[v.name], self.values.interval(v.range)
                at = Q(str(value.args[0])) if value.op == "num" else Q(self.types[v.name].index(value))
                if not low <= at <= high:
                    raise OutsideFragmentError(f"`{v.name}` may leave its declared range")

    def _mode(self, name: str, mode: str, known: Known) -> Mode:
        old = next(m for m in self.automaton.modes if m.name == mode)
        at = Situation(mode)

        def told(e: Expr) -> Expr:
            return folded(residual(self._constants(e), at), known, lets)

        lets: dict[str, Expr] = {}
        written = [*self.automaton.lets, *old.lets]
        for _ in written:  # until those that read others are known as well
            lets.update({o.name: told(o.expr) for o in written})
        made = tuple(Output(o.name, o.type, o.unit, lets[o.name], o.span) for o in written)
        flow = tuple(
            FlowLine(f.var, Range(told(f.rate.low), told(f.rate.high)) if isinstance(f.rate, Range) else told(f.rate))
            for f in old.flow
        )
        return replace(old, name=name, domain=told(old.domain), flow=flow, lets=made)

    def _edges(self, edge: Edge, mode: Mode) -> Iterator[Edge]:
        """An edge from a mode, once for each choice of values it may lead to."""
        settled = self.places[mode.name].values
        known, lets, at = dict(settled), {o.name: o.expr for o in mode.lets}, Situation(self.places[mode.name].mode)

        def told(e: Expr) -> Expr:
            return folded(residual(self._constants(e), at), known, lets)

        guard = told(edge.guard)
        if guard.op == "false":
            return
        kept = tuple(self._real(a, known, told) for a in edge.resets if a.var not in known)
        chosen = {a.var: list(self._outcomes(a, told)) for a in edge.resets if a.var in known}
        for cases in product(*chosen.values()):
            where = both([guard, *(c for c, _ in cases)])
            if where.op == "false":
                continue
            after = {**known, **{v: self._typed(v, e) for v, (_, e) in zip(chosen, cases, strict=True)}}
            target = self._place(edge.target, tuple(after.items()))
            yield replace(edge, source=mode.name, target=target, guard=where, resets=kept)

    def _outcomes(self, assign: Assign, told: Told) -> Iterator[Case]:
        if isinstance(assign.to, Range):
            yield from ((TRUE, v) for v in self._given(assign.var, assign.to))
            return
        kind = next(v.type for v in self.automaton.vars if v.name == assign.var)
        for where, value in self._cases(told(assign.to)):
            if value.op == "fuzzy":
                found = choices_of(self.spec, self.automaton, self.values, value)
                yield from ((both([where, c]), Expr("sym", (kind, term))) for c, term in found)
            else:
                yield where, value

    def _cases(self, e: Expr) -> Iterator[Case]:
        """The values that an expression may have, and where."""
        if e.op in CONSTANT or e.op == "fuzzy":
            yield TRUE, e
        elif e.op == "if":
            condition, yes, no = e.children
            for where, branch in ((condition, yes), (Expr("not", (condition,)), no)):
                yield from ((both([where, c]), v) for c, v in self._cases(branch))
        elif e.op in ("and", "or", "not", "implies", "<", "<=", ">", ">=", "==", "!="):
            yield from ((e, TRUE), (Expr("not", (e,)), FALSE))
        else:
            raise OutsideFragmentError(f"a discrete variable that is set to a value of `{e.op}`, beside a flow")

    def _real(self, assign: Assign, known: Known, told: Told | None = None) -> Assign:
        def read(e: Expr) -> Expr:
            return told(e) if told is not None else folded(self._constants(e), known, {})

        to = assign.to
        return replace(assign, to=Range(read(to.low), read(to.high)) if isinstance(to, Range) else read(to))

    def _constants(self, e: Expr) -> Expr:
        """Constants of discrete types in an expression, replaced by their values."""
        if e.op == "const":
            meant = self.values.constants.get(e.name)
            is_discrete = meant is not None and meant.type != "real" and isinstance(meant.value, Expr)
            return self._constants(meant.value) if is_discrete else e  # type: ignore[union-attr,arg-type]
        return rebuild(e, self._constants)
