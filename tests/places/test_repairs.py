"""Single faults planted in the tables of `spec/gait.ha`: the first proposal undoes them."""

from __future__ import annotations

import csv
import io
import random
import re
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.cli import main
from haverify.diagnostics.diagnostic import Edit
from haverify.diagnostics.edits import edited
from haverify.elaborate.elaborate import elaborate
from haverify.lint._facts import Facts
from haverify.repair.backwards import backwards
from haverify.repair.choice import Chooser
from haverify.repair.curves import Curves
from haverify.repair.fit import Fit
from haverify.repair.repair import repair
from haverify.repair.stated import Limit, limits
from haverify.repair.subject import Subject, Text, read
from haverify.run.load import load
from haverify.text.span import Span

ROOT = Path(__file__).parents[2]
ENDS = {"LR": "0.4", "MST": "0.5", "TS": "0.733", "PS": "0.9833", "IS": "1.1167", "MSW": "1.2667", "TSW": "1.4333"}
SLOTS = {
    p: (Fraction(a), Fraction(b))
    for p, a, b in zip(ENDS, ENDS.values(), [*list(ENDS.values())[1:], "1.6"], strict=True)
}
SEED, EACH = 20160, 50


@dataclass(frozen=True)
class Fault:
    """A line of a table with one slip in it."""

    kind: str
    path: str
    old: str
    new: str


@pytest.fixture(scope="module")
def gait(tmp_path_factory: pytest.TempPathFactory) -> Subject:
    """The gait as in the repository, without the hashes that would tell at once what a table looked like."""
    folder = tmp_path_factory.mktemp("gait")
    shutil.copytree(ROOT / "spec", folder / "spec")
    spec = folder / "spec" / "gait.ha"
    spec.write_text(re.sub(r'^ *sha256 ".*"\n', "", spec.read_text(), flags=re.MULTILINE))
    loaded, found = load(spec)
    assert loaded is not None and not found
    data = {s.path: s for s in loaded.files.data.values()}
    subject = read(Text(loaded.tree, loaded.files, {**data, **loaded.sources}), {})
    assert subject.has_meaning
    return subject


# ---- planting, without a look at how repairs are sought -------------------------


def signs(cells: list[str]) -> Iterator[list[str]]:
    for k, c in enumerate(cells):
        yield [*cells[:k], c[1:] if c.startswith("-") else "-" + c.lstrip("+"), *cells[k + 1 :]]


def points(cells: list[str]) -> Iterator[list[str]]:
    """Every point moved by one digit, in the mantissa."""
    for k, c in enumerate(cells):
        mantissa, e, exponent = c.partition("e")
        sign, digits = (mantissa[0], mantissa[1:]) if mantissa[0] in "+-" else ("", mantissa)
        whole, _, part = digits.partition(".")
        for moved in ((whole + (part or "0")[0], part[1:]), (whole[:-1], whole[-1:] + part)):
            yield [*cells[:k], f"{sign}{moved[0]}.{moved[1]}{e}{exponent}", *cells[k + 1 :]]


def digits(cells: list[str]) -> Iterator[list[str]]:
    """Every two digits side by side exchanged, before an exponent."""
    for k, c in enumerate(cells):
        end = c.find("e") if "e" in c else len(c)
        for i in range(end - 1):
            if c[i].isdigit() and c[i + 1].isdigit() and c[i] != c[i + 1]:
                yield [*cells[:k], c[:i] + c[i + 1] + c[i] + c[i + 2 :], *cells[k + 1 :]]


def neighbours(cells: list[str]) -> Iterator[list[str]]:
    for k in range(len(cells) - 2):  # the last one is the constant, which may stand anywhere
        yield [*cells[:k], cells[k + 1], cells[k], *cells[k + 2 :]]


KINDS: dict[str, Callable[[list[str]], Iterator[list[str]]]] = {
    "sign": signs, "decimal place": points, "digits": digits, "neighbours": neighbours,
}  # fmt: skip


def polynomial(cells: list[str]) -> list[Fraction]:
    """The coefficients of a row, highest power first; the last cell is added to the last of them."""
    *found, error = (Fraction(c) for c in cells)
    return [*found[:-1], found[-1] + error]


def value(coefficients: list[Fraction], x: Fraction) -> Fraction:
    total = Fraction(0)
    for c in coefficients:
        total = total * x + c
    return total


def moves(phase: str, old: list[str], new: list[str]) -> bool:
    """Whether the output moves by more than 20 deg somewhere in its slot."""
    a, b = SLOTS[phase]
    before, after = polynomial(old), polynomial(new)
    return any(abs(value(after, x) - value(before, x)) > 20 for x in (a + (b - a) * k / 16 for k in range(17)))


def faults(gait: Subject) -> Iterator[Fault]:
    for source in {s.path: s for s in gait.text.files.data.values()}.values():
        for line in source.text.splitlines()[1:]:
            phase, *cells = line.split(",")
            filled = [c for c in cells if c]
            for kind, plant in KINDS.items():
                for changed in plant(filled):
                    if changed != filled and moves(phase, filled, changed):
                        rest = [""] * (len(cells) - len(filled))
                        new = ",".join([phase, *changed[:-1], *rest, changed[-1]])
                        yield Fault(kind, source.path, line, new)


