"""Certificates of invariants for what is false or not meant, and what the analyses make of such specs."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction as Q
from pathlib import Path
from typing import Any

import pytest
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.invariants import Induction
from hacheck.obligations import Question, Setting, canonical_hash, established
from hacheck.rational import Meter, Refused, Unreadable
from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Unknown
from haverify.model.core import canonical, to_core

Json = Any
FAULTS = (Refused, Unreadable, KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError)


class World:
    """A spec's core, and certificates for its claims that are written by hand, their hashes right."""

    def __init__(self, text: str, edit: Callable[[Json], None] = lambda _: None) -> None:
        self.spec, _, _ = read(text.strip())
        data = json.loads(canonical(to_core(self.spec)))
        edit(data)
        self.core, self.certificates, self._open = Core(data), dict[str, Json](), set[str]()

    def lemma(self, name: str) -> Json:
        """As the checker's own: a claim with a certificate that proves it, in no circle."""
        if name in self._open or name not in self.certificates:
            raise Refused("used in a circle, or without a certificate")
        self._open.add(name)
        try:
            if self.verdict(name) != "proved":
                raise Refused("used and not proved")
        finally:
            self._open.discard(name)
        return self.core.claims[name]

    def setting(self, automaton: Json, rounding: bool = False) -> Setting:
        return Setting(self.core, automaton, rounding, lambda _: None, self.lemma)

    def forge(self, name: str, modes: Json, proofs: Json, start: Json, using: Sequence[str] = ()) -> str:
        """The verdict that the checker takes from these formulas and proofs (by kind and place, or kind; else "t")."""
        claim = self.core.claims[name]
        setting, goal = self.setting(self.core.automata[claim["on"]]), claim["goals"][0]
        induction = Induction(Question(setting, claim, goal), list(using), modes)
        parts = [
            {
                "kind": kind,
                "where": where,
                "proof": proofs.get(f"{kind} {where}", proofs.get(kind, "t")),
                "hash": canonical_hash(["haverify.obligation/1", setting.hash, induction.hash, kind, where, ""]),
            }
            for kind, where, _ in induction.parts()
        ]
        entry = {"kind": "invariant", "start": start, "using": list(using), "modes": modes, "parts": parts}
        head = {"schema": "haverify.certificate/1", "claim": name, "rounding": None}
        verdict = "proved" if goal["kind"] == "always" else "refuted"
        self.certificates[name] = {**head, "verdict": verdict, "goals": [entry]}
        return self.verdict(name)

    def verdict(self, name: str, certificate: Json = None) -> str:
        Meter.left = 60_000_000
        given = self.certificates[name] if certificate is None else certificate
        return established(self.core, self.core.claims[name], copy.deepcopy(given), self.setting)[0]


COUNTER = """
spec "s" version "1.0" unitless
enum N = 0..3
automaton A {
  var x
  var n: N
  init M where x == 0 and n == 0
  mode M {
    domain true
    flow { x' = 0 }
    edge step: -> M when GUARD do {
      x := x + 1
      n := n + 1
    }
  }
}
invariant p on A: x <= 3
invariant q on A: x == n inductive
"""
SAME = ["==", [["1", "x"], ["-1", "n"]]]
STILL = {"cuts": [{"formula": SAME, "start": "t", "keep": {"rule": "darboux", "matrix": [[[]]], "ideal": [[]]}}],
         "end": "t"}  # fmt: skip
ORIGIN = {"mode": "M", "values": {"x": "0", "n": "0"}, "params": {}}


def counter(guard: str) -> str:
    proofs = {"init": "b", "flow": STILL, "use": ["put", 2, "x", "b"]}
    return World(COUNTER.replace("GUARD", guard)).forge("p", {"M": SAME}, proofs, ORIGIN)


