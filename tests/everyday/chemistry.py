"""Equilibria, reactors, separations and balances."""

from __future__ import annotations

from math import exp, log, log10, sqrt

from numpy import roots
from scipy.optimize import brentq, fsolve

from .corpus import OWN, sheet


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-18, rtol=1e-14))


@sheet(
    "OpenStax Chemistry 2e, chapter 14, formic acid (solved without the approximation)",
    "pH > C, alpha > C, pH > Ka",
    x=(9.71e-3, 1e-3),
)
def weak_acid(C, Ka):
    x = (-Ka + sqrt(Ka**2 + 4 * Ka * C)) / 2
    return {"x": x, "pH": -log10(x), "alpha": x / C}


@sheet(OWN, "pH1 > n, pH0 > cB, pH0 pH1 > cA cB, pH1 > V")
def buffer(pKa, cA, cB, V, n):
    return {"pH0": pKa + log10(cB / cA), "pH1": pKa + log10((cB * V + n) / (cA * V - n))}


@sheet(OWN, "c > V1, m > c2, c V > V1 V2, m > V2")
def dilution(c1, V1, c2, V2, M):
    V, n = V1 + V2, c1 * V1 + c2 * V2
    return {"V": V, "c": n / V, "m": n * M}


@sheet(OWN, "m > T, rho > P, M > yN, pN m > yN V")
def gas_mixture(V, T, P, yN, R):
    n, M = P * V / (R * (T + 273.15)), yN * 28.014 + (1 - yN) * 31.998
    return {"n": n, "pN": yN * P, "M": M, "m": n * M, "rho": n * M / V}


def dense_state():
    """The liquid-like state of the same pressure and compressibility, far below any real
    temperature."""
    a, b, R, V = 3.640, 0.04267, 0.083145, 0.5
    P = R * 320 / (V - b) - a / V**2
    Z = P * V / (R * 320)
    return {"V": root(lambda v: (P + a / v**2) * (v - b) - P * v / Z, b, 0.1)}


@sheet(
    "constants of carbon dioxide",
    "P > V, P > T, Z > T, P > n, Z P > V T",
    {
        "Z P > V T": (dense_state(),),
    },
)
def van_der_waals(n, T, V, a, b, R):
    P = n * R * T / (V - n * b) - a * n**2 / V**2
    return {"P": P, "Z": P * V / (n * R * T)}


@sheet(OWN, "Ea > T2, k > T, thalf > T, k > k2, A Ea > k1 k2")
def arrhenius(k1, T1, k2, T2, R, T):
    Ea = R * log(k2 / k1) / (1 / T1 - 1 / T2)
    A = k1 * exp(Ea / (R * T1))
    k = A * exp(-Ea / (R * T))
    return {"Ea": Ea, "A": A, "k": k, "thalf": log(2) / k}


@sheet(OWN, "x > t, b > k, a > b0, x > a0")
def second_order(a0, b0, k, t):
    e = exp((a0 - b0) * k * t)
    x = a0 * b0 * (e - 1) / (a0 * e - b0)
    return {"x": x, "a": a0 - x, "b": b0 - x}


@sheet(OWN, "E > cCu, dG > cZn, E > T")
def nernst(E0, n, T, cZn, cCu):
    E = E0 - 8.314 * T / (n * 96485) * log(cZn / cCu)
    return {"Q": cZn / cCu, "E": E, "dG": -n * 96485 * E / 1000}


@sheet(OWN, "mg > c, s > Ksp, mg > Ksp")
def solubility(Ksp, c):
    s = 2 * Ksp / (c + sqrt(c**2 + 4 * Ksp))
    return {"s": s, "mg": s * 143.32 * 1000}


@sheet(OWN, "M > P, a > Kp, yNO2 > P, M > Kp")
def n2o4(Kp, P):
    a = sqrt(Kp / (Kp + 4 * P))
    y = 2 * a / (1 + a)
    return {"a": a, "yNO2": y, "yN2O4": 1 - y, "M": y * 46.006 + (1 - y) * 92.011}


@sheet(OWN, "x > P, yA > P, yA > Kp, n > Kp", tolerance=1e-7)
def ammonia(Kp, P):
    def miss(x):
        return (2 * x) ** 2 * (4 - 2 * x) ** 2 - Kp * P**2 * (1 - x) * (3 - 3 * x) ** 3

    x = root(miss, 0, 1)
    n = 4 - 2 * x
    return {"x": x, "n": n, "yN": (1 - x) / n, "yH": (3 - 3 * x) / n, "yA": 2 * x / n}


