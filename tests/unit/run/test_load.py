"""Reading specs, imports and data files, and what can be wrong with them."""

import os
from pathlib import Path

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.elaborate.elaborate import elaborate
from haverify.run.load import Loaded, load

HEAD = 'spec "t" version "1.0"\n'
TABLE = 'enum I = 1..2\ntable T from "t.csv" { key i: I; column k: m }\nproperty p { holds T[1].k < T[2].k }\n'


def written(folder: Path, **texts: str) -> Path:
    for name, text in texts.items():
        (folder / f"{name}.ha").write_text(HEAD + text, encoding="utf-8", newline="")
    return folder / "main.ha"


def codes(path: Path) -> list[str]:
    loaded, found = load(path)
    if loaded is None:
        return [d.code for d in found]
    return [d.code for d in [*found, *elaborate(loaded.tree, loaded.files)[1]]]


def read(path: Path) -> tuple[Loaded, list[Diagnostic]]:
    loaded, found = load(path)
    assert loaded is not None
    return loaded, found


def test_imports_give_their_names_under_a_prefix(tmp_path: Path) -> None:
    path = written(tmp_path, main='import "b.ha" as lim\nproperty p { holds lim.a > 1 m }\n', b="const a = 2 m\n")
    loaded, found = read(path)
    spec, more = elaborate(loaded.tree, loaded.files)
    assert spec is not None and found + more == []
    assert [c.name for c in spec.constants] == ["lim_a"]


def test_a_file_imported_twice_is_one_file(tmp_path: Path) -> None:
    path = written(
        tmp_path, main='import "b.ha"\nimport "c.ha"\nproperty p { holds a < d }\n', b="param a in [0, 1]\n",
        c='import "b.ha"\nconst d = 2 * a\n',
    )  # fmt: skip
    loaded, found = read(path)
    spec, more = elaborate(loaded.tree, loaded.files)
    assert spec is not None and found + more == []
    assert [p.name for p in spec.params] == ["a"]


def test_import_cycle_is_one_finding_at_the_line_that_closes_it(tmp_path: Path) -> None:
    path = written(tmp_path, main='import "b.ha"\nconst a = 1\n', b='import "main.ha"\nconst b = 2\n')
    loaded, found = read(path)
    assert [d.message for d in found] == ["main.ha imports b.ha imports main.ha"]
    span = found[0].span
    assert span is not None and loaded.sources[span.path].at(span) == '"main.ha"'


def test_missing_import_says_it_once(tmp_path: Path) -> None:
    path = written(tmp_path, main='import "nowhere.ha" as n\nproperty p { holds n.a > 1 }\n')
    loaded, found = read(path)
    spec, more = elaborate(loaded.tree, loaded.files)
    assert [d.code for d in found + more] == ["HA006"]
    assert spec is not None and [name for name, _, _ in spec.lost] == ["p"]


def test_data_files_are_beside_the_spec_that_names_them(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "t.csv").write_text("i,k\n1,5\n2,6\n", encoding="utf-8")
    written(tmp_path / "inner", b=TABLE.split("property")[0])
    path = written(tmp_path, main='import "inner/b.ha"\nproperty p { holds T[1].k < T[2].k }\n')
    loaded, found = read(path)
    spec, more = elaborate(loaded.tree, loaded.files)
    assert spec is not None and found + more == []
    assert {c.file for c in spec.cells} == {"inner/t.csv"}


def test_missing_table_is_one_finding(tmp_path: Path) -> None:
    assert codes(written(tmp_path, main=TABLE)) == ["HA006"]


def test_line_ends_and_byte_order_marks_change_nothing(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_bytes(b"\xef\xbb\xbfi,k\r\n1,5\r\n2,6\r\n")
    path = tmp_path / "main.ha"
    path.write_bytes(b"\xef\xbb\xbf" + (HEAD + TABLE).replace("\n", "\r\n").encode())
    loaded, found = read(path)
    spec, more = elaborate(loaded.tree, loaded.files)
    assert spec is not None and found + more == []
    assert [c.row for c in spec.cells] == [2, 3]


def test_what_is_no_text_is_a_finding(tmp_path: Path) -> None:
    path = written(tmp_path, main=TABLE)
    for raw in (b"i,k\n1,\x00\n", b"i,k\n1,\xff\n"):
        (tmp_path / "t.csv").write_bytes(raw)
        assert codes(path) == ["HA006"]
    assert codes(tmp_path / "none.ha") == ["HA006"]
    assert codes(tmp_path) == ["HA006"]
    (tmp_path / "binary.ha").write_bytes(b"spec \x00\x01")
    assert codes(tmp_path / "binary.ha") == ["HA006"]


def test_units_and_unitless_files_do_not_mix(tmp_path: Path) -> None:
    (tmp_path / "b.ha").write_text('spec "b" version "1.0" unitless\nconst a = 2\n', encoding="utf-8")
    assert codes(written(tmp_path, main='import "b.ha"\n')) == ["HA101"]


def test_pipes_and_devices_are_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for place in (tmp_path / "pipe", Path("/dev/zero")):
        assert [d.message for d in load(place)[1]] == [f"cannot read {place}: it is not a regular file"]
        text = 'import "AT"\ntable T from "AT" { matrix I by I: m }\nnetwork N from "AT" { input a: m }\n'
        _, found = read(written(tmp_path, main=text.replace("AT", str(place))))
        assert [d.message for d in found] == [f"cannot read {place}: it is not a regular file"] * 3


def test_a_link_to_a_file_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("i,k\n1,5\n2,6\n", encoding="utf-8")
    (tmp_path / "t.csv").symlink_to(tmp_path / "data.csv")
    assert codes(written(tmp_path, main=TABLE)) == []


def test_a_file_has_a_name(tmp_path: Path) -> None:
    text = 'import ""\ntable T from "" { matrix I by I: m }\nnetwork N from " " { input a: m }\n'
    _, found = read(written(tmp_path, main=text))
    assert [(d.code, d.message) for d in found] == [("HA006", "the file name is empty")] * 3
