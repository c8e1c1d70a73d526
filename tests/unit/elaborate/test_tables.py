"""Tables: constants with their cells, degrees, tolerances, and what can be wrong in a file."""

from fractions import Fraction

import pytest
from tests.unit.elaborate.texts import healthy, read

from haverify.model.core import expr_to_json

POLY = """
enum Phase { LR, TS }
table T from "t.csv" { key phase: Phase; poly p1..p3 descending in x: s -> deg; add error; digits 4 }
automaton A {
  var x: s
  let y: deg = T[phase](x)
  init LR with x := 0 s
  mode Run for phase in Phase { flow { x' = 1 } }
}
property p on A { always y <= 5 deg }
"""
GOOD = "phase,p1,p2,p3,error\nLR,1.14e+04,-.2,+2.8,0\nTS,5,993,,-1\n"


def test_coefficients_are_constants_with_units_halves_and_cells() -> None:
    spec = healthy(POLY, {"t.csv": GOOD})
    found = {c.name: (c.value.args[0], str(c.unit), c.half) for c in spec.constants}
    assert found == {
        "T_LR_p1": (11400, "deg/s^2", 5),
        "T_LR_p2": (Fraction(-1, 5), "deg/s", Fraction(1, 20000)),
        "T_LR_p3": (Fraction(14, 5), "deg", Fraction(1, 2000)),
        "T_LR_error": (0, "deg", None),
        "T_TS_p1": (5, "deg/s", Fraction(1, 2000)),
        "T_TS_p2": (993, "deg", Fraction(1, 20)),
        "T_TS_error": (-1, "deg", None),
    }
    assert [(c.row, c.column, c.constant) for c in spec.cells][:2] == [(2, "p1", "T_LR_p1"), (2, "p2", "T_LR_p2")]
    assert {c.file for c in spec.cells} == {"t.csv"}


def test_a_polynomial_is_a_sum_of_powers_and_trailing_empty_cells_lower_its_degree() -> None:
    spec = healthy(POLY, {"t.csv": GOOD})
    lr, ts = (m.lets[0].expr for m in spec.automata[0].modes)
    x = ["var", "x"]
    assert expr_to_json(lr) == [
        "+", ["*", ["const", "T_LR_p1"], ["^", x, "2"]], ["*", ["const", "T_LR_p2"], x], ["const", "T_LR_p3"],
        ["const", "T_LR_error"],
    ]  # fmt: skip
    assert expr_to_json(ts) == ["+", ["*", ["const", "T_TS_p1"], x], ["const", "T_TS_p2"], ["const", "T_TS_error"]]


def test_ascending_columns_start_with_the_constant_term() -> None:
    text = POLY.replace("descending", "ascending").replace("add error; ", "")
    spec = healthy(text, {"t.csv": "phase,p1,p2,p3\nLR,1,2,3\nTS,4,5,\n"})
    assert expr_to_json(spec.automata[0].modes[1].lets[0].expr) == [
        "+", ["const", "T_TS_p1"], ["*", ["const", "T_TS_p2"], ["var", "x"]],
    ]  # fmt: skip


def test_quotes_blanks_line_ends_and_spaces_do_not_matter() -> None:
    text = '"phase" , p1,p2,p3,error\n\nLR, "1.14e+04" ,-.2,+2.8,0\n TS,5,993,,-1\n\n'
    values = [c.value for c in healthy(POLY, {"t.csv": text}).constants]
    assert values == [c.value for c in healthy(POLY, {"t.csv": GOOD}).constants]


