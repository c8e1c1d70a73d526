"""Cells: boxes of entry states with a dwell, which together contain every run; conditions are formulas on boxes.

A condition speaks of the state (variables by name, `@sigma`), chosen values `v'`, params, rounded constants and pi.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache
from typing import Any

from hacheck import bernstein
from hacheck.bernstein import FREE, Box, point
from hacheck.expressions import Instant
from hacheck.formula import Formula, conj, disj, literal, members, negated, placed, soon, variables
from hacheck.polynomial import ONE, ZERO, Env, Poly, add, const, names, scale, substitute, var
from hacheck.rational import Beyond, Interval, Refused, number, spend
from hacheck.scope import Scope

Json = Any
START = Fraction(0)
ASSIGNED = {"to": "==", "low": ">=", "high": "<="}


class Model:
    """An automaton's domains and edges as formulas about the state before an edge."""

    def __init__(self, scope: Scope) -> None:
        self.scope, self.a, self.edges = scope, scope.automaton, scope.automaton["edges"]
        if self.a["priorities"]:
            raise Beyond("automata with priorities")
        self.leaving: dict[str, list[int]] = {m: [] for m in scope.modes}
        for k, e in enumerate(self.edges):
            self.leaving[e["source"]].append(k)
        self.domain, self.outside, self.declared = cache(self._domain), cache(self._outside), cache(self._declared)
        self.landing, self.forbidden, self.enabled = cache(self._landing), cache(self._forbidden), cache(self._enabled)
        self.equations, self.ending, self.lively = cache(self._equations), cache(self._ending), cache(self._lively)
        self.stays = set[Any]()  # modes, entries and dwells that are known to be right, whatever the time
        self.walked = set[Any]()  # steps of runs that are known to be right, with the state they begin in
        self.timeless = '["time"]' not in json.dumps(self.a, separators=(",", ":"))

    def _domain(self, mode: str) -> Formula:
        """The state is in the domain, read as closed (S6)."""
        return self.scope.identity(mode).condition(self.scope.modes[mode]["domain"], closed=True)

    def _outside(self, mode: str) -> Formula:
        return negated(self.domain(mode))

    def _declared(self, mode: str) -> Formula:
        """S4: real variables are in their declared ranges, discrete ones in their types."""
        at, found = self.scope.identity(mode), []
        for v in self.a["vars"]:
            ends = zip((">=", "<="), self.scope.window(v), strict=True)
            found += [at.condition([op, ["var", v["name"]], e]) for op, e in ends if e is not None]
        return conj(found)

    def _landing(self, k: int, pick: str | None = None) -> Instant:
        """Just after edge k, over the variables before it; chosen values are `v'`, or an end of their range."""
        edge = self.edges[k]
        before = self.scope.identity(edge["source"])
        env = dict(before.env)
        for r in edge["resets"]:
            ends = {x: before.poly(r[x]) for x in r.keys() - {"var"}}
            if self.scope.types[r["var"]] != "real" and not all(map(self.scope.integral, ends.values())):
                raise Beyond(f"{r['var']} may get a value between two of its type")
            env[r["var"]] = ends["to"] if "to" in r else ends[pick] if pick else var(r["var"] + "'")
        return Instant(self.scope, edge["target"], env, edge=edge["name"], before=before)

    def sets(self, k: int) -> list[Json]:
        """The resets of an edge that leave a choice."""
        return [r for r in self.edges[k]["resets"] if "to" not in r]

    def given(self, assigned: list[Json], at: Instant, new: str = "") -> Formula:
        """Variables, named with `new`, have values that `with` or resets give them."""
        return conj(literal(op, add(var(r["var"] + new), at.poly(r[end]), -1))
                    for r in assigned for end, op in ASSIGNED.items() if end in r)  # fmt: skip

    def lands(self, k: int) -> Formula:
        """The chosen values are possible ones of edge k, and the outcome is in the target's domain."""
        edge = self.edges[k]
        chosen = self.given(self.sets(k), self.scope.identity(edge["source"]), "'")
        return conj([chosen, placed(self.domain(edge["target"]), self.landing(k).env)])

    def _forbidden(self, k: int, closed: bool) -> Formula:
        """Edge k is not taken to the chosen values; its guard is read as closed where it may fire when due (S8)."""
        guard = self.scope.identity(self.edges[k]["source"]).condition(self.edges[k]["guard"], closed=closed)
        return negated(conj([guard, self.lands(k)]))

    def _enabled(self, k: int) -> Formula:
        """Edge k is certainly enabled: its guard holds, and the lowest or the highest outcome is in the target (S9)."""
        edge, at = self.edges[k], self.scope.identity(self.edges[k]["source"])
        some = [literal("<=", add(at.poly(r["low"]), at.poly(r["high"]), -1)) for r in self.sets(k)]
        picks = ("low", "high")[: 1 + len(some)]
        lands = disj(placed(self.domain(edge["target"]), self.landing(k, pick).env) for pick in picks)
        return conj([at.condition(edge["guard"]), *some, lands])

    def _equations(self, k: int) -> list[Poly]:
        """What is 0 where the guard of an urgent edge holds, with either sign."""
        guard = self.scope.identity(self.edges[k]["source"]).condition(self.edges[k]["guard"])
        found = [f[1] for f in members(guard, "and") if not isinstance(f, bool) and f[0] == "=="]
        return [q for p in found if self.edges[k]["urgent"] for q in (p, scale(p, -1))]

    def soon(self, f: Formula, mode: str) -> Formula:
        """f is true for a while right after the instant."""
        return soon(f, {**self.scope.rates(mode), "@sigma": self.scope.rho or ZERO, "time": ONE})

    def _due(self, mode: str) -> Formula:
        """An urgent edge is certainly due: enabled, or enabled right after (S8)."""
        found = [self.enabled(k) for k in self.leaving[mode] if self.edges[k]["urgent"]]
        return disj([*found, *(self.soon(f, mode) for f in found)])

    def _ending(self, mode: str) -> Formula:
        """No time passes from here."""
        return disj([self.outside(mode), self.soon(self.outside(mode), mode), self._due(mode)])

    def _lively(self, mode: str) -> Formula:
        """A run in the domain can certainly go on from here: time passes, or an edge is enabled or due."""
        enabled = [self.enabled(k) for k in self.leaving[mode]]
        going = [self.soon(self.domain(mode), mode), *enabled, self._due(mode)]
        return bool(self.scope.modes[mode]["terminal"]) or disj(going)

    def _later(self, k: int) -> Formula:
        """Edge k is not enabled, chosen values left out where their bounds move: they may move along."""
        at, rates = self.scope.identity(self.edges[k]["source"]), self.scope.rates(self.edges[k]["source"])
        moving = {v for v, r in rates.items() if r.terms} | {"@sigma", "time"}
        if all(names(at.poly(r[x])).isdisjoint(moving) for r in self.sets(k) for x in ("low", "high")):
            return self.forbidden(k, False)
        return negated(at.condition(self.edges[k]["guard"]))

    def stuck(self, mode: str) -> Formula:
        """A run certainly cannot go on from here: no time passes, no edge is enabled or due (S12)."""
        leaving = self.leaving[mode] if not self.scope.modes[mode]["terminal"] else []
        now = [self.forbidden(k, False) for k in leaving]
        urgent = [k for k in leaving if self.edges[k]["urgent"]]
        then = [self.soon(self._later(k), mode) for k in urgent]
        return not self.scope.modes[mode]["terminal"] and conj([self.soon(self.outside(mode), mode), *now, *then])


