"""Fluid mechanics."""

from __future__ import annotations

from math import acos, atan, cos, degrees, log10, pi, radians, sin, sqrt, tan

from scipy.optimize import brentq

from .corpus import OWN, sheet


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-14))


def colebrook(Re, relative):
    return root(lambda f: 1 / sqrt(f) + 2 * log10(relative / 3.7 + 2.51 / (Re * sqrt(f))), 1e-3, 1)


@sheet(
    "Çengel and Cimbala, Fluid Mechanics, Examples 8-4 and 8-5",
    "D > V, D > hL, Re > nu",
    D=0.267,
    f=0.0180,
    vel=6.24,
    Re=100800,
)
def air_duct(V, L, hL, nu, g):
    def parts(D):
        vel = V / (pi * D**2 / 4)
        return vel, vel * D / nu, colebrook(vel * D / nu, 0)

    def excess(D):
        vel, _, f = parts(D)
        return f * L / D * vel**2 / (2 * g) - hL

    D = root(excess, 0.1, 1)
    return {"D": D} | dict(zip(("vel", "Re", "f"), parts(D), strict=True))


@sheet(OWN, "dp > Q, dp > D, P > eps, P > Q")
def pipe_colebrook(D, L, eps, Q, rho, mu):
    A = pi * D**2 / 4
    v = Q / A
    Re = rho * v * D / mu
    f = colebrook(Re, eps / D)
    dp = f * L / D * rho * v**2 / 2
    return {"A": A, "v": v, "Re": Re, "f": f, "dp": dp, "P": dp * Q}


@sheet(OWN, "hf > D, hf > Q, f > eps")
def pipe_haaland(D, L, eps, Q, nu, g):
    v = 4 * Q / (pi * D**2)
    f = (-1.8 * log10(6.9 * nu / (v * D) + (eps / D / 3.7) ** 1.11)) ** -2
    return {"v": v, "Re": v * D / nu, "f": f, "hf": f * L / D * v**2 / (2 * g)}


@sheet(OWN, "dp > D, tau > Q, Re > mu")
def laminar_pipe(D, L, Q, mu, rho):
    v = Q / (pi * D**2 / 4)
    dp = 128 * mu * L * Q / (pi * D**4)
    return {
        "v": v,
        "Re": rho * v * D / mu,
        "f": 64 * mu / (rho * v * D),
        "dp": dp,
        "tau": dp * D / (4 * L),
    }


@sheet("FHWA HDS-4, normal depth", "v > Q, R > b, v > n", y=(1.61908, 1e-5))
def manning_rectangular(b, n, S, Q):
    y = root(lambda y: b * y * (b * y / (b + 2 * y)) ** (2 / 3) * sqrt(S) / n - Q, 1e-3, 50)
    return {"y": y, "A": b * y, "P": b + 2 * y, "R": b * y / (b + 2 * y), "v": Q / (b * y)}


@sheet(OWN, "Q > y, Q > b, Fr > S, Q T > y b")
def manning_trapezoid(b, z, y, n, S):
    A, P, T = (b + z * y) * y, b + 2 * y * sqrt(1 + z**2), b + 2 * z * y
    v = (A / P) ** (2 / 3) * sqrt(S) / n
    return {"A": A, "P": P, "R": A / P, "T": T, "v": v, "Q": v * A, "Fr": v / sqrt(9.81 * A / T)}


@sheet(
    "FHWA HEC-14, chapter 6", "y2 > Fr1, dE > y1, dE > Fr1, v2 y2 > y1 Fr1", ratio=(3.7720, 1e-4)
)
def hydraulic_jump(y1, Fr1, g):
    r, v1 = (sqrt(1 + 8 * Fr1**2) - 1) / 2, Fr1 * sqrt(g * y1)
    return {
        "v1": v1,
        "ratio": r,
        "y2": r * y1,
        "v2": v1 / r,
        "dE": (r * y1 - y1) ** 3 / (4 * y1 * r * y1),
    }


