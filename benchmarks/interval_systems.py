"""Systems of interval analysis with known numbers of real roots in their ranges, as sheets.

The numbers are those of the literature, and where a count follows by hand the reason is given.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class IntervalSystem:
    """``rules`` in ``names``, each between ``low`` and ``high``: ``roots`` real roots, after
    ``source``."""

    name: str
    names: tuple[str, ...]
    low: float
    high: float
    rules: tuple[str, ...]
    roots: int
    source: str

    @property
    def sheet(self) -> str:
        rows = "\n".join(f"  {name} in [{self.low!r}, {self.high!r}]" for name in self.names)
        return f"variables\n{rows}\nrules\n" + "\n".join(f"  {rule}" for rule in self.rules)


def _sized(name: str, n: int) -> str:
    return name if n == 5 else f"{name} {n}"


def _numbered(count: int) -> tuple[str, ...]:
    return tuple(f"x{i}" for i in range(1, count + 1))


def broyden_banded(n: int = 5) -> IntervalSystem:
    rules = []
    for i in range(1, n + 1):
        band = [j for j in range(max(1, i - 5), min(n, i + 1) + 1) if j != i]
        rest = " + ".join(f"x{j}*(1 + x{j})" for j in band)
        rules.append(f"x{i}*(2 + 5*x{i}^2) + 1 - ({rest}) = 0")
    source = "Moré, Garbow & Hillstrom 1981, 31; one root: van Hentenryck, McAllester & Kapur 1997"
    return IntervalSystem(
        _sized("Broyden banded", n), _numbered(n), -1.0, 1.0, tuple(rules), 1, source
    )


def more_cosnard(n: int = 5) -> IntervalSystem:
    h = 1.0 / (n + 1)
    at = [k * h for k in range(n + 1)]
    rules = []
    for i in range(1, n + 1):
        below = " + ".join(f"{at[j]!r}*(x{j} + {at[j] + 1!r})^3" for j in range(1, i + 1))
        above = (
            " + ".join(f"{1 - at[j]!r}*(x{j} + {at[j] + 1!r})^3" for j in range(i + 1, n + 1))
            or "0"
        )
        rules.append(f"x{i} + {h / 2!r}*({1 - at[i]!r}*({below}) + {at[i]!r}*({above})) = 0")
    source = "Moré & Cosnard 1979; one root: van Hentenryck, McAllester & Kapur 1997"
    return IntervalSystem(
        _sized("Moré–Cosnard", n), _numbered(n), -4.0, 5.0, tuple(rules), 1, source
    )


def brown_almost_linear(n: int = 5) -> IntervalSystem:
    total = " + ".join(_numbered(n))
    rules = (*(f"x{i} + {total} = {n + 1}" for i in range(1, n)), "*".join(_numbered(n)) + " = 1")
    roots = {5: 3, 6: 2, 7: 2}[n]
    source = "Brown 1969; x_i = a, x_n = a^(1 - n) in the range, n a^n - (n + 1) a^(n - 1) + 1 = 0"
    return IntervalSystem(
        _sized("Brown almost linear", n), _numbered(n), -10.0, 10.0, rules, roots, source
    )


def bronstein() -> IntervalSystem:
    rules = ("x^2 + y^2 + z^2 = 36", "x + y = z", "x*y + z^2 = 1")
    source = "Bronstein; 4 z^2 = 38, and x, y are the roots of t^2 - z t + 1 - z^2: 2 times 2"
    return IntervalSystem("Bronstein", ("x", "y", "z"), -100.0, 100.0, rules, 4, source)


def cyclohexane() -> IntervalSystem:
    triples = (("y", "z"), ("z", "x"), ("x", "y"))
    rules = tuple(f"13 + {a}^2*(1 + {b}^2) + {b}*({b} - 24*{a}) = 0" for a, b in triples)
    source = "Emiris & Mourrain 1999: 16 real roots"
    return IntervalSystem("cyclohexane", ("x", "y", "z"), -100.0, 100.0, rules, 16, source)


def moore_jones() -> IntervalSystem:
    rows = (
        (0.25428722, 0.18324757, 4, 3, 9),
        (0.37842197, 0.16275449, 1, 10, 6),
        (0.27162577, 0.16955071, 1, 2, 10),
        (0.19807914, 0.15585316, 7, 1, 6),
        (0.44166728, 0.19950920, 7, 6, 3),
        (0.14654113, 0.18922793, 8, 5, 10),
        (0.42937161, 0.21180486, 2, 5, 8),
        (0.07056438, 0.17081208, 1, 7, 6),
        (0.34504906, 0.19612740, 10, 6, 8),
        (0.42651102, 0.21466544, 4, 8, 1),
    )
    rules = tuple(
        f"x{i} = {a!r} + {b!r}*x{p}*x{q}*x{r}" for i, (a, b, p, q, r) in enumerate(rows, 1)
    )
    source = "Moore & Jones 1977; one root: van Hentenryck, McAllester & Kapur 1997"
    return IntervalSystem("Moore–Jones", _numbered(10), -2.0, 2.0, rules, 1, source)


def himmelblau() -> IntervalSystem:
    rules = ("x^2 + y = 11", "x + y^2 = 7")
    return IntervalSystem(
        "Himmelblau", ("x", "y"), -10.0, 10.0, rules, 4, "Himmelblau 1972: 4 real roots"
    )


def robot_kinematics() -> IntervalSystem:
    rules = (
        "0.004731*x1*x3 - 0.3578*x2*x3 - 0.1238*x1 - 0.001637*x2 - 0.9338*x4 + x7 = 0.3571",
        "0.2238*x1*x3 + 0.7623*x2*x3 + 0.2638*x1 - 0.07745*x2 - 0.6734*x4 - x7 = 0.6022",
        "x6*x8 + 0.3578*x1 + 0.004731*x2 = 0",
        "-0.7623*x1 + 0.2238*x2 + 0.3461 = 0",
        *(f"x{i}^2 + x{i + 1}^2 = 1" for i in (1, 3, 5, 7)),
    )
    source = "Morgan & Shapiro 1987; 16 real roots: Kearfott & Novoa 1990"
    return IntervalSystem("robot kinematics", _numbered(8), -1.0, 1.0, rules, 16, source)


def logistic_cycle() -> IntervalSystem:
    rules = ("y = 3.84*x*(1 - x)", "z = 3.84*y*(1 - y)", "x = 3.84*z*(1 - z)")
    source = "May 1976; past 1 + sqrt(8) there are 2 fixed points and 2 cycles of 3: 8 real roots"
    return IntervalSystem("logistic cycle of 3", ("x", "y", "z"), 0.0, 1.0, rules, 8, source)


def freudenstein_roth() -> IntervalSystem:
    rules = ("-13 + x + ((5 - y)*y - 2)*y = 0", "-29 + x + ((y + 1)*y - 14)*y = 0")
    source = "Freudenstein & Roth 1963; the difference is 2 y^3 - 4 y^2 - 12 y - 16: one real root"
    return IntervalSystem("Freudenstein–Roth", ("x", "y"), -100.0, 100.0, rules, 1, source)


SYSTEMS = (
    broyden_banded(),
    more_cosnard(),
    brown_almost_linear(),
    bronstein(),
    cyclohexane(),
    moore_jones(),
    himmelblau(),
    robot_kinematics(),
    logistic_cycle(),
    freudenstein_roth(),
)


def yamamura(n: int = 8) -> IntervalSystem:
    names = _numbered(n)
    total = " + ".join(names)
    rules = tuple(
        f"2.5*{x}^3 - 10.5*{x}^2 + 11.8*{x} + {total} = {i}" for i, x in enumerate(names, 1)
    )
    roots = {4: 3, 5: 5, 6: 5, 7: 7, 8: 7}[n]
    source = (
        "Yamamura, Kawata & Tokue 1998; counted over s = x1 + … + xn, of which each x_i is a "
        "cubic root"
    )
    return IntervalSystem(f"Yamamura {n}", names, -10.0, 10.0, rules, roots, source)


def caprasse() -> IntervalSystem:
    rules = (
        "y^2*z + 2*x*y*t - 2*x - z = 0",
        "-x^3*z + 4*x*y^2*z + 4*x^2*y*t + 2*y^3*t + 4*x^2 - 10*y^2 + 4*x*z - 10*y*t + 2 = 0",
        "2*y*z*t + x*t^2 - x - 2*z = 0",
        "-x*z^3 + 4*y*z^2*t + 4*x*z*t^2 + 2*y*t^3 + 4*x*z + 4*z^2 - 10*y*t - 10*t^2 + 2 = 0",
    )
    source = "Moritsugu & Kuriyama 1999; 18 real roots: COPRIN"
    return IntervalSystem("Caprasse", ("x", "y", "z", "t"), -10.0, 10.0, rules, 18, source)


def neurophysiology() -> IntervalSystem:
    rules = (
        "x1^2 + x3^2 = 1",
        "x2^2 + x4^2 = 1",
        "x5*x3^3 + x6*x4^3 = 5",
        "x5*x1^3 + x6*x2^3 = 4",
        "x5*x1*x3^2 + x6*x2*x4^2 = 3",
        "x5*x1^2*x3 + x6*x2^2*x4 = 2",
    )
    source = (
        "Verschelde, Verlinden & Cools 1994; a binary cubic is the sum of two cubes in one way, "
        "of either "
        "sign and order: 2 times 2 times 2 (Sylvester 1851; t^2 - 14 t + 8 has 2 real roots)"
    )
    return IntervalSystem("neurophysiology", _numbered(6), -100.0, 100.0, rules, 8, source)


def economics(n: int = 8) -> IntervalSystem:
    names = _numbered(n)
    last = names[-1]
    rules = []
    for k in range(1, n):
        pairs = "".join(f" + x{i}*x{i + k}" for i in range(1, n - k))
        rules.append(f"(x{k}{pairs})*{last} = {k}")
    rules.append(" + ".join(names[:-1]) + " = -1")
    roots = {4: 2, 5: 4, 6: 4, 7: 8, 8: 8, 9: 16}[n]
    return IntervalSystem(
        f"economics {n}", names, -100.0, 100.0, tuple(rules), roots, "Morgan 1987; COPRIN"
    )


def kinematics() -> IntervalSystem:
    names = tuple(f"{letter}{i}" for letter in "sc" for i in range(1, 7))
    rules = (
        *(f"s{i}^2 + c{i}^2 = 1" for i in range(1, 7)),
        "s2*c5*s6 - s3*c5*s6 - s4*c5*s6 + c2*c6 + c3*c6 + c4*c6 = 0.4077",
        "c1*c2*s5 + c1*c3*s5 + c1*c4*s5 + s1*c5 = 1.9115",
        "s2*s5 + s3*s5 + s4*s5 = 1.9791",
        "3*c1*c2 + 2*c1*c3 + c1*c4 = 4.0616",
        "3*s1*c2 + 2*s1*c3 + s1*c4 = 1.7172",
        "3*s2 + 2*s3 + s4 = 3.9701",
    )
    source = "van Hentenryck, McAllester & Kapur 1997: 16 real roots"
    return IntervalSystem("kinematics 1", names, -1.0, 1.0, rules, 16, source)


HARD = (
    broyden_banded(20),
    more_cosnard(12),
    brown_almost_linear(6),
    brown_almost_linear(7),
    yamamura(5),
    yamamura(8),
    caprasse(),
    neurophysiology(),
    economics(6),
    economics(8),
    kinematics(),
)
