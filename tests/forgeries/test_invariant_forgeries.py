"""Damages to certificates of invariants, and certificates with the right hashes for what is false: all are refused."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from fractions import Fraction as Q
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.obligations import Setting, established
from hacheck.rational import Meter, Refused, Unreadable
from haverify.analyses.portfolio import decide_all
from haverify.model.core import canonical, to_core
from haverify.obligations.obligation import digest

FAULTS = (
    Refused,
    Unreadable,
    RecursionError,
    KeyError,
    IndexError,
    TypeError,
    ValueError,
    AttributeError,
    ArithmeticError,
)
Json = Any
Place = tuple[str | int, ...]

TURNING = """
spec "Turning" version "1.0" unitless
param r in [1/2, 1]
automaton A {
  var x
  var y
  init Turn where x^2 + y^2 <= 1/2
  init Fall where x >= 1 and x <= 2 and y == 0
  mode Turn { domain y <= 2; flow { x' = -y; y' = x }; edge hit: -> Turn when x == 0 do y := -r * y }
  mode Fall { flow { x' = -x; y' = cos(x) - y } }
}
invariant disc on A: (at(Turn) implies x^2 + y^2 <= 1) and (at(Fall) implies x > 0) inductive
property bounded on A { always at(Fall) implies y <= 2; using disc }
property early on A { within 2; always at(Turn) implies x <= 1; using disc }
"""


class Case:
    """A core and the certificates of its claims; copies may be damaged."""

    def __init__(self, text: str) -> None:
        spec, _, _ = read(text.strip())
        self.core: Json = json.loads(canonical(to_core(spec)))
        found = decide_all(spec)
        self.certificates: Json = {n: json.loads(canonical(e.certificate)) for n, e in found.items() if e.certificate}
        self.whole, self.shown = dict(self.certificates), set[str]()

    def outcome(self, name: str, certificate: Json | None = None) -> str:
        """The verdict that the second checker takes from a certificate."""
        Meter.left = 60_000_000
        core = Core(self.core)

        def lemma(used: str) -> Json:
            is_whole = self.certificates[used] is self.whole.get(used)
            if not (is_whole and used in self.shown) and self.outcome(used) != "proved":
                raise Refused("used and not proved")
            if is_whole:
                self.shown.add(used)
            return core.claims[used]

        def setting(automaton: Json, rounding: bool) -> Setting:
            return Setting(core, automaton, rounding, lambda _: None, lemma)

        given_ = self.certificates[name] if certificate is None else certificate
        return established(core, core.claims[name], given_, setting)[0]


@pytest.fixture(scope="module")
def case() -> Case:
    return Case(TURNING)


def test_what_is_damaged_below_is_accepted_whole(case: Case) -> None:
    assert {n: case.outcome(n) for n in case.certificates} == dict.fromkeys(("disc", "bounded", "early"), "proved")


def places(value: Json, at: Place = ()) -> Iterator[tuple[Place, Json]]:
    """All values inside of a JSON value with their places."""
    yield at, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for k, v in items:
        yield from places(v, (*at, k))


def changed(certificate: Json, at: Place, new: Json) -> Json:
    """A copy with another value at a place."""
    out = copy.deepcopy(certificate)
    inner = out
    for k in at[:-1]:
        inner = inner[k]
    inner[at[-1]] = new
    return out


def is_inside(certificate: Json, at: Place, word: str) -> bool:
    """Whether a place is inside of a list that begins with a word."""
    value = certificate
    for k in at:
        if isinstance(value, list) and value and value[0] == word:
            return True
        value = value[k]
    return False


def damages(case: Case) -> list[tuple[str, Place, Json]]:
    """Changes of one number, sign, index or hash in identities, of rules, of names, of hashes; parts dropped."""
    found: list[tuple[str, Place, Json]] = []
    for name, whole in case.certificates.items():
        for at, v in places(whole):
            if at and at[-1] == "hash":
                found.append((name, at, ("0" if v[0] != "0" else "1") + v[1:]))
            if is_inside(whole, at, "psatz") or "matrix" in at:
                if isinstance(v, str) and v.lstrip("-").replace("/", "").isdigit():
                    found.append((name, at, str(Q(v) + 1)))
                    if v != "1":  # the square of -1 is that of 1
                        found.append((name, at, str(-Q(v) if Q(v) else Q(1))))
                if isinstance(v, int):
                    found += [(name, at, v + 1), (name, at, v - 1), (name, at, 99)]
            if isinstance(v, str) and v in ("darboux", "growth", "barrier", "always", "psatz", "put", "or", "cut"):
                found += [(name, at, w) for w in ("darboux", "growth", "barrier", "lie", "t") if w != v]
            if at and at[-1] in ("kind", "where", "claim", "schema", "verdict") and isinstance(v, str):
                found.append((name, at, v + "x"))
        parts = whole["goals"][0]["parts"]
        for k in range(len(parts)):
            found.append((name, ("goals", 0, "parts"), parts[:k] + parts[k + 1 :]))
        found.append((name, ("goals", 0, "parts"), parts[1:] + parts[:1]))
        found.append((name, ("goals", 0, "parts"), [*parts, parts[-1]]))
        found.append((name, ("goals", 0, "start", "values", "x"), "77"))
        found.append((name, ("goals", 0, "start", "params", "r"), "2"))
    return found


def test_every_damage_is_refused(case: Case) -> None:
    all_of = damages(case)
    assert len(all_of) > 250
    for name, at, new in all_of:
        forged = changed(case.certificates[name], at, new)
        with pytest.raises(FAULTS):
            assert case.outcome(name, forged) == "nothing", (name, at, new)


@given(st.data())
@settings(max_examples=150, deadline=None, derandomize=True)
def test_no_other_proof_of_a_part_is_taken_for_it(data: Any) -> None:
    """The proof of one part in the place of another is accepted only if both are equal."""
    case = _turning()
    name = data.draw(st.sampled_from(sorted(case.certificates)))
    parts = case.certificates[name]["goals"][0]["parts"]
    i, j = (data.draw(st.integers(0, len(parts) - 1)) for _ in range(2))
    if parts[i]["kind"] == parts[j]["kind"] or parts[i]["proof"] == parts[j]["proof"]:
        return
    forged = changed(case.certificates[name], ("goals", 0, "parts", i, "proof"), parts[j]["proof"])
    with pytest.raises(FAULTS):
        assert case.outcome(name, forged) == "nothing"


_CASES: list[Case] = []


def _turning() -> Case:
    if not _CASES:
        _CASES.append(Case(TURNING))
    return _CASES[0]


def test_a_weaker_claim_in_the_core_has_another_hash(case: Case) -> None:
    other = copy.copy(case)
    other.shown = set()
    other.core = json.loads(json.dumps(case.core).replace('["^", ["var", "x"], "2"]', '["^", ["var", "x"], "4"]'))
    assert other.core != case.core
    with pytest.raises(FAULTS):
        other.outcome("disc")


def test_an_invariant_is_not_used_where_it_is_not_proved(case: Case) -> None:
    other = copy.copy(case)
    other.certificates = {**case.certificates, "disc": changed(case.certificates["disc"], ("verdict",), "refuted")}
    with pytest.raises(FAULTS):
        other.outcome("bounded")
    entry = case.certificates["bounded"]
    for using in ([], ["early"], ["bounded"], ["disc", "disc", "none"]):
        with pytest.raises(FAULTS):
            assert case.outcome("bounded", changed(entry, ("goals", 0, "using"), using)) == "nothing"


# ---- certificates with all the right hashes, for claims that are false -------------------------------------------


def forged(text: str, formula: Json, flow: Json, init: Json = "t", use: Json = "t", start: Json = None) -> str:
    """What the checker takes from a certificate of the property `p` of a one-mode automaton, its hashes right."""
    spec, _, _ = read(text.strip())
    core: Json = json.loads(canonical(to_core(spec)))
    claim = next(c for c in core["claims"] if c["name"] == "p")
    a = core["automata"][0]
    shared = {k: core[k] for k in ("params", "enums", "assumptions")}
    model = digest({"automaton": a, "constants": [], **shared})
    about = {"goal": claim["goals"][0], "horizon": claim["horizon"], "assume": claim["assume"], "constants": []}
    proofs = {"init": init, "flow": flow, "use": use}
    parts = [
        {
            "kind": k,
            "where": "M",
            "hash": digest(["haverify.obligation/1", model, digest(about), k, "M", ""]),
            "proof": p,
        }
        for k, p in proofs.items()
    ]
    start = start or {"mode": "M", "values": {v["name"]: "0" for v in a["vars"]}, "params": {}}
    entry = {"kind": "invariant", "start": start, "using": [], "modes": {"M": formula}, "parts": parts}
    certificate = {
        "schema": "haverify.certificate/1", "claim": "p", "verdict": "proved", "goals": [entry], "rounding": None,
    }  # fmt: skip
    case = object.__new__(Case)
    case.core, case.certificates, case.whole, case.shown = core, {"p": certificate}, {}, set()
    return case.outcome("p")


def system(flow: str, claim: str, init: str = "x == 0 and y == 0", domain: str = "true") -> str:
    return f"""
