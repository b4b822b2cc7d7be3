"""Heat and thermodynamics.

Incropera: Fundamentals of Heat and Mass Transfer, 6th ed.
Çengel: Heat and Mass Transfer; Thermodynamics.
"""

from __future__ import annotations

from math import cos, cosh, exp, log, log10, pi, sin, sqrt, tanh

from scipy.optimize import brentq

from .corpus import OWN, sheet

SIGMA = 5.67e-8


@sheet("Incropera, Example 1.1", "q > T1, flux > L", flux=2833, q=1700)
def plane_wall(L, k, T1, T2, W, H):
    flux = k * (T1 - T2) / L
    return {"A": W * H, "flux": flux, "q": flux * W * H}


@sheet("Incropera, Example 1.2", "q > Ts, qrad > Tsur, q > D", E=2270, q=998)
def steam_pipe(D, Ts, Tair, Tsur, h, eps):
    qconv = h * pi * D * (Ts - Tair)
    qrad = eps * pi * D * SIGMA * (Ts**4 - Tsur**4)
    return {"E": eps * SIGMA * Ts**4, "qconv": qconv, "qrad": qrad, "q": qconv + qrad}


@sheet("Çengel, Heat and Mass Transfer, Example 3-3", "Q > La, T1 > To, Q > W", Q=69.2, T1=14.2)
def double_glazing(W, H, Lg, kg, La, ka, hi, ho, Ti, To):
    A = W * H
    Rtot = (1 / hi + 2 * Lg / kg + La / ka + 1 / ho) / A
    Q = (Ti - To) / Rtot
    return {"A": A, "Rtot": Rtot, "Q": Q, "T1": Ti - Q / (hi * A)}


@sheet(
    "Incropera, Example 11.1", "L > Tho, L > mc, Tco L > mc hi", q=8524, Tco=40.2, LMTD=43.2, L=65.9
)
def oil_cooler(mh, cph, Thi, Tho, mc, cpc, Tci, D, hi, ho):
    q = mh * cph * (Thi - Tho)
    Tco = Tci + q / (mc * cpc)
    U = hi * ho / (hi + ho)
    dT1, dT2 = Thi - Tco, Tho - Tci
    LMTD = (dT1 - dT2) / log(dT1 / dT2)
    return {
        "q": q,
        "Tco": Tco,
        "U": U,
        "dT1": dT1,
        "dT2": dT2,
        "LMTD": LMTD,
        "L": q / (U * pi * D * LMTD),
    }


@sheet("Incropera, Example 3.9", "q > D, m > h", q=8.3)
def long_fin(D, k, h, Tb, Ta):
    P, Ac = pi * D, pi * D**2 / 4
    return {"P": P, "Ac": Ac, "m": sqrt(h * P / (k * Ac)), "q": sqrt(h * P * k * Ac) * (Tb - Ta)}


@sheet(OWN, "eta > t, Ttip > L, q > L")
def straight_fin(L, t, w, k, h, Tb, Ta):
    m = sqrt(2 * h / (k * t))
    eta = tanh(m * L) / (m * L)
    return {
        "m": m,
        "eta": eta,
        "Af": 2 * w * L,
        "q": eta * h * 2 * w * L * (Tb - Ta),
        "Ttip": Ta + (Tb - Ta) / cosh(m * L),
    }


@sheet("Incropera, Example 5.1", "D > tau, t > T", D=7.06e-4, t=5.2)
def thermocouple(rho, cp, k, h, tau, Ti, Tg, T):
    D = 6 * h * tau / (rho * cp)
    return {"D": D, "Bi": h * D / 6 / k, "t": tau * log((Ti - Tg) / (T - Tg))}


@sheet(
    "Çengel, Thermodynamics, Example 6-5", "eta > tH, QL > tL", eta=(0.672, 0.002), QL=(164, 0.003)
)
def carnot(tH, tL, QH):
    TH, TL = tH + 273, tL + 273
    return {"TH": TH, "TL": TL, "eta": 1 - TL / TH, "QL": QH * TL / TH, "Wnet": QH * (1 - TL / TH)}