ALTERNATE = root(
    lambda y: y + 2.5**2 / (19.62 * y * y) - 1.8 - 2.5**2 / (19.62 * 1.8**2), 0.1, 0.86
)


@sheet(OWN, "E > y, E > q, yc > q", {"E > y": ({"y": ALTERNATE},)})
def alternate_depths(q, g, y):
    yc = (q**2 / g) ** (1 / 3)
    return {"v": q / y, "E": y + (q / y) ** 2 / (2 * g), "yc": yc, "Ec": 1.5 * yc}


@sheet(OWN, "Q > h, Q > D2, v1 > D1, Q > rhom")
def venturi(D1, D2, Cd, rho, rhom, h, g):
    dp, beta = (rhom - rho) * g * h, D2 / D1
    v2 = Cd * sqrt(2 * dp / (rho * (1 - beta**4)))
    return {"dp": dp, "beta": beta, "v2": v2, "Q": v2 * pi * D2**2 / 4, "v1": v2 * beta**2}


@sheet(OWN, "Q > K, H > a, P Q > eta Hs, Q > H0")
def pump_point(H0, a, Hs, K, eta):
    Q = sqrt((H0 - Hs) / (a + K))
    return {"Q": Q, "H": Hs + K * Q**2, "P": 9.81 * Q * (Hs + K * Q**2) / eta}


@sheet(OWN, "Q > D, ps > zs, Q > dz, ps > f")
def siphon(D, L, f, K, dz, zs, Ls, g):
    head = dz / (1 + K + f * L / D)
    v = sqrt(2 * g * head)
    return {"v": v, "Q": v * pi * D**2 / 4, "ps": -zs - (1 + f * Ls / D) * head}


@sheet(OWN, "h > Q, Q1 > D2, v2 > L1")
def parallel_pipes(Q, L1, D1, f1, L2, D2, f2, g: float):
    A1, A2 = pi * D1**2 / 4, pi * D2**2 / 4
    ratio = sqrt(f2 * L2 / D2 / (f1 * L1 / D1))
    v2 = Q / (A1 * ratio + A2)
    v1 = ratio * v2
    return {"v1": v1, "v2": v2, "Q1": v1 * A1, "Q2": v2 * A2, "h": f1 * L1 / D1 * v1**2 / (2 * g)}


@sheet(OWN, "Q1 > z1, H > K3, Q3 > z2, Q1 Q2 > K1 z3")
def three_reservoirs(z1, z2, z3, K1, K2, K3):
    def flow(z, K, H):
        return (1 if z > H else -1) * sqrt(abs(z - H) / K)

    H = root(lambda H: flow(z1, K1, H) + flow(z2, K2, H) + flow(z3, K3, H), z3, z1)
    return {"H": H, "Q1": flow(z1, K1, H), "Q2": flow(z2, K2, H), "Q3": flow(z3, K3, H)}


@sheet(OWN, "hab > QA, qbc > Rab, qab qac > QA QB")
def pipe_loop(QA, QB, Rab, Rac, Rbc):
    def excess(q):
        return Rac * (QA - q) * abs(QA - q) - Rab * q * abs(q) - Rbc * (q - QB) * abs(q - QB)

    q = root(excess, 0, QA)
    return {
        "QC": QA - QB,
        "qab": q,
        "qac": QA - q,
        "qbc": q - QB,
        "hab": Rab * q * q,
        "hac": Rac * (QA - q) ** 2,
    }


@sheet("drag law of Schiller and Naumann 1935", "v > d, Re > rhop, v > mu")
def settling(d, rhop, rho, mu, g):
    def drag(v):
        Re = rho * v * d / mu
        return Re, 24 / Re * (1 + 0.15 * Re**0.687)

    v = root(lambda v: 0.75 * drag(v)[1] * rho * v**2 - (rhop - rho) * g * d, 1e-6, 1)
    return {"v": v, "Re": drag(v)[0], "Cd": drag(v)[1]}


