"""Claims about whole runs: a formula shown on every way through the cells, or shown to fail on one run."""

from __future__ import annotations

import copy
from fractions import Fraction
from typing import Any, NamedTuple

from hacheck.bernstein import Box, bounds, meet
from hacheck.cells import Cells
from hacheck.expressions import EVENTS, Instant, nodes
from hacheck.formula import Formula, conj, disj, literal, negated, placed
from hacheck.obligations import Question, Setting
from hacheck.polynomial import Env, add, const, var
from hacheck.rational import Beyond, Interval, Refused, number, spend
from hacheck.replay import Stage, Walk
from hacheck.timeline import ZERO, Dwell, Set, Signal, Timeline, atoms, horizon

Json = Any


class Share(NamedTuple):
    """A part of a dwell on which the certificate gives a truth."""

    low: Fraction
    start: int
    high: Fraction
    end: int
    value: str
    tree: Json

    def weaken(self, f: Formula) -> Formula:
        """True as well at ends that do not belong."""
        ends = [(self.low, self.start == 1), (self.high, self.end == 0)] if self.low < self.high else []
        return disj([f, *(literal("==", add(var("@s"), const(-q))) for q, out in ends if out)])


def shares(items: Json, length: Fraction) -> list[Share]:
    """The parts of a dwell, which they must fill."""
    out, at, side = list[Share](), ZERO, 0
    for item in items:
        high, end = number(item[0]), 1 if item[1] is True else 0
        if (high, end) <= (at, side) or item[2] not in ("t", "f", "u"):
            raise Refused("the parts of a dwell are not in order, or have no truth")
        out.append(Share(at, side, high, end, item[2], item[3] if len(item) > 3 else None))
        at, side = high, end
    if (at, side) < (length, 1):
        raise Refused("a truth is not given for the whole of a dwell")
    return out


class Signals:
    """A goal about whole runs, as a formula that is to hold at the start of every run."""

    def __init__(self, q: Question) -> None:
        self.q, self.time = q, q._time
        goal = q.goal["condition"]
        if q.goal["window"] or q.goal["within"] is not None:
            raise Beyond("a formula over time in a window")
        if q.goal["kind"] == "can_always":
            if q.claim["horizon"]["time"] is None:
                raise Beyond("`can always` without a horizon")
            goal = ["eventually", "0", q.claim["horizon"]["time"], ["not", goal]]
        if any(n[0] == "stuck" for n in nodes(goal)):
            raise Beyond("`stuck` in a formula over time")
        self.goal, self.horizon, self.atoms = goal, horizon(goal, self.time), atoms(goal)

    def signal(self, t: Timeline, found: list[list[Share]], landed: list[str | None]) -> Signal:
        """Where an atom must and may hold: what its shares say, but after a jump what the landing says."""
        must: Set = []
        may: Set = []
        for i, (parts, first) in enumerate(zip(found, landed, strict=True)):
            for p in parts:
                low = (p.low, p.start) if first is None else max((p.low, p.start), (ZERO, 1))
                self._add(t, i, p.value, low, (p.high, p.end), must, may)
            if first is not None:
                self._add(t, i, first, (ZERO, 0), (ZERO, 1), must, may)
        return t.union(must), t.union(may)

    def _add(self, t: Timeline, i: int, value: str, low: Any, high: Any, must: Set, may: Set) -> None:
        high = min(high, (t.dwells[i].high, 1))
        if low < high and value != "f":
            span = t.place(i, *low), t.place(i, *high)
            may.append(span)
            must += [span] if value == "t" else []


