"""Figures: drawn from the core alone, right where it matters, absent where nothing can be drawn."""

import json
import pathlib
import re
from typing import Any
from xml.etree import ElementTree

import pytest
from tests.unit.report.facts import claim, margin, part, whole

from haverify.model.core import canonical, to_core
from haverify.report import report
from haverify.report.figures import fuzzy, graphs, lanes, of_claims, orbits, plots, svg
from haverify.report.figures.bands import bands
from haverify.report.figures.evaluate import reads, scope
from haverify.report.figures.material import Figure, Material, Undrawable
from haverify.report.html.style import standalone
from haverify.run.examine import read

SAMPLE = pathlib.Path(__file__).parents[2] / "samples"

X, Y = ["var", "x"], ["let", "y"]


def mode(name: str, expr: Any, domain: Any) -> dict[str, Any]:
    let = {"name": "y", "type": "real", "unit": "deg", "expr": expr}
    return {"name": name, "domain": domain, "flow": [{"var": "x", "rate": "1"}], "lets": [let], "terminal": False}


def automaton(**changes: Any) -> dict[str, Any]:
    """Two modes: `y = x^2` up to 1 s, then `y = 3 - x` up to 2 s."""
    up = mode("Up", ["^", X, "2"], ["<=", X, "1"])
    down = mode("Down", ["-", "3", X], ["and", [">=", X, "1"], ["<=", X, "2"]])
    edges = [
        {"name": "Up_Down", "source": "Up", "target": "Down", "urgent": True, "guard": [">=", X, "1"], "resets": []},
        {"name": "again", "source": "Down", "target": "Up", "urgent": False, "guard": True, "resets": []},
    ]
    whole = {
        "name": "A", "constants": [], "params": [], "inputs": [], "lets": [], "modes": [up, down], "edges": edges,
        "vars": [{"name": "x", "type": "real", "unit": "s", "low": "0", "high": "2"}],
        "init": [{"mode": "Up", "where": True, "with": []}], "priorities": [],
    }  # fmt: skip
    return {**whole, **changes}


def core(condition: Any, a: dict[str, Any] | None = None, **changes: Any) -> Material:
    goal = {"kind": "always", "condition": condition, "window": None, "within": None}
    claims = [{"name": "low", "on": "A", "kind": "property", "goals": [goal]}]
    lists = ("constants", "params", "enums", "cellular", "fuzzy", "systems")
    whole = {**{k: [] for k in lists}, "automata": [a or automaton()], "claims": claims, **changes}
    return Material(json.loads(json.dumps(whole)))


def drawn(material: Material, c: report.Claim | None = None) -> Figure:
    (figure,) = of_claims.of_claim(material, c or claim())
    ElementTree.fromstring(standalone(figure.svg))
    return figure


def polylines(figure: Figure, kind: str) -> list[list[tuple[float, float]]]:
    found = re.findall(rf'<polyline class="{kind}" points="([^"]*)"', figure.svg)
    return [[(float(x), float(y)) for x, y in (p.split(",") for p in text.split())] for text in found]


def test_a_curve_for_each_mode_and_its_bounds() -> None:
    figure = drawn(core(["and", ["<=", Y, "3"], ["implies", ["at", "Up"], [">=", Y, "0"]]]))
    up, down = polylines(figure, "curve")
    assert up[-1][0] == pytest.approx(down[0][0])
    assert up[0][1] > up[-1][1] > down[0][1]  # y grows upwards, coordinates downwards
    assert len(polylines(figure, "bound")) == 3
    assert figure.claim == "low"
    assert "Up" in figure.svg


def test_only_what_violates_its_bound_is_red() -> None:
    figure = drawn(core(["<=", Y, "3/2"]), claim(verdict="refuted", parts=[part("refuted", mode="Down")]))
    (bad,) = polylines(figure, "curve bad")
    _, down = polylines(figure, "curve")
    assert bad[0] == down[0]
    assert (bad[-1][0] - down[0][0]) / (down[-1][0] - down[0][0]) == pytest.approx(0.5, abs=0.05)