def _other_mach(k, ratio):
    def area(M):
        return 1 / M * (2 / (k + 1) * (1 + (k - 1) / 2 * M**2)) ** ((k + 1) / (2 * (k - 1)))

    return root(lambda M: area(M) - ratio, 0.01, 1)


@sheet(
    "NACA 1135, Table I",
    "pr > M, Ar > M, p > M, v > T0",
    {"Ar > M": ({"M": _other_mach(1.4, 1.6875)},)},
    pr=(0.1278, 5e-4),
    Tr=(0.5556, 1e-4),
    Ar=(1.6875, 1e-4),
)
def isentropic_flow(M, k, p0, T0, R):
    t = 1 + (k - 1) / 2 * M**2
    pr = t ** (-k / (k - 1))
    Ar = 1 / M * (2 / (k + 1) * t) ** ((k + 1) / (2 * (k - 1)))
    return {
        "Tr": 1 / t,
        "pr": pr,
        "Ar": Ar,
        "T": T0 / t,
        "p": pr * p0,
        "v": M * sqrt(k * R * T0 / t),
    }


@sheet("NACA 1135, Table II", "M2 > M1, p2 > M1, T2 > M1", pr=(4.5, 1e-4), M2=(0.5774, 1e-4))
def normal_shock(M1, k, p1, T1):
    pr = 1 + 2 * k / (k + 1) * (M1**2 - 1)
    density = (k + 1) * M1**2 / ((k - 1) * M1**2 + 2)
    M2 = sqrt((1 + (k - 1) / 2 * M1**2) / (k * M1**2 - (k - 1) / 2))
    return {"pr": pr, "M2": M2, "p2": p1 * pr, "T2": T1 * pr / density}


def _deflection(beta, M, k):
    b = radians(beta)
    return degrees(atan(2 / tan(b) * (M**2 * sin(b) ** 2 - 1) / (M**2 * (k + cos(2 * b)) + 2)))


STRONG = root(lambda b: _deflection(b, 2, 1.4) - _deflection(39.3139, 2, 1.4), 70, 89)


@sheet(
    "NACA 1135, chart 2 (10 degrees)",
    "theta > beta, pr > beta, theta > M1",
    {"theta > beta": ({"beta": STRONG},)},
    theta=(10, 1e-5),
)
def oblique_shock(M1, k, beta):
    Mn1 = M1 * sin(radians(beta))
    return {"Mn1": Mn1, "pr": 1 + 2 * k / (k + 1) * (Mn1**2 - 1), "theta": _deflection(beta, M1, k)}


@sheet(OWN, "t > d, t > h2, t > h1")
def tank_draining(D, d, Cd, h1, h2, g):
    At, Ao = pi * D**2 / 4, pi * d**2 / 4
    return {"At": At, "Ao": Ao, "t": 2 * (D / d) ** 2 * (sqrt(h1) - sqrt(h2)) / (Cd * sqrt(2 * g))}


@sheet(
    OWN,
    "F > h, F > H, ycp > h, F ycp > H w",
    {
        "F > H": ({"H": 4.0},),
        "ycp > h": ({"h": 1 + 1 / 6},),
        "F ycp > H w": ({"H": 3.75},),
    },
)
def sluice_gate(h, H, w, rho, g):
    hc = h - H / 2
    return {"hc": hc, "F": rho * g * hc * H * w, "ycp": hc + H**2 / (12 * hc)}


@sheet(OWN, "Q > H, va > H, Q > L")
def weir(L, H, P, C):
    def flow(ha):
        return C * L * ((H + ha) ** 1.5 - ha**1.5)

    ha = root(lambda ha: (flow(ha) / (L * (H + P))) ** 2 / 19.62 - ha, 1e-6, 0.1)
    return {"Q": flow(ha), "ha": ha, "va": flow(ha) / (L * (H + P))}


@sheet(OWN, "h > D, h > Q, v h > D Q")
def hazen_williams(L, D, C, Q):
    return {"h": 10.67 * L * Q**1.852 / (C**1.852 * D**4.87), "v": 4 * Q / (pi * D**2)}


