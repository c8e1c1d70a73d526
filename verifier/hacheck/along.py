"""Claims about flows and jumps, shown along a record: at all instants of all steps, and at all jumps.

A record that is too coarse is beyond the checker, not refused.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from hacheck.crossings import Crossing, borders, crossed, during, rate
from hacheck.enclosures import Model, bounds, exponents, size
from hacheck.expressions import nodes
from hacheck.flow_starts import FlowStarts
from hacheck.formula import conj
from hacheck.rational import Beyond, Refused, spend
from hacheck.records import Ends, Here, Record, Stay, whole
from hacheck.tapes import UNKNOWN, Known, Tape, Truth, closed_bounds, holds, literals, places
from hacheck.tubes import Field

if TYPE_CHECKING:
    from hacheck.obligations import Question, Shown

Json = Any
States = dict[str, Model]
CLOSE, FEW = 14, 6  # how often a step is cut in halves
PARTS = 4  # of a step, at whose ends a goal may be met
HALF = {-1: (0, 1), 0: (-1, 1)}  # (a + x) / 2 for the halves of [0, 1] and [-1, 1]


class Aim(NamedTuple):
    """A goal as a condition on the instants from `first` to `last` of all runs.

    It holds at all of them, or, if it is to be met, at one. Where runs have to be lively they go on until then.
    """

    condition: Json
    first: Fraction
    last: Fraction
    positive: bool = True
    meet: bool = False
    lively: bool = False


def aim_of(question: Question) -> Aim:
    """What a goal comes to; of `stl` one temporal operator."""
    kind, limit, condition = question.goal["kind"], question.limit, question.condition
    first = max(question.after or Fraction(0), Fraction(0))
    if kind == "stl":
        if condition[0] not in ("globally", "eventually") or question.goal["window"] or _temporal(condition) != 1:
            raise Beyond("a formula of several temporal operators, or of none, along a flow")
        first, limit, condition = *question.ends(condition[1:3]), condition[3]
        return Aim(condition, first, limit, meet=question.condition[0] == "eventually", lively=True)
    if limit is None:
        raise Beyond("a flow without a horizon")
    return Aim(condition, first, limit, kind != "can_reach", meet=kind == "reach", lively=kind == "reach")


def _temporal(e: Json) -> int:
    return sum(n[0] in ("globally", "eventually", "until") for n in nodes(e))


class Rules(NamedTuple):
    """What matters while dwelling in a mode: conditions on the mode's tape, the guards of its edges."""

    field: Field
    claim: Truth
    domain: Truth
    window: Truth
    guards: dict[int, Truth]
    read: list[int]
    inside: Known  # what the domain says while a run is in it