def test_a_bound_that_is_met_exactly_is_no_violation() -> None:
    assert not polylines(drawn(core(["<=", Y, "2"])), "curve bad")
    assert not polylines(drawn(core(["implies", ["at", "Up"], ["<=", Y, "1"]])), "curve bad")


def test_derivatives_and_differences_are_drawn() -> None:
    figure = drawn(core(["<=", ["abs", ["der", Y]], ["+", Y, "5"]]))
    assert "abs(der(y)) - y + 5" in figure.svg
    figure = drawn(core(["<=", ["der", Y], "2"]))
    assert "der(y) [deg/s]" in figure.svg
    up, _ = polylines(figure, "curve")
    assert up[0][1] - up[-1][1] > 50


def test_claims_over_time_show_the_levels_they_compare_with() -> None:
    inner = ["eventually", "0", "1", ["<=", Y, "1/2"]]
    stl = {"kind": "stl", "condition": ["globally", "0", "2", ["implies", ["jump", "again"], inner]]}
    claims = [{"name": "low", "on": "A", "kind": "property", "goals": [stl]}]
    figure = drawn(core(True, claims=claims), claim(verdict="refuted"))
    assert len(polylines(figure, "bound")) == 2
    assert not polylines(figure, "curve bad")
    assert figure.caption == "what the values are compared with dashed"


def test_jumps_are_marked_where_they_are_claimed_about() -> None:
    jump = ["<=", ["abs", ["-", Y, ["pre", Y]]], "1/2"]
    p = part("refuted", mode="Up -> Down", kind="jump", margin=margin("-0.5", at="Up -> Down, x = 1 s"))
    figure = drawn(core(jump), claim(verdict="refuted", parts=[p]))
    assert 'class="jump bad"' in figure.svg
    assert "the steps are what the claim bounds" in figure.caption


def test_the_smallest_margin_is_marked_at_its_instant() -> None:
    parts = [
        part(mode="Up", margin=margin("3", at="Up, x = 1/2 s")),
        part(mode="Down", margin=margin("1", at="Down, x = 1.5 s")),
    ]
    figure = drawn(core(["<=", Y, "3"]), claim(parts=parts))
    assert "margin 1 deg" in figure.svg
    assert figure.svg.count("<circle") == 1


def test_what_is_far_off_the_scale_is_said_in_figures() -> None:
    high = mode("Up", ["+", "25000", X], ["<=", X, "1"])
    a = automaton(modes=[high, automaton()["modes"][1]])
    figure = drawn(core(["<=", Y, "3"], a), claim(verdict="refuted", parts=[part("refuted", mode="Up")]))
    assert "\N{UPWARDS ARROW} 25000" in figure.svg
    assert "to 25001" in figure.svg
    assert ">10000<" not in figure.svg


def test_cells_of_a_certificate_say_how_long_a_mode_lasts() -> None:
    m = core(True)
    cells = [{"mode": "Up", "entry": {"x": ["1/2", "1/2"]}, "dwell": "1/4"}]
    known = Material(m.core, {"A": {"automaton": "A", "cells": cells}})
    assert [(b.mode, b.low, b.high) for b in bands(known, m.listed("automata")[0], "x")] == [("Up", 0.5, 0.75)]


def test_modes_whose_ranges_overlap_stand_side_by_side() -> None:
    wide = automaton(modes=[mode("Up", X, ["<=", X, "2"]), mode("Down", X, ["<=", X, "2"])])
    up, down = polylines(drawn(core(["<=", Y, "3"], wide)), "curve")
    assert up[-1][0] < down[0][0]


@pytest.mark.parametrize(
    "e",
    [["input", "u"], ["let", "z"], ["sqrt", ["neg", "1"]], ["/", "1", "0"], ["^", "10", "400"], ["<="], [[]], 3, None],
)
def test_what_cannot_be_computed_has_no_figure(e: Any) -> None:
    assert of_claims.of_claim(core(["<=", ["+", Y, e], "3"]), claim()) == []


