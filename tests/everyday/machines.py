"""Machine elements and the mechanics behind them.

Shigley: Mechanical Engineering Design, 9th ed.; Norton: Design of Machinery.
"""

from __future__ import annotations

from math import acos, asin, atan2, cos, degrees, exp, hypot, log, pi, radians, sin, sqrt, tan

from scipy.optimize import brentq

from .corpus import OWN, sheet


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-14))


@sheet(
    "Shigley, Example 10-1", "F > d, k > D, k F > Na d, y > Na", k=4.13, F=6.46, KB=1.124, C=10.8
)
def compression_spring(d, D, Na, G, Ssy):
    C = D / d
    KB = (4 * C + 2) / (4 * C - 3)
    F, k = pi * d**3 * Ssy / (8 * KB * D), d**4 * G / (8 * D**3 * Na)
    return {"C": C, "KB": KB, "k": k, "F": F, "y": F / k}


@sheet(
    "Shigley, Example 8-1",
    "TR > f, e > p, TL > F, TR TL > f fc",
    TR=(26.18, 1e-3),
    TL=(9.77, 1e-3),
    e=0.311,
)
def power_screw(d, p, n, f, fc, dc, F):
    dm, lead = d - p / 2, n * p
    TR = F * dm / 2 * (lead + pi * f * dm) / (pi * dm - f * lead) + F * fc * dc / 2
    TL = F * dm / 2 * (pi * f * dm - lead) / (pi * dm + f * lead) + F * fc * dc / 2
    return {"dm": dm, "l": lead, "TR": TR, "TL": TL, "e": F * lead / (2 * pi * TR)}


@sheet(OWN, "Lh > C, Lh > Fa, Lh > n")
def bearing_life(Fr, Fa, X, Y, n, C):
    P = X * Fr + Y * Fa
    return {"P": P, "L10": (C / P) ** 3, "Lh": 1e6 * (C / P) ** 3 / (60 * n)}


@sheet(OWN, "d > nf, tau > T, d > M")
def shaft_combined(M, T, Sy, nf):
    d = (nf / Sy * 16000 / pi * sqrt(4 * M**2 + 3 * T**2)) ** (1 / 3)
    sigma, tau = 32000 * M / (pi * d**3), 16000 * T / (pi * d**3)
    return {"d": d, "sigma": sigma, "tau": tau, "vm": hypot(sigma, sqrt(3) * tau)}


@sheet(OWN, "tau > do, phi > di, phi tau > do di, tau > di")
def shaft_power(P, N, do, di, G, L):
    w = 2 * pi * N / 60
    T, J = 1000 * P / w, pi * (do**4 - di**4) / 32
    return {"w": w, "T": T, "J": J, "tau": 500 * T * do / J, "phi": degrees(1000 * T * L / (G * J))}


@sheet("formulas of Shigley, chapter 4", "P > d, P > L, sr > L")
def column_euler_johnson(L, d, E, Sy, C):
    A, k = pi * d**2 / 4, d / 4
    sr, sr1 = 1000 * L / k, sqrt(2 * pi**2 * C * E * 1000 / Sy)
    euler, johnson = C * pi**2 * E * 1000 / sr**2, Sy - (Sy * sr / (2 * pi)) ** 2 / (C * E * 1000)
    return {"A": A, "k": k, "sr": sr, "sr1": sr1, "P": A * (euler if sr > sr1 else johnson) / 1000}


@sheet(OWN, "np > At, n0 > N, Fb > km, n0 > kb")
def bolted_joint(F, N, At, Sp, kb, km):
    Fi, C, P = 0.75 * At * Sp / 1000, kb / (kb + km), F / N
    Fb, Fm = C * P + Fi, (1 - C) * P - Fi
    return {
        "Fi": Fi,
        "C": C,
        "P": P,
        "Fb": Fb,
        "Fm": Fm,
        "np": Sp * At / 1000 / Fb,
        "n0": Fi / (P - C * P),
    }


