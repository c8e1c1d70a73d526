"""Laws of verdicts about flows: what runs of an integrator of its own, and the same model told otherwise, say of them.

`python -m tests.properties.test_wild_flows COUNT [SEED] [KIND...]` does it with as many models as wanted.
"""

from __future__ import annotations

import random
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from tests.properties.wild import NEAR, Edge, Instant, Model, Runner, Values, compiled, holds, wild

from haverify.analyses.context import Context
from haverify.analyses.hybrid import question
from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.shared import Trees
from haverify.analyses.portfolio import contexts_of
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.run.examine import read

Q = Fraction
SLACK = 1e-5  # the error of a sampled run
LONG = 6.0  # how far runs are followed for claims without a horizon
BUDGET = Q(1, 100)
LIMITS = {"STEPS": 120, "STRETCHES": 16, "LAPS": 80, "RETURNS": 16, "CUTS": 2}  # of one tree


@dataclass(frozen=True)
class Asked:
    """A claim: its form, the condition `left op right`, instants asked for; without a horizon `last` is None."""

    form: str  # always, can reach, reach, globally, eventually, landing
    left: str
    op: str
    right: float
    first: float = 0.0
    last: float | None = None
    extra: str = ""

    @property
    def condition(self) -> str:
        return f"{self.left} {self.op} {self.right}"

    def text(self) -> str:
        c, t = self.condition, self.last
        within = f"within {t}; " if t is not None else ""
        inside = {
            "always": f"{within}always {f'during [{self.first}, {t}] ' if self.first else ''}{c}",
            "landing": f"{within}always jumped implies {c}",
            "can reach": f"can reach {c}" + (f" within {t}" if t is not None else ""),
            "reach": f"reach {c} within {t}",
            "globally": f"stl globally[{self.first}, {t}] {c}",
            "eventually": f"stl eventually[{self.first}, {t}] {c}",
        }[self.form]
        return f"{self.extra}{inside}"

    def distance(self, at: Instant) -> float:
        """How far the condition is from changing; positive where it holds."""
        known = {**at.values, **{f"pre_{n}": v for n, v in (at.before or at.values).items()}}
        gap = float(compiled(re.sub(r"pre\((\w)\)", r"pre_\1", self.left))(known)) - self.right
        return gap if self.op in (">", ">=") else -gap

    def is_asked_at(self, at: Instant, slack: float = NEAR) -> bool:
        t = at.values["time"]
        if self.form == "landing" and at.edge is None:
            return False
        return self.first - slack <= t and (self.last is None or t <= self.last + slack)


Sampled = tuple[list[Instant], str]


def sampled(model: Model, chance: random.Random, count: int, until: float, step: float = 0.02) -> Iterator[Sampled]:
    """Runs with how each ended."""
    for _ in range(count):
        runner = Runner(model, chance, step)
        start = runner.begin()
        if holds(model.modes[model.mode][0], start):
            try:
                found = list(runner.run(start, until))
            except OverflowError:
                continue
            yield found, runner.over


def inside(model: Model, run: Sequence[Instant]) -> bool:
    return all(lo <= at.values[v] <= hi for at in run for v, (lo, hi) in model.windows.items())


def claims(model: Model, runs: Sequence[Sampled], chance: random.Random) -> list[Asked]:
    """Claims near the border of truth, by what sampled runs do."""
    found = []
    last = chance.choice([None, 1.0, 1.0, 2.0])
    for _ in range(chance.choice([1, 4, 8])):
        form = chance.choice(
            ["always"] * 4 + ["can reach", "landing"] + ["reach", "globally", "eventually"] * bool(last)
        )
        first = chance.choice([0.0, 0.0, 0.5]) if form in ("always", "globally", "eventually") and last else 0.0
        left = chance.choice(["x", "y", "x", "y", "x + y", "x * y", "abs(x)", "x - y"])
        if form == "landing":
            left = chance.choice(["x", "y", "x - pre(x)"])
        op = chance.choice(["<=", ">=", "<", ">"])
        asked = Asked(form, left, op, 0.0, first, last)
        seen = [asked.distance(at) for run, _ in runs for at in run if asked.is_asked_at(at)]
        if not seen:
            continue
        shift = chance.choice([-0.05, -0.01, 0.01, 0.05, 0.3])
        edge = min(seen) - shift if form in ("always", "globally", "landing") else max(seen) + shift
        if form in ("reach", "eventually"):
            bests = [max([asked.distance(at) for at in run if asked.is_asked_at(at)], default=0.0) for run, _ in runs]
            edge = min(bests) - shift
        found.append(replace(asked, right=round(edge if op[0] == ">" else -edge, 3)))
    return found