@sheet(
    "Antoine constants of benzene and toluene", "T > x1, y1 > x1, y1 > P, T > P", T=(95.1, 0.002)
)
def raoult_bubble(P, x1):
    def pressures(T):
        return 10 ** (6.90565 - 1211.033 / (220.79 + T)), 10 ** (6.95464 - 1344.8 / (219.482 + T))

    T = root(lambda T: x1 * pressures(T)[0] + (1 - x1) * pressures(T)[1] - P, 50, 150)
    P1, P2 = pressures(T)
    return {"T": T, "P1": P1, "P2": P2, "y1": x1 * P1 / P, "y2": (1 - x1) * P2 / P}


@sheet(OWN, "V > z1, x1 > K1, L > K2, V x1 > z1 K2")
def flash(F, z1, K1, K2):
    x1 = (1 - K2) / (K1 - K2)
    V = F * (z1 - x1) / (K1 * x1 - x1)
    return {"V": V, "L": F - V, "x1": x1, "x2": 1 - x1, "y1": K1 * x1, "y2": K2 * (1 - x1)}


@sheet("after Fogler, the adiabatic stirred tank", "T > T0, X > q, T > V, X > J, k > k0")
def cstr(V, q, cA0, T0, k0, EaR, J):
    def concentration(T):
        return q * cA0 / (q + k0 * exp(-EaR / T) * V)

    T = root(lambda T: T0 + J * (cA0 - concentration(T)) - T, T0, T0 + J * cA0)
    cA = concentration(T)
    return {"T": T, "k": k0 * exp(-EaR / T), "cA": cA, "X": 1 - cA / cA0}


@sheet(OWN, "V > X, tau > cA0, cA > V, V > cA0")
def plug_flow(q, cA0, k, X):
    cA = cA0 * (1 - X)
    tau = (1 / cA - 1 / cA0) / k
    return {"cA": cA, "tau": tau, "V": tau * q}


@sheet("Fenske's equation", "N > xB, N > alpha, D > zF, N rec > xD xB")
def fenske(alpha, xD, xB, F, zF):
    D = F * (zF - xB) / (xD - xB)
    N = log(xD / (1 - xD) * (1 - xB) / xB) / log(alpha)
    return {"D": D, "B": F - D, "N": N, "rec": D * xD / (F * zF)}


@sheet(
    "heat of evaporation of water at its boiling point", "P2 > T2, P2 > H, P2 > T1", P2=(70.1, 0.01)
)
def clausius_clapeyron(P1, T1, H, T2):
    return {"P2": P1 * exp(-H * 1000 / 8.314 * (1 / T2 - 1 / T1))}


@sheet(OWN, "d > t, m > I, d > A, d m > A I")
def electrolysis(I, t, M, z, eta, A, rho):  # noqa: E741
    m = eta * I * t * 3600 * M / (z * 96485)
    return {"m": m, "d": m / rho / A}


@sheet(OWN, "A > xP, econ > TF, S > F, A S > U xF, Q > TB")
def evaporator(F, xF, xP, TF, TB, cp, hv, hs, Ts, U):
    P = F * xF / xP
    V = F - P
    Q = (F * cp * (TB - TF) + V * hv) / 3600
    S = Q * 3600 / hs
    return {"P": P, "V": V, "Q": Q, "S": S, "A": Q / (U * (Ts - TB)), "econ": V / S}


@sheet(OWN, "c > m, rem > V, q > qm, rem > KL, q rem > c0 m")
def langmuir(c0, V, m, qm, KL):
    b = V + m * qm * KL - V * KL * c0
    c = (-b + sqrt(b**2 + 4 * V * KL * V * c0)) / (2 * V * KL)
    return {"c": c, "q": V * (c0 - c) / m, "rem": 1 - c / c0}


@sheet(OWN, "R > p, X > Xs, I1 > p, R X > F Xs, PA > p")
def recycle(F, yI, Xs, p):
    A1 = F * (1 - yI) / (1 - (1 - p) * (1 - Xs))
    A2 = A1 * (1 - Xs)
    return {
        "A1": A1,
        "A2": A2,
        "I1": F * yI / p,
        "R": A1 * Xs,
        "PA": p * A2,
        "X": A1 * Xs / (F * (1 - yI)),
    }


