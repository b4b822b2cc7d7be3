"""``dataclass``, ``field`` and ``replace`` of the standard library, for modules that every command imports.

They mean the same and read the same (a type checker sees the standard ones). What differs is the price:
the standard decorator imports ``inspect`` and compiles six methods for each class when it is defined, half a
millisecond each, which for the classes of one solve is more than the solve. Here the methods of a class
are compiled when they are first called, and most never are.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from typing import Any

_ABSENT: Any = object()


class Field:
    """What ``field()`` says of a field; the standard library's word for it."""

    __slots__ = ("compare", "default", "factory", "repr")

    def __init__(self, default: Any, factory: Any, compare: bool, repr: bool) -> None:
        self.default, self.factory, self.compare, self.repr = default, factory, compare, repr


def _field(
    *, default: Any = _ABSENT, default_factory: Any = _ABSENT, compare: bool = True, repr: bool = True
) -> Field:
    return Field(default, default_factory, compare, repr)


def _dataclass(cls: Any = None, /, *, frozen: bool = False, slots: bool = False) -> Any:
    if cls is None:
        return lambda decorated: _dataclass(decorated, frozen=frozen, slots=slots)
    said = dict(cls.__dict__)
    fields = {name: _as_field(said.get(name, _ABSENT)) for name in said.get("__annotations__", ())}
    if slots:
        gone = {"__dict__", "__weakref__", *fields}
        body = {name: value for name, value in said.items() if name not in gone}
        body.update(__slots__=tuple(fields), __qualname__=cls.__qualname__)
        cls = type(cls)(cls.__name__, cls.__bases__, body)
    else:
        for name in fields:
            if isinstance(said.get(name), Field):
                delattr(cls, name)
    cls.__record__ = fields, frozen, slots
    setattr(cls, "__match_args__", tuple(fields))  # noqa: B010 (a type checker holds the name to be final)
    for name, method in _methods(cls, frozen, slots):
        if said.get(name) is None:
            setattr(cls, name, method)
    return cls


def _methods(cls: Any, frozen: bool, slots: bool) -> Iterator[tuple[str, object]]:
    yield "__init__", _Compiled(cls, _init)
    yield "__repr__", _Compiled(cls, _repr)
    yield "__eq__", _Compiled(cls, _eq)
    yield "__hash__", _Compiled(cls, _hash) if frozen else None
    yield "__dataclass_fields__", _Standard(lambda twin: twin.__dataclass_fields__)
    yield "__signature__", _Standard(_signature)
    if frozen:
        yield "__setattr__", _refuse_to_set
        yield "__delattr__", _refuse_to_delete
    if slots:
        yield "__reduce__", _reduce


def _as_field(default: Any) -> Field:
    return default if isinstance(default, Field) else Field(default, _ABSENT, True, True)


def _replace(instance: Any, /, **changes: Any) -> Any:
    for name in type(instance).__match_args__:
        if name not in changes:
            changes[name] = getattr(instance, name)
    return type(instance)(**changes)


# --- methods, compiled when they are first called -------------------------------------


class _Compiled:
    """A method that is not there yet: its first call puts it into the class."""

    __slots__ = ("cls", "source")

    def __init__(self, cls: Any, source: Callable[[Any], tuple[str, dict[str, Any]]]) -> None:
        self.cls, self.source = cls, source

    def __get__(self, instance: Any, owner: Any) -> Any:
        text, scope = self.source(self.cls)
        exec(text, scope)
        name = f"__{self.source.__name__[1:]}__"
        method = scope[name]
        method.__qualname__ = f"{self.cls.__qualname__}.{name}"
        method.__module__ = self.cls.__module__
        setattr(self.cls, name, method)
        return method if instance is None else method.__get__(instance, owner)


def _init(cls: Any) -> tuple[str, dict[str, Any]]:
    fields, frozen, slots = cls.__record__
    scope: dict[str, Any] = {"_absent": _ABSENT, "_put": object.__setattr__}
    parameters, lines = [], []
    for name, field in fields.items():
        value = name
        if field.factory is not _ABSENT:
            scope[f"_make_{name}"] = field.factory
            parameters.append(f"{name}=_absent")
            value = f"_make_{name}() if {name} is _absent else {name}"
        elif field.default is not _ABSENT:
            scope[f"_default_{name}"] = field.default
            parameters.append(f"{name}=_default_{name}")
        else:
            parameters.append(name)
        if not frozen:
            lines.append(f" self.{name} = {value}")
        elif slots:
            scope[f"_put_{name}"] = cls.__dict__[name].__set__
            lines.append(f" _put_{name}(self, {value})")
        else:
            lines.append(f" _put(self, {name!r}, {value})")
    return f"def __init__(self, {', '.join(parameters)}):\n" + "\n".join(lines or [" pass"]), scope


def _repr(cls: Any) -> tuple[str, dict[str, Any]]:
    shown = ", ".join(f"{name}={{self.{name}!r}}" for name, field in cls.__record__[0].items() if field.repr)
    return f'def __repr__(self):\n return f"{{self.__class__.__qualname__}}({shown})"', {}


def _eq(cls: Any) -> tuple[str, dict[str, Any]]:
    own, other = (_compared(cls, of) for of in ("self", "other"))
    return (
        f"def __eq__(self, other):\n return {own} == {other} "
        "if other.__class__ is self.__class__ else NotImplemented",
        {},
    )


def _hash(cls: Any) -> tuple[str, dict[str, Any]]:
    return f"def __hash__(self):\n return hash({_compared(cls, 'self')})", {}


def _compared(cls: Any, of: str) -> str:
    return "(" + "".join(f"{of}.{name}, " for name, field in cls.__record__[0].items() if field.compare) + ")"


# --- frozen and slotted classes ---------------------------------------------------------


def _refuse_to_set(self: Any, name: str, value: object) -> None:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _refuse_to_delete(self: Any, name: str) -> None:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _reduce(self: Any) -> tuple[Any, tuple[Any, ...]]:
    """Pickled as the call that makes it."""
    return type(self), tuple(getattr(self, name) for name in type(self).__match_args__)


# --- what tools ask of a dataclass --------------------------------------------------------


class _Standard:
    """An attribute that only tools read: taken from a twin that the standard decorator has made."""

    __slots__ = ("_read",)

    def __init__(self, read: Callable[[Any], Any]) -> None:
        self._read = read

    def __get__(self, instance: object, owner: Any) -> Any:
        import dataclasses
        import inspect

        fields, frozen, _ = owner.__record__
        body = {"__annotations__": inspect.get_annotations(owner), **dict(_standard(fields))}
        twin = type(owner.__name__, (), body)
        return self._read(dataclasses.dataclass(frozen=frozen)(twin))


def _standard(fields: Mapping[str, Field]) -> Iterator[tuple[str, Any]]:
    import dataclasses

    for name, field in fields.items():
        said: dict[str, Any] = {"compare": field.compare, "repr": field.repr}
        if field.default is not _ABSENT:
            said["default"] = field.default
        if field.factory is not _ABSENT:
            said["default_factory"] = field.factory
        yield name, dataclasses.field(**said)


def _signature(twin: Any) -> Any:
    import inspect

    return inspect.signature(twin)


if TYPE_CHECKING:
    from dataclasses import dataclass, field, replace
else:
    dataclass, field, replace = _dataclass, _field, _replace

__all__ = ["dataclass", "field", "replace"]