def decided(text: str, claims: Sequence[str], order: Sequence[int] | None = None) -> dict[int, Evidence | str]:
    """What is said of each claim, all sharing their trees, in some order."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "wild.ha"
        told = "\n".join(f"property p{i} on A {{ {c} }}" for i, c in enumerate(claims))
        path.write_text(f"{text}\n{told}\n", encoding="utf-8")
        spec, _, found = read(str(path))
    assert spec is not None, (text, [d.message for d in found])
    context, trees = contexts_of(spec).get("A"), Trees()
    assert context is not None
    usual = {name: getattr(question, name) for name in LIMITS}
    for name, limit in LIMITS.items():
        setattr(question, name, limit)
    try:
        return _decided(spec, context, trees, order if order is not None else range(len(claims)))
    finally:
        for name, limit in usual.items():
            setattr(question, name, limit)


def _decided(spec: Spec, context: Context, trees: Trees, order: Sequence[int]) -> dict[int, Evidence | str]:
    said: dict[int, Evidence | str] = {}
    for i in order:
        try:
            said[i] = decide_flow(spec, context.automaton, spec.claims[i], None, BUDGET, trees)
        except OutsideFragmentError as e:
            said[i] = str(e)
    return said


def contradiction(model: Model, asked: Asked, evidence: Evidence, runs: Sequence[Sampled]) -> str:
    """What sampled runs say against a verdict."""
    word = type(evidence.verdict).__name__
    for run, over in runs:
        kept = run if inside(model, run) else []
        seen = [asked.distance(at) for at in kept if asked.is_asked_at(at)]
        if not seen:
            continue
        if word == "Proved" and asked.form in ("always", "globally", "landing") and min(seen) < -SLACK:
            return f"proved, but a run is {min(seen)} beyond"
        if word == "Refuted" and asked.form == "can reach" and max(seen) > SLACK:
            return f"never reached, but a run is {max(seen)} inside"
        is_whole = over == "horizon" or (over == "stuck" and asked.form == "reach")
        if (
            word == "Proved"
            and asked.form in ("reach", "eventually")
            and is_whole
            and max(seen) < -SLACK - _moved(seen)
        ):
            return f"proved, but a run stays {-max(seen)} away"
    if evidence.run is not None and word in ("Proved", "Refuted"):
        return replayed(model, asked, evidence)
    return ""


def _moved(seen: Sequence[float]) -> float:
    """By how much a quantity may have been nearer between two looks."""
    return max((min(abs(b - a), 0.1) for a, b in pairwise(seen)), default=0.0)


def replayed(model: Model, asked: Asked, evidence: Evidence) -> str:
    """What is wrong of the run that is named: each stay is followed from the middle of the landing before it."""
    run = evidence.run
    assert run is not None
    fixed = {n: float(q) for n, q in (*run.values, *run.params)}
    runner = Runner(model, random.Random(0), 0.005)
    runner.inputs = {n: fixed.get(n, sum(e) / 2) for n, e in model.inputs.items()}
    runner.shares = {f"{m}.{v}": _share(fixed, v, e) for m, (_, rates) in model.modes.items() for v, e in rates.items()}
    known = {**{d: float(v) for d, (_, v) in model.discrete.items()}, **fixed, "time": 0.0}
    seen: list[Instant] = []
    now, width = Instant(run.mode, known), 1e-4
    for number, passage in enumerate([*run.path[1:-1], None]):
        width = max([width, *(b - a for _, a, b in passage.values)]) if passage else width
        dwell = float(run.steps[number].dwell if passage else run.last)
        due = [e for e in model.edges if e.source == now.mode and e.urgent]
        t = 0.0
        while t < dwell:
            seen.append(now)
            if not holds(model.modes[now.mode][0], now.values, 1e-3 + 10 * width):
                return f"the run is outside of its domain: {now}"
            early = [e for e in due if holds(e.guard, now.values, -1e-3 - 10 * width)]
            if any(runner._made(e, now) for e in early) and t > 0.0:
                return f"an urgent edge is due: {early} {now}"
            h = min(0.005, dwell - t)
            t += h
            now = Instant(now.mode, runner._flown(now, h))
        seen.append(now)
        if passage is None:
            break
        before, edge = now.values, next(e for e in model.edges if e.name == passage.edge)
        if not holds(edge.guard, before, 1e-3 + 10 * width):
            return f"the guard of {edge.name} is not met: {before}"
        after = {**before, **{n: (a + b) / 2 for n, a, b in passage.values}}
        for v, e in edge.resets.items():
            if v in model.discrete:
                after[v] = float(compiled(str(e))(before))
        if any(abs(after[v] - _reset(edge, v, before)) > 1e-3 + 10 * width for v in "xy" if not _is_chosen(edge, v)):
            return f"the landing of {edge.name} is not what its reset says: {before} {after}"
        now = Instant(passage.mode, after, edge, before)
    if asked.form in ("reach", "eventually"):
        best = max([asked.distance(at) for at in seen if asked.is_asked_at(at)], default=-1.0)
        return f"the run meets it by {best}" if best > 1e-3 else ""
    if width > 0.05:
        return ""  # a choice of a reset that does not matter for the claim, but for the replay
    wants = -1.0 if asked.form != "can reach" else 1.0
    last = [wants * asked.distance(at) for at in seen[-3:] if asked.is_asked_at(at, 1e-3)]
    return "" if last and max(last) > -2e-2 else f"the run does not show it: {last} {seen[-1]}"


def _share(fixed: Mapping[str, float], v: str, e: object) -> float:
    if not isinstance(e, tuple):
        return 0.5
    if f"{v}'" in fixed and not any(c.isalpha() for c in f"{e[0]}{e[1]}"):
        low, high = float(e[0]), float(e[1])
        return (fixed[f"{v}'"] - low) / (high - low)
    return (1 + fixed.get(f"share of the range of {v}'", 0.0)) / 2


def _is_chosen(edge: Edge, v: str) -> bool:
    return isinstance(edge.resets.get(v), tuple)


def _reset(edge: Edge, v: str, before: Values) -> float:
    told = edge.resets.get(v, v)
    return float(compiled(str(told))(before))


# ---- the same model told otherwise


def faster(model: Model, asked: Asked) -> tuple[Model, Asked]:
    """Time runs twice as fast."""
    modes = {m: (d, {v: _times(e, "2") for v, e in rates.items()}) for m, (d, rates) in model.modes.items()}
    last = None if asked.last is None else asked.last / 2
    return replace(model, modes=modes), replace(asked, first=asked.first / 2, last=last)


def _times(e: str | tuple[str, str], factor: str) -> str | tuple[str, str]:
    return (f"{factor} * ({e[0]})", f"{factor} * ({e[1]})") if isinstance(e, tuple) else f"{factor} * ({e})"


def moved(model: Model, asked: Asked) -> tuple[Model, Asked]:
    """`x` is told as `2 x + 1`, and `y` comes first."""

    def old(formula: str) -> str:
        return re.sub(r"\bx\b", "((x - 1) / 2)", formula)

    def told(v: str, e: Any, shift: str = "") -> Any:
        ends = (old(str(e[0])), old(str(e[1]))) if isinstance(e, tuple) else old(e)
        scaled = _times(ends, "2") if v == "x" else ends
        if v != "x" or not shift:
            return scaled
        return (f"{scaled[0]}{shift}", f"{scaled[1]}{shift}") if isinstance(scaled, tuple) else f"{scaled}{shift}"

    start = {v: model.start[v] if v != "x" else _doubled(model.start[v]) for v in ("y", "x")}
    modes = {m: (old(d), {v: told(v, e) for v, e in rates.items()}) for m, (d, rates) in model.modes.items()}
    edges = tuple(
        replace(e, guard=old(e.guard), resets={v: told(v, x, " + 1") for v, x in e.resets.items()}) for e in model.edges
    )
    windows = {v: _doubled(e) if v == "x" else e for v, e in model.windows.items()}
    return replace(model, start=start, modes=modes, edges=edges, windows=windows), replace(asked, left=old(asked.left))


def _doubled(ends: tuple[float, float]) -> tuple[float, float]:
    return round(2 * ends[0] + 1, 6), round(2 * ends[1] + 1, 6)


def narrower(model: Model, asked: Asked) -> tuple[Model, Asked]:
    """A half of the starts."""
    return replace(model, start={v: (low, round((low + high) / 2, 6)) for v, (low, high) in model.start.items()}), asked


def disagree(asked: Asked, told: str, one: Evidence, other: Evidence) -> bool:
    """Whether what holds of all runs fails of the same ones, or of some of them."""
    if told == "narrower" and asked.form == "can reach":
        return isinstance(one.verdict, Refuted) and isinstance(other.verdict, Proved)
    pair = {type(one.verdict), type(other.verdict)}
    if told == "narrower":
        return isinstance(one.verdict, Proved) and isinstance(other.verdict, Refuted)
    return pair == {Proved, Refuted}


TOLD = {"faster": faster, "moved": moved, "narrower": narrower}


def examined(seed: int, kinds: frozenset[str] = frozenset(), tally: Counter[str] | None = None) -> list[str]:
    """Everything that is wrong of what is said of one model."""
    chance = random.Random(seed)
    model = wild(chance, kinds)
    runs = list(sampled(model, chance, 10, LONG if chance.random() < 0.5 else 2.0))
    if not runs:
        return []
    asked = claims(model, runs, chance)
    order = list(range(len(asked)))
    chance.shuffle(order)
    counts = Counter[str]() if tally is None else tally
    found = []
    said = decided(model.text(), [a.text() for a in asked], order)
    for i, a in enumerate(asked):
        answer = said[i]
        if isinstance(answer, str):
            counts[f"outside: {answer}"] += 1
            continue
        counts[f"{type(answer.verdict).__name__} {a.form}{'' if a.last else ' endless'}"] += 1
        wrong = contradiction(model, a, answer, runs)
        if not wrong and isinstance(answer.verdict, Proved) and answer.run is None:
            wrong = contradiction(model, a, answer, list(sampled(model, chance, 15, a.last or LONG, 0.01)))
        if wrong:
            found.append(f"{a.text()}: {wrong}")
    if asked and chance.random() < 0.4:
        i = chance.randrange(len(asked))
        name = chance.choice(list(TOLD))
        other, its = TOLD[name](model, asked[i])
        first, second = said[i], decided(other.text(), [its.text()])[0]
        if isinstance(first, Evidence) and isinstance(second, Evidence):
            counts[f"told {name}"] += 1
            if disagree(asked[i], name, first, second):
                found.append(f"{asked[i].text()}: {first.verdict} but {name} {second.verdict}\n{other.text()}")
    return [f"seed {seed}: {f}\n{model.text()}" for f in found]


KINDS = [frozenset[str](), frozenset({"inputs"}), frozenset({"discrete"}), frozenset({"corners", "discrete"})]


@pytest.mark.parametrize("kinds", KINDS, ids=lambda k: "-".join(sorted(k)) or "plain")
def test_verdicts_agree_with_runs_and_with_the_same_model_told_otherwise(kinds: frozenset[str]) -> None:
    assert [e for seed in range(1) for e in examined(seed, kinds)] == []


def campaign(count: int, first: int, kinds: frozenset[str]) -> int:
    tally, started, wrong = Counter[str](), time.process_time(), 0
    for seed in range(first, first + count):
        before = time.process_time()
        found = examined(seed, kinds, tally)
        tally["slow (over 5 s)"] += time.process_time() - before > 5
        wrong += len(found)
        for text in found:
            print(text, flush=True)
        if seed % 20 == 19:
            print(
                seed + 1 - first, "models", wrong, "wrong", round(time.process_time() - started), "s", file=sys.stderr
            )
    print(f"{count} models, {wrong} wrong, {time.process_time() - started:.0f} s")
    for name, number in sorted(tally.items()):
        print(f"{number:7} {name}")
    return 1 if wrong else 0


if __name__ == "__main__":
    numbers = [int(a) for a in sys.argv[1:] if a.isdigit()]
    kinds = frozenset(a for a in sys.argv[1:] if not a.isdigit())
    sys.exit(campaign(numbers[0], (numbers[1:] or [0])[0], kinds))