def _interval(pair: Json) -> Interval:
    low, high = (None if x is None else number(x) for x in pair)
    if low is not None and high is not None and low > high:
        raise Refused("an interval of a cell is empty")
    return low, high


class Cell:
    """States `e + c s` of a mode, e in `entry` (with `sigma` where time is tracked), s in `stay`."""

    def __init__(self, model: Model, c: Json, timed: bool) -> None:
        self.scope, self.mode, self.jumps = model.scope, str(c["mode"]), c.get("jumps")
        self.slopes = {**model.scope.flow(self.mode)[1], **({"@sigma": Fraction(1)} if timed else {})}
        given = {**c["entry"], **({"@sigma": c["sigma"]} if timed else {})}
        if given.keys() != self.slopes.keys() or timed is not ("sigma" in c):
            raise Refused("a cell does not say where its variables are")
        self.entry: Box = {v: _interval(given[v]) for v in self.slopes}
        self.stay = _interval(["0", c["dwell"]])
        self.meet = None if c.get("meet") is None else number(c["meet"])
        if self.meet is not None and (self.meet < 0 or (self.stay[1] is not None and self.meet > self.stay[1])):
            raise Refused("a cell meets a goal outside its dwell")
        if not (self.jumps is None or (type(self.jumps) is int and self.jumps >= 0)):
            raise Refused("a cell has a wrong number of jumps")
        self.place = cache(self._place)

    def _place(self, stay: Interval, states: bool = False) -> tuple[Env, Box, Formula]:
        """The state in terms of unknowns, their box, and where unknowns do not fit together.

        The dwell is told by the first variable that moves and is entered at a number, the axis, else by `s`. Of
        other variables the entry is an unknown where it is no number; or with `states` the state itself.
        """
        axis = next((v for v in self.scope.types if self.slopes[v] and point(self.entry[v]) is not None), None)
        fixed, unfit, env, box = point(stay), [], Env({}), Box()
        if fixed is not None:
            axis, dwell = None, const(fixed)
        elif axis is None:
            dwell, box["@s"] = var("@s"), stay
        else:
            origin, slope = point(self.entry[axis]) or START, self.slopes[axis]
            dwell, box[axis] = scale(add(var(axis), const(-origin)), 1 / slope), _moved((origin, origin), slope, stay)
        for v, (low, high) in self.entry.items():
            way = scale(dwell, self.slopes[v])
            if v != axis and low is not None and low == high:
                env[v] = add(const(low), way)
            elif v != axis and (not states or not self.slopes[v]):
                box[v] = (low, high)
                env[v] = add(var(v), way)
            elif v != axis:
                box[v], entered = _moved((low, high), self.slopes[v], stay), add(var(v), way, -1)
                unfit += [literal("<", add(entered, const(low), -1))] if low is not None else []
                unfit += [literal(">", add(entered, const(high), -1))] if high is not None else []
        env["@s"] = dwell
        return Env({v: p for v, p in env.items() if p != var(v)}), box, disj(unfit)

    def shows(self, f: Formula, stay: Interval) -> bool:
        """Is f true in all states of the cell at these dwells?"""
        env, box, unfit = self.place(stay, True)
        return bernstein.shown(disj([placed(f, env), unfit]), {**self.scope.box, **box}, self.scope.whole)


