"""Beams, bars, cables and soils."""

from __future__ import annotations

from math import atan, atan2, cos, cosh, degrees, exp, hypot, pi, radians, sin, sinh, sqrt, tan

import numpy as np
from scipy.optimize import brentq

from .corpus import OWN, sheet


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-14))


def sind(angle):
    return sin(radians(angle))


def cosd(angle):
    return cos(radians(angle))


def tand(angle):
    return tan(radians(angle))


@sheet(OWN, "defl > h, sigma > L, sigma defl > b h, defl > L, V sigma > w h")
def simple_beam(L, w, b, h, E):
    inertia, M = b * h**3 / 12, w * L**2 / 8
    return {
        "I": inertia,
        "M": M,
        "V": w * L / 2,
        "sigma": 6 * M / (b * h**2),
        "defl": 5 * w * L**4 / (384 * E * inertia),
    }


@sheet(OWN, "RA > a, M > P, M > a, RA RB > P a", {"M > a": ({"a": 5.0},)})
def point_load(L, P, a):
    RB = P * a / L
    return {"b": L - a, "RB": RB, "RA": P - RB, "M": (P - RB) * a}


@sheet(OWN, "defl > h, M > L, defl > L, sigma > w")
def cantilever(L, P, w, E, b, h):
    M, inertia = P * L + w * L**2 / 2, b * h**3 / 12
    defl = L**3 / (E * inertia) * (P / 3 + w * L / 8)
    return {"M": M, "I": inertia, "defl": defl, "sigma": 6 * M / (b * h**2) / 1000}


@sheet("Gere, standard case", "Mx > L, MA > w, R Mx > w L")
def propped_cantilever(L, w, EI):
    return {"R": 3 * w * L / 8, "MA": w * L**2 / 8, "x": 3 * L / 8, "Mx": 9 * w * L**2 / 128}


@sheet(OWN, "T > P, FL > P, RL > a, T > b, FL FR > a b")
def plane_truss(P, a, b):
    FL, FR = P * cosd(b) / sind(a + b), P * cosd(a) / sind(a + b)
    return {"FL": FL, "FR": FR, "T": FL * cosd(a), "RL": FL * sind(a), "RR": FR * sind(b)}


@sheet(OWN, "T1 > W, T2 > t1, T1 T2 > t1 t2, T1 > t2")
def two_cables(W, t1, t2):
    return {"T1": W * cosd(t2) / sind(t1 + t2), "T2": W * cosd(t1) / sind(t1 + t2)}


@sheet(
    "integral tables: span 100, length 120",
    "sag > S, Tmax > w, H > L",
    a=(46.954152, 1e-7),
    sag=(29.234380, 1e-7),
)
def catenary(S, L, w):
    a = root(lambda a: 2 * a * sinh(L / (2 * a)) - S, 10, 1000)
    sag = a * (cosh(L / (2 * a)) - 1)
    return {"a": a, "sag": sag, "H": w * a, "Tmax": w * (a + sag)}


@sheet(OWN, "T > f, th > f, H > L, T H > f q")
def parabolic_cable(L, f, q):
    H = q * L**2 / (8 * f)
    T, n = hypot(H, q * L / 2), f / L
    return {
        "H": H,
        "T": T,
        "th": degrees(atan(q * L / (2 * H))),
        "S": L * (1 + 8 / 3 * n**2 - 32 / 5 * n**4),
    }


@sheet(OWN, "Mu > As, Mn > d, a Mn > As d, rho > b")
def rc_beam(b, d, As, fc, fy, phi):
    a = As * fy / (0.85 * fc * b)
    Mn = As * fy * (d - a / 2) / 1e6
    return {"a": a, "Mn": Mn, "Mu": phi * Mn, "rho": As / (b * d)}


@sheet(
    "Meyerhof's factors for 30 degrees",
    "Q > B, qa > phi, Q > D, Nq > phi",
    Nq=(18.401, 1e-4),
    Nc=(30.140, 1e-4),
)
def bearing_capacity(phi, c, gam, D, B, FS):
    Nq = exp(pi * tand(phi)) * tand(45 + phi / 2) ** 2
    Nc, Ng = (Nq - 1) / tand(phi), (Nq - 1) * tand(1.4 * phi)
    qu = c * Nc + gam * D * Nq + gam * B * Ng / 2
    return {"Nq": Nq, "Nc": Nc, "Ng": Ng, "qu": qu, "qa": qu / FS, "Q": qu / FS * B}


@sheet(OWN, "FSo > B, FSs > B, Ka > phi, FSo FSs > B t")
def retaining_wall(H, B, t, gs, gc, phi, mu):
    Ka = (1 - sind(phi)) / (1 + sind(phi))
    Pa = Ka * gs * H**2 / 2
    W1, W2, Mo = gc * t * H, gc * (B - t) * H / 2, Pa * H / 3
    Mr = W1 * (B - t / 2) + W2 * 2 / 3 * (B - t)
    return {
        "Ka": Ka,
        "Pa": Pa,
        "W1": W1,
        "W2": W2,
        "Mo": Mo,
        "Mr": Mr,
        "FSo": Mr / Mo,
        "FSs": mu * (W1 + W2) / Pa,
    }


