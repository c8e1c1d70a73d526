"""Tables 5.1 to 5.6 of the thesis are fits of a public recording, cell by cell; the page that says so is up to date."""

from tests.refit_page import ROOT, page, rows

CELLS = rows()


def test_all_42_cells_are_refitted() -> None:
    assert len(CELLS) == 42
    assert sum(len(row.coefficients) for row in CELLS.values()) == 176


def test_every_coefficient_is_the_refitted_one_but_for_four_signs() -> None:
    other = {
        (joint, phase, i + 1)
        for (joint, phase), row in CELLS.items()
        for i, c in enumerate(row.coefficients)
        if c.has_other_sign
    }
    assert other == {("lk", "LR", 4), ("lk", "PS", 1), ("lk", "IS", 2), ("rk", "MSW", 2)}
    every = [c for row in CELLS.values() for c in row.coefficients]
    assert all(c.agrees for c in every if not c.has_other_sign)


def test_the_added_constants_are_the_needed_ones_to_a_degree_but_one() -> None:
    far = {cell for cell, row in CELLS.items() if abs(row.error - row.offset) > 1}
    assert far == {("lk", "MST")}


def test_the_page_is_what_the_recording_and_the_tables_give() -> None:
    assert (ROOT / "docs" / "gait_refit.md").read_text(encoding="utf-8") == page()
