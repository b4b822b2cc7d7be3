"""The light dataclasses do what the standard ones do."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import pytest

from rulesheets import record

MAKERS = [pytest.param(dataclasses, id="standard"), pytest.param(record, id="light")]


def classes(maker: Any) -> tuple[Any, Any, Any]:
    """A frozen class with slots, a frozen one, and one that can change."""
    dataclass, field = maker.dataclass, maker.field

    @dataclass(frozen=True, slots=True)
    class Slotted:
        """Documented."""

        name: str
        size: float = 1.5
        place: int | None = field(default=None, compare=False, repr=False)

        @property
        def double(self) -> float:
            return 2 * self.size

    @dataclass(frozen=True)
    class Frozen(Mapping[str, int]):
        by_name: Mapping[str, int] = field(default_factory=dict)
        worst: float = 0.0

        def __getitem__(self, name: str) -> int:
            return self.by_name[name]

        def __iter__(self) -> Iterator[str]:
            return iter(self.by_name)

        def __len__(self) -> int:
            return len(self.by_name)

        @cached_property
        def total(self) -> int:
            return sum(self.by_name.values())

    @dataclass
    class Changing:
        values: list[int]
        more: list[int] = field(default_factory=list)
        said: str = "no"

    return Slotted, Frozen, Changing


@pytest.mark.parametrize("maker", MAKERS)
def test_values_are_made_compared_and_shown(maker: Any) -> None:
    slotted, frozen, changing = classes(maker)
    assert repr(slotted("a")).endswith("Slotted(name='a', size=1.5)")
    assert slotted("a", place=3) == slotted("a") != slotted("a", 2.0)
    assert hash(slotted("a", place=3)) == hash(slotted("a"))
    assert slotted("a").__eq__("a") is NotImplemented
    assert slotted("a", 2.0).double == 4.0
    assert slotted.__doc__ == "Documented."
    assert not hasattr(slotted("a"), "__dict__")
    assert frozen({"x": 1}) == frozen({"x": 1}) != frozen({"x": 1}, 1.0)
    assert frozen({"x": 1}).total == 1
    assert changing([1]) == changing(values=[1], more=[], said="no")
    assert changing([1]).more is not changing([1]).more
    with pytest.raises(TypeError, match="unhashable"):
        hash(changing([]))
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'name'"):
        slotted()
    with pytest.raises(TypeError, match="unexpected keyword argument 'other'"):
        slotted("a", other=1)


@pytest.mark.parametrize("maker", MAKERS)
def test_frozen_values_stay_as_they_are(maker: Any) -> None:
    slotted, frozen, changing = classes(maker)
    for value, name in ((slotted("a"), "name"), (frozen(), "worst"), (frozen(), "else")):
        with pytest.raises((dataclasses.FrozenInstanceError, TypeError)):
            setattr(value, name, 1)
        with pytest.raises((dataclasses.FrozenInstanceError, TypeError)):
            delattr(value, name)
    free = changing([])
    free.said = "yes"
    assert free.said == "yes"


@pytest.mark.parametrize("maker", MAKERS)
def test_values_are_matched_replaced_and_copied(maker: Any) -> None:
    slotted, frozen, changing = classes(maker)
    match slotted("a", 2.0):
        case slotted(name, size=size):
            assert (name, size) == ("a", 2.0)
    for replace in (maker.replace, dataclasses.replace):
        assert replace(slotted("a", place=3), size=4.0).place == 3
        assert replace(slotted("a"), size=4.0) == slotted("a", 4.0)
        assert replace(frozen({"x": 1}), worst=1.0) == frozen({"x": 1}, 1.0)
        assert replace(changing([1]), said="yes") == changing([1], [], "yes")
    assert copy.deepcopy(changing([1], [2])) == changing([1], [2])
    assert copy.copy(slotted("a", place=3)).place == 3


@pytest.mark.parametrize("maker", MAKERS)
def test_tools_see_a_dataclass(maker: Any) -> None:
    slotted, frozen, changing = classes(maker)
    assert dataclasses.is_dataclass(slotted) and dataclasses.is_dataclass(slotted("a"))
    assert [f.name for f in dataclasses.fields(slotted)] == ["name", "size", "place"]
    assert dataclasses.asdict(changing([1])) == {"values": [1], "more": [], "said": "no"}
    assert list(inspect.signature(slotted).parameters) == ["name", "size", "place"]
    assert inspect.signature(frozen).parameters["worst"].default == 0.0


def test_nodes_and_models_travel_between_processes() -> None:
    import rulesheets

    model = rulesheets.loads("if x > 1 then y = sqrt(x) + 2\nx = 3")
    there = pickle.loads(pickle.dumps(model))
    assert there == model
    assert there.equations[0].rule == model.equations[0].rule
