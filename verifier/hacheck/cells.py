"""Cells: boxes of entry states with a dwell, which together contain every run; and what certainly happens in them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import ceil, floor
from typing import Any, NamedTuple

from hacheck import bernstein
from hacheck.expressions import Instant, Scope
from hacheck.formula import Formula, conj, literals, variables
from hacheck.polynomial import ONE, ZERO, Images, Poly, add, by_power, const, constant, names, scale, var
from hacheck.rational import Beyond, Interval, Refused, number, spend

Json = Any
Box = dict[str, Interval]
Landing = Callable[["Cells", int, int, Interval, Box], bool]  # cells, cell, edge, scaled dwells, outcomes
Bound = tuple[str, bool, bool, Fraction, Fraction]  # variable, is it an upper bound, strict, between these values


def meet(a: Interval, b: Interval) -> Interval:
    """The intersection; empty ones have low > high."""
    low = a[0] if b[0] is None else b[0] if a[0] is None else max(a[0], b[0])
    return low, a[1] if b[1] is None else b[1] if a[1] is None else min(a[1], b[1])


def hull(a: Interval, b: Interval) -> Interval:
    """The least interval around both."""
    low = None if a[0] is None or b[0] is None else min(a[0], b[0])
    return low, None if a[1] is None or b[1] is None else max(a[1], b[1])


def empty(i: Interval) -> bool:
    """Has it no element?"""
    return i[0] is not None and i[1] is not None and i[0] > i[1]


def inside(a: Interval, b: Interval) -> bool:
    """Is a contained in b?"""
    below = b[0] is None or (a[0] is not None and b[0] <= a[0])
    return below and (b[1] is None or (a[1] is not None and a[1] <= b[1]))


def plus(i: Interval, c: Fraction, s: Interval) -> Interval:
    """`x + c t` for x in i, t in s, s starting at a finite end."""
    ends = (s[0], s[1]) if c >= 0 else (s[1], s[0])
    low, high = (None if e is None and c else c * (e or 0) for e in ends)
    return (None if i[0] is None or low is None else i[0] + low, None if i[1] is None or high is None else i[1] + high)


class Model:
    """An automaton with its bounds and slopes, under one reading of the constants."""

    def __init__(self, scope: Scope) -> None:
        self.scope, self.a = scope, scope.automaton
        if self.a["inputs"] or self.a["priorities"]:
            raise Beyond("automata with inputs or priorities")
        self.leaving: dict[str, list[int]] = {m: [] for m in scope.modes}
        for k, e in enumerate(self.a["edges"]):
            self.leaving[e["source"]].append(k)
        self._bounds: dict[tuple[str, int, object], tuple[Poly, list[Bound] | None]] = {}
        self._flows: dict[str, tuple[Poly, dict[str, Fraction]]] = {}
        self._landings: dict[tuple[int, str], Instant] = {}
        self._guards: dict[tuple[int, bool, bool, bool], Formula] = {}
        try:
            rhos = [self.flow(m)[0] for m in scope.modes]
            scope.rho = rhos[0] if all(r == rhos[0] for r in rhos) else None
        except Refused:
            scope.rho = None  # time is not tracked then

    def flow(self, mode: str) -> tuple[Poly, dict[str, Fraction]]:
        """`rho` > 0 and the slopes `c` with rate = c * rho."""
        if mode not in self._flows:
            rates = self.scope.rates(mode)
            rho = next((r for r in rates.values() if constant(r) is None), ONE)
            lead = next(iter(rho.terms))
            slopes = {v: Fraction(r.terms.get(lead, 0) * rho.unit, rho.terms[lead] * r.unit) for v, r in rates.items()}
            if any(scale(rho, slopes[v]) != r for v, r in rates.items()):
                raise Beyond(f"the rates of mode {mode} are no rational multiples of one of them")
            if not bernstein.certain(">", rho, self.scope.box):
                raise Refused(f"the rate of mode {mode} is not positive for all params")
            self._flows[mode] = rho, slopes
        return self._flows[mode]

    def domain(self, mode: str) -> Formula:
        """The domain, closed, at the state its variables name."""
        return self.scope.identity(mode).domain

    def landing(self, k: int, pick: str = "any") -> Instant:
        """Just after edge k, over the variables before it; chosen values are `v'`, or an end of their range."""
        if (k, pick) not in self._landings:
            edge = self.a["edges"][k]
            before = self.scope.identity(edge["source"])
            env = dict(before.env)
            for r in edge["resets"]:
                v, ends = r["var"], {x: before.poly(r[x]) for x in r.keys() - {"var"}}
                if self.scope.types[v] != "real" and not all(map(self.scope.integral, ends.values())):
                    raise Beyond(f"{v} may get a value between two of its type")
                env[v] = ends["to"] if "to" in r else var(v + "'") if pick == "any" else ends[pick]
            self._landings[k, pick] = Instant(self.scope, edge["target"], env, edge=edge["name"], before=before)
        return self._landings[k, pick]

    def guard(self, k: int, neg: bool = False, closed: bool = False, outer: bool = False) -> Formula:
        """The guard of an edge at the state before it, exact or closed."""
        key = k, neg, closed, outer
        if key not in self._guards:
            edge = self.a["edges"][k]
            self._guards[key] = self.scope.identity(edge["source"]).formula(edge["guard"], neg, closed, outer)
        return self._guards[key]

    def bounds(self, op: str, p: Poly, over: Collection[str] | None = None) -> list[Bound] | None:
        """A literal as bounds on one variable: `a v + r op 0`, a rational, r without other variables of the state."""
        key = op, id(p), over is None or frozenset(over)
        if key not in self._bounds:
            self._bounds[key] = p, self._bound(op, p, self.scope.types if over is None else over)
        return self._bounds[key][1]

    def _bound(self, op: str, p: Poly, over: Collection[str]) -> list[Bound] | None:
        found = sorted(names(p) & set(over))
        if len(found) != 1 or op == "!=" or "sigma" in names(p):
            return None
        parts = by_power(p, found[0])
        a = constant(parts.get(1, ONE))
        if a is None or not parts.keys() <= {0, 1}:
            return None
        low, high = bernstein.bounds(scale(parts.get(0, ZERO), -1 / a), self.scope.box)
        if low is None or high is None:
            return None
        return [(found[0], up, op == "<", low, high) for up in ((True, False) if op == "==" else (a > 0,))]

    def narrow(self, f: Formula, box: Box) -> Box | None:
        """The box cut by what f bounds, read as closed; of alternatives the hull; None where nothing is left."""
        spend(10)
        if isinstance(f, bool):
            return box if f else None
        if f[0] == "and":
            for g in f[1:]:
                cut = self.narrow(g, box)
                if cut is None:
                    return None
                box = cut
            return box
        if f[0] == "or":
            left = [b for b in (self.narrow(g, box) for g in f[1:]) if b is not None]
            out = left[0] if left else None
            for b in left[1:]:
                out = {v: hull(i, b[v]) for v, i in (out or {}).items()}
            return out
        for v, upper, _, low, high in self.bounds(f[0], f[1], box) or ():
            box = {**box, v: meet(box[v], (None, high) if upper else (low, None))}
            if empty(box[v]):
                return None
        return box

    def certainly(self, f: Formula, box: Box) -> bool:
        """Is f true on a box of states, perhaps unbounded?"""
        spend(10)
        if isinstance(f, bool):
            return f
        if f[0] in ("and", "or"):
            return (all if f[0] == "and" else any)(self.certainly(g, box) for g in f[1:])
        found = self.bounds(*f)
        if found is None:
            return bernstein.certain(f[0], f[1], {**self.scope.box, **box})
        return all(_beyond(box[v][1], low, strict) if upper else _beyond(_minus(box[v][0]), -high, strict)
                   for v, upper, strict, low, high in found)  # fmt: skip

    def lands(self, k: int, box: Box) -> bool:
        """Does edge k have an outcome in the domain of its target from every state of the box?"""
        picks = ("low", "high") if self._nonempty(k, box) else ()
        return any(self.certainly(self.landing(k, pick).domain, box) for pick in picks)

    def _nonempty(self, k: int, box: Box) -> bool:
        before = self.scope.identity(self.a["edges"][k]["source"])
        chosen = [add(before.poly(r["low"]), before.poly(r["high"]), -1)
                  for r in self.a["edges"][k]["resets"] if "to" not in r]  # fmt: skip
        return all(self.certainly(("<=", p) if names(p) else constant(p) <= 0, box) for p in chosen)  # type: ignore[operator]


def _minus(x: Fraction | None) -> Fraction | None:
    return None if x is None else -x


def _beyond(x: Fraction | None, bound: Fraction, strict: bool) -> bool:
    return x is not None and (x < bound or (x == bound and not strict))


def _values(i: Interval, real: bool) -> list[Interval]:
    """An interval as it is, or the integers in it."""
    if real or i[0] is None or i[1] is None:
        return [i]
    if i[1] - i[0] > 1000:
        raise Beyond("a discrete variable has too many values")
    return [(Fraction(n), Fraction(n)) for n in range(ceil(i[0]), floor(i[1]) + 1)]


class Cell(NamedTuple):
    """States `e + c s`, e in `entry`, s in `stay`, of a mode."""

    mode: str
    entry: Box
    sigma: Interval | None
    stay: Interval
    jumps: int | None
    meet: Fraction | None


def _interval(pair: Json) -> Interval:
    low, high = (None if x is None else number(x) for x in pair)
    if empty((low, high)):
        raise Refused("an interval of a cell is empty")
    return low, high


def _cell(model: Model, c: Json, timed: bool) -> Cell:
    if c["mode"] not in model.scope.modes or set(c["entry"]) != set(model.scope.types) or timed is not ("sigma" in c):
        raise Refused("a cell does not say where its variables are")
    dwell, at = (None if q is None else number(q) for q in (c["dwell"], c.get("meet")))
    if (dwell is not None and dwell < 0) or (at is not None and (at < 0 or (dwell is not None and at > dwell))):
        raise Refused("a cell has a negative dwell")
    if not (c.get("jumps") is None or (type(c["jumps"]) is int and c["jumps"] >= 0)):
        raise Refused("a cell has a wrong number of jumps")
    sigma = _interval(c["sigma"]) if timed else None
    entry = {v: _interval(i) for v, i in c["entry"].items()}
    return Cell(c["mode"], entry, sigma, (Fraction(0), dwell), c.get("jumps"), at)


class Cells:
    """The cells of a file; `complete` when every run stays in them, up to the horizon.

    With `landing`, runs are followed until they meet a goal: it says whether an edge lands where the goal holds.
    """

    def __init__(self, model: Model, data: Json, landing: Landing | None = None) -> None:
        head = data["schema"], data["automaton"], type(data["rho"])
        if head != ("haverify.cells/1", model.a["name"], bool):
            raise Refused("a file of cells has another schema, or is of another automaton")
        self.model, self.timed, self.meeting, self.landing = model, data["rho"], landing is not None, landing
        self.time, self.jumps = None if data.get("time") is None else number(data["time"]), data.get("jumps")
        if not (self.jumps is None or type(self.jumps) is int):
            raise Refused("a file of cells has a wrong number of jumps")
        if self.meeting and (self.time is not None or self.jumps is not None):
            raise Refused("cells up to a horizon do not show that something must happen")
        self.cells = [_cell(model, c, self.timed) for c in data["cells"]]
        if (self.timed or self.time is not None) and (not self.timed or model.scope.rho is None):
            raise Refused("time is tracked, but the modes do not share one rate")
        self._placed: dict[Any, tuple[dict[str, Poly], Box, Images]] = {}
        self.end = self.horizon(self.time)[1]
        self._init()
        for i in range(len(self.cells)):
            self._check(i)

    def horizon(self, time: Fraction | None) -> Interval:
        """The scaled instants at which time passes `time`, over all params."""
        rho = self.model.scope.rho
        return (None, None) if time is None or rho is None else bernstein.bounds(scale(rho, time), self.model.scope.box)

    def at(self, i: int, s: Interval) -> Box:
        """The states of a cell at scaled dwells s, domain ignored."""
        c = self.cells[i]
        slopes = self.model.flow(c.mode)[1]
        spend(2 * len(slopes) + 5)
        return {v: plus(e, slopes[v], s) for v, e in c.entry.items()}

    def _contained(self, mode: str, box: Box, sigma: Interval, jumps: int | None, after: int, what: str) -> None:
        """For each choice of discrete values, the box lies in one cell."""
        spend(2 * len(self.by_mode[mode]) + 5)
        fits = [c for j in self.by_mode[mode] if j > after for c in [self.cells[j]]
                if (c.jumps is None or c.jumps == jumps) and (c.sigma is None or inside(sigma, c.sigma))]  # fmt: skip
        for choice in product(*(_values(i, self.model.scope.types[v] == "real") for v, i in box.items())):
            spend((len(fits) + 1) * (len(box) + 1))
            if not any(all(inside(i, c.entry[v]) for v, i in zip(box, choice, strict=True)) for c in fits):
                raise Refused(f"{what} leads to states of mode {mode} that are in no cell")

    def _init(self) -> None:
        """Every start lies in a cell."""
        for line in self.model.a["init"]:
            for mode in self.model.scope.modes:
                start = self._start(line, mode) if line["mode"] in (None, mode) else None
                if start is not None and not any(empty(i) for i in start.values()):
                    self._contained(mode, start, (Fraction(0), Fraction(0)), 0, -1, "a start")

    def _start(self, line: Json, mode: str) -> Box | None:
        """A box around what an init line allows; the declared range on sides that nothing bounds."""
        scope = self.model.scope
        start: Box = dict.fromkeys(scope.types, (None, None))
        for r in line["with"]:
            ends = [Instant(scope, mode, {}).poly(r[x]) for x in (("to", "to") if "to" in r else ("low", "high"))]
            start[r["var"]] = bernstein.bounds(ends[0], scope.box)[0], bernstein.bounds(ends[1], scope.box)[1]
            if scope.types[r["var"]] != "real" and not all(map(scope.integral, ends)):
                raise Beyond(f"{r['var']} may start at a value between two of its type")
        where = conj([scope.identity(mode).formula(line["where"], closed=True), self.model.domain(mode)])
        members = where[1:] if not isinstance(where, bool) and where[0] == "and" else (where,)
        vague = set().union(*(variables(f) for f in members
                              if isinstance(f, bool) or f[0] == "or" or self.model.bounds(*f) is None))  # fmt: skip
        box = self.model.narrow(where, start)
        if box is None:
            return None
        for v in self.model.a["vars"]:
            name, (low, high), wide = v["name"], box[v["name"]], scope.window(v["name"])
            if v["type"] == "real" and name in vague and (low is None or high is None):
                raise Beyond(f"starts where {name} is bounded together with others")
            box[name] = wide[0] if low is None else low, wide[1] if high is None else high
        return box

    def _check(self, i: int) -> None:
        """Nothing leaves cell i except into cells, and nothing in it leaves the declared ranges."""
        c, model = self.cells[i], self.model
        short = self.meeting and c.meet is not None
        stay = (c.stay[0], c.meet) if short else c.stay
        states = model.narrow(model.domain(c.mode), self.at(i, stay))
        for v in model.a["vars"]:
            if states is not None and not inside(states[v["name"]], model.scope.window(v["name"])):
                raise Refused(f"a cell of mode {c.mode} leaves the declared range of {v['name']}")
        if not short and c.stay[1] is not None and not self.ends(i):
            raise Refused(f"a run may stay in mode {c.mode} longer than its cell lasts")
        for k in model.leaving[c.mode]:
            if not (self.jumps is not None and c.jumps == self.jumps):
                edge, (box, sigma, s) = model.a["edges"][k], self.outcome(i, k, stay)
                if short and c.meet is not None and s[0] is not None and s[0] >= c.meet:
                    continue  # a run has met the goal when it takes the edge
                if box is not None and not (self.landing is not None and self.landing(self, i, k, s, box)):
                    jumps = None if c.jumps is None else c.jumps + 1
                    after = i if self.meeting else -1
                    self._contained(edge["target"], box, sigma, jumps, after, f"edge {edge['name']}")

    def cut(self, i: int, f: Formula, stay: Interval) -> Interval:
        """The scaled dwells at which f, closed, may hold as far as it bounds single variables."""
        slopes = self.model.flow(self.cells[i].mode)[1]
        box = self.model.narrow(f, self.at(i, stay))
        if box is None:
            return Fraction(1), Fraction(0)
        for v, (low, high) in box.items():
            c, (a, b) = slopes[v], self.cells[i].entry[v]
            first, last = (low, high) if c > 0 else (high, low)
            near, far = (b, a) if c > 0 else (a, b)
            if c:
                stay = meet(stay, (None if first is None or near is None else (first - near) / c,
                                   None if last is None or far is None else (last - far) / c))  # fmt: skip
        return stay

    def outcome(self, i: int, k: int, stay: Interval) -> tuple[Box | None, Interval, Interval]:
        """A box around the states that edge k makes of cell i (None where it cannot be taken), their time, the dwells.

        An urgent edge may fire on the closure of its guard (S8), a plain one only where the guard holds as written.
        """
        c, edge, model = self.cells[i], self.model.a["edges"][k], self.model
        both = conj([model.guard(k, closed=True), model.domain(c.mode)])
        s = self.cut(i, both, stay)
        before = None if empty(s) else model.narrow(both, self.at(i, s))
        sigma = plus(c.sigma, Fraction(1), s) if c.sigma is not None and not empty(s) else (None, None)
        if before is None or (self.end is not None and sigma[0] is not None and sigma[0] > self.end):
            return None, sigma, s
        if not edge["urgent"] and model.certainly(model.guard(k, neg=True), before):
            return None, sigma, s
        space, landed = {**model.scope.box, **before}, model.landing(k).env
        after = dict(before)
        for r in edge["resets"]:
            ends = [bernstein.bounds(landed[r["var"]] if x == "to" else model.landing(k, x).env[r["var"]], space)
                    for x in (("to", "to") if "to" in r else ("low", "high"))]  # fmt: skip
            after[r["var"]] = ends[0][0], ends[1][1]
            if model.scope.types[r["var"]] != "real" and not inside(after[r["var"]], model.scope.window(r["var"])):
                raise Refused(f"edge {edge['name']} may give {r['var']} a value that its type does not have")
        if any(empty(x) for x in after.values()):
            return None, sigma, s
        return model.narrow(model.domain(edge["target"]), after), meet(sigma, (None, self.end)), s

    def ends(self, i: int) -> bool:
        """Does no run stay in cell i longer than its dwell?"""
        c = self.cells[i]
        dwell = c.stay[1]
        if c.sigma is not None and self.time is not None and self.over(i, self.time):
            return True
        if dwell is not None and self._passed(i, self.model.domain(c.mode), dwell):
            return True
        due = [self.due(i, k) for k in self.model.leaving[c.mode] if self.model.a["edges"][k]["urgent"]]
        return any(d is not None and dwell is not None and d[1] <= dwell for d in due)

    def over(self, i: int, time: Fraction) -> bool:
        """Is it `time` or later at the end of cell i?"""
        low, dwell, end = (self.cells[i].sigma or (None, None))[0], self.cells[i].stay[1], self.horizon(time)[1]
        return low is not None and dwell is not None and end is not None and low + dwell >= end

    def _passed(self, i: int, f: Formula, dwell: Fraction) -> bool:
        """Is the closed f false at every scaled dwell beyond `dwell`?"""
        if isinstance(f, bool):
            return not f
        if f[0] in ("and", "or"):
            return (any if f[0] == "and" else all)(self._passed(i, g, dwell) for g in f[1:])
        slopes, box = self.model.flow(self.cells[i].mode)[1], self.at(i, (dwell, dwell))
        return any(inside(box[v], (high, None)) if upper else inside(box[v], (None, low))
                   for v, upper, _, low, high in self.model.bounds(*f) or ()
                   if slopes[v] and (slopes[v] > 0) is upper)  # fmt: skip

    def due(self, i: int, k: int) -> tuple[Fraction, Fraction, Box] | None:
        """Where edge k certainly becomes enabled: the scaled dwells between which, and the states until then.

        Its guard must be a conjunction of bounds on single variables that hold from some scaled dwell on, or one `==`.
        """
        c, guard, model = self.cells[i], self.model.guard(k), self.model
        slopes, first, last, strict = model.flow(c.mode)[1], Fraction(0), Fraction(0), False
        if guard is False or any(f[0] == "or" for f in ([guard] if not isinstance(guard, bool) else [])):
            return None
        members = () if guard is True else guard[1:] if guard[0] == "and" else (guard,)
        moving: Box = {}
        reached: Box = {}
        moved: list[str] = []
        for f in members:
            if f[0] not in ("and", "or") and not names(f[1]) & set(c.entry) and model.certainly(f, c.entry):
                continue
            found = None if f[0] in ("and", "or") else model.bounds(*f)
            if found is None:
                return None
            for v, upper, tight, low, high in found:
                a, b, slope = c.entry[v][0], c.entry[v][1], slopes[v]
                if not slope and model.certainly(f, c.entry):
                    continue
                far, near = (b, a) if upper else (a, b)
                exact = f[0] == "=="
                if far is None or near is None or slope == 0 or ((slope < 0) is not upper and not exact):
                    return None
                ends = sorted(((low - near) / slope, (high - near) / slope, (low - far) / slope, (high - far) / slope))
                if exact and ends[0] < 0:
                    return None  # some state is past the instant
                moved.append(f[0])
                first, last, strict = max(first, ends[0]), max(last, ends[3]), strict or tight
                moving[v] = hull(moving.get(v, (a, b)), (low, high))
                reached[v] = meet(reached.get(v, (None, None)), (None, high) if upper else (low, None))
        if "==" in moved and moved != ["==", "=="]:
            return None  # what holds at one instant only need not hold together with the rest
        margin = Fraction(1, 10**9) if strict else Fraction(0)
        states, until = self.at(i, (first, last + margin)), self.at(i, (Fraction(0), last))
        if len(moving) == 1:
            v, reach = next(iter(moving.items()))
            limit = plus(meet(reach, reached[v]), slopes[v], (Fraction(0), margin))
            states[v], until[v] = meet(states[v], limit), meet(until[v], reach)
        return (first, last, until) if model.lands(k, states) else None

    def exits(self, i: int, k: int) -> bool:
        """Is edge k certainly enabled, at the latest, when the stay in cell i ends?"""
        c, due, model = self.cells[i], self.due(i, k), self.model
        if due is None or not model.certainly(model.domain(c.mode), due[2]):
            return False
        if model.a["edges"][k]["urgent"]:
            return c.stay[1] is None or due[1] <= c.stay[1]
        loose = all(op != "<" or model.certainly((op, p), c.entry) for op, p in literals(model.guard(k)))
        box = model.narrow(conj([model.guard(k, closed=True), model.domain(c.mode)]), self.at(i, (due[0], c.stay[1])))
        loose = loose and self._at_the_end(i, k)
        return loose and c.stay[1] is not None and self.ends(i) and box is not None and model.lands(k, box)

    def _at_the_end(self, i: int, k: int) -> bool:
        """Is what the guard of edge k wants to be equal equal at the end of every stay, which the domain forces?"""
        c, model = self.cells[i], self.model
        space = model.narrow(model.domain(c.mode), self.at(i, (Fraction(0), None)))
        for op, p in literals(model.guard(k)):
            for v, upper, _, low, high in (model.bounds(op, p) or ()) if op == "==" else ():
                slope = model.flow(c.mode)[1][v]
                if slope and upper is (slope > 0):
                    limit = (None, low) if upper else (high, None)
                    if space is None or not inside(space[v], limit):
                        return False
        return True

    def never_stuck(self, i: int, time: Fraction | None) -> bool:
        """Can a run in cell i always go on, at least until `time`?"""
        c, model = self.cells[i], self.model
        if model.scope.modes[c.mode]["terminal"]:
            return True
        if any(self.exits(i, k) for k in model.leaving[c.mode]):
            return True
        unbounded = c.stay[1] is None or (time is not None and self.over(i, time))
        beyond = None if c.stay[1] is None else c.stay[1] + Fraction(1, 10**9)  # time passes at the last instant too
        return unbounded and model.certainly(model.domain(c.mode), self.at(i, (Fraction(0), beyond)))

    @cached_property
    def by_mode(self) -> dict[str, list[int]]:
        """The cells of each mode, in order."""
        out: dict[str, list[int]] = {m: [] for m in self.model.scope.modes}
        for i, c in enumerate(self.cells):
            out[c.mode].append(i)
        return out

    def place(self, i: int, s: Interval, sets: Box) -> tuple[dict[str, Poly], Box, Images]:
        """State variables as polynomials of entry and dwell, and the box these vary in; points are no variables."""
        key, c, scope = (i, s, tuple(sets.items())), self.cells[i], self.model.scope
        if key not in self._placed:
            box: Box = {**{p: scope.box[p] for p in scope.params}, **sets}
            parts: dict[str, Poly] = {}
            for v, (low, high) in {**c.entry, "s": s, **({"sigma": c.sigma} if c.sigma is not None else {})}.items():
                parts[v] = const(low) if low is not None and low == high else var(v)
                if names(parts[v]):
                    box[v] = (low, high)
            slopes = self.model.flow(c.mode)[1]
            env = {v: add(parts[v], scale(parts["s"], slopes[v])) for v in c.entry}
            if c.sigma is not None:
                env["sigma"] = add(parts["sigma"], parts["s"])
            self._placed[key] = env, box, {}
        return self._placed[key]
