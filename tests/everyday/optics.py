"""Lenses, mirrors, gratings, fibres and light."""

from __future__ import annotations

from math import asin, atan, cos, degrees, hypot, pi, radians, sin, sqrt, tan

from scipy.optimize import brentq

from .corpus import OWN, sheet


def sind(angle):
    return sin(radians(angle))


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-14))


@sheet(OWN, "di > f, m > do, hi > f, hi di > f ho, m di > do f")
def thin_lens(f, do, ho):
    di = f * do / (do - f)
    return {"di": di, "m": -di / do, "hi": -ho * di / do}


@sheet(OWN, "s2i > d, M > s1, s2i > f2, M s2i > s1 d, s2i > f1")
def two_lenses(f1, f2, d, s1):
    s1i = f1 * s1 / (s1 - f1)
    s2 = d - s1i
    s2i = f2 * s2 / (s2 - f2)
    return {"s1i": s1i, "s2": s2, "s2i": s2i, "M": s1i * s2i / (s1 * s2)}


@sheet(OWN, "f > R1, bfd > d, f > n, D > R2, f bfd > n d")
def lensmaker(n, R1, R2, d):
    f = 1 / ((n - 1) * (1 / R1 - 1 / R2 + (n - 1) * d / (n * R1 * R2)))
    return {"f": f, "bfd": f * (1 - (n - 1) * d / (n * R1)), "D": 1000 / f}


@sheet(OWN, "dx > a, b > n2, dx > t, dx tc > a n2, tc > n2")
def snell(n1, n2, t, a):
    b = degrees(asin(n1 * sind(a) / n2))
    return {"b": b, "dx": t * sind(a - b) / cos(radians(b)), "tc": degrees(asin(n1 / n2))}


def prism_deviation(i1, n=1.62, A=60.0):
    r2 = A - degrees(asin(sind(i1) / n))
    return i1 + degrees(asin(n * sind(r2))) - A


@sheet(
    OWN,
    "dev > i1, dmin > n, i2 > A, dev dmin > i1 n",
    {
        "dev > i1": ({"i1": root(lambda i: prism_deviation(i) - prism_deviation(50), 54.2, 89)},),
        "dev dmin > i1 n": (
            {"i1": root(lambda i: prism_deviation(i) - prism_deviation(50), 54.2, 89)},
        ),
    },
)
def prism(A, n, i1):
    r1 = degrees(asin(sind(i1) / n))
    i2 = degrees(asin(n * sind(A - r1)))
    return {
        "r1": r1,
        "r2": A - r1,
        "i2": i2,
        "dev": i1 + i2 - A,
        "dmin": 2 * degrees(asin(n * sind(A / 2))) - A,
    }


@sheet(OWN, "m > do, di > R, f di > R do, m > R")
def mirror(R, do):
    di = R / 2 * do / (do - R / 2)
    return {"f": R / 2, "di": di, "m": -di / do}


@sheet(OWN, "th > lam, y > lam, y > N, th y > N L")
def grating(N, lam, k, L):
    th = asin(k * lam * N * 1e-6)
    return {"d": 1e6 / N, "th": degrees(th), "y": L * tan(th)}


@sheet(
    "constants of a standard single-mode fibre",
    "V > a, th > n2, lamc > a, NA > n1, V th > lam n2",
    tolerance=1e-7,
)
def fibre(n1, n2, a, lam):
    NA = sqrt(n1**2 - n2**2)
    return {
        "NA": NA,
        "th": degrees(asin(NA)),
        "V": 2 * pi * a * NA / lam,
        "lamc": 2 * pi * a * NA / 2.405,
    }


@sheet(OWN, "M > fe, L M > fo fe, exit > D, res > D, N > fo")
def telescope(fo, fe, D, lam):
    return {
        "M": fo / fe,
        "L": fo + fe,
        "exit": D * fe / fo,
        "res": degrees(1.22 * lam * 1e-6 / D) * 3600,
        "N": fo / D,
    }


@sheet(OWN, "dof > N, far > s, H > f, near > s, dof > s, near far > s N")
def depth_of_field(f, N, c, s):
    H = f**2 / (N * c) + f
    near, far = s * (H - f) / (H + s - 2 * f), s * (H - f) / (H - s)
    return {"H": H, "near": near, "far": far, "dof": far - near}


@sheet(OWN, "y > lam, dy > d, y > L, y dy > n lam")
def double_slit(d, L, lam, n):
    dy = lam * 1e-6 * L * 1000 / d
    return {"dy": dy, "y": n * dy}


@sheet(
    OWN,
    "w > z, R > w0, w > w0, th > lam, w R > w0 z",
    {
        "w > w0": ({"w0": 0.6328e-6 * 3 / pi / 0.5e-3 * 1e3},),
    },
)
def gaussian_beam(w0, lam, z):
    zR = pi * (w0 * 1e-3) ** 2 / (lam * 1e-9)
    return {
        "zR": zR,
        "w": w0 * hypot(1, z / zR),
        "R": z + zR**2 / z,
        "th": lam * 1e-9 / (pi * w0 * 1e-3) * 1000,
    }


@sheet("the two conditions of an achromat", "f1 > V1, f2 > f, f1 f2 > f V2, f1 > f")
def achromat(f, V1, V2):
    return {"D": 1000 / f, "f1": f * (V1 - V2) / V1, "f2": -f * (V1 - V2) / V2}


@sheet(
    OWN,
    "E > h, E > x, d th > h x, E > I, E th > h I",
    {
        "E > h": (
            {
                "h": root(
                    lambda h: h / (h * h + 1.44) ** 1.5 - 1.8 / (1.8**2 + 1.44) ** 1.5, 0.01, 0.8
                )
            },
        ),
    },
)
def illuminance(I, h, x):  # noqa: E741
    d = hypot(h, x)
    return {"d": d, "th": degrees(atan(x / h)), "E": I * h / d**3}


@sheet(OWN, "rs > t1, R > t1, dev > n2, dev rs > t1 n2")
def reflection(n1, n2, t1):
    t2 = degrees(asin(n1 * sind(t1) / n2))
    a, b = cos(radians(t1)), cos(radians(t2))
    rs, rp = (n1 * a - n2 * b) / (n1 * a + n2 * b), (n2 * a - n1 * b) / (n2 * a + n1 * b)
    R = (rs**2 + rp**2) / 2
    return {"t2": t2, "rs": rs, "rp": rp, "R": R, "T": 1 - R, "dev": t1 - t2}


@sheet(OWN, "lam2 > theta, K > theta, E2 > lam, K E1 > lam theta")
def compton(lam, theta):
    lam2 = lam + 0.002426 * (1 - cos(radians(theta)))
    E1, E2 = 1.2398 / lam, 1.2398 / lam2
    return {"lam2": lam2, "E1": E1, "E2": E2, "K": E1 - E2}


@sheet(OWN, "tb > n2, tc > n1")
def brewster(n1, n2):
    tb = atan(n2 / n1)
    return {"tb": degrees(tb), "tr": degrees(asin(n1 * sin(tb) / n2)), "tc": degrees(asin(n1 / n2))}
