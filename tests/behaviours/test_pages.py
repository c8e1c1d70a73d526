"""Every page of this folder: its specs are checked, and what comes out is what the page says."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.evidence.verdict import Trust
from haverify.report import report
from haverify.run.pipeline import Options, Outcome, check

PAGES = sorted(p for p in Path(__file__).parent.glob("*.md") if p.name != "README.md")
_BLOCK = re.compile(r"^```(\w+)(?: +(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Example:
    """A spec of a page, the data files before it, and the lines expected of it."""

    page: str
    number: int
    files: tuple[tuple[str, str], ...]
    spec: str
    expected: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.page}-{self.number}"


def examples(page: Path) -> Iterator[Example]:
    files: dict[str, str] = {}
    spec, number = None, 0
    for kind, name, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        if kind == "csv":
            files[name] = text
        elif kind == "ha":
            assert spec is None, f"{page.name}: a spec without an expect block"
            spec = text
        elif kind == "expect":
            assert spec is not None, f"{page.name}: an expect block without a spec"
            number += 1
            lines = (line.split("//")[0].strip() for line in text.splitlines())
            yield Example(page.stem, number, tuple(files.items()), spec, tuple(line for line in lines if line))
            spec = None
    assert spec is None, f"{page.name}: the last spec has no expect block"
    assert number, f"{page.name}: no example"


ALL = [example for page in PAGES for example in examples(page)]


def outcome(example: Example, folder: Path) -> Outcome:
    for name, text in example.files:
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "page.ha").write_text(example.spec, encoding="utf-8")
    return check("page.ha", Options(None, Fraction(60), 1, None, False, None, Trust.ENCLOSED))


def said(claim: report.Claim, question: str) -> str:
    """What the report says of a claim, in the words of the page's line."""
    if question.startswith("margin"):
        return f"margin {claim.margin.value} {claim.margin.unit}".strip() if claim.margin else "no margin"
    if " in " in question:
        where = dict.fromkeys(p.mode for p in claim.parts if p.verdict == "refuted")
        return f"{claim.verdict} in {'; '.join(where)}"
    if question.startswith("unknown "):
        return f"{claim.verdict} {claim.kind}"
    return claim.verdict


def finding_lines(found: list[report.Finding], listed: set[str]) -> set[str]:
    """The findings as the page writes them: with their line where the page gives one."""
    lines = set()
    for f in found:
        exact = f"{f.code} line {f.line}"
        if f.severity in ("error", "warning") or f.code in {line.split()[0] for line in listed}:
            lines.add(exact if exact in listed or f.code not in listed else f.code)
    return lines


@pytest.mark.parametrize("example", ALL, ids=str)
def test_page(example: Example, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = outcome(example, tmp_path).report
    claims = {c.name: c for c in result.claims}
    about_claims = [line.partition(": ")[::2] for line in example.expected if ": " in line]
    listed = {line for line in example.expected if re.match(r"HA\d", line)}
    got = [f"{name}: {said(claims[name], text)}" for name, text in about_claims if name in claims]
    assert got == [f"{name}: {text}" for name, text in about_claims]
    assert set(claims) == {name for name, _ in about_claims}
    assert finding_lines(result.findings, listed) == listed
    assert f"exit {result.summary.exit_code}" in example.expected
