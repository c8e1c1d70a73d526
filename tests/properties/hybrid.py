"""Small automata with flows and jumps: their text as `.ha`, and sampled runs of them, both from the same description.

Formulas are strings that mean the same in both languages but for `^`. The simulator shares nothing with the analyses:
classical Runge-Kutta steps in floats; where an urgent guard comes to hold or the domain ends, the instant is bisected.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import CodeType
from typing import Any

STEP = 0.01
NEAR = 1e-9  # how far an event may be missed by bisection in floats

Values = dict[str, float]


@dataclass(frozen=True)
class Jump:
    """An edge; `resets` holds formulas or pairs of ends, `event` what comes to hold where the guard is an equation."""

    name: str
    source: str
    target: str
    guard: str
    resets: Mapping[str, str | tuple[float, float]] = field(default_factory=dict)
    urgent: bool = True
    event: str = ""

    def text(self) -> str:
        made = [f"{v} in [{e[0]}, {e[1]}]" if isinstance(e, tuple) else f"{v} := {e}" for v, e in self.resets.items()]
        done = f" do {{ {'; '.join(made)} }}" if made else ""
        kind = "urgent edge" if self.urgent else "edge"
        return f"  {kind} {self.name}: {self.source} -> {self.target} when {self.guard}{done}"


@dataclass(frozen=True)
class Machine:
    """Starts in a mode from a box; for each mode a domain and rates; variables that `first` fixes, params in ranges."""

    name: str
    mode: str
    start: Mapping[str, tuple[float, float]]
    modes: Mapping[str, tuple[str, Mapping[str, str]]]
    jumps: tuple[Jump, ...]
    params: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    terminal: frozenset[str] = frozenset()

    def text(self) -> str:
        lines = ['spec "machine" version "1.0" unitless']
        lines += [f"param {p} in [{low}, {high}]" for p, (low, high) in self.params.items()]
        lines += ["automaton A {", *(f"  var {v}" for v in self.start)]
        within = " and ".join(f"{low} <= {v} <= {high}" for v, (low, high) in self.start.items())
        lines.append(f"  init {self.mode} where {within}")
        for name, (domain, rates) in self.modes.items():
            flow = "; ".join(f"{v}' = {e}" for v, e in rates.items())
            end = "; terminal" if name in self.terminal else ""
            lines.append(f"  mode {name} {{ domain {domain}; flow {{ {flow} }}{end} }}")
        return "\n".join([*lines, *(j.text() for j in self.jumps), "}"])


@dataclass(frozen=True)
class Instant:
    """A state of a run: mode, jumps so far, values with `time`; at a landing the jump and the values before it."""

    mode: str
    jumps: int
    values: Values
    jump: Jump | None = None
    before: Values = field(default_factory=dict)


@cache
def compiled(formula: str) -> CodeType:
    return compile(formula.replace("^", "**"), formula, "eval")


def value(formula: str, values: Mapping[str, float]) -> Any:
    names = {"sin": math.sin, "cos": math.cos, "exp": math.exp, "true": True}
    return eval(compiled(formula), {"__builtins__": {}}, {**names, **values})


def holds(condition: str, values: Mapping[str, float], slack: float = 0.0) -> bool:
    """A conjunction; with slack also where it misses by that much: strict bounds are then as good as closed ones."""
    return all(_near(part, values, slack) for part in condition.split(" and "))


def _near(part: str, values: Mapping[str, float], slack: float) -> bool:
    op = next((o for o in ("<=", ">=", "==", "!=", "<", ">") if o in part), None)
    if op is None or slack == 0.0 or op == "!=":
        return bool(value(part, values))
    left, right = (float(value(side.strip(), values)) for side in part.split(op))
    if op == "==":
        return abs(left - right) <= slack
    return left <= right + slack if op[0] == "<" else left >= right - slack


@dataclass
class Simulator:
    """Runs of a machine; a source of chance decides what the machine leaves open."""

    machine: Machine
    chance: random.Random
    step: float = STEP
    # What to do where several things may happen: a wanted edge by name and its instant, in order.
    script: list[tuple[str, float]] | None = None

    def start(self, box: Mapping[str, tuple[float, float]]) -> Values:
        """A point of a box, its ends and its middle more often than chance would have it."""
        shares = {v: self.chance.choice([0.0, 1.0, 0.5, self.chance.random(), self.chance.random()]) for v in box}
        return {v: low + shares[v] * (high - low) for v, (low, high) in box.items()}

    def run(self, start: Values, horizon: float, most: int = 60) -> Iterator[Instant]:
        """The states of one run up to a horizon, as long as it is neither stuck nor jumps more than `most` times."""
        now = Instant(self.machine.mode, 0, {**start, "time": start.get("time", 0.0)})
        yield now
        while now.values["time"] < horizon and now.jumps <= most:
            after = self._next(now, min(self.step, horizon - now.values["time"]))
            if after is None:
                return
            now = after
            yield now

    def _next(self, now: Instant, h: float) -> Instant | None:
        own = [j for j in self.machine.jumps if j.source == now.mode]
        landed = self._by_chance(own, now) if self.script is None else None
        if landed is not None:
            return landed
        wanted = next((j for j in own if self.script and j.name == self.script[0][0] and not j.urgent), None)
        left = self._left(now) if wanted is not None else h
        if wanted is not None and left <= NEAR and holds(wanted.guard, now.values, NEAR):
            return self._made(wanted, now)
        h = min(h, left) if left > NEAR else h
        if not self._ends(now.mode, self._flown(now, h)):
            return Instant(now.mode, now.jumps, self._flown(now, h))
        low, high = 0.0, h
        if self._ends(now.mode, self._flown(now, 1e-12)):
            high = 1e-12
        while high - low > 1e-15:
            middle = (low + high) / 2
            low, high = (low, middle) if self._ends(now.mode, self._flown(now, middle)) else (middle, high)
            if not low < (low + high) / 2 < high:
                break
        at = Instant(now.mode, now.jumps, self._flown(now, high))
        ready = [j for j in own if holds(j.guard, at.values, NEAR)]
        self.chance.shuffle(ready)
        if self.script:
            ready.sort(key=lambda j: j.name != self.script[0][0])  # type: ignore[index]
        for jump in ready:
            landed = self._made(jump, at)
            if landed is not None:
                return landed
        return None

    def _by_chance(self, own: list[Jump], now: Instant) -> Instant | None:
        """The landing of an edge that is taken though it might wait."""
        for jump in own:
            if not jump.urgent and self.chance.random() < 0.2 and holds(jump.guard, now.values):
                landed = self._made(jump, now)
                if landed is not None:
                    return landed
        return None

    def _left(self, now: Instant) -> float:
        """The time to the instant of the wanted edge."""
        assert self.script, "an edge is wanted"
        return self.script[0][1] - now.values["time"]

    def _ends(self, mode: str, values: Values) -> bool:
        """Whether a state is beyond the stay: outside of the domain, or where an urgent edge is enabled."""
        if not holds(self.machine.modes[mode][0], values):
            return True
        due = [j for j in self.machine.jumps if j.source == mode and j.urgent]
        return any(holds(j.event or j.guard, values) for j in due)

    def _made(self, jump: Jump, at: Instant) -> Instant | None:
        """The landing of a jump; None where no outcome of it that was tried is in the target's domain."""
        for _ in range(8):
            after = dict(at.values)
            for v, e in jump.resets.items():
                after[v] = self._chosen(e) if isinstance(e, tuple) else float(value(e, at.values))
            if holds(self.machine.modes[jump.target][0], after, NEAR):
                if self.script:
                    self.script.pop(0)
                return Instant(jump.target, at.jumps + 1, after, jump, at.values)
        return None

    def _chosen(self, ends: tuple[float, float]) -> float:
        share = self.chance.choice([0.0, 1.0, self.chance.random(), self.chance.random()])
        return ends[0] + share * (ends[1] - ends[0])

    def _flown(self, now: Instant, h: float) -> Values:
        """A Runge-Kutta step of order 4."""
        rates = self.machine.modes[now.mode][1]

        def slope(values: Values) -> Values:
            return {v: float(value(e, values)) for v, e in rates.items()}

        def moved(by: Values, h: float) -> Values:
            return {**{v: x + h * by.get(v, 0.0) for v, x in now.values.items()}, "time": now.values["time"] + h}

        k1 = slope(now.values)
        k2 = slope(moved(k1, h / 2))
        k3 = slope(moved(k2, h / 2))
        k4 = slope(moved(k3, h))
        return moved({v: (k1[v] + 2 * k2[v] + 2 * k3[v] + k4[v]) / 6 for v in rates}, h)
