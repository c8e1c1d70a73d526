"""HA308: starts of which the domain cuts off a part."""

TEXT = """automaton A {
  var x: 1 in [-2, 2]
  init M where %s
  mode M { domain x <= 0; flow { x' = 0 Hz } }
}"""


def test_a_point_that_is_no_start_is_shown(lint):
    (d,) = lint(TEXT % "-1 <= x <= 0.25").of("HA308")
    assert d.message.startswith("init M of A is cut by the domain of mode M: x = ")


def test_a_start_inside(lint):
    assert lint(TEXT % "-1 <= x <= 0").of("HA308") == []


def test_a_start_outside_altogether_is_another_finding(lint):
    found = lint(TEXT % "0.1 <= x <= 0.2")
    assert found.of("HA308") == [] and found.of("HA307")


def test_time_is_zero_at_the_start(lint):
    assert lint((TEXT % "-1 <= x <= 0").replace("domain x <= 0", "domain x <= 0 and time <= 1 s")).of("HA308") == []
