"""HA403: flows that are undefined or jump."""

TEXT = """automaton A {
  var x: 1 in [-1, 1]
  init M with x := 0.5
  mode M { domain %s; flow { x' = %s } }
}"""


def test_a_divisor_that_may_be_zero(lint):
    (d,) = lint(TEXT % ("x >= 0", "1 Hz / x")).of("HA403")
    assert d.message == "mode M: the divisor is 0 at x = 0"
    assert lint(TEXT % ("x >= 0.1", "1 Hz / x")).of("HA403") == []


def test_a_divisor_guarded_by_a_condition(lint):
    assert lint(TEXT % ("x >= 0", "if x > 0.5 then 1 Hz / x else 2 Hz")).of("HA403") == []


def test_a_root_at_zero(lint):
    assert lint(TEXT % ("x >= 0", "sqrt(x) * 1 Hz")).of("HA403")
    assert lint(TEXT % ("x >= 0.01", "sqrt(x) * 1 Hz")).of("HA403") == []


def test_a_switch_that_jumps(lint):
    (d,) = lint(TEXT % ("x >= 0", "if x > 0.5 then 1 Hz else 2 Hz")).of("HA403")
    assert "the branches of `if` differ on its boundary at x = 0.5" in d.message
    assert lint(TEXT % ("x >= 0", "if x > 0.5 then x * 1 Hz else 0.5 Hz")).of("HA403") == []
