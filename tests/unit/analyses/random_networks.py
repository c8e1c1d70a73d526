"""Random small systems: their text as `.ha`, and an interpreter of LANGUAGE S7 to S18 on single states.

The interpreter shares nothing with the analyses: it reads the descriptions below, knows no zones and no core, and lets
time pass in steps. Every part has a clock x and a counter n in 0..2; the system has a variable v in 0..2.
"""

from dataclasses import dataclass
from fractions import Fraction as Q
from itertools import product

from hypothesis import strategies as st

COMPARE = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
}
TOP = 3  # the largest constant a clock is compared with or set to


@dataclass(frozen=True)
class Edge:
    """`x`, `n`: (comparison, number) or None; `set_x`: None, a number or a pair; `set_n`: None, a number or "+1"."""

    name: str
    source: int
    target: int
    urgent: bool
    x: tuple | None
    n: tuple | None
    set_x: object
    set_n: object


@dataclass(frozen=True)
class Part:
    name: str
    domains: tuple  # upper bound of x in each mode, or None
    edges: tuple


@dataclass(frozen=True)
class Sync:
    """`edges`, `listeners`: (part, edge); `v`: a number v has to be, or None; `set_v`: None or a number."""

    name: str
    edges: tuple
    listeners: tuple
    v: int | None
    set_v: int | None


@dataclass(frozen=True)
class Net:
    parts: tuple
    syncs: tuple
    priorities: tuple  # (higher, lower, v or None)

    def text(self):
        lines = ["enum Count = 0..2"]
        for p in self.parts:
            lines += [f"automaton {p.name.upper()} {{", "  var x: s", "  var n: Count"]
            lines += ["  init M0 with { x := 0 s; n := 0 }", "  flow { x' = 1 }"]
            for m, top in enumerate(p.domains):
                inner = [f"domain x <= {top} s"] * (top is not None)
                inner += [edge_text(e) for e in p.edges if e.source == m]
                lines.append(f"  mode M{m} {{ {'; '.join(inner)} }}" if inner else f"  mode M{m} {{ domain true }}")
            lines.append("}")
        lines += ["system S {", "  var v: Count", "  init with v := 0"]
        lines += [f"  part {p.name} = {p.name.upper()}" for p in self.parts]
        for s in self.syncs:
            heard = " -> " + ", ".join(f"{p}.{e}" for p, e in s.listeners) if s.listeners else ""
            guard = f" when v == {s.v}" if s.v is not None else ""
            change = f" do v := {s.set_v}" if s.set_v is not None else ""
            lines.append(f"  sync {s.name}: {', '.join(f'{p}.{e}' for p, e in s.edges)}{heard}{guard}{change}")
        for a, b, v in self.priorities:
            lines.append(f"  priority {a} over {b}" + (f" when v == {v}" if v is not None else ""))
        return "\n".join([*lines, "}"])


def edge_text(e):
    guards = [f"{name} {g[0]} {g[1]}{unit}" for name, g, unit in (("x", e.x, " s"), ("n", e.n, "")) if g is not None]
    sets = []
    if e.set_x is not None:
        sets.append("x in [{} s, {} s]".format(*e.set_x) if isinstance(e.set_x, tuple) else f"x := {e.set_x} s")
    if e.set_n is not None:
        sets.append("n := if n == 2 then 0 else n + 1" if e.set_n == "+1" else f"n := {e.set_n}")
    when = f" when {' and '.join(guards)}" if guards else ""
    do = f" do {{ {'; '.join(sets)} }}" if sets else ""
    return f"{'urgent ' * e.urgent}edge {e.name}: -> M{e.target}{when}{do}"


