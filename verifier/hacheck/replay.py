"""Runs, walked exactly (LANGUAGE S5 to S12): states are polynomials of the dwell `s` so far."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

from hacheck import bernstein
from hacheck.cells import START, Model
from hacheck.expressions import Instant
from hacheck.formula import Formula, conj, disj, literal, negated, placed, variables
from hacheck.polynomial import ZERO, Env, Poly, add, const, constant, mul, substitute, var
from hacheck.rational import Refused, number

Json = Any


class Stage(NamedTuple):
    """A dwell, or the landing of a jump: the instant, its state in terms of `s`, the longest `s`, the time before."""

    at: Instant
    state: Env
    dwell: Fraction
    time: Fraction


class Walk:
    """One run of a model; raises Refused where it is not one. It ends in `mode`, at the end of the stage `last`.

    `edge` is the edge just taken, if the run ends with a jump.
    """

    def __init__(self, model: Model, run: Json, assume: list[Json]) -> None:
        self.model, self.scope, self.jumps = model, model.scope, len(run["steps"])
        self.mode, self.time = str(run["mode"]), START
        self.edge: int | None = None
        if set(run["params"]) != set(self.scope.ranges) or set(run["values"]) != set(self.scope.types):
            raise Refused("a run does not give every param and variable a value")
        self.params = Env({p: const(number(q)) for p, q in run["params"].items()})
        self.values = {v: const(number(q)) for v, q in run["values"].items()}
        self.stages: list[Stage] = []
        self.last: Stage
        for name, p in self.scope.ranges.items():
            low, high = (add(self.params[name], self.scope.base.poly(p[end]), -1) for end in ("low", "high"))
            inside = conj([literal(">=", low), literal("<=", high)])
            self.need(placed(inside, self.params), f"the param {name} is outside its range")
        self._start()
        for step in run["steps"]:
            self._dwell(number(step["dwell"]))
            self._jump(step["edge"], step.get("values") or {})
        self._dwell(number(run["last"]))
        for stage in self.stages if assume else ():
            f = conj(stage.at.formula(a) for a in assume)
            self.need(placed(f, stage.state), "an assumption fails", stage.dwell)

    def need(self, f: Formula, message: str, upto: Fraction = START) -> None:
        """Refuse unless f holds for all dwells up to a bound."""
        if not self.surely(f, upto):
            raise Refused(f"a run is none: {message} (mode {self.mode}, after {str(self.time)[:40]} s)")

    def surely(self, f: Formula, upto: Fraction = START) -> bool:
        """Does f hold for all dwells in [0, upto], and all pi and rounded constants in their enclosures?"""
        if isinstance(f, bool):
            return f
        box: bernstein.Box = {**self.scope.box, "@s": (START, upto)}
        for v in sorted(variables(f) & self.scope.box.keys() - {"pi"}):
            f = bernstein.eliminate(f, v, box)
        return bernstein.shown(f, box, self.scope.whole)

    def finally_(self, f: Formula) -> bool:
        """Does a formula about the last instant surely hold there?"""
        return self.surely(placed(placed(f, self.last.state), Env({"@s": const(self.last.dwell)})))

    def stuck(self) -> bool:
        """Can no time pass at the end of the run, and is no edge enabled or due (S12)?"""
        return self.surely(placed(self.model.stuck(self.mode), self._moving(still=True)))

    def _moving(self, still: bool = False) -> Env:
        """The state after a dwell of `s` from now, or now."""
        s = ZERO if still else var("@s")
        rates = {} if still else self.scope.rates(self.mode)
        moved = self.values if still else {
            v: add(x, mul(s, substitute(rates[v], self.params))) for v, x in self.values.items()}  # fmt: skip
        time = add(const(self.time), s)
        sigma = time if self.scope.rho is None else mul(substitute(self.scope.rho, self.params), time)
        return Env({**self.params, **moved, "time": time, "@sigma": sigma})

    def _start(self) -> None:
        """S5: the state satisfies an init line."""
        at, now = self.scope.identity(self.mode), self._moving(still=True)
        if not any(self.surely(placed(self._allowed(line, at), now)) for line in self.scope.automaton["init"]
                   if line["mode"] in (None, self.mode)):  # fmt: skip
            raise Refused("a run does not start in an admissible state")
        self._arrived()

    def _allowed(self, line: Json, at: Instant) -> Formula:
        return conj([at.condition(line["where"]), self.model.given(line["with"], at)])

    def _arrived(self) -> None:
        """The values are of their types, in the domain and in the declared ranges, which no run leaves (S4)."""
        discrete = [constant(self.values[v]) for v, kind in self.scope.types.items() if kind != "real"]
        if any(q is None or q.denominator != 1 for q in discrete):
            raise Refused("a run gives a variable a value that its type does not have")
        inside = conj([self.model.domain(self.mode), self.model.declared(self.mode)])
        self.need(placed(inside, self._moving(still=True)), "it is outside the domain or the declared ranges")

    def _dwell(self, d: Fraction) -> None:
        """Let time pass: in the domain throughout, with no urgent edge due before the end (S7, S8).

        Where an edge would be enabled right after an instant it is enabled at one before the end.
        """
        if d < 0:
            raise Refused("a run dwells for a negative time")
        state, key = self._moving(), self._key("dwell", d)
        if d and key not in self.model.walked:  # what holds without a dwell was seen on arrival
            self._waits(state, d)
            self.model.walked.add(key)
        self.stages.append(Stage(self.scope.identity(self.mode), state, d, self.time))
        self.last, self.edge = (self.stages[-1], None) if d or self.edge is None else (self.last, self.edge)
        self.values = {v: substitute(state[v], Env({"@s": const(d)})) for v in self.values}
        self.time += d

    def _waits(self, state: Env, d: Fraction) -> None:
        inside = conj([self.model.domain(self.mode), self.model.declared(self.mode)])
        self.need(placed(inside, state), "it leaves the domain or a declared range", d)
        ended = literal(">=", add(var("@s"), const(d), -1))
        for k in self.model.leaving[self.mode]:
            if self.model.edges[k]["urgent"]:
                waits = disj([ended, placed(self.model.forbidden(k, False), state)])
                self.need(waits, "it dwells where an urgent edge is due", d)

    def _key(self, *step: Any) -> Any:
        """What is done next and all that it depends on, for steps that several runs have in common."""
        known = {**self.params, **self.values}
        return self.mode, self.time, step, frozenset((v, p.unit, *p.terms.items()) for v, p in known.items())

    def _jump(self, k: Json, chosen: Json) -> None:
        """Take edge k: its guard holds as written, or it is urgent and due; the outcome is in the target's domain."""
        if type(k) is not int or k not in self.model.leaving[self.mode]:
            raise Refused("a run takes an edge that its mode does not have")
        if set(chosen) != {r["var"] for r in self.model.sets(k)}:
            raise Refused("a run does not choose the values that its edge leaves open")
        values: dict[str, Poly] = {v + "'": const(number(q)) for v, q in chosen.items()}
        now, key = Env({**self._moving(still=True), **values}), self._key("jump", k, *sorted(chosen.items()))
        if key not in self.model.walked:
            self._takes(k, now)
        self.last = Stage(self.model.landing(k), now, START, self.time)
        self.stages.append(self.last)
        self.values = {v: substitute(self.model.landing(k).env[v], now) for v in self.values}
        self.mode, self.edge = self.model.edges[k]["target"], k
        if key not in self.model.walked:
            self._arrived()
            self.model.walked.add(key)

    def _takes(self, k: int, now: Env) -> None:
        taken = negated(self.model.forbidden(k, False))
        if not self.surely(placed(taken, now)):
            due = self.model.edges[k]["urgent"] and conj([self.model.soon(taken, self.mode), self.model.lands(k)])
            self.need(placed(due, now), f"edge {self.model.edges[k]['name']} is not enabled")
