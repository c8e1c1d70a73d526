"""What a claim comes to, derived from the core alone, and whether its certificate shows it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from hacheck import bernstein
from hacheck.cells import Box, Cells, Model
from hacheck.core import Core
from hacheck.expressions import EVENTS, Instant, Scope, nodes, well_formed
from hacheck.formula import NEGATED, Formula, conj, disj, literal, replace
from hacheck.polynomial import Images, Poly, constant, substitute
from hacheck.rational import Beyond, Interval, Refused, spend
from hacheck.replay import Walk
from hacheck.systems import SystemCheck, shown

Json = Any


def canonical_hash(value: Json) -> str:
    """SHA-256 of the canonical JSON of a value."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def mentioned(core: Core, value: Json, hidden: set[str]) -> list[Json]:
    """The top-level constants that a value mentions, transitively, in the order of the core."""
    found: set[str] = set()
    new = {n[1] for n in nodes(value) if n[0] == "const" and len(n) == 2 and isinstance(n[1], str)} - hidden
    while new:
        found |= new
        values = [core.constants[n]["value"] for n in new if n in core.constants]
        new = {n[1] for n in nodes(values) if n[0] == "const" and len(n) == 2 and isinstance(n[1], str)} - found
    return [core.constants[n] for n in sorted(found & core.order.keys(), key=core.order.__getitem__)]


def fold(e: Json, mode: str, edge: Json) -> bool | None:
    """The truth value that `at`, `jump`, `jumped` and truth constants give an expression, if they do."""
    if isinstance(e, bool):
        return e
    op = e[0] if isinstance(e, list) and e else None
    if op == "implies":
        return fold(["or", ["not", e[1]], e[2]], mode, edge)
    if op in ("and", "or"):
        members = [fold(x, mode, edge) for x in e[1:]]
        return (op == "or") if (op == "or") in members else None if None in members else op == "and"
    if op == "not":
        inner = fold(e[1], mode, edge)
        return None if inner is None else not inner
    if op == "at":
        return bool(e[1] == mode)
    if op in ("jump", "jumped"):
        return edge is not None and (op == "jumped" or e[1] == edge["name"])
    if op == "pre":
        return fold(e[1], edge["source"] if edge else mode, None)
    if op == "if":
        a = fold(e[1], mode, edge)
        return None if a is None else fold(e[2 if a else 3], mode, edge)
    return None


def conjuncts(e: Json) -> list[Json]:
    """The members of a conjunction; an implication is distributed over those of its conclusion."""
    if isinstance(e, list) and e and e[0] == "and":
        return [c for x in e[1:] for c in conjuncts(x)]
    if isinstance(e, list) and len(e) == 3 and e[0] == "implies":
        return [["implies", e[1], c] for c in conjuncts(e[2])]
    return [e]


def pushed(e: Json) -> Json:
    """An expression with a negation at its top pushed inwards by one level."""
    is_not = isinstance(e, list) and len(e) == 2 and e[0] == "not"
    inner = e[1] if is_not and isinstance(e[1], list) and e[1] else [None]
    if inner[0] == "or":
        return ["and", *(["not", x] for x in inner[1:])]
    if inner[0] == "not":
        return inner[1]
    if inner[0] == "implies":
        return ["and", inner[1], ["not", inner[2]]]
    return [NEGATED[inner[0]], *inner[1:]] if inner[0] in NEGATED else e


class Part(NamedTuple):
    """One part of an `always` goal; `place` is a mode's name or an edge's index."""

    kind: str
    where: str
    output: str
    place: Any
    conjuncts: tuple[Json, ...]  # those that do not fold to true


def parts(automaton: Json, condition: Json) -> Iterator[Part]:
    """The parts of `always condition`, in their order."""
    if condition == ["not", ["stuck"]]:
        yield from (Part("stuck", m["name"], "", m["name"], ()) for m in automaton["modes"])
        return
    groups: dict[str, list[Json]] = {}
    for c in conjuncts(pushed(condition)):
        seen = [{n[1] for n in nodes(c) if n[0] == kind} for kind in ("let", "var")]
        groups.setdefault(",".join(sorted(seen[0] or seen[1])), []).append(c)
    for m in automaton["modes"]:
        spend(len(groups))
        for output, cs in groups.items():
            left = tuple(c for c in cs if fold(c, m["name"], None) is not True)
            if left:
                yield Part("dwell", m["name"], output, m["name"], left)
    jumpy = {o: cs for o, cs in groups.items() if any(n[0] in EVENTS for n in nodes(cs))}
    ends = [(e["source"], e["target"]) for e in automaton["edges"]] if jumpy else []
    for k, (source, target) in enumerate(ends):
        edge = automaton["edges"][k]
        where = f"{source} -> {target}" + (f" ({edge['name']})" if ends.count((source, target)) > 1 else "")
        for output, cs in jumpy.items():
            left = tuple(c for c in cs if fold(c, target, edge) is not True)
            if left:
                yield Part("jump", where, output, k, left)


