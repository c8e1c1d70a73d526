"""Cells of automata: shared, with parts called like the enumerations, also of an imported file."""

from pathlib import Path

from haverify.model.expression import nodes
from haverify.run.examine import examine

HEAD = 'spec "T" version "1.0"\nenum Leg { Left, Right }\nenum Sub { IC, LR }\n'
TWO = HEAD + (
    "cellular A { cell Cell = Leg ++ Sub; next(c) = c }\n"
    "cellular B { cell Cell = Leg ++ Sub; next(c) = (Left, IC) }\n"
    "property p on A { holds forall c in Cell: next(B.next(c)) == B.next(next(c)); expect proved }\n"
)


def codes_and_claims(path: Path, text: str) -> tuple[list[str], list[str]]:
    path.write_text(text, encoding="utf-8")
    found = examine(str(path))
    assert found.spec is not None
    return [d.code for d in found.found], [c.name for c in found.spec.claims]


def test_automata_with_one_line_share_their_cells(tmp_path: Path) -> None:
    assert codes_and_claims(tmp_path / "a.ha", TWO) == ([], ["p"])


def test_cells_of_one_name_that_are_two_things(tmp_path: Path) -> None:
    codes, _ = codes_and_claims(
        tmp_path / "a.ha", TWO.replace("Leg ++ Sub; next(c) = (Left", "Sub ++ Leg; next(c) = (Left")
    )
    assert "HA004" in codes


def test_two_parts_of_one_name(tmp_path: Path) -> None:
    text = 'spec "T" version "1.0"\nenum Sub { IC, LR }\ncellular A { cell Cell = Sub ++ Sub; next(c) = c }\n'
    path = tmp_path / "a.ha"
    path.write_text(text, encoding="utf-8")
    (d,) = [d for d in examine(str(path)).found if d.code == "HA105"]
    assert d.message == "both parts of Cell would be called 'sub': two enumerations are needed"


def test_an_imported_automaton(tmp_path: Path) -> None:
    (tmp_path / "rules.ha").write_text(TWO, encoding="utf-8")
    path = tmp_path / "a.ha"
    claim = "property q on n.B { holds forall c in Cell: c.leg is Left implies next(c).leg == c.leg; expect proved }\n"
    path.write_text('spec "T" version "1.0"\nimport "rules.ha" as n\n' + claim, encoding="utf-8")
    found = examine(str(path))
    assert found.spec is not None
    assert [d.message for d in found.found] == []
    (q,) = found.spec.claims
    assert {n.args[1] for n in nodes(q.goals[0].condition) if n.op == "field"} == {"n_leg"}
