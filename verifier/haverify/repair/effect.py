"""What a change does to a spec: findings and violations that go, and those that come."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from haverify.repair.subject import Subject
from haverify.report.gate import expected
from haverify.text.record import record


@record
class Effect:
    """Compared with the spec as written, exactly decided both times.

    `findings` are gone, `mended` claims are as expected and were not, `fewer` parts of others no longer violated;
    `better` claims are proved although a refutation is expected. `worse` are claims that were as expected and are not;
    `come` are findings that are new, or were there all the time and hidden behind those that are gone.
    """

    findings: tuple[str, ...]
    mended: tuple[str, ...]
    fewer: tuple[str, ...]
    better: tuple[str, ...]
    worse: tuple[str, ...]
    come: tuple[str, ...]

    @property
    def solved(self) -> int:
        """How many problems are gone."""
        return len(self.findings) + len(self.mended)

    @property
    def helps(self) -> bool:
        """Whether anything is better."""
        return bool(self.findings or self.mended or self.fewer or self.better)


def effect(before: Subject, after: Subject) -> Effect:
    """The difference between two subjects that are linted and decided."""
    both = [n for n in before.evidence if n in after.evidence]
    gone, come = _moved(before.findings, after.findings)
    mended = [n for n in both if not before.is_expected(n) and after.is_expected(n)]
    better = [n for n in both if _is_better(before, after, n)]
    fewer = [f"{n} ({p})" for n in both if n not in (*better, *mended) for p in _healed(before, after, n)]
    return Effect(
        tuple(gone), tuple(mended), tuple(fewer), tuple(better), tuple(_worse(before, after, both, better)), tuple(come)
    )


def _moved(before: Iterable[str], after: Collection[str]) -> tuple[list[str], list[str]]:
    """The findings gone and come; one that came for one gone with the same code is the same said of other values."""
    gone = [k for k in before if k not in after]
    come = [k for k in after if k not in set(before)]
    for k in list(come):
        same = next((g for g in gone if g.split(":")[0] == k.split(":")[0]), None)
        if same is not None:
            gone.remove(same)
            come.remove(k)
    return gone, come


def _healed(before: Subject, after: Subject, name: str) -> list[str]:
    return [p for p in before.violated(name) if p not in after.violated(name)]


def _is_better(before: Subject, after: Subject, name: str) -> bool:
    return (
        expected(after.claims[name]) == "refuted"
        and before.verdict(name) != "proved"
        and after.verdict(name) == "proved"
    )


def _worse(before: Subject, after: Subject, names: Iterable[str], better: Collection[str]) -> Iterable[str]:
    for n in names:
        if before.is_expected(n) and not after.is_expected(n) and n not in better:
            yield f"{n}: {after.verdict(n)}"
