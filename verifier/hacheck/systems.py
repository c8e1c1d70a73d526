"""Claims about systems: a list of symbolic states that no run leaves, or one run (docs/core.md section 7)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from hacheck.core import Core
from hacheck.expressions import nodes
from hacheck.networks import Move, Network
from hacheck.rational import Beyond, Refused, number, spend
from hacheck.readings import TIME, Event, State
from hacheck.symmetry import Symmetry
from hacheck.wholes import Whole
from hacheck.zones import Formula, Zone, both, inside, opposite

if TYPE_CHECKING:
    from hacheck.obligations import Setting

Json = Any
Load = Callable[[Json], Json]
MODEL = ("systems", "automata", "constants", "params", "enums", "assumptions")


def obligation(core: Core, claim: Json, goal: Json) -> str:
    """The hash of a goal: of all systems, automata and numbers of the core, and of what the claim says."""
    said = [goal, claim["horizon"], claim["assume"], claim["on"]]
    value = ["haverify.obligation/1", {k: core.data[k] for k in MODEL}, *said]
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


class Listed:
    """A file of symbolic states, closed under time and jumps up to inclusion and the symmetry it names.

    `time`, `jumps`: the horizon for which it is closed; None where for all runs.
    """

    def __init__(self, core: Core, system: Json, data: Json) -> None:
        said = data["schema"], data["system"]
        if said != ("haverify.states/1", system["name"]):
            raise Refused("the states are of another schema or system")
        self.time = None if data["time"] is None else number(data["time"])
        self.jumps = data["jumps"]
        if self.jumps is not None and (type(self.jumps) is not int or self.jumps < 0):
            raise Refused("a number of jumps is none")
        self.network = Network(core, system, data["scale"], self.time is not None)
        self.symmetry = Symmetry(self.network, data["symmetry"])
        self.states = [self._state(entry) for entry in data["states"]]
        self.hints = [entry["next"] for entry in data["states"]]
        self.limit: Formula = True if self.time is None else self.network.truth(["<=", [TIME], data["time"]], ())
        starts = list(self.network.starts())
        if not starts:
            raise Refused("the system has no start, so nothing can be shown of its runs")
        for s, z in starts:
            self._covered(data["starts"], s, z, 0)
        for i, _ in enumerate(self.states):
            for _, target, landed, depth in self.landings(i):
                self._covered(self.hints[i], target, landed, depth)

    def _state(self, entry: Json) -> tuple[State, Zone, int]:
        net, given = self.network, entry["at"]
        if not isinstance(given, list) or len(given) != len(net.slots):
            raise Refused("a state does not give each part a mode and each discrete variable a value")
        s = tuple(number(v) if i >= len(net.automata) else v for i, v in enumerate(given))
        if any(f"{a.prefix}{v}" not in net.domains for a, v in zip(net.automata, s, strict=False)):
            raise Refused("a state has a mode that its part lacks")
        z = net.space.read(entry["zone"])
        if net.space.cut(z, opposite(net.window(s))):
            raise Beyond("a state leaves the declared range of a variable")
        depth = entry["jumps"] if self.jumps is not None else 0
        if type(depth) is not int or depth < 0:
            raise Refused("a state does not say after how many jumps it is reached")
        return s, z, depth

    def landings(self, i: int) -> Iterator[tuple[Move, State, Zone, int]]:
        """What follows a listed state by one jump, within the horizon, and the number of jumps by then."""
        s, z, depth = self.states[i]
        if self.jumps is None or depth < self.jumps:
            for m, target, landed in self.network.landings(s, z):
                yield m, target, landed, depth + (self.jumps is not None)

    def instants(self) -> Iterator[tuple[State, Zone, Event | None]]:
        """All states with the jump just made: the starts, what lands, and what follows either after some time."""
        net = self.network
        for s, z in net.starts():
            yield from ((s, q, None) for _, q in net.dwells(s, z))
        for i, _ in enumerate(self.states):
            for m, s, z, _ in self.landings(i):
                yield s, z, m.event
                for q, dwelt in net.dwells(s, z):
                    later = net.space.formula(net.space.after(q)) if q is not None else False
                    yield from ((s, p, None) for p in net.space.cut(dwelt, later))

    def _covered(self, hints: Json, s: State, z: Zone, depth: int) -> None:
        """All that time makes of a landing is inside listed states, renamed as the hints say."""
        renamed = [(self.symmetry.renaming(r), k) for r, k in hints]
        if any(type(k) is not int or not 0 <= k < len(self.states) for _, k in renamed):
            raise Refused("a hint to no listed state")
        space = self.network.space
        spend(10 * len(renamed))
        near = [
            (r.clocks, z2)
            for r, k in renamed
            for t, z2, jumps in [self.states[k]]
            if jumps <= depth and r.state(s) == t
        ]
        for _, dwelt in self.network.dwells(s, z):
            for part in space.cut(dwelt, self.limit):
                if not any(inside(space.permuted(part, clocks), z2) for clocks, z2 in near):
                    raise Refused(f"a state that follows is in no listed state: {', '.join(map(str, s))[:150]}")


class SystemCheck:
    """The claims on one system, and the files of states already checked."""

    def __init__(self, core: Core, system: Json, load: Load, lemma: Load | None = None) -> None:
        self.core, self.system, self.load, self.lemma = core, system, load, lemma
        self._listed: dict[str, Listed] = {}
        self._wholes: dict[str, Whole] = {}

    @cached_property
    def plain(self) -> Network:
        """The system as one of clocks."""
        return Network(self.core, self.system, 1, False)

    def whole(self, claim: Json, certificate: Json) -> tuple[Json, Json, Setting]:
        """The claim, its certificate, and the automaton that the system is, as the certificate wants it looked at."""
        given, everywhere = certificate["whole"], claim["inductive"] is not False
        key = json.dumps([given, everywhere])
        if key not in self._wholes:
            self._wholes[key] = Whole(self, given, everywhere)
        return self._wholes[key].question(claim, certificate)

    def listed(self, name: Json) -> Listed:
        """A file of states, checked once."""
        key = str(name)
        if key not in self._listed:
            self._listed[key] = Listed(self.core, self.system, self.load(key))
        return self._listed[key]

    def verdict(self, claim: Json, goal: Json, entry: Json) -> str:
        """What a goal entry of a certificate establishes; unknown where it shows nothing."""
        if entry == {}:
            return "unknown"
        if entry.get("hash") != obligation(self.core, claim, goal):
            raise Refused("a goal has another hash than the obligation derived from the core")
        if claim["assume"] or self.core.data["assumptions"] or claim["which"]:
            raise Beyond("assumptions and `for which` in claims about systems")
        kind = entry["kind"], goal["kind"]
        if kind in (("states", "always"), ("states", "can_reach")) and not claim["inductive"]:
            self._all(claim, goal, self.listed(entry["states"]))
        elif kind in (("run", "always"), ("run", "can_reach")):
            self._one(claim, goal, entry)
        else:
            raise Beyond(f"a goal `{goal['kind']}` about a system, shown in this way")
        return "proved" if (entry["kind"] == "states") is (goal["kind"] == "always") else "refuted"

    def _limits(self, claim: Json, goal: Json) -> tuple[Fraction | None, Fraction | None, int | None]:
        """First and last instant of which the goal speaks, and the number of jumps (S24: with a time, no limit)."""
        scope = self.plain
        first, last = (goal["window"] or [None, None])[0], [claim["horizon"]["time"], goal["within"]]
        ends = [scope.value(scope.root.flat(e), ()) for e in [*last, *(goal["window"] or [])[1:]] if e is not None]
        after = None if first is None else scope.value(scope.root.flat(first), ())
        limit = min(ends) if ends else None
        jumps = claim["horizon"]["jumps"] if limit is None else None
        if (limit is not None and limit < max(0, after or 0)) or (jumps or 0) < 0:
            raise Refused("the claim speaks of no instant")
        return after, limit, jumps

    def _all(self, claim: Json, goal: Json, listed: Listed) -> None:
        """The claim holds in every listed state, and at every landing if it speaks of jumps."""
        after, limit, jumps = self._limits(claim, goal)
        if listed.time is not None and (limit is None or listed.time < limit):
            raise Refused("the states end before the claim's horizon")
        if listed.jumps is not None and (jumps is None or listed.jumps < jumps):
            raise Refused("the states end before the claim's last jump")
        net = listed.network
        wanted = net.root.flat(goal["condition"])
        wanted = ["not", wanted] if goal["kind"] == "can_reach" else wanted
        listed.symmetry.keeps(wanted)
        moments = [
            [op, [TIME], str(q)] for op, q in (("<", after), (">", limit)) if q is not None and TIME in net.clocks
        ]
        wanted = ["or", *moments, wanted]
        words = {n[0] for n in nodes(wanted)}
        if TIME in words and (TIME not in net.clocks or any(net.is_terminal(s) for s, _, _ in listed.states)):
            raise Beyond("the time in a claim, which the states do not track, or in a terminal mode")
        plain = ((s, z, None) for s, z, _ in listed.states)
        for s, z, event in listed.instants() if words & {"jump", "jumped", "pre"} else plain:
            if net.space.cut(z, both([listed.limit, net.truth(wanted, s, event, no=True)])):
                raise Refused(f"a state does not satisfy the claim: {', '.join(map(str, s))[:150]}")

    def _one(self, claim: Json, goal: Json, entry: Json) -> None:
        """A run that violates the claim, or reaches what it asks for, within its horizon."""
        after, limit, jumps = self._limits(claim, goal)
        walk = Walk(Network(self.core, self.system, entry["scale"], True), entry["run"])
        if (after is not None and walk.time < after) or (limit is not None and walk.time > limit):
            raise Refused("a run ends at an instant of which the claim does not speak")
        made = len(entry["run"]["steps"])
        if jumps is not None and (made, made > 0 and number(entry["run"]["last"]) > 0) > (jumps, False):
            raise Refused("a run makes more jumps than the claim speaks of")
        net = walk.network
        met = net.truth(net.root.flat(goal["condition"]), walk.state, walk.event, no=goal["kind"] == "always")
        if not net.space.cut(walk.zone, met):
            raise Refused("a run does not show at its end what it should")


class Walk:
    """A run, walked with exact numbers; `state`, `zone` (a point), `time`, `event` are those of its last instant."""

    def __init__(self, network: Network, run: Json) -> None:
        self.network, self.time = network, Fraction(0)
        self.event: Event | None = None
        self.state, self.zone = self._start(run["start"])
        for step in run["steps"]:
            self._dwell(number(step["dwell"]))
            self._jump(step)
        self._dwell(number(run["last"]))

    def _start(self, start: Json) -> tuple[State, Zone]:
        net = self.network
        if set(start["modes"]) != {a.prefix[:-1] for a in net.automata} or set(start["values"]) != set(net.types):
            raise Refused("a start does not give each part a mode and each variable a value")
        given = {
            **{p + ".": m for p, m in start["modes"].items()},
            **{v: number(q) for v, q in start["values"].items()},
        }
        s = tuple(given[n] for n in net.slots)
        point = both(self._exactly(n, given.get(n, Fraction(0))) for n in net.clocks)
        zones = [q for t, z in net.starts() if t == s for q in net.space.cut(z, point)]
        if not zones:
            raise Refused("a run does not start in an admissible state")
        return s, self._in_range(s, zones[0])

    def _exactly(self, clock: str, q: Fraction) -> Formula:
        i, c = self.network.clocks[clock], self.network.clock_value(clock, q)
        return both([(i, 0, 2 * c + 1), (0, i, 1 - 2 * c)])

    def _in_range(self, s: State, z: Zone) -> Zone:
        if not self.network.space.cut(z, self.network.window(s)):
            raise Refused("a run leaves the declared range of a variable")
        return z

    def _dwell(self, d: Fraction) -> None:
        if d < 0:
            raise Refused("a run dwells for a negative time")
        self.time += d
        if not d:
            return
        self.event = None
        now = self._exactly(TIME, self.time)
        found = [
            q
            for z in [q for _, q in self.network.dwells(self.state, self.zone)]
            for q in self.network.space.cut(z, now)
        ]
        if not found:
            raise Refused(f"a run dwells where no time can pass, or too long (until {str(self.time)[:40]} s)")
        self.zone = self._in_range(self.state, found[0])

    def _jump(self, step: Json) -> None:
        net, chosen = self.network, {v: number(q) for v, q in step["values"].items()}
        if not set(chosen) <= set(net.types):
            raise Refused("a run chooses a value for no variable")
        wanted = both(self._exactly(v, q) for v, q in chosen.items() if v in net.clocks)
        kept = [(net.slots[v], q) for v, q in chosen.items() if v in net.slots]
        found = [(m, s, q) for m, s, z in net.landings(self.state, self.zone)
                 if list(m.event.names) == step["names"] and all(s[i] == q for i, q in kept)
                 for q in net.space.cut(z, wanted)]  # fmt: skip
        if len({(s, z) for _, s, z in found}) != 1 or not _is_point(found[0][2], net.space.n):
            raise Refused(f"a run takes {str(step['names'])[:80]} where it is not enabled, or leaves a value open")
        move, self.state, zone = found[0]
        self.event, self.zone = move.event, self._in_range(self.state, zone)


def _is_point(z: Zone, n: int) -> bool:
    return all(z[i * n + j] + z[j * n + i] == 2 for i in range(n) for j in range(n))


def shown(claim: Json, certificate: Json, check: SystemCheck) -> tuple[str, str | None, list[tuple[str, str, str]]]:
    """The verdict and the verdicts of the goals that a certificate establishes."""
    given = certificate["goals"]
    if (
        not isinstance(given, list)
        or len(given) != len(claim["goals"])
        or not given
        or certificate["rounding"] is not None
    ):
        raise Refused("its certificate does not have one entry for each goal")
    found = [check.verdict(claim, goal, entry) for goal, entry in zip(claim["goals"], given, strict=True)]
    verdict = "refuted" if "refuted" in found else "proved" if set(found) == {"proved"} else None
    if verdict is None or verdict != certificate["verdict"]:
        raise Refused(f"its certificate does not establish the verdict {certificate['verdict']!a}")
    return verdict, None, [("", "", v) for v in found]
