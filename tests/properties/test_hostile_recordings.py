"""Files that are damaged anywhere are read, or refused with findings; nothing else happens."""

import random
from pathlib import Path

import pytest
from tests.walks import WALKS

from haverify.cli import main

PIECES = ["nan", "0", "1e308", "-1e308", "1e-300", "", "9" * 50, "1e99999", "\t", "\n", "\x00", "é", "endheader", "{"]


def damaged(text: str, chance: random.Random) -> str:
    """The text with some bytes, lines or cells exchanged, removed or repeated."""
    for _ in range(chance.choice([1, 2, 5, 20])):
        lines = (text or "x").split("\n")
        k, how = chance.randrange(len(lines)), chance.randrange(4)
        if how == 0:
            cells = lines[k].split("\t")
            cells[chance.randrange(len(cells))] = chance.choice(PIECES)
            lines[k] = "\t".join(cells)
        elif how == 1:
            del lines[k : k + chance.randrange(1, 40)]
        elif how == 2:
            lines.insert(k, chance.choice(lines))
        text = "\n".join(lines)
        if how == 3 and text:
            at = chance.randrange(len(text))
            text = text[:at] + chance.choice(PIECES) + text[at + chance.randrange(1, 300) :]
    return text


@pytest.mark.parametrize("name", ["normal_gait.mot", "referenceCoordinates_2d_halfcycle.sto", "bmc_walk1.trc"])
def test_damaged_files_are_read_or_refused(name: str, tmp_path: Path) -> None:
    chance = random.Random(7)
    text = (WALKS / name).read_text(encoding="utf-8")
    codes = set()
    for _ in range(8):
        path = tmp_path / name
        path.write_text(damaged(text, chance), encoding="utf-8")
        codes.add(main(["fit", str(path), "-o", str(tmp_path / "walk.ha")]))
    assert codes <= {0, 2}
    assert 2 in codes
