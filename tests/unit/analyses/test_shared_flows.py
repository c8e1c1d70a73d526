"""Claims share flowpipes: each is grown once, and what is said of a claim does not depend on the others."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from haverify import _kernel
from haverify.analyses.hybrid import shared
from haverify.analyses.hybrid.shared import Trees, at_once
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read

PENDULUM = """
spec "Pendulum" version "1.0" unitless
automaton A {
  var angle in [-2, 2]
  var rate
  init Swing where 0.9 <= angle <= 1 and rate == 0
  mode Swing { flow { angle' = rate; rate' = -sin(angle) - 0.2 * rate } }
}
"""
CLAIMS = {
    "low": "within 4; always angle <= 1.001",
    "late": "within 4; always during [1, 4] angle <= 0.7",
    "above": "within 4; always angle >= -0.75; expect proved",
    "deep": "within 4; always angle >= -0.5; expect refuted",
    "far": "within 4; can reach angle <= -0.9; expect refuted",
    "signal": "stl globally[0, 4] (rate <= 0.9)",
    "shorter": "within 2; always angle <= 1.001",
}


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("shared") / "pendulum.ha"
    claims = "".join(f"property {name} on A {{ {text} }}\n" for name, text in CLAIMS.items())
    path.write_text(PENDULUM + claims, encoding="utf-8")
    return path


def grown(path: Path, names: list[str]) -> tuple[int, dict[str, Any]]:
    """How many flowpipes of the whole set of starts were computed for some claims, and their verdicts."""
    spec, _, found = read(str(path))
    assert spec is not None, found
    original, wide = _kernel.reach, list[bool]()

    def reach(modes: Any, start: Any, *rest: Any) -> Any:
        wide.append(start[1][0][0] < start[1][0][1] - 1e-6)
        return original(modes, start, *rest)

    with patch.object(_kernel, "reach", reach):
        decided = decide_all(spec, names)
    return sum(wide), {name: e.verdict for name, e in decided.items()}


def test_one_flowpipe_serves_all_claims_up_to_the_same_instant(pendulum: Path) -> None:
    assert grown(pendulum, ["low"])[0] == 1
    assert grown(pendulum, ["low", "late", "above", "signal"])[0] == 1
    assert grown(pendulum, ["low", "shorter"])[0] == 2


def test_claims_are_answered_as_if_they_were_alone(pendulum: Path) -> None:
    _, together = grown(pendulum, list(CLAIMS))
    kinds = {name: type(verdict) for name, verdict in together.items()}
    assert kinds == {n: Refuted if n in ("deep", "far") else Proved for n in CLAIMS}
    for name, verdict in together.items():
        alone = grown(pendulum, [name])[1][name]
        assert type(alone) is type(verdict)
        if isinstance(verdict, Proved) and verdict.margin is not None:
            assert isinstance(alone, Proved) and alone.margin is not None
            assert float(verdict.margin.low) == pytest.approx(float(alone.margin.low), abs=1e-9)


def test_what_needs_too_much_memory_is_let_go() -> None:
    class Sized:
        def __init__(self, size: int) -> None:
            self.bytes = size

        def size(self) -> int:
            return self.bytes

    trees = Trees()
    made = [Sized(5_000_000) for _ in range(3)]
    for number, tree in enumerate(made):
        assert trees.get(number, lambda tree=tree: tree) == (tree, True)  # type: ignore[arg-type, misc, return-value]
    assert list(trees.known) == [1, 2]
    assert trees.size == 10_000_000
    assert trees.get(2, lambda: pytest.fail("it is known")) == (made[2], False)


CUT = """
spec "Cut" version "1.0" unitless
automaton A {
  var x in [-4, 4]
  var y
  init Run where 0.9 <= x <= 1.1 and 0.4 <= y <= 0.5
  mode Run { flow { x' = y; y' = (1 - x^2) * y - x } }
}
property high on A { within 3; always x <= 2; method taylor(cuts = 2) }
property touched on A { within 3; always x <= 1.15; method taylor(cuts = 2) }
"""


def told(path: Path, threads: int) -> dict[str, tuple[Any, ...]]:
    """All that is said of the claims where so many trees are grown at the same time."""
    spec, _, found = read(str(path))
    assert spec is not None, found
    with patch.object(shared, "THREADS", threads):
        decided = decide_all(spec)
    return {n: (e.verdict, e.certificate, e.cells, e.flowpipe, e.run) for n, e in decided.items()}


def test_threads_make_no_difference(tmp_path: Path) -> None:
    (tmp_path / "cut.ha").write_text(CUT, encoding="utf-8")
    one, two, three = (told(tmp_path / "cut.ha", threads) for threads in (1, 2, 3))
    assert isinstance(one["high"][0], Proved)
    assert not isinstance(one["touched"][0], Proved)
    assert one == two == three


def test_of_several_faults_the_first_is_raised() -> None:
    def fails(number: int) -> Any:
        def call() -> None:
            raise ValueError(number)

        return call

    with pytest.raises(ValueError, match="1"):
        at_once([lambda: None, fails(1), fails(2)])
    assert at_once([lambda: 1, lambda: 2]) == [1, 2]
