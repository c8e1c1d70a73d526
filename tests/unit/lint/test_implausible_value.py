"""HA108: angles in rad that look like degrees."""


def spec(low: str, claim: str = "always knee <= 3 rad") -> str:
    return f"""automaton A {{
  var knee: rad in [{low}, 3 rad]
  init M with knee := 0 rad
  mode M {{ domain knee >= -1 rad; flow {{ knee' = -1 rad/s }} }}
}}
property p on A {{ {claim} }}
"""


def test_many_turns_are_few_degrees(lint):
    found = lint(spec("-83 rad"))
    (d,) = found.of("HA108")
    assert d.message == "-83 rad is 13.2099 turns; is it in degrees?"
    assert "[-83 deg, 3 rad]" in found.fixed("HA108")


def test_claims_are_read_too(lint):
    assert lint(spec("-2 rad", "always knee <= 45 rad")).at("HA108") == "45 rad"


def test_a_turn_or_two_and_thousands_are_as_written(lint):
    for low in ("-12 rad", "-83 deg", "-5000 rad"):
        assert lint(spec(low)).of("HA108") == []