class Setting:
    """An automaton under one reading of its constants, with what several claims share."""

    def __init__(self, core: Core, automaton: Json, rounding: bool, load: Callable[[str], Json]) -> None:
        self.core, self.a, self.load = core, automaton, load
        well_formed([automaton, *(core.data[k] for k in ("constants", "params", "assumptions"))], False)
        self.model = Model(Scope(core, automaton, rounding, Scope(core, automaton, rounding)))
        hidden = {c["name"] for c in automaton["constants"]}
        data = core.data
        shared = {key: data[key] for key in ("params", "enums", "assumptions")}
        self.hash = canonical_hash(
            {"automaton": automaton, "constants": mentioned(core, automaton, hidden), **shared})  # fmt: skip
        self.own = hidden & set(core.constants)
        self._cells: dict[str, Cells] = {}
        self._starts: set[str] = set()

    def cells(self, name: Json) -> Cells:
        """A file of cells, checked for completeness once."""
        key = str(name)
        if key not in self._cells:
            self._cells[key] = Cells(self.model, self.load(key))
        return self._cells[key]

    def start(self, start: Json, assume: list[Json]) -> None:
        """A start is admissible and satisfies what is assumed: nothing is proved of nothing."""
        key = canonical_hash([start, assume])
        if key not in self._starts:
            Walk(self.model, {**start, "steps": [], "last": "0"}, assume)
            self._starts.add(key)


