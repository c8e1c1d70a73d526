"""Single runs: concrete ones from the start past the horizon, and the truth of every atom along them."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.clock_model import PI, reads_time
from haverify.analyses.counterexample import Explorer, Node
from haverify.analyses.motion import NOW, Motion, State
from haverify.analyses.poly_range import Ranges, Work
from haverify.analyses.questions import Setting
from haverify.analyses.signals_cells import EVENTS
from haverify.analyses.signals_formula import Formula as Stl
from haverify.analyses.signals_pieces import Item, items, spans_of, where_true
from haverify.analyses.signals_value import ZERO, Cut, Dwell, Signal, Spans, Timeline, at_start, common, joined
from haverify.model.expression import Expr, nodes
from haverify.obligations.circle import stronger
from haverify.obligations.denial import denial
from haverify.obligations.formula import Formula, conjunction, holds, negation
from haverify.obligations.residual import Situation, residual
from haverify.obligations.spread import spread
from haverify.text.record import field, holder

Q = Fraction
TAIL = Q(1)  # s; a dwell that stands for all that follows the run


@holder
class Followed:
    """A run as the states in which its dwells begin, with their lengths in s; nothing is known of what follows it
    where it does not go past the horizon."""

    motion: Motion
    node: Node
    last: Q
    horizon: Q
    ranges: Ranges = field(default_factory=Ranges)
    nodes: list[Node] = field(default_factory=list)
    known: dict[Expr, list[list[Item]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """The nodes from the start on."""
        here: Node | None = self.node
        while here is not None:
            self.nodes.append(here)
            here = here.parent
        self.nodes.reverse()

    def dwells(self) -> list[Q]:
        """The length of each dwell."""
        return [*(n.step.dwell for n in self.nodes[1:] if n.step is not None), self.last]

    @property
    def lost(self) -> bool:
        """Whether it ends at the horizon or before."""
        return self.node.state.time + self.last <= self.horizon

    def timeline(self) -> Timeline:
        """The dwells, and one for what is not known."""
        listed = [
            Dwell(d, d, (n.state.time, n.state.time)) for n, d in zip(self.nodes, self.dwells(), strict=True)
        ]  # fmt: skip
        end = self.node.state.time + self.last
        tail = [Dwell(self.horizon + TAIL, self.horizon + TAIL, (end, end))] if self.lost else []
        return Timeline((*listed, *tail))

    def items(self, atom: Expr) -> list[list[Item]]:
        """The truth of an atom along each dwell, no jump being just made."""
        if atom not in self.known:
            timed = reads_time(atom, self.motion.model.timed_lets)
            alike: dict[object, list[Item]] = {}
            listed = []
            for n, last in zip(self.nodes, self.dwells(), strict=True):
                key = (n.state.mode, tuple(n.state.values.values()), last, n.state.time if timed else None)
                if key not in alike:
                    alike[key] = self._along(n.state, last, atom)
                listed.append(alike[key])
            self.known[atom] = listed
        return self.known[atom]

    def _along(self, state: State, last: Q, atom: Expr) -> list[Item]:
        model = self.motion.model
        scope = model.timed_scope(state.mode)
        left = residual(atom, Situation(model.automaton.modes[state.mode].name))
        f, g = (self.motion.along(stronger(scope.formula(spread(e)), PI), state) for e in (left, denial(left)))
        good, bad = where_true(f, NOW, (Q(0), last), self.ranges)
        if g != negation(f):
            bad = where_true(g, NOW, (Q(0), last), self.ranges)[0]
        return items(good, bad, (last, 1))

    def landing(self, n: int, atom: Expr) -> bool | None:
        """The truth of an atom just after the n-th jump."""
        node, model = self.nodes[n], self.motion.model
        assert node.step is not None and node.parent is not None, "a landing has a step"
        edge = model.automaton.edges[node.step.edge]
        scope = model.landing(node.step.edge)
        left = residual(atom, Situation(edge.target, edge.source, edge.name))
        before = self.motion.known(self.motion.at(node.parent.state, node.step.dwell))
        values = {**before, **{f"{v}'": x for v, x in node.step.values}}
        for e, value in ((left, True), (denial(left), False)):
            if holds(stronger(scope.formula(spread(e)), PI), values):
                return value
        return None

    def signal(self, atom: Expr) -> Signal:
        """Where an atom holds."""
        found = [spans_of(x) for x in self.items(atom)]
        if any(n.op in EVENTS for n in nodes(atom)):
            found[1:] = [self._landed(n, atom, *found[n]) for n in range(1, len(found))]
        if self.lost:
            found.append(((), ((ZERO, (self.horizon + TAIL, 1)),)))
        return Signal(tuple(must for must, _ in found), tuple(may for _, may in found))

    def _landed(self, n: int, atom: Expr, must: Spans, may: Spans) -> tuple[Spans, Spans]:
        first: tuple[Cut, Cut] = (ZERO, (Q(0), 1))
        later: Spans = ((first[1], (self.dwells()[n] + 1, 1)),)
        value = self.landing(n, atom)
        must = joined((*common(must, later), *([first] if value else [])))
        return must, joined((*common(may, later), *([first] if value is not False else [])))

    def holds(self, stl: Stl, atoms: tuple[tuple[Expr, Expr], ...]) -> bool | None:
        """The truth of the formula at the start."""
        return at_start(self.value(stl, atoms))

    def value(self, stl: Stl, atoms: tuple[tuple[Expr, Expr], ...]) -> Signal:
        """Where the formula holds; each atom is given as it reads where more makes the whole truer, and less."""
        return stl.value(self.timeline(), (Q(1), Q(1)), lambda n, up: self.signal(atoms[n][0 if up else 1]))


def runs(motion: Motion, horizon: Q, work: Work) -> Iterator[Followed]:
    """Some runs past the horizon, or to where they are stuck, under the motion's params."""
    explorer = Explorer(motion, horizon + 1, True)
    stack = [Node(s, None, None) for s in _starts(motion)]
    stack.reverse()
    while stack and work.spend(1):
        node = stack.pop()
        stay = explorer.stay(node.state)
        if stay is None or _seen_before(node):
            continue
        left = horizon - node.state.time
        if stay[0] > left:
            yield Followed(motion, node, left + min(stay[0] - left, Q(1)) / 2, horizon)
        children = [c for c in explorer.children(node) if c.step is not None and c.state.time <= horizon]
        if not children and stay[0] <= left:
            yield Followed(motion, node, stay[0], horizon)
        stack.extend(reversed(children))


def _seen_before(node: Node) -> bool:
    """Whether the run was in the same state at the same instant before: it may go round for ever."""
    here, state = node.parent, node.state
    while here is not None and here.state.time == state.time:
        if here.state.mode == state.mode and here.state.values == state.values:
            return True
        here = here.parent
    return False


def _starts(motion: Motion) -> list[State]:
    """Some starts, the middle ones first."""
    listed = []
    for n, state in enumerate(motion.starts()):
        listed.append(state)
        if n == 26:
            break
    return listed[::-1]


def assumed(setting: Setting, run: Followed) -> bool:
    """Whether everything assumed holds at every instant of the run."""
    listed = (*setting.model.spec.assumptions, *setting.claim.assume)
    if not listed:
        return True
    for n, dwell in zip(run.nodes, run.dwells(), strict=True):
        scope = run.motion.model.timed_scope(n.state.mode)
        f: Formula = run.motion.along(stronger(conjunction(scope.formula(a) for a in listed), PI), n.state)
        good, _ = where_true(f, NOW, (Q(0), dwell), run.ranges)
        if good != ((ZERO, (dwell, 1)),):
            return False
    return True
