"""Laws of automata with flows and jumps: sampled runs stay in the trees that enclose them, and agree with verdicts.

`campaign` does the same with as many machines and runs as wanted: `python -m tests.properties.test_hybrid_flows 500`.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from tests.properties.hybrid import Instant, Jump, Machine, Simulator, Values, value

from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, follow, question_of
from haverify.analyses.portfolio import contexts_of
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read
from haverify.solvers.kernel import Stretch

Q = Fraction
SLACK = 1e-6  # the error of a sampled run, not of an enclosure
ENDS = ("horizon", "jumped", "left", "cut", "answered")

POINT = (0.0, 0.0)


def ball(name: str, drag: str, factor: str, **more: object) -> Machine:
    rise, fall = f"0 - 9.81 - {drag} * v^2", f"{drag} * v^2 - 9.81"
    top = Jump("top", "Rise", "Fall", "v <= 0")
    bounce = Jump("bounce", "Fall", "Rise", "h <= 0 and v < 0", {"v": f"0 - {factor} * v"})
    modes = {"Fall": ("h >= 0", {"h": "v", "v": fall}), "Rise": ("h >= 0", {"h": "v", "v": rise})}
    return Machine(name, "Fall", {"h": (1.0, 1.125), "v": POINT}, modes, (top, bounce), **more)  # type: ignore[arg-type]


MACHINES = [
    ball("a ball", "0", "0.75"),
    ball("drag", "0.02", "0.75"),
    ball("uncertain bounce", "0.01", "c", params={"c": (0.7, 0.75)}),
    Machine(
        "rocking block",
        "Left",
        {"x": (-0.51, -0.49), "w": (-0.01, 0.01)},
        {
            "Left": ("x <= 0", {"x": "w", "w": "sin(0.785 * (1 + x)) / 0.785"}),
            "Right": ("x >= 0", {"x": "w", "w": "0 - sin(0.785 * (1 - x)) / 0.785"}),
        },
        (
            Jump("a", "Left", "Right", "x >= 0 and w > 0", {"w": "0.8 * w", "x": "0"}),
            Jump("b", "Right", "Left", "x <= 0 and w < 0", {"w": "0.8 * w", "x": "0"}),
        ),
    ),
    Machine(
        "thermostat",
        "On",
        {"T": (19.0, 19.5)},
        {"On": ("T <= 22", {"T": "3 - 0.1 * T / 2"}), "Off": ("T >= 18", {"T": "0 - 0.1 * T"})},
        (
            Jump("off", "On", "Off", "T >= 21", urgent=False),
            Jump("on", "Off", "On", "T <= 19", urgent=False),
        ),
    ),
    Machine(
        "open jump",
        "P",
        {"x": (0.0, 0.1), "y": (1.0, 1.0)},
        {"P": ("true", {"x": "1", "y": "0 - y"}), "B": ("true", {"x": "0 - x", "y": "x"})},
        (Jump("go", "P", "B", "x >= 0.5 and x <= 0.8", {"y": "y + x"}, urgent=False),),
    ),
    Machine(
        "pendulum with kick",
        "Swing",
        {"a": (0.9, 1.0), "w": POINT},
        {"Swing": ("true", {"a": "w", "w": "0 - sin(a) - 0.1 * w"})},
        (Jump("kick", "Swing", "Swing", "a <= 0 and w < 0", {"a": "0.01", "w": "1.1 * w - 0.1"}),),
    ),
    Machine(
        "chain at an instant",
        "P",
        {"x": (0.0, 0.1), "y": (0.5, 0.6)},
        {
            "P": ("true", {"x": "1 + x * y", "y": "0 - y"}),
            "B": ("true", {"x": "1", "y": "0 - x"}),
            "C": ("y >= 0 - 9", {"x": "0 - x", "y": "0 - 1"}),
        },
        (
            Jump("pb", "P", "B", "x >= 0.5", {"y": "y + 2"}),
            Jump("bc", "B", "C", "y >= 1.5", {"x": "x + y", "y": "y - 1"}),
            Jump("cp", "C", "P", "x >= 2", {"x": "x - 3", "y": "0.7"}),
        ),
    ),
    Machine(
        "chain with a choice",
        "P",
        {"x": (0.0, 0.1), "y": (0.5, 0.6)},
        {
            "P": ("true", {"x": "1 + x * y", "y": "0 - y"}),
            "B": ("true", {"x": "1", "y": "0 - x"}),
            "C": ("true", {"x": "0 - x", "y": "0 - 1"}),
        },
        (
            Jump("pb", "P", "B", "x >= 0.5", {"y": (2.0, 2.5)}),
            Jump("bc", "B", "C", "y >= 1.5", {"x": "x + y"}),
            Jump("bp", "B", "P", "y >= 1.9 and y <= 3", {"x": "0 - y"}, urgent=False),
        ),
    ),
    Machine(
        "switched",
        "A",
        {"x": (1.0, 1.1), "y": (0.4, 0.5)},
        {
            "A": ("x >= y / 2", {"x": "0 - x + y", "y": "0 - x - y / 2"}),
            "B": ("y >= 0 - 2", {"x": "0 - 2 * x + y", "y": "0.5 - y"}),
        },
        (Jump("ab", "A", "B", "y <= 0 - 0.2", {"y": "y - 0.1"}), Jump("ba", "B", "A", "y >= 0.3 and x > 0.16")),
    ),
    Machine(
        "van der pol",
        "Run",
        {"x": (1.25, 1.35), "y": (2.35, 2.4)},
        {"Run": ("true", {"x": "y", "y": "(1 - x^2) * y - x"})},
        (Jump("back", "Run", "Run", "x >= 2.005 and y > 0", {"x": "x - 1", "y": "y + 1"}),),
    ),
    Machine(
        "choices",
        "P",
        {"x": (0.0, 0.1), "y": (0.0, 0.0)},
        {"P": ("x <= 1", {"x": "1", "y": "0 - y"}), "B": ("x >= 0 - 3", {"x": "y - 2", "y": "0.5 * x"})},
        (Jump("go", "P", "B", "x >= 1", {"y": (0.25, 0.5)}), Jump("gi", "B", "P", "x <= 0", {"x": (0.0, 0.25)})),
    ),
    Machine(
        "timer",
        "P",
        {"x": (1.0, 1.5), "s": POINT},
        {"P": ("s <= 0.5", {"x": "0 - x", "s": "1"}), "B": ("s <= 0.25", {"x": "2 - x * x / 2", "s": "1"})},
        (Jump("up", "P", "B", "s >= 0.5", {"s": "0"}), Jump("down", "B", "P", "s >= 0.25", {"s": "0", "x": "x - 0.1"})),
    ),
    Machine(
        "several at once",
        "P",
        {"x": (0.0, 0.1), "y": (0.5, 0.5)},
        {m: ("true", {"x": r, "y": "0 - y * x"}) for m, r in (("P", "1"), ("B", "0 - x"), ("C", "0"))},
        (
            Jump("b", "P", "B", "x >= 1"),
            Jump("c", "P", "C", "x >= 1", {"y": "y + 1"}),
            Jump("d", "P", "P", "x >= 1", {"x": "0"}, urgent=False),
        ),
    ),
    Machine(
        "surface",
        "P",
        {"x": (0.2, 0.25), "y": (0.2, 0.25)},
        {"P": ("true", {"x": "1 - x / 2", "y": "x"}), "B": ("x >= 0.1", {"x": "0 - y", "y": "x"})},
        (
            Jump("meet", "P", "B", "x + y == 1", {"x": "x / 2 + 1"}, event="x + y >= 1"),
            Jump("again", "B", "P", "x <= 0.2", {"x": "0.2", "y": "0.2"}),
        ),
    ),
    Machine(
        "terminal",
        "P",
        {"x": (0.0, 0.1), "y": (1.0, 1.0)},
        {"P": ("x < 1", {"x": "1 + x", "y": "0 - y"}), "E": ("true", {"x": "0 - x", "y": "x"})},
        (Jump("end", "P", "E", "x >= 1", {"x": "x + y"}),),
        terminal=frozenset({"E"}),
    ),
]


def random_machine(chance: random.Random) -> Machine:
    """Two modes, linear or quadratic rates, edges at straight lines, of every kind."""

    def number(most: float = 2.0) -> str:
        q = chance.randint(-8, 8) * most / 8
        return f"{q}" if q >= 0 else f"(0 - {-q})"

    def rate() -> str:
        square = f" + {number(0.5)} * {chance.choice(['x * y', 'x^2', 'y^2'])}" if chance.random() < 0.4 else ""
        return f"{number()} + {number()} * x + {number()} * y{square}"

    def line(strict: str) -> str:
        return f"{chance.choice(['x', 'y', 'x + y', 'x - y'])} {chance.choice(['<', '>'])}{strict} {number()}"

    def domain() -> str:
        return chance.choice(["true", line("="), line("=")])

    def jump(k: int) -> Jump:
        guard = line(chance.choice(["=", "", "="])) + (f" and {line('=')}" if chance.random() < 0.3 else "")
        resets: dict[str, str | tuple[float, float]] = {}
        if chance.random() < 0.6:
            resets["x"] = f"{number(1)} * x + {number(1)}"
        if chance.random() < 0.4:
            low = chance.randint(-4, 4) / 4
            resets["y"] = (low, low + 0.25) if chance.random() < 0.5 else f"{number(1)} * x + y"
        return Jump(f"e{k}", chance.choice("PB"), chance.choice("PB"), guard, resets, chance.random() < 0.75)

    corner = [chance.randint(-4, 4) / 4 for _ in "xy"]
    start = {v: (c, c + chance.choice([0.0, 0.05, 0.2])) for v, c in zip("xy", corner, strict=True)}
    modes = {m: (domain(), {"x": rate(), "y": rate()}) for m in "PB"}
    return Machine("random", "P", start, modes, tuple(jump(k) for k in range(chance.randint(1, 3))))


@dataclass(frozen=True)
class Asked:
    """A claim `kind` with the condition `left op right`, and up to when."""

    kind: str
    left: str
    op: str
    right: float
    until: float

    def text(self) -> str:
        right = f"{self.right}" if self.right >= 0 else f"0 - {-self.right}"
        if self.kind == "always":
            return f"within {self.until}; always {self.left} {self.op} {right}"
        return f"{self.kind.replace('_', ' ')} {self.left} {self.op} {right} within {self.until}"

    def distance(self, values: Values) -> float:
        """How far the condition is from changing; positive where it holds."""
        gap = float(value(self.left, values)) - self.right
        return gap if self.op in (">", ">=") else -gap


def decided(machine: Machine, claim: str) -> tuple[Question, Evidence]:
    """The question that a claim about a machine is, and what the analysis says."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "machine.ha"
        path.write_text(f"{machine.text()}\nproperty p on A {{ {claim} }}\n", encoding="utf-8")
        spec, _, found = read(str(path))
    assert spec is not None, [d.message for d in found]
    context, asked = contexts_of(spec).get("A"), spec.claims[0]
    assert context is not None
    model = hybrid_model(spec, context.automaton, [g.condition for g in asked.goals])
    evidence = decide_flow(spec, context.automaton, asked, context.core)
    return question_of(model, asked, asked.goals[0]), evidence


