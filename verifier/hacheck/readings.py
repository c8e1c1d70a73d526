"""What the expressions of a system are in a discrete state, and in which states it starts (LANGUAGE S5, S6).

A discrete state has the mode of each automaton and the value of each discrete variable. Clocks are measured in s times
`scale`, so that all bounds are whole numbers; they pass at the rate of time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from hacheck.core import Core
from hacheck.formula import CLOSED, NEGATED
from hacheck.parts import Scope
from hacheck.rational import Beyond, Refused, number, spend
from hacheck.zones import LARGEST, NO_BOUND, Formula, Space, Zone, both, either, opposite

Json = Any
State = tuple[Any, ...]
TIME = "time"


class Event(NamedTuple):
    """The jump just made: the interaction and its edges by name, and the discrete state before it."""

    names: tuple[str, ...]
    before: State


class Readings(ABC):
    """What the names and expressions of a system mean; `timed` adds a clock for the time since the start."""

    def __init__(self, core: Core, system: Json, scale: int, timed: bool) -> None:
        if type(scale) is not int or not 0 < scale < 1 << 40:
            raise Refused("a scale is no positive whole number")
        self.core, self.scale = core, scale
        self.root = Scope(core, system, "", None, [])
        self.automata = list(self.root.automata())
        self.slots: dict[str, int] = {a.prefix: i for i, a in enumerate(self.automata)}
        self.clocks: dict[str, int] = {}
        self.rates: dict[str, Fraction] = {TIME: Fraction(1)}
        self.types: dict[str, str] = {}
        self.windows: dict[str, tuple[Json, Json]] = {}
        for owner in [*self.root.systems(), *self.automata]:
            for v in owner.model["vars"]:
                self._variable(owner, v)
        if timed:
            self.clocks[TIME] = len(self.clocks) + 1
        self.space = Space(len(self.clocks))
        self.places = {
            a.prefix + m["name"]: (i, m["name"]) for i, a in enumerate(self.automata) for m in a.model["modes"]
        }
        self.domains = {a.prefix + m["name"]: a.flat(m["domain"]) for a in self.automata for m in a.model["modes"]}
        self.terminal = {a.prefix + m["name"] for a in self.automata for m in a.model["modes"] if m["terminal"]}
        self._domains: dict[State, Zone | None] = {}

    # ---- variables and expressions ----

    def _variable(self, owner: Scope, v: Json) -> None:
        name = owner.prefix + v["name"]
        flows = [owner.model["flow"]] if "flow" in owner.model else [m["flow"] for m in owner.model["modes"]]
        lines = [f for flow in flows for f in flow if f["var"] == v["name"]]
        if any("rate" not in f for f in lines) or (v["type"] == "real" and len(lines) != len(flows)):
            raise Beyond(f"{name!a} has no single rate")
        rates = {self._constant(owner.flat(f["rate"])) for f in lines} or {Fraction(0)}
        if name in self.slots or name in self.clocks or len(rates) > 1 or name == TIME:
            raise Beyond(f"{name!a} has several rates, or means several things")
        rate = rates.pop()
        self.types[name] = v["type"]
        if v["low"] is not None or v["high"] is not None:
            if v["type"] != "real":
                raise Beyond("a declared range of a discrete variable")
            self.windows[name] = (owner.flat(v["low"]), owner.flat(v["high"]))
        if rate:
            self.clocks[name], self.rates[name] = len(self.clocks) + 1, rate
        else:
            self.slots[name] = len(self.slots)

    def _constant(self, e: Json) -> Fraction:
        return self.value(e, ())

    def value(self, e: Json, s: State) -> Fraction:
        """The number an expression is in a discrete state, clocks apart."""
        q, clocks = self.linear(e, s, None)
        if clocks:
            raise Beyond("a clock where a number is needed")
        return q

    def linear(self, e: Json, s: State, event: Event | None) -> tuple[Fraction, dict[int, Fraction]]:
        """A number and how often each clock is added to it."""
        spend(5)
        if isinstance(e, str):
            return number(e), {}
        op, args = (e[0], e[1:]) if isinstance(e, list) else ("true", [])
        if op == "var" or op == TIME:
            return self._read(TIME if op == TIME else args[0], s)
        if op in _LINEAR or op in _NUMBERS:
            return self._sum(op, [self.linear(a, s, event) for a in (args[2:] if op == "scale" else args)], args)
        if op == "if":
            return self.linear(args[1] if self._sure(args[0], s, event) else args[2], s, event)
        if op == "pre":
            return (self.value(args[0], event.before), {}) if event else self.linear(args[0], s, None)
        return Fraction(self._sure(e, s, event)), {}

    def _sure(self, e: Json, s: State, event: Event | None) -> bool:
        f = self.truth(e, s, event)
        if not isinstance(f, bool):
            raise Beyond("a truth about clocks where a number is needed")
        return f

    def _read(self, name: str, s: State) -> tuple[Fraction, dict[int, Fraction]]:
        if name in self.clocks:
            return Fraction(0), {self.clocks[name]: self.rates[name] / self.scale}
        if name not in self.slots or self.slots[name] >= len(s):
            raise Beyond(f"{name!a} has no value here")
        return s[self.slots[name]], {}

    def _sum(self, op: str, given: list[tuple[Fraction, dict[int, Fraction]]], args: list[Json],
             ) -> tuple[Fraction, dict[int, Fraction]]:  # fmt: skip
        if op in ("+", "-", "neg"):
            out, clocks = Fraction(0), dict[int, Fraction]()
            for k, (q, terms) in enumerate(given):
                sign = -1 if op == "neg" or (op == "-" and k) else 1
                out += sign * q
                clocks = {c: clocks.get(c, Fraction(0)) + sign * terms.get(c, Fraction(0)) for c in {*clocks, *terms}}
            return out, {c: k for c, k in clocks.items() if k}
        if op in ("*", "/", "scale"):
            moving = [k for k, (_, terms) in enumerate(given) if terms]
            if len(moving) > 1 or (op == "/" and moving == [1]) or (op == "scale" and args[1] != 0):
                raise Beyond("a product of clocks, or pi")
            factor = number(args[0]) if op == "scale" else Fraction(1)
            for k, (q, _) in enumerate(given):
                factor = factor if k in moving else factor / q if op == "/" and k else factor * q
            q, terms = given[moving[0]] if moving else (Fraction(1), {})
            return q * factor, {c: k * factor for c, k in terms.items() if k * factor}
        if any(terms for _, terms in given):
            raise Beyond(f"`{op:.20}` of a clock")
        numbers = [q for q, _ in given]
        if op == "^" and (numbers[1].denominator != 1 or abs(numbers[1]) > 64):
            raise Beyond("a power with another exponent than a small integer")
        return Fraction(_NUMBERS[op](*numbers)), {}

    def truth(self, e: Json, s: State, event: Event | None = None, closed: bool = False, no: bool = False) -> Formula:
        """Where an expression is true of the clocks in a discrete state; `no`: where false; `closed`: read as S6."""
        spend(5)
        if isinstance(e, bool):
            return e is not no
        op, args = e[0], e[1:]
        if op in ("and", "or"):
            return (both if (op == "and") is not no else either)(self.truth(a, s, event, closed, no) for a in args)
        if op == "not":
            return self.truth(args[0], s, event, closed, not no)
        if op == "implies":
            return self.truth(["or", ["not", args[0]], args[1]], s, event, closed, no)
        if op == "if":
            return self.truth(args[1] if self._sure(args[0], s, event) else args[2], s, event, closed, no)
        if op in NEGATED:
            return self._compare(NEGATED[op] if no else op, args, s, event, closed)
        if op == "at":
            slot, mode = self.places[args[0]]
            return (s[slot] == mode) is not no
        if op in ("jump", "jumped"):
            return (event is not None and (op == "jumped" or args[0] in event.names)) is not no
        if op == "pre":
            return (
                self._sure(args[0], event.before, None) is not no if event else self.truth(args[0], s, None, closed, no)
            )
        if op == "var":
            return (self.value(e, s) != 0) is not no
        if op == "stuck":
            return opposite(self.stuck(s)) if no else self.stuck(s)
        raise Beyond(f"`{op!s:.20}` is outside the checker's fragment")

    def _compare(self, op: str, args: list[Json], s: State, event: Event | None, closed: bool) -> Formula:
        (p, xs), (q, ys) = self.linear(args[0], s, event), self.linear(args[1], s, event)
        clocks = {c: xs.get(c, Fraction(0)) - ys.get(c, Fraction(0)) for c in {*xs, *ys}}
        terms = [(c, k) for c, k in sorted(clocks.items()) if k]
        if closed and op == "!=":
            return True
        op = CLOSED[op] if closed else op
        if not terms:
            return _holds(op, p - q)
        (i, k), (j, other) = terms[0], terms[1] if len(terms) > 1 else (0, -terms[0][1])
        if len(terms) > 2 or other != -k:
            raise Beyond("a comparison of clocks that is no bound on one, nor on the difference of two")
        return self._bound(i, j, op if k > 0 else _TURNED[op], (q - p) / k)

    def _bound(self, i: int, j: int, op: str, q: Fraction) -> Formula:
        """`x_i - x_j op q`, where q is measured in the scaled unit."""
        c = self._whole(q)
        if op in ("<", "<="):
            return (i, j, 2 * c + (op == "<="))
        if op in (">", ">="):
            return (j, i, 2 * -c + (op == ">="))
        ends = [(i, j, 2 * c + (op == "==")), (j, i, 2 * -c + (op == "=="))]
        return both(ends) if op == "==" else either(ends)

    def _whole(self, q: Fraction) -> int:
        if q.denominator != 1 or abs(q) > LARGEST // 4:
            raise Refused("a bound is no multiple of the unit that the certificate gives")
        return int(q)

    def clock_value(self, name: str, q: Fraction) -> int:
        """A value of a clock variable in the scaled unit."""
        return self._whole(q / self.rates[name] * self.scale)

    @abstractmethod
    def stuck(self, s: State) -> Formula:
        """Where no time can pass and nothing can fire (S12)."""

    # ---- domains, starts ----

    def domain(self, s: State) -> Zone | None:
        """The clock values allowed in a discrete state."""
        if s not in self._domains:
            parts = [self.truth(self.domains[a.prefix + s[i]], s, closed=True) for i, a in enumerate(self.automata)]
            zones = self.space.cut(self.space.all, both(parts))
            if len(zones) > 1:
                raise Beyond("a domain with alternatives about clocks")
            self._domains[s] = zones[0] if zones else None
        return self._domains[s]

    def within_domain(self, s: State, z: Zone) -> Zone | None:
        """The part of a zone inside the domain."""
        d = self.domain(s)
        found = self.space.cut(z, self.space.formula(d)) if d is not None else []
        return found[0] if found else None

    def typed(self, name: str, q: Fraction) -> bool:
        """May a discrete variable have that value?"""
        values = self.values(name)
        return values is None or q in values

    def values(self, name: str) -> list[Fraction] | None:
        """The values of a discrete variable's type; None for a number that no flow changes."""
        kind = self.types[name]
        if kind == "real":
            return None
        if kind == "bool":
            return [Fraction(0), Fraction(1)]
        e = self.core.enums[kind]
        low = number(e["low"]) if e["low"] is not None else Fraction(0)
        spend(len(e["values"]))
        return [low + k for k in range(len(e["values"]))]

    def starts(self) -> Iterator[tuple[State, Zone]]:
        """The initial states (S5), before time passes."""
        owners = [*self.root.systems(), *self.automata]
        if any(not a.model["init"] for a in self.automata):
            raise Refused("an automaton without a start")
        lines = [[(o, line, m) for line in o.model["init"] or [{"mode": None, "where": True, "with": []}]
                  for m in self._start_modes(o, line)] for o in owners]  # fmt: skip
        for chosen in product(*lines):
            spend(100)
            known: dict[str, Json] = {}
            given_values = [r for o, line, _ in chosen for r in o.resets(line["with"])]
            known.update({r["var"]: r for r in given_values})
            if len(known) < len(given_values):
                raise Refused("a start gives a variable two values")
            modes = {o.prefix: m for o, _, m in chosen if m is not None}
            names = [n for n in self.slots if n not in modes]
            for given in product(*(self._start_values(n, known.get(n)) for n in names)):
                spend(20)
                found = {**modes, **dict(zip(names, given, strict=True))}
                s = tuple(found[n] for n in self.slots)
                where = [self.truth(o.flat(line["where"]), s) for o, line, _ in chosen]
                yield from ((s, z) for z in self._start_zones(s, known, both(where)))

    def _start_modes(self, o: Scope, line: Json) -> list[Any]:
        if "modes" not in o.model:
            return [None]
        return [m["name"] for m in o.model["modes"] if line["mode"] in (None, m["name"])]

    def _start_values(self, name: str, r: Json) -> list[Fraction]:
        values = self.values(name)
        if r is None:
            ends = self.windows.get(name, (None, None))
            r = {"low": ends[0], "high": ends[1]} if values is None and None not in ends else None
        if r is None:
            if values is None:
                raise Beyond(f"{name!a} starts anywhere")
            return values
        low, high = (self._constant(r[k]) for k in (("to", "to") if "to" in r else ("low", "high")))
        if values is None and low != high:
            raise Beyond(f"{name!a} may be any number of a range")
        return [low] if low == high and self.typed(name, low) else [v for v in values or () if low <= v <= high]

    def _start_zones(self, s: State, known: dict[str, Json], where: Formula) -> Iterator[Zone]:
        z = self.within_domain(s, self.space.all)
        sets = [*((n, known[n]) for n in self.clocks if n in known), *[(TIME, {"to": "0"})][: TIME in self.clocks]]
        given = both(self._between(n, r["to"], r["to"]) if "to" in r else self._between(n, r["low"], r["high"])
                     for n, r in sets)  # fmt: skip
        for part in self.space.cut(z, both([given, where])) if z is not None else ():
            found = self.space.cut(
                part, both(self._between(n, *self._missing(n, c, part)) for n, c in self.clocks.items())
            )
            if not found:
                raise Beyond("a start outside the declared ranges")
            yield from found

    def _missing(self, name: str, clock: int, z: Zone) -> list[Json]:
        """The ends of a clock's declared range where nothing else bounds it (S5); None where something does."""
        open_ = [z[clock] == NO_BOUND, z[clock * self.space.n] == NO_BOUND]
        ends = self.windows.get(name, (None, None))
        if self.rates.get(name, 1) < 0:
            open_.reverse()
        if any(o and e is None for o, e in zip(open_, ends, strict=True)):
            raise Beyond("a clock starts anywhere")
        return [e if o else None for o, e in zip(open_, ends, strict=True)]

    def _between(self, name: str, low: Json, high: Json) -> Formula:
        ends = [(op, self._constant(e)) for op, e in ((">=", low), ("<=", high)) if e is not None]
        return both(self._bound(self.clocks[name], 0, op if self.rates[name] > 0 else _TURNED[op],
                                q / self.rates[name] * self.scale) for op, q in ends)  # fmt: skip

    def window(self, s: State) -> Formula:
        """The declared ranges of all clocks and of numbers that no flow changes (S4)."""
        out = []
        for n, (low, high) in self.windows.items():
            if n in self.clocks:
                out.append(self._between(n, low, high))
            elif self.types[n] == "real":
                q = self.value(["var", n], s)
                out += [_holds(op, q - self._constant(e)) for op, e in ((">=", low), ("<=", high)) if e is not None]
        return both(out)


_LINEAR = ("+", "-", "neg", "*", "/", "scale")
_NUMBERS: dict[str, Callable[..., Any]] = {"abs": abs, "min": min, "max": max,
            "clamp": lambda x, low, high: min(max(x, low), high), "^": lambda a, b: a ** int(b)}  # fmt: skip
_TURNED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "==", "!=": "!="}


def _holds(op: str, q: Fraction) -> bool:
    return {"<": q < 0, "<=": q <= 0, ">": q > 0, ">=": q >= 0, "==": q == 0, "!=": q != 0}[op]
