"""The names that an automaton sees: constants, params, lets, flows, types."""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from typing import Any

from hacheck import bernstein
from hacheck.core import Core
from hacheck.expressions import Case, Instant, nodes
from hacheck.polynomial import ONE, ZERO, Poly, const, constant, names, scale, var
from hacheck.rational import PI, Beyond, Interval, Refused, number

Json = Any


class Scope:
    """The names that an automaton sees, its own before those of the top level; `rounding` lets constants vary."""

    has_functions = False  # of polynomials, as names
    open = frozenset[str]()  # modes of a system whose edges are not listed: nothing is to be shown there

    def __init__(self, core: Core, automaton: Json, rounding: bool) -> None:
        self.core, self.automaton, self.rounding = core, automaton, rounding
        self.modes = {m["name"]: m for m in automaton["modes"]}
        self.types: dict[str, str] = {v["name"]: v["type"] for v in automaton["vars"]}
        self.whole = frozenset(w for v, t in self.types.items() if t != "real" for w in (v, v + "'"))
        self.own = {c["name"]: c for c in automaton["constants"]}
        self.constants, self.hidden = {**core.constants, **self.own}, self.own.keys() & core.constants.keys()
        self._unhidden([core.data["params"], core.data["assumptions"]])
        self.ranges = {p["name"]: p for p in [*core.data["params"], *automaton["params"]]}
        rounded = [n for n, c in self.constants.items() if rounding and c["half"] is not None]
        known = [*self.types, *(p["name"] for p in core.data["params"] + automaton["params"]), *rounded]
        if len({*known, "@s", "@sigma", "pi", "time"}) < len(known) + 4 or any("'" in n for n in known):
            raise Beyond("a name has another meaning in certificates")
        self.box: bernstein.Box = {"pi": PI}
        self.base = Instant(self, None, {})
        self._values: dict[str, list[Case]] = {}
        self._rates: dict[str, dict[str, Poly]] = {}
        self._flows: dict[str, tuple[Poly, dict[str, Fraction]]] = {}
        self._identities: dict[str, Instant] = {}
        self.params: dict[str, Poly] = {}
        for name, p in self.ranges.items():
            low, high = self.range(p["low"])[0], self.range(p["high"])[1]
            if low is None or high is None or low > high:
                raise Refused(f"the range of param {name} is empty or unbounded")
            self.params[name] = const(low) if low == high else var(name)
            self.box[name] = (low, high)

    @property
    def chosen(self) -> bernstein.Box:
        """The box of everything but the state: params, rounded constants, pi; and chosen values, which are free."""
        return {**{v + "'": bernstein.FREE for v in self.types}, **self.box}

    def _unhidden(self, value: Json) -> None:
        """What is written at the top level does not mean a constant that the automaton hides."""
        if any(n[0] == "const" and n[1:] and n[1] in self.hidden for n in nodes(value)):
            raise Beyond("a constant of the top level that the automaton has too")

    def constant(self, name: str) -> list[Case]:
        """The value of a constant, a box variable where it stands for a rounding box."""
        if name not in self._values:
            c, value = self.constants.get(name, {}), self.base.value(self.definition(name))
            if self.rounding and c["half"] is not None:
                middle, half = constant(value[0][1]), number(c["half"])
                if middle is None or half < 0 or len(value) > 1 or value[0][2] != ONE:
                    raise Beyond(f"the rounding box of {name} is no interval")
                self.box[name] = (middle - half, middle + half)
                value = [(False, var(name), ONE)]
            self._values[name] = value
        return self._values[name]

    def definition(self, name: str) -> Json:
        """What a constant is defined as."""
        c = self.constants.get(name)
        if c is None or isinstance(c["value"], dict):
            raise Refused(f"there is no constant {name}, or it is a set")
        if name not in self.own:
            self._unhidden(c["value"])
        return c["value"]

    def range(self, e: Json) -> Interval:
        """An enclosure of an expression of constants and params."""
        return bernstein.FREE if e is None else bernstein.bounds(self.base.poly(e), self.box)

    def integral(self, p: Poly) -> bool:
        """Is it an integer wherever discrete variables are?"""
        return p.unit == 1 and names(p) <= self.whole

    def function(self, op: str, _: Poly) -> Poly:
        """A function of a polynomial, as a name; only about flows."""
        raise Beyond(f"`{op}` is outside the checker's fragment")

    def input(self, name: str) -> Poly:
        """The value of an input; only in flows, guards and resets."""
        raise Beyond(f"the input {name[:40]!a}")

    def ordinal(self, enum: str, value: str) -> Fraction:
        """The number an enumeration value counts as."""
        found = self.core.enums.get(enum)
        if found is None or value not in found["values"]:
            raise Refused(f"there is no value {value} of {enum}")
        return Fraction(found["values"].index(value)) + (number(found["low"]) if found["low"] is not None else 0)

    def window(self, v: Json) -> tuple[Json, Json]:
        """The declared range of a variable, or the numbers of its type, as expressions."""
        if v["type"] == "real":
            return v["low"], v["high"]
        found = self.core.enums.get(v["type"], {"values": "01", "low": None})
        low = number(found["low"]) if found["low"] is not None else Fraction(0)
        return str(low), str(low + len(found["values"]) - 1)

    def identity(self, mode: str) -> Instant:
        """Dwelling in a mode at the state its variables name."""
        if mode not in self._identities:
            self._identities[mode] = Instant(self, mode, {v: var(v) for v in self.types})
        return self._identities[mode]

    def left(self, mode: str) -> None:
        """Raise Refused where it is not known how a mode is left."""
        if mode in self.open:
            raise Refused("a run comes to a mode of a system that its certificate leaves out")

    def rates(self, mode: str) -> dict[str, Poly]:
        """The flow: a polynomial of params and constants per variable, 0 for discrete ones."""
        self.left(mode)
        if mode not in self._rates:
            flow, at = self.modes[mode]["flow"], Instant(self, mode, {})
            if not all("rate" in line for line in flow):
                raise Beyond("flows that are inclusions")
            self._rates[mode] = {**dict.fromkeys(self.types, ZERO), **{f["var"]: at.poly(f["rate"]) for f in flow}}
        return self._rates[mode]

    def flow(self, mode: str) -> tuple[Poly, dict[str, Fraction]]:
        """`rho` > 0 and the slopes `c` with rate = c * rho."""
        if mode not in self._flows:
            rates = self.rates(mode)
            rho = next((r for r in rates.values() if constant(r) is None), ONE)
            lead = next(iter(rho.terms))
            slopes = {v: Fraction(r.terms.get(lead, 0) * rho.unit, rho.terms[lead] * r.unit) for v, r in rates.items()}
            if any(scale(rho, slopes[v]) != r for v, r in rates.items()):
                raise Beyond(f"the rates of mode {mode} are no rational multiples of one of them")
            if not bernstein.certain(">", rho, self.box):
                raise Refused(f"the rate of mode {mode} is not positive for all params")
            self._flows[mode] = rho, slopes
        return self._flows[mode]

    @cached_property
    def rho(self) -> Poly | None:
        """The rate that all modes share, if they do; else time is not tracked."""
        try:
            found = [self.flow(m)[0] for m in self.modes]
        except Refused:
            return None
        return found[0] if all(r == found[0] for r in found) else None

    def let(self, mode: str | None, name: str) -> Json:
        """The definition of a let in a mode."""
        lets = [*(self.modes[mode]["lets"] if mode is not None else ()), *self.automaton["lets"]]
        found = next((o for o in lets if o["name"] == name), None)
        if found is None or mode is None:
            raise Refused(f"there is no let {name} in mode {mode}")
        return found