class Interpreter:
    """States are (modes, counters, v, clocks); `step` is the distance of the clock values looked at."""

    def __init__(self, net, step):
        self.net, self.step = net, step
        self.index = {p.name: k for k, p in enumerate(net.parts)}
        taken = {x for s in net.syncs for x in (*s.edges, *s.listeners)}
        single = dict.fromkeys((p.name, e.name) for p in net.parts for e in p.edges if (p.name, e.name) not in taken)
        self.interactions = [*(Sync(f"{p}.{e}", ((p, e),), (), None, None) for p, e in single), *net.syncs]
        self.higher = {}
        for a, b, v in net.priorities:
            self.higher.setdefault(b, []).append((a, v))

    def start(self):
        k = len(self.net.parts)
        return (0,) * k, (0,) * k, 0, (Q(0),) * k

    def edge(self, state, part, name, xs):
        """The edge of that name in the current mode, where its guard holds for the clocks xs; else None."""
        k = self.index[part]
        for e in self.net.parts[k].edges:
            if e.name == name and e.source == state[0][k]:
                good = e.x is None or COMPARE[e.x[0]](xs[k], e.x[1])
                if good and (e.n is None or COMPARE[e.n[0]](state[1][k], e.n[1])):
                    return e
        return None

    def values(self, e, x):
        if not isinstance(e.set_x, tuple):
            return [x if e.set_x is None else Q(e.set_x)]
        low, high = e.set_x
        return [low + i * self.step for i in range(int((high - low) / self.step) + 1)]

    def alone(self, state, part, e, x):
        """The results of an edge for its own part: those inside the target's domain."""
        k = self.index[part]
        top = self.net.parts[k].domains[e.target]
        return [y for y in self.values(e, x) if top is None or y <= top]

    def results(self, state, sync, at=None):
        """The states an interaction leads to, without priorities; `at`: the clocks for the guards, if others."""
        modes, ns, v, xs = state
        seen = xs if at is None else at
        if sync.v is not None and v != sync.v:
            return []
        chosen = [(p, self.edge(state, p, e, seen)) for p, e in sync.edges]
        if any(e is None for _, e in chosen):
            return []
        for p, name in sync.listeners:
            e = self.edge(state, p, name, seen)
            if e is not None and self.alone(state, p, e, seen[self.index[p]]):
                chosen.append((p, e))
        out = []
        for new in product(*(self.alone(state, p, e, xs[self.index[p]]) for p, e in chosen)):
            m, n, x = list(modes), list(ns), list(xs)
            for (p, e), value in zip(chosen, new, strict=True):
                k = self.index[p]
                m[k], x[k] = e.target, value
                n[k] = n[k] if e.set_n is None else (n[k] + 1) % 3 if e.set_n == "+1" else e.set_n
            new_v = v if sync.set_v is None else sync.set_v
            out.append((tuple(m), tuple(n), new_v, tuple(x)))
        return [r for r in out if self.allowed(r)]  # those who take no part may be outside theirs, right after now

    def suppressed(self, state, name, at, depth=0):
        """Is an interaction of higher priority enabled, directly or over others that the priorities name?"""
        for a, v in self.higher.get(name, ()):
            if v is None or state[2] == v:
                above = next(s for s in self.interactions if s.name == a)
                if self.results(state, above, at) or self.suppressed(state, a, at):
                    return True
        return False

    def enabled(self, state, at=None):
        """(interaction, results) of all that may fire, with priorities."""
        found = [(s, self.results(state, s, at)) for s in self.interactions]
        return [(s, r) for s, r in found if r and not self.suppressed(state, s.name, at)]

    def is_urgent(self, state, sync, at):
        seen = state[3] if at is None else at
        names = [*sync.edges]
        for p, name in sync.listeners:
            e = self.edge(state, p, name, seen)
            if e is not None and self.alone(state, p, e, seen[self.index[p]]):
                names.append((p, name))
        return any(self.edge(state, p, e, seen).urgent for p, e in names)

    def due(self, state, ahead):
        """The urgent interactions enabled now or all the time right after, with what they lead to now."""
        xs = tuple(x + ahead for x in state[3])
        later = (*state[:3], xs)
        now = [(s, r) for s, r in self.enabled(state) if self.is_urgent(state, s, None)]
        soon = [s for s, _ in self.enabled(later) if self.is_urgent(later, s, None)]
        return now + [(s, self.results(state, s, xs)) for s in soon]

    def jumps(self, state, ahead):
        """(name, next state) of all jumps, urgent ones about to be enabled included."""
        found = self.enabled(state) + self.due(state, ahead)
        return list(dict.fromkeys((s.name, r) for s, results in found for r in results))

    def waits(self, state):
        """The state one step later, or None: the domains end, or something urgent is due."""
        if self.due(state, self.step / 2):
            return None
        xs = tuple(min(x + self.step, Q(TOP + 1)) if x <= TOP else x for x in state[3])
        later = (*state[:3], xs)
        return later if self.allowed(later) else None

    def allowed(self, state):
        return all(
            top is None or x <= top
            for m, x, p in zip(state[0], state[3], self.net.parts, strict=True)
            for top in [p.domains[m]]
        )

    def is_stuck(self, state):
        return not self.jumps(state, self.step / 2) and self.waits(state) is None

    def explore(self, most=20000):
        """All states reachable in steps, with the least number of jumps to each; None where there are too many."""
        found = {self.start(): 0}
        layer = [self.start()]
        jumps = 0
        while layer:
            for s in layer:  # grows
                later = self.waits(s)
                if later is not None and later not in found:
                    found[later] = jumps
                    layer.append(later)
            new = []
            for s in layer:
                for _, r in self.jumps(s, self.step / 2):
                    if r not in found:
                        found[r] = jumps + 1
                        new.append(r)
            layer, jumps = new, jumps + 1
            if len(found) > most:
                return None
        return found