@sheet(OWN, "eta > r, MEP > qin, T3 > r")
def otto_cycle(r, k, cv, R, P1, T1, qin):
    v1 = R * T1 / P1
    v2 = v1 / r
    T2 = T1 * r ** (k - 1)
    T3 = T2 + qin / cv
    P2 = P1 * r**k
    T4 = T3 * r ** (1 - k)
    qout = cv * (T4 - T1)
    wnet = qin - qout
    return {
        "v1": v1,
        "v2": v2,
        "T2": T2,
        "P2": P2,
        "T3": T3,
        "P3": P2 * T3 / T2,
        "T4": T4,
        "qout": qout,
        "wnet": wnet,
        "eta": wnet / qin,
        "MEP": wnet / (v1 - v2),
    }


@sheet("Çengel, Thermodynamics, Example 9-3", "eta > rc, T3 > r", eta=0.632)
def diesel_cycle(r, rc, k, T1):
    T2 = T1 * r ** (k - 1)
    return {
        "T2": T2,
        "T3": rc * T2,
        "T4": T1 * rc**k,
        "eta": 1 - (rc**k - 1) / (k * (rc - 1) * r ** (k - 1)),
    }


@sheet(OWN, "wnet > T3, eta > etaT, T2 T4 > etaC etaT")
def brayton(rp, k, cp, T1, T3, etaC, etaT):
    x = rp ** ((k - 1) / k)
    T2s, T4s = T1 * x, T3 / x
    T2, T4 = T1 + (T2s - T1) / etaC, T3 - etaT * (T3 - T4s)
    wC, wT, qin = cp * (T2 - T1), cp * (T3 - T4), cp * (T3 - T2)
    return {
        "T2s": T2s,
        "T2": T2,
        "T4s": T4s,
        "T4": T4,
        "wC": wC,
        "wT": wT,
        "wnet": wT - wC,
        "qin": qin,
        "eta": (wT - wC) / qin,
        "bwr": wC / wT,
    }


@sheet(OWN, "Tp > Tf, Tp > h, qin > Tr")
def furnace_radiation(Tf, Tr, h, eps):
    def out(T):
        return h * (T - Tr) + eps * SIGMA * (T**4 - Tr**4)

    Tp = brentq(lambda T: eps * SIGMA * (Tf**4 - T**4) - out(T), Tr, Tf, xtol=1e-12, rtol=1e-15)
    return {"Tp": Tp, "qin": out(Tp), "qout": out(Tp)}


@sheet(OWN, "T > mh, m T > mh mc")
def mixing_valve(mh, Th, mc, Tc, cp):
    return {"m": mh + mc, "T": (mh * Th + mc * Tc) / (mh + mc), "Q": mh * cp * (Th - Tc)}


@sheet(OWN, "Tho > UA, Tco > Thi, q > UA")
def effectiveness_ntu(Ch, Cc, UA, Thi, Tci):
    Cmin, Cmax = min(Ch, Cc), max(Ch, Cc)
    Cr, NTU = Cmin / Cmax, UA / Cmin
    x = exp(-NTU * (1 - Cr))
    eff = (1 - x) / (1 - Cr * x)
    q = eff * Cmin * (Thi - Tci)
    return {
        "Cmin": Cmin,
        "Cmax": Cmax,
        "Cr": Cr,
        "NTU": NTU,
        "eff": eff,
        "q": q,
        "Tho": Thi - q / Ch,
        "Tco": Tci + q / Cc,
    }


@sheet(OWN, "q > Ts, h > L")
def free_convection_plate(Ta, Ts, L, W, nu, a, k, g):
    beta = 1 / ((Ts + Ta) / 2 + 273.15)
    Ra = g * beta * (Ts - Ta) * L**3 / (nu * a)
    h = 0.59 * Ra**0.25 * k / L
    return {"beta": beta, "Ra": Ra, "Nu": 0.59 * Ra**0.25, "h": h, "q": h * W * L * (Ts - Ta)}


def _thin_insulation(r1, r2, k, h):
    """The other outer radius with the same resistance, inside the critical one."""

    def resistance(r):
        return log(r / r1) / k + 1 / (r * h)

    return float(
        brentq(lambda r: resistance(r) - resistance(r2), r1 / 5, k / h, xtol=1e-15, rtol=1e-14)
    )


@sheet(OWN, "q > Tp, q > r2", {"q > r2": ({"r2": _thin_insulation(0.005, 0.02, 0.12, 8)},)})
def insulated_pipe(r1, r2, k, h, Tp, Ta):
    R = log(r2 / r1) / (2 * pi * k) + 1 / (2 * pi * r2 * h)
    return {"rc": k / h, "R": R, "q": (Tp - Ta) / R}