class Question:
    """One goal of a claim: its condition, horizon and assumptions, taken from the core."""

    def __init__(self, setting: Setting, claim: Json, goal: Json) -> None:
        self.setting, self.claim, self.goal, self.model = setting, claim, goal, setting.model
        self.assume = [*setting.core.data["assumptions"], *claim["assume"]]
        window = goal["window"] or []
        if len(window) not in (0, 2):
            raise Refused("a window has not two ends")
        self.after = self._time(window[0]) if window else None
        well_formed([claim["assume"], claim["horizon"], goal["window"], goal["within"]], False)
        well_formed(goal["condition"], True)
        limits = [self._time(e) for e in (claim["horizon"]["time"], goal["within"], *window[1:]) if e is not None]
        shape = goal["condition"] if goal["kind"] == "always" else ["not", goal["condition"]]
        ends = (
            [self._true_after(c) for c in conjuncts(pushed(shape))] if goal["kind"] in ("always", "can_reach") else []
        )
        limits += [max(e for e in ends if e is not None)] if ends and None not in ends else []
        self.limit = min(limits) if limits else None
        self.jumps = claim["horizon"]["jumps"]
        if (self.limit is not None and self.limit < max(0, self.after or 0)) or (self.jumps or 0) < 0:
            raise Refused("the claim speaks of no instant")
        about = {"goal": goal, "horizon": claim["horizon"], "assume": claim["assume"]}
        if any(n[0] == "const" and len(n) == 2 and n[1] in setting.own for n in nodes(about)):
            raise Beyond("a constant of the claim that the automaton has too")
        self.hash = canonical_hash({**about, "constants": mentioned(setting.core, about, set())})

    def _time(self, e: Json) -> Fraction:
        q = constant(Instant(self.model.scope, None, {}).poly(e))
        if q is None:
            raise Beyond("a time that is no rational")
        return q

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

    def part_hash(self, kind: str, where: str, output: str) -> str:
        """The hash of a part's obligation."""
        return canonical_hash(["haverify.obligation/1", self.setting.hash, self.hash, kind, where, output])

    def verdict(self, entry: Json) -> tuple[str | None, list[tuple[str, str, str]]]:
        """What a goal entry of a certificate establishes, and the verdict of each part; Refused where it does not."""
        kind = entry.get("kind") if isinstance(entry, dict) else None
        if entry == {}:
            return None, []
        if kind in ("run", "inevitable", "signals") and entry.get("hash") != self.part_hash("goal", "", ""):
            raise Refused("a goal has another hash than the obligation derived from the core")
        if kind == "cells" and self.goal["kind"] in ("always", "can_reach"):
            return self._cells(entry)
        if kind == "inevitable" and self.goal["kind"] == "reach":
            self._inevitable(entry)
            return "proved", [("", "", "proved")]
        if kind == "run" and self.goal["kind"] in ("reach", "can_reach"):
            met = self.goal["kind"] == "can_reach"
            (self._witness if met else self._missed)(entry.get("run"))
            verdict = "proved" if met else "refuted"
            return verdict, [("", "", verdict)]
        if kind == "signals" and self.goal["kind"] in ("stl", "can_always"):
            from hacheck.signals import established as over_time

            verdict = over_time(self, entry)
            return verdict, [("", "", verdict)]
        raise Beyond(f"a goal `{self.goal['kind']}` shown in this way")

    def _cells(self, entry: Json) -> tuple[str | None, list[tuple[str, str, str]]]:
        positive = self.goal["kind"] == "always"
        condition = self.goal["condition"] if positive else ["not", self.goal["condition"]]
        derived, given = list(parts(self.setting.a, condition)), entry.get("parts")
        if not isinstance(given, list) or len(given) != len(derived):
            raise Refused(f"{len(derived)} parts are to be shown, the certificate has another number")
        if not given or any(isinstance(p, dict) and "proof" in p for p in given):
            self.setting.start(entry.get("start"), self.assume)
        found = [(p.where, p.output, self._part(entry, p, g)) for p, g in zip(derived, given, strict=True)]
        verdicts = {v for _, _, v in found}
        if "refuted" in verdicts and not positive:
            raise Refused("a run beside the proof that there is none")
        if "refuted" in verdicts or "unknown" in verdicts:
            return ("refuted" if "refuted" in verdicts else None), found
        return ("proved" if positive else "refuted"), found

    def _part(self, entry: Json, part: Part, given: Json) -> str:
        if any(given[k] != getattr(part, k) for k in ("kind", "where", "output")):
            raise Refused(f"the part {part.where} {part.output} is missing or in another place")
        if given.get("hash") != self.part_hash(part.kind, part.where, part.output):
            raise Refused(f"the part {part.where} {part.output} has another hash than the one derived from the core")
        if "proof" in given and "run" in given:
            raise Refused("a part with a proof and a run")
        if "proof" in given:
            if self.claim["inductive"]:
                raise Beyond("proofs that an invariant is inductive")
            cells = self.setting.cells(entry.get("cells"))
            self._covers(cells)
            self._prove(cells, part, given["proof"])
            return "proved"
        if "run" in given:
            self._violated(part, given["run"])
            return "refuted"
        return "unknown"

    def _covers(self, cells: Cells) -> None:
        """The cells are complete for all instants that the goal speaks of."""
        if cells.time is not None and (self.limit is None or cells.time < self.limit):
            raise Refused("the cells end before the claim's horizon")
        if cells.jumps is not None and (self.limit is not None or self.jumps is None or cells.jumps < self.jumps):
            raise Refused("the cells end before the claim's last jump")

    def _timing(self, at: Instant, tracked: bool, terminal: bool) -> Formula:
        """What is false at instants the goal does not speak of (S20); in a terminal mode time may go on alone."""
        ends = [(self.limit, ">"), (None if terminal else self.after, "<")]
        return disj(at.formula([op, ["time"], str(q)]) for q, op in ends if q is not None and tracked)

    def _outside(self, cells: Cells, at: Instant) -> list[Formula]:
        """Reasons why nothing is claimed at an instant in cells: outside the domain, the assumptions, the time."""
        terminal = self.model.scope.modes[str(at.mode)]["terminal"]
        return [at.outside, *(at.formula(a, True) for a in self.assume), self._timing(at, cells.timed, terminal)]

    def _timeless(self, name: str) -> None:
        """In a terminal mode no claim reads the time, which may go on alone."""
        mode = self.model.scope.modes[name]
        seen = [self.goal["condition"], mode["lets"], self.setting.a["lets"]] if mode["terminal"] else []
        if any(n[0] == "time" for n in nodes(seen)):
            raise Beyond("time in a claim about a terminal mode")

    def _prove(self, cells: Cells, part: Part, proof: Json) -> None:
        """One tree for each cell that the part concerns."""
        if part.kind == "stuck":
            if not all(cells.never_stuck(i, self.limit) for i in cells.by_mode[part.place]):
                raise Refused(f"a run may be stuck in mode {part.place}")
            return
        boxes: list[tuple[int, Any, Box]] = []
        if part.kind == "dwell":
            at = self.model.scope.identity(part.place)
            boxes = [(i, cells.cells[i].stay, {}) for i in cells.by_mode[part.place]]
            claimed, guard = conj(at.formula(c) for c in part.conjuncts), None
        else:
            edge, at = self.setting.a["edges"][part.place], self.model.landing(part.place)
            for i in cells.by_mode[edge["source"]]:
                after, _, s = cells.outcome(i, part.place, cells.cells[i].stay)
                if after is not None and not (cells.jumps is not None and cells.cells[i].jumps == cells.jumps):
                    boxes.append((i, s, {r["var"] + "'": after[r["var"]] for r in edge["resets"] if "to" not in r}))
            claimed = conj(at.formula(c) for c in part.conjuncts if any(n[0] in EVENTS for n in nodes(c)))
            guard = edge
        if not isinstance(proof, list) or len(proof) != len(boxes):
            raise Refused(f"the part {part.where} {part.output} concerns {len(boxes)} cells, its proof another number")
        self._timeless(str(at.mode))
        for tree, (i, s, sets) in zip(proof, boxes, strict=True):
            try:
                self._tree(tree, claimed, cells.place(i, s, sets))
            except Refused:  # the claim alone is often shown; if not, with all that excuses it
                excuses = [] if guard is None else [
                    self.model.guard(part.place, closed=guard["urgent"], outer=True),
                    self.model.scope.identity(guard["source"]).outside]  # fmt: skip
                self._tree(tree, disj([claimed, *excuses, *self._outside(cells, at)]), cells.place(i, s, sets))

    def _tree(self, tree: Json, f: Formula, placed: tuple[dict[str, Poly], Box, Images]) -> None:
        env, box, images = placed
        f = replace(f, lambda op, p: literal(op, substitute(p, env, images)))
        bernstein.replay(tree, f, {**self.model.scope.box, **self._params(box)})

    def _params(self, box: Box) -> Box:
        """The params' box, cut to what is assumed of each of them alone."""
        if not self.assume:
            return box
        still = Instant(self.model.scope, None, {})
        params = {p: box[p] for p in self.model.scope.params if p in box}
        for a in self.assume:
            try:
                params = self.model.narrow(still.formula(a, closed=True), params) or params
            except Beyond:
                continue
        return {**box, **params}

    def _inevitable(self, entry: Json) -> None:
        """Each cell meets the goal in time, or is certainly left, for cells further on."""
        if self.limit is None or (self.goal["within"] is None and self.jumps is not None) or self.after is not None:
            raise Beyond("a `reach` without a time limit")
        self.setting.start(entry.get("start"), self.assume)
        cells = Cells(self.model, self.setting.load(str(entry.get("cells"))), self._landed)
        if not cells.timed:
            raise Refused("the cells do not track time")
        for i, c in enumerate(cells.cells):
            if c.meet is None:
                leaves = any(cells.exits(i, k) for k in self.model.leaving[c.mode])
                if self.model.scope.modes[c.mode]["terminal"] or not leaves:
                    raise Refused(f"a run need not leave a cell of mode {c.mode}")
                continue
            if self.model.scope.modes[c.mode]["terminal"] and c.meet > 0:
                raise Refused(f"a run may end in the terminal mode {c.mode} before it meets the goal")
            if any(n[0] in EVENTS for n in nodes(self.goal["condition"])):
                raise Beyond("a goal about a jump, met during a dwell")
            at = self.model.scope.identity(c.mode)
            assumed = [at.formula(a, True) for a in self.assume]
            met = conj([at.formula(self.goal["condition"]), at.formula(["<=", ["time"], str(self.limit)])])
            self._tree("b", disj([met, *assumed]), cells.place(i, (c.meet, c.meet), {}))
            self._tree("b", self.model.domain(c.mode), cells.place(i, (Fraction(0), c.meet), {}))

    def _landed(self, cells: Cells, i: int, k: int, s: Interval, after: Box) -> bool:
        """Does the goal hold in time where edge k leads to from cell i, whatever the outcome?"""
        edge, at = self.setting.a["edges"][k], self.model.landing(k)
        if fold(self.goal["condition"], edge["target"], edge) is False or not cells.timed:
            return False
        met = conj([at.formula(self.goal["condition"]), at.formula(["<=", ["time"], str(self.limit)])])
        sets = {r["var"] + "'": after[r["var"]] for r in edge["resets"] if "to" not in r}
        try:
            excuses = (at.formula(a, True) for a in self.assume)
            self._tree("b", disj([met, *excuses]), cells.place(i, s, sets))
        except Refused:
            return False
        return True

    def _in_time(self, walk: Walk) -> None:
        if (self.limit is not None and walk.time > self.limit) or (self.after is not None and walk.time < self.after):
            raise Refused("a run ends at an instant that the claim does not speak of")
        late = self.jumps is not None and (walk.jumps, walk.edge is None and walk.jumps > 0) > (self.jumps, False)
        if late and self.limit is None:  # beside a time, K jumps only limit the analysis (S24)
            raise Refused("a run makes more jumps than the claim speaks of")

    def _violated(self, part: Part, run: Json) -> None:
        """The run violates a conjunct of the part at its last instant."""
        walk = Walk(self.model, run, self.assume)
        self._in_time(walk)
        if part.kind == "stuck":
            if not (walk.mode == part.place and walk.stuck()):
                raise Refused("a run is not stuck at its end")
            return
        if (walk.mode if part.kind == "dwell" else walk.edge) != part.place:
            raise Refused("a run ends elsewhere than its part says")
        wrong = disj(walk.last.formula(c, True) for c in part.conjuncts)
        if not walk.surely(wrong):
            raise Refused("a run does not violate the claim at its end")

    def _witness(self, run: Json) -> None:
        walk = Walk(self.model, run, self.assume)
        self._in_time(walk)
        stuck = self.goal["condition"] == ["stuck"]
        if not (walk.stuck() if stuck else walk.surely(walk.last.formula(self.goal["condition"]))):
            raise Refused("a run does not meet the goal at its end")

    def _missed(self, run: Json) -> None:
        """The goal is never met up to the bound, and the run goes beyond it or ends."""
        if (self.limit is None and self.jumps is not None) or self.after is not None:
            raise Beyond("a `reach` bounded by jumps")
        bounds = [self._time(e) for e in (self.claim["horizon"]["time"], self.goal["within"]) if e is not None]
        limit = max(bounds) if bounds else None

        def watch(at: Instant, dwell: Fraction, time: Fraction) -> None:
            if limit is None or time <= limit:
                upto = dwell if limit is None else min(dwell, limit - time)
                missed.append((at, upto))

        missed: list[tuple[Instant, Fraction]] = []
        walk = Walk(self.model, run, self.assume, watch)
        if not all(walk.surely(at.formula(self.goal["condition"], True), upto) for at, upto in missed):
            raise Refused("a run that should miss the goal may meet it")
        ended = self.model.scope.modes[walk.mode]["terminal"] and not any(
            n[0] == "time" for n in nodes([self.goal["condition"], self.setting.a["lets"], self.setting.a["modes"]])
        )
        if not ((limit is not None and walk.time > limit) or ended or walk.stuck()):
            raise Refused("a run stops before the goal's time is over")


