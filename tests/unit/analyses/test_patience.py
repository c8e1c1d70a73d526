"""Work beyond the time allowed is given up, wherever it is; what is quick does not notice."""

import time
from fractions import Fraction
from threading import Thread

import pytest

from haverify.analyses.patience import OutOfTimeError, allowed
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Unknown
from haverify.model.spec import Spec
from haverify.run.examine import read

# Chaotic, and the claim is true: flowpipes are cut again and again.
LONG = """spec "Long" version "1.0" unitless
automaton Lorenz {
  var x
  var y
  var z
  init where 14 <= x <= 16 and 14 <= y <= 16 and 35 <= z <= 37
  mode M { flow { x' = 10 * (y - x); y' = x * (28 - z) - y; z' = x * y - 8 / 3 * z } }
}
property stays on Lorenz { within 20; always x <= 30 }
property quick on Lorenz { within 0.001; always x <= 30 }
"""


def busy() -> None:
    while True:
        sum(range(1000))


def test_work_of_python_is_given_up() -> None:
    with pytest.raises(OutOfTimeError), allowed(0.1):
        busy()


def test_the_outer_allowance_holds() -> None:
    with pytest.raises(OutOfTimeError), allowed(0.1), allowed(1000):
        busy()
    with allowed(1000):
        time.sleep(0.3)


def test_who_drops_the_first_exception_gets_another() -> None:
    raised = 0
    with pytest.raises(OutOfTimeError), allowed(0.1):
        try:
            busy()
        except OutOfTimeError:
            raised += 1
        busy()
    assert raised == 1


def test_other_threads_are_let_alone() -> None:
    done: list[int] = []

    def work() -> None:
        with allowed(0):
            time.sleep(0.3)
            done.append(1)

    thread = Thread(target=work)
    thread.start()
    thread.join()
    assert done


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Spec:
    path = tmp_path_factory.mktemp("long") / "long.ha"
    path.write_text(LONG, encoding="utf-8")
    found, findings, _ = read(str(path))
    assert found is not None, findings
    return found


def test_a_claim_that_takes_too_long_is_unknown_and_the_next_is_decided(spec: Spec) -> None:
    found = decide_all(spec, budget=Fraction(1, 100))
    verdict = found["stays"].verdict
    assert isinstance(verdict, Unknown) and verdict.kind == "timeout", verdict
    assert isinstance(found["quick"].verdict, Proved)
