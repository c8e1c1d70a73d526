"""Whole report folders: what the checker accepts, and what it refuses."""

import copy
import hashlib
import importlib.util
import json
from pathlib import Path

import pytest

from hacheck.__main__ import main

_spec = importlib.util.spec_from_file_location("hacheck_tiny", Path(__file__).parent / "tiny.py")
T = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(T)
Y = ["let", "y"]
X = ["var", "x"]


def outcome(tmp_path, capsys, data, proofs, cell_files=None):
    """The exit code, and the outcome and reason of each claim."""
    T.write(tmp_path, data, proofs, cell_files)
    code = main([str(tmp_path), "--json"])
    found = json.loads(capsys.readouterr().out)
    return code, {n: c["outcome"] for n, c in found["claims"].items()}, found


def one(tmp_path, capsys, claim, verdict, *goals, model=None, cell_files=None, rounding=None, **changes):
    """The exit code for a core with one claim."""
    data = T.core([claim], model, **changes)
    proofs = {claim["name"]: T.certificate(data, claim, verdict, *goals, rounding=rounding)}
    return outcome(tmp_path, capsys, data, proofs, cell_files)[0]


LOW = T.claim("low", T.goal("always", ["<=", "0", Y]))
LOW_PARTS = (T.part("dwell", "A", "y", proof=["b"]), T.part("dwell", "B", "y", proof=["u"]))


def test_a_range_is_proved(tmp_path, capsys):
    assert one(tmp_path, capsys, LOW, "proved", T.on_cells(*LOW_PARTS)) == 0


@pytest.mark.parametrize(("bound", "code"), [("1", 0), ("999/1000", 1)])
def test_a_bound_is_decided_exactly(tmp_path, capsys, bound, code):
    claim = T.claim("high", T.goal("always", ["implies", ["at", "A"], ["<=", Y, bound]]))
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(T.part("dwell", "A", "y", proof=["u"]))) == code


def test_a_missing_part_is_refused(tmp_path, capsys):
    assert one(tmp_path, capsys, LOW, "proved", T.on_cells(LOW_PARTS[0])) == 1


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({}, 0),
        ({"dwell": "1/2"}, 1),  # a run stays longer
        ({"entry": {"x": ["1/2", "1/2"]}}, 1),  # the start is in no cell
        ({"dwell": None}, 0),  # no bound on the stay is claimed
    ],
)
def test_cells_contain_every_run(tmp_path, capsys, change, code):
    cells = copy.deepcopy(T.LOOP)
    cells["cells"][0].update(change)
    trees = [T.part("dwell", "A", "y", proof=["u"]), T.part("dwell", "B", "y", proof=["u"])]
    assert one(tmp_path, capsys, LOW, "proved", T.on_cells(*trees), cell_files={"c": cells}) == code


def test_a_forgotten_successor_is_refused(tmp_path, capsys):
    cells = T.cells(T.LOOP["cells"][0])
    trees = [T.part("dwell", "A", "y", proof=["u"]), T.part("dwell", "B", "y", proof=[])]
    assert one(tmp_path, capsys, LOW, "proved", T.on_cells(*trees), cell_files={"c": cells}) == 1


BAD = T.claim("bad", T.goal("always", ["<", Y, "7/2"]))


@pytest.mark.parametrize(
    ("run", "code"),
    [
        (T.run("0", ("1", 0)), 0),  # y = 4 just after the jump
        (T.run("1", ("1", 0)), 1),  # y = 3 at the end
        (T.run("1/4", ("1/2", 0)), 1),  # the guard does not hold
        (T.run("1/4", ("5/4", 0)), 1),  # the urgent edge was due
        (T.run("0", ("1", 0), start={**T.START, "values": {"x": "1/8"}}), 1),  # not a start
        (T.run("0", ("1", 1)), 1),  # no edge of mode A
    ],
)
def test_runs_are_walked(tmp_path, capsys, run, code):
    parts = [T.part("dwell", "A", "y", proof=["b"]), T.part("dwell", "B", "y", run=run)]
    assert one(tmp_path, capsys, BAD, "refuted", T.on_cells(*parts)) == code


