"""Twenty-three standard systems of nonlinear equations, as rule sheets and as Python functions.

The collection is that of J. Burkardt, *TEST_NONLIN* (people.sc.fsu.edu/~jburkardt), which
NonlinearProblemLibrary.jl takes over; most of it comes from J. Moré, B. Garbow and K. Hillstrom,
*Testing unconstrained optimization software*, ACM TOMS 7 (1981) 17–41, and J. Dennis and R.
Schnabel, *Numerical Methods for Unconstrained Optimization and Nonlinear Equations* (1996). Sizes
are those of the library.

Each system is stated twice, so that one statement checks the other: as the text of a sheet, which
is solved here, and as a function of numbers, which the peers solve and answers are measured by.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Residuals: TypeAlias = Callable[[Sequence[Any], Any], list[Any]]
"""``(x, m)``: the residuals at x (n,) by the functions ``exp sin cos atan sqrt where`` and ``pi``
of m."""


@dataclass(frozen=True)
class Problem:
    """``rules`` are the lines of the sheet, ``start`` the standard start (n,) for x1 … xn."""

    number: int
    title: str
    rules: tuple[str, ...]
    residuals: Residuals
    start: tuple[float, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"x{j}" for j in range(1, len(self.start) + 1))

    @property
    def sheet(self) -> str:
        return "\n".join(["variables", *self.names, "rules", *self.rules, ""])

    def guesses(self, factor: float = 1.0) -> dict[str, float]:
        return {name: factor * value for name, value in zip(self.names, self.start, strict=True)}


def rosenbrock(n: int = 10) -> Problem:
    rules = ["1 - x1 = 0", *(f"10*(x{j + 1} - x{j}^2) = 0" for j in range(1, n))]
    return Problem(
        1,
        "generalised Rosenbrock",
        tuple(rules),
        lambda x, m: [1 - x[0], *(10 * (x[j] - x[j - 1] ** 2) for j in range(1, n))],
        (-1.2, *[1.0] * (n - 1)),
    )


def powell_singular() -> Problem:
    rules = (
        "x1 + 10*x2 = 0",
        "sqrt(5)*(x3 - x4) = 0",
        "(x2 - 2*x3)^2 = 0",
        "sqrt(10)*(x1 - x4)^2 = 0",
    )
    return Problem(
        2,
        "Powell singular",
        rules,
        lambda x, m: [
            x[0] + 10 * x[1],
            m.sqrt(5.0) * (x[2] - x[3]),
            (x[1] - 2 * x[2]) ** 2,
            m.sqrt(10.0) * (x[0] - x[3]) ** 2,
        ],
        (3.0, -1.0, 0.0, 1.0),
    )


def powell_badly_scaled() -> Problem:
    return Problem(
        3,
        "Powell badly scaled",
        ("10000*x1*x2 - 1 = 0", "exp(-x1) + exp(-x2) - 1.0001 = 0"),
        lambda x, m: [10000 * x[0] * x[1] - 1, m.exp(-x[0]) + m.exp(-x[1]) - 1.0001],
        (0.0, 1.0),
    )


def wood() -> Problem:
    rules = (
        "-200*x1*(x2 - x1^2) - (1 - x1) = 0",
        "200*(x2 - x1^2) + 20.2*(x2 - 1) + 19.8*(x4 - 1) = 0",
        "-180*x3*(x4 - x3^2) - (1 - x3) = 0",
        "180*(x4 - x3^2) + 20.2*(x4 - 1) + 19.8*(x2 - 1) = 0",
    )

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        one, two = x[1] - x[0] ** 2, x[3] - x[2] ** 2
        return [
            -200 * x[0] * one - (1 - x[0]),
            200 * one + 20.2 * (x[1] - 1) + 19.8 * (x[3] - 1),
            -180 * x[2] * two - (1 - x[2]),
            180 * two + 20.2 * (x[3] - 1) + 19.8 * (x[1] - 1),
        ]

    return Problem(4, "Wood", rules, residuals, (-3.0, -1.0, -3.0, -1.0))


def helical_valley() -> Problem:
    rules = (
        "if x1 > 0 then turn = atan(x2/x1)/(2*pi)",
        "if x1 < 0 then turn = atan(x2/x1)/(2*pi) + 0.5",
        "if x1 = 0 then turn = 0.25*sgn(x2)",
        "10*(x3 - 10*turn) = 0",
        "10*(sqrt(x1^2 + x2^2) - 1) = 0",
        "x3 = 0",
    )

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        turn = m.atan(x[1] / x[0]) / (2 * m.pi) + m.where(x[0], 0.0, 0.5)
        return [10 * (x[2] - 10 * turn), 10 * (m.sqrt(x[0] ** 2 + x[1] ** 2) - 1), x[2]]

    return Problem(5, "helical valley", rules, residuals, (-1.0, 0.0, 0.0))


def watson(n: int = 2) -> Problem:
    """The gradient of Watson's sum of squares, whose least value is a root of it."""

    def share(i: int, k: int) -> str:
        t = f"({i}/29)"
        slope = " + ".join(f"{j}*{t}^{j - 1}*x{j + 1}" for j in range(1, n))
        total = " + ".join([f"{t}^{j}*x{j + 1}" for j in range(n)])
        return f"{t}^{k - 1}*({slope} - ({total})^2 - 1)*({k} - 2*{t}*({total}))"

    tails = {0: " + 3*x1 - 2*x1*x2 + 2*x1^3", 1: " + x2 - x1^2 - 1"}
    rules = tuple(
        " + ".join(share(i, k) for i in range(1, 30)) + tails.get(k, "") + " = 0" for k in range(n)
    )

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        found: list[Any] = [
            3 * x[0] - 2 * x[0] * x[1] + 2 * x[0] ** 3,
            x[1] - x[0] ** 2 - 1,
            *[0.0] * (n - 2),
        ]
        for t in (i / 29.0 for i in range(1, 30)):
            slope = sum(j * t ** (j - 1) * x[j] for j in range(1, n))
            total = sum(t**j * x[j] for j in range(n))
            for k in range(n):
                found[k] = found[k] + t ** (k - 1) * (slope - total**2 - 1) * (k - 2 * t * total)
        return found

    return Problem(6, "Watson", rules, residuals, (0.0,) * n)