@sheet(OWN, "p > do, T > delta, sigma > do, T > L")
def press_fit(d, do, E, delta, L, f):
    p = E * 1000 * delta / (2 * d) * (1 - (d / do) ** 2)
    Fax = f * p * pi * d * L / 1000
    return {"p": p, "Fax": Fax, "T": Fax * d / 2, "sigma": p * (do**2 + d**2) / (do**2 - d**2)}


@sheet(OWN, "wrap > D, C > Lb, P > mu, F2 > D")
def belt_drive(d, D, Lb, mu, F1, n):
    half = (Lb - pi * (D + d) / 2) / 2
    C = (half + sqrt(half**2 - (D - d) ** 2 / 2)) / 2
    alpha, v = degrees(asin((D - d) / (2 * C))), pi * d * n / 60000
    wrap = 180 - 2 * alpha
    F2 = F1 * exp(-mu * radians(wrap))
    return {"C": C, "alpha": alpha, "wrap": wrap, "F2": F2, "v": v, "P": (F1 - F2) * v / 1000}


def four_bar_angles(a, b, c, d, th2, branch):
    """Coupler and rocker, from the triangle that the diagonal cuts off."""
    x, y = d - a * cos(radians(th2)), -a * sin(radians(th2))
    diagonal, direction = hypot(x, y), atan2(y, x)
    inner = acos((b**2 + diagonal**2 - c**2) / (2 * b * diagonal))
    th3 = direction + branch * inner
    return degrees(th3), degrees(atan2(b * sin(th3) - y, b * cos(th3) - x))


def crossed(*lengths):
    return dict(zip(("th3", "th4"), four_bar_angles(*lengths, -1), strict=True))


@sheet(
    "Norton, Example 4-1",
    "th4 > th2, th3 > b, th3 th4 > b c",
    {
        "forward": (crossed(40, 120, 80, 100, 40),),
        "th4 > th2": ({"th4": four_bar_angles(40, 120, 80, 100, 40, 1)[1]},),
    },
    th3=(20.298, 1e-4),
    th4=(57.325, 1e-4),
)
def four_bar(a, b, c, d, th2):
    th3, th4 = four_bar_angles(a, b, c, d, th2, 1)
    return {"th3": th3, "th4": th4}


def arm(l1, l2, x, y, bend):
    q2 = bend * acos((x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2))
    q1 = atan2(y, x) - atan2(l2 * sin(q2), l1 + l2 * cos(q2))
    return {"q1": degrees(q1), "q2": degrees(q2)}


@sheet(
    "law of cosines",
    "q2 > l2, q1 > x, q1 q2 > x y, q1 > y",
    {"forward": (arm(400, 300, 450, 350, -1),)},
)
def two_link_arm(l1, l2, x, y):
    return arm(l1, l2, x, y, 1)


@sheet(OWN, "wc > Ns, wp > ws, ratio > Ns")
def planetary(Ns, Nr, ws, wr):
    Np = (Nr - Ns) / 2
    wc = (ws * Ns + wr * Nr) / (Ns + Nr)
    return {"Np": Np, "wc": wc, "wp": wc - (ws - wc) * Ns / Np, "ratio": ws / wc}


@sheet(OWN, "C > m, Fr > P, C n2 > N1 i, F > phi")
def spur_gears(m, N1, i, P, n1, phi):
    T1 = P * 1000 * 60 / (2 * pi * n1)
    Ft = 2000 * T1 / (m * N1)
    Fr = Ft * tan(radians(phi))
    return {
        "N2": i * N1,
        "C": m * N1 * (1 + i) / 2,
        "n2": n1 / i,
        "T1": T1,
        "Ft": Ft,
        "Fr": Fr,
        "F": hypot(Ft, Fr),
    }


@sheet(
    OWN,
    "T > D, F > D, T F > D pa, T > d",
    {
        "T > d": ({"d": root(lambda d: d * (250**2 - d**2) - 150 * (250**2 - 150**2), 100, 144)},),
    },
)
def disc_clutch(D, d, f, pa, N):
    F = pi * pa * d * (D - d) / 2
    return {"F": F, "T": N * f * F * (D + d) / 4000}


