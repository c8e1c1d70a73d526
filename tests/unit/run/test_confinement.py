"""An error in one claim or automaton costs what depends on it; any other error costs every verdict."""

from pathlib import Path

import pytest

from haverify.run.examine import Examined, examine

SPEC = """spec "Two" version "1.0"
param k in [1, 2]
automaton M {
  var x: s in [0 s, 2 s]
  init A with x := 0 s
  mode A { domain x <= 1 s; flow { x' = 1 } }
  urgent edge e: A -> A when x >= 1 s do x := 0 s
}
automaton N {
  var x: s in [0 s, 2 s]
  init A with x := 0 s
  mode A { domain x <= 1 s; flow { x' = 1 } }
  urgent edge e: A -> A when x >= 1 s do x := 0 s
}
assume k <= 1.5
property p on M { always k * x <= 2 s; expect proved }
property q on N { always x <= 1 s; expect proved }
"""


def examined(tmp_path: Path, old: str, new: str) -> Examined:
    assert SPEC.count(old) >= 1
    path = tmp_path / "m.ha"
    path.write_text(new.join(SPEC.rsplit(old, 1)), encoding="utf-8")
    return examine(str(path))


def test_an_intact_spec_has_a_meaning(tmp_path: Path) -> None:
    assert examined(tmp_path, "q on N", "q on N").has_meaning


@pytest.mark.parametrize(
    ("old", "new", "left"),
    [
        ("always x <= 1 s", "always xx <= 1 s", ["p"]),
        ("always x <= 1 s", "always x <= 1 m", ["p"]),
        ("when x >= 1 s", "when x >= 1 m", ["p"]),
        ("do x := 0 s", "do y := 0 s", ["p"]),
    ],
)
def test_an_error_in_a_claim_or_an_automaton_leaves_the_others(
    tmp_path: Path, old: str, new: str, left: list[str]
) -> None:
    e = examined(tmp_path, old, new)
    assert not e.has_meaning
    assert e.can_decide
    assert e.spec is not None
    assert [c.name for c in e.spec.claims] == left


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("assume k <= 1.5", "assume k <= 1.5 s"),
        ("param k in [1, 2]", "param k in [1, 2 s]"),
        ("param k in [1, 2]", "param k in [1, 2]\nparam k in [1, 2]"),
        ("always x <= 1 s", "always x <= "),
        ("when x >= 1 s do", "when x >= do"),
        ('version "1.0"', 'version "1.0"\nimport "none.ha"'),
        ("property q on N", "property p on N"),
    ],
)
def test_any_other_error_leaves_none(tmp_path: Path, old: str, new: str) -> None:
    e = examined(tmp_path, old, new)
    assert not e.has_meaning
    assert not e.can_decide