class Ways(Signals):
    """All ways of runs through cells, with the truths that a certificate gives for each cell."""

    def __init__(self, q: Question, node: Json) -> None:
        super().__init__(q)
        given = node["cells"]
        self.cells = q.setting.cells(given) if isinstance(given, str) else Cells(q.model, given)
        c = self.cells
        if not c.timed or c.jumps is not None or (c.time is not None and c.time <= self.horizon):
            raise Refused("the cells do not track time, or end before the formula's horizon")
        low, high = bounds(q.model.scope.rho, q.model.scope.box) if q.model.scope.rho is not None else (None, None)
        if low is None or high is None or len(node["atoms"]) != len(self.atoms):
            raise Refused("the truths given are not those of the formula's atoms")
        self.rate, self.reach, self.given = (low, high), self.horizon * high, node["atoms"]
        self._stays: dict[tuple[int, int], list[Share]] = {}
        self._landings: dict[tuple[int, int, int], str] = {}

    def length(self, i: int) -> Fraction:
        """How long a stay is looked at."""
        low, dwell = self.cells.cells[i].entry["@sigma"][0], self.cells.cells[i].stay[1]
        if low is None:
            raise Refused("a cell is entered at no bounded time")
        left = max(ZERO, self.reach - low)
        return left if dwell is None else min(dwell, left)

    def prove(self) -> None:
        """The formula holds at the start of every way."""
        scope = self.q.model.scope
        pending: list[tuple[int, tuple[int, int] | None, list[Any]]] = []
        for line in self.q.setting.a["init"]:
            for mode in scope.modes:
                found = self.cells.start(line, mode) if line["mode"] in (None, mode) else None
                if found is not None:
                    box = {v: found[0][v] for v in scope.types}
                    pending += [(i, None, []) for i in self.located(mode, {**box, "@sigma": (ZERO, ZERO)})]
        while pending:
            spend(200)
            i, entered, way = pending.pop()
            if len(way) > 5000:
                raise Beyond("a run with too many jumps")
            cell, length = self.cells.cells[i], self.length(i)
            low, high = cell.entry["@sigma"]
            if low is None or high is None:
                raise Refused("a cell is entered at no bounded time")
            clock = low, high
            if cell.stay[1] is None or high + cell.stay[1] > self.horizon * self.rate[0]:
                self._check([*way, (i, entered, Dwell(length, length, *clock))], False)
            if self._may_end(i, low):
                kept = not scope.modes[cell.mode]["terminal"] and cell.shows(self.q.model.domain(cell.mode), cell.stay)
                self._check([*way, (i, entered, Dwell(length if kept else ZERO, length, *clock))], True)
            for k in self.q.model.leaving[cell.mode]:
                after, s = self._leaving(i, k)
                if not after or s[0] is None or low + s[0] > self.reach:
                    continue
                stay = Dwell(s[0], length if s[1] is None else min(s[1], length), *clock)
                for j in self.located(self.q.setting.a["edges"][k]["target"], after):
                    pending.append((j, (i, k), [*way, (i, entered, stay)]))

    def _leaving(self, i: int, k: int) -> tuple[Box, Interval]:
        """A box around the states that edge k makes of those in a cell, empty if it is not taken, and the dwells."""
        c = self.cells.cells[i]
        found = self.cells.outcome(c, k, c.stay)
        if found is None:
            return {}, c.stay
        dwell = c.place(c.stay, True)[0].get("@s", var("@s"))
        return {v: bounds(p, found[1]) for v, p in found[0].items()}, meet(bounds(dwell, found[1]), c.stay)

    def _may_end(self, i: int, low: Fraction) -> bool:
        """May a run be stuck in a cell, or have ended there in a state that is not followed?"""
        cell = self.cells.cells[i]
        if self.q.model.scope.modes[cell.mode]["terminal"]:
            moving = any(self.q.model.scope.flow(cell.mode)[1].values())
            kept = conj([self.q.model.domain(cell.mode), negated(self.cells.past(cell))])
            ends = cell.stay[1] is not None and low + cell.stay[1] <= self.reach
            return moving or ends or not cell.shows(disj([kept, self.cells.late(self.horizon)]), cell.stay)
        model = self.q.model
        going = [
            model.outside(cell.mode),
            self.cells.past(cell),
            self.cells.late(self.horizon),
            model.lively(cell.mode),
        ]
        return not cell.shows(disj(going), cell.stay)

    def located(self, mode: str, box: Box) -> list[int]:
        """The one cell that contains a box, else all that touch it."""
        members = [(j, self.cells.cells[j]) for j in self.cells.by_mode[mode]]
        spend(len(members) * (len(box) + 1))
        for j, c in members:
            if all(_inside(x, c.entry[v]) for v, x in box.items()):
                return [j]
        return [j for j, c in members if not any(_empty(meet(x, c.entry[v])) for v, x in box.items())]

    def _check(self, way: list[Any], lost: bool) -> None:
        dwells = [d for _, _, d in way]
        if lost:
            d = dwells[-1]
            dwells.append(Dwell(self.reach + 1, self.reach + 1, d.first + d.low, d.last + d.high))
        t = Timeline(dwells, self.rate)

        def read(e: Json) -> Signal:
            n = self.atoms.index(e)
            found = [self.stays(n, i) for i, _, _ in way]
            landed = [
                None if entered is None or not eventful(e) else self.landing(n, *entered) for _, entered, _ in way
            ]
            if lost:
                found.append([Share(ZERO, 0, self.reach + 1, 1, "u", None)])
                landed.append(None)
            return self.signal(t, found, landed)

        must = t.value(self.goal, read, self.time)[0]
        if not must or must[0][0] != (0, ZERO, 0):
            raise Refused("a formula is not shown to hold at the start of every run")

    def stays(self, n: int, i: int) -> list[Share]:
        """The truth of an atom along a stay in a cell, each share with its proof."""
        if (n, i) not in self._stays:
            found, c = shares(self.given[n]["stays"][i], self.length(i)), self.cells.cells[i]
            excuse = disj(
                [self.q.model.outside(c.mode), self.cells.past(c), self._unassumed(self.q.model.scope.identity(c.mode))]
            )
            for p in found:
                if p.value != "u":
                    f = p.weaken(self.q.model.scope.identity(c.mode).formula(self.atoms[n], p.value == "f"))
                    self.q._tree(p.tree, c, f, excuse, (p.low, p.high))
            self._stays[n, i] = found
        return self._stays[n, i]

    def _unassumed(self, at: Instant) -> Formula:
        return disj(at.formula(a, True) for a in self.q.assume)

    def landing(self, n: int, i: int, k: int) -> str:
        """The truth of an atom just after edge k is taken out of cell i."""
        if (n, i, k) not in self._landings:
            given = [x for x in self.given[n]["jumps"] if x[0] == i and x[1] == k][:1]
            for _, _, value, tree in given:
                c, at = self.cells.cells[i], self.q.model.landing(k)
                excuse = disj([self.cells.untaken(c, k), self._unassumed(at)])
                self.q._tree(tree, c, at.formula(self.atoms[n], value == "f"), excuse)
                if value not in ("t", "f"):
                    raise Refused("a truth after a jump is none")
            self._landings[n, i, k] = given[0][2] if given else "u"
        return self._landings[n, i, k]


