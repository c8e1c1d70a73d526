"""What a claim comes to, derived from the core alone, and whether its certificate shows it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from hacheck import bernstein
from hacheck.cells import START, Cell, Cells, Model
from hacheck.core import Core
from hacheck.expressions import EVENTS, Instant, nodes, well_formed
from hacheck.formula import Formula, conj, disj, placed
from hacheck.goals import Part, conjuncts, parts, pushed
from hacheck.polynomial import constant
from hacheck.rational import Beyond, Interval, Refused
from hacheck.replay import Walk
from hacheck.scope import Scope

Json = Any
Shown = tuple[str | None, list[tuple[str, str, str]]]  # a verdict, and (where, output, verdict) of each part
_CANONICAL = json.JSONEncoder(sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def canonical_hash(value: Json) -> str:
    """SHA-256 of the canonical JSON of a value."""
    return hashlib.sha256(_CANONICAL.encode(value).encode("utf-8", "surrogatepass")).hexdigest()


def mentioned(core: Core, value: Json, hidden: set[str]) -> list[Json]:
    """The top-level constants that a value mentions, transitively, in the order of the core."""
    found: set[str] = set()
    new = {n[1] for n in nodes(value) if n[0] == "const" and len(n) == 2 and isinstance(n[1], str)} - hidden
    while new:
        found |= new
        values = [core.constants[n]["value"] for n in new if n in core.constants]
        new = {n[1] for n in nodes(values) if n[0] == "const" and len(n) == 2 and isinstance(n[1], str)} - found
    return [core.constants[n] for n in sorted(found & core.order.keys(), key=core.order.__getitem__)]


class Setting:
    """An automaton under one reading of its constants, with what several claims share."""

    def __init__(
        self, core: Core, automaton: Json, rounding: bool, load: Callable[[str], Json],
        lemma: Callable[[str], Json] | None = None,
    ) -> None:  # fmt: skip
        self.core, self.a, self.load, self.lemma = core, automaton, load, lemma
        shared = {key: core.data[key] for key in ("params", "enums", "assumptions")}
        well_formed([automaton, core.data["constants"], shared], False)
        self.model = Model(Scope(core, automaton, rounding))
        seen = mentioned(core, automaton, {c["name"] for c in automaton["constants"]})
        self.hash = canonical_hash({"automaton": automaton, "constants": seen, **shared})
        self._cells: dict[str, Cells] = {}
        self.records: dict[str, Any] = {}  # recorded flows by what they say
        self._starts: set[str] = set()

    def cells(self, name: str) -> Cells:
        """A file of cells, checked for completeness once."""
        if name not in self._cells:
            self._cells[name] = Cells(self.model, self.load(name))
        return self._cells[name]

    def start(self, start: Json, assume: list[Json]) -> None:
        """A start is admissible and satisfies what is assumed: nothing is proved of nothing."""
        key = repr((start, assume))
        if key not in self._starts:
            Walk(self.model, {**start, "steps": [], "last": "0"}, assume)
            self._starts.add(key)


class Question:
    """One goal of a claim: its condition, horizon and assumptions, taken from the core."""

    def __init__(self, setting: Setting, claim: Json, goal: Json) -> None:
        self.setting, self.claim, self.goal, self.model = setting, claim, goal, setting.model
        self.scope, self.condition = setting.model.scope, goal["condition"]
        self.assume = [*setting.core.data["assumptions"], *claim["assume"]]
        about = {"goal": goal, "horizon": claim["horizon"], "assume": claim["assume"]}
        well_formed([claim["assume"], claim["horizon"], goal["window"], goal["within"]], False)
        well_formed(goal["condition"], True)
        seen = mentioned(setting.core, about, set())
        if any(c["name"] in self.scope.hidden for c in seen):
            raise Beyond("a constant of the claim that the automaton has too")
        self.about, self.hash = about, canonical_hash({**about, "constants": seen})
        window = goal["window"] or []
        if len(window) not in (0, 2):
            raise Refused("a window has not two ends")
        self.after = self._time(window[0]) if window else None
        self.limits = [self._time(e) for e in (claim["horizon"]["time"], goal["within"]) if e is not None]
        ends = [*self.limits, *map(self._time, window[1:]), *self._over()]
        self.limit = min(ends) if ends else None
        self.jumps = claim["horizon"]["jumps"]
        if (self.limit is not None and self.limit < max(0, self.after or 0)) or (self.jumps or 0) < 0:
            raise Refused("the claim speaks of no instant")

    def ends(self, window: list[Json]) -> list[Fraction]:
        """The two ends of a window."""
        found = [self._time(e) for e in window]
        if not 0 <= found[0] <= found[1]:
            raise Refused("a window holds no instant, or one before the start")
        return found

    def _time(self, e: Json) -> Fraction:
        q = constant(self.scope.base.poly(e))
        if q is None:
            raise Beyond("a time that is no rational")
        return q

    def _over(self) -> list[Fraction]:
        """A time after which the goal is true by its shape, if there is one."""
        shape = self.condition if self.goal["kind"] == "always" else ["not", self.condition]
        if self.goal["kind"] not in ("always", "can_reach"):
            return []
        ends = [self._true_after(c) for c in conjuncts(pushed(shape))]
        return [max(e for e in ends if e is not None)] if ends and None not in ends else []

    def _true_after(self, e: Json, true: bool = True) -> Fraction | None:
        """A time after which a condition is true (or false) by its shape: it asks for something up to then only."""
        op, args = (e[0], e[1:]) if isinstance(e, list) and e else (None, [])
        if op == "not" and len(args) == 1:
            return self._true_after(args[0], not true)
        if op == (("implies") if true else "and"):
            flips = [not true, true] if true else [False] * len(args)
            found = [q for a, how in zip(args, flips, strict=True) if (q := self._true_after(a, how)) is not None]
            return min(found, default=None)
        if true or op not in ("<", "<=", ">", ">=") or len(args) != 2:
            return None
        clock, bound = args if op in ("<", "<=") else args[::-1]
        try:
            return self._time(bound) if clock == ["time"] else None
        except Beyond:
            return None

    def _timed(self, modes: list[Json]) -> bool:
        """May the condition, in one of these modes, read the time?"""
        return any(n[0] == "time" for n in nodes([self.condition, self.setting.a["lets"], modes]))

    def same(self, given: Json, kind: str, where: str, output: str, goal: str = "") -> None:
        """The hash of an obligation is the one derived from the core."""
        mine = canonical_hash(["haverify.obligation/1", self.setting.hash, goal or self.hash, kind, where, output])
        if given.get("hash") != mine:
            raise Refused(f"the {kind} {where} {output} has another hash than the obligation derived from the core")

    def verdict(self, entry: Json) -> Shown:
        """What a goal entry of a certificate establishes, and the verdict of each part; Refused where it does not."""
        if entry == {}:
            return None, []
        kind, aim = entry["kind"], self.goal["kind"]
        if self.setting.a["inputs"] and kind not in ("invariant", "start"):
            raise Beyond("automata with inputs")
        if kind == "cells" and aim in ("always", "can_reach"):
            return self._cells(entry, aim == "always")
        if kind in ("invariant", "start"):
            from hacheck.invariants import shown

            return shown(self, entry)
        if kind == "unmet" and aim == "reach":
            from hacheck.unmet import shown_unmet

            return shown_unmet(self, entry)
        if kind == "inevitable" and aim == "reach":
            self.same(entry, "goal", "", "")
            self._inevitable(entry)
            return "proved", [("", "", "proved")]
        if kind == "run" and aim in ("reach", "can_reach"):
            self.same(entry, "goal", "", "")
            walk = Walk(self.model, entry["run"], self.assume)
            verdict = self._missed(walk) if aim == "reach" else self._met(walk)
            return verdict, [("", "", verdict)]
        if kind == "signals" and aim in ("stl", "can_always"):
            from hacheck.signals import established as over_time

            self.same(entry, "goal", "", "")
            verdict = over_time(self, entry)
            return verdict, [("", "", verdict)]
        if kind == "flowpipe" and self.claim["inductive"]:
            raise Beyond("flowpipes do not show that an invariant is inductive")
        if kind in ("flowpipe", "flow_run") and aim in ("always", "can_reach", "reach", "stl"):
            from hacheck.along import shown_along

            return shown_along(self, entry)
        if kind == aim == "cycle":
            from hacheck.orbits import shown_orbit

            return shown_orbit(self, entry)
        raise Beyond(f"a goal `{aim!s:.20}` shown in this way")

    def _cells(self, entry: Json, positive: bool) -> Shown:
        given, found = list(entry["parts"]), []
        for part in parts(self.setting.a, self.condition if positive else ["not", self.condition]):
            if given and tuple(given[0][k] for k in ("kind", "where", "output")) == part[:3]:
                found.append((part.where, part.output, self._part(entry, part, given.pop(0))))
            elif self._claimed(part) is not True:
                raise Refused(f"other parts are to be shown, the certificate has another number or order: {part[:3]}")
        if given:
            raise Refused("fewer parts are to be shown, the certificate has another number")
        verdicts = {v for _, _, v in found}
        if "proved" in verdicts or not found:
            self.setting.start(entry["start"], self.assume)
        if "refuted" in verdicts and not positive:
            raise Refused("a run beside the proof that there is none")
        if verdicts <= {"proved"}:
            return ("proved" if positive else "refuted"), found
        return ("refuted" if "refuted" in verdicts else None), found

    def _part(self, entry: Json, part: Part, given: Json) -> str:
        self.same(given, *part[:3])
        if "proof" in given and "run" in given:
            raise Refused("a part with a proof and a run")
        if "proof" in given:
            if self.claim["inductive"]:
                raise Beyond("proofs that an invariant is inductive")
            self._prove(self.setting.cells(entry["cells"]), part, given["proof"])
            return "proved"
        if "run" not in given:
            return "unknown"
        walk = Walk(self.model, given["run"], self.assume)
        if (walk.edge if part.kind == "jump" else walk.mode) != part.place:
            raise Refused("a run ends elsewhere than its part says")
        self._in_time(walk)
        wrong = disj(walk.last.at.formula(c, True) for c in part.conjuncts)
        if not (walk.stuck() if part.kind == "stuck" else walk.finally_(wrong)):
            raise Refused("a run does not violate the claim at its end")
        return "refuted"

    def _claimed(self, part: Part) -> Formula:
        """What a part claims of an instant."""
        if part.kind == "stuck":
            return self.model.lively(part.place)
        at = self.scope.identity(part.place) if part.kind == "dwell" else self.model.landing(part.place)
        return conj(at.formula(c) for c in part.conjuncts)

    def _excuse(self, cells: Cells, at: Instant) -> Formula:
        """Nothing is claimed: an assumption fails, or it is too early or too late (S20)."""
        early = not self.scope.modes[str(at.mode)]["terminal"] and cells.late(self.after, "<")
        return disj([*(at.formula(a, True) for a in self.assume), cells.late(self.limit), early])

    def _prove(self, cells: Cells, part: Part, proof: list[Json]) -> None:
        """One tree for each cell of the mode; for edges null where the edge is not taken from the cell."""
        if cells.time is not None and (self.limit is None or cells.time < self.limit):
            raise Refused("the cells end before the claim's horizon")
        if cells.jumps is not None and (self.limit is not None or self.jumps is None or cells.jumps < self.jumps):
            raise Refused("the cells end before the claim's last jump")
        jump = part.kind == "jump"
        mode = self.model.edges[part.place]["source"] if jump else part.place
        at = self.model.landing(part.place) if jump else self.scope.identity(mode)
        claimed = self._claimed(part)
        if self.scope.modes[str(at.mode)]["terminal"] and self._timed(self.scope.modes[str(at.mode)]["lets"]):
            raise Beyond("time in a claim about a terminal mode")
        mine = [cells.cells[i] for i in cells.by_mode[mode]]
        if part.kind == "stuck":
            excuse = self._excuse(cells, at)
            for c in mine:
                self._show(c, disj([self.model.outside(mode), cells.past(c), excuse, claimed]), c.stay)
            return
        if len(proof) != len(mine):
            raise Refused(f"the part {part.where} {part.output} concerns {len(mine)} cells, its proof another number")
        for tree, c in zip(proof, mine, strict=True):
            if jump and cells.jumps is not None and c.jumps == cells.jumps:
                continue
            crossed = cells.crossing(c, part.place) if jump else {}
            needless = crossed is None and tree is None
            if not needless and not self._plainly(tree, c, claimed, crossed):
                gone = cells.untaken(c, part.place) if jump else disj([self.model.outside(mode), cells.past(c)])
                self._tree(tree, c, claimed, disj([gone, self._excuse(cells, at)]))

    def _plainly(self, tree: Json, c: Cell, claimed: Formula, crossed: bernstein.Box | None) -> bool:
        """Is the claim shown without looking at excuses (on where an edge crosses), as it often is?"""
        try:
            self._tree(tree, c, claimed, False, crossed=crossed)
        except Refused:
            return False
        return True

    def _tree(self, tree: Json, c: Cell, f: Formula, excuse: Formula, stay: Interval | None = None,
              crossed: bernstein.Box | None = None) -> None:  # fmt: skip
        env, box, _ = c.place(stay or c.stay)
        wide = crossed or {**self.scope.chosen, **box}
        bernstein.replay("b" if tree is None else tree, placed(f, env), wide, placed(excuse, env))

    def _show(self, c: Cell, f: Formula, stay: Any) -> None:
        if not c.shows(f, stay):
            raise Refused(f"what is claimed does not hold in a cell of mode {c.mode}")

    def _inevitable(self, entry: Json) -> None:
        """Each cell meets the goal in time, or every run leaves it for cells further on."""
        if self.limit is None or (self.goal["within"] is None and self.jumps is not None) or self.after is not None:
            raise Beyond("a `reach` without a time limit")
        self.setting.start(entry["start"], self.assume)

        def goal(at: Instant) -> Formula:
            met = at.formula(["and", self.condition, ["<=", ["time"], str(self.limit)]])
            return disj([met, *(at.formula(a, True) for a in self.assume)])

        cells = Cells(self.model, self.setting.load(entry["cells"]), lambda k: goal(self.model.landing(k)))
        if not cells.timed:
            raise Refused("the cells do not track time")
        for c in cells.cells:
            gone, terminal = disj([self.model.outside(c.mode), cells.past(c)]), self.scope.modes[c.mode]["terminal"]
            if c.meet is None:
                if terminal or c.stay[1] is None:
                    raise Refused(f"a run need not leave a cell of mode {c.mode}")
                self._show(c, disj([gone, self.model.lively(c.mode)]), c.stay)
                continue
            if terminal and c.meet > 0:
                raise Refused(f"a run may end in the terminal mode {c.mode} before it meets the goal")
            if any(n[0] in EVENTS for n in nodes(self.condition)):
                raise Beyond("a goal about a jump, met during a dwell")
            self._show(c, goal(self.scope.identity(c.mode)), (c.meet, c.meet))
            self._show(c, self.model.domain(c.mode), (START, c.meet))

    def _in_time(self, walk: Walk) -> None:
        if (self.limit is not None and walk.time > self.limit) or (self.after is not None and walk.time < self.after):
            raise Refused("a run ends at an instant that the claim does not speak of")
        late = self.jumps is not None and (walk.jumps, walk.edge is None and walk.jumps > 0) > (self.jumps, False)
        if late and self.limit is None:  # beside a time, K jumps only limit the analysis (S24)
            raise Refused("a run makes more jumps than the claim speaks of")

    def _met(self, walk: Walk) -> str:
        self._in_time(walk)
        stuck = self.condition == ["stuck"]
        if not (walk.stuck() if stuck else walk.finally_(walk.last.at.formula(self.condition))):
            raise Refused("a run does not meet the goal at its end")
        return "proved"

    def _missed(self, walk: Walk) -> str:
        """The goal is never met up to the bound, and the run goes beyond it or ends."""
        if (self.limit is None and self.jumps is not None) or self.after is not None:
            raise Beyond("a `reach` bounded by jumps")
        limit = max(self.limits) if self.limits else None
        for at, state, dwell, time in walk.stages:
            upto = dwell if limit is None else min(dwell, limit - time)
            if upto >= 0 and not walk.surely(placed(at.formula(self.condition, True), state), upto):
                raise Refused("a run that should miss the goal may meet it")
        ended = self.scope.modes[walk.mode]["terminal"] and not self._timed([self.setting.a["modes"], self.assume])
        if not ((limit is not None and walk.time > limit) or ended or walk.stuck()):
            raise Refused("a run stops before the goal's time is over")
        return "refuted"


def established(core: Core, claim: Json, certificate: Json, settings: Callable[[Json, bool], Setting],
                systems: Callable[[Json], Any] | None = None,
                ) -> tuple[str, str | None, list[tuple[str, str, str]]]:  # fmt: skip
    """The verdict, the verdict within rounding, and the parts that a certificate establishes."""
    said = certificate["schema"], certificate["claim"], certificate["verdict"] in ("proved", "refuted")
    if said != ("haverify.certificate/1", claim["name"], True):
        raise Refused("its certificate has another schema, is about another claim or has no verdict")
    if all(g["kind"] == "holds" for g in claim["goals"]):
        from hacheck.holds import held

        return held(core, claim, certificate)
    if claim["on"] in core.systems and systems is not None:
        from hacheck.systems import shown

        check = systems(core.systems[claim["on"]])
        if certificate.get("whole", False) is not False:
            verdict, found = goals_shown(*check.whole(claim, certificate))
            return verdict, None, found
        return shown(claim, certificate, check)
    if claim["on"] not in core.automata:
        raise Beyond("claims about systems, rules and formulas")
    automaton = core.automata[claim["on"]]
    if claim["which"]:
        from hacheck.boxes import shown_by_boxes

        return shown_by_boxes(claim, certificate, settings(automaton, False))
    verdict, found = goals_shown(claim, certificate, settings(automaton, False))
    rounding = certificate["rounding"]
    return verdict, None if rounding is None else goals_shown(claim, rounding, settings(automaton, True))[0], found


def goals_shown(claim: Json, certificate: Json, setting: Setting) -> tuple[str, list[tuple[str, str, str]]]:
    """The verdict and the parts that one entry for each goal establishes."""
    given, wanted = certificate.get("goals"), certificate.get("verdict")
    if not isinstance(given, list) or len(given) != len(claim["goals"]) or not given:
        raise Refused("its certificate does not have one entry for each goal")
    found: list[tuple[str, str, str]] = []
    verdicts: list[str | None] = []
    for goal, entry in zip(claim["goals"], given, strict=True):
        if entry == {}:  # what is left open may speak of no instant at all
            verdicts.append(None)
            continue
        v, listed = Question(setting, claim, goal).verdict(entry)
        verdicts.append(v)
        found += listed
    shown = "refuted" if "refuted" in verdicts else "proved" if all(v == "proved" for v in verdicts) else None
    if shown is None or shown != wanted:
        raise Refused(f"its certificate does not establish the verdict {wanted!a}")
    return shown, found
