"""Two coupled parts with flows, syncs, broadcasts and priorities have the verdicts of an automaton written by hand.

The automaton's text is written from the description of the parts, with conditions as text: nothing of the product.
"""

from __future__ import annotations

from typing import NamedTuple

import pytest
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.obligations import established
from hacheck.rational import Beyond, Meter
from hacheck.systems import SystemCheck
from haverify.analyses.networks import lazily
from haverify.analyses.poly_range import ENOUGH
from haverify.analyses.portfolio import Contexts, decide
from haverify.model.core import to_core

HEAD = 'spec "t" version "1.0" unitless\n'


class Part(NamedTuple):
    """Modes A and B; `go` leads from A to B, `back` to A. Numbers are texts."""

    rate: str  # of x towards it, in A
    top: str  # of x, in A
    go: str  # x is at least this
    urgent: bool
    reset: str  # of x, at `go`
    room: str  # least x in B
    back: str  # x is at most this


class Net(NamedTuple):
    parts: tuple[Part, Part]
    sync: str  # "", "," or "->": p.go with q.go
    over: str  # "", or a priority


def system(net: Net) -> str:
    out = []
    for n, p in zip("PQ", net.parts, strict=True):
        out.append(f"""automaton {n} {{
  input other
  var x in [-20, 20]
  init A where 0 <= x <= 0.02
  mode A {{
    domain x <= {p.top}
    flow {{ x' = {p.rate} - x + 0.1 * other }}
    {"urgent " * p.urgent}edge go: -> B when x >= {p.go} do x := {p.reset}
  }}
  mode B {{
    domain x >= {p.room}
    flow {{ x' = -x - 0.1 * other }}
    urgent edge back: -> A when x <= {p.back}
  }}
}}""")
    lines = ["part p = P with { other = q.x }", "part q = Q with { other = p.x }"]
    lines += [f"sync s: p.go{net.sync} q.go"] if net.sync else []
    lines += [f"priority {net.over}"] if net.over else []
    return "\n".join([*out, "system S {", *lines, "}"])


def by_hand(net: Net) -> str:
    """One automaton with the modes AA, AB, BA, BB."""
    out = ["automaton S {", "var p in [-20, 20]", "var q in [-20, 20]",
           "init AA where 0 <= p and p <= 0.02 and 0 <= q and q <= 0.02"]  # fmt: skip
    for m in ("AA", "AB", "BA", "BB"):
        own = list(zip("pq", "qp", m, net.parts, strict=True))
        domain = " and ".join(f"{v} <= {p.top}" if k == "A" else f"{v} >= {p.room}" for v, _, k, p in own)
        flow = "; ".join(
            f"{v}' = {p.rate} - {v} + 0.1 * {w}" if k == "A" else f"{v}' = -{v} - 0.1 * {w}" for v, w, k, p in own
        )
        out += [f"mode {m} {{", f"domain {domain}", f"flow {{ {flow} }}", *edges(net, m), "}"]
    return "\n".join([*out, "}"])


