"""Clock-driven automata: what the exact analyses know of one (docs/core.md section 4), or why it is none."""

from __future__ import annotations

from collections.abc import Mapping, Set
from fractions import Fraction
from functools import cached_property

from haverify.analyses.bounds import EVERYTHING, Box, Interval, narrow
from haverify.maths.bernstein import bounds as range_on
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Assign, HybridAutomaton, Mode, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, params_of, values_of
from haverify.obligations.formula import Formula, Junction, Literal, conjunction, disjunction
from haverify.obligations.indicator import chosen, indicator
from haverify.obligations.translate import Landing, OutsideFragmentError, Scope
from haverify.text.record import field, holder, record

Q = Fraction
DWELL, CLOCK = "@s", "@sigma"  # the box variables of certificates: scaled dwell and time at entry; no user names
RESERVED = frozenset({DWELL, CLOCK, "pi"})
PI = (Q(103993, 33102), Q(104348, 33215))  # consecutive convergents of pi: below, above


@record
class Reset:
    """What an edge makes of a variable: a polynomial, or any value between two."""

    low: Polynomial
    high: Polynomial

    @property
    def is_set(self) -> bool:
        """Whether there is a choice."""
        return self.low != self.high


@record
class ClockEdge:
    """An edge as formulas over the variables before it; `resets` only of variables that change."""

    index: int
    name: str
    source: int
    target: int
    urgent: bool
    guard: Formula
    resets: Mapping[str, Reset]


@record
class ClockMode:
    """A mode whose variables move as `e + slope * s`, `s` being time times `rho`; `domain` is closed."""

    index: int
    name: str
    rho: Polynomial
    slopes: Mapping[str, Q]
    domain: Formula
    allowed: Box | None  # the box of the domain; None: empty
    terminal: bool


