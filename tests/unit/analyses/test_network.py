"""What systems do, rule by rule: small systems with one claim each, decided and accepted by the checker."""

from fractions import Fraction as Q

import pytest
from tests.unit.analyses.test_network_laws import decided

from haverify.evidence.verdict import Unknown

LIGHT = "automaton Light { init Red; mode Red { edge go: -> Green }; mode Green { edge stop: -> Red } }\n"
TIMER = """
automaton Timer {
  var x: s
  init Run with x := 0 s
  flow { x' = 1 }
  mode Run { domain x <= 5 s; urgent edge ring: -> Done when x > 2 s; edge quit: -> Off when x >= 4 s }
  mode Done { }
  mode Off { }
}
automaton Partner { init Shy; mode Shy { edge dare: -> Ready }; mode Ready { edge meet: -> Shy } }
"""
TWO = TIMER + "system S { part t = Timer; part q = Partner; sync r: t.ring, q.meet }"
ORDERED = TIMER + "system S { part t = Timer; part q = Partner; sync r: t.ring; priority q.dare over r }"
BUTTON = """
automaton Button { init Up; mode Up { edge press: -> Down }; mode Down { domain true } }
automaton Lamp {
  var y: s
  init Dark with y := 0 s
  flow { y' = 1 }
  mode Dark { edge light: -> Lit when y >= 1 s }
  mode Lit { domain y <= 9 s }
}
"""


def word(text, name="p"):
    return type(decided(text)[name].verdict).__name__.lower()


def run(text, name="p"):
    return decided(text)[name].trace


