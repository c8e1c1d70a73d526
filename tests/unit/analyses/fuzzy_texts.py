"""Small fuzzy specs, decided and checked without files."""

import json
from fractions import Fraction

from haverify.analyses.fuzzy import decide_fuzzy
from haverify.analyses.holds import Held
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.core import to_core
from haverify.model.spec import Spec
from haverify.syntax.parse import parse
from haverify.text.source import Source

FORCE = """
enum S { low, high }
fuzzy F {
  input force: N over [0 N, 12 N] { small = trap(0 N, 0 N, 4 N, 5 N); large = trap(4 N, 5 N, 12 N, 12 N) }
  input side: 1 over [0, 1] { yes = ramp(0, 1) }
  output o { low, high }
  logic min max
  rule force is small and side is yes => o is low
  rule force is large and side is yes => o is high
}
"""


def spec_of(text: str) -> Spec:
    """The spec of a text without errors."""
    source = Source.of_text("page.ha", 'spec "Test" version "1.0"\n' + text)
    tree, found = parse(source)
    spec, more = elaborate(tree, Files({source.path: source}))
    assert spec is not None
    assert not [d for d in [*found, *more] if d.code != "HA005"], [*found, *more]
    return spec


def core_of(spec: Spec) -> dict:
    """The core as a checker reads it."""
    return json.loads(json.dumps(to_core(spec)))


def decided(spec: Spec, number: int = 0, units: int = 400) -> Held:
    """What is found out about the first goal of a claim."""
    claim = spec.claims[number]
    return decide_fuzzy(spec, claim, claim.goals[0], to_core(spec), units)


def verdict(text: str, claim: str) -> str:
    """`proved` or `refuted`, agreed by the checker; else the kind of unknown."""
    from hacheck.core import Core
    from hacheck.fuzzy import fuzzy_goal

    spec = spec_of(text + f"property p {claim}\n")
    held = decided(spec)
    if not isinstance(held.verdict, Proved | Refuted):
        assert held.entry == {}
        return held.verdict.kind
    said = "proved" if isinstance(held.verdict, Proved) else "refuted"
    core = Core(core_of(spec))
    listed = core.claims["p"]
    assert fuzzy_goal(core, listed, listed["goals"][0], json.loads(json.dumps(held.entry))) == said
    return said


def witness(text: str, claim: str) -> dict[str, Fraction]:
    """The point that refutes a claim."""
    held = decided(spec_of(text + f"property p {claim}\n"))
    return {v: Fraction(q) for v, q in held.entry["point"].items()}