SLOW = root(
    lambda v: 0.028 * 9.8 * (v**3 - 55**3) + 0.052 * 12000**2 / 9.8 * (1 / v - 1 / 55), 5, 35
)
"""The slow speed of the same power."""


@sheet(
    OWN,
    "P > V, CL > V, D > V, P > CD0",
    {
        "P > V": ({"V": SLOW},),
        "D > V": ({"V": sqrt(0.052 * 12000**2 / (0.028 * 9.8**2)) / 55},),
    },
)
def level_flight(W, S, CD0, K, rho, V):
    q = rho * V**2 * S / 2
    CL = W / q
    D = (CD0 + K * CL**2) * q
    return {"CL": CL, "CD": CD0 + K * CL**2, "D": D, "P": D * V / 1000}


@sheet(
    OWN,
    "P > u, F > v, eta > u, F > th",
    {
        "P > u": ({"u": root(lambda u: u * (25 - u) ** 2 - 2250, 0.1, 8.3)},),
        "eta > u": ({"u": root(lambda u: u * (25 - u) ** 2 - 2250, 0.1, 8.3)},),
    },
)
def jet_on_vane(v, u, d, th, rho):
    A = pi * d**2 / 4
    F = rho * A * (v - u) ** 2 * (1 - cos(radians(th)))
    return {"m": rho * A * (v - u), "F": F, "P": F * u, "eta": F * u / (rho * A * v**3 / 2)}


@sheet(
    OWN,
    "Re > v, f > v, f > D, f > nu, dp > L, dp > v, Q dp > v L",
    dict.fromkeys(("f > v", "f > D", "f > nu"), ({"Re": 64 * 2300**0.25 / 0.316},)),
)
def pipe_regimes(D, L, nu, rho, v):
    Re = v * D / nu
    f = 64 / Re if Re < 2300 else 0.316 / Re**0.25
    return {"Re": Re, "f": f, "dp": f * L / D * rho * v**2 / 2, "Q": v * pi * D**2 / 4}


@sheet(OWN, "h > s, Vs > s, V h > R s, V > R")
def sphere_floating(R, s):
    V = 4 / 3 * pi * R**3
    h = root(lambda h: pi * h * h * (R - h / 3) - s * V, 0, 2 * R)
    return {"V": V, "Vs": s * V, "h": h}


@sheet(OWN, "Q > S, Q > n, theta > y, R > D, v Q > n y, Q theta > n y")
def chezy_circular(D, n, S, y):
    theta = 2 * acos(1 - 2 * y / D)
    A, P = D**2 / 8 * (theta - sin(theta)), D * theta / 2
    v = (A / P) ** (2 / 3) * sqrt(S) / n
    return {"theta": theta, "A": A, "P": P, "R": A / P, "v": v, "Q": A * v}


@sheet(OWN, "yc > Q, Ec > b, v E > Q y, Fr > y, yc v > Q y")
def critical_flow(b, Q, y):
    yc, v = (Q**2 / (9.81 * b**2)) ** (1 / 3), Q / (b * y)
    return {
        "yc": yc,
        "Ec": 1.5 * yc,
        "v": v,
        "E": y + v**2 / 19.62,
        "Fr": v / sqrt(9.81 * y),
    }


@sheet(OWN, "c > e1, dpreal > v0, dp > v0, Tc c > L E")
def water_hammer(K, E, D, e1, rho, v0, L, tclose):
    c = sqrt(K / rho / (1 + K * D / (E * e1)))
    return {"c": c, "dp": rho * c * v0, "Tc": 2 * L / c, "dpreal": rho * c * v0}


@sheet(OWN, "delta > x, D > b, Rex > L, delta Rex > U x")
def blasius(U, nu, x, L, rho, b):
    Re = U * L / nu
    Cf = 0.074 / Re**0.2 - 1742 / Re
    return {
        "Rex": Re,
        "delta": 5 * x / sqrt(U * x / nu),
        "Cf": Cf,
        "D": Cf * rho * U**2 / 2 * b * L,
    }