spec "s" version "1.0" unitless
automaton A {{ var x; var y; init M where {init}; mode M {{ domain {domain}; flow {{ {flow} }} }} }}
property p on A {{ always {claim} }}
"""


X, Y = [["1", "x"]], [["1", "y"]]
X_LOW = ["<=", X]


def cut(formula: Json, keep: Json, start: Json = "t") -> Json:
    return {"cuts": [{"formula": formula, "start": start, "keep": keep}], "end": "t"}


def test_the_frame_of_these_attacks_is_sound() -> None:
    keep = {"rule": "darboux", "matrix": [[[["-1"]]]], "ideal": [[]]}
    assert forged(system("x' = -x; y' = 0", "x <= 0"), X_LOW, cut(X_LOW, keep)) == "proved"


@pytest.mark.parametrize(
    ("flow", "keep"),
    [
        ("x' = 1; y' = 0", {"rule": "darboux", "matrix": [[[["1"]]]], "ideal": [[]]}),
        ("x' = 1; y' = 0", {"rule": "darboux", "matrix": [[[]]], "ideal": [[]]}),
        ("x' = 1; y' = 0", {"rule": "growth", "cofactor": [["5"]], "band": None, "proof": "t"}),
        ("x' = 1; y' = 0", {"rule": "growth", "cofactor": [["5"]], "band": "0", "proof": "t"}),
        ("x' = 1; y' = 0", {"rule": "growth", "cofactor": [["5"]], "band": "-1", "proof": "b"}),
        ("x' = 1; y' = 0", {"rule": "growth", "cofactor": [["1", "1/x"]], "band": None, "proof": "b"}),
        ("x' = y^2; y' = 1", {"rule": "barrier", "proofs": ["b"]}),
        ("x' = y; y' = 1", {"rule": "barrier", "proofs": ["t"]}),
        ("x' = y; y' = 1", {"rule": "barrier", "proofs": []}),
        ("x' = y; y' = 1", {"rule": "lie", "ranks": [[2, None, []]], "forward": "t", "backward": "t"}),
        ("x' = y; y' = 1", {"rule": "lie", "ranks": [[1, None, []]], "forward": "t", "backward": "t"}),
        ("x' = y; y' = 1", {"rule": "lie", "ranks": [[1, [[]], []]], "forward": "t", "backward": "t"}),
        ("x' = y; y' = 1", {"rule": "lie", "ranks": [[1, [[["1"]]], []]], "forward": "t", "backward": "t"}),
        ("x' = y; y' = 1", {"rule": "lie", "ranks": [], "forward": "t", "backward": "t"}),
        ("x' = y; y' = 1", {"rule": "lie", "ranks": [[0, [], []]], "forward": "t", "backward": "t"}),
        ("x' = 1; y' = 0", {"rule": "always", "proof": "t"}),
        ("x' = 1; y' = 0", {"rule": "always", "proof": "b"}),
        ("x' = 1; y' = 0", None),
        ("x' = 1; y' = 0", {"rule": "none"}),
    ],
)  # fmt: skip
def test_no_rule_keeps_what_is_left(flow: str, keep: Json) -> None:
    with pytest.raises(FAULTS):
        forged(system(flow, "x <= 0"), X_LOW, cut(X_LOW, keep))


def test_a_barrier_that_the_flow_touches_along_its_side_is_none() -> None:
    """x' = 0 on x == 0 is not enough: x' = y - x^2 there has y' = 1 to take it out."""
    proof = ["put", 0, "x", "t"]
    for text in ("x' = 0 * x; y' = 1", "x' = x^2; y' = 1"):
        with pytest.raises(FAULTS):
            forged(system(text, "x <= 0"), X_LOW, cut(X_LOW, {"rule": "barrier", "proofs": [proof]}))


