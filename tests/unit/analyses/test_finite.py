"""Goals about cells, relations and params: verdicts, witnesses, what is told, orbits."""

from collections.abc import Callable
from fractions import Fraction

import networkx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.analyses.finite_orbits import orbits, orbits_of
from haverify.analyses.finite_params import points
from haverify.analyses.portfolio import decide_all
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.cellular import CellularAutomaton, Rule
from haverify.model.spec import EnumType, Spec
from haverify.solvers.finite_world import World
from haverify.syntax.parse import parse
from haverify.text.record import replace
from haverify.text.source import Source

LEGS = """enum Leg { Left = 0b0, Right = 0b1 }
enum Sub { IC = 0b00, LR = 0b01, MS = 0b10 }
"""
PARTNER = (
    LEGS
    + """cellular Partner {
  cell Cell = Leg ++ Sub
  rule (Left, IC) -> (Right, MS)
  rule (Left, LR) -> (Right, LR)
  rule (Left, MS) -> (Right, IC)
  rule 0b100 -> 0b010
  rule 0b101 -> 0b001
  rule 0b110 -> 0b000
}
relation Text { IC -> MS; LR -> LR; MS -> LR }
"""
)


def spec_of(text: str) -> Spec:
    source = Source.of_text("test.ha", f'spec "Test" version "1.0"\n{text}\n')
    tree, _ = parse(source)
    spec, found = elaborate(tree, Files({source.path: source}))
    assert spec is not None, found
    return spec


def decided(goal: str, head: str = PARTNER, on: str = " on Partner", extra: str = "") -> Evidence:
    """The evidence for one goal."""
    return decide_all(spec_of(f"{head}property p{on} {{ {extra} holds {goal} }}"))["p"]


def told(e: Evidence) -> str:
    (fact,) = e.parts[0].facts
    return fact


def reason(e: Evidence) -> str:
    assert isinstance(e.verdict, Unknown)
    return f"{e.verdict.kind}: {e.verdict.reason}"


TRUE_GOALS = [
    "forall c in Cell: defined(next(c)) and unique_rule(c)",
    "forall c in Cell: next(next(c)) == c and next(c) != c",
    "forall c in Cell: next(c).leg != c.leg",
    "next((Left, IC)) is (Right, MS)",
    "next(0b000) is 0b110 and not (next(0b000) is 0b100)",
    "forall c in Cell: c is (Left, IC) or c is (Left, LR) or c is (Left, MS) or c.leg is Right",
    "exists c in Cell: c.sub is MS and next(c).sub is IC",
    "unique c in Cell: c.leg is Left and c.sub == next(c).sub",
    "not (unique c in Cell: c.leg is Left)",
    "forall c in Cell: forall d in Cell: next(c) == next(d) implies c == d",
    "forall c in Cell: unique d in Cell: next(d) == c",
    "forall c in Cell: (if c.leg is Left then next(c).leg is Right else next(c).leg is Left)",
    "forall c in Cell: defined(next(c)) == unique_rule(c)",
    "forall l in Leg: exists c in Cell: c.leg == l and c.sub is MS",
    "forall s in Sub: related(Text, s)",
    "Text(IC) is MS and not defined(Text(Text(MS))) or Text(Text(MS)) is LR",
    "forall c in Cell: forall c in Cell: next(next(c)) == c",
    "sum(if related(Text, s) then 1 else 0 for s in Sub) == 3",
    "min(2, 3) < max(2, 3) and abs(-2) == 2 and clamp(5, 0, 1) == 1 and 2^3 == 8 and 1 / 4 < 0.3",
]


@pytest.mark.parametrize("goal", TRUE_GOALS)
def test_what_is_true_is_proved_and_its_negation_refuted(goal: str) -> None:
    assert isinstance(decided(goal).verdict, Proved)
    assert isinstance(decided(f"not ({goal})").verdict, Refuted)


def test_a_cell_that_refutes() -> None:
    e = decided("forall c in Cell: c.leg is Right implies next(c).sub == Text(c.sub)")
    assert isinstance(e.verdict, Refuted)
    assert e.witness == (("c", "Right MS (0b110)"),)
    assert told(e) == "1 of 3 fail: Right MS (0b110): Partner.next(c).sub is IC and Text(c.sub) is LR"
    assert e.certificate is not None
    assert e.certificate["goals"][0]["values"] == [["c", "110"]]


def test_two_cells_that_refute() -> None:
    e = decided("forall c in Cell: forall d in Cell: c.sub == d.sub implies c == d")
    assert e.witness == (("c", "Left IC (0b000)"), ("d", "Right IC (0b100)"))
    assert told(e).startswith("6 of 6 fail: Left IC (0b000); ")


