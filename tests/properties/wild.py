"""Automata with flows of all sorts, by chance: their text as `.ha`, and runs of them by an integrator of its own.

Nothing here is shared with the analyses. Runs are Runge-Kutta steps in floats under inputs that change by chance; where
an urgent guard comes to hold or the domain ends, the instant is bisected.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

NEAR = 1e-9  # how far an event may be missed by bisection in floats

Values = dict[str, float]
Ends = tuple[float, float]
NAMES: dict[str, Any] = {"sin": math.sin, "cos": math.cos, "exp": math.exp, "abs": abs, "min": min, "max": max}
CHOSEN = re.compile(r"\bif (.+?) then (.+?) else (.+?)\)")


@cache
def compiled(formula: str) -> Callable[[Mapping[str, float]], Any]:
    """A formula of the language that is one of Python's as well, but for powers, truths and `(if a then b else c)`."""
    told = CHOSEN.sub(r"(\2) if (\1) else (\3))", formula.replace("^", "**"))
    told = re.sub(r"\b(true|false)\b", lambda m: m[0].capitalize(), told)
    code = compile(told, formula, "eval")
    return lambda values: eval(code, {"__builtins__": {}, **NAMES}, values)  # type: ignore[arg-type]


def holds(condition: str, values: Mapping[str, float], slack: float = 0.0) -> bool:
    """A conjunction of comparisons; with slack also where one misses by less than that."""
    return all(_near(part, values, slack) for part in condition.split(" and "))


def _near(part: str, values: Mapping[str, float], slack: float) -> bool:
    op = next((o for o in ("<=", ">=", "==", "!=", "<", ">") if o in part), None)
    if op is None or op == "!=" or slack == 0.0:
        return bool(compiled(part)(values))
    left, right = (float(compiled(side.strip())(values)) for side in part.split(op))
    if op == "==":
        return abs(left - right) <= slack
    gap = right - left if op[0] == "<" else left - right
    return gap > -slack and (gap != 0.0 or "=" in op)


@dataclass(frozen=True)
class Edge:
    name: str
    source: str
    target: str
    guard: str
    resets: Mapping[str, str | Ends] = field(default_factory=dict)
    urgent: bool = True

    def text(self) -> str:
        made = [f"{v} in [{e[0]}, {e[1]}]" if isinstance(e, tuple) else f"{v} := {e}" for v, e in self.resets.items()]
        done = f" do {{ {'; '.join(made)} }}" if made else ""
        return f"  {'urgent ' * self.urgent}edge {self.name}: {self.source} -> {self.target} when {self.guard}{done}"


@dataclass(frozen=True)
class Model:
    """Starts in a mode from a box; for each mode a domain and rates, or ends of rates."""

    mode: str
    start: Mapping[str, Ends]
    modes: Mapping[str, tuple[str, Mapping[str, str | tuple[str, str]]]]
    edges: tuple[Edge, ...] = ()
    params: Mapping[str, Ends] = field(default_factory=dict)
    inputs: Mapping[str, Ends] = field(default_factory=dict)
    windows: Mapping[str, Ends] = field(default_factory=dict)
    # Discrete variables with their type and first value: numbers of an enum, or truths.
    discrete: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    more: tuple[str, ...] = ()

    def text(self) -> str:
        lines = ['spec "wild" version "1.0" unitless', "enum Count = 0..3", *self.more]
        lines += [f"param {p} in [{low}, {high}]" for p, (low, high) in self.params.items()]
        lines += [f"input {p} in [{low}, {high}]" for p, (low, high) in self.inputs.items()]
        ranged = {v: f" in [{low}, {high}]" for v, (low, high) in self.windows.items()}
        lines += ["automaton A {", *(f"  var {v}{ranged.get(v, '')}" for v in self.start)]
        lines += [f"  var {d}: {kind}" for d, (kind, _) in self.discrete.items()]
        within = " and ".join(f"{low} <= {v} <= {high}" for v, (low, high) in self.start.items())
        first = "; ".join(f"{d} := {self.first(d)}" for d in self.discrete)
        lines.append(f"  init {self.mode} where {within}" + (f" with {{ {first} }}" if first else ""))
        for name, (domain, rates) in self.modes.items():
            flow = "; ".join(
                f"{v}' in [{e[0]}, {e[1]}]" if isinstance(e, tuple) else f"{v}' = {e}" for v, e in rates.items()
            )
            lines.append(f"  mode {name} {{ domain {domain}; flow {{ {flow} }} }}")
        return "\n".join([*lines, *(e.text() for e in self.edges), "}"])

    def first(self, name: str) -> str:
        kind, value = self.discrete[name]
        return ("true" if value else "false") if kind == "bool" else str(value)


