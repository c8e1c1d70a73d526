"""Certificates with all the right hashes for claims that are false of their core: the checker accepts none of them."""

import hashlib
import json

import pytest

from hacheck.__main__ import main

X, P, JUMPED = ["var", "x"], ["param", "p"], ["jumped"]
STAY = [["0", "0"], "1"]  # from 0, for 1
RISING = {"type": "real", "unit": None, "low": None, "high": None}
DIGIT = {"name": "N", "values": ["0", "1", "2", "3"], "codes": [None] * 4, "low": "0", "high": "3"}


def variable(name, **changes):
    return {"name": name, **RISING, **changes}


def mode(name, domain=True, lets=(), **rates):
    flow = [{"var": v, "rate": r} for v, r in (rates or {"x": "1"}).items()]
    return {"name": name, "domain": domain, "flow": flow, "lets": list(lets), "terminal": False}


def let(name, expr):
    return {"name": name, "type": "real", "unit": None, "expr": expr}


def edge(source, target, guard, *resets, urgent=True):
    name = source + target
    return {"name": name, "source": source, "target": target, "urgent": urgent, "guard": guard, "resets": list(resets)}


def to(name, value):
    return {"var": name, "to": value}


def param(name, low, high):
    return {"name": name, "unit": None, "low": low, "high": high, "default": None}


def rounded(name, value, half):
    return {"name": name, "type": "real", "unit": None, "value": value, "half": half}


def init(*values, where=True, name="A"):
    return {"mode": name, "where": where, "with": [to(*v) for v in values]}


def automaton(*modes, edges=(), **changes):
    return {
        "name": "M", "constants": [], "params": [], "inputs": [], "vars": [variable("x")], "lets": [], "priorities": [],
        "init": [init(("x", "0"))], "modes": list(modes), "edges": list(edges), **changes,
    }  # fmt: skip


def claim(kind, condition, name="c", within=None, **changes):
    goal = {"kind": kind, "condition": condition, "window": None, "within": within, "attracting": False}
    return {
        "name": name, "on": "M", "kind": "property", "goals": [goal], "horizon": {"time": None, "jumps": None},
        "assume": [], "which": [], "using": [], "method": None, "expect": None, "inductive": False, **changes,
    }  # fmt: skip


def core(model, *claims, **changes):
    empty = ("units", "enums", "constants", "params", "inputs", "tables", "networks", "assumptions", "systems",
             "cellular", "relations", "fuzzy", "cells")  # fmt: skip
    spec = {"name": "t", "version": "1", "unitless": True}
    return {"schema": "haverify.core/1", "spec": spec, "automata": [model], "claims": list(claims),
            **{k: [] for k in empty}, **changes}  # fmt: skip