def test_a_let_that_reads_itself_has_no_figure() -> None:
    m = core(["<=", Y, "3"], automaton(modes=[mode("Up", ["+", Y, X], ["<=", X, "1"])]))
    assert of_claims.of_claim(m, claim()) == []


def test_expressions_are_computed_as_the_core_means_them() -> None:
    a = automaton(constants=[{"name": "k", "value": ["/", "1", "2"]}], params=[{"name": "p", "low": "1", "high": "3"}])
    s = scope(core(True, a), a, a["modes"][0])
    deg = ["scale", "1/180", "1", "90"]
    for e, value in [
        (["*", ["const", "k"], ["param", "p"], X], 4.0),
        (["sin", deg], 1.0),
        (["clamp", X, "0", "3"], 3.0),
        (["if", ["at", "Up"], Y, "0"], 16.0),
        (["der", ["^", X, "3"]], 48.0),
        (["der", ["abs", ["-", X, "9"]]], -1.0),
        (["min", X, "2", "7"], 2.0),
    ]:
        assert s.value(e)({"x": 4.0}) == pytest.approx(value)
    assert reads(["+", Y, ["const", "k"]], s) == {"x"}


def test_a_mode_graph_has_its_nodes_edges_and_start() -> None:
    figure = graphs.of_automaton(automaton())
    ElementTree.fromstring(standalone(figure.svg))
    assert figure.svg.count('class="arrow"') == 1
    assert figure.svg.count('class="arrow may"') == 1
    assert figure.svg.count('class="node start"') == 1
    assert "again" in figure.svg


def test_the_walk_from_the_start_gives_the_order() -> None:
    arrows = [graphs.Arrow(*p) for p in ("ac", "cb", "ba")]
    assert graphs.ordered("abc", arrows, ["c"]) == ["c", "b", "a"]


def test_a_run_over_time_shows_modes_and_variables() -> None:
    run = report.Run(
        ["Up", "Down"], ["Up_Down"], ["0", "1", "3/2"], ["0", "1", "1.5"],
        [{"x": "0"}, {"x": "1/2"}, {"x": "1"}], [{"x": "0"}, {"x": "0.5"}, {"x": "1"}], {}, {"x": "s"}, "y",
    )  # fmt: skip
    figure = drawn(core(True), claim(verdict="refuted", run=run))
    assert [len(line) for line in polylines(figure, "curve")] == [2, 2]
    assert "violated at t = 1.5 s" in figure.caption


def test_a_run_of_a_clock_alone_shows_its_modes() -> None:
    run = report.Run(
        ["Up"], [], ["0", "1"], ["0", "1"], [{"x": "0"}, {"x": "1"}], [{"x": "0"}, {"x": "1"}], {}, {"x": "s"}, None
    )
    figure = drawn(core(True), claim(run=run))
    assert not polylines(figure, "curve")
    assert ">Up<" in figure.svg


def test_a_run_of_a_system_has_a_lane_for_each_part() -> None:
    run = report.Run(
        ["p[1].Idle, p[2].Idle", "p[1].Busy, p[2].Idle"], ["go"], ["0", "1", "1"], ["0", "1", "1"],
        [{"owner": "0"}] * 3, [{"owner": "0"}, {"owner": "1"}, {"owner": "1"}], {}, {}, "mutex",
    )  # fmt: skip
    figure = lanes.of_run(claim(verdict="refuted", run=run))
    ElementTree.fromstring(standalone(figure.svg))
    assert figure.svg.count('class="node changed"') == 2
    for text in ("p[1]", "p[2]", "owner", "Busy", "go", "t = 1 s"):
        assert f">{text}<" in figure.svg


RULE = {"name": "R", "rules": [["00", "01"], ["01", "00"], ["10", "00"]], "first": None, "second": None}


