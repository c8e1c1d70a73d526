"""HA311: counters past their range."""

TEXT = """enum Gear = 1..4
automaton A {
  var gear: Gear
  init M with gear := 1
  mode M { edge up: -> M%s do gear := gear + 1; edge down: -> M when gear > 1 do gear := gear - 1 }
}"""


def test_the_last_value_is_shown_with_the_guard_to_add(lint):
    (d,) = lint(TEXT % "").of("HA311")
    assert d.message == "edge up (M -> M): `gear := gear + 1` leaves Gear (1..4)"
    assert d.notes == ("from gear = 4",)
    assert d.help == "add `and gear < 4` to the guard"


def test_a_guarded_counter(lint):
    assert lint(TEXT % " when gear < 4").of("HA311") == []