def _moved(i: Interval, c: Fraction, s: Interval) -> Interval:
    """`x + c t` for x in i, t in s."""
    low, high = (None if x is None or (t is None and c) else x + c * (t or 0)
                 for x, t in zip(i, s if c >= 0 else s[::-1], strict=True))  # fmt: skip
    return low, high


class Cells:
    """The cells of a file; complete when every run stays in them, up to the horizon.

    With `met` each run leaves each cell for later ones, or meets a goal: at dwell `meet`, or where `met(k)` holds after
    edge k.
    """

    def __init__(self, model: Model, data: Json, met: Callable[[int], Formula] | None = None) -> None:
        if (data["schema"], data["automaton"], type(data["rho"])) != ("haverify.cells/1", model.a["name"], bool):
            raise Refused("a file of cells has another schema, or is of another automaton")
        self.model, self.scope, self.timed, self.met = model, model.scope, data["rho"], met
        self.time, self.jumps = None if data.get("time") is None else number(data["time"]), data.get("jumps")
        if not (self.jumps is None or type(self.jumps) is int) or (met and (self.time, self.jumps) != (None, None)):
            raise Refused("cells up to a horizon do not show that something must happen")
        if (self.timed and self.scope.rho is None) or (self.time is not None and not self.timed):
            raise Refused("time is tracked, but the modes do not share one rate")
        self.past, self.untaken, self.crossing = cache(self._past), cache(self._untaken), cache(self._crossing)
        self.cells = [Cell(model, c, self.timed) for c in data["cells"]]
        self.by_mode: dict[str, list[int]] = {m: [] for m in self.scope.modes}
        for i, c in enumerate(self.cells):
            self.by_mode[c.mode].append(i)
        for line in model.a["init"]:
            for mode in self.scope.modes if line["mode"] is None else [line["mode"]]:
                self._init(line, mode)
        for i, c in enumerate(self.cells):
            self._check(i, c)

    def late(self, time: Fraction | None, op: str = ">") -> Formula:
        """The instant is after (or at, before) a time."""
        rho = self.scope.rho
        tracked = self.timed and time is not None and rho is not None
        return tracked and literal(op, add(var("@sigma"), scale(rho or ONE, time or START), -1))

    def within(
        self, mode: str, env: Mapping[str, Poly], box: Box, excuse: Formula, jumps: int | None, after: int
    ) -> bool:
        """Is every state of the box, of integers for discrete variables, in a cell of the mode, unless excused?"""
        seen = {v: bernstein.bounds(p, box) for v, p in env.items()}
        spend(len(self.by_mode[mode]) * len(seen))
        left = [c for c in (self.cells[j] for j in self.by_mode[mode] if j > after)
                if c.jumps in (None, jumps) and all(_touch(i, c.entry[v]) for v, i in seen.items())]  # fmt: skip
        inside = [conj(literal(op, add(env[v], const(end), -1)) for v, i in c.entry.items()
                       for op, end in zip((">=", "<="), i, strict=True) if end is not None) for c in left]  # fmt: skip
        return bernstein.shown(disj([excuse, *inside]), box, self.scope.whole)

    def start(self, line: Json, mode: str) -> tuple[Box, Formula] | None:
        """A box around the starts that an init line allows in a mode, and where none is; None where there are none.

        The declared range stands in on a side of a variable that nothing bounds (S5).
        """
        at, scope = self.scope.identity(mode), self.scope
        integral = all(scope.types[r["var"]] == "real" or scope.integral(at.poly(r[x]))
                       for r in line["with"] for x in r.keys() - {"var"})  # fmt: skip
        if not integral:
            raise Beyond("a variable may start at a value between two of its type")
        start = conj([at.condition(line["where"]), self.model.given(line["with"], at), self.model.domain(mode)])
        start = placed(start, Env({"@sigma": ZERO, "time": ZERO}))
        none = negated(start)
        box = bernstein.narrowed(none, {**scope.box, **dict.fromkeys(scope.types, FREE)})
        if box is None:
            return None
        for v in self.model.a["vars"]:
            name, (low, high) = v["name"], box[v["name"]]
            if (low is None or high is None) and not all(_alone(f, name, scope) for f in members(start, "and")):
                raise Beyond(f"starts where {name} is bounded together with others")
            wide = scope.window(v)
            box[name] = (
                scope.range(wide[0])[0] if low is None else low,
                scope.range(wide[1])[1] if high is None else high,
            )
        return box, none

    def _init(self, line: Json, mode: str) -> None:
        """Every start lies in a cell."""
        found = self.start(line, mode)
        env = {**self.scope.identity(mode).env, **({"@sigma": ZERO} if self.timed else {})}
        if found is not None and not self.within(mode, env, *found, 0, -1):
            raise Refused(f"a start leads to states of mode {mode} that are in no cell")

    def _check(self, i: int, c: Cell) -> None:
        """Nothing leaves cell i except into cells, and nothing in it leaves the declared ranges."""
        model, mode, short = self.model, c.mode, self.met is not None and c.meet is not None
        stay = (START, c.meet) if short else c.stay
        key = mode, tuple(c.entry[v] for v in self.scope.types), stay, short
        if key not in model.stays and self._stays(c, stay, short) and model.timeless:
            model.stays.add(key)
        for k in model.leaving[mode] if self.jumps is None or c.jumps != self.jumps else ():
            found = self.outcome(c, k, stay)
            target, jumps = model.edges[k]["target"], None if c.jumps is None else c.jumps + 1
            if found is not None and not self.within(target, *found, jumps, i if self.met else -1):
                raise Refused(f"edge {model.edges[k]['name']} leads to states of mode {target} that are in no cell")

    def _stays(self, c: Cell, stay: Interval, short: bool) -> bool:
        """A cell is in the declared ranges, and no run stays longer than it lasts; does time not matter for that?"""
        past, end = self.past(c), (c.stay[1], c.stay[1])
        if not c.shows(disj([self.model.outside(c.mode), past, self.model.declared(c.mode)]), stay):
            raise Refused(f"a cell of mode {c.mode} leaves the declared ranges")
        ends = disj([self.model.ending(c.mode), past])
        if short or end[1] is None or c.shows(ends, end):
            return True
        if not c.shows(disj([ends, self.late(self.time, ">=")]), end):
            raise Refused(f"a run may stay in mode {c.mode} longer than its cell lasts")
        return False

    def outcome(self, c: Cell, k: int, stay: Interval) -> tuple[Env, Box, Formula] | None:
        """The states that edge k makes of those in a cell at these dwells: what they are in terms of unknowns, the
        unknowns' box and where nothing is to be shown; None if the edge is not taken."""
        env, box, unfit = c.place(stay, True)
        met = self.met(k) if self.met else False
        if self.met and c.meet is not None:  # a run has met the goal when it takes the edge
            met = disj([met, literal(">=", add(var("@s"), const(c.meet), -1))])
        excuse = disj([placed(disj([self.untaken(c, k), met]), env), unfit])
        found = bernstein.narrowed(excuse, {**self.scope.box, **box})
        after = {v: substitute(p, env) for v, p in self.model.landing(k).env.items()}
        clock = {"@sigma": env.get("@sigma", var("@sigma"))} if self.timed else {}
        return None if found is None else (Env({**after, **clock}), found, excuse)

    def _crossing(self, c: Cell, k: int) -> Box | None:
        """A box around the states of the cell, in its unknowns, from which edge k is taken; None where it is not."""
        env, box, _ = c.place(c.stay)
        return bernstein.narrowed(placed(self.untaken(c, k), env), {**self.scope.chosen, **box})

    def _untaken(self, c: Cell, k: int) -> Formula:
        """Edge k is not taken from a state of the cell; an urgent one may fire on the closure of its guard (S8)."""
        forbidden = self.model.forbidden(k, self.model.edges[k]["urgent"])
        return disj([self.model.outside(c.mode), forbidden, self.late(self.time), self.past(c)])

    def _past(self, c: Cell) -> Formula:
        """States of the cell that no run reaches: beyond where an equation in its guard makes an urgent edge due."""
        found = []
        for edge, p in ((k, p) for k in self.model.leaving[c.mode] for p in self.model.equations(k)):
            fires = disj([self.model.outside(c.mode), literal("!=", p), self.model.enabled(edge)])
            if c.shows(literal("<=", p), (START, START)) and c.shows(fires, c.stay):
                found.append(literal(">", p))
        return disj(found)


def _touch(a: Interval, b: Interval) -> bool:
    return not any(x is not None and y is not None and x > y for x, y in ((a[0], b[1]), (b[0], a[1])))


def _alone(f: Formula, name: str, scope: Scope) -> bool:
    """Does f not speak of a variable, or bound it by a linear expression without other variables?"""
    if name not in variables(f):
        return True
    alone = f[0] not in ("or", "!=") and names(f[1]) & scope.types.keys() == {name}
    return alone and all(m == (name,) for m in f[1].terms if name in m)
