"""An automaton as the simulator runs it: one state vector for variables, params, inputs and time."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from haverify.model.expression import Expr, number, rebuild
from haverify.model.hybrid import Edge, HybridAutomaton, Input, Mode, Output, Param, Priority, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, params_of, values_of
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.applied import Applied
from haverify.simulate.compile import NEGATED, Code, joined
from haverify.solvers.runs import EdgeListing, ModeListing, ResetListing, Simulator, Words
from haverify.text.record import field, holder, record

SHARE = "share of "  # of an inclusion: where between its ends the slope is
SLOPE = "slope of "  # of an input that is continuous
ZERO, ONE = number(0), number(1)

_DENIED = {**NEGATED, "all": "any", "any": "all", "true": "false", "false": "true"}


@record
class Observation:
    """What a formula over runs reads in one mode: for each of its quantities the expression there."""

    quantities: tuple[Expr, ...]


@record
class Landing:
    """What it reads right after an edge."""

    quantities: tuple[Expr, ...]


@record
class Starting:
    """An init line in a mode: registers of what it assigns, and conditions that a start has to meet."""

    mode: int
    assigned: tuple[tuple[str, int, int], ...]  # variable, registers of the least and greatest value
    condition: Words
    line: int


@holder
class SimulatedAutomaton:
    """The automaton with its kernel; `names` is the order of the state, `time` the last one.

    `resets` has for each edge a variable and registers of the source mode: of the value, or of both ends of a choice.
    """

    spec: Spec
    automaton: HybridAutomaton
    observed: tuple[Observation, ...] = ()
    landings: tuple[Landing, ...] = ()
    codes: list[Code] = field(default_factory=list)
    starts: list[Starting] = field(default_factory=list)
    moving: list[int] = field(default_factory=list)  # for each mode, how many operations its flow and guards need

    def __post_init__(self) -> None:
        listings = [self._mode(k) for k in range(len(self.automaton.modes))]
        edges = [self._edge(k, e) for k, e in enumerate(self.automaton.edges)]
        modes = [self._closed(k, listing) for k, listing in enumerate(listings)]
        self.resets = [e[3] for e in edges]
        self.kernel = Simulator(modes, edges, len(self.names), len(self.names) - 1)

    @cached_property
    def values(self) -> Values:
        """Constants and enumerations."""
        return values_of(self.spec, self.automaton)

    @cached_property
    def params(self) -> tuple[Param, ...]:
        """The params in scope, an automaton's own hiding those of the file."""
        return tuple({p.name: p for p in params_of(self.spec, self.automaton)}.values())

    @cached_property
    def inputs(self) -> tuple[Input, ...]:
        """The inputs in scope."""
        return tuple({i.name: i for i in (*self.spec.inputs, *self.automaton.inputs)}.values())

    @cached_property
    def inclusions(self) -> tuple[str, ...]:
        """Variables whose slope is a range in some mode."""
        lines = [line for m in self.automaton.modes for line in m.flow if isinstance(line.rate, Range)]
        return tuple(dict.fromkeys(line.var for line in lines))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The state: variables, params, inputs, slopes of continuous inputs, shares of inclusions, time."""
        return (
            *(v.name for v in self.automaton.vars),
            *(p.name for p in self.params),
            *(i.name for i in self.inputs),
            *(SLOPE + i.name for i in self.inputs if i.rate is not None),
            *(SHARE + v for v in self.inclusions),
            "time",
        )

    @cached_property
    def places(self) -> Mapping[str, int]:
        """The place of each name in the state."""
        return {n: i for i, n in enumerate(self.names)}

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """The lets that some mode has, each name once."""
        lets = (*self.automaton.lets, *(o for m in self.automaton.modes for o in m.lets))
        return tuple({o.name: o for o in lets}.values())

    @cached_property
    def leaving(self) -> Mapping[str, tuple[int, ...]]:
        """The numbers of the edges that leave each mode: a system of many parts has thousands of both."""
        found: dict[str, list[int]] = {m.name: [] for m in self.automaton.modes}
        for i, e in enumerate(self.automaton.edges):
            found[e.source].append(i)
        return {m: tuple(numbers) for m, numbers in found.items()}

    @cached_property
    def _numbers(self) -> Mapping[str, int]:
        return {m.name: i for i, m in enumerate(self.automaton.modes)}

    def mode(self, name: str) -> int:
        """The number of a mode."""
        return self._numbers[name]

    def _edges(self, mode: str) -> list[Edge]:
        return [self.automaton.edges[i] for i in self.leaving[mode]]

    def _code(self, mode: Mode) -> Code:
        lets = {("let", o.name): o.expr for o in (*self.automaton.lets, *mode.lets)}
        constants = {("const", n): c.value for n, c in self.values.constants.items() if isinstance(c.value, Expr)}
        symbols = {(e, v): q for e, values in self.values.positions.items() for v, q in values.items()}
        truths = frozenset(v.name for v in self.automaton.vars if v.type == "bool")
        here = {k: residual(e, Situation(mode.name)) for k, e in lets.items()}
        applied = Applied(self.spec, symbols)
        return Code(self.places, {**here, **constants}, symbols, truths, self._rates(mode), applied)

    def _rates(self, mode: Mode) -> dict[str, Expr]:
        found = {}
        for line in mode.flow:
            rate = line.rate
            if isinstance(rate, Range):
                share = Expr("var", (SHARE + line.var,))
                rate = Expr("+", (rate.low, Expr("*", (share, Expr("-", (rate.high, rate.low))))))
            found[line.var] = residual(rate, Situation(mode.name))
        return found

    def _mode(self, k: int) -> tuple[list[int | None], Words, list[Words], list[int]]:
        """Slopes, domain, for each edge of the automaton the condition under which it is enabled, observations."""
        mode = self.automaton.modes[k]
        code = self._code(mode)
        self.codes.append(code)
        rates: dict[str, Expr] = {**code.rates, "time": ONE}
        rates |= {i.name: Expr("var", (SLOPE + i.name,)) for i in self.inputs if i.rate is not None}
        slopes = [code.value(rates[n]) if n in rates else None for n in self.names]
        domain = code.words(residual(mode.domain, Situation(mode.name)), closed=True)
        ready = [self._ready(code, e) for e in self._edges(mode.name)]
        observed = [code.value(q) for q in self.observed[k].quantities] if self.observed else []
        self.moving.append(len(code.operations))
        return slopes, domain, ready, observed

    def _ready(self, code: Code, edge: Edge) -> Words:
        """Guard and outcome of an edge, and no edge of higher priority ready."""
        above = [w for p in self.automaton.priorities if edge.name in p.over for w in self._denied(code, p, edge)]
        return joined("all", [self._enabled(code, edge), *above])

    def _denied(self, code: Code, order: Priority, edge: Edge) -> list[Words]:
        """That no edge above another in a priority is ready."""
        higher = order.over[: order.over.index(edge.name)]
        when = code.words(residual(order.when, Situation(edge.source)))
        rivals = [e for e in self._edges(edge.source) if e.name in higher]
        return [denial(joined("all", [when, self._enabled(code, e)])) for e in rivals]

    def _enabled(self, code: Code, edge: Edge) -> Words:
        guard = code.words(residual(edge.guard, Situation(edge.source)))
        if any(isinstance(a.to, Range) for a in edge.resets):
            return guard
        target = self.automaton.modes[self.mode(edge.target)]
        lets = {o.name: residual(o.expr, Situation(target.name)) for o in (*self.automaton.lets, *target.lets)}
        resets = {a.var: residual(a.to, Situation(edge.source)) for a in edge.resets if isinstance(a.to, Expr)}
        landed = _landed(residual(target.domain, Situation(target.name)), lets, resets)
        return joined("all", [guard, code.words(landed, closed=True)])

    def _edge(self, k: int, edge: Edge) -> EdgeListing:
        """The edge with registers behind those that move."""
        number_of = self.mode(edge.source)
        code = self.codes[number_of]
        enabled = self._ready(code, edge)  # made before: no new operation
        resets: list[ResetListing] = []
        for a in edge.resets:
            to = (a.to.low, a.to.high) if isinstance(a.to, Range) else (a.to,)
            low, *high = [code.value(residual(e, Situation(edge.source))) for e in to]
            resets.append((self.places[a.var], low, high[0] if high else None))
        target = self.mode(edge.target)
        seen = [self.codes[target].value(q) for q in self.landings[k].quantities] if self.landings else []
        return target, edge.urgent, enabled, resets, seen

    def _closed(self, k: int, made: tuple[list[int | None], Words, list[Words], list[int]]) -> ModeListing:
        mode, code = self.automaton.modes[k], self.codes[k]
        slopes, domain, _, observed = made
        own = list(self.leaving[mode.name])
        self._add_starts(k, domain)
        outputs = [self._output(code, o, mode) for o in self.outputs]
        return (
            code.operations, self.moving[k], slopes, code.conditions, domain, mode.terminal, own, observed, outputs,
        )  # fmt: skip

    def _output(self, code: Code, o: Output, mode: Mode) -> int:
        """The register of a let; of one that this mode does not have, a number that is none."""
        try:
            return code.value(Expr("let", (o.name,)))
        except OutsideFragmentError:
            return code.constant(float("nan"))

    def _add_starts(self, k: int, domain: Words) -> None:
        mode, code = self.automaton.modes[k], self.codes[k]
        for line, init in enumerate(self.automaton.init):
            if init.mode not in (None, mode.name):
                continue
            assigned = []
            for a in init.assigns:
                ends = (a.to.low, a.to.high) if isinstance(a.to, Range) else (a.to, a.to)
                low, high = [code.value(residual(e, Situation(mode.name))) for e in ends]
                assigned.append((a.var, low, high))
            where = code.words(residual(init.where, Situation(mode.name)))
            self.starts.append(Starting(k, tuple(assigned), joined("all", [where, domain]), line))


def denial(words: Words) -> Words:
    """The condition that holds where another does not."""
    return [(_DENIED[w], n) for w, n in words]


def _landed(e: Expr, lets: Mapping[str, Expr], resets: Mapping[str, Expr]) -> Expr:
    """A condition after a jump as one of the state before it."""
    if e.op == "let":
        return _landed(lets[e.name], lets, resets)
    if e.op == "var":
        return resets.get(e.name, e)
    return rebuild(e, lambda c: _landed(c, lets, resets))
