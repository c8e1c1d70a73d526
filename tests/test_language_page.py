"""Every spec in docs/language.md is read without an error, beside the data files that the page shows."""

import re
from pathlib import Path

import pytest

from haverify.diagnostics.codes import is_error
from haverify.run.examine import examine

PAGE = (Path(__file__).parents[1] / "docs" / "language.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)(?: +(\S+))?\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
SPECS = [text for kind, _, text in BLOCKS if kind == "ha"]


@pytest.mark.parametrize("number", range(len(SPECS)))
def test_a_spec_of_the_page_is_read_without_an_error(number: int, tmp_path: Path) -> None:
    for kind, name, text in BLOCKS:
        if kind == "csv":
            (tmp_path / name).write_text(text, encoding="utf-8")
    path = tmp_path / "page.ha"
    path.write_text(SPECS[number], encoding="utf-8")
    found = examine(str(path))
    assert [d.message for d in found.found if is_error(d)] == []
    assert found.spec is not None


def test_the_page_has_specs_and_all_rules() -> None:
    assert len(SPECS) >= 6
    assert re.findall(r"^- \*\*S(\d+)\b", PAGE, re.MULTILINE) == [str(n) for n in range(1, 29)]
