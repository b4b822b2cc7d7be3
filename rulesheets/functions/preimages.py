"""Inverses of the built-in functions of one argument: every x with f(x) = t, and which t have one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from math import inf

from rulesheets.construct import add, call, negative, power, subtract
from rulesheets.functions.builtin import Branches, Preimage
from rulesheets.nodes import Expression, Number

_PI, _TURN = call("pi"), Number(180.0)


def _by(name: str) -> Branches:
    return lambda t: (call(name, t),)


def _both_signs(name: str) -> Branches:
    return lambda t: (call(name, t), negative(call(name, t)))


def _supplement(name: str, half_turn: Expression) -> Branches:
    return lambda t: (call(name, t), subtract(half_turn, call(name, t)))


def _opposite(name: str, half_turn: Expression) -> Branches:
    return lambda t: (call(name, t), add(call(name, t), half_turn))


def _plus_minus(t: Expression) -> tuple[Expression, ...]:
    return t, negative(t)


def _unit(branches: Branches, period: float) -> Preimage:
    return Preimage(branches, -1.0, 1.0, period=period)


PREIMAGES: Mapping[str, Preimage] = {
    "sqrt": Preimage(lambda t: (power(t, Number(2.0)),), low=0.0),
    "abs": Preimage(_plus_minus, low=0.0),
    "exp": Preimage(_by("ln"), low=0.0, low_open=True),
    "ln": Preimage(_by("exp")),
    "log": Preimage(lambda t: (power(Number(10.0), t),)),
    "log10": Preimage(lambda t: (power(Number(10.0), t),)),
    "sin": _unit(_supplement("asin", _PI), math.tau),
    "cos": _unit(_both_signs("acos"), math.tau),
    "tan": Preimage(_opposite("atan", _PI), period=math.tau),
    "asin": Preimage(_by("sin"), -math.pi / 2, math.pi / 2),
    "acos": Preimage(_by("cos"), 0.0, math.pi),
    "atan": Preimage(_by("tan"), -math.pi / 2, math.pi / 2, True, True),
    "sinh": Preimage(_by("asinh")),
    "cosh": Preimage(_both_signs("acosh"), low=1.0),
    "tanh": Preimage(_by("atanh"), -1.0, 1.0, True, True),
    "asinh": Preimage(_by("sinh")),
    "acosh": Preimage(_by("cosh"), 0.0, inf),
    "atanh": Preimage(_by("tanh")),
    "sind": _unit(_supplement("asind", _TURN), 360.0),
    "cosd": _unit(_both_signs("acosd"), 360.0),
    "tand": Preimage(_opposite("atand", _TURN), period=360.0),
    "asind": Preimage(_by("sind"), -90.0, 90.0),
    "acosd": Preimage(_by("cosd"), 0.0, 180.0),
    "atand": Preimage(_by("tand"), -90.0, 90.0, True, True),
}
