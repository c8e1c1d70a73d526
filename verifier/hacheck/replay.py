"""Runs, walked exactly (LANGUAGE S5 to S12): states are polynomials of the dwell `s` so far."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from hacheck import bernstein, sturm
from hacheck.cells import Model
from hacheck.expressions import Instant
from hacheck.formula import Formula, conj, disj, literal, variables
from hacheck.polynomial import Poly, add, const, constant, mul, substitute, var
from hacheck.rational import Refused, number

Json = Any
ZERO = Fraction(0)
Watch = Callable[[Instant, Fraction, Fraction], None]  # an instant, how long one may dwell there, the time before


def _compared(op: str, a: Poly, b: Poly) -> Formula:
    return literal(op, add(a, b, -1))


class Walk:
    """One run of a model; raises Refused where it is not one.

    In the end, `last` is its last instant, `time` the time there, and `edge` the edge just taken, if there is one.
    """

    def __init__(self, model: Model, run: Json, assume: list[Json], watch: Watch | None = None) -> None:
        self.model, self.assume, self.watch = model, assume, watch
        self.params = self._params(run["params"])
        self.mode, self.time = str(run["mode"]), ZERO
        self.values = self.start(self.mode, run["values"])
        self.edge: int | None = None
        self.last = self.instant(self.values)
        self.need(self._assumed(self.last), "an assumption does not hold at the start")
        for step in run["steps"]:
            self.dwell(number(step["dwell"]))
            self.last = self.jump(step["edge"], step.get("values"))
        self.dwell(number(run["last"]))
        self.jumps = len(run["steps"])
        if number(run["last"]):
            self.last, self.edge = self.instant(self.values), None

    def need(self, f: Formula, message: str, upto: Fraction = ZERO, half_open: bool = False) -> None:
        """Refuse unless f holds for all dwells up to a bound."""
        if not self.surely(f, upto, half_open):
            raise Refused(f"a run is none: {message} (mode {self.mode}, after {str(self.time)[:40]} s)")

    def surely(self, f: Formula, upto: Fraction = ZERO, half_open: bool = False) -> bool:
        """Does f hold for all dwells in [0, upto], and all pi and rounded constants in their enclosures?"""
        if isinstance(f, bool):
            return f
        if variables(f) <= {"s"}:
            return bernstein.holds(f, {"s": (ZERO, upto)}) or sturm.always(f, "s", ZERO, upto, half_open)
        box = {**self.model.scope.box, "s": (ZERO, upto)}
        for v in variables(f) - {"s", "pi"}:
            f = bernstein.eliminate(f, v, box)
        return bernstein.holds(f, box)

    def _params(self, given: Json) -> dict[str, Poly]:
        scope = self.model.scope
        if set(given) != set(scope.params):
            raise Refused("a run does not give every param a value")
        params = {p: const(number(q)) for p, q in given.items()}
        for of, listed in ((scope.outer, scope.core.data["params"]), (scope, scope.automaton["params"])):
            at = Instant(of or scope, None, params)
            for p in listed:
                ends = [at.formula([op, p[end], given[p["name"]]]) for op, end in (("<=", "low"), (">=", "high"))]
                if not self.surely(conj(ends)):
                    raise Refused(f"a run gives the param {p['name']} a value outside its range")
        return params

    def instant(self, values: dict[str, Poly], clock: Poly | None = None) -> Instant:
        """Dwelling in the current mode."""
        time = add(const(self.time), clock or const(0))
        return Instant(self.model.scope, self.mode, {**self.params, **values}, time=time)

    def start(self, mode: str, values: Json) -> dict[str, Poly]:
        """The values of an admissible start."""
        scope = self.model.scope
        if mode not in scope.modes or set(values) != set(scope.types):
            raise Refused("a start does not give a mode of the automaton and every variable a value")
        state = {v: const(number(q)) for v, q in values.items()}
        self._typed(state)
        at = Instant(scope, mode, {**self.params, **state}, time=const(0))
        self.need(at.domain, "the start is outside the domain")
        self.need(self._declared(at), "the start is outside a declared range")
        if not any(self._allows(line, mode, at, state) for line in scope.automaton["init"]):
            raise Refused("a run does not start in an admissible state")
        return state

    def _allows(self, line: Json, mode: str, at: Instant, state: dict[str, Poly]) -> bool:
        """S5: the start satisfies an init line."""
        if line["mode"] not in (None, mode):
            return False
        parts = [at.formula(line["where"])]
        for r in line["with"]:
            pairs = [("==", r["to"])] if "to" in r else [(">=", r["low"]), ("<=", r["high"])]
            parts += [_compared(op, state[r["var"]], at.poly(e)) for op, e in pairs]
        return self.surely(conj(parts))

    def _typed(self, values: dict[str, Poly]) -> None:
        """Discrete variables hold a value of their type."""
        for v in self.model.a["vars"]:
            if v["type"] != "real":
                x, (low, high) = constant(values[v["name"]]), self.model.scope.window(v["name"])
                if x is None or x.denominator != 1 or low is None or high is None or not low <= x <= high:
                    raise Refused(f"{v['name']} gets a value that its type does not have")

    def _declared(self, at: Instant) -> Formula:
        """The declared ranges, which a run may not leave (S4)."""
        return conj(at.formula([op, ["var", v["name"]], v[end]]) for v in self.model.a["vars"] if v["type"] == "real"
                    for op, end in ((">=", "low"), ("<=", "high")) if v[end] is not None)  # fmt: skip

    def _assumed(self, at: Instant) -> Formula:
        return conj(at.formula(a) for a in self.assume)

    def dwell(self, d: Fraction) -> None:
        """Let time pass: in the domain throughout, with no urgent edge due before the end (S7, S8).

        Where an edge would be enabled right after an instant it is enabled at one before the end.
        """
        if d < 0:
            raise Refused("a run dwells for a negative time")
        at = self._soon()
        if d > 0:
            self.need(at.domain, "it leaves the domain", d)
            self.need(self._declared(at), "it leaves a declared range", d)
            self.need(self._assumed(at), "an assumption fails", d)
            for k in self.model.leaving[self.mode]:
                if self.model.a["edges"][k]["urgent"]:
                    self.need(self.enabled(k, at, neg=True), "it dwells where an urgent edge is due", d, half_open=True)
        if self.watch:
            self.watch(at, d, self.time)
        self.values = {v: substitute(at.env[v], {"s": const(d)}, {}) for v in self.values}
        self.time += d

    def landing(self, k: int, at: Instant, chosen: dict[str, Poly]) -> Instant:
        """The instant after edge k, taken at an instant."""
        edge = self.model.a["edges"][k]
        env = dict(at.env)
        for r in edge["resets"]:
            env[r["var"]] = at.poly(r["to"]) if "to" in r else chosen[r["var"]]
        return Instant(self.model.scope, edge["target"], env, time=at.time, edge=edge["name"], before=at)

    def enabled(self, k: int, at: Instant, neg: bool, chosen: dict[str, Poly] | None = None) -> Formula:
        """S9; for edges that choose values the outcome counts as possible, so only the negation is of use, unless
        `chosen` says which are taken."""
        edge = self.model.a["edges"][k]
        guard = at.formula(edge["guard"], neg)
        if neg and any("to" not in r for r in edge["resets"]):
            return guard
        landed = self.landing(k, at, chosen or {})
        if neg:
            return disj([guard, landed.outside])
        return conj([guard, landed.domain, *self._possible(k, at, chosen or {})])

    def _possible(self, k: int, at: Instant, chosen: dict[str, Poly]) -> list[Formula]:
        """The chosen values are among those that edge k leaves open."""
        sets = [r for r in self.model.a["edges"][k]["resets"] if "to" not in r]
        return [_compared(op, at.poly(r[end]), chosen[r["var"]])
                for r in sets for op, end in (("<=", "low"), (">=", "high"))]  # fmt: skip

    def jump(self, k: Json, values: Json) -> Instant:
        """Take edge k: its guard holds as written, or it is urgent and due; the outcome is in the target's domain."""
        if type(k) is not int or k not in self.model.leaving[self.mode]:
            raise Refused("a run takes an edge that its mode does not have")
        edge, at = self.model.a["edges"][k], self.instant(self.values)
        sets = [r for r in edge["resets"] if "to" not in r]
        values = {} if values is None else values
        if set(values) != {r["var"] for r in sets}:
            raise Refused("a run does not choose the values that its edge leaves open")
        chosen = {v: const(number(q)) for v, q in values.items()}
        if not self.surely(at.formula(edge["guard"])) and not (edge["urgent"] and self._due(k, chosen)):
            raise Refused(f"a run takes edge {edge['name']} where its guard does not hold")
        landed = self.landing(k, at, chosen)
        self.need(conj(self._possible(k, at, chosen)), "a chosen value is not a possible one")
        state = {v: landed.env[v] for v in self.values}
        self._typed(state)
        self.mode, self.values, self.edge = edge["target"], state, k
        self.need(landed.domain, "an outcome is outside the target's domain")
        self.need(self._declared(landed), "an outcome is outside a declared range")
        self.need(self._assumed(landed), "an assumption fails after a jump")
        if self.watch:
            self.watch(landed, ZERO, self.time)
        return landed

    def _soon(self) -> Instant:
        """The states after a dwell s from now."""
        rates = self.model.scope.rates(self.mode)
        moved = {v: add(x, mul(var("s"), substitute(rates[v], self.params, {}))) for v, x in self.values.items()}
        return self.instant(moved, var("s"))

    def _due(self, k: int, chosen: dict[str, Poly]) -> bool:
        f = self.enabled(k, self._soon(), neg=False, chosen=chosen)
        return variables(f) <= {"s"} and sturm.soon(f, ZERO)

    def stuck(self) -> bool:
        """Can no time pass at the end of the run, and is no edge enabled or due (S12)?"""
        if self.model.scope.modes[self.mode]["terminal"]:
            return False
        soon, now = self._soon(), self.instant(self.values)
        blocked = [self.enabled(k, now, neg=True) for k in self.model.leaving[self.mode]]
        urgent = [k for k in self.model.leaving[self.mode] if self.model.a["edges"][k]["urgent"]]
        fires = [self.enabled(k, soon, neg=True) for k in urgent]
        later = conj([soon.outside, *fires])
        return self.surely(conj(blocked)) and variables(later) <= {"s"} and sturm.soon(later, ZERO)