def established(core: Core, claim: Json, certificate: Json, settings: Callable[[Json, bool], Setting],
                systems: Callable[[Json], SystemCheck] | None = None,
                ) -> tuple[str, str | None, list[tuple[str, str, str]]]:  # fmt: skip
    """The verdict, the verdict within rounding, and the parts that a certificate establishes."""
    said = certificate["schema"], certificate["claim"], certificate["verdict"] in ("proved", "refuted")
    if said != ("haverify.certificate/1", claim["name"], True):
        raise Refused("its certificate has another schema, is about another claim or has no verdict")
    if all(g["kind"] == "holds" for g in claim["goals"]):
        from hacheck.holds import held

        return held(core, claim, certificate)
    if claim["on"] in core.systems and systems is not None:
        return shown(claim, certificate, systems(core.systems[claim["on"]]))
    if claim["on"] not in core.automata or claim["which"]:
        raise Beyond("claims about systems, rules and formulas, and `for which`")
    automaton = core.automata[claim["on"]]
    verdict, found = _goals(claim, certificate, settings(automaton, False))
    rounding = certificate["rounding"]
    return verdict, None if rounding is None else _goals(claim, rounding, settings(automaton, True))[0], found


def _goals(claim: Json, certificate: Json, setting: Setting) -> tuple[str, list[tuple[str, str, str]]]:
    given, wanted = certificate.get("goals"), certificate.get("verdict")
    if not isinstance(given, list) or len(given) != len(claim["goals"]) or not given:
        raise Refused("its certificate does not have one entry for each goal")
    found: list[tuple[str, str, str]] = []
    verdicts = []
    for goal, entry in zip(claim["goals"], given, strict=True):
        v, listed = Question(setting, claim, goal).verdict(entry)
        verdicts.append(v)
        found += listed
    shown = "refuted" if "refuted" in verdicts else "proved" if all(v == "proved" for v in verdicts) else None
    if shown is None or shown != wanted:
        raise Refused(f"its certificate does not establish the verdict {wanted!a}")
    return shown, found