def tree_of(question: Question, box: dict[str, tuple[float, float]]) -> list[Stretch]:
    """The tree from a part of the starts."""
    start = question.model.starts[0]
    sides = tuple(
        (Q(box[n][0]), Q(box[n][1])) if n in box else ends
        for n, ends in zip(question.model.names, start.box, strict=True)
    )
    return follow(question, start, sides, "horizon")


def part_of(machine: Machine, chance: random.Random) -> dict[str, tuple[float, float]]:
    """All starts, or a part of them, params included."""
    whole = {**machine.start, **machine.params}
    if chance.random() < 0.4:
        return whole
    share = chance.choice([0.0, 0.0, 0.5, 0.75])
    at = {v: low + chance.choice([0.0, share]) * (high - low) for v, (low, high) in whole.items()}
    width = chance.choice([0.0, 0.25, 0.25])
    return {v: (at[v], min(high, at[v] + width * (high - low))) for v, (low, high) in whole.items()}


def followed_until(tree: Sequence[Stretch]) -> float:
    """Before this the tree encloses all runs: nothing of it ended for a lack of effort."""
    ends = [s for s in tree if s.end not in ENDS]
    if any("stretches" in s.end for s in ends):
        return 0.0  # nothing is known of those that wait
    return min((s.stages[-1].time[0] if s.stages else s.jump.time[0] if s.jump else 0.0 for s in ends), default=1e9)