@pytest.mark.parametrize(("strict", "code"), [(False, 0), (True, 0)])
def test_an_urgent_edge_fires_where_it_is_due(tmp_path, capsys, strict, code):
    model = T.automaton()
    model["edges"][0]["guard"] = [">" if strict else ">=", X, "1"]
    parts = [T.part("dwell", "A", "y", proof=["b"]), T.part("dwell", "B", "y", run=T.run("0", ("1", 0)))]
    assert one(tmp_path, capsys, BAD, "refuted", T.on_cells(*parts), model=model) == code


def test_a_plain_edge_needs_its_guard_as_written(tmp_path, capsys):
    model = T.automaton()
    model["edges"][0].update(urgent=False, guard=[">", X, "1"])
    parts = [T.part("dwell", "A", "y", proof=["b"]), T.part("dwell", "B", "y", run=T.run("0", ("1", 0)))]
    assert one(tmp_path, capsys, BAD, "refuted", T.on_cells(*parts), model=model) == 1


@pytest.mark.parametrize(("bound", "code"), [("3", 0), ("2", 1)])
def test_jumps_are_bounded(tmp_path, capsys, bound, code):
    claim = T.claim("c", T.goal("always", ["implies", ["jumped"], ["<=", ["abs", ["-", Y, ["pre", Y]]], bound]]))
    parts = [T.part("jump", w, "y", proof=["b"]) for w in ("A -> B", "B -> A")]
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(*parts)) == code


@pytest.mark.parametrize(("bound", "code"), [("2", 0), ("1", 1)])
def test_derivatives_follow_the_flow(tmp_path, capsys, bound, code):
    claim = T.claim("d", T.goal("always", ["<=", ["abs", ["der", Y]], bound]))
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(*LOW_PARTS)) == code


REACH = T.cells(
    T.cell("A", "1", sigma=["0", "0"], x=["0", "0"]),
    T.cell("B", None, meet="0", sigma=["1", "1"], x=["1", "1"]),
    rho=True,
)


@pytest.mark.parametrize(("within", "urgent", "code"), [("1", True, 0), ("1/2", True, 1), ("1", False, 0)])
def test_reach_is_proved_where_it_is_inevitable(tmp_path, capsys, within, urgent, code):
    model = T.automaton()
    model["edges"][0]["urgent"] = urgent
    claim = T.claim("r", T.goal("reach", ["at", "B"], within=within))
    entry = {"kind": "inevitable", "cells": "r", "start": T.START}
    assert one(tmp_path, capsys, claim, "proved", entry, model=model, cell_files={"r": REACH}) == code


def test_a_blocked_run_reaches_nothing(tmp_path, capsys):
    model = T.automaton()
    model["edges"][0]["guard"] = [">", X, "1"]
    model["edges"][0]["urgent"] = False
    claim = T.claim("r", T.goal("reach", ["at", "B"], within="2"))
    entry = {"kind": "inevitable", "cells": "r", "start": T.START}
    assert one(tmp_path, capsys, claim, "proved", entry, model=model, cell_files={"r": REACH}) == 1
    assert one(tmp_path, capsys, claim, "refuted", {"kind": "run", "run": T.run("1")}, model=model) == 0


@pytest.mark.parametrize(("last", "code"), [("1/2", 0), ("2/5", 1)])
def test_reach_is_refuted_beyond_its_bound(tmp_path, capsys, last, code):
    claim = T.claim("r", T.goal("reach", ["at", "B"], within="2/5"))
    assert one(tmp_path, capsys, claim, "refuted", {"kind": "run", "run": T.run(last)}) == code


def test_can_reach(tmp_path, capsys):
    claim = T.claim("w", T.goal("can_reach", [">=", Y, "4"]))
    assert one(tmp_path, capsys, claim, "proved", {"kind": "run", "run": T.run("0", ("1", 0))}) == 0
    assert one(tmp_path, capsys, claim, "proved", {"kind": "run", "run": T.run("1/9", ("1", 0))}) == 1
    never = T.claim("w", T.goal("can_reach", [">=", Y, "5"]))
    assert one(tmp_path, capsys, never, "refuted", T.on_cells(*LOW_PARTS)) == 0