def eventful(e: Json) -> bool:
    """Does it speak of a jump that has just been made?"""
    return any(n[0] in EVENTS for n in nodes(e))


class Single(Signals):
    """One run, walked exactly."""

    def refute(self, run: Json, given: Json) -> None:
        """The formula does not hold at the start of the run."""
        walk = Walk(self.q.model, run, self.q.assume)
        before: list[Stage | None] = [None, *(x if x.at.edge is not None else None for x in walk.stages[:-1])]
        seen = [(landed, x) for landed, x in zip(before, walk.stages, strict=True) if x.at.edge is None]
        dwells = [Dwell(x.dwell, x.dwell, x.time, x.time) for _, x in seen]
        lost = walk.time <= self.horizon
        if lost:
            dwells.append(Dwell(self.horizon + 1, self.horizon + 1, walk.time, walk.time))
        t = Timeline(dwells, (Fraction(1), Fraction(1)))
        if len(given) != len(self.atoms) or any(len(x) != len(seen) for x in given):
            raise Refused("the truths given are not those of the formula's atoms along the run")

        def read(e: Json) -> Signal:
            items = given[self.atoms.index(e)]
            found = [self._along(walk, e, at, x) for (_, at), x in zip(seen, items, strict=True)]
            at_once = [self._now(walk, e, x) if x is not None and eventful(e) else None for x, _ in seen]
            if lost:
                found.append([Share(ZERO, 0, self.horizon + 1, 1, "u", None)])
                at_once.append(None)
            return self.signal(t, found, at_once)

        may = t.value(self.goal, read, self.time)[1]
        if may and may[0][0] == (0, ZERO, 0):
            raise Refused("a run is not shown to violate the formula")

    def _along(self, walk: Walk, e: Json, stage: Stage, items: Json) -> list[Share]:
        found = shares(items, stage.dwell)
        for p in found:
            if p.value != "u":
                f = placed(p.weaken(stage.at.formula(e, p.value == "f")), stage.state)
                if not walk.surely(placed(f, Env({"@s": add(var("@s"), const(p.low))})), p.high - p.low):
                    raise Refused("a truth along a run is not the one given")
        return found

    def _now(self, walk: Walk, e: Json, stage: Stage) -> str:
        yes, no = (placed(stage.at.formula(e, neg), stage.state) for neg in (False, True))
        return "t" if walk.surely(yes) else "f" if walk.surely(no) else "u"


