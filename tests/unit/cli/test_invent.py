"""`haverify invent`."""

from collections.abc import Callable

from tests.unit.cli.conftest import Said

Call = Callable[..., Said]
Write = Callable[[str, str], str]

SPEC = """spec "Decay" version "1.0"
automaton Decay {
  var x: m
  init Run where 1 m <= x <= 2 m
  mode Run { flow { x' = -x * 1 Hz } }
}
property positive on Decay { always x > -1 m; expect proved }
"""


def test_what_is_found_can_be_pasted(haverify: Call, write: Write) -> None:
    said = haverify("invent", write("m.ha", SPEC), "-p", "positive")
    assert said.code == 0
    pasted = haverify("check", write("n.ha", SPEC + said.out.replace("inductive", "inductive expect proved")))
    assert (pasted.code, "2 proved" in pasted.out) == (0, True)


def test_what_is_false_is_not_found(haverify: Call, write: Write) -> None:
    said = haverify("invent", write("m.ha", SPEC.replace("x > -1 m", "x > 1 m")), "--seconds", "1")
    assert (said.code, "nothing found" in said.out) == (3, True)


def test_a_claim_that_is_not_there(haverify: Call, write: Write) -> None:
    assert haverify("invent", write("m.ha", SPEC), "-p", "positiv").code == 2