class Along:
    """One goal of a claim along a record."""

    def __init__(self, question: Question, name: Json) -> None:
        self.q, self.scope, self.model = question, question.scope, question.model
        self.aim = self._aim()
        if self.scope.rounding or question.assume:
            raise Beyond("a flow with rounded constants, or assumptions")
        if any(t != "real" for t in self.scope.types.values()):
            raise Beyond("a flow beside discrete variables")
        if any(mode["terminal"] for mode in self.scope.modes.values()) or any(
            n[0] == "stuck" for n in nodes(question.condition)
        ):
            raise Beyond("a flow that a run may leave for good")
        self.record = self._record(question, name)
        self.starts = FlowStarts(self.scope, self.record)
        self.space = self.record.space
        self._rules: dict[str, Rules] = {}

    def _aim(self) -> Aim:
        return aim_of(self.q)

    def _record(self, question: Question, name: Json) -> Record:
        """The record of a name; claims whose records are equal share what is found out about it."""
        data = question.setting.load(name)
        key = json.dumps(data, sort_keys=True)
        known: dict[str, Record] = question.setting.records
        if key not in known:
            known[key] = Record(self.scope, data)
        return known[key]

    def rules(self, mode: str) -> Rules:
        """The conditions of a mode."""
        if mode not in self._rules:
            field = self.record.field(mode)
            tape, edges = field.tape, self.model.edges
            claim, window = tape.truth(self.aim.condition, not self.aim.positive), self._window(tape)
            domain = tape.truth(self.scope.modes[mode]["domain"], closed=True)
            guards = {k: tape.truth(edges[k]["guard"], closed=edges[k]["urgent"]) for k in self.model.leaving[mode]}
            read = places(("and", claim, domain, window, *guards.values()))
            self._rules[mode] = Rules(field, claim, domain, window, guards, read, closed_bounds(domain))
        return self._rules[mode]

    def _window(self, tape: Tape) -> Truth:
        return conj(tape.truth(e) for e in self.starts.window())

    # All runs

    def shown(self, tree: Json, mode: str, box: Mapping[str, Ends]) -> None:
        """The claim holds along all pieces of a tree of halves of the box."""
        spend(100)
        if "split" in tree:
            low, high = box[tree["split"]]
            middle = (low + high) / 2
            self.shown(tree["low"], mode, {**box, tree["split"]: (low, middle)})
            self.shown(tree["high"], mode, {**box, tree["split"]: (middle, high)})
            return
        self._stretch(tree, self.record.start(mode, box), self.record.params(box), self._touching(mode, box))

    def _touching(self, mode: str, box: Mapping[str, Ends]) -> list[tuple[int, bool]]:
        """Quantities of claim and window that keep their bound at the start exactly; is it an upper one?"""
        r = self.rules(mode)
        sides = {**box, "time": (Fraction(0), Fraction(0))}
        found = []
        for op, place in literals(("and", r.claim, r.window, r.domain)):
            ends = r.field.tape.exactly(place, sides) if op in ("<=", ">=") else None
            if ends is not None and (ends[1] <= 0 if op == "<=" else ends[0] >= 0):
                found.append((place, op == "<="))
        return found

    def _held(self, mode: str, states: States, touching: list[tuple[int, bool]]) -> Known:
        """Those of them that move away from their bound, or along it, during the whole first step."""
        r, found = self.rules(mode), dict(UNKNOWN)
        for place, is_upper in touching:
            moves = rate(r.field, place)
            if moves is None or self._close(states, partial(self._moves, mode, moves, is_upper), FEW):
                found[place] = (None, 0) if is_upper else (0, None)
        return found

    def _moves(self, mode: str, moves: int, is_upper: bool, states: States) -> bool:
        r = self.rules(mode)
        values = r.field.tape.values([moves, *r.read], states, self.space)
        away = holds(("<=" if is_upper else ">=", moves), values, {} if self.aim.lively else r.inside)
        return away is True or (not self.aim.lively and holds(r.domain, values) is False)

    def _stretch(self, node: Json, here: Here, params: Mapping[str, Model],
                 touching: list[tuple[int, bool]] | None = None) -> None:  # fmt: skip
        """The claim holds along the steps of a stretch, up to the horizon or to jumps, and along what follows."""
        steps, jumps, first = list(node["steps"]), node.get("jumps"), True
        for n, step in enumerate(steps):
            stays = self.record.steps(here, params, step)
            for stay in stays:
                if jumps is not None and n == len(steps) - 1 and stay is stays[-1]:
                    self._leave(stay, jumps, params)
                    return
                known = self._held(here.mode, stay.states, touching or []) if first else UNKNOWN
                self._need(self._close(stay.states, partial(self._fits, here.mode, known, UNKNOWN), CLOSE), stay.states)
                if self._is_met(here.mode, known, stay):
                    return
                if self._is_late(stay.after.time, inclusive=True):
                    self._is_over()
                    return
                here, first = stay.after, False
        raise Beyond("a recorded flow ends before the claim's horizon")

    def _is_over(self) -> None:
        if self.aim.meet:
            raise Beyond("a goal is not met in time along a recorded flow")

    def _is_met(self, mode: str, known: Known, stay: Stay) -> bool:
        """Is there an instant of the step, at the same part of it for all states, at which all meet the goal?"""
        if not self.aim.meet:
            return False
        r, one = self.rules(mode), self.space.one
        for k in range(PARTS + 1):
            states = during(self.space, stay.states, one * k // PARTS, 0)
            values = r.field.tape.values(places(r.claim), states, self.space)
            if self._is_asked(states["time"]) and holds(r.claim, values, known) is True:
                return True
        return False

    def _is_asked(self, time: Model) -> bool:
        """Is it certainly an instant that the goal speaks of?"""
        low, high = (Fraction(end, self.space.one) for end in bounds(time))
        return self.aim.first <= low and high <= self.aim.last

    def _need(self, is_shown: bool, states: States) -> None:
        if not is_shown:
            at = bounds(states["time"])[0] / self.space.one
            raise Beyond(f"a claim is not shown along a recorded flow, from {at:.6g} s on")

    def _is_late(self, time: Model, inclusive: bool = False) -> bool:
        """Is it certainly after the horizon, or not before it?"""
        low, limit = Fraction(bounds(time)[0], self.space.one), self.aim.last
        return low >= limit if inclusive else low > limit

    def _is_early(self, time: Model) -> bool:
        return Fraction(bounds(time)[1], self.space.one) < self.aim.first

    def _fits(self, mode: str, held: Known, before: Known, states: States) -> bool:
        """No run is here, or the claim holds, the declared ranges are kept and no jump is possible.

        `before` holds at instants before a crossing only, which itself is looked at where jumps are.
        """
        if self._is_late(states["time"]):
            return True
        r = self.rules(mode)
        values = r.field.tape.values(r.read, states, self.space)
        if self.aim.lively:
            if holds(r.domain, values, {**held, **before}) is not True:
                return False
        elif holds(r.domain, values) is False:
            return True
        known = {**r.inside, **held}
        fits = holds(r.window, values, known) and (
            self.aim.meet or self._is_early(states["time"]) or holds(r.claim, values, known)
        )
        return fits is True and all(holds(g, values, {**known, **before}) is False for g in r.guards.values())

    def _close(self, states: States, fits: Callable[[States], bool], depth: int) -> bool:
        """Does something hold for all states of a step, or on both halves?"""
        spend(20)
        return fits(states) or (depth > 0 and all(self._close(half, fits, depth - 1) for half in self._halves(states)))

    def _halves(self, states: States) -> Iterator[States]:
        """States cut where they vary most: in time, or in a set variable."""
        width = {-1: 0, **dict.fromkeys(range(len(self.record.set)), 0)}
        by_key: dict[int, int] = defaultdict(int)
        for m in states.values():
            for i, terms in m.parts.items():
                width[-1] += size(terms) if i else 0
                for k, c in terms.items():
                    by_key[k] += abs(c)
        for k, c in by_key.items():
            for j, e in enumerate(exponents(k)):
                width[j] += c if e else 0
        cut = max(width, key=lambda v: width[v])
        half = self.space.one >> 1
        for a in HALF[min(cut, 0)]:
            yield {v: self.space.moved(m, cut, a * half, half) for v, m in states.items()}

    # Jumps

    def _leave(self, stay: Stay, jumps: list[Json], params: Mapping[str, Model]) -> None:
        """All runs are out of the domain at the end of a step; the jumps at its border go on as the record says."""
        found, mode = self.border(stay), stay.before.mode
        self.before(mode, stay.states, found, self._fits)
        self._jumps(mode, found, jumps, params)

    def border(self, stay: Stay) -> Crossing:
        """Where all states of a step leave their domain."""
        found: Crossing = self.record.once(lambda: self._border(stay), stay, "border")
        return found

    def _border(self, stay: Stay) -> Crossing:
        r = self.rules(stay.before.mode)
        for place, sign in borders(r.domain):
            try:
                found = crossed(r.field, place, sign, stay.states, stay.h)
            except Beyond:
                continue
            if found is not None:
                return found
        raise Beyond("it is not shown that all runs leave their domain in a step")

    def before(self, mode: str, states: States, found: Crossing, fits: Callable[..., bool]) -> None:
        """Until its border the domain's quantity is strictly inside, so jumps that need the border are not made."""
        one = self.space.one
        if found.since:
            early = during(self.space, states, 0, found.since)
            self._need(self._close(early, partial(fits, mode, UNKNOWN, UNKNOWN), CLOSE), early)
        late = during(self.space, states, found.since, one - found.since)
        inside: Known = {found.place: (None, -1) if found.sign > 0 else (1, None)}
        self._need(self._close(late, partial(fits, mode, UNKNOWN, inside), CLOSE), late)

    def _jumps(self, mode: str, found: Crossing, jumps: list[Json], params: Mapping[str, Model]) -> None:
        """Each edge that may be taken at the border is in the record, and the claim holds there and afterwards."""
        r, given = self.rules(mode), {whole(j["edge"], 0, 10**6): j for j in jumps}
        values, goes_on = r.field.tape.values(r.read, found.states, self.space), False
        if self._is_late(found.states["time"]):
            self._is_over()
            return
        for k, guard in r.guards.items():
            if holds(guard, values, {found.place: (0, 0)}) is False:
                continue
            landing = self.landing(k, found)
            goes_on = goes_on or (self.is_taken(k, found) and landing.domain is True)
            if landing.domain is False:
                continue
            self._need((landing.window and self._serves(landing)) is True, landing.states)
            if self.aim.meet and landing.claim is True and self._is_asked(landing.states["time"]):
                continue
            if k not in given:
                raise Beyond(f"a jump that may be made is not in the record: {self.model.edges[k]['name']}")
            self._stretch(given[k], self.landed(k, given[k], found, landing), params, landing.touching)
        if self.aim.lively and not goes_on:
            raise Beyond("a run may be stuck where it leaves its domain")

    def _serves(self, landing: Landing) -> bool | None:
        return True if self.aim.meet or self._is_early(landing.states["time"]) else landing.claim

    def is_taken(self, k: int, found: Crossing) -> bool:
        """Is the guard of an edge, as written, certainly true at a border?"""
        edge = self.model.edges[k]
        tape = self.rules(edge["source"]).field.tape
        guard = tape.truth(edge["guard"])
        return holds(guard, tape.values(places(guard), found.states, self.space), {found.place: (0, 0)}) is True

    def landed(self, k: int, given: Json, found: Crossing, landing: Landing) -> Here:
        """Where a recorded stretch begins after an edge."""
        target, time = self.model.edges[k]["target"], landing.states["time"]
        begun = partial(self.record.landed, target, given["x"], landing.states, time)
        here: Here = self.record.once(begun, found, given)
        return here

    def landing(self, k: int, found: Crossing) -> Landing:
        """The instant just after an edge; what is 0 at the border still is, if nothing in it is reset."""
        edge, before = self.model.edges[k], found.states
        tape, source = Tape(self.scope, edge["target"], edge), self.record.field(edge["source"]).tape
        resets = {r["var"]: r for r in edge["resets"]}
        if any("to" not in r for r in resets.values()):
            raise Beyond("a reset that leaves a choice")
        outcome = {v: source.value(r["to"]) for v, r in resets.items()}
        values = source.values(outcome.values(), before, self.space)
        after = {v: values[outcome[v]] if v in outcome else before[v] for v in self.scope.types}
        states = {**before, **after, **{f"pre {v}": before[v] for v in self.scope.types}}
        zero = tape.taken(source, found.place, set(resets))
        known: Known = {} if zero is None else {zero: (0, 0)}
        conditions = [tape.truth(self.scope.modes[edge["target"]]["domain"], closed=True), self._window(tape),
                      tape.truth(self.aim.condition, not self.aim.positive)]  # fmt: skip
        landed = tape.values(places(("and", *conditions)), states, self.space)
        r = self.rules(edge["target"])
        still = r.field.tape.taken(source, found.place, set(resets))
        touching = [(p, op == "<=") for op, p in literals(("and", r.claim, r.window, r.domain))
                    if p == still and op in ("<=", ">=")]  # fmt: skip
        domain, window, claim = (holds(c, landed, known) for c in conditions)
        return Landing(states, domain, window, claim, touching)


class Landing(NamedTuple):
    """The states after and before a jump, what holds there, and which quantities touch their bounds."""

    states: States
    domain: bool | None
    window: bool | None
    claim: bool | None
    touching: list[tuple[int, bool]]


def shown_along(question: Question, entry: Json) -> Shown:
    """The verdict that an entry of kind `flowpipe` or `flow_run` establishes."""
    if "flow" not in entry:
        raise Beyond("a flow without a record")
    lines, is_reached = question.setting.a["init"], question.goal["kind"] != "can_reach"
    if entry["kind"] == "flow_run":
        from hacheck.along_runs import AlongRun

        run = AlongRun(question, entry["flow"])
        where = run.starts.mode(lines[0])
        question.same(entry, "flow", where, "")
        run.decides(entry["run"])
        verdict = "refuted" if is_reached else "proved"
        return verdict, [(where, "", verdict)]
    along = Along(question, entry["flow"])
    where = along.starts.mode(lines[0])
    question.same(entry, "flow", where, "")
    along.starts.admissible(entry["start"])
    starts = along.record.data["starts"]
    if len(starts) != len(lines):
        raise Refused("a recorded flow has other starts than the automaton")
    for given, line in zip(starts, lines, strict=True):
        mode = along.starts.mode(line)
        along.shown(given["pieces"], mode, along.starts.box(line, mode, given["box"]))
    verdict = "proved" if is_reached else "refuted"
    return verdict, [(where, "", verdict)]