def is_in(values: Sequence[float], box: Sequence[tuple[float, float]]) -> bool:
    slack = [SLACK * (1 + abs(v)) for v in values]
    return all(low - s <= v <= high + s for v, (low, high), s in zip(values, box, slack, strict=True))


def escapes(question: Question, tree: Sequence[Stretch], run: Sequence[Instant]) -> list[str]:
    """The instants of a run that are in no stage of the tree, the jumps that are none of its jumps."""
    model, until = question.model, followed_until(tree)
    found = []
    for at in run:
        if at.values["time"] >= until - SLACK:
            break
        state = [at.values[n] for n in model.names]
        mode = model.mode(at.mode)
        own = [s for s in tree if s.mode == mode and s.jumps == at.jumps]
        # A stay of no length is in no stage: the landing itself encloses it.
        boxes = [g.states for s in own for g in s.stages] + [s.jump.after for s in own if s.jump is not None]
        if not any(is_in(state, b) for b in boxes):
            found.append(f"{at.mode} after {at.jumps} jumps: {at.values}")
        if at.jump is not None:
            before = [at.before[n] for n in model.names]
            made = [s.jump for s in own if s.jump is not None and edge_of(question, tree, s) == at.jump.name]
            if not any(is_in(before, j.before) and is_in(state, j.after) for j in made):
                found.append(f"jump {at.jump.name}: {at.before} to {at.values}")
    return found


