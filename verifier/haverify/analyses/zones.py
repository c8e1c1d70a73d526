"""Claims about systems: `always`, `never`, `can reach` (and `stuck` in them), by exploring their states.

For systems whose parts have discrete variables and clocks that never stop: one constant rate in all modes, compared
with numbers or with each other. The states are those of the parts together with a zone of clock values (bounds on
clocks and their differences), explored breadth first; beyond the last number a clock is compared with, its value is
forgotten; members of a family of parts that can trade places are not told apart. `proved` rests on a list of states
that no run leaves, `refuted` on the run with the fewest jumps. A horizon adds a clock for the time where it decides.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import lcm
from typing import Any

from haverify.analyses.networks.bounds import Bounds
from haverify.analyses.networks.concrete import Stage, concrete_run
from haverify.analyses.networks.explore import Exploration, Node
from haverify.analyses.networks.network import Network, mentioned
from haverify.analyses.networks.starts import starts
from haverify.analyses.networks.symmetry import symmetry_of
from haverify.analyses.networks.terms import TIME, ScaleError, State
from haverify.analyses.networks.zones import Effort, SpentError, Zone, conjunction, negation
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.network_run import NetworkRun
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.maths.digits import rational_text
from haverify.maths.exact import people_text
from haverify.model.claim import Claim
from haverify.model.core import canonical
from haverify.obligations.obligation import digest
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder

Json = Any
METHOD = "zones"
MODEL = ("systems", "automata", "constants", "params", "enums", "assumptions")
FINEST = 1 << 36  # units of time in a second
MANY = 40  # interactions listed
STEPS = 8_000_000  # for the usual budget
EVENTS = frozenset({"jump", "jumped", "pre"})


@holder
class Found:
    """What came out for one goal; `run` decides it where it is refuted (`can reach`: proved)."""

    verdict: Verdict
    entry: Json = field(default_factory=dict)
    files: dict[str, Json] = field(default_factory=dict)
    run: NetworkRun | None = None
    notes: tuple[str, ...] = ()


@holder
class Systems:
    """The explorations of a core's systems, which claims share."""

    core: Mapping[str, Json]
    made: dict[Any, Exploration] = field(default_factory=dict)
    files: dict[int, tuple[str, Json]] = field(default_factory=dict)
    scales: dict[str, int] = field(default_factory=dict)
    reached: int = 0  # states of the largest exploration that was given up

    def exploration(self, q: Question, limit: Fraction | None, effort: Effort, is_exact: bool) -> Exploration:
        """The exploration for a question, up to a time."""
        scale = self.scales.get(q.system["name"], 1)
        network = Network(self.core, q.system, scale, limit is not None, effort)
        wanted = network.root.flat(q.wanted)
        symmetry = symmetry_of(network, [wanted])
        compared = (wanted,) if mentioned(wanted) & set(network.clocks) or q.speaks_of(wanted, {TIME}) else ()
        both_ways = q.speaks_of(wanted, {"stuck"})
        key = (q.system["name"], limit, q.jumps, scale, repr(compared), both_ways, is_exact, symmetry.groups)
        if key not in self.made:
            end = True if limit is None else network.terms.clock_bounds(TIME, None, limit)
            claims = (*compared, *([] if limit is None else [["<=", [TIME], rational_text(limit)]]))
            self.made[key] = Exploration(network, symmetry, Bounds(network, claims, both_ways, is_exact), end, q.jumps)
        self.made[key].use(effort)
        return self.made[key]

    def drop(self, x: Exploration) -> None:
        """Forget an exploration that stopped in the middle of a step."""
        self.made = {k: v for k, v in self.made.items() if v is not x}
        self.reached = max(self.reached, len(x.nodes))

    def refine(self, q: Question, factor: int) -> None:
        """Count time in a finer unit from now on."""
        name = q.system["name"]
        self.scales[name] = self.scales.get(name, 1) * factor
        if self.scales[name] > FINEST:
            raise OutsideFragmentError("times of denominators too different to be counted in one unit")

    def file(self, x: Exploration) -> tuple[str, Json]:
        """The states of an exploration that is complete, as certificates have them, under a name of their own."""
        if id(x) not in self.files:
            value = states_json(x)
            name = f"{x.network.system['name']}-{hashlib.sha256(canonical(value)).hexdigest()[:12]}"
            self.files[id(x)] = name, value
        return self.files[id(x)]


_LAST: list[Systems] = []


def systems_of(core: Mapping[str, Json]) -> Systems:
    """The explorations of a core; those of the core asked for last are kept."""
    if not _LAST or _LAST[0].core is not core:
        _LAST[:] = [Systems(core)]
    return _LAST[0]