def test_orbits_are_cycles_with_what_leads_into_them() -> None:
    figure = orbits.of_rule(Material(), RULE)
    ElementTree.fromstring(standalone(figure.svg))
    assert figure.caption == "3 cells: 1 cycle of length 2"
    assert figure.svg.count('class="arrow"') == 3


def test_cells_without_a_rule_and_second_rules_are_red() -> None:
    rule = {**RULE, "rules": [["00", "01"], ["00", "10"], ["10", "10"]]}
    figure = orbits.of_rule(Material(), rule)
    assert "1 cell without a rule (red)" in figure.caption
    assert figure.svg.count('class="node bad"') == 1
    assert figure.svg.count('class="arrow bad"') == 1


def test_cells_are_named_by_their_codes() -> None:
    enums = [{"name": n, "values": [f"{n}0", f"{n}1"], "codes": ["0b0", "0b1"]} for n in "LS"]
    figure = orbits.of_rule(Material({"enums": enums}), {**RULE, "first": "L", "second": "S"})
    assert ">L1 S0<" in figure.svg


def test_no_two_cells_are_drawn_over_each_other() -> None:
    rules = [[f"{k:05b}", f"{(k * k + 7) % 29:05b}"] for k in range(29)]
    figure = orbits.of_rule(Material(), {**RULE, "rules": rules})
    boxes = [
        tuple(map(float, b))
        for b in re.findall(
            r'<rect class="node" x="([-\d.]+)" y="([-\d.]+)" width="([\d.]+)" height="([\d.]+)"', figure.svg
        )
    ]
    assert len(boxes) == 29
    for k, (x, y, w, h) in enumerate(boxes):
        assert all(abs(x - u) >= w or abs(y - v) >= h for u, v, _, _ in boxes[:k])


def system(**changes: Any) -> dict[str, Any]:
    def term(name: str, *corners: str) -> dict[str, Any]:
        return {"name": name, "shape": {2: "ramp", 3: "tri", 4: "trap"}[len(corners)], "corners": list(corners)}

    force = {"name": "f", "unit": "N", "low": "0", "high": "4", "source": None, "terms": [term("high", "0", "4")]}
    roll = {"name": "r", "unit": "1", "low": "0", "high": "1", "source": None, "terms": [term("mid", "0", "1/2", "1")]}
    rules = [
        {"name": "1", "output": "o", "premise": ["and", ["is", "f", "high"], ["is", "r", "mid"]], "term": "go"},
        {"name": "2", "output": "o", "premise": ["not", ["is", "f", "high"]], "term": "stay"},
    ]
    outputs = [{"name": "o", "terms": ["stay", "go"]}]
    return {
        "name": "F",
        "inputs": [force, roll],
        "outputs": outputs,
        "logic": ["min", "max"],
        "rules": rules,
        **changes,
    }


def test_degrees_are_those_of_the_shapes() -> None:
    force, roll = (i["terms"][0] for i in system()["inputs"])
    assert [fuzzy.degree(force, x) for x in (-1, 1, 5)] == [0.0, 0.25, 1.0]
    assert [fuzzy.degree(roll, x) for x in (0, 0.25, 0.5, 0.75, 1)] == [0.0, 0.5, 1.0, 0.5, 0.0]
    step = {"name": "s", "shape": "trap", "corners": ["0", "0", "1", "1"]}
    assert [fuzzy.degree(step, x) for x in (0, 1, 1.1)] == [1.0, 1.0, 0.0]


def test_terms_and_the_strongest_conclusion_are_drawn() -> None:
    m = Material({"fuzzy": [system()]})
    terms, chart = plots.of_model(m)
    for figure in (terms, chart):
        ElementTree.fromstring(standalone(figure.svg))
    assert terms.svg.count('class="term') == 2
    assert ">stay<" in chart.svg
    assert ">go<" in chart.svg


