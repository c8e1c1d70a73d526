"""`record` behaves like `dataclass(frozen=True, slots=True)`."""

import copy
import pickle
from dataclasses import FrozenInstanceError, asdict, field, fields, replace

import pytest

from haverify.text.record import record


@record
class Point:
    """A point with a remark that does not count."""

    x: int
    y: int = 0
    tags: list[str] = field(default_factory=list)
    remark: str = field(default="", compare=False, repr=False)

    @property
    def far(self) -> bool:
        return self.x > 100


@record
class Positive:
    value: int

    def __post_init__(self) -> None:
        if self.value <= 0:
            raise ValueError


def test_values_and_defaults() -> None:
    p = Point(1, remark="r")
    assert (p.x, p.y, p.tags, p.remark, p.far) == (1, 0, [], "r", False)
    assert Point(1).tags is not Point(1).tags


def test_equality_and_hash_leave_out_what_does_not_count() -> None:
    assert Point(1, remark="a") == Point(1, remark="b")
    assert Point(1) != Point(2)
    assert Point(1).__eq__((1, 0)) is NotImplemented
    assert hash(Positive(3)) == hash(Positive(3))


def test_it_is_frozen_and_has_no_other_attributes() -> None:
    p = Point(1)
    with pytest.raises(FrozenInstanceError):
        p.x = 2  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        del p.x
    with pytest.raises(FrozenInstanceError):
        p.z = 1  # type: ignore[attr-defined]
    assert not hasattr(p, "__dict__")


def test_the_tools_for_dataclasses_work() -> None:
    p = Point(1, 2)
    assert replace(p, y=5) == Point(1, 5)
    assert asdict(p) == {"x": 1, "y": 2, "tags": [], "remark": ""}
    assert [f.name for f in fields(p)] == ["x", "y", "tags", "remark"]  # type: ignore[arg-type]


def test_copies_and_pickles_are_equal() -> None:
    p = Point(1, 2, ["a"])
    assert copy.deepcopy(p) == p
    assert pickle.loads(pickle.dumps(p)) == p


def test_matching_by_position() -> None:
    match Point(3, 4):
        case Point(x, y):
            assert (x, y) == (3, 4)


def test_post_init_and_repr() -> None:
    with pytest.raises(ValueError):
        Positive(0)
    assert repr(Point(1, remark="hidden")) == "Point(x=1, y=0, tags=[])"