BAD = {
    "no row for a key": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\n", '"t.csv"'),
    "row twice": ("HA210", GOOD + "TS,5,993,,-1\n", "TS,5,993,,-1"),
    "no such column": ("HA210", "phase,p1,p2,error\nLR,1,2,0\nTS,1,2,0\n", "poly p1..p3 descending in x: s -> deg"),
    "column twice": ("HA210", "phase,p1,p2,p3,p1,error\nLR,1,2,3,4,0\nTS,1,2,3,4,0\n", "p1"),
    "empty before filled": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS,1,,3,0\n", ""),
    "no coefficient at all": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS,,,,0\n", "TS,,,,0"),
    "not a number": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS,1,2x,3,0\n", "2x"),
    "number too large": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS,1,1e999999999,3,0\n", "1e999999999"),
    "more cells than the header": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS,1,2,3,0,77\n", "77"),
    "one cell": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS\n", ""),
    "no column in the middle": (
        "HA210",
        "phase,p1,p3,error\nLR,1,2,0\nTS,1,2,0\n",
        "poly p1..p3 descending in x: s -> deg",
    ),
    "another column in the middle": (
        "HA210",
        "phase,p1,p2,note,p3,error\nLR,1,2,1,3,0\nTS,1,2,1,3,0\n",
        "poly p1..p3 descending in x: s -> deg",
    ),
    "columns in disorder": (
        "HA210",
        "phase,p2,p1,p3,error\nLR,1,2,3,0\nTS,1,2,3,0\n",
        "poly p1..p3 descending in x: s -> deg",
    ),
    "fewer cells": ("HA210", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTS,1,2,3\n", ""),
    "key misspelt": ("HA211", "phase,p1,p2,p3,error\nLR,1,2,3,0\nTSX,1,2,3,0\n", "TSX"),
    "empty file": ("HA210", "", '"t.csv"'),
}


@pytest.mark.parametrize("name", BAD)
def test_a_fault_in_the_file_is_one_finding_in_its_cell(name: str) -> None:
    code, text, place = BAD[name]
    spec, found, sources = read(POLY, {"t.csv": text})
    assert [(d.code, sources[d.span.path].at(d.span)) for d in found if d.span] == [(code, place)]
    assert [claim for claim, _, _ in spec.lost] == ["p"]


def test_a_misspelt_key_has_a_fix() -> None:
    _, found, _ = read(POLY, {"t.csv": "phase,p1,p2,p3,error\nLR,1,2,3,0\nTz,1,2,3,0\n"})
    assert found[0].message == "'Tz' is not a Phase; did you mean TS?"
    assert found[0].fix is not None and found[0].fix.edits[0].text == "TS"


def test_a_bad_row_loses_only_what_reads_it() -> None:
    text = 'enum I = 1..2\ntable T from "t.csv" { key i: I; column k: m }\nproperty p for i in I { holds T[i].k > 0 m }'
    spec, found, _ = read(text, {"t.csv": "i,k\n1,5\n2,x\n"})
    assert [d.code for d in found] == ["HA210"]
    assert [c.name for c in spec.claims] == ["p[1]"]
    assert [name for name, _, _ in spec.lost] == ["p[2]"]


def test_tolerances_make_params_around_the_printed_constant() -> None:
    text = 'enum I = 1..2\ntable T from "t.csv" { key i: I; column k: m +- dk; column c: s +- 0.5 s }\n'
    spec = healthy(text + "property p { holds T[1].k > T[2].k }", {"t.csv": "i,k,dk,c\n1,5,1,7\n2,6,2,8\n"})
    ranges = {p.name: (p.range.low.args[0], p.range.high.args[0], p.default.name) for p in spec.params}
    assert ranges["T_2_k_true"] == (4, 8, "T_2_k")
    assert ranges["T_1_c_true"] == (Fraction(13, 2), Fraction(15, 2), "T_1_c")
    assert expr_to_json(spec.claims[0].goals[0].condition) == [">", ["param", "T_1_k_true"], ["param", "T_2_k_true"]]


def test_an_index_that_the_run_decides_picks_the_row() -> None:
    text = """
enum Gear = 1..3
table Box from "t.csv" { key gear: Gear; column ratio: 1 }
automaton A { var g: Gear; var x: 1; init M with { g := 1; x := 0 }; mode M { flow { x' = Box[g].ratio * 1 Hz } } }
"""
    spec = healthy(text, {"t.csv": "gear,ratio\n1,2\n2,3\n3,4\n"})
    cases = [
        "if", ["==", ["var", "g"], "1"], ["const", "Box_1_ratio"],
        ["if", ["==", ["var", "g"], "2"], ["const", "Box_2_ratio"], ["const", "Box_3_ratio"]],
    ]  # fmt: skip
    assert expr_to_json(spec.automata[0].modes[0].flow[0].rate) == ["*", cases, "1"]


def test_a_changed_file_is_a_warning_with_a_safe_fix() -> None:
    text = POLY.replace("digits 4", 'digits 4; sha256 "0000"')
    spec, found, sources = read(text, {"t.csv": GOOD})
    assert [d.code for d in found] == ["HA215"]
    assert found[0].fix is not None and found[0].fix.safe
    assert found[0].fix.edits[0].text == f'sha256 "{sources["t.csv"].sha256}"'
    assert [c.name for c in spec.claims] == ["p"]


def test_a_number_beyond_all_measure_is_not_called_no_number() -> None:
    _, found, _ = read(POLY, {"t.csv": GOOD.replace("993", "1e5000")})
    told = "t.csv: '1e5000' in column 'p2' is too large or too small to be meant"
    assert [(d.code, d.message) for d in found] == [("HA210", told)]


@pytest.mark.parametrize("digits", ["0", "1.5", "51", "1e9", "999999999"])
def test_digits_are_few_and_whole(digits: str) -> None:
    _, found, _ = read(POLY.replace("digits 4", f"digits {digits}"), {"t.csv": GOOD})
    assert [(d.code, d.message) for d in found] == [("HA105", "a number of digits is an integer from 1 to 50")]


def test_the_missing_column_of_a_polynomial_is_named() -> None:
    _, found, _ = read(POLY, {"t.csv": "phase,p1,p3,error\nLR,1,2,0\nTS,1,2,0\n"})
    assert found[0].message == "t.csv has no column 'p2', which `p1..p3` asks for"


def test_of_many_faulty_rows_ten_are_shown_and_the_rest_counted() -> None:
    _, found, _ = read(POLY, {"t.csv": GOOD + "TS,5,993,,-1\n" * 40})
    assert len(found) == 11
    assert found[-1].message == "t.csv: 30 more findings in its rows are not shown"


def test_semicolons_are_told_from_commas() -> None:
    _, found, _ = read(POLY, {"t.csv": GOOD.replace(",", ";")})
    assert [(d.code, d.help) for d in found] == [("HA210", "separated by ';'? a comma is expected")]


def test_of_what_is_no_table_little_is_shown() -> None:
    _, found, _ = read(POLY, {"t.csv": "s" * 100 + "\nsecret\n"})
    assert [d.message for d in found] == [f"t.csv has no column 'phase'; it has {'s' * 40}..."]
    assert found[0].span is not None and found[0].span.path == "a.ha"


def test_rows_of_tables_with_axes_and_of_matrices_are_as_wide_as_they_should_be() -> None:
    axes = 'table T from "t.csv" { axis t: s; column v: m }\nproperty p { holds T.v(1 s) > 0 m }'
    _, found, _ = read(axes, {"t.csv": "t,v\n0,1\n1,2,3\n"})
    assert [d.message for d in found] == ["t.csv: this row has 3 cells, the header has 2"]
    matrix = 'enum I = 1..2\ntable T from "t.csv" { matrix I by I: m }\nproperty p { holds 1 < 2 }'
    _, found, _ = read(matrix, {"t.csv": "1,2\n3\n"})
    assert [d.message for d in found] == ["t.csv: this row has 1 cell, I has 2"]


def test_of_many_misspelt_keys_the_first_have_fixes() -> None:
    _, found, _ = read(POLY, {"t.csv": GOOD + "Tz,5,993,,-1\n" * 40})
    assert [d.fix is not None for d in found] == [True] * 10 + [False]
