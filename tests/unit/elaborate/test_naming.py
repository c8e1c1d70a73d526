"""Names of the core: one name means one thing, whatever hides what in the text."""

from tests.unit.elaborate.texts import healthy, read

from haverify.model.core import to_core

AUTOMATON = "automaton A {{ {} var z; init M with z := 0; mode M {{ flow {{ z' = {} }} }} }}\n"


def flow(spec, k=0):
    return to_core(spec)["automata"][k]["modes"][0]["flow"][0]["rate"]


def test_what_hides_has_a_name_of_its_own():
    text = 'spec "t" version "1.0" unitless\nparam k in [1, 2]\nconst c = 2 * k\n'
    for own in ("param k in [3, 4];", "const k = 3;", "input k in [3, 4];", "let k = 3;"):
        spec = healthy(text + AUTOMATON.format(own, "c * k"))
        product = flow(spec)
        assert product[1] == ["const", "c"] and product[2][1] == "A_k", own
        assert to_core(spec)["constants"][0]["value"] == ["*", "2", ["param", "k"]]


def test_a_variable_that_hides_a_param_is_another_quantity():
    text = 'spec "t" version "1.0" unitless\nparam z in [1, 2]\nconst c = 2 * z\n' + AUTOMATON.format("", "c * z")
    a = to_core(healthy(text))["automata"][0]
    assert [v["name"] for v in a["vars"]] == ["A_z"]
    assert a["modes"][0]["flow"] == [{"var": "A_z", "rate": ["*", ["const", "c"], ["var", "A_z"]]}]


def test_members_of_a_family_that_hides_are_one_family():
    text = """spec "t" version "1.0" unitless
enum Leg { left, right }
param k in [1, 2]
const lift = k
automaton A {
  const k[left] = 1
  const k[right] = 2
  var z
  init M with z := 0
  mode M { flow { z' = lift + sum(k[i] for i in Leg) } }
}
"""
    assert [c["name"] for c in to_core(healthy(text))["automata"][0]["constants"]] == ["A_k[left]", "A_k[right]"]


def test_names_that_are_taken_are_not_given():
    text = 'spec "t" version "1.0" unitless\nparam k in [1, 2]\nparam A_k in [5, 6]\nconst c = k\n'
    assert flow(healthy(text + AUTOMATON.format("param k in [3, 4];", "c * k + A_k"))) == [
        "+", ["*", ["const", "c"], ["param", "A_k_2"]], ["param", "A_k"],
    ]  # fmt: skip


def test_a_sample_does_not_take_the_name_of_a_param():
    text = 'spec "t" version "1.0" unitless\nparam tick_clock in [1, 2]\n'
    text += AUTOMATON.format("sample tick every 1 do z := 0;", "tick_clock")
    assert [v["name"] for v in to_core(healthy(text))["automata"][0]["vars"]] == ["z", "tick_clock_2"]


SYSTEM = """spec "t" version "1.0" unitless
param k in [1, 2]
const c = k
automaton A { param k in [3, 4]; var z; init M with z := 0; mode M { flow { z' = c * k } } }
system S { param k in [5, 6]; part a = A with { k = k } }
"""


def test_bindings_say_which_name_they_bind():
    s = to_core(healthy(SYSTEM))["systems"][0]
    assert [p["name"] for p in s["params"]] == ["S_k"]
    assert s["parts"][0]["bindings"] == [{"name": "A_k", "to": ["param", "S_k"]}]


def test_claims_mean_what_is_nearest():
    claims = "property p on S { always a.k == k }\nproperty q on A { for which k in [3, 4]; always k >= 3 }"
    spec = healthy(SYSTEM + claims)
    core = to_core(spec)["claims"]
    assert core[0]["goals"][0]["condition"] == ["==", ["param", "a.A_k"], ["param", "S_k"]]
    assert core[1]["which"][0]["name"] == "A_k"


def test_a_port_that_hides_is_bound_under_its_name():
    text = 'spec "t" version "1.0" unitless\nparam u in [1, 2]\nconst c = u\n' + AUTOMATON.format("input u;", "c * u")
    _, found, _ = read(text + "system S { part a = A }")
    assert [d.message for d in found] == ["port 'u' of part a is bound to nothing"]
    assert to_core(healthy(text + "system S { part a = A with { u = u } }"))["systems"][0]["parts"][0]["bindings"]