@sheet(OWN, "T > phi, pa T > P1 f, P2 > f")
def band_brake(P1, f, phi, D, b):
    P2 = P1 * exp(-f * radians(phi))
    return {"P2": P2, "T": (P1 - P2) * D / 2, "pa": 2 * P1 / (b * D)}


@sheet(OWN, "extra > D, extra > n, I > Cs")
def flywheel(E, n, Cs, rho, D, t):
    w = 2 * pi * n / 60
    inertia, disc = E / (Cs * w**2), rho * pi * D**4 * t / 32
    return {"w": w, "I": inertia, "Id": disc, "extra": inertia - disc}


@sheet(OWN, "p0 > F, a > R, delta > E, p0 delta > F R")
def hertz_spheres(F, R, E, nu):
    Es = E * 1000 / (2 * (1 - nu**2))
    a = (3 * F * R / (4 * Es)) ** (1 / 3)
    return {"Es": Es, "a": a, "p0": 3 * F / (2 * pi * a**2), "delta": a**2 / R}


def flight(v0, th, h, g, late=1):
    return (v0 * sin(radians(th)) + late * sqrt((v0 * sin(radians(th))) ** 2 - 2 * g * h)) / g


def other_shot():
    x = 40 * cos(radians(50)) * flight(40, 50, 12, 9.81)
    k = 9.81 * x / (2 * 40**2)
    slopes = [(1 + s * sqrt(1 - 4 * k * (12 / x + k))) / (2 * k) for s in (1, -1)]
    return min((degrees(atan2(t, 1)) for t in slopes), key=lambda th: -abs(th - 50))


UP = {"t": flight(40, 50, 12, 9.81, -1)}


@sheet(
    OWN,
    "x > th, x > v0, ymax > th, x > h",
    {
        "forward": (UP,),
        "x > th": ({"th": other_shot()},),
        "ymax > th": (UP,),
    },
)
def projectile(v0, th, h, g):
    t = flight(v0, th, h, g)
    up = v0 * sin(radians(th))
    return {"t": t, "x": v0 * cos(radians(th)) * t, "ymax": up**2 / (2 * g), "vy": up - g * t}


@sheet(OWN, "T > ha, vp > hp, e > ha, vp e > hp ha, va > hp")
def two_body_orbit(mu, Re, hp, ha):
    rp, ra = Re + hp, Re + ha
    a = (rp + ra) / 2
    vp = sqrt(mu * (2 / rp - 1 / a))
    return {
        "rp": rp,
        "ra": ra,
        "a": a,
        "e": (ra - rp) / (ra + rp),
        "vp": vp,
        "va": vp * rp / ra,
        "T": 2 * pi * sqrt(a**3 / mu) / 60,
    }


@sheet(
    "mu of the earth, geostationary radius; burns as NASA tabulates them",
    "dv1 > r1, v2 > mu, dv1 > r2",
    dv1=(2.4546, 1e-4),
    dv2=(1.4773, 1e-3),
)
def hohmann(mu, r1, r2):
    v1, v2 = sqrt(mu / r1), sqrt(mu / r2)
    dv1 = v1 * (sqrt(2 * r2 / (r1 + r2)) - 1)
    dv2 = v2 * (1 - sqrt(2 * r1 / (r1 + r2)))
    return {"v1": v1, "v2": v2, "dv1": dv1, "dv2": dv2, "dv": dv1 + dv2}


@sheet("NASA Glenn, ideal rocket equation", "dv > mf, dv > ve, mp dv > mf m0", dv=(4828.3, 1e-5))
def rocket(ve, m0, mf):
    return {"mp": m0 - mf, "dv": ve * log(m0 / mf)}


@sheet(OWN, "X > c, wn > k, TR > w, phi > c")
def vibration(m, k, c, F0, w):
    wn, zeta = sqrt(k / m), c / (2 * sqrt(k * m))
    r = w / wn
    size = hypot(1 - r**2, 2 * zeta * r)
    return {
        "wn": wn,
        "zeta": zeta,
        "r": r,
        "X": F0 / k / size,
        "phi": degrees(atan2(2 * zeta * r, 1 - r**2)),
        "TR": hypot(1, 2 * zeta * r) / size,
    }


