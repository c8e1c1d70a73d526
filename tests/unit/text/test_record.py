"""`record` behaves like `dataclass(frozen=True, slots=True)`, `holder` like `dataclass(eq=False)`."""

import copy
import dataclasses
import pickle
from dataclasses import FrozenInstanceError, asdict, fields
from functools import cached_property

import pytest

from haverify.text.record import field, holder, record, replace


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


@record
class Square:
    side: int

    @cached_property
    def area(self) -> int:
        return self.side**2


@holder
class Basket:
    """Things that come and go."""

    owner: str
    things: list[str] = field(default_factory=list)
    secret: str = field(default="", repr=False)

    @cached_property
    def size(self) -> int:
        return len(self.things)


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
    assert dataclasses.replace(p, y=5) == Point(1, 5)
    assert asdict(p) == {"x": 1, "y": 2, "tags": [], "remark": ""}
    assert [f.name for f in fields(p)] == ["x", "y", "tags", "remark"]  # type: ignore[arg-type]


def test_the_tools_for_dataclasses_see_what_was_said_about_a_field() -> None:
    x, y, tags, remark = fields(Point)  # type: ignore[arg-type]
    assert x.default is dataclasses.MISSING
    assert (y.default, tags.default_factory) == (0, list)
    assert (remark.compare, remark.repr, y.compare, y.repr) == (False, False, True, True)


def test_a_copy_with_changes() -> None:
    assert replace(Point(1, 2), y=5) == Point(1, 5)
    with pytest.raises(TypeError):
        replace(Point(1), z=5)
    with pytest.raises(ValueError):
        replace(Positive(1), value=0)


def test_arguments_are_as_the_fields_say() -> None:
    with pytest.raises(TypeError):
        Square()  # type: ignore[call-arg]
    with pytest.raises(TypeError):
        Square(1, 2)  # type: ignore[call-arg]
    assert Square(side=3) == Square(3)


def test_cached_properties_are_kept_and_no_part_of_the_record() -> None:
    s = Square(3)
    assert (s.area, s.__dict__) == (9, {"area": 9})
    assert s == Square(3)
    assert pickle.loads(pickle.dumps(s)).area == 9
    with pytest.raises(FrozenInstanceError):
        s.side = 4  # type: ignore[misc]


def test_a_holder_changes_and_equals_itself_only() -> None:
    basket = Basket("me", secret="s")
    assert (basket.size, basket.things) == (0, [])
    basket.owner = "you"
    basket.things.append("apple")
    assert repr(basket) == "Basket(owner='you', things=['apple'])"
    assert basket != Basket("you", ["apple"])
    assert basket in {basket}
    assert Basket("x").things == []
    assert copy.copy(basket).owner == "you"
    assert replace(basket, owner="he").things is basket.things


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


@record
class Backwards:
    first: int = 0
    second: int  # type: ignore[misc]


def test_a_field_without_default_after_one_with_a_default_is_refused() -> None:
    with pytest.raises(TypeError, match="first, second"):
        Backwards(1, 2)


@record
class Twin:
    left: int
    right: int


def test_classes_of_one_shape_keep_their_own_names() -> None:
    assert Twin(right=1, left=2) == Twin(2, 1)
    with pytest.raises(TypeError, match="'right'"):
        Twin(left=1)  # type: ignore[call-arg]
