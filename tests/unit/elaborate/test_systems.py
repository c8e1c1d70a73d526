"""Systems, fuzzy systems and networks: what may go wrong, and where it is said."""

import pytest
from tests.unit.elaborate.texts import healthy, marked, read

A = "automaton A { var x: s; init M with x := 0 s; mode M { flow { x' = 1 }; edge go: -> M } }\n"
F = "fuzzy F { input a over [0, 1] { yes = ramp(0, 1) }; output o { low }; rule a is yes => o is low }\n"

INDEXED = """
enum I = 1..2
automaton B { var x: s; init M with x := 0 s; mode M { flow { x' = 1 }; edge go for i in I: -> M } }
"""
CONSTANT = "automaton K { const k = 1 Hz; var x: 1; init M with x := 0; mode M { flow { x' = k } } }\n"


def fuzzy(terms: str, rule: str = "a is y => o is x") -> str:
    return f"fuzzy G {{ input a over [0, 1] {{ {terms} }}; output o {{ x }}; rule {rule} }}"


FINDINGS = {
    "own variable without a flow": ("HA007", "system S { var «y»: s; part a = A; init with y := 0 s }"),
    "unknown automaton": ("HA002", "system S { part a = «B» }"),
    "part twice": ("HA004", "system S { part a = A; «part a = A» }"),
    "nothing of that name to bind": ("HA002", "system S { part a = A with { «z = 1» } }"),
    "unknown edge": ("HA002", "system S { part a = A; sync e: «a.stop» }"),
    "unknown mode of a part": ("HA002", "system S { part a = A }\nproperty p on S { always at(«a.N») }"),
    "a system has no modes of its own": ("HA002", "system S { part a = A }\nproperty p on S { always at(«M») }"),
    "a family of edges in a sync": ("HA105", INDEXED + "system S { part b = B; sync e: «b.go» }"),
    "unknown shape": ("HA002", fuzzy("«y = wave(0, 1)»")),
    "corners": ("HA105", fuzzy("«y = tri(0, 1)»")),
    "unknown term": ("HA002", fuzzy("y = ramp(0, 1)", "a is «z» => o is x")),
    "unknown input in a claim": ("HA002", F + "property p on F { holds covered(«b», 0.5) }"),
    "unknown term in a claim": ("HA002", F + "property p on F { holds strength(«high») > 0.5 }"),
    "constant bound to a range": ("HA105", CONSTANT + "automaton L = K with { «k in [0 Hz, 1 Hz]» }"),
}


@pytest.mark.parametrize("name", FINDINGS)
def test_finding_points_at_its_place(name: str) -> None:
    code, text = FINDINGS[name]
    inside, found = marked(A + text)
    assert [f for f in found if f[0] != "HA005"] == [(code, inside)]


def test_parallel_composition_of_one_automaton_with_itself_defines_a_part_twice() -> None:
    _, found, _ = read(A + "system S = A || A")
    assert [(d.code, d.message) for d in found] == [("HA004", "part 'A' is defined twice")]


def test_parallel_composition_syncs_edges_of_one_name() -> None:
    spec = healthy(A + A.replace("automaton A", "automaton B") + "system S = A || B sync go")
    assert [(p.name, p.of) for p in spec.systems[0].parts] == [("A", "A"), ("B", "B")]
    assert [(y.name, y.edges) for y in spec.systems[0].syncs] == [("go", ("A.go", "B.go"))]


def test_a_network_is_a_function_and_a_subject() -> None:
    text = 'network N from "n.onnx" { input a: m; output b: s }\nproperty p on N { holds b > 1 s and a > 1 mm }'
    spec = healthy(text, {"n.onnx": ""})
    (goal,) = spec.claims[0].goals
    assert [e.op for c in goal.condition.children for e in c.children] == ["netoutput", "num", "netinput", "num"]
    assert spec.networks[0].inputs[0][0] == "a"
