"""What is found in a spec: one finding per cause."""

from pathlib import Path

from haverify.run.examine import examine

HEAD = 'spec "t" version "1.0"\n'
BALL = """
automaton A { var x: m; init M with x := 0 m; mode M { flow { x' = 1 m/s } } }
property p on A { within 1 s; always x >= 0 m; expect proved }
"""
TABLE = 'enum I = 1..2\ntable T from "t.csv" { key i: I; column k: m }\n'


def found(folder: Path, text: str) -> list[str]:
    path = folder / "main.ha"
    path.write_text(HEAD + text, encoding="utf-8")
    return [d.code for d in examine(str(path)).found]


def test_what_a_missing_or_broken_table_would_have_read_is_not_unused(tmp_path: Path) -> None:
    text = TABLE + "const k = 1 m\nproperty q { holds T[1].k > k; expect proved }\n" + BALL
    assert found(tmp_path, text) == ["HA006"]
    (tmp_path / "t.csv").write_text("i,l\n1,5\n2,6\n", encoding="utf-8")
    assert found(tmp_path, text) == ["HA210"]
    axes = 'table T from "t.csv" { axis i: s; column l: m }\nconst k = 1 m\n'
    (tmp_path / "t.csv").write_text("i,l\n2,5\n1,6\n", encoding="utf-8")
    assert found(tmp_path, axes + "property q { holds T.l(1 s) > k; expect proved }\n" + BALL) == ["HA203"]


def test_a_block_with_broken_text_has_no_other_findings(tmp_path: Path) -> None:
    broken = BALL.replace("init M with x := 0 m;", "init M with x := < 0 m; let y = 1 m + 1 s;")
    assert found(tmp_path, broken) == ["HA001"]
    assert found(tmp_path, "const a = <\nconst b = a\n" + BALL) == ["HA001"]


def test_broken_text_comes_before_other_findings(tmp_path: Path) -> None:
    assert found(tmp_path, "const a = 1 m + 1 s\n" + BALL + "const b = = 2\n") == ["HA001", "HA101"]
