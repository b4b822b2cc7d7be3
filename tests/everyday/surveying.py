"""Plane and height surveying, roads and earthworks."""

from __future__ import annotations

from math import acos, asin, atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tan

from .corpus import OWN, sheet


def sind(angle):
    return sin(radians(angle))


def cosd(angle):
    return cos(radians(angle))


def tand(angle):
    return tan(radians(angle))


@sheet(OWN, "h > d, h > a1, x > a2, h x > a1 a2")
def tower_two_angles(d, a1, a2, hi):
    x = d * tand(a1) / (tand(a2) - tand(a1))
    return {"x": x, "h": hi + x * tand(a2)}


def circles(xA, yA, xB, yB, rA, rB, side=1):
    """The intersection to the left of the line from A to B, or to the right."""
    base, direction = hypot(xB - xA, yB - yA), atan2(yB - yA, xB - xA)
    angle = direction + side * acos((rA**2 + base**2 - rB**2) / (2 * rA * base))
    return xA + rA * cos(angle), yA + rA * sin(angle)


def intersection(xA, yA, xB, yB, tA, tB):
    dx, dy = xB - xA, yB - yA
    det = sind(tA) * cosd(tB) - cosd(tA) * sind(tB)
    dA = (dx * cosd(tB) - dy * sind(tB)) / det
    dB = (dx * cosd(tA) - dy * sind(tA)) / det
    return dA, dB, xA + dA * sind(tA), yA + dA * cosd(tA)


def right_of_base():
    """The intersection of the same two distances on the other side of the base."""
    dA, dB, *_ = intersection(100, 200, 400, 260, 60, 320)
    return dict(zip("xy", circles(100, 200, 400, 260, dA, dB, -1), strict=True))


@sheet(
    OWN,
    "x y > tA tB, dA > tB, x > yB, dA dB > tA tB",
    {
        "dA dB > tA tB": (right_of_base(),),
    },
)
def forward_intersection(xA, yA, xB, yB, tA, tB):
    return dict(zip(("dA", "dB", "x", "y"), intersection(xA, yA, xB, yB, tA, tB), strict=True))


@sheet(
    OWN,
    "d t > xB yB, dx > xA, d > yB, t > xB",
    {
        "d > yB": ({"yB": 2 * 2310.10 - 2525.75},),
    },
)
def inverse_problem(xA, yA, xB, yB):
    dx, dy = xB - xA, yB - yA
    return {"dx": dx, "dy": dy, "d": hypot(dx, dy), "t": degrees(atan2(dx, dy))}


@sheet(
    "standard formulas of highway curves", "E > D, T > R, L > D, E > R, T L > R D, M > D, PT > P0"
)
def circular_curve(R, D, P0):
    T, L = R * tand(D / 2), pi * R * D / 180
    return {
        "T": T,
        "L": L,
        "C": 2 * R * sind(D / 2),
        "E": R / cosd(D / 2) - R,
        "M": R - R * cosd(D / 2),
        "PC": P0 - T,
        "PT": P0 - T + L,
    }


@sheet("standard formulas of highway curves", "yH > yV, xH > L, K > L, yH > L, yP xH > yV L")
def vertical_curve(g1, g2, L, xV, yV):
    xP, yP = xV - L / 2, yV - g1 / 100 * L / 2
    u = g1 * L / (g1 - g2)
    return {"xP": xP, "yP": yP, "xH": xP + u, "yH": yP + g1 / 100 * u / 2, "K": L / abs(g1 - g2)}


@sheet(OWN, "d > s, H2 > s, d dh > s a, H2 > H1")
def stadia(k, s, a, hi, r, H1):
    d, dh = k * s * cosd(a) ** 2, k * s * sind(2 * a) / 2
    return {"d": d, "dh": dh, "H2": H1 + hi + dh - r}


@sheet(
    OWN,
    "ga > c, al be > a b, A > c, al > a, h > b",
    {
        "A > c": ({"c": sqrt(2 * (45**2 + 60**2) - 70**2)},),
    },
)
def triangle_sides(a, b, c):
    s = (a + b + c) / 2
    A = sqrt(s * (s - a) * (s - b) * (s - c))
    al = degrees(acos((b**2 + c**2 - a**2) / (2 * b * c)))
    be = degrees(acos((a**2 + c**2 - b**2) / (2 * a * c)))
    return {"s": s, "A": A, "al": al, "be": be, "ga": 180 - al - be, "h": 2 * A / c}


@sheet(OWN, "a > c, a > al, a b > al be, A > c, A > be")
def sine_rule(c, al, be):
    ga = 180 - al - be
    a, b = c * sind(al) / sind(ga), c * sind(be) / sind(ga)
    return {"ga": ga, "a": a, "b": b, "A": a * b * sind(ga) / 2}


@sheet(OWN, "V > h2, V > L, A1 > h1, Vend V > b L, V > b")
def earthwork(b, s, h1, h2, L):
    def area(h):
        return (b + s * h) * h

    A1, A2, hm = area(h1), area(h2), (h1 + h2) / 2
    return {
        "A1": A1,
        "A2": A2,
        "hm": hm,
        "Am": area(hm),
        "V": L / 6 * (A1 + 4 * area(hm) + A2),
        "Vend": L * (A1 + A2) / 2,
    }


@sheet(OWN, "d > h, d1 > h, d > H, e > k")
def curvature_refraction(R, k, h, H):
    d1, d2 = sqrt(2 * R * h / (1 - k)), sqrt(2 * R * H / (1 - k))
    return {"d1": d1, "d2": d2, "d": d1 + d2, "e": (1 - k) * 1e6 / (2 * R)}