def test_chained_systems_are_drawn_over_the_inputs_of_the_first() -> None:
    of = {"name": "a", "unit": "1", "low": None, "high": None, "source": ["F", "o"], "terms": []}
    rules = [{"name": "1", "output": "p", "premise": ["is", "a", "go"], "term": "on"}]
    second = system(name="G", inputs=[of], outputs=[{"name": "p", "terms": ["on"]}], rules=rules)
    (chart,) = fuzzy.conclusions(fuzzy.chain(Material({"fuzzy": [system(), second]})), second)
    assert "over f and r" in chart.caption


@pytest.mark.parametrize(
    "broken", [{}, {"automata": 3}, {"automata": [{}], "cellular": [{"rules": [[1]]}], "fuzzy": [{}]}]
)
def test_foreign_files_have_no_figures(broken: dict[str, Any]) -> None:
    assert plots.every(whole(claim()), Material(broken)) == []


def test_drawings_hold_no_infinite_numbers() -> None:
    assert svg.number(float("inf")) == "1000000"
    assert svg.number(float("nan")) == "0"
    assert svg.ticks(0.0, float("inf"), 5) == []


def test_ticks_of_any_range_are_few() -> None:
    for low, high in [(0, 1e-9), (1e8, 1e8 + 1), (-3, 7), (0, 1e300)]:
        assert len(svg.ticks(float(low), float(high), 5)) <= 5


def test_a_rule_by_formula_has_no_orbits() -> None:
    with pytest.raises(Undrawable):
        orbits.of_rule(Material(), {**RULE, "rules": []})


SAMPLES = {
    "leg_ca": ["orbits_Partner"],
    "push_recovery": ["modes_Push", "terms_FIS1", "map_FIS1_action", "map_FIS2_strategy", "map_Printed_verdict"],
    "fischer": ["modes_Process"],
    "gait": ["modes_Gait", "outputs_Gait"],
}


@pytest.mark.parametrize("name", SAMPLES)
def test_models_of_each_kind_have_their_figures(name: str) -> None:
    spec, _, _ = read(str(SAMPLE / f"{name}.ha"))
    assert spec is not None
    figures = plots.of_model(Material(json.loads(canonical(to_core(spec)))))
    assert [f.name for f in figures] == SAMPLES[name]
    for f in figures:
        ElementTree.fromstring(standalone(f.svg))


JUNK = [None, True, [], {}, "", "x", "1/0", "1e999999", 5, [[]], ["let", "y"], ["^", ["var", "x"], "99"]]


Path = tuple[Any, ...]


def places(x: Any) -> list[Path]:
    """The way to every place in nested lists and objects."""
    keys = list(x) if isinstance(x, dict) else list(range(len(x))) if isinstance(x, list) else []
    return [(k, *rest) for k in keys for rest in [(), *places(x[k])]]


def put(x: Any, path: Path, value: Any) -> None:
    for key in path[:-1]:
        x = x[key]
    x[path[-1]] = value


CELLS = {"A": {"automaton": "A", "cells": [{"mode": "Up", "entry": {"x": ["0", "0"]}, "dwell": "1"}]}}
CONDITION = ["implies", ["at", "Up"], ["<=", ["abs", ["der", Y]], ["*", "2", X]]]
CORES = {
    "automaton": (core(CONDITION).core, CELLS, JUNK),
    "rule": ({"cellular": [RULE]}, {}, JUNK),
    "fuzzy": ({"fuzzy": [system()]}, {}, JUNK[2:8:2]),
}


@pytest.mark.parametrize("name", CORES)
def test_a_core_damaged_anywhere_stops_no_page(name: str) -> None:
    text = json.dumps(CORES[name][:2])
    told = whole(claim(parts=[part(mode="Up")]))
    counts = set()
    for k, path in enumerate(p for p in places(json.loads(text)) if len(p) > 1):
        for junk in (CORES[name][2] * 3)[k % 5 :: 5][:4]:
            both = json.loads(text)
            put(both, path, junk)
            counts.add(len(plots.every(told, Material(*both))))
    assert len(counts) > 1
