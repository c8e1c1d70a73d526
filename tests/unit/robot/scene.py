"""The gait on HOAP-2, read once for all tests."""

from functools import cache
from pathlib import Path

from haverify.robot import mechanics
from haverify.robot.cycle import cycle_of
from haverify.robot.folder import describe
from haverify.robot.mapping import read_map
from haverify.robot.trajectory import sampled
from haverify.run.examine import read
from haverify.run.load import read_text
from haverify.text.source import Source

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "models" / "hoap2"


@cache
def robot():
    described, _, found = describe(str(FOLDER), read_text)
    assert found == []
    return described


@cache
def gait_map(name="gait.toml"):
    made, found = read_map(read_text(str(FOLDER / name))[1], robot().robot)
    assert found == []
    return made


def changed(text):
    """A map from text, and what is wrong with it."""
    return read_map(Source.of_text("map.toml", text), robot().robot)


@cache
def cycle():
    spec, _, _ = read(str(ROOT / "spec" / "gait.ha"))
    automaton = next(a for a in spec.automata if a.name == "Gait")
    return cycle_of(spec, automaton, ["lh", "lk", "la", "rh", "rk", "ra"])


@cache
def engine():
    return mechanics.engine(robot())


def moved(m, rate=1000):
    t = sampled(cycle(), m, robot().robot, rate)
    return t, mechanics.moved(engine(), robot(), t)
