"""An automaton with flows and jumps as the flowpipe analyses see it: the names of its state, its modes, its starts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import members
from haverify.analyses.hybrid.starts import Box, NoStartError, keeps, start_box
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Mode, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, params_of, values_of
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, record

Q = Fraction
Definitions = dict[tuple[str, str], Expr]


@record
class Start:
    """Starts in a mode: a box over the names of the state, and what an init line says beyond it."""

    mode: int
    box: Box
    rest: tuple[Expr, ...]


@holder
class HybridModel:
    """The automaton with the names of its state: variables, params that are read, `time`.

    `modes` are those that edges lead to from a start, in the order in which the kernel numbers them.
    """

    spec: Spec
    automaton: HybridAutomaton
    values: Values
    modes: tuple[Mode, ...]
    names: tuple[str, ...]
    starts: tuple[Start, ...]
    # For each mode, what lets and constants stand for.
    definitions: tuple[Definitions, ...]
    # Conditions as long as which runs are judged, bounds of params left out, and conditions that hold on all of them.
    assumed: tuple[Expr, ...]
    used: tuple[Expr, ...]
    # For each mode, the automaton's edge that each of the kernel's edges stands for.
    edges: list[list[int]] = field(default_factory=list)

    def mode(self, name: str) -> int:
        """The number of a mode."""
        return next(i for i, m in enumerate(self.modes) if m.name == name)

    @property
    def jumps(self) -> bool:
        """Whether any edge leaves a mode."""
        names = {m.name for m in self.modes}
        return any(e.source in names for e in self.automaton.edges)


def hybrid_model(
    spec: Spec,
    automaton: HybridAutomaton,
    asked: Sequence[Expr],
    assumed: Iterable[Expr] = (),
    used: Iterable[Expr] = (),
) -> HybridModel:
    """The automaton with all that it and the conditions `asked`, `assumed` and `used` read.

    Raises
    ------
    OutsideFragmentError    if it has priorities or discrete variables
    """
    if automaton.priorities:
        raise OutsideFragmentError("priorities beside a flow that is not clock-driven")
    if any(v.type != "real" for v in automaton.vars):
        raise OutsideFragmentError("discrete variables beside a flow that is not clock-driven")
    values = values_of(spec, automaton)
    modes = tuple(_reachable(automaton))
    known = tuple(_definitions(automaton, m, values) for m in modes)
    assumed, used = (*spec.assumptions, *assumed), tuple(used)
    read = _read(automaton, modes, known, (*asked, *assumed, *used))
    params = [p for p in params_of(spec, automaton) if p.name in read]
    names = (*(v.name for v in automaton.vars), *(p.name for p in params), "time")
    ranges = {p.name: values.interval(p.range) for p in params}
    starts = _starts(automaton, modes, values, ranges, assumed)
    assumed = tuple(c for e in assumed for c in members(e) if not keeps(c, ranges, values))
    return HybridModel(spec, automaton, values, modes, names, starts, known, assumed, used)


def _reachable(automaton: HybridAutomaton) -> Iterator[Mode]:
    """The modes that edges lead to from a start."""
    found = {i.mode for i in automaton.init}
    found |= {m.name for m in automaton.modes} if None in found else set()
    for _ in automaton.modes:
        found |= {e.target for e in automaton.edges if e.source in found}
    return (m for m in automaton.modes if m.name in found)


def _starts(
    automaton: HybridAutomaton,
    modes: Sequence[Mode],
    values: Values,
    params: Mapping[str, tuple[Q, Q]],
    assumed: Sequence[Expr],
) -> tuple[Start, ...]:
    """The starts of all init lines, those left out that contradict themselves or what is assumed.

    Raises
    ------
    OutsideFragmentError    if there are no others
    """
    found, nowhere = list[Start](), None
    for init in automaton.init:
        for number, mode in enumerate(modes):
            if init.mode in (mode.name, None):
                try:
                    bounded, more = start_box(automaton, mode, init, values, params, assumed)
                except NoStartError as e:
                    nowhere = e
                    continue
                found.append(Start(number, (*bounded, (Q(0), Q(0))), tuple(more)))
    if nowhere is not None and not found:
        raise nowhere
    return tuple(found)


def _definitions(automaton: HybridAutomaton, mode: Mode, values: Values) -> Definitions:
    """What lets and constants stand for in a mode."""
    found = {("let", o.name): residual(o.expr, Situation(mode.name)) for o in (*automaton.lets, *mode.lets)}
    constants = {("const", n): c.value for n, c in values.constants.items() if isinstance(c.value, Expr)}
    return {**found, **constants}


def _read(
    automaton: HybridAutomaton, modes: Sequence[Mode], known: Sequence[Definitions], asked: Sequence[Expr]
) -> frozenset[str]:
    """The params that the automaton or a condition reads, directly or through lets and constants."""
    names = {m.name for m in modes}
    edges = [e for e in automaton.edges if e.source in names]
    waiting = [*asked, *(i.where for i in automaton.init), *(m.domain for m in modes), *(e.guard for e in edges)]
    waiting += [e for m in modes for line in m.flow for e in _ends(line.rate)]
    waiting += [e for o in edges for a in o.resets for e in _ends(a.to)]
    waiting += [e for i in automaton.init for a in i.assigns for e in _ends(a.to)]
    found, seen = set[str](), set[tuple[str, str]]()
    while waiting:
        for n in nodes(waiting.pop()):
            if n.op == "param":
                found.add(n.name)
            elif n.op in ("let", "const") and (n.op, n.name) not in seen:
                seen.add((n.op, n.name))
                waiting += [of[n.op, n.name] for of in known if (n.op, n.name) in of]
    return frozenset(found)


def _ends(to: Expr | Range) -> tuple[Expr, ...]:
    return (to.low, to.high) if isinstance(to, Range) else (to,)
