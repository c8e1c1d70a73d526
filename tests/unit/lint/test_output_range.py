"""HA212 and HA213: outputs that leave their range, or jump."""


def two(rate: str, claim: str, offset: str = "0 deg") -> str:
    return f"""enum Half {{ first, second }}
fn place(h: Half): deg = if h is first then 0 deg else {offset}
automaton A {{
  var x: s in [0 s, 2 s]
  let y: deg = place(half) + x * {rate} deg/s
  init first with x := 0 s
  mode Run for half in Half {{ flow {{ x' = 1 }} }}
  schedule on x from 0 s {{ first until 1 s; second until 2 s then first do x := 0 s }}
}}
property p on A {{ {claim} }}"""


def test_the_range_in_the_slot_is_exact(lint):
    (d,) = lint(two("8", "always at(first) implies 0 deg <= y <= 5 deg; expect proved")).of("HA212")
    assert d.message == "`y` leaves its stated range in mode first"
    assert d.notes == ("`y` runs from 0 deg to 8 deg in mode first; stated 0 deg .. 5 deg by p",)


def test_an_output_inside_its_range(lint):
    assert lint(two("8", "always 0 deg <= y <= 16 deg; expect proved")).of("HA212") == []


def test_a_small_excess_that_is_expected_is_no_finding(lint):
    claim = "always at(first) implies 0 deg <= y <= {} deg; expect refuted"
    assert lint(two("8", claim.format(5))).of("HA212") == []
    assert lint(two("8", claim.format(3))).of("HA212")


def test_a_jump_larger_than_the_motion(lint):
    (d,) = lint(two("8", "always y <= 99 deg; expect proved", "50 deg")).of("HA213")
    assert d.message == "`y` jumps by 50 deg at edge first_second (first -> second), x = 1 s"


def test_a_jump_within_the_motion_or_with_a_stated_limit(lint):
    assert lint(two("8", "always y <= 99 deg; expect proved", "5 deg")).of("HA213") == []
    limited = "always jumped implies abs(y - pre(y)) <= 60 deg; expect proved"
    assert lint(two("8", limited, "50 deg")).of("HA213") == []