def test_never_stuck(tmp_path, capsys):
    claim = T.claim("s", T.goal("always", ["not", ["stuck"]]))
    parts = [T.part("stuck", m, "", proof=[]) for m in "AB"]
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(*parts)) == 0
    model = T.automaton()
    model["edges"][1]["resets"] = []
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(*parts), model=model) == 1
    found = [T.part("stuck", "A", ""), T.part("stuck", "B", "", run=T.run("1", ("1", 0)))]
    assert one(tmp_path, capsys, claim, "refuted", T.on_cells(*found), model=model) == 0
    assert one(tmp_path, capsys, claim, "refuted", T.on_cells(*found)) == 1


@pytest.mark.parametrize(("half", "code"), [("1/100", 0), ("1", 1)])
def test_rounding_boxes(tmp_path, capsys, half, code):
    model = T.automaton()
    model["modes"][0]["lets"][0]["expr"] = ["*", ["const", "k"], X]
    constants = [T.const("k", "1", half)]
    claim = T.claim("rounded", T.goal("always", ["implies", ["at", "A"], ["<=", Y, "3/2"]]))
    exact, wide = (T.on_cells(T.part("dwell", "A", "y", proof=[t])) for t in ("u", ["e", ["k"], "b"]))
    rounding = {"verdict": "proved", "goals": [wide]}
    assert one(tmp_path, capsys, claim, "proved", exact, model=model, constants=constants, rounding=rounding) == code


@pytest.mark.parametrize(("assume", "code"), [([["<=", ["param", "v"], "1"]], 0), ([], 1), ([["<", "1", "0"]], 1)])
def test_params_and_assumptions(tmp_path, capsys, assume, code):
    model = T.automaton()
    for m in model["modes"]:
        m["flow"][0]["rate"] = ["param", "v"]
    claim = T.claim("v", T.goal("always", ["<=", ["der", X], "1"]), assume=assume)
    start = {**T.START, "params": {"v": "1/2"}}
    trees = [T.part("dwell", m, "x", proof=["b"]) for m in "AB"]
    params = [T.param("v", "1/2", "2")]
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(*trees, start=start), model=model, params=params) == code


def test_time_windows(tmp_path, capsys):
    claim = T.claim("t", T.goal("always", ["<=", Y, "4"], window=["0", "1"]))
    timed = T.cells(
        T.cell("A", "1", sigma=["0", "0"], x=["0", "0"]), T.cell("B", "0", sigma=["1", "1"], x=["1", "1"]),
        rho=True, time="1",
    )  # fmt: skip
    assert one(tmp_path, capsys, claim, "proved", T.on_cells(*LOW_PARTS), cell_files={"c": timed}) == 0
    longer = T.claim("t", T.goal("always", ["<=", Y, "4"], window=["0", "3/2"]))
    assert one(tmp_path, capsys, longer, "proved", T.on_cells(*LOW_PARTS), cell_files={"c": timed}) == 1


def true_folder(tmp_path):
    data = T.core([LOW, BAD])
    bad = [T.part("dwell", "A", "y", proof=["b"]), T.part("dwell", "B", "y", run=T.run("0", ("1", 0)))]
    proofs = {
        "low": T.certificate(data, LOW, "proved", T.on_cells(*LOW_PARTS)),
        "bad": T.certificate(data, BAD, "refuted", T.on_cells(*bad)),
    }
    return T.write(tmp_path, data, proofs)


def test_every_damage_is_refused(tmp_path):
    found = importlib.util.spec_from_file_location("damage", Path(__file__).parents[2] / "forgeries" / "damage.py")
    damage = importlib.util.module_from_spec(found)
    found.loader.exec_module(damage)
    folder = true_folder(tmp_path / "true")
    assert main([str(folder)]) == 0
    forger, survivors = damage.Forger(folder, tmp_path / "forged"), []
    for name, forge in damage.damages(folder):
        if main([str(forger.forged(forge))]) not in (1, 2):
            survivors.append(name)
    assert survivors == []


