"""The registry: rules by folder, one message per cause, deterministic order."""

from haverify.diagnostics.codes import CATALOGUE
from haverify.lint._facts import Facts
from haverify.lint._registry import _checked, rules

FAMILY = """enum Phase { a, b, c }
automaton A {
  var x: s in [0 s, 2 s]
  init a with x := 0 s
  mode Run for p in Phase {
    domain x < 1 s
    flow { x' = 1 }
    urgent edge on: -> a when x >= 1 s do x := 0 s
  }
}"""


def test_every_rule_has_a_code_of_the_catalogue():
    assert rules().keys() <= CATALOGUE.keys()
    assert len(rules()) >= 25


def test_modes_written_by_one_text_share_a_finding(lint):
    (d,) = lint(FAMILY).of("HA205")
    assert d.notes[-1].startswith("also: ")


def test_the_order_is_that_of_codes_then_places(lint):
    found = lint(FAMILY).found
    keys = [(d.code, d.span.start if d.span else -1) for d in found]
    assert keys == sorted(keys)
    assert lint(FAMILY).found == found


def test_a_check_that_runs_too_deep_says_so():
    def deep(spec, facts):
        return deep(spec, facts)

    (d,) = _checked("HA201", deep, None, Facts(None))
    assert (d.code, d.message) == ("HA900", "HA201: an expression is nested too deeply for this check")