@sheet(OWN, "draft > rhob, GM > b, KB > H, GM draft > b rhob")
def buoyancy(b, L, H, rhow, rhob):
    draft = H * rhob / rhow
    BM = b**2 / (12 * draft)
    return {"draft": draft, "BM": BM, "KB": draft / 2, "KG": H / 2, "GM": draft / 2 + BM - H / 2}


@sheet("Çengel and Boles, chapter 17", "m > At, m > p0, m pc > At p0, V > pb, m > pb")
def gas_nozzle(p0, T0, pb, At, k, R):
    pc = p0 * (2 / (k + 1)) ** (k / (k - 1))
    pe = max(pb, pc)
    M = sqrt(2 / (k - 1) * ((p0 / pe) ** ((k - 1) / k) - 1))
    Te = T0 / (1 + (k - 1) / 2 * M**2)
    V = M * sqrt(k * R * Te)
    return {"pc": pc, "pe": pe, "M": M, "Te": Te, "V": V, "m": pe / (R * Te) * V * At / 10}


@sheet("McCabe, Smith and Harriott, chapter 7", "v > d, Re > d, v > rhop, Re > mu")
def settling_regimes(d, rhop, rho, mu):
    K = d * (9.81 * rho * (rhop - rho) / mu**2) ** (1 / 3)
    stokes = 9.81 * (rhop - rho) * d**2 / (18 * mu)
    between = 0.153 * 9.81**0.71 * d**1.14 * (rhop - rho) ** 0.71 / (rho**0.29 * mu**0.43)
    newton = 1.74 * sqrt(9.81 * d * (rhop - rho) / rho)
    v = stokes if K < 3.3 else between if K < 43.6 else newton
    return {"K": K, "v": v, "Re": rho * v * d / mu}


@sheet(OWN, "H > H1, Q1 > Hs, Q > H2, Q2 > a1, Q H > H1 k")
def check_valves(H1, a1, H2, a2, Hs, k):
    def flows(H):
        return sqrt((H1 - H) / a1), sqrt((H2 - H) / a2)

    H = root(lambda H: Hs + k * sum(flows(H)) ** 2 - H, Hs, H2)
    Q1, Q2 = flows(H)
    return {"H": H, "Q1": Q1, "Q2": Q2, "Q": Q1 + Q2}


@sheet(OWN, "Q > Hstat, Hp > D, P_shaft > eta, Q > f, V > Lp")
def pump_system(H0, a_p, Hstat, Lp, D, f, Ksum, eta):
    def speed(Q):
        return Q / 1000 / (pi / 4 * (D / 1000) ** 2)

    def surplus(Q):
        loss = (f * Lp * 1000 / D + Ksum) * speed(Q) ** 2 / (2 * 9.81)
        return H0 - a_p * Q**2 - Hstat - loss

    Q = root(surplus, 1, 60)
    Hp = H0 - a_p * Q**2
    return {"Q": Q, "Hp": Hp, "V": speed(Q), "P_shaft": 9.81 * Q / 1000 * Hp / (eta / 100)}


@sheet(OWN, "Q > Kv, Q > p2, sigma > p1, dpmax > FL")
def control_valve(p1, p2, pv, pc, FL, rho, Kv):
    FF = 0.96 - 0.28 * sqrt(pv / pc)
    dp, dpmax = p1 - p2, FL**2 * (p1 - FF * pv)
    dps = min(dp, dpmax)
    return {
        "FF": FF,
        "dpmax": dpmax,
        "dp": dp,
        "dps": dps,
        "Q": Kv * sqrt(dps / rho),
        "sigma": (p1 - pv) / dp,
    }


