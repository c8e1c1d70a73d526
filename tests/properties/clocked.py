"""Random small clock-driven machines: their text as `.ha`, and exact runs of them, both from the same description.

The simulator shares nothing with the analyses: clocks are linear in time, so every condition changes its truth only
where a clock passes a number; it is looked at there and once in between.
"""

from dataclasses import dataclass, field
from fractions import Fraction as Q
from itertools import pairwise

from hypothesis import strategies as st

COMPARE = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}


@dataclass(frozen=True)
class Bound:
    """A comparison of a clock with a number; of `on` with a truth value (`==`)."""

    clock: str
    op: str
    number: Q

    def text(self):
        if self.clock == "on":
            return "on" if self.number else "not on"
        return f"{self.clock} {self.op} {show(self.number)}"

    def holds(self, values, closed=False):
        op = {"<": "<=", ">": ">="}.get(self.op, self.op) if closed else self.op
        return COMPARE[op](values[self.clock], self.number)


@dataclass(frozen=True)
class Jump:
    """An edge: `resets` gives a number, or a pair for a choice between two."""

    name: str
    source: int
    target: int
    urgent: bool
    guard: tuple
    resets: tuple


@dataclass(frozen=True)
class Machine:
    """Clocks x and perhaps y, perhaps a switch `on`, perhaps params `k` (speed) and `amp` (amplitude of f)."""

    slopes: tuple  # of y, by mode; None where there is no y
    domains: tuple
    edges: tuple
    outputs: tuple  # coefficients of f in x, lowest power first, by mode
    start: tuple  # of x
    has_switch: bool
    has_speed: bool
    has_amplitude: bool

    @property
    def modes(self):
        return len(self.domains)

    def clocks(self):
        return ("x", "y") if self.slopes[0] is not None else ("x",)


def show(q):
    return str(q) if q.denominator == 1 else f"({q.numerator} / {q.denominator})"


def text(m, claims):
    """The machine and claims about it as `.ha`."""
    lines = ['spec "random" version "1.0" unitless']
    lines += ["param k in [1/2, 2]"] * m.has_speed + ["param amp in [-1, 2]"] * m.has_amplitude
    lines += ["automaton A {", *(f"  var {c}" for c in m.clocks()), *["  var on: bool"] * m.has_switch]
    low, high = m.start
    first = f"x := {show(low)}" if low == high else f"x in [{show(low)}, {show(high)}]"
    starts = [first, *["y := 0"] * (len(m.clocks()) > 1), *["on := false"] * m.has_switch]
    lines.append(f"  init M0 with {{ {'; '.join(starts)} }}")
    for i in range(m.modes):
        lines += [*_mode(m, i), "  }"]
    return "\n".join([*lines, "}", *(f"property c{n} on A {{ {c} }}" for n, c in enumerate(claims))]) + "\n"


def _mode(m, i):
    rate = "k" if m.has_speed else "1"
    yield f"  mode M{i} {{"
    if m.domains[i]:
        yield f"    domain {' and '.join(b.text() for b in m.domains[i])}"
    slope = m.slopes[i]
    yield f"    flow {{ x' = {rate}" + ("" if slope is None else f"; y' = {show(slope)} * {rate}") + " }"
    powers = " + ".join(f"{show(c)} * x^{n}" if n else show(c) for n, c in enumerate(m.outputs[i]))
    yield f"    let f = {'amp * ' if m.has_amplitude else ''}({powers})"
    for e in m.edges:
        if e.source == i:
            when = f" when {' and '.join(b.text() for b in e.guard)}" if e.guard else ""
            resets = "; ".join(_reset(v, to) for v, to in e.resets)
            done = f" do {{ {resets} }}" if resets else ""
            yield f"    {'urgent ' * e.urgent}edge {e.name}: -> M{e.target}{when}{done}"


def _reset(v, to):
    if v == "on":
        return f"on := {'true' if to else 'false'}"
    return f"{v} in [{show(to[0])}, {show(to[1])}]" if isinstance(to, tuple) else f"{v} := {show(to)}"


