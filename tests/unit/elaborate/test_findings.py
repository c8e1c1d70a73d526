"""Each finding of elaboration once, with the place it points at: the text between the marks."""

import pytest
from tests.unit.elaborate.texts import marked, read

BALL = """
automaton A {
  var x: m
  init M with x := 0 m
  mode M { flow { x' = 1 m/s } }
  %s
}
property p on A { %s }
"""


def ball(member: str = "", claim: str = "always x >= 0 m") -> str:
    return BALL % (member, claim)


FINDINGS = {
    "unknown name": ("HA002", "const a = 1\nconst b = a + «aa»"),
    "unknown unit": ("HA002", "const a«: metre» = 1"),
    "unknown mode": ("HA002", ball("edge e: M -> «N»")),
    "unknown variable in a reset": ("HA002", ball("edge e: M -> M do «z» := 1 m")),
    "unknown edge": ("HA002", ball(claim="always not jump(«e»)")),
    "unknown column": (
        "HA002",
        ball(claim="always «A.y» > 1 m"),
    ),
    "constant twice": ("HA004", "const a = 1\nconst «a» = 2"),
    "mode twice": ("HA004", ball("mode «M» { flow { x' = 1 m/s } }")),
    "two assignments": ("HA004", ball("edge e: M -> M do { x := 1 m; «x := 2 m» }")),
    "claim twice": ("HA004", ball() + "property «p» on A { always x >= 1 m }"),
    "value twice": ("HA004", "enum E { a, b, «a» }"),
    "no flow": ("HA007", ball("mode «N» { terminal }")),
    "circle of constants": ("HA008", "const «a» = b\nconst b = a"),
    "function in itself": ("HA008", "fn f(x) = «f(x)»\nconst a = f(1)"),
    "circle of outputs": ("HA008", ball("let «l» = k\n  let k = l")),
    "index outside": ("HA009", "enum I = 1..3\nconst c for i in I = 2\nconst d = c[«4»]"),
    "index of another kind": ("HA009", "enum I = 1..3\nconst c for i in I = 2\nconst d = c[«true»]"),
    "sum of m and s": ("HA101", "const a = 1 m + «2 s»"),
    "comparison of m and a number": ("HA101", ball(claim="always «x <= 2»")),
    "deg and a plain number": ("HA101", "const a = 1 deg + «2»"),
    "declared unit": ("HA101", "const a: m = «1 s»"),
    "sin of a number": ("HA102", "const a = sin(«30»)"),
    "flow not per second": ("HA103", ball("mode N { flow { x' = «1 m» } }")),
    "exp of a length": ("HA104", "const a = exp(«2 m»)"),
    "exponent with a unit": ("HA104", "const a = 2^«(1 s)»"),
    "number for truth": ("HA105", ball(claim="always «x»")),
    "order of an enumeration": (
        "HA105",
        "enum E { a, b }\nfn f(e: E): bool = «e < a»\nproperty p { holds forall e in E: f(e) implies 1 < 2 }",
    ),
    "interval as a number": ("HA105", "const c = [1, 2]\nconst d = «c» + 1"),
    "too large": ("HA105", "const a = 2^«9^9^9»"),
    "division by zero": ("HA403", "const a = «1 / (2 - 2)»"),
    "stl outside stl": ("HA105", ball(claim="always «eventually[0 s, 1 s] x >= 0 m»")),
    "a horizon before 0 s": ("HA105", ball(claim="within «-1 min»; always x >= 0 m")),
    "a window before 0 s": ("HA105", ball(claim="always during [«-2 s», -1 s] x >= 0 m")),
    "a time before 0 s": ("HA105", ball(claim="reach x >= 2 m within «0 s - 1 s»")),
    "an stl window before 0 s": ("HA105", ball(claim="stl eventually[«-1 s», 1 s] x >= 0 m")),
    "very many jumps": ("HA105", ball(claim="within «1e400» jumps; always x >= 0 m")),
    "a part of a jump": ("HA105", ball(claim="within 1 s, «1.5» jumps; always x >= 0 m")),
    "a very long name": ("HA001", ball() + f"property «{'q' * 101}» on A {{ always x >= 1 m }}"),
    "schedule of no length": ("HA203", ball("schedule on x from 0 m { M until 2 m; M until «2 m» }")),
    "schedule backwards": ("HA203", ball("schedule on x from 0 m { M until 2 m; M until «1 m» }")),
    "bits of another width": (
        "HA504",
        "enum A { a = 0b0, b = 0b1 }\nenum B { c = 0b0, d = 0b1 }\n"
        "cellular C { cell K = A ++ B; rule «0b101» -> 0b00 }",
    ),
    "no such cell": (
        "HA504",
        "enum A { a = 0b0, b = 0b1 }\nenum B { c = 0b00, d = 0b01 }\n"
        "cellular C { cell K = A ++ B; rule 0b001 -> «0b011» }",
    ),
    "output of one mode": (
        "HA601",
        ball("mode N { let k = x; flow { x' = 1 m/s } }", "always «k» <= 1 m"),
    ),
    "output read in another mode": (
        "HA601",
        ball("mode N { let k = x; flow { x' = 1 m/s } }\n  edge e: M -> N when «k» >= 1 m"),
    ),
    "using a property": ("HA608", ball() + "property q on A { using «p»; always x >= 0 m }"),
    "no start": ("HA307", "automaton «A» { var x: m; mode M { flow { x' = 1 m/s } } }"),
    "never read": ("HA005", "const «k» = 1\n" + ball()),
    "name of a unit": ("HA107", "const s = 2\n" + BALL.replace("1 m/s", "«1 m/s»") % ("", "always x * s >= 0 m")),
    "unit in a unitless file": ("HA101", 'spec "t" version "1.0" unitless\nconst a = «5 m»'),
    "port unbound": (
        "HA105",
        "automaton A { input u: m; var x: m; init M with x := 0 m; mode M { flow { x' = u * 1 Hz } } }\n"
        "system S { «part a = A» }",
    ),
    "ports in a circle": (
        "HA008",
        "automaton A { input u: m; let y = 2 * u; var x: m; init M with x := 0 m; mode M { flow { x' = u * 1 Hz } } }\n"
        "system S { part a = A with { «u = b.y» }; part b = A with { u = a.y } }",
    ),
}