def _empty(i: Interval) -> bool:
    return i[0] is not None and i[1] is not None and i[0] > i[1]


def _inside(a: Interval, b: Interval) -> bool:
    below = b[0] is None or (a[0] is not None and b[0] <= a[0])
    return below and (b[1] is None or (a[1] is not None and a[1] <= b[1]))


def narrowed(q: Question, place: Json, end: str, at: Json) -> Question:
    """The question with the lower (`high` moved) or upper (`low`) part of a range alone."""
    core, a, data = copy.copy(q.setting.core), dict(q.setting.a), dict(q.setting.core.data)
    core.data = data
    if place[0] == "param":
        for holder in (data, a):
            holder["params"] = [{**p, end: at} if p["name"] == place[1] else p for p in holder["params"]]
    elif place[0] == "start" and type(place[1]) is int and 0 <= place[1] < len(a["init"]):
        bound = ["<=" if end == "high" else ">=", ["var", place[2]], at]
        a["init"] = [
            {**x, "where": ["and", x["where"], bound]} if n == place[1] else x for n, x in enumerate(a["init"])
        ]
    else:
        raise Refused("a range is split that there is not")
    return Question(Setting(core, a, q.model.scope.rounding, q.setting.load), q.claim, q.goal)


def follow(q: Question, tree: Json, depth: int = 0) -> None:
    """Every share of the ranges is shown."""
    if isinstance(tree, list) and len(tree) == 5 and tree[0] == "split" and depth < 60:
        number(tree[2])
        follow(narrowed(q, tree[1], "high", tree[2]), tree[3], depth + 1)
        follow(narrowed(q, tree[1], "low", tree[2]), tree[4], depth + 1)
    elif isinstance(tree, dict):
        Ways(q, tree).prove()
    else:
        raise Refused("a tree of shares is malformed")


def established(q: Question, entry: Json) -> str:
    """`proved` or `refuted`: what an entry shows of a goal about whole runs; Refused where it shows nothing."""
    if "run" in entry:
        Single(q).refute(entry["run"], entry["atoms"])
        shown = "refuted"
    else:
        q.setting.start(entry["start"], q.assume)
        follow(q, entry["tree"])
        shown = "proved"
    if q.goal["kind"] == "can_always":
        return "refuted" if shown == "proved" else "proved"
    return shown