def edge_of(question: Question, tree: Sequence[Stretch], s: Stretch) -> str | None:
    assert s.parent is not None
    assert s.jump is not None
    model = question.model
    return model.automaton.edges[model.edges[tree[s.parent].mode][s.jump.edge]].name


def runs_of(
    machine: Machine, box: dict[str, tuple[float, float]], until: float, count: int, seed: int
) -> list[list[Instant]]:
    simulator = Simulator(machine, random.Random(seed))
    return [list(simulator.run(simulator.start(box), until)) for _ in range(count)]


def contradictions(machine: Machine, asked: Asked, evidence: Evidence, runs: Sequence[Sequence[Instant]]) -> list[str]:
    """What sampled runs say against a verdict."""
    best = [max(asked.distance(at.values) for at in run) for run in runs]
    worst = [min(asked.distance(at.values) for at in run) for run in runs]
    verdict = evidence.verdict
    against = {
        ("always", Proved): any(d < -SLACK for d in worst),
        ("can_reach", Refuted): any(d > SLACK for d in best),
        ("reach", Proved): any(d < -SLACK for d in best),
        ("reach", Refuted): False,
    }.get((asked.kind, type(verdict)), False)
    found = [f"{type(verdict).__name__}: {asked.text()}"] if against else []
    if isinstance(verdict, (Proved, Refuted)) and evidence.run is not None and not _confirmed(machine, asked, evidence):
        found.append(f"the run is none that shows it: {asked.text()}, {evidence.run}")
    return found


def _confirmed(machine: Machine, asked: Asked, evidence: Evidence) -> bool:
    """Whether the run that is named does what it is named for; where resets leave a choice, nothing is compared."""
    run = evidence.run
    assert run is not None
    if any(isinstance(e, tuple) for j in machine.jumps for e in j.resets.values()):
        return True
    instants = accumulate(float(step.dwell) for step in run.steps)
    script = [(machine.jumps[step.edge].name, at) for step, at in zip(run.steps, instants, strict=True)]
    simulator = Simulator(machine, random.Random(1), script=script)
    values = {n: float(q) for n, q in (*run.values, *run.params)}
    seen = [at for at in simulator.run(values, asked.until) if at.jumps <= len(run.steps)]
    distances = [asked.distance(at.values) for at in seen]
    if asked.kind == "reach":
        return max(distances) < SLACK
    near = 5e-2 * (1 + max(abs(d) for d in distances))  # between two steps of the simulator
    return max(distances) > -near if asked.kind == "can_reach" else min(distances) < near