@sheet("ASME VIII, UG-27", "t > p, V > D, sl > D, t > S, V t > D S")
def pressure_vessel(p, D, L, S, E, CA):
    t = p * D * 500 / (S * E - 0.6 * p) + CA
    return {"t": t, "V": pi * D**2 / 4 * L + pi * D**3 / 6, "sl": p * D * 250 / t}


@sheet(OWN, "s1 > sx, tmax > txy, s1 s2 > sx txy, th > txy")
def mohr_circle(sx, sy, txy):
    mean, R = (sx + sy) / 2, hypot((sx - sy) / 2, txy)
    s1, s2 = mean + R, mean - R
    angle = degrees(atan(2 * txy / (sx - sy))) / 2
    return {
        "savg": mean,
        "R": R,
        "s1": s1,
        "s2": s2,
        "th": angle,
        "tmax": R,
        "vm": sqrt(s1**2 - s1 * s2 + s2**2),
    }


@sheet(OWN, "ss > dT, sa > As, dL > dT, sa > Ea")
def composite_bar(As, Aa, Es, Ea, als, ala, dT, L):
    F = (ala - als) * dT / (1 / (As * Es) + 1 / (Aa * Ea)) * 1000
    return {"F": F, "ss": F / As, "sa": F / Aa, "dL": als * dT * L + F * L / (As * Es * 1000)}


@sheet(OWN, "smax > P, smax > e, smax > L, Pcr > r")
def eccentric_column(P, A, r, c, e, L, E):
    x = L * 1000 / (2 * r) * sqrt(P / (E * A))
    return {
        "smax": P * 1000 / A * (1 + e * c / r**2 / cos(x)),
        "Pcr": pi**2 * E * A * r**2 / (L * 1000) ** 2,
    }


@sheet(OWN, "tau > t, tau > h, phi > L, phi > b")
def torsion_tube(T, b, h, t, G, L):
    Am = (b - t) * (h - t)
    q = T * 1e6 / (2 * Am)
    phi = degrees(T * 1e6 * L * 2 * (b + h - 2 * t) / (4 * Am**2 * G * t))
    return {"Am": Am, "q": q, "tau": q / t, "phi": phi}


@sheet(OWN, "u1 > k1, R3 > k2, u1 u2 > F1 F2, u1 R3 > k1 k2")
def spring_network(k1, k2, k3, F1, F2):
    u1, u2 = np.linalg.solve([[k1 + k2, -k2], [-k2, k2 + k3]], [F1, F2])
    return {"u1": float(u1), "u2": float(u2), "R1": float(k1 * u1), "R3": float(k3 * u2)}


@sheet(OWN, "sway > Ic, sway > h, M V > h L, sway > Ib")
def portal_sway(H, h, L, E, Ic, Ib):
    k = Ib * h / (Ic * L)
    return {
        "k": k,
        "M": H * h / 2,
        "V": H * h / L,
        "sway": H * h**3 / (12 * E * Ic * 1e-2) * (2 + 1 / k) * 1000,
    }


@sheet(OWN, "R vm > sx txy, vm > txy, n > sx, thp > txy")
def plane_stress(sx, sy, txy, Sy):
    savg, R = (sx + sy) / 2, sqrt(((sx - sy) / 2) ** 2 + txy**2)
    s1, s2 = savg + R, savg - R
    vm = sqrt(s1**2 - s1 * s2 + s2**2)
    thp = degrees(atan2(2 * txy, sx - sy)) / 2
    return {"savg": savg, "R": R, "s1": s1, "s2": s2, "thp": thp, "vm": vm, "n": Sy / vm}


@sheet(OWN, "F1 > rise, SF > d, sig1 > W, F3 > span, Pcr F3 > d W")
def roof_truss(W, span, rise, d, E):
    Ls = sqrt((span / 2) ** 2 + rise**2)
    RA, A, second = W / 2, pi * d**2 / 4, pi * d**4 / 64
    F1 = -RA * Ls / rise
    F3 = RA * span / 2 / rise
    Pcr = pi**2 * E * 1000 * second / (Ls * 1000) ** 2 / 1000
    return {
        "al": degrees(atan(2 * rise / span)),
        "RA": RA,
        "F1": F1,
        "F2": F1,
        "F3": F3,
        "sig1": F1 * 1000 / A,
        "sig3": F3 * 1000 / A,
        "Ls": Ls,
        "I": second,
        "Pcr": Pcr,
        "SF": Pcr / -F1,
    }