@sheet("after Çengel, Heat and Mass Transfer, the nitrogen tanks of chapter 3", "day > t, m > r1")
def sphere_tank(r1, t, k, h, T1, Ta, hfg):
    r2 = r1 + t
    q = (Ta - T1) / ((1 / r1 - 1 / r2) / (4 * pi * k) + 1 / (h * 4 * pi * r2**2))
    return {"r2": r2, "q": q, "m": q / hfg, "day": q / hfg * 86400}


@sheet(
    "Magnus coefficients of Alduchov and Eskridge 1996",
    "Tdp > phi, h > T, w > P",
    Psat=(3.169, 0.003),
)
def moist_air(T, phi, P):
    Psat = 0.61094 * exp(17.625 * T / (T + 243.04))
    Pv = phi * Psat
    w, g = 0.622 * Pv / (P - Pv), log(Pv / 0.61094)
    return {
        "Psat": Psat,
        "Pv": Pv,
        "w": w,
        "Tdp": 243.04 * g / (17.625 - g),
        "h": 1.006 * T + w * (2501 + 1.86 * T),
    }


@sheet(OWN, "P > Tout, P > Tin, COP > Tout")
def heat_pump(UA, Tin, Tout, g):
    Q, COP = UA * (Tin - Tout), g * (Tin + 273.15) / (Tin - Tout)
    return {"Q": Q, "COP": COP, "P": Q / COP}


@sheet(OWN, "T2 > n, w > P2, v2 > T1")
def polytropic(P1, T1, P2, n, R):
    v1 = R * T1 / P1
    v2 = v1 * (P1 / P2) ** (1 / n)
    return {"v1": v1, "v2": v2, "T2": P2 * v2 / R, "w": (P2 * v2 - P1 * v1) / (1 - n)}


@sheet(
    "Antoine constants of water in mmHg and degC (1 to 100 degC)", "T > P, T > B", T=(100, 0.001)
)
def antoine_boiling(A, B, C, P):
    return {"T": B / (A - log10(P)) - C}


@sheet(OWN, "Tout > m, eta > Tin, Tout > Tin")
def solar_collector(G, Ac, ta, UL, FR, Tin, Ta, m, cp):
    Qu = Ac * FR * (G * ta - UL * (Tin - Ta))
    return {"Qu": Qu, "eta": Qu / (Ac * G), "Tout": Tin + Qu / (m * cp)}


@sheet(OWN, "q > UA, Tho > UA, Tco > Thi, e > UA, q > Tci")
def counterflow_ntu(mh, ch, mc, cc, Thi, Tci, UA):
    hot, cold = mh * ch, mc * cc
    left = exp(-UA / hot * (1 - hot / cold))
    e = (1 - left) / (1 - hot / cold * left)
    q = e * hot * (Thi - Tci)
    return {
        "Cr": hot / cold,
        "N": UA / hot,
        "e": e,
        "q": q,
        "Tho": Thi - q / hot,
        "Tco": Tci + q / cold,
    }


@sheet(
    OWN,
    "A > U, A > Thi, A > Tho, A > Tci, A > Tco, q > Tci, LMTD > Tho, LMTD > Tci, dT1 > Thi, mh > "
    "Tho,"
    " eps > Tci",
)
def water_exchanger(Thi, Tho, Tci, Tco, U, mc, cp):
    dT1, dT2, q = Thi - Tco, Tho - Tci, mc * cp * 1000 * (Tco - Tci)
    LMTD, mh = (dT1 - dT2) / log(dT1 / dT2), q / (cp * 1000 * (Thi - Tho))
    eps = q / (min(mc, mh) * cp * 1000 * (Thi - Tci))
    return {"dT1": dT1, "dT2": dT2, "LMTD": LMTD, "q": q, "mh": mh, "A": q / (U * LMTD), "eps": eps}


@sheet(
    "W. M. Rohsenow (1952), N. Zuber (1959)",
    "q > Ts, qmax > rv, ratio mb > rv Ts, qmax mb > Csf rv",
)
def pool_boiling(Ts, Tsat, D, mu, hfg, rl, rv, s, cp, Csf, Pr):
    dT = Ts - Tsat
    qs = mu * hfg * sqrt(9.81 * (rl - rv) / s) * (cp * dT / (Csf * hfg * Pr)) ** 3
    qmax = 0.149 * hfg * rv * (s * 9.81 * (rl - rv) / rv**2) ** 0.25
    q = qs * pi * D**2 / 4
    return {"dT": dT, "qs": qs, "q": q, "mb": q / hfg, "qmax": qmax, "ratio": qs / qmax}