def edit(gait: Subject, fault: Fault) -> Edit:
    start = gait.text.sources[fault.path].text.index(fault.old)
    return Edit(Span(fault.path, start, start + len(fault.old)), fault.new)


def numbers(text: str) -> list[list[Fraction | str | None]]:
    """A table by value: other spellings of a number do not count."""
    first, *rows = csv.reader(io.StringIO(text))
    return [[first[0]], *([r[0], *(Fraction(c) if c else None for c in r[1:])] for r in rows)]


# ---- the tests ------------------------------------------------------------------


def sample(gait: Subject) -> list[Fault]:
    """The same 200 on every run, 50 of each kind."""
    by_kind: dict[str, list[Fault]] = {kind: [] for kind in KINDS}
    for f in faults(gait):
        by_kind[f.kind].append(f)
    rng = random.Random(SEED)
    return [f for kind in KINDS for f in rng.sample(sorted(by_kind[kind], key=repr), EACH)]


def first_proposal(subject: Subject, stated: list[Limit]) -> list[Edit]:
    """The edits that tables alone suggest, before they are tried."""
    assert subject.spec is not None
    facts = Facts(subject.spec, subject.text.sources)
    choices, _ = Chooser(Fit(Curves(facts), stated), subject.text.sources).choose()
    return [e for c in choices for e in c.change.edits]


def test_of_200_faults_that_matter_95_percent_are_undone(gait: Subject) -> None:
    assert gait.spec is not None
    stated = limits(Facts(gait.spec, gait.text.sources), {})
    right, wrong = Counter[str](), list[Fault]()
    for f in sample(gait):
        faulty = gait.edited([edit(gait, f)])
        text = edited(faulty.text.sources[f.path].text, first_proposal(faulty, stated))
        is_right = numbers(text) == numbers(gait.text.sources[f.path].text)
        right[f.kind] += is_right
        wrong += [] if is_right else [f]
    assert right.total() >= 190, wrong
    assert all(right[kind] >= 45 for kind in KINDS), wrong


def test_a_proposal_is_tried_and_says_what_it_meets(gait: Subject) -> None:
    for f in sample(gait)[::80]:
        faulty = gait.edited([edit(gait, f)])
        faulty.lint()
        outcome = repair(faulty, ())
        (p,) = outcome.proposals
        text = edited(faulty.text.sources[f.path].text, p.change.edits)
        assert numbers(text) == numbers(gait.text.sources[f.path].text), f
        assert p.effect.mended, f
        assert not p.effect.worse
        assert outcome.left == ()


def test_nothing_is_proposed_where_nothing_is_wrong(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    assert main(["repair", "spec/gait.ha"]) == 0
    assert capsys.readouterr().out == "spec/gait.ha: nothing to repair\n"


def test_the_four_lost_signs_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    assert main(["repair", "spec/gait_printed.ha", "--diff"]) == 1
    said = capsys.readouterr().out
    changed = [line for line in said.splitlines() if line[0] in "+-" and line[1:3] not in ("--", "++")]
    assert sorted(line for line in changed if "sha256" not in line) == [
        "+IS,2435,-1.09e+04,1.571e+04,-7356,,-6.1",
        "+LR,2458,-3383,1598,-258.8,,0",
        "+MSW,9973,-4.122e+04,5.642e+04,-2.561e+04,,+0.5",
        "+PS,-8138,2.899e+04,-3.678e+04,1.938e+04,-3508,-1",
        "-IS,2435,1.09e+04,1.571e+04,-7356,,-6.1",
        "-LR,2458,-3383,1598,258.8,,0",
        "-MSW,9973,4.122e+04,5.642e+04,-2.561e+04,,+0.5",
        "-PS,8138,2.899e+04,-3.678e+04,1.938e+04,-3508,-1",
    ]
    assert len([line for line in changed if "sha256" in line]) == 4


def test_half_of_the_printed_ranges_are_backwards(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 32 ranges of angles 16; each is first offered to be exchanged."""
    monkeypatch.chdir(ROOT)
    loaded, _ = load("spec/ranges_printed.ha")
    assert loaded is not None
    spec, _ = elaborate(loaded.tree, loaded.files)
    assert spec is not None
    data = {s.path: s for s in loaded.files.data.values()}
    pairs = backwards(Facts(spec, {**data, **loaded.sources}))
    found = Counter(p.low.column for p in pairs)
    assert found == {"lh_lower": 3, "rh_lower": 6, "lk_lower": 3, "rk_lower": 4}
    for p in pairs:
        assert p.high.column == p.low.column.replace("lower", "upper")
        first = next(p.changes(data))
        assert first.kind == "bounds"
        assert dict(first.numbers) == {p.low.constant: p.high.number, p.high.constant: p.low.number}