@sheet(OWN, "SF > F, SF > h, sig > a, RA MB > F q")
def overhanging_beam(b, h, L, a, q, F, Sy):
    hog = F * a + q * a**2 / 2
    RA = q * L / 2 - hog / L
    Mf = RA**2 / (2 * q)
    sig = max(Mf, hog) * 1e6 / (b * h**2 / 6)
    return {
        "RA": RA,
        "RB": q * (L + a) + F - RA,
        "MB": -hog,
        "Mf": Mf,
        "Mmax": max(Mf, hog),
        "sig": sig,
        "SF": Sy / sig,
    }


@sheet(OWN, "ph > z, ph > zw, u sv > z zw, ph > Ka")
def soil_pressure(z, zw, g1, gs, Ka):
    dry, wet = min(z, zw), max(z - zw, 0)
    sv, u = g1 * dry + gs * wet, 9.81 * wet
    return {"sv": sv, "u": u, "se": sv - u, "ph": Ka * (sv - u) + u}


@sheet("Eurocode 8, type 1 with S = 1", "V > T, Se > ag", {"V > T": ({"T": 0.0525},)})
def response_spectrum(T, ag, W):
    Se = 2.5 * ag * 0.5 / T
    return {"Se": Se, "V": 0.85 * Se * W}


@sheet("Terzaghi, after Taylor", "U > t, S > cv, U > H")
def consolidation(H, cv, mv, dq, t):
    Sf, Tv = mv * dq * 2 * H, cv * t / H**2
    U = sqrt(4 * Tv / pi)
    if U > 0.6:
        U = 1 - 10 ** ((1.781 - Tv) / 0.933) / 100
    return {"Sf": Sf, "Tv": Tv, "U": U, "S": U * Sf}


@sheet(
    OWN,
    "up > h, FS > B",
)
def footing(B, h, cov, col, Df, PD, PL, M, gs, gc, phi, coh, fc, fy):
    P, Wt = PD + PL, B**2 * (gc * h + gs * (Df - h))
    e, mean, t = M / (P + Wt), (P + Wt) / B**2, tan(radians(phi))
    within = e <= B / 6
    Nq = exp(pi * t) * tan(radians(45 + phi / 2)) ** 2
    Nc, Ng, Bp = (Nq - 1) / t, 2 * (Nq + 1) * t, B - 2 * e
    qmax = mean * (1 + 6 * e / B) if within else 4 * (P + Wt) / (3 * B * Bp)
    qult = 1.3 * coh * Nc + gs * Df * Nq + 0.4 * gs * Bp * Ng
    qu, d = (1.2 * PD + 1.6 * PL) / B**2, h - cov
    bo, arm = 4 * (col + d), (B - col) / 2
    Vu, Vc = qu * (B**2 - (col + d) ** 2), 0.75 * 0.33 * sqrt(fc) * 1000 * bo * d
    Mu = qu * B * arm**2 / 2
    a = d - sqrt(d**2 - 2 * Mu / (0.9 * 0.85 * fc * B * 1000))
    return {
        "P": P,
        "Wt": Wt,
        "e": e,
        "qmax": qmax,
        "qmin": mean * (1 - 6 * e / B) if within else 0.0,
        "Nq": Nq,
        "Nc": Nc,
        "Ng": Ng,
        "Bp": Bp,
        "qult": qult,
        "FS": qult / qmax,
        "qu": qu,
        "d": d,
        "bo": bo,
        "Vu": Vu,
        "Vc": Vc,
        "up": Vu / Vc,
        "arm": arm,
        "Mu": Mu,
        "As": 0.85 * fc * B * 1e6 * a / fy,
        "a": a,
    }


@sheet(OWN, "F > Ls, SF > ang, beta h > width Ls, WLL > width, SF R H > m boom ang, H h > Ls ang")
def crane_sling(m, width, Ls, boom, ang, base, mc, xc):
    h = sqrt(Ls**2 - width**2 / 4)
    beta = degrees(atan2(width / 2, h))
    force, R = m * 9.81 / (2 * cos(radians(beta))) / 1000, boom * cos(radians(ang))
    Mo, Mr = m * 9.81 * (R - base) / 1000, mc * 9.81 * (base + xc) / 1000
    forces = {"F": force, "WLL": (1.4 if beta <= 45 else 2) * force}
    return {"h": h, "beta": beta, "R": R, "H": boom * sind(ang) - h, "Mo": Mo, "Mr": Mr} | {
        "SF": Mr / Mo,
        **forces,
    }


@sheet(OWN, "T > boom, gam > boom, T > load, T > mast, reach T > boom load")
def crane_boom(load, Wb, boom, ang, mast, back):
    reach, tip = boom * cosd(ang), boom * sind(ang)
    gam = degrees(atan((tip - mast) / (reach + back)))
    return {
        "gam": gam,
        "T": (load + Wb / 2) * cosd(ang) / sind(ang - gam),
        "reach": reach,
        "tip": tip,
    }