def claims_of(machine: Machine, runs: Sequence[Sequence[Instant]], until: float, chance: random.Random) -> list[Asked]:
    """A claim near the border of truth, by what sampled runs do."""
    v = chance.choice(list(machine.start))
    seen = [at.values[v] for run in runs for at in run]
    low, high = min(seen), max(seen)
    width = (high - low + 0.1) * chance.choice([0.01, 0.05, 0.2])
    shift = chance.choice([-width, width])
    last = max(r[0].values[v] for r in runs)
    kinds = [
        Asked("always", v, "<=", round(high + shift, 4), until),
        Asked("can_reach", v, "<=", round(low + shift, 4), until),
        Asked("reach", v, chance.choice(["<=", ">="]), round(chance.choice([low, high, last]) + shift, 4), until),
    ]
    return [kinds[chance.randrange(2 if machine.terminal else 3)]]


def examined(machine: Machine, until: float, runs: int, seed: int) -> list[str]:
    """Everything that is wrong of one machine, a part of its starts, and a claim about it."""
    chance = random.Random(seed)
    sampled = runs_of(machine, {**machine.start, **machine.params}, until, runs, seed)
    sampled = [r for r in sampled if _may_start(machine, r[0])]
    found = []
    for asked in claims_of(machine, sampled, until, chance) if sampled else []:
        question, evidence = decided(machine, asked.text())
        found += contradictions(machine, asked, evidence, sampled)
        box = part_of(machine, chance)
        tree = tree_of(question, box)
        for run in runs_of(machine, box, until, runs, seed + 1):
            if _may_start(machine, run[0]):
                found += escapes(question, tree, run)[:1]
    return [f"{machine.text()}\n{f}" for f in found]


def _may_start(machine: Machine, at: Instant) -> bool:
    return bool(value(machine.modes[machine.mode][0].replace("<", "<=").replace("<==", "<="), at.values))


def campaign(count: int, seed: int = 0, runs: int = 12, until: float = 1.5) -> list[str]:
    """All that is wrong of the machines by hand and of `count` random ones."""
    found = [e for m in MACHINES for k in range(3) for e in examined(m, 2.5, runs, seed + k)]
    for k in range(count):
        found += examined(random_machine(random.Random(seed + k)), until, runs, seed + k)
    return found


@pytest.mark.parametrize("machine", MACHINES, ids=lambda m: m.name)
def test_runs_stay_in_their_trees_and_agree_with_verdicts(machine: Machine) -> None:
    assert examined(machine, 1.5, 3, 7) == []


# Starts of all of these are admissible, those of 1 and 2 are not; runs of the last four jump, those of the first never.
SEEDS = (0, 3, 4, 5, 6, 26, 28, 42, 50)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_machines(seed: int) -> None:
    assert examined(random_machine(random.Random(seed)), 1.0, 4, seed) == []


def test_a_run_of_another_machine_is_noticed() -> None:
    """The looks above can fail: a ball that bounces a little higher, or a little later, is seen."""
    machine = MACHINES[0]
    question, _ = decided(machine, "within 1.5; always h <= 2")
    tree = tree_of(question, dict(machine.start))
    assert followed_until(tree) > 1.5
    higher = replace(machine, jumps=(machine.jumps[0], replace(machine.jumps[1], resets={"v": "0 - 0.76 * v"})))
    later = replace(machine, jumps=(machine.jumps[0], replace(machine.jumps[1], guard="h <= 0 - 0.01 and v < 0")))
    later = replace(later, modes={m: ("true", rates) for m, (_, rates) in machine.modes.items()})
    for other, is_right in ((machine, True), (higher, False), (later, False)):
        runs = runs_of(other, dict(machine.start), 1.5, 4, 1)
        assert all(not escapes(question, tree, run) for run in runs) is is_right


if __name__ == "__main__":
    print("\n\n".join(campaign(int(sys.argv[1]), int((sys.argv[2:] or ["0"])[0]))) or "nothing is wrong")
