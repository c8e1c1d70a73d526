"""Small specs read from text."""

from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.obligations.obligation import hashes
from haverify.obligations.parts import parts
from haverify.syntax.parse import parse
from haverify.text.source import Source

PLAIN = """spec "plain" version "1.0" unitless
const c = 3
param p in [0, 1]
automaton A {
  var x in [0, 9]
  init M with { x := 0 }
  mode M {
    domain x <= 1
    flow { x' = 1 }
    let y = c * x + p
    urgent edge up: -> N when x >= 1
  }
  mode N {
    domain x <= 2
    flow { x' = 1 }
    let y = x - p
    let z = p
    edge down: -> M when x >= 2 do { x := 0 }
  }
}
"""


def spec_of(*claims, model=PLAIN):
    """The model with these claims, named c0, c1, ..."""
    named = (f"property c{k} on A {{ {claim} }}\n" for k, claim in enumerate(claims))
    source = Source("plain.ha", model + "".join(named), "")
    tree, problems = parse(source)
    assert not problems, problems
    spec, found = elaborate(tree, Files({source.path: source}, {}, {}))
    assert len(spec.claims) == len(claims), found
    return spec


def condition(claim):
    """The condition of a claim's first goal."""
    return spec_of(claim).claims[0].goals[0].condition


def parts_of(claim):
    """The parts of a claim about PLAIN."""
    a = spec_of().automata[0]
    return list(parts(condition(claim), a, {m.name: k for k, m in enumerate(a.modes)}))


def hash_of(claim, model=PLAIN):
    """The hash of the claim's part for mode M and output y."""
    spec = spec_of(claim, model=model)
    found = hashes(spec, spec.automata[0])
    return found.part(found.goal(spec.claims[0], spec.claims[0].goals[0]), "dwell", "M", "y")