def test_a_cell_that_proves() -> None:
    e = decided("exists c in Cell: c.leg is Right and next(c).sub is IC")
    assert e.witness == (("c", "Right MS (0b110)"),)


def test_members_of_an_enumeration_that_fail() -> None:
    e = decided("forall s in Sub: Text(s) == s")
    assert told(e) == "2 of 3 fail: Text(IC) is MS; Text(MS) is LR"


def test_many_failing_cells_are_counted() -> None:
    names = ", ".join(f"A{k}" for k in range(20))
    head = f"enum Leg {{ Left, Right }}\nenum A {{ {names} }}\ncellular Q {{ cell Cell = Leg ++ A; next(c) = c }}\n"
    e = decided("forall c in Cell: next(c) != c", head, " on Q")
    assert told(e).startswith("40 of 40 fail: Left A0 (0b000000): ")
    assert told(e).endswith("; and 24 more")


def test_what_is_undefined() -> None:
    head = PARTNER.replace("  rule (Left, LR) -> (Right, LR)\n", "")
    e = decided("forall c in Cell: next(next(c)) == c", head)
    assert reason(e) == "undefined: Partner.next(c) has no value for c = Left LR (0b001)"
    relation = LEGS + "relation R { (IC, LR); (IC, MS) }\n"
    assert reason(decided("R(IC) is LR", relation, "")) == "undefined: R(IC) has no value"
    assert isinstance(decided("forall s in Sub: not defined(R(s))", relation, "").verdict, Proved)


def test_a_premise_that_is_never_true() -> None:
    e = decided("forall c in Cell: c.leg is Left and c.leg is Right implies next(c) == c")
    assert reason(e) == "vacuous: the premise is never true"
    e = decided("forall s in Sub: Text(s) is IC implies related(Text, s)")
    assert reason(e) == "vacuous: the premise is never true"
    assert isinstance(decided("Text(IC) is LR implies Text(IC) is MS").verdict, Proved)


def test_codes_that_clash() -> None:
    head = "enum Leg { Left = 0b0, Right = 0b0 }\nenum A { B, C }\ncellular Q { cell Cell = Leg ++ A; next(c) = c }\n"
    e = decided("forall c in Cell: next(c) == c", head, " on Q")
    assert reason(e).startswith("fragment: two values of Leg have one code, or codes of different lengths")


@pytest.mark.parametrize(
    ("extra", "goal", "said"),
    [
        ("for which m in [6, 7];", "m < 9", "fragment: `for which` needs a split"),
        ("method taylor(order = 3);", "m < 9", "fragment: `method taylor` does not decide goals without time"),
        ("assume m > 9;", "m < 9", "vacuous: no values of the params were found"),
        (
            "",
            "forall c in Cell: c.leg is Left implies m < 9",
            "fragment: it depends on the param m, in a goal about cells",
        ),
        ("", "sqrt(m) < 9", "fragment: the claim reads `sqrt(...)`"),
        ("", "1 / (m - 7) < 2 or 1 / (m - 7) >= 2", "undefined: something in it has no value for m = 7"),
    ],
)
def test_what_is_not_decided(extra: str, goal: str, said: str) -> None:
    assert reason(decided(goal, PARTNER + "param m in [6, 8]\n", extra=extra)).startswith(said)


@pytest.mark.parametrize(
    ("goal", "verdict"),
    [
        ("m^2 <= 64", Proved), ("m^2 < 64", Refuted), ("m * k <= 8 and m + k >= 6", Proved),
        ("(m - 7)^2 > 0 or k >= 0", Proved), ("m > 6.5", Refuted), ("min(m, 7) <= 7", Proved),
        ("m * pi < 26", Proved), ("m * pi > 26", Refuted), ("pi > 3.14 and pi < 3.15", Proved), ("pi > 3.15", Refuted),
        ("if m > 7 then m^2 > 49 else m^2 <= 49", Proved), ("abs(m - 7) <= 1 and max(m, 8) == 8", Proved),
    ],
)  # fmt: skip
def test_goals_about_params(goal: str, verdict: type) -> None:
    e = decided(goal, "param m in [6, 8]\nparam k in [0, 1]\n", "")
    assert isinstance(e.verdict, verdict)


def test_a_bound_that_an_assumption_just_reaches() -> None:
    head = "param m in [6, 8]\nparam k in [0, 1]\n"
    assert isinstance(decided("m + m * k >= 7", head, "", "assume m >= 7;").verdict, Proved)
    assert isinstance(decided("m + m * k > 7", head, "", "assume m >= 7;").verdict, Refuted)


def test_values_of_params_that_refute_are_shown_with_units() -> None:
    e = decided("m * 2 < 14 kg", "param m: kg in [6 kg, 8 kg] default 6.5 kg\n", "")
    assert e.witness == (("m", "7 kg"),)