@dataclass(frozen=True)
class Instant:
    """A state of a run; at a landing also the edge, and the values before it."""

    mode: str
    values: Values
    edge: Edge | None = None
    before: Values = field(default_factory=dict)


@dataclass
class Runner:
    """One run of a model; a source of chance decides what the model leaves open.

    `over` says how it ended: `horizon`, `stuck`, or `jumps` where it was given up.
    """

    model: Model
    chance: random.Random
    step: float = 0.02
    eager: float = 0.1
    inputs: Values = field(default_factory=dict)
    shares: Values = field(default_factory=dict)
    over: str = ""

    def point(self, box: Mapping[str, Ends]) -> Values:
        """A point of a box, its ends and its middle more often than chance would have it."""
        shares = {v: self.chance.choice([0.0, 1.0, 0.5, self.chance.random(), self.chance.random()]) for v in box}
        return {v: low + shares[v] * (high - low) for v, (low, high) in box.items()}

    def begin(self) -> Values:
        discrete = {d: float(v) for d, (_, v) in self.model.discrete.items()}
        return {**self.point({**self.model.start, **self.model.params}), **discrete}

    def run(self, start: Values, horizon: float, most: int = 60) -> Iterator[Instant]:
        """The states of one run up to a horizon."""
        self.eager = self.chance.choice([0.0, 0.02, 0.2, 1.0])
        hold = self.chance.choice([1, 10, 10**6])
        now, jumps, steps = Instant(self.model.mode, {**start, "time": 0.0}), 0, 0
        self.over = "horizon"
        yield now
        while now.values["time"] < horizon:
            if steps % hold == 0:
                self._blow()
            steps += 1
            after = self._next(now, min(self.step, horizon - now.values["time"]))
            if after is None:
                self.over = "stuck"
                return
            jumps += after.edge is not None
            if jumps > most or abs(sum(after.values.values())) > 1e6:
                self.over = "jumps"
                return
            now = after
            yield now

    def _blow(self) -> None:
        self.inputs = self.point(self.model.inputs)
        included = [(m, v) for m, (_, rates) in self.model.modes.items() for v in rates]
        self.shares = {f"{m}.{v}": self.chance.choice([0.0, 1.0, self.chance.random()]) for m, v in included}

    def _next(self, now: Instant, h: float) -> Instant | None:
        own = [e for e in self.model.edges if e.source == now.mode]
        due = [e for e in own if e.urgent and holds(e.guard, now.values) and self._made(e, now) is not None]
        if due or self.chance.random() < self.eager:
            ready = [e for e in own if holds(e.guard, now.values)]
            self.chance.shuffle(ready)
            landed = next((x for x in (self._made(e, now) for e in ready) if x is not None), None)
            if landed is not None:
                return landed
        futile: list[str] = []
        while True:
            ends = self._ends(now.mode, self._flown(now, h), futile)
            if ends is None:
                return Instant(now.mode, self._flown(now, h))
            low, high = 0.0, h
            while low < (middle := (low + high) / 2) < high and high - low > 1e-15:
                found = self._ends(now.mode, self._flown(now, middle), futile)
                if found is None:
                    low = middle
                else:
                    high, ends = middle, found
            at = Instant(now.mode, self._flown(now, high))
            ready = [e for e in own if holds(e.guard, at.values, NEAR)]
            self.chance.shuffle(ready)
            landed = next((x for x in (self._made(e, at) for e in ready) if x is not None), None)
            if landed is not None:
                return landed
            if ends == "domain":
                return None
            futile.append(ends)

    def _ends(self, mode: str, values: Values, futile: list[str]) -> str | None:
        """What ends the stay at a state: the domain, or an urgent edge by name."""
        if not holds(self.model.modes[mode][0], values):
            return "domain"
        own = (e for e in self.model.edges if e.source == mode and e.urgent and e.name not in futile)
        return next((e.name for e in own if holds(e.guard, values)), None)

    def _made(self, edge: Edge, at: Instant) -> Instant | None:
        """The landing of a jump; None where no outcome of it that was tried is in the target's domain."""
        for _ in range(8):
            after = dict(at.values)
            for v, e in edge.resets.items():
                after[v] = self._chosen(e) if isinstance(e, tuple) else float(compiled(e)(at.values))
            if holds(self.model.modes[edge.target][0], after, NEAR):
                return Instant(edge.target, after, edge, at.values)
        return None

    def _chosen(self, ends: Ends) -> float:
        return ends[0] + self.chance.choice([0.0, 1.0, self.chance.random()]) * (ends[1] - ends[0])

    def _flown(self, now: Instant, h: float) -> Values:
        """A Runge-Kutta step of order 4."""
        rates = self.model.modes[now.mode][1]

        def slope(values: Values) -> Values:
            known = {**values, **self.inputs}
            found = {}
            for v, e in rates.items():
                if isinstance(e, tuple):
                    low, high = (float(compiled(x)(known)) for x in e)
                    found[v] = low + self.shares.get(f"{now.mode}.{v}", 0.5) * (high - low)
                else:
                    found[v] = float(compiled(e)(known))
            return found

        def moved(by: Values, h: float) -> Values:
            return {**{v: x + h * by.get(v, 0.0) for v, x in now.values.items()}, "time": now.values["time"] + h}

        k1 = slope(now.values)
        k2 = slope(moved(k1, h / 2))
        k3 = slope(moved(k2, h / 2))
        k4 = slope(moved(k3, h))
        return moved({v: (k1[v] + 2 * k2[v] + 2 * k3[v] + k4[v]) / 6 for v in rates}, h)


