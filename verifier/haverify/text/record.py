"""`dataclass` made faster: classes of the same behaviour, made in a twentieth of the time.

The standard decorator compiles up to six functions for each class, about a millisecond, and its module imports another
ten; `haverify lint` is to start, read a spec with some two hundred classes and answer in less than that adds up to.
Here one function is compiled (`__init__`, so that calls stay fast) for all classes of one shape, when the first object
is made, and the others are shared. `dataclasses.fields`, `replace`, `asdict`, matching by position, copying and
pickling work as usual.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property
from operator import attrgetter
from types import CodeType, FunctionType
from typing import Any, NamedTuple, NoReturn, TypeVar, dataclass_transform, overload

T = TypeVar("T")
_NONE = object()


class _Field(NamedTuple):
    """What is said about an attribute; no `default` and no `factory`: its value must be given."""

    default: Any = _NONE
    factory: Any = _NONE
    compare: bool = True
    repr: bool = True


@overload
def field(*, default: T, compare: bool = True, repr: bool = True) -> T: ...
@overload
def field(*, default_factory: Callable[[], T], compare: bool = True, repr: bool = True) -> T: ...
def field(*, default: Any = _NONE, default_factory: Any = _NONE, compare: bool = True, repr: bool = True) -> Any:
    """As the `field` of `dataclasses`, with those of its options that are needed."""
    return _Field(default, default_factory, compare, repr)


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def record(cls: type[T]) -> type[T]:
    """The class with fields from its annotations, frozen and slotted: `dataclass(frozen=True, slots=True)`.

    It has no base class but `object`; what its cached properties keep is no part of it.

    Example
    -------
    >>> @record
    ... class Point:
    ...     x: int
    ...     y: int = 0
    >>> Point(1), Point(1) == Point(1, 0), hash(Point(1)) == hash(Point(1, 0))
    (Point(x=1, y=0), True, True)
    """
    own = dict(cls.__dict__)
    fields = _fields(own)
    body = {k: v for k, v in own.items() if k not in fields and k not in ("__dict__", "__weakref__")}
    names = tuple(fields)
    keeps = any(isinstance(v, cached_property) for v in own.values())
    body["__slots__"] = (*names, "__dict__") if keeps else names
    body["_key"] = staticmethod(_key(tuple(n for n in names if fields[n].compare)))
    body["__init__"] = _first_init
    for name, shared in _SHARED.items():
        body.setdefault(name, shared)
    made: Any = type(cls.__name__, (), body | _described(fields))
    return made  # type: ignore[no-any-return]


@dataclass_transform(eq_default=False, field_specifiers=(field,))
def holder(cls: type[T]) -> type[T]:
    """The class with fields from its annotations that may change; objects equal themselves only: `dataclass(eq=False)`.

    It has no base class but `object`.

    Example
    -------
    >>> @holder
    ... class Counter:
    ...     count: int = 0
    >>> Counter(), Counter() == Counter()
    (Counter(count=0), False)
    """
    fields = _fields(cls.__dict__)
    for name in fields:
        if name in cls.__dict__:
            delattr(cls, name)
    for name, value in (_described(fields) | {"__init__": _first_init, "__repr__": _repr}).items():
        setattr(cls, name, value)
    return cls


def replace(of: T, **changes: Any) -> T:
    """The same with other values of some fields."""
    names: tuple[str, ...] = of.__match_args__  # type: ignore[attr-defined]
    return type(of)(**{name: getattr(of, name) for name in names} | changes)


def _fields(own: Any) -> dict[str, _Field]:
    given = {name: own.get(name, _NONE) for name in own.get("__annotations__", {})}
    return {name: f if isinstance(f, _Field) else _Field(f) for name, f in given.items()}


class _Standard:
    """`__dataclass_fields__`, made when someone asks: `dataclasses` is slow to import, and few do."""

    def __get__(self, instance: object, owner: Any) -> Any:
        import dataclasses

        own: dict[str, _Field] = owner._fields
        specified = [(name, owner.__annotations__[name], dataclasses.field(**_options(f))) for name, f in own.items()]
        standard: Any = dataclasses.make_dataclass(owner.__name__, specified)
        owner.__dataclass_fields__ = standard.__dataclass_fields__
        return standard.__dataclass_fields__


def _options(f: _Field) -> dict[str, Any]:
    given = {"default": f.default, "default_factory": f.factory}
    return {"compare": f.compare, "repr": f.repr} | {k: v for k, v in given.items() if v is not _NONE}


def _described(fields: dict[str, _Field]) -> dict[str, Any]:
    return {"_fields": fields, "__match_args__": tuple(fields), "__dataclass_fields__": _Standard()}


def _first_init(self: Any, *values: Any, **named: Any) -> None:
    """`__init__` of a class until its first object is made."""
    cls: Any = type(self)
    setters = {n: getattr(cls, n).__set__ for n in cls._fields} if "__slots__" in cls.__dict__ else {}
    cls.__init__ = _init(cls._fields, setters, hasattr(cls, "__post_init__"))
    cls.__init__(self, *values, **named)


def _init(fields: dict[str, _Field], setters: dict[str, Any], has_post_init: bool) -> Any:
    """`__init__` with the fields as parameters, in order; what has no setter is assigned."""
    optional = [f.default is not _NONE or f.factory is not _NONE for f in fields.values()]
    if optional != sorted(optional):
        raise TypeError(f"a field without default follows one that has a default: {', '.join(fields)}")
    made = tuple(f.factory is not _NONE for f in fields.values())
    template = _template(made, bool(setters), has_post_init)
    scope: dict[str, Any] = {"_NONE": _NONE} | {f"_s{k}": setter for k, setter in enumerate(setters.values())}
    scope |= {f"_f{k}": f.factory for k, f in enumerate(fields.values())}
    attributes = {f"_{k}": name for k, name in enumerate(fields)}
    code = template.replace(
        co_varnames=("self", *fields), co_names=tuple(attributes.get(n, n) for n in template.co_names)
    )
    return FunctionType(
        code, scope, "__init__", tuple(f.default for f in list(fields.values())[optional.count(False) :])
    )


@cache
def _template(made: tuple[bool, ...], has_setters: bool, has_post_init: bool) -> CodeType:
    """The code of `__init__` for fields named `_0`, `_1`, ...: compiled once for all classes of one shape.

    A field that is `made` and not given gets what `_f0`, `_f1`, ... returns.
    """
    values = [f"_f{k}() if _{k} is _NONE else _{k}" if m else f"_{k}" for k, m in enumerate(made)]
    lines = [f" _s{k}(self, {v})" if has_setters else f" self._{k} = {v}" for k, v in enumerate(values)]
    lines += [" self.__post_init__()"] if has_post_init else []
    scope: dict[str, Any] = {}
    parameters = "".join(f", _{k}" for k in range(len(made)))
    exec(f"def __init__(self{parameters}):\n" + "\n".join(lines or [" pass"]), scope)
    code: CodeType = scope["__init__"].__code__
    return code


def _key(names: tuple[str, ...]) -> Callable[[Any], Any]:
    """What two records of a class are compared by."""
    return attrgetter(*names) if names else lambda _: ()


def _eq(self: Any, other: Any) -> Any:
    if other.__class__ is not self.__class__:
        return NotImplemented
    return bool(self._key(self) == self._key(other))


def _hash(self: Any) -> int:
    return hash(self._key(self))


def _repr(self: Any) -> str:
    shown = ", ".join(f"{n}={getattr(self, n)!r}" for n, f in self._fields.items() if f.repr)
    return f"{type(self).__qualname__}({shown})"


def _setattr(self: Any, name: str, value: object) -> NoReturn:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(f"cannot assign to field {name!r} of {type(self).__name__}")


def _delattr(self: Any, name: str) -> NoReturn:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(f"cannot delete field {name!r} of {type(self).__name__}")


def _getstate(self: Any) -> list[Any]:
    return [getattr(self, name) for name in self._fields]


def _setstate(self: Any, state: list[Any]) -> None:
    for name, value in zip(self._fields, state, strict=True):
        object.__setattr__(self, name, value)


_SHARED = {
    "__eq__": _eq,
    "__hash__": _hash,
    "__repr__": _repr,
    "__setattr__": _setattr,
    "__delattr__": _delattr,
    "__getstate__": _getstate,
    "__setstate__": _setstate,
}