def test_a_type_does_not_stop_a_counter() -> None:
    """No run is followed beyond the values of a type (S4), and none is thought to stay inside of it for that."""
    assert counter("n < 3") == "proved"
    for guard in ("true", "n <= 3", "x <= 3"):
        with pytest.raises(FAULTS):
            counter(guard)


def test_an_analysis_does_not_think_so_either() -> None:
    for guard, word in (("true", "Unknown"), ("n < 3", "Proved")):
        found = decide_all(World(COUNTER.replace("GUARD", guard)).spec, ["q"])
        assert type(found["q"].verdict).__name__ == word


def test_no_run_is_made_up_that_leaves_a_type() -> None:
    """Its certificate would be refused."""
    assert isinstance(decide_all(World(COUNTER.replace("GUARD", "true")).spec, ["p"])["p"].verdict, Unknown)


FROZEN = """
spec "s" version "1.0" unitless
automaton A { var x; var y; init M where x == 0 and y == 0; mode M { terminal; flow { x' = 1 + 0 * y; y' = x * y } } }
property p on A { always x >= time }
invariant q on A: x >= time inductive
"""


def test_time_goes_on_where_a_run_is_frozen() -> None:
    """A run may stop in a terminal mode at once (S12): x stays 0."""
    assert {type(e.verdict).__name__ for e in decide_all(World(FROZEN).spec).values()} == {"Unknown"}


UNDEFINED = """
spec "s" version "1.0" unitless
automaton A {
  var x
  var y
  init M where -1 <= x and x <= 1 and y == 0
  mode M { flow { x' = -x; y' = x * y }; edge e: -> M when x > 5 }
}
property p on A { always 1 / x <= 100 or 1 / x >= -5 }
property q on A { always 1 / x <= 100 }
"""


def test_nothing_is_violated_where_a_divisor_is_nought() -> None:
    """The start x = 0 is no counterexample: nothing is evaluated to false there."""
    world = World(UNDEFINED)
    found = decide_all(world.spec)
    assert type(found["p"].verdict).__name__ == "Unknown"
    assert world.verdict("q", json.loads(canonical(found["q"].certificate))) == "refuted"


TIMED = """
spec "s" version "1.0" unitless
automaton A { var x; var y; init M where x == 0 and y == 0; mode M { flow { x' = x + y^2; y' = x * y } } }
invariant p on A: time <= 1 implies x <= 1 inductive
property q on A { within 1; always x <= 1 }
"""


def test_what_holds_on_all_runs_need_not_be_inductive() -> None:
    world = World(TIMED)
    claim = next(c for c in world.spec.claims if c.name == "q")
    found = decide_flow(world.spec, world.spec.automata[0], claim, to_core(world.spec))
    records = {name: json.loads(canonical(value)) for name, value in found.cells.items()}
    setting = Setting(world.core, world.core.automata["A"], False, records.__getitem__, world.lemma)
    certificate = json.loads(canonical(found.certificate))
    assert established(world.core, world.core.claims["q"], certificate, lambda *_: setting)[0] == "proved"
    world.core.claims["q"]["inductive"] = True
    with pytest.raises(FAULTS):
        established(world.core, world.core.claims["q"], certificate, lambda *_: setting)


def test_a_state_that_leaves_an_invariant_has_its_time() -> None:
    verdict = decide_all(World(TIMED).spec, ["p"])["p"].verdict
    assert isinstance(verdict, Unknown)
    assert verdict.kind == "inductive"


# ---- every small change of true certificates ----------------------------------------------------------------------

RULES, SIGNS = ("darboux", "growth", "barrier", "always", "lie"), ("<", "<=", "==", "!=")
Place = tuple[Any, ...]


def places(value: Json, at: Place = ()) -> Iterator[tuple[Place, Json]]:
    """All values inside of a JSON value with their places."""
    yield at, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for k, v in items:
        yield from places(v, (*at, k))