@sheet(OWN, "a > mu, T > m2, t > m1, v > th, t v > s mu")
def incline_block(m1, m2, th, mu, g, s):
    N = m1 * g * cos(radians(th))
    a = (m2 * g - m1 * g * sin(radians(th)) - mu * N) / (m1 + m2)
    return {"N": N, "a": a, "T": m2 * (g - a), "v": sqrt(2 * a * s), "t": sqrt(2 * s / a)}


@sheet(OWN, "swing > a, swing > c, p2 > d, Q > a, p1 p2 > a b")
def rocker_dead_centres(a, b, c, d):
    ends = b - a, b + a
    c1, c2 = ((c**2 + d**2 - far**2) / (2 * c * d) for far in ends)
    g1, g2 = (degrees(acos((d**2 + far**2 - c**2) / (2 * d * far))) for far in ends)
    p1, p2 = degrees(acos(c1)), degrees(acos(c2))
    lag = abs(g1 - g2)
    found = {"c1": c1, "c2": c2, "p1": p1, "p2": p2, "g1": g1, "g2": g2}
    return {**found, "swing": p2 - p1, "Q": (180 + lag) / (180 - lag)}


@sheet(OWN, "w3 > w2, w4 > w2, mu > d, th4 > d, K3 > d, th4 > a")
def freudenstein(a, b, c, d, th2, w2):
    th3, th4 = four_bar_angles(a, b, c, d, th2, 1)
    t2, t3, t4 = map(radians, (th2, th3, th4))
    return {
        "K1": d / a,
        "K2": d / c,
        "K3": (a**2 - b**2 + c**2 + d**2) / (2 * a * c),
        "th3": th3,
        "th4": th4,
        "w4": a * w2 * sin(t2 - t3) / (c * sin(t4 - t3)),
        "w3": a * w2 * sin(t4 - t2) / (b * sin(t3 - t4)),
        "mu": abs(th4 - th3),
    }


@sheet(OWN, "t y > x al")
def throw(v, al, x):
    across, up = v * cos(radians(al)), v * sin(radians(al))
    t = x / across
    return {"t": t, "y": up * t - 9.81 * t**2 / 2}


@sheet(OWN, "a > M, a > m1, T1 T2 > m1 m2, alpha > R, T1 > g")
def atwood(m1, m2, M, R, g):
    a = (m1 - m2) * g / (m1 + m2 + M / 2)
    return {"a": a, "T1": m1 * (g - a), "T2": m2 * (g + a), "I": M * R**2 / 2, "alpha": a / R}


@sheet(OWN, "mu > x, NB > theta, mu NA > P x, FA > W")
def ladder(L, W, P, x, theta):
    force = (W / 2 + P * x / L) / tan(radians(theta))
    return {"NA": W + P, "FA": force, "NB": force, "mu": force / (W + P)}


@sheet(OWN, "theta > T, v > T, F > m, F v > T m, r > g, F > L")
def conical_pendulum(L, T, g, m):
    w = 2 * pi / T
    theta = acos(g / (w**2 * L))
    r = L * sin(theta)
    return {"omega": w, "theta": degrees(theta), "r": r, "v": w * r, "F": m * w**2 * L}


@sheet(OWN, "phi > v, h > m, V > v, phi > L, phi V > v L")
def ballistic_pendulum(m, M, L, v):
    V = m * v / (m + M)
    return {"V": V, "h": V**2 / 19.62, "phi": degrees(acos(1 - V**2 / 19.62 / L))}


@sheet(OWN, "T2 > mu, T2 > n, M > T1, T2 M > mu d, beta > n")
def capstan(T1, n, mu, d):
    T2 = T1 * exp(mu * 2 * pi * n)
    return {"beta": 2 * pi * n, "T2": T2, "M": (T2 - T1) * d / 2}