def test_several_inequalities_are_not_kept_by_rows() -> None:
    both = ["and", X_LOW, ["<=", Y]]
    row = [[[], [["1"]]], [[["1"]], []]]
    keep = {"rule": "darboux", "matrix": row, "ideal": [[], []]}
    with pytest.raises(FAULTS):
        forged(system("x' = -y; y' = -x", "x <= 0"), both, cut(both, keep))


def test_a_formula_may_not_speak_of_names_that_are_none() -> None:
    for name in ("z", "x'", "sin(1*x)", "cos(", "pi "):
        p = [["1", name]]
        with pytest.raises(FAULTS):
            forged(system("x' = 1; y' = 0", "x <= 0"), ["<=", p], cut(["<=", p], {"rule": "always", "proof": "b"}))


def test_a_start_must_be_one() -> None:
    keep = {"rule": "darboux", "matrix": [[[["-1"]]]], "ideal": [[]]}
    text = system("x' = -x; y' = 0", "x <= 0", init="x == 0 and y == 0 and x > 1")
    with pytest.raises(FAULTS):
        forged(text, X_LOW, cut(X_LOW, keep))
    text = system("x' = -x; y' = 0", "x <= 0", domain="y >= 1")
    with pytest.raises(FAULTS):
        forged(text, X_LOW, cut(X_LOW, keep))