def others(v: Json) -> list[Json]:
    """What may stand in the place of a number, an index, a sign, a rule or a name."""
    if isinstance(v, bool) or not isinstance(v, str | int):
        return []
    if isinstance(v, int):
        return [v + 1, v - 1, True, 99]
    if v.lstrip("-").replace("/", "").isdigit():
        return sorted({str(Q(v) + 1), str(-Q(v)), "0", str(Q(v) * 2)} - {v})
    alike = next((words for words in (RULES, SIGNS, ("x1", "x2", "time", "zz")) if v in words), (v,))
    return [w for w in alike if w != v]


def at_place(value: Json, at: Place) -> Json:
    for k in at:
        value = value[k]
    return value


def changed(whole: Json, at: Place, new: Json) -> Json:
    """A copy with another value at a place, or without it."""
    out = copy.deepcopy(whole)
    if new is None:
        del at_place(out, at[:-1])[at[-1]]
    else:
        at_place(out, at[:-1])[at[-1]] = new
    return out


def is_harmless(proof: Json, at: Place, new: Json) -> bool:
    """Whether a change leaves a proof a proof: of a split, a root's sign, a cut that follows from what is known."""
    above = [at_place(proof, at[:n]) for n in range(len(at))]
    if any(isinstance(v, list) and v[:1] == ["s"] and at[n] in (1, 2) for n, v in enumerate(above)):
        return True
    if any(isinstance(v, dict) and (v.get("keep") or {}).get("rule") == "always" for v in above):
        return True
    root = above[-2] if len(above) > 1 else None  # a POLY of one term: its square is that of its negative
    return isinstance(root, list) and len(root) == 1 and isinstance(new, str) and new == str(-Q(above[-1][0]))


def test_no_small_change_of_the_rocking_block_s_proofs_is_a_proof() -> None:
    text = Path(__file__).parents[2].joinpath("spec", "rocking_block.ha").read_text(encoding="utf-8")
    world, names, tried = World(text), ("energy", "never_falls", "gentle"), 0
    found = decide_all(world.spec, names)
    world.certificates = {n: json.loads(canonical(found[n].certificate)) for n in names}
    setting = world.setting(world.core.automata["Rocking"])
    for name in names:
        (entry,), claim = world.certificates[name]["goals"], world.core.claims[name]
        induction = Induction(Question(setting, claim, claim["goals"][0]), entry["using"], entry["modes"])
        for (_, _, check), part in zip(induction.parts(), entry["parts"], strict=True):
            proof = part["proof"]
            check(proof)
            for at, v in places(proof):
                drop = [None] if isinstance(v, list) and at and isinstance(at[-1], int) else []
                for new in [*others(v), *drop]:
                    if at and not is_harmless(proof, at, new):
                        Meter.left, tried = 60_000_000, tried + 1
                        with pytest.raises(FAULTS):
                            assert check(changed(proof, at, new)) == "nothing", (name, part["where"], at, v, new)
    assert tried > 900


NAMED = """
spec "s" version "1.0" unitless
automaton A {
  var x
  var y
  var w
  init M where x == 0 and y == 0 and w == 0
  mode M { flow { x' = 1; y' = 1; w' = 0 } }
}
property p on A { always sin(x * y) <= sin(w) }
"""


def test_names_do_not_read_as_arguments() -> None:
    """A variable called `x*y` in a core that is written by hand is not the product of two."""
    start = {"mode": "M", "values": {"x": "0", "y": "0", "w": "0"}, "params": {}}
    with pytest.raises(FAULTS):  # neither is `sin(x * y)` the sine of w
        World(NAMED).forge("p", {"M": True}, {"flow": {"cuts": [], "end": "t"}}, start)

    def renamed(data: Json) -> None:
        data.update(json.loads(json.dumps(data).replace('"w"', '"x*y"')))

    start = {"mode": "M", "values": {"x": "0", "y": "0", "x*y": "0"}, "params": {}}
    with pytest.raises(FAULTS):
        World(NAMED, renamed).forge("p", {"M": True}, {"flow": {"cuts": [], "end": "t"}}, start)