def test_points_are_inside_and_begin_with_the_usual_one() -> None:
    spec = spec_of("param m in [6, 8] default 7.5\nparam k in [0, 1]")
    found = list(points(spec, None))
    assert found[0] == {"m": Fraction(15, 2), "k": Fraction(1, 2)}
    assert all(6 <= p["m"] <= 8 and 0 <= p["k"] <= 1 for p in found)
    assert {"m": 6, "k": 0} in found
    assert {"m": 8, "k": 1} in found


# ---- orbits -----------------------------------------------------------------------------------


def world_of(steps: dict[int, int], count: int) -> World:
    """An automaton on 2 * count cells; left and right halves are numbered one after the other."""
    enums = (
        EnumType("Leg", ("L", "R"), (None, None)),
        EnumType("Sub", tuple(f"S{k}" for k in range(count)), (None,) * count),
    )
    spec = Spec("t", "1.0", False, (), enums, (), (), (), (), (), (), (), (), (), (), (), (), ())
    bare = CellularAutomaton("Q", "Cell", "Leg", "Sub", ())
    cells = World(_with(spec, bare)).cells("Cell").cells
    rules = tuple(Rule(cells[a][1], cells[b][1]) for a, b in steps.items())
    return World(_with(spec, CellularAutomaton("Q", "Cell", "Leg", "Sub", rules)))


def _with(spec: Spec, automaton: CellularAutomaton) -> Spec:
    return replace(spec, cellular=(automaton,))


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.dictionaries(st.integers(0, 15), st.integers(0, 15)))
def test_orbits_are_those_of_the_graph(steps: dict[int, int]) -> None:
    world = world_of(steps, 8)
    cells = world.cells("Cell").cells
    graph = networkx.DiGraph([(cells[a], cells[b]) for a, b in steps.items()])
    graph.add_nodes_from(cells)
    found = orbits_of(world, "Q")
    assert {frozenset(c) for c in found.cycles} == {frozenset(c) for c in networkx.simple_cycles(graph)}
    assert set(found.dead) == {c for c in cells if graph.out_degree(c) == 0}
    assert set(found.unreached) == {c for c in cells if graph.in_degree(c) == 0}
    cyclic = {c for cycle in found.cycles for c in cycle}
    assert set(found.tails) == set(cells) - cyclic - set(found.dead)


def test_orbits_in_words() -> None:
    assert orbits(world_of({k: (k + 1) % 16 for k in range(16)}, 8), "Q") == (
        "Q: 16 cells, 1 cycle of 16 cells; each cell has one cell before it"
    )
    assert orbits(world_of({0: 0, 1: 0, 2: 3}, 2), "Q") == (
        "Q: 4 cells, 1 cycle of 1 cell; 2 on the way to a cycle or an end: L S1 (0b01), R S0 (0b10); "
        "2 with none before: L S1 (0b01), R S0 (0b10); 1 without a next one: R S1 (0b11)"
    )


# ---- size --------------------------------------------------------------------------------------


def big(size: int) -> str:
    """A table of size * size cells whose rules exchange the parts."""
    width = (size - 1).bit_length()
    names = ["enum A { %s }", "enum B { %s }"]
    head = [n % ", ".join(f"{n[5]}{k} = 0b{k:0{width}b}" for k in range(size)) for n in names]
    rules = [
        f"  rule 0b{a:0{width}b}{b:0{width}b} -> 0b{b:0{width}b}{a:0{width}b}" for a in range(size) for b in range(size)
    ]
    return "\n".join([*head, "cellular Big {", "  cell Cell = A ++ B", *rules, "}\n"])


@pytest.fixture(scope="module")
def swap() -> Callable[[str], Evidence]:
    head = big(32)
    return lambda goal: decided(goal, head, " on Big")


def test_nested_quantifiers_over_a_thousand_cells(swap: Callable[[str], Evidence]) -> None:
    assert isinstance(swap("forall c in Cell: forall d in Cell: next(c) == next(d) implies c == d").verdict, Proved)
    assert isinstance(swap("forall c in Cell: unique d in Cell: next(d) == c and next(c) == d").verdict, Proved)
    e = swap("forall c in Cell: exists d in Cell: c.a == d.a and next(d) == d and next(c) != d")
    assert isinstance(e.verdict, Refuted)
    assert told(e).startswith("32 of 1024 fail: A0 B0 (0b0000000000)")


def test_more_than_can_be_tried_is_said(swap: Callable[[str], Evidence]) -> None:
    four = "forall c in Cell: forall d in Cell: exists e in Cell: exists f in Cell"
    spec = spec_of(f"{big(32)}property p on Big {{ holds {four}: c == d or next(e) == f and e == c }}")
    e = decide_all(spec, budget=Fraction(1, 10))["p"]
    assert reason(e) == "budget: there are too many combinations of cells to try"
