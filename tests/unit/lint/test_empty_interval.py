"""HA201: bounds in the wrong order."""


def clock(domain: str, edge: str, start: str = "0 s", tail: str = "") -> str:
    """A mode with one clock."""
    return f"""automaton A {{
  var x: s in [0 s, 2 s]
  init M with x := {start}
  mode M {{
    domain {domain}
    flow {{ x' = 1 }}
    {edge}
  }}
}}
{tail}"""


BACK = "urgent edge back: -> M when x >= 1 s do x := 0 s"


def test_backwards_domain_is_shown_at_the_upper_bound_with_the_distance(lint):
    found = lint(clock("1 s <= x <= 0.4 s", BACK))
    (d,) = found.of("HA201")
    assert found.at("HA201") == "0.4 s"
    assert d.label == "below the lower bound by 0.6 s"
    assert d.help == "as a range: `0.4 s <= x <= 1 s`"


def test_exchanging_the_bounds_removes_the_finding(lint):
    text = clock("1 s <= x <= 0 s", BACK)
    assert lint(lint(text).fixed("HA201")).of("HA201") == []


def test_strictness_travels_with_its_bound(lint):
    (d,) = lint(clock("x <= 1 s", BACK, tail="property p on A { always 1 s <= x < 0.5 s; expect refuted }")).of("HA201")
    assert d.help == "as a range: `0.5 s < x <= 1 s`"


def test_equal_bounds_are_empty_only_when_one_is_excluded(lint):
    assert lint(clock("x <= 1 s", BACK, tail="property p on A { always 1 s <= x <= 1 s }")).of("HA201") == []
    (d,) = lint(clock("x <= 1 s", BACK, tail="property p on A { always 1 s <= x < 1 s }")).of("HA201")
    assert "both bounds are 1 s" in d.message


def test_an_interval_of_a_param(lint):
    (d,) = lint("param a in [2, 1]\nproperty p { holds a <= 3 }").of("HA201")
    assert d.message == "empty interval for `a`: the lower bound is above the upper bound"


def test_bounds_in_different_units_are_compared_exactly(lint):
    assert lint("param a: rad in [1 rad, 3 rad]\nproperty p { holds 57 deg <= a <= 1 rad }").of("HA201") == []
    assert lint("param a: rad in [1 rad, 3 rad]\nproperty p { holds 58 deg <= a <= 1 rad }").of("HA201")


def test_bounds_of_a_disjunction_are_no_interval(lint):
    assert lint(clock("x <= 1 s", BACK, tail="property p on A { always x >= 1 s or x <= 0.5 s }")).of("HA201") == []