def sha(value):
    return hashlib.sha256(json.dumps(value, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def part_hash(data, owner, kind, where, output):
    def mentioned(value):
        return [c for c in data["constants"] if json.dumps(["const", c["name"]]) in json.dumps(value)]

    model, about = (
        data["automata"][0],
        {"goal": owner["goals"][0], "horizon": owner["horizon"], "assume": owner["assume"]},
    )
    shared = {k: data[k] for k in ("params", "enums", "assumptions")}
    m = sha({"automaton": model, "constants": mentioned(model), **shared})
    return sha(["haverify.obligation/1", m, sha({**about, "constants": mentioned(about)}), kind, where, output])


def start(params=None, name="A", **values):
    return {"mode": name, "values": values or {"x": "0"}, "params": params or {}}


def run(begin, last, *steps):
    return {**begin, "steps": [{"dwell": d, "edge": k, "values": {}} for d, k in steps], "last": last}


def shown(data, owner, begin, *parts, cells="c"):
    """A goal shown on cells; a part is (kind, where, output, trees or run)."""
    listed = [{"kind": k, "where": w, "output": o, "hash": part_hash(data, owner, k, w, o),
               "run" if isinstance(e, dict) else "proof": e} for k, w, o, e in parts]  # fmt: skip
    return {"kind": "cells", "cells": cells, "start": begin, "parts": listed}


def inevitable(data, owner, begin):
    return {"kind": "inevitable", "cells": "c", "start": begin, "hash": part_hash(data, owner, "goal", "", "")}


def cell(name, dwell, sigma=None, meet=None, **entry):
    extra = {k: v for k, v in (("sigma", sigma), ("meet", meet)) if v is not None}
    return {"mode": name, "entry": entry, "dwell": dwell, **extra}


def table(*cells, time=None):
    timed = any("sigma" in c for c in cells)
    return {
        "schema": "haverify.cells/1",
        "automaton": "M",
        "rho": timed,
        "time": time,
        "jumps": None,
        "cells": list(cells),
    }


LINE = table(cell("A", "1", x=["0", "0"]))
UP_TO_1 = ["<=", X, "1"]
ACCEPTED = {"c": "accepted"}


@pytest.fixture
def outcomes(tmp_path, capsys):
    """Write a folder without a report, and say what became of each claim."""

    def check(data, files, entries, verdict="proved", rounding=False):
        (tmp_path / "certificates" / "cells").mkdir(parents=True)
        for name, value in files.items():
            (tmp_path / "certificates" / "cells" / f"{name}.json").write_text(json.dumps(value))
        for name, entry in entries.items():
            goals = entry if isinstance(entry, list) else [entry]
            wide = {"verdict": verdict, "goals": goals} if rounding else None
            text = {
                "schema": "haverify.certificate/1",
                "claim": name,
                "verdict": verdict,
                "goals": goals,
                "rounding": wide,
            }
            (tmp_path / "certificates" / f"{name}.json").write_text(json.dumps(text))
        (tmp_path / "core.json").write_text(json.dumps(data))
        code = main([str(tmp_path), "--json", "--no-report"])
        out = capsys.readouterr().out
        return {n: c["outcome"] for n, c in json.loads(out)["claims"].items()} if out else {"folder": f"exit {code}"}

    return check


def forged(outcomes, model, owner, *parts, begin=None, files=None, verdict="proved", rounding=False, **changes):
    """The outcome of a claim with parts shown on cells."""
    data = core(model, owner, **changes)
    entry = shown(data, owner, begin or start(), *parts)
    return outcomes(data, files or {"c": LINE}, {"c": entry}, verdict, rounding)


def test_what_is_true_is_accepted(outcomes):
    model = automaton(mode("A", UP_TO_1))
    assert forged(outcomes, model, claim("always", UP_TO_1), ("dwell", "A", "x", ["b"])) == ACCEPTED


def test_a_run_stuck_exactly_at_the_horizon_is_stuck(outcomes):
    owner = claim("always", ["not", ["stuck"]], horizon={"time": "1", "jumps": None})
    files = {"c": table(cell("A", "1", sigma=["0", "0"], x=["0", "0"]), time="1")}
    assert forged(outcomes, automaton(mode("A", UP_TO_1)), owner, ("stuck", "A", "", []), files=files) != ACCEPTED


def test_a_let_seen_with_time_keeps_its_slope_where_time_is_not_tracked(outcomes):
    first, second = (
        claim("always", [">=", ["let", "t"], "0"], "a"),
        claim("always", ["<=", ["der", ["let", "t"]], "0"], "b"),
    )
    data = core(automaton(mode("A", lets=[let("t", ["time"])])), first, second)
    files = {"t": table(cell("A", None, sigma=["0", "0"], x=["0", "0"])), "u": table(cell("A", None, x=["0", "0"]))}
    entries = {"a": shown(data, first, start(), ("dwell", "A", "t", ["u"]), cells="t"),
               "b": shown(data, second, start(), ("dwell", "A", "t", ["b"]), cells="u")}  # fmt: skip
    assert outcomes(data, files, entries)["b"] != "accepted"


@pytest.mark.parametrize(
    "undefined_at_0", [["/", "1", ["/", "1", X]], ["^", ["/", "1", X], "-1"], ["^", ["/", "1", X], "0"]]
)
def test_a_division_inside_a_divisor_may_be_by_zero(outcomes, undefined_at_0):
    model = automaton(mode("A", ["<=", X, "2"]), init=[init(("x", "-1"))])
    files = {"c": table(cell("A", "3", x=["-1", "-1"]))}
    parts = [("dwell", "A", "x", ["u"])]
    owner = claim("always", ["<=", undefined_at_0, "2"])
    assert forged(outcomes, model, owner, *parts, begin=start(x="-1"), files=files) != ACCEPTED


def test_a_rounded_constant_is_not_the_variable_of_its_name(outcomes):
    k = ["var", "k"]
    model = automaton(mode("A", ["<=", k, "2"], k="1"), vars=[variable("k")], init=[init(("k", "0"))])
    found = forged(
        outcomes, model, claim("always", ["<=", k, ["const", "k"]]), ("dwell", "A", "k", ["b"]), begin=start(k="0"),
        files={"c": table(cell("A", "2", k=["0", "0"]))}, rounding=True, constants=[rounded("k", "2", "3/2")],
    )  # fmt: skip
    assert found != ACCEPTED


def test_a_rounded_constant_is_not_the_param_of_its_name(outcomes):
    k = ["const", "k"]
    model = automaton(mode("A", UP_TO_1), params=[param("q", "0", k), param("k", "0", "1")])
    found = forged(
        outcomes, model, claim("always", ["<=", ["param", "k"], k]), ("dwell", "A", "", ["b"]),
        begin=start({"q": "0", "k": "0"}), rounding=True, constants=[rounded("k", "2", "3/2")],
    )  # fmt: skip
    assert found != ACCEPTED


def test_a_chosen_value_is_not_the_variable_with_a_prime(outcomes):
    primed = "x'"
    model = automaton(
        mode("A", UP_TO_1, x="1", **{primed: "0"}), mode("B", x="0", **{primed: "0"}),
        edges=[edge("A", "B", [">=", X, "1"], {"var": "x", "low": "0", "high": "9"})],
        vars=[variable("x"), variable(primed)], init=[init(("x", "0"), (primed, "0"))],
    )  # fmt: skip
    cells = table(
        cell("A", "1", x=["0", "0"], **{primed: ["0", "0"]}), cell("B", None, x=["0", "9"], **{primed: ["0", "0"]})
    )
    owner, parts = claim("always", ["implies", JUMPED, ["<=", X, "0"]]), [("jump", "A -> B", "x", ["b"])]
    found = forged(outcomes, model, owner, *parts, begin=start(x="0", **{primed: "0"}), files={"c": cells})
    assert found != ACCEPTED


PI_41 = "31415926535897932384626433832795028841971{}/1" + 41 * "0"  # 41 digits after the point, the last one given


@pytest.mark.parametrize(
    ("params", "values", "bound"),
    [
        ([param("p", "0", "1"), param("q", "0", P)], {"p": "0", "q": "1"}, P),
        ([param("q", "0", ["pi"])], {"q": PI_41.format("9")}, PI_41.format("8")),
    ],
)
def test_a_param_of_a_run_is_inside_its_range_as_written(outcomes, params, values, bound):
    owner, begin = claim("always", ["<=", ["param", "q"], bound]), start(values)
    model = automaton(mode("A", UP_TO_1))
    found = forged(
        outcomes, model, owner, ("dwell", "A", "", run(begin, "0")), begin=begin, verdict="refuted", params=params
    )
    assert found != ACCEPTED


CHAIN = automaton(
    mode("A", UP_TO_1), mode("B"), mode("C"),
    edges=[edge("A", "B", [">=", X, "1"], to("x", "5")), edge("B", "C", True, to("x", "6"))],
)  # fmt: skip
CHAIN_CELLS = {"c": table(cell("A", "1", x=["0", "0"]), cell("B", "0", x=["5", "5"]), cell("C", None, x=["6", "6"]))}


@pytest.mark.parametrize(
    ("condition", "parts"),
    [
        (["not", ["and", JUMPED, ["pre", JUMPED]]], []),
        (
            ["implies", ["at", "C"], [">=", ["pre", ["pre", X]], "5"]],
            [("dwell", "C", "x", ["u"]), ("jump", "B -> C", "x", ["b"])],
        ),
    ],
)
def test_before_a_jump_there_may_have_been_another(outcomes, condition, parts):
    assert forged(outcomes, CHAIN, claim("always", condition), *parts, files=CHAIN_CELLS) != ACCEPTED


def test_a_let_does_not_hide_a_jump(outcomes):
    lets = [let("d", ["-", X, ["pre", X]])]
    model = automaton(
        mode("A", UP_TO_1, lets), mode("B", True, lets), edges=[edge("A", "B", [">=", X, "1"], to("x", "5"))]
    )
    files = {"c": table(cell("A", "1", x=["0", "0"]), cell("B", None, x=["5", "5"]))}
    parts = [("dwell", "A", "d", ["b"]), ("dwell", "B", "d", ["b"])]
    assert forged(outcomes, model, claim("always", ["<=", ["let", "d"], "0"]), *parts, files=files) != ACCEPTED


def test_a_guard_does_not_ask_for_the_jump_before(outcomes):
    edges = [edge("A", "B", [">=", X, "1"]), edge("B", "C", JUMPED, urgent=False)]
    model = automaton(mode("A", UP_TO_1), mode("B"), mode("C"), edges=edges)
    files = {"c": table(cell("A", "1", x=["0", "0"]), cell("B", None, x=["1", "1"]))}
    owner = claim("always", ["not", ["at", "C"]])
    assert forged(outcomes, model, owner, ("dwell", "C", "", []), files=files) != ACCEPTED


def test_a_goal_is_not_met_at_the_landing_that_it_excludes(outcomes):
    model = automaton(mode("A", UP_TO_1), mode("B", UP_TO_1), edges=[edge("A", "B", [">=", X, "1"])])
    owner = claim("reach", ["and", ["at", "B"], ["not", JUMPED]], within="5")
    data = core(model, owner)
    cells = table(cell("A", "1", ["0", "0"], x=["0", "0"]), cell("B", "0", ["1", "1"], "0", x=["1", "1"]))
    assert outcomes(data, {"c": cells}, {"c": inevitable(data, owner, start())}) != ACCEPTED


COUNTED = {"vars": [variable("x"), variable("n", type="N")], "init": [init(("x", "0"), ("n", "1"))]}
ONE = {"c": table(cell("A", "1", x=["0", "0"], n=["1", "1"]))}


def test_half_an_integer_is_not_nothing(outcomes):
    halved = edge("A", "B", [">=", X, "1"], to("n", ["/", ["var", "n"], "2"]))
    model = automaton(mode("A", UP_TO_1), mode("B"), edges=[halved], **COUNTED)
    owner, parts = claim("always", ["not", ["at", "B"]]), [("dwell", "B", "", [])]
    assert forged(outcomes, model, owner, *parts, begin=start(x="0", n="1"), files=ONE, enums=[DIGIT]) != ACCEPTED


def test_an_edge_is_not_due_by_a_choice_that_is_no_integer(outcomes):
    n = ["var", "n"]
    chosen = edge("A", "B", [">=", X, "1"], {"var": "n", "low": "1/2", "high": "3/2"})
    only_half = mode("B", ["and", ["<=", n, "3/4"], [">=", n, "1/4"]])
    model = automaton(mode("A"), only_half, edges=[chosen], **COUNTED)
    parts = [("dwell", "A", "x", ["b"]), ("dwell", "B", "x", [])]
    found = forged(
        outcomes, model, claim("always", UP_TO_1), *parts, begin=start(x="0", n="1"), files=ONE, enums=[DIGIT]
    )
    assert found != ACCEPTED


def test_a_start_bounded_by_a_square_is_not_cut_to_the_declared_range(outcomes):
    line = init(where=["<=", ["^", X, "2"], "4"])
    model = automaton(mode("A", x="0"), vars=[variable("x", low="0", high="1")], init=[line])
    parts, files = [("dwell", "A", "x", ["b"])], {"c": table(cell("A", None, x=["0", "1"]))}
    assert forged(outcomes, model, claim("always", [">=", X, "0"]), *parts, files=files) != ACCEPTED


def test_a_start_bounded_by_a_relation_is_not_cut_to_the_declared_range(outcomes):
    y = ["var", "y"]
    line = init(where=["and", ["<=", "0", X], ["<=", X, "1"], ["==", ["+", X, y], "3/2"]])
    ranges = [variable(v, low="0", high="1") for v in "xy"]
    model = automaton(mode("A", x="0", y="0"), vars=ranges, init=[line])
    parts, files = [("dwell", "A", "y", ["b"])], {"c": table(cell("A", None, x=["0", "1"], y=["0", "1"]))}
    owner = claim("always", ["<=", y, "1"])
    assert forged(outcomes, model, owner, *parts, begin=start(x="1", y="1/2"), files=files) != ACCEPTED


@pytest.mark.parametrize(
    "assumed", [["or", ["at", "A"], ["<=", P, "1/2"]], ["<=", ["let", "w"], "1/2"]]
)  # both hold in mode A, whatever p is
def test_an_assumption_is_read_in_the_mode_it_is_used_in(outcomes, assumed):
    model = automaton(mode("A", UP_TO_1, [let("w", "0")]), lets=[let("w", P)])
    owner = claim("always", ["<=", P, "1/2"], assume=[assumed])
    parts = [("dwell", "A", "", ["b"])]
    found = forged(outcomes, model, owner, *parts, begin=start({"p": "0"}), params=[param("p", "0", "1")])
    assert found != ACCEPTED


def test_a_flow_reads_the_lets_of_its_mode(outcomes):
    model = automaton(mode("A", UP_TO_1, [let("w", "2")], x=["let", "w"]), lets=[let("w", "1")])
    owner = claim("always", ["<=", ["der", X], "1"])
    assert forged(outcomes, model, owner, ("dwell", "A", "x", ["b"])) != ACCEPTED


def test_a_start_reads_the_lets_of_its_mode(outcomes):
    lines = [init(("x", ["let", "w"])), init(("x", "0"))]
    model = automaton(mode("A", True, [let("w", "2")], x="0"), lets=[let("w", "1")], init=lines)
    files = {"c": table(cell("A", None, x=["0", "1"]))}
    assert forged(outcomes, model, claim("always", UP_TO_1), ("dwell", "A", "x", ["b"]), files=files) != ACCEPTED


@pytest.mark.parametrize(
    "condition",
    [
        [">=", ["-", X], "0"],
        ["<=", "0", X, "1/2"],
        ["implies", ["at", "A"], [">=", X, "0"], ["<", "5", X]],
    ],
)
def test_an_operator_with_the_wrong_number_of_operands_means_nothing(outcomes, condition):
    parts = [("dwell", "A", "x", ["b"])]
    assert forged(outcomes, automaton(mode("A", UP_TO_1)), claim("always", condition), *parts) != ACCEPTED


def test_an_integer_enumeration_begins_at_an_integer(outcomes):
    enum = {"name": "N", "values": ["a", "b"], "codes": [None, None], "low": "1/2", "high": "3/2"}
    lines = [init(("x", "0"), ("n", "1")), init(("x", "0"), ("n", ["sym", "N", "a"]), name="B")]
    model = automaton(mode("A", UP_TO_1), mode("B"), **{**COUNTED, "init": lines})
    owner, parts = claim("always", ["not", ["at", "B"]]), [("dwell", "B", "", [])]
    assert forged(outcomes, model, owner, *parts, begin=start(x="0", n="1"), files=ONE, enums=[enum]) != ACCEPTED


@pytest.mark.parametrize(("verdict", "rounding"), [("unknown", "proved"), ("unknown\naccepted  c proved", None)])
def test_an_undecided_claim_gets_nothing_accepted_by_the_report(tmp_path, capsys, verdict, rounding):
    model = automaton(mode("A", UP_TO_1))
    true, open_ = claim("always", UP_TO_1, "a"), claim("always", [">", X, "0"])
    data = core(model, true, open_)
    entry = shown(data, true, start(), ("dwell", "A", "x", ["b"]))
    (tmp_path / "certificates" / "cells").mkdir(parents=True)
    proof = {"schema": "haverify.certificate/1", "claim": "a", "verdict": "proved", "goals": [entry], "rounding": None}
    part = {"mode": "A", "output": "x", "verdict": "proved"}
    said = [
        {"name": "a", "verdict": "proved", "trust": "checked", "rounding": None, "parts": [part]},
        {"name": "c", "verdict": verdict, "trust": None, "rounding": rounding and {"verdict": rounding}, "parts": []},
    ]
    files = {
        "core": data,
        "report": {"claims": said, "inputs": []},
        "certificates/a": proof,
        "certificates/cells/c": LINE,
    }
    for name, value in files.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(value))
    assert main([str(tmp_path)]) == 1
    assert "\naccepted  c" not in capsys.readouterr().out


def test_the_parts_of_a_claim_without_parts_are_not_made_up(tmp_path):
    owner = claim("can_reach", [">=", X, "1"])
    data = core(automaton(mode("A", UP_TO_1)), owner)
    (tmp_path / "certificates").mkdir()
    entry = {"kind": "run", "run": run(start(), "1"), "hash": part_hash(data, owner, "goal", "", "")}
    proof = {"schema": "haverify.certificate/1", "claim": "c", "verdict": "proved", "goals": [entry], "rounding": None}
    part = {"mode": "A", "output": "x", "verdict": "proved"}
    said = {"name": "c", "verdict": "proved", "trust": "checked", "rounding": None, "parts": [part]}
    files = {"core": data, "report": {"claims": [said], "inputs": []}, "certificates/c": proof}
    for name, value in files.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(value))
    assert main([str(tmp_path)]) == 1


@pytest.mark.parametrize("before", [1, 2, 3])
def test_cells_read_after_others_are_not_taken_for_them(outcomes, before):
    model = automaton(mode("A", x="0"), mode("B", x="0"), init=[init(("x", "0")), init(("x", "5"), name="B")])
    goals = [claim("reach", [">=", X, bound], within="5")["goals"][0] for bound in ["0"] * before + ["5"]]
    owner = claim("reach", True, goals=goals)
    data = core(model, owner)
    a, b = cell("A", None, ["0", "0"], "0", x=["0", "0"]), cell("B", None, ["0", "0"], "0", x=["5", "5"])
    hashes = [part_hash(data, {**owner, "goals": [g]}, "goal", "", "") for g in goals]
    entries = [{"kind": "inevitable", "cells": "one", "start": start(), "hash": h} for h in hashes[:-1]]
    entries.append({"kind": "inevitable", "cells": "two", "start": start(), "hash": hashes[-1]})
    assert outcomes(data, {"one": table(b, b, a), "two": table(a, b)}, {"c": entries}) != ACCEPTED