def chebyquad(n: int = 2) -> Problem:
    """Nodes of equal-weight quadrature on [-1, 1]: the means of Chebyshev's polynomials."""

    def polynomial(k: int) -> list[int]:
        before, here = [1], [0, 1]
        for _ in range(k - 1):
            ahead = [0, *(2 * c for c in here)]
            ahead[: len(before)] = [a - b for a, b in zip(ahead, before, strict=False)]
            before, here = here, ahead
        return here

    def text(k: int, name: str) -> str:
        return " + ".join(f"({c})*{name}^{p}" for p, c in enumerate(polynomial(k)) if c)

    rules = []
    for k in range(1, n + 1):
        mean = " + ".join(text(k, f"x{j}") for j in range(1, n + 1))
        rules.append(f"({mean})/{n} + {0 if k % 2 else f'1/{k * k - 1}'} = 0")

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        rows: list[list[Any]] = [[1.0] * n, list(x)]
        for _ in range(1, n):
            rows.append([2 * v * b - a for v, a, b in zip(x, rows[-2], rows[-1], strict=True)])
        return [sum(rows[k]) / n + (0 if k % 2 else 1 / (k * k - 1)) for k in range(1, n + 1)]

    start = tuple((2 * j - 1 - n) / (n + 1) for j in range(1, n + 1))
    return Problem(7, "Chebyquad", tuple(rules), residuals, start)


def brown_almost_linear(n: int = 10) -> Problem:
    total = " + ".join(f"x{j}" for j in range(1, n + 1))
    product = "*".join(f"x{j}" for j in range(1, n + 1))
    rules = [*(f"x{k} + ({total}) - {n + 1} = 0" for k in range(1, n)), f"{product} - 1 = 0"]

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        total, product = sum(x), x[0]
        for v in x[1:]:
            product = product * v
        return [*(v + total - (n + 1) for v in x[:-1]), product - 1]

    return Problem(8, "Brown almost linear", tuple(rules), residuals, (0.5,) * n)


def boundary_value(n: int = 10) -> Problem:
    def rule(k: int) -> str:
        before = f" - x{k - 1}" if k > 1 else ""
        after = f" - x{k + 1}" if k < n else ""
        return f"2*x{k} + 0.5*(1/{n + 1})^2*(x{k} + {k}/{n + 1} + 1)^3{before}{after} = 0"

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        h, y = 1 / (n + 1), [0.0, *x, 0.0]
        return [
            2 * y[k] + 0.5 * h**2 * (y[k] + k * h + 1) ** 3 - y[k - 1] - y[k + 1]
            for k in range(1, n + 1)
        ]

    rules = tuple(rule(k) for k in range(1, n + 1))
    return Problem(9, "discrete boundary value", rules, residuals, _parabola(n))