def edges(net: Net, mode: str) -> list[str]:
    """The edges of a mode: what fires alone, together, with a listener, and what is silenced."""
    p, q = net.parts

    def moved(part: Part, v: str) -> str:
        return part.reset.replace("x", v)

    def go(part: Part, v: str) -> str:
        return f"{v} >= {part.go}"

    def enters(part: Part, v: str) -> str:
        return f"{moved(part, v)} >= {part.room}"

    found = []  # name, guard, resets, target, urgent, where the outcome is in the domain
    can = {"p": mode[0] == "A", "q": mode[1] == "A"}
    rest = {v: f"{v} <= {part.top}" if can[v] else f"{v} >= {part.room}" for v, part in (("p", p), ("q", q))}
    both = f"p := {moved(p, 'p')}; q := {moved(q, 'q')}", "BB", p.urgent or q.urgent
    if net.sync == "," and can["p"] and can["q"]:
        inside = f"{enters(p, 'p')} and {enters(q, 'q')}"
        found.append(("s", f"{go(p, 'p')} and {go(q, 'q')}", *both, inside))
    elif net.sync == " ->" and can["p"]:
        hears = f"({go(q, 'q')} and {enters(q, 'q')})" if can["q"] else "false"
        if can["q"]:
            found.append(("s", f"{go(p, 'p')} and {hears}", *both, f"{enters(p, 'p')} and {enters(q, 'q')}"))
        alone = f"{go(p, 'p')} and not {hears}" if can["q"] else go(p, "p")
        inside = f"{enters(p, 'p')} and {rest['q']}"
        found.append(("s", alone, f"p := {moved(p, 'p')}", "B" + mode[1], p.urgent, inside))
    elif not net.sync:
        if can["p"]:
            inside = f"{enters(p, 'p')} and {rest['q']}"
            found.append(("p.go", go(p, "p"), f"p := {moved(p, 'p')}", "B" + mode[1], p.urgent, inside))
        if can["q"]:
            inside = f"{enters(q, 'q')} and {rest['p']}"
            found.append(("q.go", go(q, "q"), f"q := {moved(q, 'q')}", mode[0] + "B", q.urgent, inside))
    if not can["p"]:
        found.append(("p.back", f"p <= {p.back}", "", "A" + mode[1], True, f"p <= {p.top} and {rest['q']}"))
    if not can["q"]:
        found.append(("q.back", f"q <= {q.back}", "", mode[0] + "A", True, f"q <= {q.top} and {rest['p']}"))
    high, _, low = net.over.partition(" over ")
    above = " or ".join(f"({g} and {inside})" for n, g, _, _, _, inside in found if n == high)
    return [
        f"{'urgent ' * urgent}edge {n.replace('.', '_')}_{k}: -> {t} when {g}"
        + (f" and not ({above})" if n == low and above else "") + (f" do {{ {r} }}" if r else "")
        for k, (n, g, r, t, urgent, _) in enumerate(found)
    ]  # fmt: skip


GOALS = [
    ("within 0.8; always {p} <= 0.9 and {q} <= 0.9", "", ""),
    ("within 0.8; always {p} >= -0.1", "", ""),
    ("reach {b} within 0.8", "at(p.B) or at(q.B)", "at(BA) or at(BB) or at(AB)"),
    ("can reach {b} within 0.8", "at(q.B)", "at(AB) or at(BB)"),
    ("within 0.8; never {b} and {p} >= 0.8", "at(p.B)", "(at(BA) or at(BB))"),
]
NAMES = (("p.x", "q.x"), ("p", "q"))


def claims(by: int) -> str:
    p, q = NAMES[by]
    texts = [goal.format(p=p, q=q, b=words[by]) for goal, *words in GOALS]
    return "\n".join(f"property c{k} on S {{ {text} }}" for k, text in enumerate(texts))


def decided(text: str, by: int) -> tuple[list[str], int]:
    """The verdicts, and how many of a system the second checker accepts; it refuses none."""
    spec, found, _ = read(HEAD + text + "\n" + claims(by) + "\n")
    assert spec.claims, found
    core = Core(to_core(spec))
    contexts, words, accepted = Contexts(spec), [], 0
    for claim in spec.claims:
        e = decide(spec, claim, contexts, ENOUGH // 400)
        words.append(type(e.verdict).__name__)
        if e.certificate is not None and not by:
            check = SystemCheck(core, core.systems["S"], e.cells.__getitem__)
            Meter.left = 60_000_000
            try:
                established(core, core.claims[claim.name], e.certificate, None, lambda _, c=check: c)
                accepted += 1
            except Beyond:
                pass
    return words, accepted


def pair(first: str, second: str) -> tuple[Part, Part]:
    """Two parts with urgent edges, told as `rate top go reset room back`."""
    made = [Part(*words[:3], True, *words[3:]) for words in (first.split(), second.split())]
    return made[0], made[1]


NETS = [
    Net(pair("2 5 0.6 0.5*x -9 0.1", "3 5 0.4 0.5*x 0.2 0.25"), " ->", "s over q.back"),
    Net(pair("2 5 0.4 x 0.2 0.25", "2 0.6 0.5 x -9 0.1"), " ->", "q.back over s"),
    Net(pair("3 0.6 0.6 x+0.5 0.55 0.25", "2 0.6 0.4 x+0.5 -9 0.1"), "", "p.go over q.go"),
]
WORDS = ["RPPPP", "PPPRP", "RPPPR"]


@pytest.mark.parametrize(("net", "wanted"), list(zip(NETS, WORDS, strict=True)), ids=str)
def test_a_system_has_the_verdicts_of_the_automaton_written_by_hand(
    net: Net, wanted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    alone, _ = decided(by_hand(net), 1)
    assert "".join(w[0] for w in alone) == wanted
    for few in (1, 40):
        monkeypatch.setattr(lazily, "FEW", few)
        assert decided(system(net), 0)[0] == alone