@sheet(OWN, "t > h, tau > d, Bi t > d k, t > c")
def lumped(rho, c, d, h, k):
    tau = rho * c * d / 6 / h
    return {
        "Lc": d / 6,
        "Bi": h * d / 6 / k,
        "tau": tau,
        "theta": 0.01,
        "t": tau * log(100),
    }


@sheet(OWN, "Tf > Tw, Tf > mw, avail > mw, Tf need > Tw Ti")
def ice_mix(mi, Ti, mw, Tw, Lf):
    need, avail = mi * (2.1 * -Ti + Lf), mw * 4.19 * Tw
    return {
        "need": need,
        "avail": avail,
        "Tf": (avail - need) / (4.19 * (mw + mi)),
        "melted": mi,
    }


@sheet(OWN, "q > es, Ts > T1, q0 > e1, q > T1, Ts q > e2 es")
def shield(T1, T2, e1, e2, es):
    near, far = 1 / e1 + 1 / es - 1, 1 / es + 1 / e2 - 1
    across = 5.67e-8 * (T1**4 - T2**4)
    q = across / (near + far)
    return {
        "q0": across / (1 / e1 + 1 / e2 - 1),
        "q": q,
        "Ts": (T1**4 - q * near / 5.67e-8) ** 0.25,
    }


@sheet("Magnus' formula", "Td > RH, Td > T, e > RH, Td AH > T RH, AH > RH")
def dewpoint(T, RH, a, b):
    gam = log(RH / 100) + a * T / (b + T)
    e = 6.112 * exp(a * T / (b + T)) * RH / 100
    return {"gam": gam, "Td": b * gam / (a - gam), "e": e, "AH": 216.7 * e / (T + 273.15)}


@sheet(OWN, "T4 > rc, T5 > rp, T2 > r, eta > r, T3 > rp, T4 T3 > rc rp")
def dual_cycle(r, rp, rc, k, T1):
    T2 = T1 * r ** (k - 1)
    T3, T5 = rp * T2, T1 * rp * rc**k
    return {
        "T2": T2,
        "T3": T3,
        "T4": rc * T3,
        "T5": T5,
        "eta": 1 - (T5 - T1) / (T3 - T2 + k * T3 * (rc - 1)),
    }


@sheet(OWN, "t > T1, k > t1, t k > T t1, t > T0")
def cooling_coffee(T0, Ta, T1, t1, T):
    k = log((T0 - Ta) / (T1 - Ta)) / t1
    return {"k": k, "t": log((T0 - Ta) / (T - Ta)) / k}


@sheet(OWN, "q > Q, q > m")
def ice_to_steam(Q, m):
    return {"q": Q / m, "T": 0.0}


@sheet("Çengel, chapter 8", "h > m, Nu > m, Re h > m k")
def tube_regimes(m, D, mu, Pr, k):
    Re = 4 * m / (pi * D * mu)
    turbulent = 0.023 * max(Re, 10000) ** 0.8 * Pr**0.4
    share = min(max((Re - 2300) / 7700, 0), 1)
    Nu = 3.66 + share * (turbulent - 3.66)
    return {"Re": Re, "Nu": Nu, "h": Nu * k / D}


@sheet(OWN, "Twb > RH, W > RH, h > RH, Twb > P")
def wet_bulb(P, Tdb, RH):
    def saturated(T):
        return 0.61078 * exp(17.27 * T / (T + 237.3))

    def humid(pressure):
        return 0.622 * pressure / (P - pressure)

    def miss(T):
        rise = (2501 - 2.326 * T) * humid(saturated(T)) - 1.006 * (Tdb - T)
        return rise / (2501 + 1.86 * Tdb - 4.186 * T) - W

    Pw = RH * saturated(Tdb)
    W = humid(Pw)
    Twb = brentq(miss, 0, Tdb, xtol=1e-13)
    h = 1.006 * Tdb + W * (2501 + 1.86 * Tdb)
    return {"Pw": Pw, "W": W, "h": h, "Twb": Twb, "Wwb": humid(saturated(Twb))}