@pytest.mark.parametrize(
    "text",
    [
        b"", b"{", b"\x00\xff", b"[" * 200_000, b"{\"a\":1,\"a\":2}", b"NaN", b"1.5", b"9" * 5000, b"{}", b"[]",
        b"null", b"\"\\ud800\"",
    ],
)  # fmt: skip
@pytest.mark.parametrize("name", ["core.json", "report.json", "certificates/low.json", "certificates/cells/c.json"])
def test_hostile_files_are_refused_in_one_line(tmp_path, capsys, name, text):
    folder = true_folder(tmp_path)
    (folder / name).write_bytes(text)
    assert main([str(folder)]) in (1, 2)
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    "number",
    ["1e999999999", "9" * 1_000_000, "1/0", "1.5", "", "0x1", "１", "-", "1/-2", "inf", None, 1, True,
     ["^", "9", "999999999"]],
)  # fmt: skip
def test_hostile_numbers_are_refused(tmp_path, number):
    folder = true_folder(tmp_path)
    data = json.loads((folder / "core.json").read_text())
    data["automata"][0]["modes"][0]["flow"][0]["rate"] = number
    T.dump(folder / "core.json", data)
    assert main([str(folder)]) in (1, 2)


def test_cyclic_constants_and_deep_trees_are_refused(tmp_path):
    cyclic = [T.const("a", ["const", "b"]), T.const("b", ["const", "a"])]
    claim = T.claim("low", T.goal("always", ["<=", ["const", "a"], Y]))
    data = T.core([claim], constants=cyclic)
    proofs = {"low": T.certificate(data, claim, "proved", T.on_cells(*LOW_PARTS))}
    assert main([str(T.write(tmp_path / "cyclic", data, proofs))]) == 1
    deep = "b"
    for _ in range(900):
        deep = ["s", "s", "1/2", deep, "b"]
    data = T.core([LOW])
    entry = T.on_cells(T.part("dwell", "A", "y", proof=[deep]), LOW_PARTS[1])
    proofs = {"low": T.certificate(data, LOW, "proved", entry)}
    assert main([str(T.write(tmp_path / "deep", data, proofs))]) == 1


def test_doubling_lets_do_not_hang(tmp_path):
    model = T.automaton()
    lets = [T.let("y", X)] + [T.let(f"z{i}", ["*", Y if i == 0 else ["let", f"z{i - 1}"]] * 2) for i in range(60)]
    model["modes"][0]["lets"] = lets
    claim = T.claim("low", T.goal("always", ["implies", ["at", "A"], ["<=", "0", ["let", "z59"]]]))
    data = T.core([claim], model)
    proofs = {"low": T.certificate(data, claim, "proved", T.on_cells(T.part("dwell", "A", "z59", proof=["b"])))}
    assert main([str(T.write(tmp_path, data, proofs))]) == 1


def test_a_symlink_is_no_certificate(tmp_path):
    folder = true_folder(tmp_path)
    (folder / "elsewhere").write_bytes((folder / "certificates" / "low.json").read_bytes())
    (folder / "certificates" / "low.json").unlink()
    (folder / "certificates" / "low.json").symlink_to(folder / "elsewhere")
    assert main([str(folder)]) == 1


@pytest.mark.parametrize(("text", "code"), [("k,v\na,1.50\n", 0), ("k,v\na,1.51\n", 1), ("k,v\na\n", 1)])
def test_table_numbers_are_those_of_the_cells(tmp_path, monkeypatch, text, code):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text(text)
    cell = {"file": "t.csv", "row": 2, "column": "v", "number": "3/2", "constant": "T_a_v"}
    data = T.core([LOW], constants=[T.const("T_a_v", "3/2")], cells=[cell])
    proofs = {"low": T.certificate(data, LOW, "proved", T.on_cells(*LOW_PARTS))}
    inputs = [{"path": p, "sha256": hashlib.sha256(text.encode()).hexdigest()} for p in ("t.csv", "s.ha")]
    folder = T.write(tmp_path / "r", data, proofs, inputs=inputs)
    assert main([str(folder)]) == code


def test_weaker_trust_is_beyond_and_nothing_is_five(tmp_path, capsys):
    data = T.core([LOW])
    folder = T.write(tmp_path, data, {})
    assert main([str(folder)]) == 5
    report = json.loads((folder / "report.json").read_text())
    report["claims"][0].update(verdict="proved", trust="enclosed")
    T.dump(folder / "report.json", report)
    assert main([str(folder)]) == 0
    assert main([str(folder), "--strict"]) == 1
    report["claims"][0].update(trust="checked")
    T.dump(folder / "report.json", report)
    assert main([str(folder)]) == 1