@holder
class ClockModel:
    """One automaton of the fragment. Modes and edges are compiled when asked for; OutsideFragmentError
    says what is missing."""

    spec: Spec
    automaton: HybridAutomaton
    values: Values
    params: Mapping[str, tuple[Q, Q]]
    _modes: dict[int, ClockMode] = field(default_factory=dict)
    _edges: dict[int, ClockEdge] = field(default_factory=dict)
    _scopes: dict[int, Scope] = field(default_factory=dict)

    @cached_property
    def index(self) -> dict[str, int]:
        """The position of each mode."""
        return {m.name: i for i, m in enumerate(self.automaton.modes)}

    @cached_property
    def leaving(self) -> list[list[int]]:
        """The edges of each mode."""
        found: list[list[int]] = [[] for _ in self.automaton.modes]
        for k, e in enumerate(self.automaton.edges):
            found[self.index[e.source]].append(k)
        return found

    @cached_property
    def reals(self) -> tuple[str, ...]:
        """The variables that flow."""
        return tuple(v.name for v in self.automaton.vars if v.type == "real")

    @cached_property
    def discrete(self) -> Mapping[str, tuple[Q, ...]]:
        """The values of each variable that only jumps change."""
        return {v.name: self._values_of(v.type) for v in self.automaton.vars if v.type != "real"}

    def _values_of(self, type_: str) -> tuple[Q, ...]:
        if type_ == "bool":
            return (Q(0), Q(1))
        enum = next((e for e in self.spec.enums if e.name == type_), None)
        if enum is None:
            raise OutsideFragmentError(f"there is no enumeration `{type_}`")
        if enum.low is not None and enum.high is not None:
            return tuple(Q(i) for i in range(int(enum.low), int(enum.high) + 1))
        return tuple(Q(i) for i in range(len(enum.values)))

    @cached_property
    def windows(self) -> Box:
        """The declared range of each variable."""
        box = {}
        for v in self.automaton.vars:
            if v.type != "real":
                values = self.discrete[v.name]
                box[v.name] = Interval(values[0], values[-1])
                low, high = (values[0], values[-1]) if v.range is None else self.values.interval(v.range)
                if low > values[0] or values[-1] > high:
                    raise OutsideFragmentError(f"`{v.name}` may leave its declared range")
            else:
                box[v.name] = EVERYTHING if v.range is None else Interval(*self.values.interval(v.range))
        return box

    @cached_property
    def timed_lets(self) -> frozenset[str]:
        """The lets that read `time`, in any mode, directly or through others."""
        lets = [*self.automaton.lets, *(o for m in self.automaton.modes for o in m.lets)]
        found: set[str] = set()
        grown = True
        while grown:
            new = {o.name for o in lets if o.name not in found and reads_time(o.expr, found)}
            found |= new
            grown = bool(new)
        return frozenset(found)

    @cached_property
    def rho(self) -> Polynomial | None:
        """The rate that all modes share, None where they do not: then time is not followed."""
        rates = {self.mode(i).rho for i in range(len(self.automaton.modes))}
        return rates.pop() if len(rates) == 1 else None

    @cached_property
    def rho_range(self) -> tuple[Q, Q]:
        """The range of the shared rate."""
        assert self.rho is not None, "time is followed only with a shared rate"
        return range_on(self.rho, self.params)

    def scope(self, index: int) -> Scope:
        """What names mean in a mode."""
        if index not in self._scopes:
            mode = self.automaton.modes[index]
            lets = {o.name: (o.type, o.expr) for o in (*self.automaton.lets, *mode.lets)}
            self._scopes[index] = Scope(
                f"mode {mode.name}",
                self._variables,
                lets,
                self.values.constant,
                self.values.symbol,
                self._truths,
                self._rates(mode),
                box=self.params,
            )
        return self._scopes[index]

    def timed_scope(self, index: int) -> Scope:
        """The same, with `time` known where all modes share one rate."""
        scope = self.scope(index)
        if scope.time is None and self.rho is not None:
            scope.time = (variable(CLOCK), self.rho)
        return scope

    @cached_property
    def _variables(self) -> dict[str, Polynomial]:
        return {n: variable(n) for n in (*self.params, *(v.name for v in self.automaton.vars))}

    @cached_property
    def _truths(self) -> frozenset[str]:
        return frozenset(v.name for v in self.automaton.vars if v.type == "bool")

    def _rates(self, mode: Mode) -> dict[str, Polynomial | None]:
        still: dict[str, Polynomial | None] = {v: constant(0) for v in (*self.params, *self.discrete)}
        scope = Scope(
            f"the flow of mode {mode.name}",
            {n: variable(n) for n in self.params},
            {},
            self.values.constant,
            self.values.symbol,
            frozenset(),
            {},
        )
        for line in mode.flow:
            try:
                still[line.var] = None if isinstance(line.rate, Range) else scope.polynomial(line.rate)
            except OutsideFragmentError:
                still[line.var] = None
        return still

    def mode(self, index: int) -> ClockMode:
        """A mode, compiled."""
        if index not in self._modes:
            self._modes[index] = self._compile_mode(index)
        return self._modes[index]

    def _compile_mode(self, index: int) -> ClockMode:
        mode = self.automaton.modes[index]
        rates = {v: self._rate(mode, v) for v in self.reals}
        rho = next((r for r in rates.values() if r.constant is None), constant(1))
        if not set(rho.variables) <= self.params.keys():
            raise OutsideFragmentError(f"the rate in mode {mode.name} depends on constants that are left open")
        if rho.constant is None and range_on(rho, self.params)[0] <= 0:
            raise OutsideFragmentError(
                f"the rate in mode {mode.name} may be zero or negative for some value of its params"
            )
        slopes = {v: _multiple(r, rho, mode.name, v) for v, r in rates.items()}
        slopes.update(dict.fromkeys(self.discrete, Q(0)))
        domain = closed(self.scope(index).formula(mode.domain))
        everywhere = {v.name: EVERYTHING if v.type == "real" else self.windows[v.name] for v in self.automaton.vars}
        return ClockMode(index, mode.name, rho, slopes, domain, narrow(domain, everywhere, self.params), mode.terminal)

    def _rate(self, mode: Mode, name: str) -> Polynomial:
        line = next((f for f in mode.flow if f.var == name), None)
        if line is None:
            raise OutsideFragmentError(f"mode {mode.name} gives no flow for `{name}`")
        if isinstance(line.rate, Range):
            raise OutsideFragmentError(
                f"`{name}' in [..]` in mode {mode.name} is an inclusion: it needs flowpipes, which this "
                f"version does not have"
            )
        rate = self.scope(mode_index(self, mode)).rates[name]
        if rate is None:
            raise OutsideFragmentError(
                f"`{name}'` in mode {mode.name} is no polynomial of params and constants: flows that are "
                f"not constant need"
                " validated flowpipes, which this version does not have"
            )
        return rate

    def edge(self, index: int) -> ClockEdge:
        """An edge, compiled."""
        if index not in self._edges:
            e = self.automaton.edges[index]
            scope = self.timed_scope(self.index[e.source])
            resets = {a.var: self._reset(scope, a) for a in e.resets}
            self._edges[index] = ClockEdge(
                index, e.name, self.index[e.source], self.index[e.target], e.urgent, scope.formula(e.guard), resets
            )
        return self._edges[index]

    def _reset(self, scope: Scope, a: Assign) -> Reset:
        if isinstance(a.to, Range):
            low, high = scope.polynomial(a.to.low), scope.polynomial(a.to.high)
            width = (high - low).constant
            if width is not None and width < 0:
                raise OutsideFragmentError(f"{scope.where} gives `{a.var}` a value of an empty range")
            return Reset(low, high)
        if a.var in self._truths:
            value = indicator(scope.formula(a.to), self._bits)
        else:
            value = chosen(scope.cases(a.to), self._bits)
        if value is None:
            raise OutsideFragmentError(
                f"{scope.where} gives `{a.var}` a value that depends on more than truth variables: write one edge "
                "for each case"
            )
        return Reset(value, value)

    @cached_property
    def _bits(self) -> frozenset[str]:
        """The variables whose values are 0 and 1."""
        return frozenset(v for v, values in self.discrete.items() if values == (Q(0), Q(1)))

    def landing(self, index: int) -> Scope:
        """What names mean just after an edge, in terms of the variables before it (`v'` for chosen values)."""
        edge = self.edge(index)
        after = self.timed_scope(edge.target)
        assigned = {v: variable(f"{v}'") if r.is_set else r.low for v, r in edge.resets.items()}
        values = {**self._variables, **assigned}
        landing = Landing(self.timed_scope(edge.source), after, assigned)
        return Scope(
            f"the jump {edge.name}",
            values,
            after.lets,
            after.constants,
            after.symbols,
            after.truths,
            after.rates,
            after.time,
            self.params,
            landing,
        )