@holder
class Question:
    """One goal as a condition that is to hold always; `after`, `limit`, `jumps`: the instants it speaks of."""

    core: Mapping[str, Json]
    claim: Json
    goal: Json

    def __post_init__(self) -> None:
        self.system = next(s for s in self.core["systems"] if s["name"] == self.claim["on"])
        self.is_reach = self.goal["kind"] == "can_reach"
        plain = Network(self.core, self.system, 1, False, Effort(STEPS))
        window = self.goal["window"] or [None, None]
        ends = [self.claim["horizon"]["time"], self.goal["within"], window[1]]
        values = [plain.terms.number(plain.root.flat(e), ()) for e in ends if e is not None]
        self.limit = min(values, default=None)
        self.after = None if window[0] is None else plain.terms.number(plain.root.flat(window[0]), ())
        self.jumps = self.claim["horizon"]["jumps"] if self.limit is None else None
        condition = ["not", self.goal["condition"]] if self.is_reach else self.goal["condition"]
        early = [] if self.after is None else [["<", [TIME], rational_text(self.after)]]
        self.wanted = ["or", *early, condition] if early else condition
        self.needs_time = self.speaks_of(plain.root.flat(self.wanted), {TIME}) or _tells_time(plain)
        if self.limit is not None and self.limit < max(0, self.after or 0):
            raise OutsideFragmentError("the window of the claim has no instant")

    def speaks_of(self, e: Json, words: set[str] | frozenset[str]) -> bool:
        """Does an expression use one of some operators?"""
        return isinstance(e, list) and (e[0] in words or any(self.speaks_of(x, words) for x in e[1:]))

    def hash(self) -> str:
        """The hash of the obligation (docs/core.md section 7)."""
        said = [self.goal, self.claim["horizon"], self.claim["assume"], self.claim["on"]]
        return digest(["haverify.obligation/1", {k: self.core[k] for k in MODEL}, *said])


def _tells_time(network: Network) -> bool:
    """Does the system itself read `time`?"""
    text = repr([p.model for p in network.places])
    return repr([TIME]) in text


def decide_network(claim: Claim, core: Mapping[str, Json], share: Fraction) -> Evidence:
    """What an exploration finds out about a claim on a system; `share` scales the work, 1 being usual."""
    if claim.method is not None and claim.method[0] != METHOD:
        text = f"`method {claim.method[0]}` does not decide systems; without it `{METHOD}` is used"
        return Evidence(Unknown("fragment", text), (), METHOD)
    data = next(c for c in core["claims"] if c["name"] == claim.name)
    effort = Effort(int(STEPS * share))
    found = [_goal(systems_of(core), data, goal, effort) for goal in data["goals"]]
    verdict = _combined(claim, found)
    notes = tuple(dict.fromkeys(n for f in found for n in f.notes))
    parts = tuple(PartResult(k, "system", "", "", "", f.verdict, facts=_told(f)) for k, f in enumerate(found))
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, notes=notes)
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    runs = [f.run for f in found if f.run is not None and isinstance(f.verdict, type(verdict))]
    files = {k: v for f in found for k, v in f.files.items()}
    shown = certificate(claim.name, word, [f.entry for f in found], None)
    return Evidence(verdict, parts, METHOD, shown, files, notes=notes, trace=min(runs, key=_length, default=None))


def _told(found: Found) -> tuple[str, ...]:
    """A run in a line or two: where it ends, and what fires when."""
    run = found.run
    if run is None:
        return ("no state that is reached meets it",) if isinstance(found.verdict, Refuted) else ()
    time, fired = Fraction(0), []
    for m in run.moments:
        fired += [f"{m.names[0]} at {people_text(time, 10)} s"] if m.names else []
        time += m.dwell
    where = ", ".join(f"{part}.{mode}" for part, mode in run.moments[-1].modes)
    jumps = f"{len(fired)} jump{'s' * (len(fired) != 1)}"
    listed = ", ".join(fired[:MANY]) + (", ..." if len(fired) > MANY else "")
    return (f"after {jumps} at {people_text(time, 10)} s in {where}", *([f"by {listed}"] if fired else []))


def _length(run: NetworkRun) -> int:
    return len(run.moments)


