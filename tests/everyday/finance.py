"""Loans, savings, bonds, options and prices."""

from __future__ import annotations

from math import erf, exp, log, sqrt

from scipy.optimize import brentq

from .corpus import OWN, sheet


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-16, rtol=1e-14))


@sheet(OWN, "A > n, A > r, interest > r, total A > n P", tolerance=1e-7)
def annuity_loan(P, r, n):
    i = r / 1200
    A = P * i / (1 - (1 + i) ** -n)
    return {"i": i, "A": A, "total": n * A, "interest": n * A - P}


@sheet(OWN, "share > price, A > years, A cash > r price, share > r", tolerance=1e-7)
def mortgage(price, down, costs, income, r, years):
    loan, q = price * (1 - down), 1 + r / 1200
    A = loan * (q - 1) / (1 - q ** (-12 * years))
    return {"loan": loan, "cash": price * (down + costs), "q": q, "A": A, "share": A / income}


@sheet(OWN, "K > m, K > p, K > t, gain > t, paid K > m p", tolerance=1e-7)
def savings_plan(K0, m, p, t):
    q = (1 + p / 100) ** (1 / 12)
    K, paid = K0 * q ** (12 * t) + m * (q ** (12 * t) - 1) / (q - 1), K0 + 12 * t * m
    return {"q": q, "K": K, "paid": paid, "gain": K - paid}


@sheet(OWN, "t2 > p, real > infl, K > n, pr > infl, K real > p infl")
def compound_interest(K0, p, n, infl):
    K, i = K0 * (1 + p / 100) ** n, 1 + infl / 100
    return {
        "K": K,
        "real": K / i**n,
        "t2": log(2) / log(1 + p / 100),
        "pr": 100 * ((1 + p / 100) / i - 1),
    }


@sheet(
    "documentation of the spreadsheet function IRR", "pct > c0, pct > c5, r > c2", pct=(8.66, 1e-3)
)
def irr(c0, c1, c2, c3, c4, c5):
    flows = (c1, c2, c3, c4, c5)
    r = root(lambda r: sum(c / (1 + r) ** k for k, c in enumerate(flows, 1)) - c0, -0.5, 1)
    return {"r": r, "pct": 100 * r}


@sheet(OWN, "P > y, P > c, P > n, cur > y, P cur > y c", tolerance=1e-7)
def bond(F, c, n, y):
    C, v = F * c / 100, 1 / (1 + y / 100)
    P = sum(C * v**k for k in range(1, round(n) + 1)) + F * v**n
    return {"C": C, "v": v, "P": P, "cur": 100 * C / P}


@sheet(
    "Hull, Options, Futures and Other Derivatives, Example 15.6 (8th edition: 14.6)",
    "C > sigma, P > S, P > K, C > T",
    C=(4.76, 2e-3),
    P=(0.81, 5e-3),
)
def black_scholes(S, K, r, sigma, T):
    d1 = (log(S / K) + (r + sigma**2 / 2) * T) / (sigma * sqrt(T))
    d2 = d1 - sigma * sqrt(T)
    N1, N2 = (1 + erf(d1 / sqrt(2))) / 2, (1 + erf(d2 / sqrt(2))) / 2
    C = S * N1 - K * exp(-r * T) * N2
    return {"d1": d1, "d2": d2, "N1": N1, "N2": N2, "C": C, "P": C - S + K * exp(-r * T)}


@sheet(OWN, "profit > price, be > price, margin > n, safety > fixed")
def break_even(fixed, price, var, n):
    be, profit = fixed / (price - var), n * (price - var) - fixed
    return {"be": be, "profit": profit, "margin": profit / (n * price), "safety": (n - be) / n}


@sheet(OWN, "gross > cost, gross > markup, profit gross > markup vat, profit > disc")
def price_with_tax(cost, markup, disc, vat):
    net = cost * (1 + markup / 100) * (1 - disc / 100)
    return {"net": net, "gross": net * (1 + vat / 100), "profit": net - cost}