def reads_time(e: Expr, lets: Set[str]) -> bool:
    """Whether an expression mentions `time` or one of the lets."""
    return any(n.op == "time" or (n.op == "let" and n.args[0] in lets) for n in nodes(e))


def mode_index(model: ClockModel, mode: Mode) -> int:
    """The position of a mode."""
    return model.index[mode.name]


def _multiple(rate: Polynomial, rho: Polynomial, mode: str, name: str) -> Q:
    """`c` with `rate = c * rho`."""
    if rho.constant is not None:
        return rate.constant or Q(0)
    if not rate.terms:
        return Q(0)
    monomial = next(iter(rho.terms))
    factor = rate.terms.get(monomial, Q(0)) / rho.terms[monomial]
    if not factor or rho.scaled(factor) != rate:
        raise OutsideFragmentError(f"`{name}'` in mode {mode} is no rational multiple of the other rates")
    return factor


def closed(f: Formula) -> Formula:
    """The closure of a domain: `<` read as `<=`, `!=` as true (LANGUAGE S6)."""
    if isinstance(f, Literal):
        return True if f.op == "!=" else Literal("<=" if f.op == "<" else f.op, f.polynomial)
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([closed(m) for m in f.members])
    return f


def clock_model(spec: Spec, automaton: HybridAutomaton) -> ClockModel:
    """The automaton as a clock-driven one.

    Raises
    ------
    OutsideFragmentError    naming the construct that is in the way
    """
    if automaton.inputs:
        raise OutsideFragmentError(
            f"the input `{automaton.inputs[0].name}` of {automaton.name} needs differential inclusions, "
            f"which this version does not have"
        )
    if automaton.priorities:
        raise OutsideFragmentError(
            f"the priorities among the edges of {automaton.name} are not followed in this version"
        )
    values = values_of(spec, automaton)
    params = {p.name: values.interval(p.range) for p in params_of(spec, automaton)}
    names = [*params, *(v.name for v in automaton.vars)]
    clash = next((n for n in names if n in RESERVED or names.count(n) > 1), None)
    if clash is not None:
        raise OutsideFragmentError(
            f"the name `{clash}` of {automaton.name} has another meaning in certificates; rename it"
        )
    empty = next((n for n, (low, high) in params.items() if low > high), None)
    if empty is not None:
        raise OutsideFragmentError(f"the range of the param `{empty}` is empty")
    return ClockModel(spec, automaton, values, params)