@sheet(OWN, "C > C0, X > k, X > V, C > Q")
def tank_reactor(V, Q, k, C0):
    tau = V / Q
    C = (sqrt(1 + 4 * k * tau * C0) - 1) / (2 * k * tau)
    return {"tau": tau, "C": C, "X": 1 - C / C0}


@sheet(
    "constants of nickel ammines",
    "m1 > K2, m4 > K4, m2 > K3, free > NH3, m0 > K1",
)
def complexes(Ni, NH3, K1, K2, K3, K4):
    betas = [1, K1, K1 * K2, K1 * K2 * K3, K1 * K2 * K3 * K4]

    def amounts(free):
        shares = [beta * free**k for k, beta in enumerate(betas)]
        return [Ni * share / sum(shares) for share in shares]

    free = root(lambda free: free + sum(k * m for k, m in enumerate(amounts(free))) - NH3, 0, NH3)
    return {**{f"m{k}": m for k, m in enumerate(amounts(free))}, "free": free}


@sheet(
    "Meintjes and Morgan, ACM TOMS 16 (1990) 143-151, the one positive answer",
    "y1 > R7, y1 > R9, y3 > R5, y5 > R, y2 > R6",
    y1=(0.00311410, 1e-3),
    y2=(34.5979, 1e-3),
    y3=(0.0650418, 1e-3),
    y4=(0.859378, 1e-3),
    y5=(0.0369519, 1e-3),
)
def combustion(R, R5, R6, R7, R8, R9, R10):
    def misses(logs):
        y1, y2, y3, y4 = map(exp, logs)
        y5 = y1 * (y2 + 1) / 3
        three = y3 * (y3 + R7)
        return (
            y3 * (y2 * (2 * y3 + R7) + 2 * R5 * y3 + R6) - 8 * y5,
            y4 * (R9 * y2 + 2 * y4) - 4 * R * y5,
            y2 * (2 * y1 + three + R8 + 2 * R10 * y2 + R9 * y4) + y1 - R * y5,
            y2 * (y1 + R10 * y2 + three + R8 + R9 * y4) + y1 + y3 * (R5 * y3 + R6) + y4**2 - 1,
        )

    y = [
        exp(found)
        for found in fsolve(misses, [log(0.003), log(35), log(0.065), log(0.86)], xtol=1e-12)
    ]
    return {"y1": y[0], "y2": y[1], "y3": y[2], "y4": y[3], "y5": y[0] * (y[1] + 1) / 3}


@sheet(OWN, "rec > W, rec > x, rec e1 > W x")
def leaching(S, x, W, ret):
    oil, Lu = x * S, ret * (1 - x) * S
    left = Lu / (Lu + W)
    e1, e2 = oil * (1 - left), oil * left * (1 - left)
    x1 = oil / (Lu + W)
    return {"oil": oil, "Lu": Lu, "x1": x1, "x2": x1 * left, "e1": e1, "e2": e2, "rec": 1 - left**2}


@sheet(OWN, "pH > Vb, pH > Ka, pH > Ca, pH > Cb, H > Va")
def titration(Ca, Va, Cb, Vb, Ka, Kw):
    def charge(H):
        total = Va + Vb
        return Cb * Vb / total + H - Kw / H - Ca * Va / total * Ka / (Ka + H)

    H = root(charge, 1e-12, 1e-1)
    return {"pH": -log10(H), "H": H}


@sheet(OWN, "pH > A, pH2 > add, pH pH2 > A add, pH2 > pKa")
def henderson(pKa, HA, A, add):
    return {"pH": pKa + log10(A / HA), "pH2": pKa + log10((A + add) / (HA - add))}


@sheet(OWN, "v > S, inh > Ki, v vi > Vmax Ki, vi > I")
def michaelis(Vmax, Km, S, I, Ki):  # noqa: E741
    v, vi = Vmax * S / (Km + S), Vmax * S / (Km * (1 + I / Ki) + S)
    return {"v": v, "vi": vi, "inh": 100 * (1 - vi / v)}


@sheet(OWN, "p > T, Z > a, p > v, p Z > T a")
def redlich_kwong(T, v, a, b, R):
    p = R * T / (v - b) - a / (sqrt(T) * v * (v + b))
    return {"p": p, "Z": p * v / (R * T)}