@sheet(OWN, "t > Tdone, t > alpha, zeta > h, t > Toven")
def roast(T0, Toven, Tdone, L, alpha, h, k):
    Bi = h * L / k
    zeta = brentq(lambda z: z * sin(z) - Bi * cos(z), 0, pi / 2, xtol=1e-15)
    C1 = 4 * sin(zeta) / (2 * zeta + sin(2 * zeta))
    Fo = -log((Tdone - Toven) / (T0 - Toven) / C1) / zeta**2
    return {"Bi": Bi, "zeta": zeta, "C1": C1, "Fo": Fo, "t": Fo * L**2 / alpha / 60}


@sheet(
    OWN,
    "eta > eps, m > r, T9 > etat, bwr eta > T8 eps",
)
def gas_turbine(T1, T3, T6, T8, r, k, cp, etac, etat, eps, Wnet):
    hotter = sqrt(r) ** ((k - 1) / k)
    T2s, T4s, T7s, T9s = T1 * hotter, T3 * hotter, T6 / hotter, T8 / hotter
    T2, T4 = T1 + (T2s - T1) / etac, T3 + (T4s - T3) / etac
    T7, T9 = T6 - etat * (T6 - T7s), T8 - etat * (T8 - T9s)
    T5 = T4 + eps * (T9 - T4)
    wc, wt = cp * (T2 - T1 + T4 - T3), cp * (T6 - T7 + T8 - T9)
    qin = cp * (T6 - T5 + T8 - T7)
    return {
        "rs": sqrt(r),
        "T2s": T2s,
        "T2": T2,
        "T4s": T4s,
        "T4": T4,
        "T5": T5,
        "T7s": T7s,
        "T7": T7,
        "T9s": T9s,
        "T9": T9,
        "wc": wc,
        "wt": wt,
        "qin": qin,
        "wnet": wt - wc,
        "bwr": wc / wt,
        "eta": (wt - wc) / qin,
        "m": Wnet / (wt - wc),
    }


@sheet(OWN, "T0 > t, Ts > h, z > k, th0 > alpha")
def transient_wall(L, k, alpha, h, Ti, Tinf, t):
    Bi, Fo = h * L / 1000 / k, alpha * t / (L / 1000) ** 2
    z = brentq(lambda z: z * sin(z) - Bi * cos(z), 0, pi / 2, xtol=1e-15)
    C1 = 4 * sin(z) / (2 * z + sin(2 * z))
    th0 = C1 * exp(-(z**2) * Fo)
    T0, Ts = (Tinf + share * (Ti - Tinf) for share in (th0, th0 * cos(z)))
    return {"Bi": Bi, "Fo": Fo, "z": z, "C1": C1, "th0": th0, "T0": T0, "Ts": Ts}


@sheet(OWN, "SHR > BF, cond > t1, Qc > rh1, w2 > BF, Qr > ts, Qc w2 > V BF")
def cooling_coil(t1, rh1, tadp, BF, V, ts, p):
    def humidity(t, rh):
        pw = rh * 0.61094 * exp(17.625 * t / (t + 243.04))
        return pw, 0.622 * pw / (p - pw)

    def enthalpy(t, w):
        return 1.006 * t + w * (2501 + 1.86 * t)

    (pw1, w1), (pwa, wa) = humidity(t1, rh1 / 100), humidity(tadp, 1)
    t2, w2 = (end + BF * (start - end) for start, end in ((t1, tadp), (w1, wa)))
    v1 = 0.287 * (t1 + 273.15) * (1 + 1.608 * w1) / p
    ma = V / v1
    Qc = ma * (enthalpy(t1, w1) - enthalpy(t2, w2) - (w1 - w2) * 4.19 * t2)
    return {
        "pws1": 100 * pw1 / rh1,
        "pw1": pw1,
        "w1": w1,
        "pwa": pwa,
        "wa": wa,
        "t2": t2,
        "w2": w2,
        "h1": enthalpy(t1, w1),
        "h2": enthalpy(t2, w2),
        "v1": v1,
        "ma": ma,
        "Qc": Qc,
        "cond": 3600 * ma * (w1 - w2),
        "Qr": ma * (1.006 + 1.86 * w2) * (ts - t2),
        "SHR": ma * (1.006 + 1.86 * w1) * (t1 - t2) / Qc,
    }