@sheet(OWN, "bank > v, vmax > mu, vmin vmax > v mu, vmax > r")
def banked_curve(r, v, g, mu):
    slope = (v / 3.6) ** 2 / (r * g)
    fast, slow = ((slope + sign * mu) / (1 - sign * mu * slope) for sign in (1, -1))
    return {
        "bank": degrees(atan2(slope, 1)),
        "vmax": sqrt(r * g * fast),
        "vmin": sqrt(r * g * slow),
    }


@sheet(OWN, "zeta > x2, zeta wn > n Td, wn > Td, delta > x1")
def damped(x1, x2, n, Td):
    delta = log(x1 / x2) / n
    zeta = delta / hypot(2 * pi, delta)
    wd = 2 * pi / Td
    return {"delta": delta, "zeta": zeta, "wd": wd, "wn": wd / sqrt(1 - zeta**2)}


@sheet(OWN, "N > h, vtop > R, N vtop > m h")
def loop(R, h, g, m):
    square = 2 * g * (h - 2 * R)
    return {"vtop": sqrt(square), "N": m * square / R - m * g, "ok": 1.0}


@sheet(OWN, "v > t, s > t, s > T, v s > t T", {"v > t": ({"t": 0.3},)})
def trapezoid_move(t, a, vm, T):
    ta = vm / a
    v = min(a * t, vm, a * (T - t))
    braking = max(t - (T - ta), 0)
    s = a * min(t, ta) ** 2 / 2 + vm * max(t - ta, 0) - a * braking**2 / 2
    return {"ta": ta, "v": v, "s": s}


@sheet(OWN, "Tm > n, Ta > n, TL > n", {"Tm > n": ({},), "Ta > n": ({},)})
def motor_limits(n):
    w = 2 * pi * n / 60
    Tm, TL = min(120, 18000 / w, 60 + 0.05 * n), 6e-6 * n**2 + 5
    return {"w": w, "Tm": Tm, "TL": TL, "Ta": Tm - TL}


@sheet(OWN, "L > C, links > N2, V > p, beta > C")
def roller_chain(N1, N2, p, n1, C):
    L = 2 * C + p * (N1 + N2) / 2 + p**2 * (N2 - N1) ** 2 / (4 * pi**2 * C)
    beta = 2 * degrees(asin((N2 - N1) * p / (2 * pi * C)))
    return {"L": L, "links": L / p, "V": N1 * p * n1 / 12, "beta": beta}


@sheet(OWN, "ta > D")
def spring_fatigue(d, D, Na, G, Asp, mexp, Fmin, Fmax, ends, clash, rho):
    C, k = D / d, G * d**4 / (8 * D**3 * Na)
    Kw, Ks, Sut = (4 * C - 1) / (4 * C - 4) + 0.615 / C, 1 + 0.5 / C, Asp / d**mexp
    Ssu, Fa, Fm, Nt = 0.67 * Sut, (Fmax - Fmin) / 2, (Fmax + Fmin) / 2, Na + ends
    Sse, area = 310 / (1 - (379 / Ssu) ** 2), pi * d**3
    ysol = (1 + clash) * Fmax / k
    ta, tm, tsol = (8 * K * F * D / area for K, F in ((Kw, Fa), (Ks, Fm), (Ks, k * ysol)))
    coil = rho * 1e-9 * pi * d**2 / 4 * pi * D
    return {
        "C": C,
        "Kw": Kw,
        "Ks": Ks,
        "k": k,
        "Sut": Sut,
        "Ssy": 0.45 * Sut,
        "Ssu": Ssu,
        "Sse": Sse,
        "Nt": Nt,
        "Ls": Nt * d,
        "ymax": Fmax / k,
        "ysol": ysol,
        "Lf": Nt * d + ysol,
        "Fsol": k * ysol,
        "tsol": tsol,
        "nsol": 0.45 * Sut / tsol,
        "Fa": Fa,
        "Fm": Fm,
        "ta": ta,
        "tm": tm,
        "nf": 1 / (ta / Sse + tm / Ssu),
        "Lcr": 2.63 * D / 0.707,
        "slender": (Nt * d + ysol) / D,
        "mass": coil * Nt,
        "fn": 0.5 * sqrt(1000 * k / (coil * Na)),
    }