def _combined(claim: Claim, found: list[Found]) -> Verdict:
    """Goals are a conjunction (S26)."""
    for kind in (Refuted, Unknown):
        first = next((f.verdict for f in found if isinstance(f.verdict, kind)), None)
        if first is not None:
            return first
    if claim.inductive:
        text = "true on all runs, but whether it is inductive (LANGUAGE S22) is not decided for systems"
        return Unknown("fragment", text, next_step="leave out `inductive`")
    return Proved()


def _goal(systems: Systems, claim: Json, goal: Json, effort: Effort) -> Found:
    if claim["assume"] or systems.core["assumptions"]:
        return Found(Unknown("fragment", "claims about systems are decided without assumptions in this version"))
    if goal["kind"] not in ("always", "can_reach"):
        word = goal["kind"].replace("_", " ")
        return Found(
            Unknown("fragment", f"`{word}` about a system is not in this version; `always`, `never`, `can reach` are")
        )
    try:
        return _decided(systems, Question(systems.core, claim, goal), effort)
    except OutsideFragmentError as e:
        return Found(Unknown("fragment", str(e)))
    except SpentError:
        step = "a larger `--budget`, fewer parts, or a shorter horizon"
        return Found(
            Unknown(
                "budget",
                "the system has more states than were explored",
                f"{systems.reached} symbolic states",
                "",
                step,
            )
        )
    except RecursionError:
        return Found(Unknown("fragment", "an expression is nested too deeply"))