def wild(chance: random.Random, kinds: frozenset[str] = frozenset()) -> Model:
    """One to three modes, contracting and other rates, edges at straight lines; `kinds` asks for more than usual."""
    return _Maker(chance, kinds).model()


@dataclass
class _Maker:
    chance: random.Random
    kinds: frozenset[str]
    params: dict[str, Ends] = field(default_factory=dict)
    inputs: dict[str, Ends] = field(default_factory=dict)

    def number(self, low: float, high: float, digits: int = 2) -> float:
        return round(self.chance.uniform(low, high), digits)

    def model(self) -> Model:
        r = self.chance
        names = ["P", "B", "C"][: r.choice([1, 1, 2, 2, 3])]
        if r.random() < 0.35:
            self.params["k"] = (0.8, 1.2)
        if r.random() < 0.3 or "inputs" in self.kinds:
            self.inputs["u"] = r.choice([(-0.1, 0.1), (0.0, 0.2), (0.5, 0.6)])
        modes = {m: (self.domain(), self.rates()) for m in names}
        edges = [self.edge(k, names) for k in range(r.choice([0, 1, 2, 2, 3]))]
        start = {v: self.side() for v in "xy"}
        windows = {"x": (-3.0, 3.0)} if r.random() < 0.15 else {}
        made = Model("P", start, modes, tuple(edges), self.params, self.inputs, windows)
        return self.counting(made) if "discrete" in self.kinds else made

    def counting(self, made: Model) -> Model:
        """The model with a counter or a truth that edges read and change."""
        edges = []
        for e in made.edges:
            kind = self.chance.choice(["count", "flip", "", "reset"])
            if kind == "count":
                e = replace(e, guard=f"{e.guard} and n < 3", resets={**e.resets, "n": "n + 1"})
            elif kind == "flip":
                e = replace(e, guard=f"{e.guard} and on == {self.chance.choice(['true', 'false'])}")
                e = replace(e, resets={**e.resets, "on": "not on"})
            elif kind == "reset":
                e = replace(e, guard=f"{e.guard} and n >= 2", resets={**e.resets, "n": "0"})
            edges.append(e)
        first = {"n": ("Count", self.chance.choice([0, 0, 1])), "on": ("bool", self.chance.choice([0, 1]))}
        return replace(made, edges=tuple(edges), discrete=first)

    def side(self) -> Ends:
        low = self.number(-1, 1, 1)
        return low, round(low + self.chance.choice([0, 0.1, 0.25, 0.5]), 2)

    def domain(self) -> str:
        return self.chance.choice(["true", "true", "true", "x <= 1.5", "x >= -1.5", "x <= 1 and y <= 2", "x + y <= 1"])

    def rates(self) -> dict[str, str | tuple[str, str]]:
        r = self.chance
        k, u = ("k" if self.params else "1"), (" + u" if self.inputs and r.random() < 0.7 else "")
        a, s = self.number(0.3, 1.5), self.number(-1, 1)
        found: dict[str, str | tuple[str, str]] = {
            "lin": {"x": f"{s} - {a} * {k} * x{u}", "y": "x / 2 - y"},
            "spiral": {"x": f"y - {a} * x", "y": f"-x * {k} - {a} * y{u}"},
            "cubic": {"x": f"{s} - {k} * x^3 - x{u}", "y": "sin(x) - y"},
            "growth": {"x": f"{a}{u}", "y": f"{k} * x - 2 * y"},
            "centre": {"x": "y", "y": f"-{k} * x{u}"},
            "timer": {"x": "1", "y": f"{s}{u} - y"},
            "waves": {"x": f"{s} * sin(y){u} - x / 2", "y": f"cos(x) - {k} * y"},
        }[r.choice(["lin", "lin", "spiral", "cubic", "growth", "centre", "timer", "waves"])]  # type: ignore[assignment]
        if r.random() < 0.12:
            found["y"] = (f"-y - {a}", f"{a} - y") if r.random() < 0.5 else ("-0.5", "0.25")
        if "corners" in self.kinds:
            corner = r.choice(["abs(x)", "max(x, y)", "min(x, 0.3)", "max(-0.4, min(0.4, x - y))", "x * abs(x)",
                               "(if x < 0 then 0 else x)", "max(0, x + y) * y"])  # fmt: skip
            v = r.choice("xy")
            if not isinstance(found[v], tuple):
                found[v] = f"{found[v]} {r.choice('+-')} {self.number(0.2, 1)} * {corner}"
        return found

    def edge(self, k: int, names: list[str]) -> Edge:
        r = self.chance
        v, g, rising = r.choice(["x", "x", "x", "y", "x + y"]), self.number(-1, 1), r.random() < 0.5
        guard = f"{v} {r.choice(['>=', '>'] if rising else ['<=', '<'])} {g}"
        if r.random() < 0.2:
            guard += f" and y {r.choice(['<=', '>='])} {self.number(-1, 1)}"
        if r.random() < 0.1:
            guard += f" and {v} {'<=' if rising else '>='} {round(g + (0.4 if rising else -0.4), 2)}"
        away = self.number(0.1, 1)
        back = round(g - away if rising else g + away, 2)
        w = v if v in "xy" else "x"
        resets = r.choice([
            {w: f"{back}"}, {w: f"{back}"}, {}, {"y": "-y / 2"}, {w: f"{w} / 2"}, {"x": "y", "y": "x"},
            {w: (back, round(back + 0.25, 2))}, {w: (round(back - 0.1, 2), back), "y": "y + 0.1"},
        ])  # fmt: skip
        return Edge(f"e{k}", r.choice(names), r.choice(names), guard, resets, r.random() < 0.65)