def integral_equation(n: int = 10) -> Problem:
    def rule(k: int) -> str:
        cubes = {j: f"{j}/{n + 1}*(x{j} + {j}/{n + 1} + 1)^3" for j in range(1, n + 1)}
        below = " + ".join(cubes[j] for j in range(1, k + 1))
        above = [f"(1 - {j}/{n + 1})*(x{j} + {j}/{n + 1} + 1)^3" for j in range(k + 1, n + 1)]
        tail = f" + {k}/{n + 1}*({' + '.join(above)})" if above else ""
        return f"x{k} + ((1 - {k}/{n + 1})*({below}){tail})/(2*{n + 1}) = 0"

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        h = 1 / (n + 1)
        t = [(j + 1) * h for j in range(n)]
        cube = [(v + s + 1) ** 3 for v, s in zip(x, t, strict=True)]
        found = []
        for k in range(n):
            below = sum(t[j] * cube[j] for j in range(k + 1))
            above = sum((1 - t[j]) * cube[j] for j in range(k + 1, n))
            found.append(x[k] + h * ((1 - t[k]) * below + t[k] * above) / 2)
        return found

    rules = tuple(rule(k) for k in range(1, n + 1))
    return Problem(10, "discrete integral equation", rules, residuals, _parabola(n))


def _parabola(n: int) -> tuple[float, ...]:
    return tuple(k * (k - n - 1) / (n + 1) ** 2 for k in range(1, n + 1))


def trigonometric(n: int = 10) -> Problem:
    cosines = " - ".join(f"cos(x{j})" for j in range(1, n + 1))
    rules = tuple(f"{n} - {cosines} + {k}*(1 - cos(x{k})) - sin(x{k}) = 0" for k in range(1, n + 1))

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        cosines = sum(m.cos(v) for v in x)
        return [n - cosines + k * (1 - m.cos(v)) - m.sin(v) for k, v in enumerate(x, 1)]

    return Problem(11, "trigonometric", rules, residuals, (1 / n,) * n)


def variably_dimensioned(n: int = 10) -> Problem:
    total = " + ".join(f"{j}*(x{j} - 1)" for j in range(1, n + 1))
    rules = tuple(f"x{k} - 1 + {k}*({total})*(1 + 2*({total})^2) = 0" for k in range(1, n + 1))

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        total = sum(j * (v - 1) for j, v in enumerate(x, 1))
        return [v - 1 + k * total * (1 + 2 * total**2) for k, v in enumerate(x, 1)]

    return Problem(
        12, "variably dimensioned", rules, residuals, tuple(1 - k / n for k in range(1, n + 1))
    )


def broyden_tridiagonal(n: int = 10) -> Problem:
    def rule(k: int) -> str:
        before = f" - x{k - 1}" if k > 1 else ""
        after = f" - 2*x{k + 1}" if k < n else ""
        return f"(3 - 2*x{k})*x{k}{before}{after} + 1 = 0"

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        y = [0.0, *x, 0.0]
        return [(3 - 2 * y[k]) * y[k] - y[k - 1] - 2 * y[k + 1] + 1 for k in range(1, n + 1)]

    rules = tuple(rule(k) for k in range(1, n + 1))
    return Problem(13, "Broyden tridiagonal", rules, residuals, (-1.0,) * n)


def broyden_banded(n: int = 10) -> Problem:
    def near(k: int) -> list[int]:
        return [j for j in range(max(1, k - 5), min(n, k + 1) + 1) if j != k]

    def rule(k: int) -> str:
        return (
            f"x{k}*(2 + 5*x{k}^2) + 1 - " + " - ".join(f"x{j}*(1 + x{j})" for j in near(k)) + " = 0"
        )

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        return [
            x[k - 1] * (2 + 5 * x[k - 1] ** 2) + 1 - sum(x[j - 1] * (1 + x[j - 1]) for j in near(k))
            for k in range(1, n + 1)
        ]

    rules = tuple(rule(k) for k in range(1, n + 1))
    return Problem(14, "Broyden banded", rules, residuals, (-1.0,) * n)


def hammarling(order: int) -> Problem:
    """The square root of a matrix with 1e-4 on the diagonal and a 1 above it."""

    def entry(i: int, j: int) -> int:
        return order * i + j

    def goal(i: int, j: int) -> float:
        return 0.0001 if i == j else 1.0 if (i, j) == (0, 1) else 0.0

    every = [(i, j) for i in range(order) for j in range(order)]
    rules = tuple(
        " + ".join(f"x{entry(i, k) + 1}*x{entry(k, j) + 1}" for k in range(order))
        + f" - {goal(i, j)} = 0"
        for i, j in every
    )

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        return [
            sum(x[entry(i, k)] * x[entry(k, j)] for k in range(order)) - goal(i, j)
            for i, j in every
        ]

    start = tuple(float(i == j) for i, j in every)
    return Problem(13 + order, f"Hammarling {order} by {order}", rules, residuals, start)


