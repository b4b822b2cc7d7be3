"""Doses, populations, sport and the household."""

from __future__ import annotations

from math import cos, exp, log, radians, sin, sqrt

from scipy.optimize import brentq

from .corpus import OWN, sheet


@sheet(OWN, "C > D, Cmax > F, tmax Cmax > ka V")
def oral_dose(F, D, V, ka, ke, t):
    return {
        "C": F * D * ka / (V * (ka - ke)) * (exp(-ke * t) - exp(-ka * t)),
        "tmax": log(ka / ke) / (ka - ke),
        "Cmax": F * D / V * (ke / ka) ** (ke / (ka - ke)),
    }


@sheet(OWN, "C > t, thalf > CL, C0 thalf > V CL, C AUC > CL t, C > D")
def one_compartment(D, V, CL, t):
    k = CL / V
    return {
        "k": k,
        "thalf": log(2) / k,
        "C0": D / V,
        "C": D / V * exp(-k * t),
        "AUC": D / CL,
    }


@sheet(OWN, "N1 > t, A2 > N0, N1 N2 > N0 l2, N1 > l1")
def decay_chain(N0, l1, l2, t):
    N2 = N0 * l1 / (l2 - l1) * (exp(-l1 * t) - exp(-l2 * t))
    return {"N1": N0 * exp(-l1 * t), "N2": N2, "A2": l2 * N2}


@sheet(OWN, "P > t, tinf > P0, P tinf > P0 r")
def logistic(K, r, P0, t):
    P = K / (1 + (K - P0) / P0 * exp(-r * t))
    return {"P": P, "tinf": log((K - P0) / P0) / r, "growth": r * P * (1 - P / K)}


@sheet("Kermack and McKendrick", "z > R0, herd > R0, cases herd > N R0")
def sir_final(R0, N):
    z = float(brentq(lambda z: 1 - exp(-R0 * z) - z, 0.1, 1, xtol=1e-15, rtol=1e-14))
    return {"z": z, "herd": 1 - 1 / R0, "cases": z * N}


@sheet(OWN, "bill > kwh, avg > fix, bill avg > kwh fix")
def electricity_bill(kwh, fix):
    bill = fix + 40 + 0.22 * (kwh - 300)
    return {"bill": bill, "avg": bill / kwh}


@sheet(OWN, "pace > t, t2 > D2, v t2 > t D2")
def marathon(D, t, D2):
    return {"v": D / t, "pace": 60 * t / D, "t2": 60 * t * (D2 / D) ** 1.06}


@sheet(OWN, "v0 t > d theta, t > h, v0 > d")
def basketball(d, h, theta):
    angle = radians(theta)
    t = sqrt(2 * (d * sin(angle) / cos(angle) - h) / 9.81)
    return {"t": t, "v0": d / (cos(angle) * t)}


@sheet(OWN, "E > dose, E > n, E C > V EC50")
def effect(dose, V, Emax, EC50, n):
    C = dose / V
    return {"C": C, "E": Emax / (1 + (EC50 / C) ** n)}


@sheet(OWN, "v > S", {"v > S": ({"S": (14 + sqrt(14**2 - 4 * 41)) / 2},)})
def substrate_inhibition(S):
    return {"v": 10 * S / (2 + S + max(S - 5, 0) ** 2 / 8)}


@sheet(OWN, "N > t, N > b, tinf > N0, dN N > b K")
def gompertz(N0, K, b, t):
    N = K * exp(log(N0 / K) * exp(-b * t))
    return {"N": N, "dN": b * N * log(K / N), "tinf": log(log(K / N0)) / b}


@sheet(OWN, "net > gross, tax > gross, taxable > allowance, ss > rate")
def salary(gross, rate, cap, allowance):
    ss = rate * min(gross, cap)
    taxable = max(0, gross - allowance - ss)
    slices = ((0, 0.1), (1000, 0.22), (4000, 0.35))
    ends = (1000, 4000, float("inf"))
    tax = sum(
        share * max(0, min(taxable, end) - start)
        for (start, share), end in zip(slices, ends, strict=True)
    )
    return {"ss": ss, "taxable": taxable, "tax": tax, "net": gross - ss - tax}


@sheet(OWN, "w > k1, w > kj, w > vf, q1 > k1, delay > k1, share > k1, w q1 > k1 vf")
def traffic(vf, kj, k1, k2, L):
    v1, v2 = vf * (1 - k1 / kj), vf * (1 - k2 / kj)
    return {
        "v1": v1,
        "q1": k1 * v1,
        "v2": v2,
        "q2": k2 * v2,
        "qmax": vf * kj / 4,
        "w": (k2 * v2 - k1 * v1) / (k2 - k1),
        "head": 3600 / (k1 * v1),
        "t": 60 * L / v1,
        "delay": 60 * L / v1 - 60 * L / vf,
        "share": k1 * v1 / (vf * kj / 4),
    }
