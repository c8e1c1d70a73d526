"""One run along a record: it certainly exists, takes its edges, and decides a goal."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from typing import Any

from hacheck.along import CLOSE, Along, Landing
from hacheck.crossings import during
from hacheck.enclosures import bounds, middle
from hacheck.rational import Beyond, Refused, number
from hacheck.records import Here, Stay
from hacheck.tapes import UNKNOWN, Known, holds, places

Json = Any
NEAR = Fraction(1, 2**16)  # s; dwells up to a jump are numbers for people to read


class AlongRun(Along):
    """A run of a recorded flow from one start. Its dwells end where it leaves the domain, or are exact: the last one.

    The other dwells are numbers near those instants, nothing rests on them.
    """

    def decides(self, run: Json) -> None:
        """The run violates the claim (meets the goal of `can reach`) at its end, or never meets what it should."""
        mode, box = str(run["mode"]), self.starts.admissible(run)
        (start,), here, params = self.record.data["starts"], self.record.start(mode, box), self.record.params(box)
        node, landing, touching = start["pieces"], None, self._touching(mode, box)
        for jump in run["steps"]:
            k, stays = jump["edge"], list(self._stays(node, here, params))
            self._waits(stays[:-1], touching)
            landing = self._taken(k, jump, stays)
            node = self._next(node, k)
            here, touching = self.landed(k, node, self.border(stays[-1]), landing), landing.touching
        if self.aim.meet:
            self._never(node, here, params, touching)
        else:
            self._ends(node, here, params, touching, number(run["last"]), landing)

    @staticmethod
    def _next(node: Json, k: Json) -> Json:
        """Where a record goes on after edge k."""
        found = [j for j in node["jumps"] if j["edge"] == k]
        if len(found) > 1:
            raise Beyond("a recorded run may take its edge at several instants")
        if not found:
            raise Refused("a run takes an edge that its record does not have")
        return found[0]

    def _stays(self, node: Json, here: Here, params: Any) -> Any:
        for step in node["steps"]:
            for stay in self.record.steps(here, params, step):
                if len(set(bounds(stay.h))) > 1:
                    raise Beyond("a recorded run has a step of no one length")
                yield stay
                here = stay.after

    def _waits(self, stays: list[Stay], touching: list[tuple[int, bool]]) -> None:
        """The run goes on for some steps; where a goal is to be missed it does not meet it."""
        for n, stay in enumerate(stays):
            mode = stay.before.mode
            known = self._held(mode, stay.states, touching) if not n else UNKNOWN
            if not self._close(stay.states, partial(self._goes_on, mode, known, UNKNOWN), CLOSE):
                raise Beyond("a recorded run may leave its domain or the declared ranges, or be made to jump")

    def _goes_on(self, mode: str, held: Known, before: Known, states: Any) -> bool:
        """Is the run in its domain and in the declared ranges, with no urgent edge due? `before` is of no crossing."""
        r = self.rules(mode)
        values, strictly = r.field.tape.values(r.read, states, self.space), {**held, **before}
        due = [g for k, g in r.guards.items() if self.model.edges[k]["urgent"]]
        misses = not self.aim.meet or self._is_outside(states) or holds(r.claim, values, held) is False
        return (misses and holds(r.domain, values, strictly) is True and holds(r.window, values, held) is True
                and all(holds(g, values, strictly) is False for g in due))  # fmt: skip

    def _is_outside(self, states: Any) -> bool:
        return self._is_late(states["time"]) or self._is_early(states["time"])

    def _taken(self, k: Json, jump: Json, stays: list[Stay]) -> Landing:
        """The last of some steps leads to a border, where the run takes edge k."""
        if not stays or type(k) is not int or k not in self.rules(stays[-1].before.mode).guards or jump.get("values"):
            raise Refused("a run takes an edge that its mode does not have, or chooses where nothing is left open")
        stay, found = stays[-1], self.border(stays[-1])
        self.before(stay.before.mode, stay.states, found, self._goes_on)
        ended = sum(Fraction(middle(s.h), self.space.one) for s in stays)
        if not ended - Fraction(middle(stay.h), self.space.one) - NEAR <= number(jump["dwell"]) <= ended + NEAR:
            raise Refused("a dwell of a run ends elsewhere than its record says")
        landing = self.landing(k, found)
        if not (self.is_taken(k, found) and landing.domain is True and landing.window is True):
            raise Beyond("a recorded run does not certainly take its edge")
        if self.aim.meet and not (self._is_outside(landing.states) or landing.claim is False):
            raise Beyond("a recorded run may meet its goal at a jump")
        return landing

    def _ends(self, node: Json, here: Here, params: Any, touching: list[tuple[int, bool]], last: Fraction,
              landing: Landing | None) -> None:  # fmt: skip
        """The run goes on for a time, at whose end the claim is certainly false."""
        if last < 0:
            raise Refused("a run dwells for a negative time")
        if landing is None and not self.aim.first <= last <= self.aim.last:
            raise Refused("a run ends at an instant that the claim does not speak of")
        if landing is not None and not last:
            if not self._is_asked(landing.states["time"]):
                raise Refused("a run ends at an instant that the claim does not speak of")
            if landing.claim is not False:
                raise Beyond("a recorded run does not certainly violate the claim at its end")
            return
        passed = Fraction(0)
        for n, stay in enumerate(self._stays(node, here, params)):
            length = Fraction(middle(stay.h), self.space.one)
            share = min(Fraction(1), (last - passed) / length)
            part = int(share * self.space.one)
            upto = stay._replace(states=during(self.space, stay.states, 0, min(part + 1, self.space.one)))
            self._waits([upto], touching if not n else [])
            if share < 1 or passed + length == last:
                self._fails(stay, part, is_exact=landing is None)
                return
            passed += length
        raise Beyond("a recorded run ends before its last instant")

    def _fails(self, stay: Stay, part: int, is_exact: bool) -> None:
        """The claim is false from an instant on for the least time, in which the run's last instant lies."""
        r = self.rules(stay.before.mode)
        end = during(self.space, stay.states, part, min(1, self.space.one - part))
        if not (is_exact or self._is_asked(end["time"])):
            raise Refused("a run ends at an instant that the claim does not speak of")
        if holds(r.claim, r.field.tape.values(places(r.claim), end, self.space)) is not False:
            raise Beyond("a recorded run does not certainly violate the claim at its end")

    def _never(self, node: Json, here: Here, params: Any, touching: list[tuple[int, bool]]) -> None:
        """The run goes on past the last instant that the goal speaks of."""
        for n, stay in enumerate(self._stays(node, here, params)):
            self._waits([stay], touching if not n else [])
            if self._is_late(stay.after.time, inclusive=True):
                return
        raise Beyond("a recorded run ends before its goal's time is over")
