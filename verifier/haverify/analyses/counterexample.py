"""Search for runs: concrete states reached, breadth first, so that the first witness found has the fewest jumps.

Everything is exact, so what is found is a run; that nothing is found says nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import islice, product

from haverify.analyses.bounds import Interval, narrow
from haverify.analyses.clock_model import ClockModel
from haverify.analyses.motion import NOW, Motion, State, Stretch, stretches
from haverify.analyses.poly_range import Ranges
from haverify.evidence.run import Run, Step
from haverify.maths.polynomial import constant, variable
from haverify.model.expression import Expr
from haverify.obligations.formula import Formula, Literal, holds, literals, negation, transform
from haverify.text.record import field, holder

Q = Fraction
MOST_NODES = 1500
TRIES = 24  # nodes of the right mode that are looked at for one question and one choice of params


@holder
class Node:
    """A state just after a jump (or at the start), and how it was reached."""

    state: State
    parent: Node | None
    step: Step | None

    def steps(self) -> tuple[Step, ...]:
        """The way here."""
        found: list[Step] = []
        node: Node | None = self
        while node is not None and node.step is not None:
            found.append(node.step)
            node = node.parent
        return tuple(reversed(found))

    def start(self) -> State:
        """Where the run began."""
        node = self
        while node.parent is not None:
            node = node.parent
        return node.state


@holder
class Explorer:
    """The runs of an automaton under fixed params, explored as far as anybody has asked.

    With `timed`, states that differ in time alone are different, and none beyond `horizon` (s) is followed.
    """

    motion: Motion
    horizon: Q | None
    timed: bool
    jumps: int | None = None
    kept: Formula = True  # assumptions on the state, over the variables of each mode
    most: int = MOST_NODES
    nodes: list[Node] = field(default_factory=list)
    by_mode: dict[int, list[Node]] = field(default_factory=dict)
    _seen: set[object] = field(default_factory=set)
    _stays: dict[int, tuple[State, tuple[Q, bool] | None]] = field(default_factory=dict)
    _queue: Iterator[Node] | None = None

    def in_mode(self, mode: int) -> Iterator[Node]:
        """The states in which runs enter a mode, fewest jumps first."""
        position = 0
        while True:
            found = self.by_mode.get(mode, [])
            if position < len(found):
                position += 1
                yield found[position - 1]
            elif not self._more():
                return

    def everywhere(self) -> Iterator[Node]:
        """The states in which runs enter any mode, fewest jumps first."""
        position = 0
        while position < len(self.nodes) or self._more():
            position += 1
            yield self.nodes[position - 1]

    def view(self, state: State) -> Q | None:
        """How long a run may still go on within the horizon."""
        return None if self.horizon is None else max(Q(0), self.horizon - state.time)

    def stay(self, state: State) -> tuple[Q, bool] | None:
        """The longest dwell in view, and whether it is the end of the stay: worked out once, for many parts ask."""
        if id(state) not in self._stays:  # which is told apart by identity, and kept, so that this is not given away
            self._stays[id(state)] = state, self.motion.stay(state, self.view(state))
        return self._stays[id(state)][1]

    def _more(self) -> bool:
        if self._queue is None:
            self._queue = self._explore()
        return len(self.nodes) < self.most and next(self._queue, None) is not None

    def _explore(self) -> Iterator[Node]:
        for state in islice(self.motion.starts(), 64):
            yield from self._enter(Node(state, None, None))
        position = 0
        while position < len(self.nodes):
            node = self.nodes[position]
            position += 1
            if self.jumps is None or node.state.jumps < self.jumps:
                for child in self.children(node):
                    yield from self._enter(child)

    def _enter(self, node: Node) -> Iterator[Node]:
        state = node.state
        key = (state.mode, tuple(state.values.items()), state.time if self.timed else None)
        late = self.horizon is not None and state.time > self.horizon
        if key not in self._seen and not late:
            self._seen.add(key)
            self.nodes.append(node)
            self.by_mode.setdefault(state.mode, []).append(node)
            yield node

    def children(self, node: Node) -> Iterator[Node]:
        """Some states after one more jump."""
        for k in self.motion.model.leaving[node.state.mode]:
            for dwell in self.firings(node.state, k):
                yield from self.jump(node, k, dwell)

    def jump(self, node: Node, k: int, dwell: Q) -> Iterator[Node]:
        """The states after edge k is taken after a dwell."""
        left = self.motion.at(node.state, dwell)
        for after, picked in self.motion.outcomes(left, self.motion.model.edge(k)):
            yield Node(after, node, Step(dwell, k, tuple(picked.items())))

    def firings(self, state: State, k: int) -> list[Q]:
        """Some dwells after which an edge may be taken."""
        found: dict[Q, None] = {}
        for stretch in self.openings(state, k):
            found.update(dict.fromkeys(stretch.rationals()))
        return list(found)

    def openings(self, state: State, k: int) -> list[Stretch]:
        """When an edge may be taken: its guard holds, or it is urgent and due, and the state may stay until then."""
        stay = self.stay(state)
        if stay is None:
            return []
        end = stay[0]
        result = []
        for s in self.motion.openings(state, k, end):
            result.append(Stretch(s.low, min(s.high, end), s.low_closed, s.high_closed or s.high > end))
        if self.motion.model.edge(k).urgent and not any(s.low == end for s in result):
            due = self.motion.due(state, k, end + 1)
            if due == end:
                result.append(Stretch(end, end, True, True))
        return result


def choices(model: ClockModel, wanted: Mapping[str, Q], allowed: Formula) -> Iterator[dict[str, Q]]:
    """Values of the params to try: defaults (else middles), those wanted, corners; only where `allowed` holds."""
    seen: set[tuple[Q, ...]] = set()
    ends = assumed_ranges(model, allowed)
    corners = product(*ends.values()) if len(ends) <= 4 else iter(())
    middle = {p: (low + high) / 2 for p, (low, high) in ends.items()}
    near = {p: min(max(wanted.get(p, middle[p]), low), high) for p, (low, high) in ends.items()}
    usual = {p: min(max(x, ends[p][0]), ends[p][1]) for p, x in defaults(model).items()}
    listed = [usual, near, middle, *(dict(zip(ends, c, strict=True)) for c in corners)]
    for params in listed:
        key = tuple(params.values())
        if key not in seen and holds(allowed, params):
            seen.add(key)
            yield params


def assumed_ranges(model: ClockModel, allowed: Formula) -> dict[str, tuple[Q, Q]]:
    """The ranges of the params, cut to what is assumed of each of them alone."""
    ranges = dict(model.params)
    cut = None if allowed is True else narrow(allowed, {p: Interval(*ends) for p, ends in ranges.items()}, {})
    for p, x in (cut or {}).items():
        if x.low is not None and x.high is not None:
            ranges[p] = (x.low, x.high)
    return ranges


def defaults(model: ClockModel) -> dict[str, Q]:
    """The default of each param that has one in its range, else the middle."""
    found = {p: (low + high) / 2 for p, (low, high) in model.params.items()}
    for param in (*model.spec.params, *model.automaton.params):
        if isinstance(param.default, Expr):
            value = model.values.number(param.default)
            low, high = model.params[param.name]
            if low <= value <= high:
                found[param.name] = value
    return found


def worst_moment(f: Formula, stretch: Stretch, ranges: Ranges) -> Q | None:
    """A dwell in the stretch at which `f`, in `t` alone, is false, with a short denominator and about
    where it is worst."""
    if isinstance(f, bool):
        return None if f else next(stretch.rationals(), None)
    if stretch.low == stretch.high:
        return None if holds(f, {NOW: stretch.low}) else stretch.low
    for wish in _wishes(f, stretch, ranges):
        for t in (*_short(wish, stretch), wish):
            if stretch.low <= t <= stretch.high and _belongs(t, stretch) and not holds(f, {NOW: t}):
                return t
    width = stretch.high - stretch.low
    inner = stretches(_shifted(negation(f), stretch.low), width)
    return next((stretch.low + t for s in inner for t in s.rationals() if _belongs(stretch.low + t, stretch)), None)


def _shifted(f: Formula, by: Q) -> Formula:
    return transform(f, lambda p: p.substitute({NOW: variable(NOW) + constant(by)}))


def _belongs(t: Q, stretch: Stretch) -> bool:
    return (t > stretch.low or stretch.low_closed) and (t < stretch.high or stretch.high_closed)


def _wishes(f: Formula, stretch: Stretch, ranges: Ranges) -> list[Q]:
    """Where the literals are hardest to satisfy, the hardest of them first."""
    ends = (stretch.low, stretch.high)
    found: list[tuple[Q, Q]] = []
    for leaf in literals(f):
        if isinstance(leaf, Literal) and leaf.polynomial.variables == (NOW,):
            low, high = ranges.extremes(leaf.polynomial, {NOW: ends})
            found.append((high.low, high.at))
            if leaf.op in ("==", "!="):
                found.append((-low.high, low.at))
    return [at for _, at in sorted(found, key=lambda x: -x[0])]


def _short(wish: Q, stretch: Stretch) -> list[Q]:
    width = stretch.high - stretch.low
    digits = 0
    while width * 10**digits < 20:
        digits += 1
    rounded = [Q(round(wish * 10**d), 10**d) for d in range(digits, digits + 4)]
    return [t for t in rounded if stretch.low <= t <= stretch.high]


def the_run(model: ClockModel, node: Node, params: Mapping[str, Q], last: Q) -> Run:
    """The run that leads to a node and dwells there."""
    start = node.start()
    return Run(
        model.automaton.modes[start.mode].name, tuple(start.values.items()), tuple(params.items()), node.steps(), last
    )