@sheet(OWN, "a1 > Ct, a1 > Na, pH > Na, a3 > Kw")
def phosphoric(Ka1, Ka2, Ka3, Kw, Ct, Na):
    def shares(H):
        parts = (Ka1 * H**2, Ka1 * Ka2 * H, Ka1 * Ka2 * Ka3)
        return [part / (H**3 + sum(parts)) for part in parts]

    def charge(pH):
        H = 10**-pH
        return Na + H - Kw / H - Ct * sum(k * a for k, a in enumerate(shares(H), 1))

    pH = brentq(charge, 0, 14, xtol=1e-14)
    H = 10**-pH
    a1, a2, a3 = shares(H)
    return {"pH": pH, "H": H, "OH": Kw / H, "den": Ka1 * H**2 / a1, "a1": a1, "a2": a2, "a3": a3}


@sheet(OWN, "pH > pCO2, HCO3 > KH, H > K1, OH > pCO2")
def rain(pCO2, KH, K1, K2, Kw):
    acid = KH * pCO2

    def charge(pH):
        H = 10**-pH
        return H - (K1 * acid + Kw) / H - 2 * K1 * K2 * acid / H**2

    H = 10 ** -brentq(charge, 3, 9, xtol=1e-14)
    HCO3 = K1 * acid / H
    return {
        "pH": -log10(H),
        "H": H,
        "OH": Kw / H,
        "H2CO3": acid,
        "HCO3": HCO3,
        "CO3": K2 * HCO3 / H,
    }


@sheet("NIST: propane boils at 300 K and 9.978 bar", "p > T", p=(9.98, 0.002))
def peng_robinson(T, Tc, pc, om, R):
    kap = 0.37464 + 1.54226 * om - 0.26992 * om**2
    al = (1 + kap * (1 - sqrt(T / Tc))) ** 2
    a, b = 0.45724 * R**2 * Tc**2 / pc * al, 0.0778 * R * Tc / pc

    def phases(p):
        A, B = a * p / (R * T) ** 2, b * p / (R * T)
        cubic = [1, B - 1, A - 3 * B**2 - 2 * B, B**2 + B**3 - A * B]
        ends = sorted(z.real for z in roots(cubic))
        return A, B, *(float(ends[place]) for place in (0, -1))

    def fugacity(Z, A, B):
        ratio = (Z + (1 + sqrt(2)) * B) / (Z + (1 - sqrt(2)) * B)
        return exp(Z - 1 - log(Z - B) - A / (2 * sqrt(2) * B) * log(ratio))

    def excess(p):
        A, B, ZL, ZV = phases(p)
        return fugacity(ZL, A, B) / fugacity(ZV, A, B) - 1

    p = root(excess, 8, 12)
    A, B, ZL, ZV = phases(p)
    return {
        "kap": kap,
        "al": al,
        "a": a,
        "b": b,
        "p": p,
        "A": A,
        "B": B,
        "ZL": ZL,
        "ZV": ZV,
        "fL": fugacity(ZL, A, B),
        "fV": fugacity(ZV, A, B),
        "vL": ZL * R * T / p,
        "vV": ZV * R * T / p,
    }


@sheet(OWN, "Na1 > c0, Cl2 > z, dE > T, Cl1 > V2")
def donnan(cP, z, c0, V1, V2, T):
    def outside(Cl1):
        return c0 - V1 / V2 * Cl1

    Cl1 = root(lambda c: (c - z * cP) * c - outside(c) ** 2, 0, V2 * c0 / V1)
    Na1, Na2 = Cl1 - z * cP, outside(Cl1)
    dE = 8.314 * T / 96485 * log(Na2 / Na1)
    return {"Na1": Na1, "Cl1": Cl1, "Na2": Na2, "Cl2": Na2, "dE": dE}


@sheet(OWN, "rec > xF, rec > xW, yD > xW, D > alpha, y0 > xF, share yD > xF xW")
def rayleigh_still(F, xF, xW, alpha):
    heavy = log((1 - xW) / (1 - xF))
    W = F / exp((log(xF / xW) + heavy) / (alpha - 1) + heavy)
    D = F - W
    drawn = F * xF - W * xW
    return {
        "W": W,
        "D": D,
        "yD": drawn / D,
        "y0": alpha * xF / (1 + (alpha - 1) * xF),
        "yend": alpha * xW / (1 + (alpha - 1) * xW),
        "rec": 100 * drawn / (F * xF),
        "share": D / F,
    }
