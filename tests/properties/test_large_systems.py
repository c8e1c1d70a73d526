"""Systems of many modes, listed as far as runs come: the same verdicts, the same certificates, runs inside."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.obligations import established
from hacheck.rational import Meter
from hacheck.systems import SystemCheck
from haverify.analyses.networks import lazily
from haverify.analyses.networks.product import Product
from haverify.analyses.networks.whole import whole_of
from haverify.analyses.portfolio import Contexts, decide
from haverify.model.core import to_core
from haverify.model.spec import Spec
from haverify.simulate.crosscheck import Beside

ROOM = (Path(__file__).parents[1] / "samples" / "rooms.ha").read_text().split("system House")[0]
CLAIMS = """
property warm on House { within 1.5; always r[1].T >= 17.9 }
property third on House { within 1.5; always r[3].T >= 18.2 }
property heated on House { reach at(r[2].On) within 1.5 }
property soon on House { can reach at(r[1].On) and at(r[2].Off) within 1.5 }
property hot on House { can reach r[1].T >= 25 within 1.5 }
"""


def house(rooms: int, claims: str = CLAIMS) -> Spec:
    """Rooms in a ring, one warmer than the one before; each is cooled by the two beside it."""
    parts = [
        f"  part r[{k}] = Room with {{ first = {18 + 0.3 * k:.1f}, left = r[{(k - 2) % rooms + 1}].T, "
        f"right = r[{k % rooms + 1}].T }}"
        for k in range(1, rooms + 1)
    ]
    text = ROOM.replace("1..8", f"1..{rooms}")
    spec, _, _ = read("\n".join([text + "system House {", *parts, "}"]) + claims)
    assert spec.claims
    return spec


def shown(spec: Spec, few: int, monkeypatch: pytest.MonkeyPatch, order: int = 1) -> dict[str, Any]:
    """What is shown of each claim, the claims taken in an order."""
    monkeypatch.setattr(lazily, "FEW", few)
    contexts = Contexts(spec)
    return {c.name: decide(spec, c, contexts) for c in spec.claims[::order]}


def test_modes_listed_as_runs_come_decide_what_all_modes_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = house(4)
    lazy, full = shown(spec, 1, monkeypatch), shown(spec, 40, monkeypatch)
    words = {n: type(e.verdict).__name__ for n, e in lazy.items()}
    assert words == {n: type(e.verdict).__name__ for n, e in full.items()}
    assert words == {"warm": "Proved", "third": "Refuted", "heated": "Proved", "soon": "Proved", "hot": "Refuted"}
    core = Core(to_core(spec))
    for found in (lazy, full):
        files = {k: v for e in found.values() for k, v in e.cells.items()}
        check = SystemCheck(core, core.systems["House"], files.__getitem__)
        for name, e in found.items():
            Meter.left = 60_000_000
            assert established(core, core.claims[name], e.certificate, None, lambda _, c=check: c)


def test_certificates_do_not_depend_on_what_was_asked_before(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = house(4)
    there, back = shown(spec, 1, monkeypatch), shown(spec, 1, monkeypatch, order=-1)
    assert {n: e.certificate for n, e in there.items()} == {n: e.certificate for n, e in back.items()}
    assert {n: e.cells for n, e in there.items()} == {n: e.cells for n, e in back.items()}
    assert len({tuple(e.certificate["whole"]) for e in there.values() if e.certificate}) > 1


@pytest.mark.parametrize("rooms", [10, 14])
def test_only_what_runs_come_to_is_listed(rooms: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """14 rooms have 16384 modes; how many are come to does not depend on the number of rooms."""
    spec = house(rooms, "\nproperty warm on House { within 0.8; always r[1].T >= 17.9 }\n")
    e = shown(spec, 40, monkeypatch)["warm"]
    assert type(e.verdict).__name__ == "Proved" and e.certificate is not None
    offs = [f"r[{k}].Off" for k in range(1, rooms + 1)]
    ons = [f"r[{k}].On" for k in range(1, rooms + 1)]
    assert set(e.certificate["whole"]) == {", ".join(ons[:k] + offs[k:]) for k in range(len(e.certificate["whole"]))}
    assert 2 <= len(e.certificate["whole"]) <= 5


def test_sampled_runs_stay_inside_what_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = house(8, "\n" + CLAIMS.splitlines()[1] + "\n")
    e = shown(spec, 40, monkeypatch)["warm"]
    assert e.certificate is not None
    whole = whole_of(spec, "House", to_core(spec), e.certificate["whole"])
    beside = Beside(whole, whole.automata[0], whole.claims[0], e.flowpipe)
    assert beside.disagreement(20.0, runs=40) is None and beside.checked == 40


def test_what_is_open_has_no_edges_and_is_told() -> None:
    spec = house(4)
    product = Product(spec, to_core(spec), "House", frozenset())
    automaton = product.automaton()
    assert automaton.open == {m.name for m in automaton.modes} - {e.source for e in automaton.edges}
    assert len(automaton.modes) == 5 and len(automaton.open) == 4
