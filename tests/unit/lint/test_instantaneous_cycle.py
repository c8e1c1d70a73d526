"""HA401 and HA402: cycles that take no time."""

ROCKING = """automaton A {
  var x: 1 in [-2, 2]
  var v: 1/s in [-9 Hz, 9 Hz]
  init L with { x := %s; v := 0 Hz }
  mode L { domain x <= 0; flow { x' = v; v' = 0 s^-2 }; edge hitR: -> R when x == 0 and v %s 0 Hz }
  mode R { domain x >= 0; flow { x' = v; v' = 0 s^-2 }; edge hitL: -> L when x == 0 and v <= 0 Hz }
}"""

BALL = """param c in [0.7, 0.8]
automaton Ball {
  var h: m
  var v: m/s
  init Fall with { h := 10 m; v := 0 m/s }
  mode Fall {
    domain h >= 0 m
    flow { h' = v; v' = -9.81 m/s^2 }
    urgent edge bounce: -> Fall when h <= 0 m and v < %s do v := -c * v
  }
}"""


def test_two_edges_that_enable_each_other(lint):
    (d,) = lint(ROCKING % ("0", ">=")).of("HA402")
    assert d.message == "edges hitR and hitL can fire in turn with no time passing"
    assert d.notes == ("at x = 0, v = 0 s^-1 every guard holds and the resets keep the point",)


def test_a_state_that_no_run_is_known_to_reach_is_a_risk(lint):
    found = lint(ROCKING % ("-1", ">="))
    assert found.of("HA402") == []
    assert "hitR, hitL may tend to 0" in found.of("HA401")[0].message


def test_one_strict_guard_breaks_the_cycle(lint):
    assert lint(ROCKING % ("0", ">")).of("HA402") == []


def test_a_ball_comes_to_rest_in_infinitely_many_bounces(lint):
    found = lint(BALL % "0 m/s")
    (d,) = found.of("HA401")
    assert d.message == (
        "Zeno risk: the time between jumps of bounce may tend to 0 as the state tends to h = 0 m, v = 0 m/s"
    )
    assert found.of("HA402") == []


def test_a_least_speed_bounds_the_bounces(lint):
    assert lint(BALL % "-0.1 m/s").of("HA401") == []


def test_clocks_that_are_set_back_are_no_zeno_risk(lint):
    text = """automaton A {
  var x: s
  init M with x := 0 s
  mode M { domain x <= 1 s; flow { x' = 1 }; urgent edge tick: -> M when x >= 1 s do x := 0 s }
}"""
    assert lint(text).of("HA401") == [] and lint(text).of("HA402") == []
