"""HA602, HA603, HA604, HA606, HA607: claims that say less than they seem to."""


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


def claim(body: str) -> str:
    return clock("x <= 1 s", BACK, tail=f"property p on A {{ {body} }}")


def test_a_premise_that_is_never_true(lint):
    found = lint(claim("always x > 1.5 s implies x <= 0.5 s; expect proved"))
    assert found.at("HA602") == "x > 1.5 s"
    assert lint(claim("always x > 0.5 s implies x <= 0.5 s; expect refuted")).of("HA602") == []


def test_a_premise_about_jumps(lint):
    assert lint(claim("always jump(back) implies x == 0 s; expect proved")).of("HA602") == []
    assert lint(claim("always jump(back) and x > 0.1 s implies x == 0 s; expect proved")).of("HA602") == []


def test_assumptions_that_clash(lint):
    text = "param a in [0, 9]\nproperty p {{ assume a <= 4; assume a >= {}; holds a <= 5; expect proved }}"
    (d,) = lint(text.format(5)).of("HA603")
    assert d.message == "contradictory assumptions: `a <= 4` and `a >= 5` cannot hold together"
    assert lint(text.format(4)).of("HA603") == []


def test_an_assumption_that_clashes_with_a_declared_range(lint):
    text = "param a in [0, 9]\nproperty p { assume a >= 10; holds a <= 5; expect proved }"
    assert [d.code for d in lint(text).found] == ["HA202"]


def test_a_claim_that_follows_from_the_domains(lint):
    assert lint(claim("always x <= 1 s; expect proved")).of("HA604")
    assert lint(claim("always x < 1 s; expect refuted")).of("HA604") == []


def test_a_horizon_shorter_than_the_goals(lint):
    (d,) = lint(claim("within 1 s; reach x >= 1 s within 2 s; expect proved")).of("HA606")
    assert d.message == "property p: the horizon 1 s ends before the goal's 2 s"
    assert lint(claim("within 2 s; reach x >= 1 s within 2 s; expect proved")).of("HA606") == []


def test_a_claim_without_expectation(lint):
    assert lint(claim("always x >= 0 s")).of("HA607")[0].message == "property p has no `expect`"
    assert lint(claim("always x >= 0 s; expect proved")).of("HA607") == []


def test_a_claim_without_a_value_somewhere_follows_from_nothing(lint):
    assert lint(claim("always 0 s * log(x / 1 s) <= 1 s; expect proved")).of("HA604") == []