@sheet(OWN, "v > d, t > H, v > mu, Re > d, t > rhos")
def sphere_fall(d, rhos, rhof, mu, H):
    def drag(Re):
        if Re < 1:
            return 24 / Re
        return 24 / Re * (1 + 0.15 * Re**0.687) if Re < 1000 else 0.44

    def reynolds(v):
        return rhof * v * d / 1000 / mu

    weight = (rhos - rhof) * 9.81 * 4 / 3 * d / 1000
    v = root(lambda v: drag(reynolds(v)) * rhof * v**2 - weight, 1e-6, 10)
    return {"v": v, "Re": reynolds(v), "Cd": drag(reynolds(v)), "t": H / v}


@sheet(OWN, "P > Q, D > n, d > Q, eta > k, u > phi")
def pelton(H, Cv, phi, beta, k, n, Q, nj):
    free = sqrt(2 * 9.81 * H)
    V, u = Cv * free, phi * free
    D, d = 60 * u / (pi * n), sqrt(4 * Q / (nj * pi * V))
    P = 1000 * Q * u * (V - u) * (1 - k * cos(radians(beta)))
    eta, z = P / (1000 * 9.81 * Q * H), round(15 + D / (2 * d))
    return {"V": V, "u": u, "D": D, "d": d, "P": P, "eta": eta, "z": float(z)}


@sheet(OWN, "y4 > b2, P > Cc")
def channel_step(Q, b1, n, S, b2, dz, yg, Cc):
    """Flow is slow before the step and above it."""

    def slope(y):
        A = b1 * y
        return A * (A / (b1 + 2 * y)) ** (2 / 3) * sqrt(S) / n - Q

    y1 = root(slope, 0.01, 100)
    A1, q2 = b1 * y1, Q / b2
    v1, yc2 = Q / A1, (q2**2 / 9.81) ** (1 / 3)
    E1 = y1 + v1**2 / 19.62
    E2 = E1 - dz
    y2 = root(lambda y: y + q2**2 / (19.62 * y**2) - E2, yc2, E2)
    y3 = Cc * yg
    v3 = q2 / y3
    Fr3 = v3 / sqrt(9.81 * y3)
    y4 = y3 / 2 * (sqrt(1 + 8 * Fr3**2) - 1)
    dE = (y4 - y3) ** 3 / (4 * y3 * y4)
    return {
        "y1": y1,
        "A1": A1,
        "R1": A1 / (b1 + 2 * y1),
        "v1": v1,
        "E1": E1,
        "Fr1": v1 / sqrt(9.81 * y1),
        "yc1": ((Q / b1) ** 2 / 9.81) ** (1 / 3),
        "q2": q2,
        "yc2": yc2,
        "E2": E2,
        "y2": y2,
        "v2": q2 / y2,
        "Fr2": q2 / y2 / sqrt(9.81 * y2),
        "dzmax": E1 - 1.5 * yc2,
        "y3": y3,
        "v3": v3,
        "Fr3": Fr3,
        "y4": y4,
        "dE": dE,
        "Lj": 6.1 * y4,
        "P": 9.81 * Q * dE,
    }


@sheet(OWN, "Q > y, V > y, Fr > y, Qf > nf, share > bf, Q yf > y hb")
def compound_channel(bm, hb, bf, y, nm, nf, S):
    def flow(A, P, n):
        return A / n * (A / P) ** (2 / 3) * sqrt(S)

    yf = max(y - hb, 0)
    Am, Af = bm * y, 2 * bf * yf
    Pm, Pf = bm + 2 * hb, 2 * (bf + yf)
    Qm, Qf = flow(Am, Pm, nm), flow(Af, Pf, nf)
    A, T = Am + Af, bm + 2 * bf
    V = (Qm + Qf) / A
    return {
        "Am": Am,
        "Pm": Pm,
        "Qm": Qm,
        "yf": yf,
        "Af": Af,
        "Pf": Pf,
        "Qf": Qf,
        "Q": Qm + Qf,
        "A": A,
        "V": V,
        "share": Qf / (Qm + Qf),
        "T": T,
        "Fr": V / sqrt(9.81 * A / T),
    }