numbers = st.sampled_from([Q(n, 2) for n in range(7)])
small = st.sampled_from([Q(n) for n in range(-3, 4)])


@st.composite
def machines(draw):
    modes = draw(st.integers(1, 3))
    has_y, has_switch = draw(st.booleans()), draw(st.booleans())
    clocks = ["x", "y"] if has_y else ["x"]
    slopes = tuple(draw(st.sampled_from([Q(1), Q(-1), Q(0), Q(2)])) if has_y else None for _ in range(modes))
    domains = tuple(tuple(draw(_domain(clocks))) for _ in range(modes))
    edges = tuple(draw(_edge(n, modes, clocks, has_switch)) for n in range(draw(st.integers(1, 4))))
    outputs = tuple(tuple(draw(st.lists(small, min_size=1, max_size=4))) for _ in range(modes))
    low = draw(numbers)
    start = (low, low + draw(st.sampled_from([Q(0), Q(0), Q(1, 2)])))
    return Machine(slopes, domains, edges, outputs, start, has_switch, draw(st.booleans()), draw(st.booleans()))


@st.composite
def _domain(draw, clocks):
    bounds = [Bound("x", draw(st.sampled_from(["<=", "<=", "<"])), draw(numbers) + 1)]
    if len(clocks) > 1 and draw(st.booleans()):
        bounds.append(Bound("y", draw(st.sampled_from(["<=", ">="])), draw(small)))
    return bounds if draw(st.integers(0, 5)) else bounds[1:]


@st.composite
def _edge(draw, n, modes, clocks, has_switch):
    guard = [Bound(draw(st.sampled_from(clocks)), draw(st.sampled_from([">=", ">", ">=", "<=", "<"])), draw(numbers))]
    if draw(st.booleans()):
        guard.append(Bound(draw(st.sampled_from(clocks)), draw(st.sampled_from([">=", "<="])), draw(numbers)))
    if has_switch and draw(st.booleans()):
        guard.append(Bound("on", "==", draw(st.sampled_from([Q(0), Q(1)]))))
    resets = []
    for v in clocks:
        kind = draw(st.integers(0, 3))
        if kind == 1:
            resets.append((v, draw(numbers)))
        elif kind == 2:
            low = draw(numbers)
            resets.append((v, (low, low + draw(st.sampled_from([Q(1, 2), Q(1)])))))
        elif kind == 3:
            resets.append((v, Q(0)))
    if has_switch and draw(st.booleans()):
        resets.append(("on", draw(st.sampled_from([Q(0), Q(1)]))))
    source, target = draw(st.integers(0, modes - 1)), draw(st.integers(0, modes - 1))
    return Jump(f"e{n}", source, target, draw(st.booleans()), tuple(guard), tuple(resets))


@dataclass(frozen=True)
class Instant:
    """What a run is at one instant: `edge` where it has just jumped, and `before` the instant before that."""

    mode: int
    values: dict
    time: Q
    jumps: int
    edge: Jump | None = None
    before: "Instant | None" = None