def _decided(systems: Systems, q: Question, effort: Effort) -> Found:
    """First without a clock for the time, which is enough for most; then with it, if only the horizon can decide."""
    if q.limit is not None and not q.needs_time:
        try:
            found = _explored(systems, q, None, Effort(effort.left // 3))
        except (OutsideFragmentError, SpentError):
            found = Found(Unknown("fragment", ""))
        is_early = found.run is None or _duration(found.run) <= q.limit
        if is_early and not isinstance(found.verdict, Unknown):
            return found
    return _explored(systems, q, q.limit, effort)


def _duration(run: NetworkRun) -> Fraction:
    return sum((m.dwell for m in run.moments), Fraction(0))


def _explored(systems: Systems, q: Question, limit: Fraction | None, effort: Effort) -> Found:
    """What an exploration shows; where its rounded zones mislead (differences of clocks), one with exact zones."""
    found = _refined(systems, q, limit, effort, False)
    if not isinstance(found.verdict, Unknown) or found.verdict.kind != "abstraction":
        return found
    try:
        return _refined(systems, q, limit, Effort(effort.left // 4), True)
    except SpentError:
        return found


def _refined(systems: Systems, q: Question, limit: Fraction | None, effort: Effort, is_exact: bool) -> Found:
    """The same in a unit of time of which all bounds are multiples."""
    while True:
        try:
            x = systems.exploration(q, limit, effort, is_exact)
        except ScaleError as e:
            systems.refine(q, e.factor)
            continue
        try:
            return _searched(systems, q, x)
        except ScaleError as e:
            systems.drop(x)
            systems.refine(q, e.factor)
        except (OutsideFragmentError, SpentError):
            systems.drop(x)
            raise


def _searched(systems: Systems, q: Question, x: Exploration) -> Found:
    net = x.network
    wanted = net.root.flat(q.wanted)
    has_events = q.speaks_of(wanted, EVENTS)
    count = 0
    for node in x.reached():
        count += 1
        if net.space.meet(node.zone, negation(net.window(node.state))):
            return Found(_left(net, node))
        bad = _bad_instants(net, wanted, node, x) if has_events else _bad_states(net, wanted, node)
        for more in bad:
            run = concrete_run(x, [*(n.state for n in x.path(node)), *more], _end(net, wanted, has_events))
            if run is None:
                text = "an exploration with rounded zones finds a violation, but no run shows it"
                return Found(Unknown("abstraction", text))
            made = len(run.moments) - 1
            if q.jumps is not None and (made, made > 0 and run.moments[-1].dwell > 0) > (q.jumps, False):
                text = "the run that shows it goes on after the last jump that the claim speaks of"
                return Found(Unknown("jumps", text))
            return _shown(q, net, run, count)
    if not count:
        return Found(Unknown("vacuous", "the system has no start, so nothing can be claimed of its runs"))
    name, file = systems.file(x)
    entry = {"kind": "states", "states": name, "hash": q.hash()}
    verdict = Refuted() if q.is_reach else Proved()
    return Found(verdict, entry, {name: file}, notes=tuple(_facts(q, x, file)))


def _left(net: Network, node: Node) -> Unknown:
    """A declared range is left (S4)."""
    ends = {n: net.terms.clock_bounds(n, *w) for n, w in net.windows.items() if n in net.clocks}
    names = [n for n, f in ends.items() if net.space.meet(node.zone, negation(f))] or list(net.windows)
    text = f"`{names[0]}` leaves its declared range, and what happens after that is not followed (LANGUAGE S4)"
    return Unknown("window", text, next_step="declare it without a range, or give the claim a horizon")


def _bad_states(net: Network, wanted: Json, node: Node) -> Iterator[list[State]]:
    """An empty continuation where a condition fails somewhere in a state."""
    if net.space.meet(node.zone, net.terms.truth(wanted, node.state, no=True)):
        yield []


def _bad_instants(net: Network, wanted: Json, node: Node, x: Exploration) -> Iterator[list[State]]:
    """Continuations at whose end a condition fails that speaks of jumps: of length 0 from a start, else 1."""
    if node.parent is None:
        for s, z in starts(net):
            bad = conjunction([x.limit, net.terms.truth(wanted, s, no=True)])
            if s == node.state and any(net.space.meet(d.reached, bad) for d in net.dwells(s, z)):
                yield []
    if x.jumps is not None and node.jumps >= x.jumps:
        return
    for m, _, landed in net.jumps(node.state, node.zone):
        assert m.target is not None
        stages = (Stage(m, None, m.target, d) for d in net.dwells(m.target, landed))
        end = _end(net, wanted, True)
        if any(net.space.meet(z, x.limit) for stage in stages for z in end(stage)):
            yield [m.target]


def _end(net: Network, wanted: Json, has_events: bool) -> Any:
    """Where a run may end so as to show that a condition fails: with `has_events`, right after a jump or later."""

    def end(last: Stage) -> Iterator[Zone]:
        s, zones = last.state, [last.dwell.reached]
        if has_events and last.move is not None:
            yield from net.space.meet(last.dwell.landed, net.terms.truth(wanted, s, last.move.event, no=True))
            later = net.space.formula(net.space.strictly_later(last.dwell.landed))
            zones = net.space.meet(zones[0], later) if last.dwell.can_wait else []
        for z in zones:
            yield from net.space.meet(z, net.terms.truth(wanted, s, no=True))

    return end


def _shown(q: Question, net: Network, run: NetworkRun, count: int) -> Found:
    numbers = [m.dwell for m in run.moments]
    numbers += [v / net.rates[n] for m in run.moments for n, v in m.values if n in net.clocks]
    scale = lcm(net.scale, *(x.denominator for x in numbers))
    entry = {"kind": "run", "hash": q.hash(), "scale": scale, "run": run.json()}
    return Found(Proved() if q.is_reach else Refuted(), entry, run=run, notes=(f"found after {count} symbolic states",))


def _facts(q: Question, x: Exploration, file: Json) -> Iterator[str]:
    """What people want to know about a complete exploration."""
    groups = [", ".join(m[0] for m in g.members) for g in x.symmetry.groups]
    alike = f", up to exchanges of {' and of '.join(groups)}" if groups else ""
    yield f"explored completely: {len(file['states'])} symbolic states{alike}"
    if q.speaks_of(q.wanted, {"stuck"}) and x.jumps is None:
        idle = next((n for n in x.kept() if not n.next and not x.network.is_terminal(n.state)), None)
        if idle is not None and x.limit is True:
            where = ", ".join(f"{a.prefix}{idle.state[k]}" for k, a in enumerate(x.network.automata))
            yield f"in {where} nothing can fire any more; time passes there, so it is not stuck (LANGUAGE S12)"


def states_json(x: Exploration) -> Json:
    """The states of a complete exploration, with what covers what follows each of them."""
    heirs = x.heirs()

    def links(found: Mapping[Any, None]) -> list[Json]:
        pairs = dict.fromkeys((orders, heirs[k]) for orders, k in found)
        return [[[list(o) for o in orders], k] for orders, k in pairs]

    net = x.network
    limit = None
    if net.is_timed:
        limit = rational_text(Fraction(x.limit[2] >> 1, net.scale))
    states = []
    for n in x.kept():
        at = [v if isinstance(v, str) else rational_text(v) for v in n.state]
        entry = {"at": at, "zone": [None if b >= 1 << 60 else b for b in n.zone], "next": links(n.next)}
        states.append(entry | ({} if x.jumps is None else {"jumps": n.jumps}))
    return {
        "schema": "haverify.states/1",
        "system": net.system["name"],
        "scale": net.scale,
        "time": limit,
        "jumps": x.jumps,
        "symmetry": [g.json() for g in x.symmetry.groups],
        "starts": links(x.starts),
        "states": states,
    }