@sheet(OWN, "tax > income, net > income, avg > income")
def progressive_tax(income):
    tax = (
        0
        if income <= 12000
        else 0.2 * (income - 12000)
        if income <= 40000
        else 5600 + 0.42 * (income - 40000)
    )
    return {"tax": tax, "net": income - tax, "avg": 100 * tax / income}


@sheet(OWN, "eff > A, eff > res, i > n, eff > V", tolerance=1e-7)
def lease_or_buy(V, A, n, res):
    i = root(lambda i: A * (1 - (1 + i) ** -n) / i + res * (1 + i) ** -n - V, 1e-5, 0.1)
    return {"i": i, "eff": 100 * ((1 + i) ** 12 - 1)}


@sheet(OWN, "P > g, PE > k, P PE > g E")
def growth_stock(D, g, k, E):
    P = D * (1 + g / 100) / (k / 100 - g / 100)
    return {"P": P, "PE": P / E}


@sheet(OWN, "K > m, K > S, K > r, real > infl, real > m", tolerance=1e-7)
def retirement(S, m, r, years, infl):
    i = r / 1200
    K = S * (1 + i) ** (12 * years) + m * ((1 + i) ** (12 * years) - 1) / i
    return {"i": i, "K": K, "real": K / (1 + infl / 100) ** years}


@sheet(OWN, "total > price, net > disc, total > vat, net > qty")
def web_shop(price, qty, disc, vat):
    net = price * qty * (1 - disc / 100)
    ship = 0.0 if net > 500 else 12.5
    total = (net + ship) * (1 + vat / 100)
    return {"net": net, "ship": ship, "total": total, "pay": round(total * 100) / 100}


@sheet(OWN, "net > gross, cost > gross, wedge > gross, tax > free, net cost > gross free")
def pay_with_caps(gross, cap, free):
    soc = 0.19 * min(gross, cap)
    base = max(0, gross - soc - free)
    tax = 0.12 * min(base, 2500) + 0.3 * max(0, base - 2500)
    net, cost = gross - soc - tax, gross + 0.21 * min(gross, cap)
    return {
        "soc": soc,
        "base": base,
        "tax": tax,
        "net": net,
        "cost": cost,
        "wedge": 100 * (cost - net) / cost,
    }


@sheet(
    "J. C. Hull, Options, Futures, and Other Derivatives, section 24.6",
    "V > E0, s > sE",
    V=(12.40, 1e-3),
    s=(0.2123, 1e-3),
    pd=(0.127, 5e-3),
)
def firm_value(E0, sE, D, r, T):
    def told(V, s):
        d1 = (log(V / D) + (r + s**2 / 2) * T) / (s * sqrt(T))
        d2 = d1 - s * sqrt(T)
        return d1, d2, (1 + erf(d1 / sqrt(2))) / 2, (1 + erf(d2 / sqrt(2))) / 2

    def value(s):
        def miss(V):
            _, _, N1, N2 = told(V, s)
            return V * N1 - D * exp(-r * T) * N2 - E0

        return root(miss, E0, E0 + D)

    s = root(lambda s: told(value(s), s)[2] * s * value(s) - sE * E0, 0.05, 1)
    V = value(s)
    d1, d2, N1, N2 = told(V, s)
    return {"V": V, "s": s, "d1": d1, "d2": d2, "N1": N1, "N2": N2, "pd": 1 - N2}


@sheet(OWN, "P > n, current > n")
def bond_price(F, c, y, n):
    P = sum(F * c / 100 / (1 + y / 100) ** k for k in range(1, int(n) + 1))
    P += F / (1 + y / 100) ** n
    return {"P": P, "current": F * c / P}


@sheet(OWN, "mean > h, pay > h")
def overtime(h, w):
    pay = w * (h + max(h - 40, 0) / 2)
    return {"pay": pay, "mean": pay / h}


@sheet(OWN, "end > long")
def night_shift(start, long):
    return {"end": (start + long) % 24}


