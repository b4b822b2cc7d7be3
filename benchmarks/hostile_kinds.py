"""More hostile sheets: edges of functions, kinks and jumps, branches, subsheets, and numbers of any
size.

Where the text of a sheet says its rules another way (``if … else``, tuples, calls of rule
functions), its ``lines`` have the text, and its ``rules`` what it comes to.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace

from benchmarks.expressions import evaluated
from benchmarks.hostile_sheets import (
    PLAIN,
    ROUGH,
    Dice,
    Sheet,
    expression,
    magnitude,
    names_of,
    planted,
    sides,
)

FOLDED = (
    "abs",
    "min",
    "max",
    "mod",
    "int",
    "round",
    "sgn",
    "frac",
    "atan2d",
    "abs",
    "max",
    "atan2",
)
SATURATING = ("tanh", "exp", "atan", "erf", "erfc", "cosh", "sinh", "asinh", "exp", "tanh")
INVERSE = ("asin", "acos", "asind", "acosd", "acosh", "atanh", "sqrt", "ln", "acosd", "sqrt")

EDGES = (
    ("sin(x)/x = {q}",),
    ("sin(x)/x = {p}",),
    ("(exp(x) - 1)/x = 1",),
    ("(1 - cos(x))/x^2 = 0.5",),
    ("(x^2 - {a}^2)/(x - {a}) = 2*{a}",),
    ("{p}*(x/(1 - (1 + x)^(-36))) = {p}/36",),
    ("{p}*(x/(1 - (1 + x)^(-36))) = {p}/30",),
    ("tanh(x) = 1",),
    ("tanh({p}*x) = {near}",),
    ("tanh(x)*y = {p}", "y - {p} = {tiny}"),
    ("erf(x) = 1",),
    ("erfc(x) = {tiny}",),
    ("atan(x) = pi/2",),
    ("atan({big}*x) = {near}",),
    ("exp(-{p}*x) = 0",),
    ("exp(-x) + exp(x) = 2",),
    ("exp(-{big}*x^2) = 1",),
    ("1/(1 + exp(-x)) = {near}",),
    ("1/(1 + exp(-{big}*x)) = 0.5",),
    ("x^x = {near}",),
    ("ln(1 + x) = {tiny}",),
    ("ln(1 + x) = x",),
    ("sqrt(1 + x) - 1 = {tiny}",),
    ("sqrt(1 + x) - 1 = x/2",),
    ("(1 + 1/x)^x = 2.7182818",),
    ("asin(x) = pi/2",),
    ("asin(x) = {near}",),
    ("acos(x) = {tiny}",),
    ("acosd(x) = {tiny}",),
    ("asind(x) = 90 - {tiny}",),
    ("asind({near}) = x", "sind(x) = y"),
    ("cos(asin(x)) = {tiny}",),
    ("cos(asin(x*y)) = {tiny}", "x = y"),
    ("sin(acos(x)) = x",),
    ("acosh(x) = {tiny}",),
    ("atanh(x) = {p}*10",),
    ("sind(x) = {near}",),
    ("cosd(x) = {near}", "y = sind(x)"),
    ("tand(x) = {big}",),
    ("tand(x)*cosd(x) = {q}",),
    ("atan2d(y, x) = {a}*10", "x^2 + y^2 = {p}"),
    ("atan2d(y, x) = 180", "x^2 + y^2 = {p}"),
    ("abs(abs(x - {a}) - {p}) = {p}",),
    ("abs(x - {a}) + abs(x + {a}) = 2*abs({a})",),
    ("abs(sgn(x)) = 1", "x^2 = {p}"),
    ("max(x, -x) = {p}",),
    ("min(x, {a}) = max(x, {a})",),
    ("max(x, y) = {p}", "min(x, y) = {a}"),
    ("min(x, y) + max(x, y) = {a}", "x - y = {p}"),
    ("mod(x, 3) = 1", "x^2 = 16"),
    ("mod(x, {p}) = {p}",),
    ("x - mod(x, 1) = int(x)",),
    ("int(x) + frac(x) = {a}",),
    ("round(x)^2 = 4", "x^3 = {p}"),
    ("int(x)*round(y) = 6", "x + y = {a}"),
    ("(-x)^3 = {a}",),
    ("x^3 = -{p}",),
    ("x^(-3) = {a}",),
    ("(x - {a})^4 = {tiny}^4",),
    ("(-{p})^x = -1",),
    ("x^7 = {a}", "y = (-x)^7"),
    ("x*1e300*1e300 = {p}",),
    ("x/1e-300 = {p}*1e300",),
    ("x^2 = 1e-300",),
    ("x^2 = 1e300", "x*y = 1e-300"),
    ("x*1e-200 = y*1e200", "x + y = {p}"),
    ("sqrt(x^2 + y^2) = 1e200", "x = y"),
    ("x^2 + y^2 = 1e-320", "x = 2*y"),
    ("exp(x) = 1e308", "exp(y) = 1e-308"),
    ("sin({big}*x) = 0", "x^2 = {p}"),
    ("sin(pi)*x = {tiny}",),
    ("cos(pi/2)*x = {a}",),
    ("tan(pi/2) = x",),
    ("ln({p}*sin(pi)/x) = {a}*10",),
    ("x + {big} = {big}",),
    ("(x + {big}) - {big} = {a}",),
    ("(x + {big})^2 - {big}^2 = {a}",),
    ("x*y = {p}", "(x + {big})*y = {p} + {big}*y"),
    ("x/y = {p}", "x*{tiny} = y*{tiny}*{p}"),
    ("x - y = 0", "1/(x - y) = {a}"),
    ("0/x = 0",),
    ("x/x = 1", "x + 1 = 1"),
    ("x^0.5 = -{tiny}",),
    ("x = x^2/x", "x^2 = {p}"),
    ("gamma(x) = {p}",),
    ("gamma(x) = 24",),
    ("j0(x) = 0", "y = j0(x)*{big}"),
)


def edges(random: Dice) -> Sheet:
    """Saturation, removable singularities, ends of domains, kinks, jumps and ends of the floats."""
    a, p = magnitude(random, 1), abs(magnitude(random, 1))
    words = {
        "a": f"({a!r})",
        "p": repr(p),
        "q": repr(random.choice((0.0, 1.0, -1.0, 0.5))),
        "big": repr(10.0 ** random.randint(6, 20)),
        "tiny": repr(10.0 ** -random.randint(4, 20)),
        "near": repr(1 - random.choice((1, 0, -1)) * 10.0 ** -random.randint(5, 16)),
    }
    rules = [("", *rule.format(**words).split(" = ")) for rule in random.choice(EDGES)]
    random.shuffle(rules)
    names = sorted({name for rule in rules for name in names_of(" ".join(rule))})
    guesses = {name: magnitude(random, 2) for name in names if random.random() < 0.25}
    ranges = {name: (-10.0, 10.0) for name in names if random.random() < 0.2}
    return Sheet("edges", tuple(rules), {}, guesses, ranges)


def folded(random: Dice) -> Sheet:
    """Planted among kinks and jumps: nested abs, min, max, mod, int, round, directions."""
    return replace(planted(random, functions=FOLDED), kind="folded")


def saturating(random: Dice) -> Sheet:
    made = planted(random, random.choice((1.0, 2.0)), functions=SATURATING)
    return replace(made, kind="saturating")


def inverse(random: Dice) -> Sheet:
    return replace(planted(random, random.choice((0.3, 1.0)), functions=INVERSE), kind="inverse")


def huge(random: Dice) -> Sheet:
    """Planted states of 1e±30 up to 1e±300."""
    made = planted(random, random.choice((30.0, 100.0, 300.0)), limit=1e305)
    return replace(made, kind="huge scales")


def branched(random: Dice) -> Sheet:
    """Planted, with some rules in one arm of an ``if … else`` that waits on what it determines, and
    others that look at a symbol."""
    made = planted(random)
    assert made.planted is not None
    lines, rules = [], []
    symbol = random.random() < 0.3
    for _, left, right in made.rules:
        way = random.random()
        if way < 0.5:
            condition = _condition(random, made)
            other = sides(random, list(made.planted))
            holds = evaluated(condition, made.planted)
            here, there = ((left, right), other) if holds else (other, (left, right))
            lines.append(f"if {condition} then {' = '.join(here)} else {' = '.join(there)}")
            rules += [(condition, *here), (f"not ({condition})", *there)]
        elif symbol and way < 0.7:
            lines.append(f"if mode = 'open then {left} = {right} else {left} = {right} + 1")
            rules.append(("", left, right))
        else:
            lines.append(f"{left} = {right}")
            rules.append(("", left, right))
    symbols = {"mode": "'open"} if any("mode" in line for line in lines) else {}
    return replace(made, kind="branched", rules=tuple(rules), lines=tuple(lines), symbols=symbols)


def _condition(random: Dice, made: Sheet) -> str:
    """A comparison with a number that is not too near to the planted value."""
    assert made.planted is not None
    name = random.choice(list(made.planted))
    edge = made.planted[name] * random.choice((0.5, 0.9, 1.1, 2.0, -1.0))
    one = f"{name} {random.choice(('<', '>', '<=', '>='))} {edge!r}"
    if random.random() < 0.7:
        return one
    return f"{one} {random.choice(('and', 'or'))} {name} {random.choice('<>')} {3 * edge!r}"


def called(random: Dice) -> Sheet:
    """Planted, with rules in rule functions that are called forwards and backwards, and some in
    tuples."""
    made = planted(random)
    functions, calls, waiting = [], [], []
    for place, (_, left, right) in enumerate(made.rules):
        way, inside = random.random(), sorted(names_of(left))
        if way < 0.5:
            given = ", ".join(f"p{name}" for name in inside)
            body = _renamed(left, inside)
            functions.append(f"function f{place}({given}; out)\nrules\n  out = {body}")
            calls.append(f"call f{place}({', '.join(inside)}; {right})")
        elif way < 0.6:
            given = ", ".join(f"p{name}" for name in inside)
            functions.append(
                f"function f{place}({given}; out)\nrules\n  inner = {_renamed(left, inside)}\n  "
                "out = 2*inner"
            )
            calls.append(f"f{place}({', '.join(inside)})/2 = {right}")
        else:
            waiting.append((left, right))
    if len(waiting) > 1 and random.random() < 0.7:
        (a, b), (c, d) = waiting.pop(), waiting.pop()
        calls.append(f"({a}, {c}) = ({b}, {d})")
    calls += [f"{left} = {right}" for left, right in waiting]
    return replace(made, kind="called", lines=tuple(calls), head=tuple(functions))


def _renamed(text: str, names: list[str]) -> str:
    return re.sub(rf"\b({'|'.join(names)})\b", r"p\1", text)


def jumpy(random: Dice) -> Sheet:
    """Random rules of kinks, jumps and inverse functions, that may have any number of answers."""
    names = random.sample(("a", "b", "x", "y", "z"), random.randint(1, min(3, random.most)))
    functions = (*FOLDED, *INVERSE, *ROUGH)
    rules = []
    for _ in names:
        left = expression(random, names, random.randint(1, 2), functions)
        left = left if names_of(left) else names[0]
        rules.append(("", left, expression(random, names, random.randint(0, 1), functions)))
    return Sheet(
        "jumpy",
        tuple(rules),
        {name: magnitude(random, 1) for name in names if random.random() < 0.2},
    )


KINDS: Mapping[str, Callable[[Dice], Sheet]] = {
    **PLAIN,
    "edges": edges,
    "folded": folded,
    "saturating": saturating,
    "inverse": inverse,
    "huge scales": huge,
    "branched": branched,
    "called": called,
    "jumpy": jumpy,
}


def sheet(seed: int, most: int = 5) -> Sheet:
    """The sheet of a seed, always the same, with at most so many unknowns."""
    random = Dice(seed, most)
    kind = random.choice(tuple(KINDS))
    return KINDS[kind](random)