@dataclass
class Walker:
    """Random exact runs under one choice of params; `stuck` says of each run whether it ended so."""

    machine: Machine
    speed: Q
    amplitude: Q
    horizon: Q
    pick: object  # random.Random
    instants: list = field(default_factory=list)

    def f(self, at):
        value = sum(c * at.values["x"] ** n for n, c in enumerate(self.machine.outputs[at.mode]))
        return value * self.amplitude if self.machine.has_amplitude else value

    def walk(self, jumps=5):
        """One run: its instants in order, and how it ended: `late`, `stuck` or `cut`; None where nothing can start."""
        m = self.machine
        x = self.pick.choice([m.start[0], m.start[1], (m.start[0] + m.start[1]) / 2])
        at = Instant(0, {"x": x, "y": Q(0), "on": Q(0)}, Q(0), 0)
        if not self.inside(0, at.values):
            return None
        seen = [at]
        for _ in range(jumps):
            cuts = self.cuts(at)
            stay, limit = self.stay(at, cuts)
            leaving = [e for e in m.edges if e.source == at.mode]
            options = [
                (t, e, found) for t in moments(cuts, stay) for e in leaving if (found := self.fired(e, at, t, cuts))
            ]
            go_on = not limit and (not options or self.pick.random() < 0.2)
            if go_on or not options:
                seen += [self.after(at, t) for t in moments(cuts, stay)]
                return seen, "stuck" if limit else "late"
            t, e, outcomes = self.pick.choice(options[-2:] if self.pick.random() < 0.5 else options)
            seen += [self.after(at, u) for u in moments(cuts, t)]
            last = self.after(at, t)
            at = Instant(e.target, self.pick.choice(outcomes), last.time, last.jumps + 1, e, last)
            seen.append(at)
            if at.time > self.horizon:
                return seen, "late"
        return seen, "cut"

    def inside(self, mode, values):
        return all(b.holds(values, closed=True) for b in self.machine.domains[mode])

    def after(self, at, t):
        if t == 0:
            return at
        slope = {"x": Q(1), "y": self.machine.slopes[at.mode] or Q(0), "on": Q(0)}
        values = {v: x + slope[v] * self.speed * t for v, x in at.values.items()}
        return Instant(at.mode, values, at.time + t, at.jumps)

    def cuts(self, at):
        """The dwells at which some condition may change, and one beyond."""
        numbers = {b.number for d in self.machine.domains for b in d} | {
            b.number for e in self.machine.edges for b in e.guard
        }
        slopes = {"x": Q(1), "y": self.machine.slopes[at.mode] or Q(0)}
        found = {(n - at.values[v]) / (c * self.speed) for v, c in slopes.items() if c for n in numbers}
        found = {t for t in found if t > 0}
        return sorted({Q(0), *found, max(found, default=Q(0)) + self.horizon + 1})

    def enabled(self, e, values):
        return all(b.holds(values) for b in e.guard) and bool(self.outcomes(e, values))

    def is_due(self, e, at, t, following):
        """Enabled at the dwell, or throughout the open stretch that follows."""
        return self.enabled(e, self.after(at, t).values) or self.enabled(e, self.after(at, (t + following) / 2).values)

    def stay(self, at, cuts):
        """The longest dwell, and whether a run cannot stay longer."""
        urgent = [e for e in self.machine.edges if e.urgent and e.source == at.mode]
        for t, following in pairwise(cuts):
            if any(self.is_due(e, at, t, following) for e in urgent):
                return t, True
            if not self.inside(at.mode, self.after(at, (t + following) / 2).values):
                return t, True
        return cuts[-1], False

    def fired(self, e, at, t, cuts):
        """The outcomes of the edge at this dwell: none unless it is enabled there, or urgent and due."""
        values = self.after(at, t).values
        if all(b.holds(values) for b in e.guard):
            return self.outcomes(e, values)
        following = next((c for c in cuts if c > t), t + 1)
        return self.outcomes(e, values) if e.urgent and self.is_due(e, at, t, following) else []

    def outcomes(self, e, values):
        """Some outcomes in the target's domain; none only where there is none."""
        choices = [dict(values)]
        for v, to in e.resets:
            options = self.allowed(v, to, e.target) if isinstance(to, tuple) else [to]
            choices = [{**c, v: x} for c in choices for x in options]
        return [c for c in choices if self.inside(e.target, c)]

    def allowed(self, v, to, mode):
        """Some values between the two that the domain allows for this clock; none only where there is none."""
        low, high = to
        for b in self.machine.domains[mode]:
            if b.clock == v:
                low, high = (low, min(high, b.number)) if b.op[0] == "<" else (max(low, b.number), high)
        return [low, (low + high) / 2, high] if low <= high else []


def moments(cuts, stay):
    """The cuts up to the stay, and dwells between them."""
    kept = [c for c in cuts if c < stay] + [stay]
    between = [a + (b - a) * q for a, b in pairwise(kept) for q in (Q(1, 3), Q(9, 10))]
    return sorted({*kept, *between})