def dennis_schnabel() -> Problem:
    return Problem(
        17,
        "Dennis and Schnabel",
        ("x1 + x2 - 3 = 0", "x1^2 + x2^2 - 9 = 0"),
        lambda x, m: [x[0] + x[1] - 3, x[0] ** 2 + x[1] ** 2 - 9],
        (1.0, 5.0),
    )


def sample_18() -> Problem:
    """Both residuals are defined as 0 where they would divide by 0; either axis is all roots."""
    rules = (
        "if x1 <> 0 then x2^2*(1 - exp(-x1^2))/x1 = 0",
        "if x2 <> 0 then x1*(1 - exp(-x2^2))/x2 = 0",
    )

    def quotient(v: Any, m: Any) -> Any:
        """(1 - exp(-v²))/v, which is v - v³/2 + … near 0."""
        return m.expm1_over(v)

    return Problem(
        18,
        "sample problem 18",
        rules,
        lambda x, m: [x[1] ** 2 * quotient(x[0], m), x[0] * quotient(x[1], m)],
        (2.0, 2.0),
    )


def sample_19() -> Problem:
    return Problem(
        19,
        "sample problem 19",
        ("x1*(x1^2 + x2^2) = 0", "x2*(x1^2 + x2^2) = 0"),
        lambda x, m: [x[0] * (x[0] ** 2 + x[1] ** 2), x[1] * (x[0] ** 2 + x[1] ** 2)],
        (3.0, 3.0),
    )


def scalar() -> Problem:
    return Problem(
        20,
        "scalar x (x - 5)^2",
        ("x1*(x1 - 5)^2 = 0",),
        lambda x, m: [x[0] * (x[0] - 5) ** 2],
        (1.0,),
    )


def freudenstein_roth() -> Problem:
    return Problem(
        21,
        "Freudenstein and Roth",
        ("x1 - x2^3 + 5*x2^2 - 2*x2 - 13 = 0", "x1 + x2^3 + x2^2 - 14*x2 - 29 = 0"),
        lambda x, m: [
            x[0] - x[1] ** 3 + 5 * x[1] ** 2 - 2 * x[1] - 13,
            x[0] + x[1] ** 3 + x[1] ** 2 - 14 * x[1] - 29,
        ],
        (0.5, -2.0),
    )


def boggs() -> Problem:
    return Problem(
        22,
        "Boggs",
        ("x1^2 - x2 + 1 = 0", "x1 - cos(pi/2*x2) = 0"),
        lambda x, m: [x[0] ** 2 - x[1] + 1, x[0] - m.cos(0.5 * m.pi * x[1])],
        (1.0, 0.0),
    )


def chandrasekhar(n: int = 10) -> Problem:
    def rule(i: int) -> str:
        mu = [f"{2 * j - 1}/{2 * n}" for j in range(1, n + 1)]
        total = " + ".join(f"{mu[i - 1]}*x{j}/({mu[i - 1]} + {mu[j - 1]})" for j in range(1, n + 1))
        return f"x{i} - 1/(1 - 0.9*({total})/{2 * n}) = 0"

    def residuals(x: Sequence[Any], m: Any) -> list[Any]:
        mu = [(2 * j + 1) / (2 * n) for j in range(n)]
        return [
            x[i] - 1 / (1 - 0.9 * sum(mu[i] * x[j] / (mu[i] + mu[j]) for j in range(n)) / (2 * n))
            for i in range(n)
        ]

    rules = tuple(rule(i) for i in range(1, n + 1))
    return Problem(23, "Chandrasekhar H", rules, residuals, (1.0,) * n)


PROBLEMS: tuple[Problem, ...] = (
    rosenbrock(),
    powell_singular(),
    powell_badly_scaled(),
    wood(),
    helical_valley(),
    watson(),
    chebyquad(),
    brown_almost_linear(),
    boundary_value(),
    integral_equation(),
    trigonometric(),
    variably_dimensioned(),
    broyden_tridiagonal(),
    broyden_banded(),
    hammarling(2),
    hammarling(3),
    dennis_schnabel(),
    sample_18(),
    sample_19(),
    scalar(),
    freudenstein_roth(),
    boggs(),
    chandrasekhar(),
)
