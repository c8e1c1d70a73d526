"""An automaton with flows and jumps as the flowpipe analyses see it: the names of its state, its modes, its starts."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property

from haverify.analyses.hybrid.conditions import members
from haverify.analyses.hybrid.corners import without_corners
from haverify.analyses.hybrid.discrete import without_discrete
from haverify.analyses.hybrid.expansion import Expanded, Place, dwelling, landing
from haverify.analyses.hybrid.starts import Box, NoStartError, contracted, keeps, start_box
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Mode, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, params_of, values_of
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Listing
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
    # The variables as declared, discrete ones included; what each mode stands for; the number of each edge in the
    # automaton as written (None: a change of side).
    variables: tuple[str, ...]
    places: tuple[Place, ...]
    origins: tuple[int | None, ...]
    # Modes of a system, as written, whose edges are not listed.
    open: frozenset[str] = frozenset()
    # For each mode, the automaton's edge that each of the kernel's edges stands for.
    edges: list[list[int]] = field(default_factory=list)
    # Fields as the kernel takes them, by automaton, names of the state and mode: for claims without modes of their own.
    compiled: dict[Hashable, Listing] = field(default_factory=dict)

    def mode(self, name: str) -> int:
        """The number of a mode."""
        return self._numbers[name]

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {m.name: i for i, m in enumerate(self.modes)}

    def dwelling(self, e: Expr, number: int) -> Expr:
        """What is left of a condition during a stay in a mode."""
        return dwelling(e, self.places[number], _lets(self.definitions[number]))

    def landing(self, e: Expr, edge: int) -> Expr:
        """What is left of a condition right after an edge; a change of side is part of a stay."""
        of = self.automaton.edges[edge]
        source, target = self.mode(of.source), self.mode(of.target)
        if self.origins[edge] is None:
            return self.dwelling(e, target)
        ends = [(self.places[k], _lets(self.definitions[k])) for k in (source, target)]
        return landing(e, of.name, ends[0], ends[1])

    @property
    def is_plain(self) -> bool:
        """Whether the modes are those of the automaton as written."""
        return all(k == n for n, k in enumerate(self.origins)) and not any(p.values for p in self.places)

    def discrete(self, number: int) -> tuple[tuple[str, Q], ...]:
        """The discrete variables of a mode, their values as numbers."""
        return tuple((v, self._number(e)) for v, e in self.places[number].values)

    def _number(self, e: Expr) -> Q:
        if e.op == "sym":
            enum = next(t for t in self.spec.enums if t.name == e.args[0])
            return Q(enum.values.index(str(e.args[1])))
        return Q(str(e.args[0])) if e.op == "num" else Q(e.op == "true")

    @property
    def jumps(self) -> bool:
        """Whether any edge leaves a mode."""
        names = {m.name for m in self.modes}
        return any(e.source in names for e in self.automaton.edges)


def written_out(spec: Spec, automaton: HybridAutomaton) -> Expanded:
    """The automaton without discrete variables and corners.

    Raises
    ------
    OutsideFragmentError    if it has priorities, or is not to be written out so
    """
    if automaton.priorities:
        raise OutsideFragmentError("priorities beside a flow that is not clock-driven")
    return without_corners(without_discrete(spec, automaton), values_of(spec, automaton))


def hybrid_model(
    spec: Spec,
    automaton: HybridAutomaton,
    asked: Sequence[Expr],
    assumed: Iterable[Expr] = (),
    used: Iterable[Expr] = (),
    written: Expanded | None = None,
) -> HybridModel:
    """The automaton with all that it and the conditions `asked`, `assumed` and `used` read.

    `written` is what `written_out` makes of it, where that is known.

    Raises
    ------
    OutsideFragmentError    if it has priorities, or is not to be written out without discrete variables and corners
    """
    values = values_of(spec, automaton)
    found = written_out(spec, automaton) if written is None else written
    given, automaton = automaton, found.automaton
    modes = tuple(_reachable(automaton))
    places = tuple(found.places[m.name] for m in modes)
    known = tuple(_definitions(automaton, m, p, values) for m, p in zip(modes, places, strict=True))
    assumed, used = (*spec.assumptions, *assumed), tuple(used)
    read = _read(automaton, modes, known, (*asked, *assumed, *used))
    params = [p for p in params_of(spec, automaton) if p.name in read]
    names = (*(v.name for v in automaton.vars), *(p.name for p in params), "time")
    ranges = {p.name: values.interval(p.range) for p in params}
    holding = [[dwelling(e, p, _lets(d)) for e in assumed] for p, d in zip(places, known, strict=True)]
    starts = _starts(automaton, modes, values, ranges, holding, automaton is given)
    assumed = tuple(c for e in assumed for c in members(e) if not keeps(c, ranges, values))
    variables = tuple(v.name for v in given.vars)
    return HybridModel(
        spec, automaton, values, modes, names, starts, known, assumed, used, variables, places, found.edges,
        given.open,
    )  # fmt: skip


def _lets(definitions: Definitions) -> dict[str, Expr]:
    return {name: e for (kind, name), e in definitions.items() if kind == "let"}


def _reachable(automaton: HybridAutomaton) -> Iterator[Mode]:
    """The modes that edges lead to from a start."""
    found = {i.mode for i in automaton.init}
    found |= {m.name for m in automaton.modes} if None in found else set()
    for _ in automaton.modes:
        more = {e.target for e in automaton.edges if e.source in found} - found
        if not more:
            break
        found |= more
    return (m for m in automaton.modes if m.name in found)


def _starts(
    automaton: HybridAutomaton,
    modes: Sequence[Mode],
    values: Values,
    params: Mapping[str, tuple[Q, Q]],
    assumed: Sequence[Sequence[Expr]],
    is_plain: bool,
) -> tuple[Start, ...]:
    """The starts of all init lines, those left out that contradict themselves or what is assumed in each mode.

    Raises
    ------
    OutsideFragmentError    if there are no others
    """
    found, nowhere = list[Start](), None
    for init in automaton.init:
        for number, mode in enumerate(modes):
            if init.mode in (mode.name, None):
                try:
                    bounded, more = start_box(automaton, mode, init, values, params, assumed[number])
                except NoStartError as e:
                    nowhere = e
                    continue
                box: Box | None = tuple(bounded)
                if not is_plain:  # second checkers take the boxes of the others from what is written
                    names = [*(v.name for v in automaton.vars), *params]
                    box = contracted(tuple(bounded), names, more, values)
                if box is not None:
                    found.append(Start(number, (*box, (Q(0), Q(0))), tuple(more)))
    if not found:
        raise nowhere or OutsideFragmentError("no start: no mode and no discrete values fit its conditions")
    return tuple(found)


def _definitions(automaton: HybridAutomaton, mode: Mode, place: Place, values: Values) -> Definitions:
    """What lets and constants stand for in a mode."""
    found = {("let", o.name): residual(o.expr, Situation(place.mode)) for o in (*automaton.lets, *mode.lets)}
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