@pytest.mark.parametrize("name", FINDINGS)
def test_finding_points_at_its_place(name: str) -> None:
    code, text = FINDINGS[name]
    inside, found = marked(text)
    at = [place for c, place in found if c == code]
    assert at == [inside.removeprefix(": ")] or at == [inside], found
    errors = [c for c, _ in found if c not in ("HA005", "HA107")]
    assert len(errors) <= 1


def test_one_cause_one_message_and_the_rest_goes_on() -> None:
    spec, found, _ = read(ball("edge e: M -> Nowhere") + "const good = 2\nproperty q { holds good > 1 }")
    assert [d.code for d in found] == ["HA002"]
    assert [c.name for c in spec.claims] == ["q"]
    assert [(name, reason) for name, _, reason in spec.lost] == [("p", "A has errors")]


def test_did_you_mean_has_a_fix() -> None:
    _, found, _ = read("const theta = 1 rad\nconst a = sin(tetha)")
    assert found[0].message == "no name 'tetha'; did you mean 'theta'?"
    assert found[0].fix is not None and found[0].fix.edits[0].text == "theta"


def test_a_family_of_claims_with_one_error_reports_it_once() -> None:
    spec, found, _ = read("enum I = 1..3\nproperty p for i in I { holds nothing > i }")
    assert [d.code for d in found] == ["HA002"]
    assert [name for name, _, _ in spec.lost] == ["p[1]", "p[2]", "p[3]"]
    assert len({reason for _, _, reason in spec.lost}) == 1


@pytest.mark.parametrize("text", ["9^9^9^9", "2^(10^9)", "1e400^1000", "(1/3)^9999999", "10^-5000", "(0 - 2)^(10^9)"])
def test_huge_numbers_are_refused_at_once(text: str) -> None:
    spec, found, _ = read(f"const a = {text}")
    assert [d.code for d in found] == ["HA105"]
    assert spec.constants == ()


def test_a_long_chain_of_definitions_is_a_finding() -> None:
    text = "\n".join(f"const c{i} = c{i + 1}" for i in range(700)) + "\nconst c700 = 1"
    _, found, _ = read(text)
    assert {d.code for d in found} == {"HA008"}


def test_long_sums_and_conjunctions_are_flat() -> None:
    text = " - ".join(["x"] * 3000)
    spec, found, _ = read(f"const x = 1 m\nconst a = {text}\nproperty p {{ holds {' and '.join(['x > 0 m'] * 3000)} }}")
    assert found == []
    assert len(spec.constants[1].value.args) == 3000
    assert len(spec.claims[0].goals[0].condition.args) == 3000


GROWING = {
    "doubling functions": "param x in [0, 1]\nfn f0(a) = a * a + 1\n"
    + "\n".join(f"fn f{k}(a) = f{k - 1}(f{k - 1}(a))" for k in range(1, 40))
    + "\nconst y = 2\nproperty p { holds f39(x) > y }",
    "sums that double": "param x in [0, 1]\n"
    + "fn d0(a) = a + a\n"
    + "\n".join(f"fn d{k}(a) = d{k - 1}(a) + d{k - 1}(a)" for k in range(1, 40))
    + "\nproperty p { holds d39(x) > 1 }",
    "nested quantifiers": "enum I = 1..60\nproperty p { holds forall i in I: forall j in I: forall k in I: i + j > k }",
    "unique over many": "enum I = 1..5000\nparam x for i in I in [0, 1]\nproperty p { holds unique i in I: x[i] > 0 }",
    "an index of many cases": "enum I = 1..5000\nparam x for i in I in [0, 1]\nautomaton A { var k: I; var z: 1; "
    "init M with { k := 1; z := 0 }; mode M { flow { z' = 1 Hz } } }\nproperty p on A { always x[k] <= 1 }",
}


@pytest.mark.parametrize("name", GROWING)
def test_what_few_lines_grow_into_is_bounded(name: str) -> None:
    spec, found, _ = read(GROWING[name])
    assert [d.code for d in found] == ["HA105"]
    assert [claim for claim, _, _ in spec.lost] == ["p"]
