"""Small sheets at special points: one to three rules whose numbers are where functions have their
edges.

States are planted at 0, ±1, right angles, whole turns, the ends of the floats and their neighbours,
and the right sides computed with 50 digits. A sheet of one unknown is held to a search by brute
force besides: an answer that is called complete without a root, or a root where there is said to be
none, is a *false completeness*.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from benchmarks.brute_force import missing
from benchmarks.expressions import Undefined, evaluated
from benchmarks.hostile import false_claims as claims_of_any
from benchmarks.hostile_sheets import Dice, Sheet, names_of
from solver import Result

PLAIN = (0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 3.0)
ANGLES = (30.0, 45.0, 60.0, 90.0, 180.0, 270.0, 360.0, -90.0, -180.0)
FAR = (
    *(
        sign * 10.0**k
        for sign in (1, -1)
        for k in (9, -9, 16, -16, 100, -100, 200, -200, 300, -300)
    ),
    1e308,
)
ENDS = (5e-324, 2.0**-1022, 1.7976931348623157e308)

SMOOTH = (
    "sin",
    "cos",
    "tan",
    "exp",
    "sqrt",
    "ln",
    "log",
    "atan",
    "sind",
    "cosd",
    "tand",
    "tanh",
    "cosh",
)
SMOOTH += ("sinh", "asinh", "atand", "erf", "erfc", "abs")
ENDED = ("asin", "acos", "asind", "acosd", "acosh", "atanh", "sqrt", "ln")
KINKED = ("abs", "int", "frac", "round", "sgn", "mod", "min", "max")
EVEN = (
    "{0}^2",
    "abs({0})",
    "cosd({0})",
    "cos({0})",
    "cosh({0})",
    "({1}/{0})^2",
    "{0}^4",
    "{1}*{0}^2",
    "abs({0})^0.5",
)
ARGUMENTS = (
    "{x}",
    "{x}",
    "{a}*{x}",
    "{x} + {a}",
    "{a}*{x} + {b}",
    "{x}^2",
    "{a}/{x}",
    "{x}^3",
    "{a} - {x}",
    "{x}/{a}",
)
OF_TWO = ("{x}*{y}", "{x} + {y}", "{x}/{y}", "{x} - {y}", "{a}*{x}*{y}", "{x}^2*{y}", "{x}/{y}^2")


def special(random: Dice, wild: float = 0.3) -> float:
    """A number of the tables; ``wild``: the chance of one far from 1."""
    way = random.random()
    value = random.choice(
        FAR if way < 0.9 * wild else ENDS if way < wild else random.choice((PLAIN, ANGLES))
    )
    if random.random() < 0.12:
        value = math.nextafter(value, random.choice((-math.inf, math.inf)))
    return value if math.isfinite(value) else 1.0


def _number(random: Dice, wild: float = 0.15) -> str:
    value = special(random, wild)
    return f"({value!r})" if value < 0 else repr(value)


def argument(random: Dice, names: list[str]) -> str:
    """Linear in, or a monomial of, the first of the names, and of another one at times."""
    form = random.choice(OF_TWO if len(names) > 1 and random.random() < 0.6 else ARGUMENTS)
    other = random.choice(names[1:]) if len(names) > 1 else ""
    return form.format(x=names[0], y=other, a=_number(random), b=_number(random))


def applied(random: Dice, function: str, inside: str) -> str:
    if function in ("mod", "min", "max", "atan2", "atan2d"):
        pair = [inside, _number(random, 0.05)]
        random.shuffle(pair)
        return f"{function}({', '.join(pair)})"
    return f"{function}({inside})"


Form = Callable[[Dice, list[str]], str]


def _planted(random: Dice, form: Form, kind: str, most: int = 3) -> Sheet:
    """A rule of the form for each unknown, at a special state; now and then with a right side of
    any kind."""
    n = min(most, random.most, random.choice((1, 1, 1, 1, 2, 2, 3)))
    names = random.sample(("x", "y", "z", "a"), n)
    wild = random.choice((0.0, 0.0, 0.3, 1.0))
    state = {name: special(random, wild) for name in names}
    rules, fits = [], True
    for k, name in enumerate(names):
        others = (
            [other for other in names if other != name] if n > 1 and random.random() < 0.7 else []
        )
        for _ in range(20):
            left = form(random, [name, *others])
            right = value(left, state)
            if random.random() < 0.15:
                right, fits = special(random), False
            if name in names_of(left) and right is not None:
                rules.append(("", left, repr(right)))
                break
        fits &= len(rules) == k + 1
    return Sheet(
        kind, tuple(rules) or (("", names[0], "1"),), planted=state if fits and rules else None
    )


def value(text: str, state: Mapping[str, float]) -> float | None:
    """Rounded from 50 digits; None where there is none, or no float for it."""
    try:
        number = float(evaluated(text, state))
    except (Undefined, OverflowError):
        return None
    return number if math.isfinite(number) else None


def _one(random: Dice, names: list[str]) -> str:
    return applied(random, random.choice((*SMOOTH, *ENDED)), argument(random, names))


def _nested(random: Dice, names: list[str]) -> str:
    return applied(random, random.choice((*SMOOTH, *ENDED, *KINKED)), _one(random, names))


def _product(random: Dice, names: list[str]) -> str:
    second = argument(random, names) if random.random() < 0.3 else _one(random, names)
    return f"{_one(random, names)}{random.choice('*/')}({second})"


def _cancelling(random: Dice, names: list[str]) -> str:
    one, x = _one(random, names), names[0]
    number = _number(random, 0.6)
    return random.choice(
        (
            f"({x} + {number}) - {number}",
            f"({x} - {number})^2 - {number}^2",
            f"{one} - {_one(random, names)}",
            f"{one} + {argument(random, names)}",
            f"{one} - {_number(random)}",
            f"{one} - {x}",
        )
    )


def _power(random: Dice, names: list[str]) -> str:
    inside = argument(random, names)
    power = random.choice(
        ("2", "3", "4", "0.5", "1.5", "(-1)", "(-2)", "(1/3)", "0", "0.1", "20", "(-0.5)", "1e-9")
    )
    other = names[1] if len(names) > 1 else names[0]
    base = f"{abs(special(random))!r}"
    return random.choice(
        (
            f"({inside})^{power}",
            f"({inside})^{power}",
            f"{base}^({inside})",
            f"{names[0]}^{other}",
            f"({inside})^{other}",
        )
    )


def _kinked(random: Dice, names: list[str]) -> str:
    inside = random.choice((argument, _one))(random, names)
    kink = applied(random, random.choice(KINKED), inside)
    return kink if random.random() < 0.6 else f"{kink} + {argument(random, names)}"


def _directed(random: Dice, names: list[str]) -> str:
    if random.random() < 0.4:
        return applied(random, random.choice(ENDED), argument(random, names))
    function = random.choice(("atan2", "atan2d"))
    second = random.choice([*names[1:], names[0], _number(random)])
    pair = [argument(random, names[:1]), second]
    random.shuffle(pair)
    return f"{function}({', '.join(pair)})"


def _checked(random: Dice) -> Sheet:
    """An even or periodic rule, and a check that one mirror answer fits, or both."""
    x = special(random, random.choice((0.0, 0.3, 1.0)))
    k = _number(random)
    left = random.choice(EVEN).format("x", k)
    check = random.choice(EVEN).format("x", k) if random.random() < 0.6 else argument(random, ["x"])
    state = {"x": x}
    rules = [
        ("", text, repr(right))
        for text in (left, check)
        if (right := value(text, state)) is not None
    ]
    if random.random() < 0.3 and (right := value("2*x", state)) is not None:
        state["y"] = right
        rules.append(("", "y", "2*x"))
    random.shuffle(rules)
    return Sheet("checked", tuple(rules) or (("", "x", repr(x)),), planted=state)


def _edged(random: Dice) -> Sheet:
    """An ``if … then … else`` on the unknown, at its edge or by it; planted if no rounding
    decides."""
    x = special(random, random.choice((0.0, 0.0, 0.5)))
    edge = x if random.random() < 0.6 else special(random, 0.1)
    test, opposite = random.choice((("<", ">="), (">", "<="), ("<=", ">"), (">=", "<")))
    conditions = (f"x {test} {edge!r}", f"x {opposite} {edge!r}")
    rules = []
    for condition in conditions:
        left = _one(random, ["x"]) if random.random() < 0.5 else argument(random, ["x"])
        right = value(left, {"x": x})
        if right is None:
            left, right = "x", x
        rules.append((condition, left, repr(right)))
    exact = all(evaluated(f"{left} - ({right})", {"x": x}) == 0 for _, left, right in rules)
    then, other = (f"{left} = {right}" for _, left, right in rules)
    return Sheet(
        "edged",
        tuple(rules),
        planted={"x": x} if exact else None,
        lines=(f"if {conditions[0]} then {then} else {other}",),
    )


def _given(random: Dice) -> Sheet:
    """Some unknowns of another sheet become inputs at their special numbers, and an output hangs on
    them."""
    form = random.choice((_one, _product, _power, _kinked, _directed, _cancelling))
    name, state = "x", {"x": special(random, random.choice((0.0, 0.3, 1.0)))}
    left = form(random, [name])
    if random.random() < 0.5 and (right := value(left, state)) is not None:
        return Sheet("given", (("", "y", left),), dict(state), planted={**state, "y": right})
    state["y"] = special(random, 0.2)
    left = form(random, ["y", "x"])
    right = value(left, state)
    plant = state if right is not None and "y" in names_of(left) else None
    return Sheet(
        "given",
        (("", left, repr(1.0 if right is None else right)),),
        {"x": state["x"]},
        planted=plant,
    )


def _ended(random: Dice) -> Sheet:
    """A range of which the answer is an end, planted if no rounding decides."""
    form = random.choice((_one, _product, _power, _kinked, _cancelling))
    made = _planted(random, form, "ended", most=2)
    state = made.planted or {
        name: special(random, 0.1) for name in names_of(" ".join(made.rules[0][1:]))
    }
    ranges = {}
    for name, x in state.items():
        size = random.choice((1.0, 360.0, abs(x), 1e-9))
        ends = (x, x + size) if random.random() < 0.5 else (x - size, x)
        if ends[0] < ends[1] and max(map(abs, ends)) < math.inf:
            ranges[name] = ends
    exact = made.planted and all(
        evaluated(f"{left} - ({right})", state) == 0 for _, left, right in made.rules
    )
    return replace(made, ranges=ranges, planted=state if exact else None)


SMALL: Mapping[str, Callable[[Dice], Sheet]] = {
    "one function": lambda random: _planted(random, _one, "one function"),
    "nested": lambda random: _planted(random, _nested, "nested"),
    "product": lambda random: _planted(random, _product, "product"),
    "checked": _checked,
    "cancelling": lambda random: _planted(random, _cancelling, "cancelling"),
    "power": lambda random: _planted(random, _power, "power"),
    "edged": _edged,
    "kinked": lambda random: _planted(random, _kinked, "kinked"),
    "directed": lambda random: _planted(random, _directed, "directed"),
    "given": _given,
    "ended": _ended,
}


def sheet(seed: int, most: int = 3) -> Sheet:
    """The sheet of a seed, always the same."""
    random = Dice(seed, most)
    return SMALL[random.choice(tuple(SMALL))](random)


def false_claims(made: Sheet, result: Result) -> Iterator[tuple[str, str]]:
    """What the hostile sheets are judged by, and where there is one unknown, what brute force
    finds."""
    yield from claims_of_any(made, result)
    for root in missing(made, result):
        yield "false completeness", f"{result.status} without {root!r}"