CASES = {
    # S14: an edge that no sync mentions fires alone; one that a sync mentions never does
    "fires alone": (
        LIGHT + "system S { part a = Light; part b = Light }", "never at(a.Green) and at(b.Green)", "refuted"),
    "only together": (
        LIGHT + "system S { part a = Light; part b = Light; sync t: a.go, b.stop }", "never at(a.Green)", "refuted"),
    "never without its partner": (
        LIGHT + "system S { part a = Light; part b = Light; sync t: a.go, b.stop; sync u: b.go, a.stop }",
        "never at(a.Green) or at(b.Green)", "proved"),
    # S14: listeners join exactly where they are enabled
    "a listener that can joins": (
        BUTTON + "system S { part b = Button; part l = Lamp; sync s: b.press -> l.light }",
        "never at(b.Down) and at(l.Dark) and 1 s < l.y <= 9 s and jumped",
        "proved",
    ),
    "not where its outcome is outside the domain": (
        BUTTON + "system S { part b = Button; part l = Lamp; sync s: b.press -> l.light }",
        "never at(b.Down) and at(l.Dark) and 1 s < l.y and jumped",
        "refuted",
    ),
    "a listener that cannot does not": (
        BUTTON + "system S { part b = Button; part l = Lamp; sync s: b.press -> l.light }",
        "can reach at(b.Down) and at(l.Dark) and l.y < 1 s", "proved"),
    "a listener does not act alone": (
        BUTTON + "system S { part b = Button; part l = Lamp; sync s: b.press -> l.light }",
        "never at(b.Up) and at(l.Lit)", "proved"),
    # S8: an urgent edge with a strict guard fires at the bound, and no time passes there
    "due at an open bound": (TIMER + "system S { part t = Timer }", "never t.x > 2 s and at(t.Run)", "proved"),
    "fires at the open bound": (TIMER + "system S { part t = Timer }", "can reach at(t.Done) and t.x == 2 s", "proved"),
    "not before": (TIMER + "system S { part t = Timer }", "can reach at(t.Done) and t.x < 2 s", "refuted"),
    "not due right after a domain ends": (
        "automaton A { var x: s; init M with x := 0 s; flow { x' = 1 }; mode M { domain x <= 1 s } }\n"
        "automaton B { var x: s; init M with x := 0 s; flow { x' = 1 }; mode M { urgent edge e: -> N when x > 1 s }; "
        "mode N { domain true } }\nsystem S { part a = A; part b = B }",
        "can reach at(b.N)",
        "refuted",
    ),
    # S16: urgent only as a whole
    "an urgent edge waits for its partner": (
        TWO,
        "can reach at(t.Run) and t.x == 5 s", "proved"),
    "and then time stops": (
        TWO,
        "can reach at(t.Run) and at(q.Ready) and t.x > 3 s and not jumped",
        "refuted",
    ),
    # S17: what is suppressed does not stop time
    "a suppressed urgent edge": (
        ORDERED,
        "can reach at(t.Run) and t.x > 3 s", "proved"),
    "only while the higher one is enabled": (
        ORDERED,
        "can reach at(t.Run) and at(q.Ready) and t.x > 3 s and not jumped", "refuted"),
    "chains of priorities": (
        LIGHT + "system S { part a = Light; part b = Light; part c = Light; priority a.go over b.go; "
        "priority b.go over c.go }", "never at(c.Green) and at(a.Red) and at(b.Red) and jump(c.go)", "proved"),
    # S12: stuck is where no time passes and nothing fires; waiting for ever is not stuck
    "waiting is not stuck": (LIGHT + "system S { part a = Light; sync t: a.go when false }", "never stuck", "proved"),
    "a time-lock is": (
        "automaton A { var x: s; init M with x := 0 s; flow { x' = 1 }; mode M { domain x <= 1 s } }\n"
        "system S { part a = A; part b = A }", "never stuck", "refuted"),
    "terminal modes are not": (
        "automaton A { var x: s; init M with x := 0 s; flow { x' = 1 }; mode M { terminal; domain x <= 1 s } }\n"
        "system S { part a = A; part b = A }", "never stuck", "proved"),
    # S15: all right sides read the state before the jump
    "a swap": (
        "automaton A { var n: N; init M with n := 1; mode M { edge e: -> M do n := 2 } }\nenum N = 0..3\n"
        "system S { var m: N; init with m := 0; part a = A; sync t: a.e do m := a.n }",
        "never m == 2 and a.n == 2 and jump(t) and pre(a.n) == 1", "proved"),
    # S13: inputs are read continuously
    "a port": (
        LIGHT + "automaton W { input go: bool; init M; mode M { edge e: -> N when go }; mode N { } }\n"
        "system S { part a = Light; part w = W with { go = at(a.Green) } }",
        "never jump(w.e) and at(a.Red)", "proved"),
    # horizons
    "within a time": (TIMER + "system S { part t = Timer }", "within 2 s; never at(t.Done)", "refuted"),
    "within less": (TIMER + "system S { part t = Timer }", "within 1.9 s; never at(t.Done)", "proved"),
    "within no jump": (LIGHT + "system S { part a = Light }", "within 0 jumps; never at(a.Green)", "proved"),
    "within a jump": (LIGHT + "system S { part a = Light }", "within 1 jumps; never at(a.Green)", "refuted"),
    "inside a declared range up to the horizon": (
        "automaton A { var x: s in [0 s, 3 s]; init M with x := 0 s; mode M { flow { x' = 1 } } }\n"
        "system S { part a = A; part b = A }",
        "within 2.5 s; never a.x > 2.6 s",
        "proved",
    ),
    "during": (TIMER + "system S { part t = Timer }", "always during [2.1 s, 3 s] at(t.Done)", "proved"),
    "during, too early": (TIMER + "system S { part t = Timer }", "always during [1.9 s, 3 s] at(t.Done)", "refuted"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_case(name):
    system, claim, verdict = CASES[name]
    assert word(f"{system}\nproperty p on S {{ {claim} }}") == verdict


FISCHER = """
enum Pid = 1..{n}; enum Owner = 0..{n}
automaton P {{
  var x: s
  init Idle with x := 0 s
  flow {{ x' = 1 }}
  mode Idle {{ edge try: -> Request do x := 0 s }}
  mode Request {{ domain x <= {a} s; edge set: -> Wait do x := 0 s }}
  mode Wait {{ edge enter: -> Critical when x {op} {b} s; edge retry: -> Request do x := 0 s }}
  mode Critical {{ edge leave: -> Idle }}
}}
system S {{
  var owner: Owner
  init with owner := 0
  part p for i in Pid = P
  sync try for i in Pid: p[i].try when owner == 0
  sync set for i in Pid: p[i].set do owner := i
  sync enter for i in Pid: p[i].enter when owner == i
  sync retry for i in Pid: p[i].retry when owner == 0
  sync leave for i in Pid: p[i].leave do owner := 0
}}
property p on S {{ never exists i in Pid: exists j in Pid: i != j and at(p[i].Critical) and at(p[j].Critical) }}
"""


@pytest.mark.parametrize(
    ("a", "b", "op", "verdict"),
    [(2, 3, ">", "proved"), (2, 2, ">", "proved"), (2, "1.999", ">", "refuted"), (2, 2, ">=", "refuted"),
     (2, "2.001", ">=", "proved"), ("1/3", "1/3", ">", "proved"), ("1/3", "1/3", ">=", "refuted")],
)  # fmt: skip
@pytest.mark.parametrize("n", [2, 4])
def test_fischer_excludes_just_where_the_wait_is_longer(n, a, b, op, verdict):
    text = FISCHER.format(n=n, a=f"({a}) *" if "/" in str(a) else a, b=f"({b}) *" if "/" in str(b) else b, op=op)
    text = text.replace("* s", "* 1 s")
    assert word(text) == verdict


def test_a_violated_exclusion_is_shown_by_a_shortest_round_run():
    found = run(FISCHER.format(n=3, a=2, b=1, op=">"))
    fired = [m.names[0] for m in found.moments[1:]]
    assert fired == ["try[1]", "try[2]", "set[1]", "enter[1]", "set[2]", "enter[2]"]
    assert [m.dwell for m in found.moments] == [0, 0, 0, Q(3, 2), 0, Q(3, 2), 0]


def test_symmetry_keeps_the_number_of_states_small():
    notes = decided(FISCHER.format(n=5, a=2, b=3, op=">"))["p"].notes
    assert notes == ("explored completely: 40 symbolic states, up to exchanges of p[1], p[2], p[3], p[4], p[5]",)


UNKNOWN = {
    "a param": (
        "param k in [1, 2]\nautomaton A { var x: s; init M with x := 0 s; mode M { flow { x' = 1 }; "
        "edge e: -> M when x >= k * 1 s } }\nsystem S { part a = A }", "never a.x < 0 s", "fragment", "param `a.k`"),
    "a slope of several values": (
        "automaton A { var x: s; init M with x := 0 s; mode M { flow { x' in [1, 2] } } }\nsystem S { part a = A }",
        "never a.x < 0 s", "fragment", "a range of rates"),
    "a stopwatch": (
        "automaton A { var x: s; init M with x := 0 s; mode M { flow { x' = 1 }; edge e: -> N }; "
        "mode N { flow { x' = 0 } } }\nsystem S { part a = A }", "never a.x < 0 s", "fragment", "another rate"),
    "a moving rate": (
        "automaton A { var x: s; init M with x := 0 s; mode M { flow { x' = 1 + x * 1 Hz } } }\n"
        "system S { part a = A }",
        "never a.x < 0 s", "fragment", "no constant"),
    "a sum of clocks": (
        "automaton A { var x: s; init M with x := 0 s; mode M { flow { x' = 1 } } }\n"
        "system S { part a = A; part b = A }", "never a.x + b.x < 0 s", "fragment", "the difference of two"),
    "a counter beyond its range": (
        "enum N = 0..2\nautomaton A { var n: N; init M with n := 0; mode M { edge e: -> M do n := n + 1 } }\n"
        "system S { part a = A }", "never a.n > 2", "fragment", "does not have"),
    "a declared range that is left": (
        "automaton A { var x: s in [0 s, 3 s]; init M with x := 0 s; mode M { flow { x' = 1 } } }\n"
        "system S { part a = A }", "never a.x < 0 s", "window", "declared range"),
    "reach": (LIGHT + "system S { part a = Light }", "reach at(a.Green) within 1 s", "fragment", "`reach`"),
    "time without a horizon": (
        LIGHT + "system S { part a = Light }", "never at(a.Green) and time < 1 s",
        "fragment", "give the claim a `within`"),
}  # fmt: skip


@pytest.mark.parametrize("name", UNKNOWN)
def test_what_is_not_decided_says_why(name):
    system, claim, kind, reason = UNKNOWN[name]
    verdict = decided(f"{system}\nproperty p on S {{ {claim} }}")["p"].verdict
    assert isinstance(verdict, Unknown)
    assert (verdict.kind, reason in verdict.reason) == (kind, True), verdict.reason


def test_a_system_inside_a_system():
    text = (
        LIGHT + "system Pair { part a = Light; part b = Light; sync both: a.go, b.go; sync back: a.stop, b.stop }\n"
        "system S { part l = Pair; part r = Pair; sync t: l.both, r.back; sync u: l.back, r.both; sync w: r.both }\n"
        "property p on S { never at(l.a.Green) and at(r.b.Green) }\n"
        "property q on S { can reach at(l.a.Green) and jump(l.a.go) and jump(t) }"
    )
    assert (word(text), word(text, "q")) == ("refuted", "proved")
    assert [m.names[0] for m in run(text).moments[1:]] == ["w", "t", "w"]