@sheet(OWN, "d > n, SL > C, B3 > S, SL d > C n, SL dep3 > C S, SL dep3 > S n, dep3 > k")
def depreciation(C, S, n, k):
    d = 1 - (S / C) ** (1 / n)
    return {
        "d": d,
        "B3": C * (1 - d) ** k,
        "dep3": C * (1 - d) ** (k - 1) * d,
        "SL": (C - S) / n,
    }


@sheet(OWN, "NPV > r, irr > I, PI > c1, NPV irr > c2 c3, PI irr > I r")
def npv3(I, c1, c2, c3, r):  # noqa: E741
    def worth(percent):
        return sum(c / (1 + percent / 100) ** k for k, c in enumerate((c1, c2, c3), 1))

    npv = worth(r) - I
    return {"NPV": npv, "irr": root(lambda x: worth(x) - I, 0, 100), "PI": (npv + I) / I}


@sheet(OWN, "tax > t, Pd > t, Q Ps > a d, DWL > t, CS > b")
def market(a, b, c, d, t):
    Ps = (a - b * t + c) / (b + d)
    Pd, Q = Ps + t, a - b * (Ps + t)
    return {
        "Ps": Ps,
        "Pd": Pd,
        "Q": Q,
        "CS": (a / b - Pd) * Q / 2,
        "tax": t * Q,
        "DWL": t**2 / (2 * (1 / b + 1 / d)),
    }


@sheet(OWN, "pay > sales, c > sales, pay c > sales base, rate > sales")
def commission(sales, base):
    c = 1500 + 0.05 * (sales - 50000)
    return {"c": c, "pay": base + c, "rate": c / sales}


@sheet(OWN, "net > income, tax > income")
def tax_by_slices(income):
    ends, rates = (0, 10000, 40000, 85000, float("inf")), (0.1, 0.15, 0.25, 0.35)
    t1, t2, t3, t4 = (
        rate * max(min(income, high) - low, 0)
        for low, high, rate in zip(ends[:-1], ends[1:], rates, strict=True)
    )
    tax = t1 + t2 + t3 + t4
    return {
        "t1": t1,
        "t2": t2,
        "t3": t3,
        "t4": t4,
        "tax": tax,
        "net": income - tax,
        "avg": tax / income,
    }


@sheet(OWN, "duty > price, total > price, rate > price")
def stamp_duty(price):
    slices = ((250000, 0.05), (925000, 0.05), (1500000, 0.02))
    duty = sum(rate * max(price - start, 0) for start, rate in slices)
    return {"duty": duty, "total": price + duty, "rate": duty / price}


@sheet(OWN, "EV > g, wacc > D, ke > bu, E > FCF, lev bl > D tax")
def circular_wacc(FCF, g, D, rf, mrp, bu, kd, tax):
    """The value cancels from its rules but for a sum of debt and unlevered equity."""
    unlevered = rf + bu * mrp
    EV = (FCF + D * (unlevered - bu * (1 - tax) * mrp - kd * (1 - tax))) / (unlevered - g)
    E = EV - D
    bl = bu * (1 + (1 - tax) * D / E)
    return {
        "EV": EV,
        "E": E,
        "bl": bl,
        "ke": rf + bl * mrp,
        "wacc": FCF / EV + g,
        "lev": D / EV,
    }


@sheet(OWN, "P > y, D > y, Dm > y, conv > y, dP > y, bpv > y, Pnew > dy, C Dm > face y")
def bond_duration(face, c, y, n, dy):
    C, v = c / 100 * face, 1 / (1 + y / 100)
    paid = [(k, C + (face if k == n else 0.0)) for k in range(1, 5)]
    P = sum(pay * v**k for k, pay in paid)
    D = sum(k * pay * v**k for k, pay in paid) / P
    conv = sum(k * (k + 1) * pay * v ** (k + 2) for k, pay in paid) / P
    dP = -D * v * dy / 100 + conv / 2 * (dy / 100) ** 2
    return {
        "C": C,
        "v": v,
        "P": P,
        "D": D,
        "Dm": D * v,
        "conv": conv,
        "dP": dP,
        "Pnew": P * (1 + dP),
        "bpv": D * v * P / 10000,
    }