def test_time_in_a_terminal_mode_is_frozen_with_the_run() -> None:
    text = system("x' = 1; y' = 0", "x >= time").replace("domain true", "terminal")
    keep = {"rule": "darboux", "matrix": [[[]]], "ideal": [[]]}
    f = ["==", [["1", "x"], ["-1", "time"]]]
    proof = ["psatz", [], [[0, [["1"]]]], ["1", [1]]]
    assert forged(text.replace("terminal", ""), f, cut(f, keep), init="b", use=proof) == "proved"
    with pytest.raises(FAULTS):
        forged(text, f, cut(f, keep), init="b", use=proof)


@given(st.fractions(min_value=-2, max_value=2, max_denominator=6), st.booleans())
@settings(max_examples=60, deadline=None, derandomize=True)
def test_a_perturbed_barrier_is_accepted_only_where_it_is_one(shift: Q, is_turned: bool) -> None:
    """x' = -x + 1: `x <= c` is kept where c >= 1, `x >= c` where c <= 1."""
    c = 1 + shift
    p = [["-1" if is_turned else "1", "x"], [str(c if is_turned else -c)]]
    number = f"({c.numerator} / {c.denominator})"
    claim = f"x {'>=' if is_turned else '<='} {number}"
    text = system("x' = 1 - x; y' = 0", claim, init=f"x == {number} and y == 0")
    start = {"mode": "M", "values": {"x": str(c), "y": "0"}, "params": {}}
    rule = {"rule": "barrier", "proofs": [["put", 0, "x", "t"]]}
    try:
        outcome = forged(text, ["<=", p], cut(["<=", p], rule), init="b", start=start)
    except FAULTS:
        outcome = "refused"
    assert outcome == ("proved" if (shift < 0 if is_turned else shift > 0) else "refused")
