"""Two benchmark problems in other words: paces of time, units of the state, variables in another order.

Verdicts and margins are those of the problem as it is written: what is computed in floats differs, the answer does not.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read
from haverify.text.record import record, replace

FOLDER = Path(__file__).parents[1] / "peers" / "nln"


@record
class Words:
    """Time runs `pace` times as fast, a state of the text is `size` times smaller, variables in this order."""

    pace: int = 1
    size: int = 1
    order: tuple[str, ...] = ()


@record
class Problem:
    """A problem of the folder: its states, those that have units, and instants that the text names."""

    file: str
    states: tuple[str, ...]
    instants: tuple[int, ...]


VAN_DER_POL = Problem("coupled_van_der_pol.ha", ("x1", "y1", "x2", "y2"), (7,))
SPACECRAFT = Problem("spacecraft_rendezvous.ha", ("x", "y", "vx", "vy"), (120, 200))


def plain(problem: Problem) -> str:
    """The problem as it is written, without its claims and comments."""
    text = (FOLDER / problem.file).read_text(encoding="utf-8")
    text = re.sub(r"//.*", "", text)
    return text[: text.index("\nproperty")]


def said(problem: Problem, words: Words, claim: str) -> str:
    """The same in other words, with a claim."""
    text = plain(problem)
    names = "|".join(sorted(problem.states, key=len, reverse=True))
    inner = rf"\b({names})\b(?!')"
    head, body = text.split("\n  init ", 1)
    start, modes = body.split("\n", 1)
    lines = [line for line in head.splitlines() if not re.match(r"\s*var ", line)]
    declared = {m[1]: m[0] for m in re.finditer(r"  var (\w+).*", head)}
    # Lets read states; declared ranges and starts are numbers in the units of the state.
    order = words.order or tuple(declared)
    first = 1 + next(k for k, line in enumerate(lines) if line.startswith("automaton"))
    lines[first:first] = [declared[name] for name in order]
    is_declared = re.compile(r"\s*var ")
    larger = rf"({words.size} * \1)"
    scaled = "\n".join(line if is_declared.match(line) else re.sub(inner, larger, line) for line in lines)
    scaled = re.sub(r"in \[(-?\d+), (\d+)\]", lambda m: f"in [{m[1]} / {words.size}, {m[2]} / {words.size}]", scaled)
    wide = re.compile(rf"(-?[\d.]+) <= ({names}) <= (-?[\d.]+)")
    start = wide.sub(lambda m: f"{m[1]} / {words.size} <= {m[2]} <= {m[3]} / {words.size}", start)
    modes = re.sub(inner, larger, modes)
    factor = dict.fromkeys(problem.states, f"{words.pace} / {words.size}")
    modes = re.sub(r"(\w+)' = (.*)", lambda m: f"{m[1]}' = {factor.get(m[1], words.pace)} * ({m[2]})", modes)
    claim = re.sub(inner, larger, claim)
    text = f"{scaled}\n  init {start}\n{modes}\n{claim}\n"
    for instant in problem.instants:
        text = re.sub(rf"(time (?:<=|>=)|within) {instant}\b", rf"\1 {instant} / {words.pace}", text)
    return re.sub(r"within (\d+) / (\d+)", lambda m: f"within {int(m[1]) / int(m[2])}", text)


def answer(problem: Problem, words: Words, claim: str, folder: Path) -> tuple[str, float | None]:
    """The verdict in one word, and the margin in the units of the plain problem."""
    path = folder / "said.ha"
    path.write_text(said(problem, words, claim), encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, (found, path.read_text(encoding="utf-8"))
    verdict = decide_all(spec)["p"].verdict
    word = "proved" if isinstance(verdict, Proved) else "refuted" if isinstance(verdict, Refuted) else "unknown"
    margin = getattr(verdict, "margin", None)
    return word, None if margin is None else float(margin.low)


PACED, SIZED = Words(pace=4), Words(size=8)
SWAPPED = Words(order=("b", "y2", "x2", "x1", "y1"))
TURNED = Words(order=("vy", "y", "x", "vx"))


def assert_same(problem: Problem, claim: str, others: list[Words], wanted: str, folder: Path) -> None:
    verdict, margin = answer(problem, Words(), claim, folder)
    assert verdict == wanted
    for words in others:
        other, its = answer(problem, words, claim, folder)
        assert other == verdict, words
        assert (its is None) == (margin is None)
        if margin is not None and its is not None:
            assert its == pytest.approx(margin, rel=0.1), words


# Where the answer is found soon: the bound is far from the runs, or clearly passed.
OSCILLATORS = [(1, "2.6", "proved"), (7, "2.5", "refuted")]


@pytest.mark.parametrize(("end", "bound", "wanted"), OSCILLATORS)
def test_coupled_oscillators_in_other_words(end: int, bound: str, wanted: str, tmp_path: Path) -> None:
    claim = f"property p on Coupled {{\n  within {end}\n  always y1 <= {bound}\n}}"
    assert_same(replace(VAN_DER_POL, instants=(end,)), claim, [PACED, SIZED, SWAPPED], wanted, tmp_path)


def test_a_rendezvous_in_other_words(tmp_path: Path) -> None:
    goal = "within 200\n  always at(Attempt) implies vx^2 + vy^2 <= 10.89"
    claim = f"property p on Chaser {{\n  {goal}\n}}"
    assert_same(SPACECRAFT, claim, [PACED, SIZED, TURNED], "proved", tmp_path)