def comparisons(closed):
    ops = ["<=", ">=", "=="] if closed else ["<", "<=", ">", ">=", "=="]
    return st.one_of(st.none(), st.tuples(st.sampled_from(ops), st.integers(0, TOP)))


@st.composite
def networks(draw, closed):
    """Systems of two or three parts; `closed`: such that whole numbers of seconds decide what is reachable."""
    parts = []
    for k in range(draw(st.integers(2, 3))):
        modes = draw(st.integers(1, 3))
        domains = tuple(draw(st.one_of(st.none(), st.integers(0, TOP))) for _ in range(modes))
        edges, used = [], set()
        for _ in range(draw(st.integers(1, 4))):
            name, source = draw(st.sampled_from(["f", "g", "h"])), draw(st.integers(0, modes - 1))
            if (name, source) in used:
                continue
            used.add((name, source))
            urgent = draw(st.sampled_from([False, False, True]))
            pair = st.tuples(st.integers(0, 1), st.integers(1, TOP)).map(lambda p: (p[0], max(p)))
            set_x = draw(st.one_of(st.none(), st.integers(0, 1), pair))
            x = draw(comparisons(closed))
            if closed and urgent:
                x, set_x = None, 0 if set_x is None else set_x
            n = draw(st.one_of(st.none(), st.tuples(st.sampled_from(["<", ">=", "=="]), st.integers(0, 2))))
            set_n = draw(st.sampled_from([None, 0, 1, 2, "+1"]))
            edges.append(Edge(name, source, draw(st.integers(0, modes - 1)), urgent, x, n, set_x, set_n))
        parts.append(Part("abc"[k], domains, tuple(edges)))
    syncs = draw(st.lists(some_sync(parts, closed), max_size=3))
    syncs = [Sync(f"s{k}", *s) for k, s in enumerate(syncs)]
    net = Net(tuple(parts), tuple(syncs), ())
    return Net(net.parts, net.syncs, tuple(draw(some_priorities(net, closed))))


@st.composite
def some_sync(draw, parts, closed):
    chosen = draw(st.permutations(parts))[: draw(st.integers(1, len(parts)))]
    edges = [(p.name, draw(st.sampled_from(sorted({e.name for e in p.edges})))) for p in chosen]
    split = draw(st.integers(1, len(edges)))

    def hears(p, name):
        part = next(q for q in parts if q.name == p)
        return all(e.x is None and e.set_x is not None for e in part.edges if e.name == name)

    listeners = [x for x in edges[split:] if not closed or hears(*x)]
    v, set_v = (draw(st.one_of(st.none(), st.integers(0, 2))) for _ in range(2))
    return tuple(edges[:split]), tuple(listeners), v, set_v


@st.composite
def some_priorities(draw, net, closed):
    names = [s.name for s in Interpreter(net, Q(1)).interactions]
    if closed:
        return []
    order = draw(st.permutations(names))
    pairs = [(a, b) for i, a in enumerate(order) for b in order[i + 1 :]]
    chosen = draw(st.lists(st.sampled_from(pairs), max_size=3, unique=True)) if pairs else []
    return [(a, b, draw(st.one_of(st.none(), st.integers(0, 2)))) for a, b in chosen]


@dataclass(frozen=True)
class Family:
    """Three interchangeable parts p[1] .. p[3] and a register v in 0..3; `syncs`: (name, edge, v needed, v written).

    The values needed and written are None, 0 or "i", the part's own number.
    """

    part: Part
    syncs: tuple

    def net(self):
        parts = tuple(Part(f"p[{i}]", self.part.domains, self.part.edges) for i in (1, 2, 3))
        own = [
            Sync(f"{n}[{i}]", ((f"p[{i}]", e),), (), i if v == "i" else v, i if w == "i" else w)
            for n, e, v, w in self.syncs
            for i in (1, 2, 3)
        ]
        return Net(parts, tuple(own), ())

    def text(self):
        lines = Net((self.part,), (), ()).text().split("system S")[0].splitlines()
        lines += ["enum I = 1..3", "enum Owner = 0..3", "system S {", "  var v: Owner", "  init with v := 0"]
        lines.append(f"  part p for i in I = {self.part.name.upper()}")
        for n, e, v, w in self.syncs:
            guard = "" if v is None else f" when v == {v}"
            lines.append(f"  sync {n} for i in I: p[i].{e}{guard}" + ("" if w is None else f" do v := {w}"))
        return "\n".join([*lines, "}"])


@st.composite
def families(draw):
    part = draw(networks(closed=True)).parts[0]
    edges = sorted({e.name for e in part.edges})
    some = st.sampled_from([None, 0, "i"])
    syncs = draw(st.lists(st.tuples(st.sampled_from(edges), some, some), min_size=1, max_size=3, unique=True))
    return Family(part, tuple((f"s{k}", *s) for k, s in enumerate(syncs)))