@sheet(
    "haversine, Berlin to New York",
    "d > R, d > l2, c > l2, d > p2",
    {
        "d > l2": ({"l2": 2 * 13.40 + 74.01},),
        "c > l2": ({"l2": 2 * 13.40 + 74.01},),
    },
    d=(6385, 3e-3),
)
def great_circle(R, p1, l1, p2, l2):
    a = sind((p2 - p1) / 2) ** 2 + cosd(p1) * cosd(p2) * sind((l2 - l1) / 2) ** 2
    c = 2 * degrees(asin(sqrt(a)))
    return {"a": a, "c": c, "d": R * radians(c)}


@sheet(
    OWN,
    "x y > rA rB, x > rA, y > rB, x y > xB rA",
    {
        "x y > xB rA": ({"xB": 2 * circles(0, 0, 500, 120, 380, 290)[0] - 500},),
    },
)
def trilateration(xA, yA, xB, yB, rA, rB):
    x, y = circles(xA, yA, xB, yB, rA, rB)
    return {"x": x, "y": y}


@sheet(
    OWN,
    "H2 > z, d > s, grade > z, d H2 > s z, d > z",
    {
        "d > z": ({"z": 180 - 86.4},),
    },
)
def slope_distance(s, z, hi, ht, H1):
    d, H2 = s * sind(z), H1 + hi + s * cosd(z) - ht
    return {"d": d, "H2": H2, "grade": 100 * (H2 - H1) / d}


@sheet(OWN, "A area > C a, area c > C b, area c > a b, A > C, B > a")
def triangle_area(a, b, C):
    c = sqrt(a**2 + b**2 - 2 * a * b * cosd(C))
    A = degrees(acos((b**2 + c**2 - a**2) / (2 * b * c)))
    return {"c": c, "A": A, "B": 180 - C - A, "area": a * b * sind(C) / 2}


@sheet(OWN, "P > b, A c > a b, p q > a b, alpha P > a b")
def right_triangle(a, b):
    c, alpha = hypot(a, b), degrees(atan2(a, b))
    return {
        "c": c,
        "alpha": alpha,
        "beta": 90 - alpha,
        "A": a * b / 2,
        "P": a + b + c,
        "h": a * b / c,
        "p": a**2 / c,
        "q": b**2 / c,
    }


@sheet(OWN, "d > h, dip > h, D > ship, d D > h ship, dip > R")
def horizon(h, R, ship):
    def distance(height):
        return sqrt(2 * R * height + height**2) / 1000

    dip = 2 * asin(sqrt(h / (2 * (R + h))))
    return {"d": distance(h), "dip": degrees(dip), "D": distance(h) + distance(ship)}


@sheet(OWN, "az > d1, N2 E2 > d1 d2, close az > d1 d2, N2 E2 > N0 E0")
def traverse(N0, E0, d1, az1, d2, az2):
    north, east = d1 * cosd(az1) + d2 * cosd(az2), d1 * sind(az1) + d2 * sind(az2)
    return {
        "N2": N0 + north,
        "E2": E0 + east,
        "close": hypot(north, east),
        "az": degrees(atan2(east, north)),
    }


@sheet(OWN, "w > base, gamma > alpha, a gamma > base alpha, w > alpha")
def river_width(base, alpha, beta):
    gamma = 180 - alpha - beta
    a = base * sind(alpha) / sind(gamma)
    return {"gamma": gamma, "a": a, "w": a * sind(beta)}


@sheet(OWN, "noon > lat, alt > H, noon alt > lat H, daylen > lat")
def sun_height(lat, day, H):
    decl = 23.45 * sind(360 * (284 + day) / 365)
    alt = asin(sind(lat) * sind(decl) + cosd(lat) * cosd(decl) * cosd(H))
    return {
        "decl": decl,
        "alt": degrees(alt),
        "noon": 90 - lat + decl,
        "daylen": 2 / 15 * degrees(acos(-tand(lat) * tand(decl))),
    }


@sheet(OWN, "TWS > AWS, TWA > BS, VMG > BS, TWS TWA > AWS AWA")
def sailing(AWS, AWA, BS):
    x, y = AWS * cos(radians(AWA)) - BS, AWS * sin(radians(AWA))
    return {"TWS": hypot(x, y), "TWA": degrees(atan2(y, x)), "VMG": BS * x / hypot(x, y)}


@sheet(
    OWN,
    "alt azs > day hour, daylight > lat, theta > az, alt daylight > day lat, I > tilt, AM > hour",
)
def sun_tracking(lat, day, hour, tilt, az, G):
    dec, w = 23.45 * sind(360 * (284 + day) / 365), 15 * (hour - 12)
    sina = sind(lat) * sind(dec) + cosd(lat) * cosd(dec) * cosd(w)
    alt = degrees(asin(sina))
    azs = degrees(atan2(sind(w), cosd(w) * sind(lat) - tand(dec) * cosd(lat)))
    ci = sina * cosd(tilt) + cosd(alt) * sind(tilt) * cosd(azs - az)
    ws = degrees(acos(-tand(lat) * tand(dec)))
    mass = {"AM": 1 / (sina + 0.50572 * (alt + 6.07995) ** -1.6364), "daylight": 2 * ws / 15}
    sun = {"dec": dec, "w": w, "sina": sina, "alt": alt, "azs": azs, "ws": ws, **mass}
    return {**sun, "ci": ci, "theta": degrees(acos(ci)), "I": G * max(ci, 0)}
