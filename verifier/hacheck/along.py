"""Claims about flows and jumps, shown along a record: at all instants of all steps, and at all jumps.

A record that is too coarse is beyond the checker, not refused.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from hacheck.crossings import Crossing, borders, crossed, during, rate
from hacheck.enclosures import Model, bounds, exponents, middle
from hacheck.expressions import nodes
from hacheck.flow_starts import FlowStarts
from hacheck.formula import conj
from hacheck.rational import Beyond, Refused, number, spend
from hacheck.records import Ends, Here, Record, whole
from hacheck.tapes import UNKNOWN, Known, Tape, Truth, closed_bounds, holds, literals, places
from hacheck.tubes import Field

if TYPE_CHECKING:
    from hacheck.obligations import Question, Shown

Json = Any
States = dict[str, Model]
CLOSE, FEW = 14, 6  # how often a step is cut in halves
HALF = {-1: ((0, 1), (1, 1)), 0: ((-1, 1), (1, 1))}  # (a + b x) / 2 for the halves of [0, 1] and [-1, 1]


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
        if self.scope.rounding or question.assume or question.limit is None:
            raise Beyond("a flow with rounded constants, assumptions, or no horizon")
        if any(t != "real" for t in self.scope.types.values()):
            raise Beyond("a flow beside discrete variables")
        if any(mode["terminal"] for mode in self.scope.modes.values()) or any(
            n[0] == "stuck" for n in nodes(question.condition)
        ):
            raise Beyond("a flow that a run may leave for good")
        self.record = self._record(question, name)
        self.starts = FlowStarts(self.scope, self.record)
        self.space, self.limit = self.record.space, question.limit
        self.first, self.positive = max(question.after or Fraction(0), Fraction(0)), question.goal["kind"] == "always"
        self._rules: dict[str, Rules] = {}

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
            claim, window = tape.truth(self.q.condition, not self.positive), self._window(tape)
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
        for op, place in literals(("and", r.claim, r.window)):
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
        away = holds(("<=" if is_upper else ">=", moves), values, r.inside)
        return away is True or holds(r.domain, values) is False

    def _stretch(self, node: Json, here: Here, params: Mapping[str, Model],
                 touching: list[tuple[int, bool]] | None = None) -> None:  # fmt: skip
        """The claim holds along the steps of a stretch, up to the horizon or to jumps, and along what follows."""
        steps, jumps = list(node["steps"]), node.get("jumps")
        for n, step in enumerate(steps):
            states, _, after = self.record.step(here, params, step)
            if jumps is not None and n == len(steps) - 1:
                self._leave(here, step, jumps, params)
                return
            known = self._held(here.mode, states, touching or []) if not n else UNKNOWN
            self._need(self._close(states, partial(self._fits, here.mode, known, UNKNOWN), CLOSE), states)
            if self._is_late(after.time, inclusive=True):
                return
            here = after
        raise Beyond("a recorded flow ends before the claim's horizon")

    def _need(self, is_shown: bool, states: States) -> None:
        if not is_shown:
            at = bounds(states["time"])[0] / self.space.one
            raise Beyond(f"a claim is not shown along a recorded flow, from {at:.6g} s on")

    def _is_late(self, time: Model, inclusive: bool = False) -> bool:
        """Is it certainly after the horizon, or not before it?"""
        low, limit = Fraction(bounds(time)[0], self.space.one), self.limit
        return low >= limit if inclusive else low > limit

    def _is_early(self, time: Model) -> bool:
        return Fraction(bounds(time)[1], self.space.one) < self.first

    def _fits(self, mode: str, held: Known, before: Known, states: States) -> bool:
        """No run is here, or the claim holds, the declared ranges are kept and no jump is possible.

        `before` holds at instants before a crossing only, which itself is looked at where jumps are.
        """
        if self._is_late(states["time"]):
            return True
        r = self.rules(mode)
        values = r.field.tape.values(r.read, states, self.space)
        if holds(r.domain, values) is False:
            return True
        known = {**r.inside, **held}
        fits = holds(r.window, values, known) and (self._is_early(states["time"]) or holds(r.claim, values, known))
        return fits is True and all(holds(g, values, {**known, **before}) is False for g in r.guards.values())

    def _close(self, states: States, fits: Callable[[States], bool], depth: int) -> bool:
        """Does something hold for all states of a step, or on both halves?"""
        spend(20)
        return fits(states) or (depth > 0 and all(self._close(half, fits, depth - 1) for half in self._halves(states)))

    def _halves(self, states: States) -> Iterator[States]:
        """States cut where they vary most: in time, or in a set variable."""
        width = {-1: 0, **dict.fromkeys(range(len(self.record.set)), 0)}
        for m in states.values():
            for i, terms in m.parts.items():
                for k, c in terms.items():
                    for v in [-1] * (i > 0) + [j for j, e in enumerate(exponents(k)) if e]:
                        width[v] += abs(c)
        cut = max(width, key=lambda v: width[v])
        for a, b in HALF[min(cut, 0)]:
            whole, half = a * self.space.one >> 1, b * self.space.one >> 1
            part = Model({0: {0: whole, self.record.unit(cut): half}} if cut >= 0 else {0: {0: whole}, 1: {0: half}}, 0)
            yield {v: self.space.replaced(m, cut, part) for v, m in states.items()}

    # Jumps

    def _leave(self, here: Here, step: Json, jumps: list[Json], params: Mapping[str, Model]) -> None:
        """All runs are out of the domain at the end of a step; the jumps at its border go on as the record says."""
        states, h, _ = self.record.step(here, params, step)
        found = self.record.once(lambda: self._border(here.mode, states, h), here, step, "border")
        self._before(here.mode, states, found)
        self._jumps(here.mode, found, jumps, params)

    def _border(self, mode: str, states: States, h: Model) -> Crossing:
        r = self.rules(mode)
        for place, sign in borders(r.domain):
            try:
                found = crossed(r.field, place, sign, states, h)
            except Beyond:
                continue
            if found is not None:
                return found
        raise Beyond("it is not shown that all runs leave their domain in a step")

    def _before(self, mode: str, states: States, found: Crossing) -> None:
        """Until its border the domain's quantity is strictly inside, so jumps that need the border are not made."""
        one = self.space.one
        if found.since:
            early = during(self.space, states, 0, found.since)
            self._need(self._close(early, partial(self._fits, mode, UNKNOWN, UNKNOWN), CLOSE), early)
        late = during(self.space, states, found.since, one - found.since)
        inside: Known = {found.place: (None, -1) if found.sign > 0 else (1, None)}
        self._need(self._close(late, partial(self._fits, mode, UNKNOWN, inside), CLOSE), late)

    def _jumps(self, mode: str, found: Crossing, jumps: list[Json], params: Mapping[str, Model]) -> None:
        """Each edge that may be taken at the border is in the record, and the claim holds there and afterwards."""
        r, given = self.rules(mode), {whole(j["edge"], 0, 10**6): j for j in jumps}
        values = r.field.tape.values(r.read, found.states, self.space)
        for k, guard in r.guards.items():
            if holds(guard, values, {found.place: (0, 0)}) is False or self._is_late(found.states["time"]):
                continue
            tape, after = self._landing(k, found.states)
            target = self.model.edges[k]["target"]
            domain = tape.truth(self.scope.modes[target]["domain"], closed=True)
            claim, window = tape.truth(self.q.condition, not self.positive), self._window(tape)
            landed = tape.values(places(("and", domain, claim, window)), after, self.space)
            if holds(domain, landed) is False:
                continue
            fits = holds(window, landed) and (self._is_early(after["time"]) or holds(claim, landed))
            self._need(fits is True, after)
            if k not in given:
                raise Beyond(f"a jump that may be made is not in the record: {self.model.edges[k]['name']}")
            begun = partial(self.record.landed, target, given[k]["x"], after, after["time"])
            self._stretch(given[k], self.record.once(begun, found, given[k]), params)

    def _landing(self, k: int, before: States) -> tuple[Tape, States]:
        """The instant just after an edge: its tape, with the states after and before it."""
        edge = self.model.edges[k]
        tape, source = Tape(self.scope, edge["target"], edge), self.record.field(edge["source"]).tape
        resets = {r["var"]: r for r in edge["resets"]}
        if any("to" not in r for r in resets.values()):
            raise Beyond("a reset that leaves a choice")
        outcome = {v: source.value(r["to"]) for v, r in resets.items()}
        values = source.values(outcome.values(), before, self.space)
        after = {v: values[outcome[v]] if v in outcome else before[v] for v in self.scope.types}
        return tape, {**before, **after, **{f"pre {v}": before[v] for v in self.scope.types}}

    # One run

    def violated(self, run: Json) -> str:
        """The run stays in its domain and in the declared ranges up to its last instant, where the claim is false."""
        mode, box, last = str(run["mode"]), self.starts.admissible(run), number(run["last"])
        if run["steps"] or self.model.leaving[mode]:
            raise Beyond("a run with jumps along recorded flows")
        if not self.first <= last <= self.limit:
            raise Refused("a run ends at an instant that the claim does not speak of")
        (start,), here, params = self.record.data["starts"], self.record.start(mode, box), self.record.params(box)
        for step in start["pieces"]["steps"]:
            begun, (states, h, after) = here.time, self.record.step(here, params, step)
            if len(set(bounds(h))) > 1:
                raise Beyond("a recorded run has a step of no one length")
            done = Fraction(bounds(after.time)[0], self.space.one) >= last
            until = self._upto(states, begun, h, last, False) if done else states
            if not self._close(until, partial(self._possible, mode), CLOSE):
                raise Beyond("a recorded run may leave its domain or the declared ranges")
            if done:
                r, end = self.rules(mode), self._upto(states, begun, h, last, True)
                if holds(r.claim, r.field.tape.values(places(r.claim), end, self.space)) is not False:
                    raise Beyond("a recorded run does not certainly violate the claim at its end")
                return mode
            here = after
        raise Beyond("a recorded run ends before its last instant")

    def _possible(self, mode: str, states: States) -> bool:
        r = self.rules(mode)
        values = r.field.tape.values(places(("and", r.window, r.domain)), states, self.space)
        return holds(r.window, values) is True and holds(r.domain, values) is True

    def _upto(self, states: States, begun: Model, h: Model, last: Fraction, only: bool) -> States:
        """The states up to an instant, or at that instant alone, of a step that begins at an exact one."""
        share = self.space.number(
            (last - Fraction(bounds(begun)[0], self.space.one)) / Fraction(middle(h), self.space.one)
        )
        part = share if only else self.space.mul(share, Model({1: {0: self.space.one}}, 0))
        return {v: self.space.replaced(m, -1, part) for v, m in states.items()}


def shown_along(question: Question, entry: Json) -> Shown:
    """The verdict that an entry of kind `flowpipe` or `flow_run` establishes."""
    if "flow" not in entry:
        raise Beyond("a flow without a record")
    along, lines = Along(question, entry["flow"]), question.setting.a["init"]
    positive = question.goal["kind"] == "always"
    where = along.starts.mode(lines[0])
    question.same(entry, "flow", where, "")
    if entry["kind"] == "flow_run":
        along.violated(entry["run"])
        verdict = "refuted" if positive else "proved"
    else:
        along.starts.admissible(entry["start"])
        starts = along.record.data["starts"]
        if len(starts) != len(lines):
            raise Refused("a recorded flow has other starts than the automaton")
        for given, line in zip(starts, lines, strict=True):
            mode = along.starts.mode(line)
            along.shown(given["pieces"], mode, along.starts.box(line, mode, given["box"]))
        verdict = "proved" if positive else "refuted"
    return verdict, [(where, "", verdict)]
