"""Circuits, machines, lines and sensors."""

from __future__ import annotations

from math import (
    acos,
    atan,
    atan2,
    cos,
    degrees,
    exp,
    hypot,
    log,
    log10,
    pi,
    radians,
    sin,
    sqrt,
    tan,
)

import numpy as np
from scipy.optimize import brentq, fsolve

from .corpus import OWN, sheet


def root(function, low, high):
    return float(brentq(function, low, high, xtol=1e-18, rtol=1e-14))


@sheet(
    "OpenStax College Physics, Example 23.12",
    "Z > L, f0 > C, Z > R, I > C",
    {
        "I > C": (
            {"C": 1 / (2 * pi * 10000 * (2 * 2 * pi * 10000 * 3e-3 - 1 / (2 * pi * 10000 * 5e-6)))},
        ),
    },
    Z=190,
    f0=1300,
)
def series_rlc(R, L, C, f, V):
    w = 2 * pi * f
    XL, XC = w * L, 1 / (w * C)
    Z = hypot(R, XL - XC)
    phi = atan((XL - XC) / R)
    return {
        "w": w,
        "XL": XL,
        "XC": XC,
        "Z": Z,
        "I": V / Z,
        "phi": degrees(phi),
        "P": V**2 / Z * cos(phi),
        "f0": 1 / (2 * pi * sqrt(L * C)),
    }


@sheet(
    "Easwarakhanthan et al. 1986, cell of 57 mm at 33 degC",
    "P > Iph, I > V, P > Rs, I > I0",
    P=(0.31126, 3e-4),
)
def solar_cell(Iph, I0, n, Rs, Rsh, T, V):
    Vt = 1.380649e-23 * T / 1.602176634e-19

    def excess(current):
        u = V + current * Rs
        return Iph - I0 * (exp(u / (n * Vt)) - 1) - u / Rsh - current

    current = root(excess, 0, Iph)
    return {"Vt": Vt, "I": current, "P": V * current}


@sheet("IEC 60751", "R > T, R > R0", R=(138.5055, 1e-6))
def pt100(R0, A, B, T):
    return {"R": R0 * (1 + A * T + B * T**2)}


@sheet(
    OWN,
    "V > RL, PL > R1, I > R2, V I > R1 R2, PL > RL",
    {
        "PL > RL": ({"RL": (1000 * 2200 / 3200) ** 2 / 4700},),
    },
)
def voltage_divider(Vs, R1, R2, RL):
    Rp = R2 * RL / (R2 + RL)
    V = Vs * Rp / (R1 + Rp)
    return {"Rp": Rp, "V": V, "I": Vs / (R1 + Rp), "PL": V**2 / RL}


@sheet(OWN, "Ig > R4, Va > R1, Va Vb > R1 R3, Ig > Vs")
def wheatstone(Vs, R1, R2, R3, R4, Rg):
    G = [[1 / R1 + 1 / R2 + 1 / Rg, -1 / Rg], [-1 / Rg, 1 / R3 + 1 / R4 + 1 / Rg]]
    Va, Vb = map(float, np.linalg.solve(G, [Vs / R1, Vs / R3]))
    return {"Va": Va, "Vb": Vb, "Ig": (Va - Vb) / Rg}


@sheet(OWN, "Ra Rb Rc > Rab Rbc Rca, Ra > Rab, Rb > Rca")
def star_delta(Rab, Rbc, Rca):
    total = Rab + Rbc + Rca
    return {"Ra": Rab * Rca / total, "Rb": Rab * Rbc / total, "Rc": Rbc * Rca / total}


def other_capacity():
    """Stored energy at a given time has a maximum over C: the other capacity of the same energy."""

    def energy(C):
        return C * (9 * (1 - exp(-0.6 / (47000 * C)))) ** 2 / 2

    return root(lambda C: energy(C) - energy(1e-5), 1.0165e-5, 1e-3)


@sheet(
    OWN,
    "V > t, I > R, V > C, E > C, E I > Vs R",
    {
        "I > R": (
            {"R": root(lambda R: exp(-6e4 / R) / R - exp(-6e4 / 47000) / 47000, 61000, 1e6)},
        ),
        "E > C": ({"C": other_capacity()},),
    },
)
def rc_charge(Vs, R, C, t):
    V = Vs * (1 - exp(-t / (R * C)))
    return {"tau": R * C, "V": V, "I": (Vs - V) / R, "E": C * V**2 / 2}


@sheet(OWN, "C > pf2, I1 > pf1, Qc > P, I2 C > P pf1")
def power_factor(P, V, f, pf1, pf2):
    Q1, Q2 = P * tan(acos(pf1)), P * tan(acos(pf2))
    C = (Q1 - Q2) * 1e9 / (3 * V**2 * 2 * pi * f)
    return {
        "Q1": Q1,
        "Q2": Q2,
        "Qc": Q1 - Q2,
        "C": C,
        "I1": P * 1000 / (sqrt(3) * V * pf1),
        "I2": P * 1000 / (sqrt(3) * V * pf2),
    }


@sheet(
    OWN,
    "S > X, P pf > R X, I > R, P Q > R X, P > R",
    {
        "P > R": ({"R": 81 / 12},),
    },
)
def three_phase(VL, R, X):
    Z = hypot(R, X)
    current = VL / (sqrt(3) * Z)
    S = sqrt(3) * VL * current
    return {"Z": Z, "I": current, "pf": R / Z, "P": S * R / Z, "Q": S * X / Z, "S": S}


@sheet(
    OWN,
    "reg > Xeq, E2 > S, eta > S, Pcu eta > Req Pfe",
    {
        "eta > S": ({"S": 150 / (0.03 / 0.240**2 * 25)},),
    },
)
def transformer(S, V2, pf, Req, Xeq, Pfe):
    I2 = S * 1000 / V2
    E2 = hypot(V2 * pf + I2 * Req, V2 * sin(acos(pf)) + I2 * Xeq)
    out, Pcu = S * 1000 * pf, I2**2 * Req
    return {"I2": I2, "E2": E2, "reg": E2 / V2 - 1, "Pcu": Pcu, "eta": out / (out + Pfe + Pcu)}


def fast_torque():
    """The smaller load of the same power."""
    P = 0.4 * (24 - 0.42 / 0.06 * 0.5) / 0.06
    return {"TL": root(lambda T: T * (24 - (T + 0.02) / 0.06 * 0.5) / 0.06 - P, 1.0, 2.86)}


@sheet(
    OWN,
    "n > K, P > TL, eta > TL, n I > K T0, w > Ra",
    {
        "P > TL": (fast_torque(),),
        "n > K": ({"K": 0.42 * 0.5 / ((24 - 0.42 / 0.06 * 0.5) / 0.06) / 0.06},),
        "eta > TL": ({"TL": 0.02 * (24 - 3.5) * 0.06 / 0.5 / (0.06 * 7)},),
    },
)
def dc_motor(V, Ra, K, TL, T0):
    current = (TL + T0) / K
    w = (V - current * Ra) / K
    return {
        "I": current,
        "w": w,
        "n": w * 60 / (2 * pi),
        "P": TL * w,
        "eta": TL * w / (V * current),
    }


@sheet(
    "after Chapman, Electric Machinery, the 25 hp motor",
    "T > s, T > R2, Tmax > Xth, n > s",
    {
        "T > R2": ({"R2": (0.59**2 + 1.21**2) * 0.03**2 / 0.33},),
    },
)
def induction_motor(Vth, Rth, Xth, R2, X2, ns, s):
    ws = 2 * pi * ns / 60
    Z = hypot(Rth, Xth + X2)
    T = 3 * Vth**2 * R2 / s / (ws * ((Rth + R2 / s) ** 2 + (Xth + X2) ** 2))
    return {
        "n": (1 - s) * ns,
        "ws": ws,
        "T": T,
        "smax": R2 / Z,
        "Tmax": 3 * Vth**2 / (2 * ws * (Rth + Z)),
    }


@sheet(OWN, "I > Is, Vd > R, Pd > Vs, Vd > n")
def diode_resistor(Vs, R, Is, n, Vt):
    Vd = root(lambda v: Is * (exp(v / (n * Vt)) - 1) * R + v - Vs, 0, 1)
    current = (Vs - Vd) / R
    return {"I": current, "Vd": Vd, "Pd": Vd * current}


@sheet(OWN, "VCE > RE, IC > R1, VC VE > RC RE, VCE > beta", tolerance=1e-7)
def bjt_bias(VCC, R1, R2, RC, RE, VBE, beta):
    VTH, RTH = VCC * R2 / (R1 + R2), R1 * R2 / (R1 + R2)
    IB = (VTH - VBE) / (RTH + (beta + 1) * RE)
    IC, IE = beta * IB, (beta + 1) * IB
    VC, VE = VCC - IC * RC, IE * RE
    return {
        "VTH": VTH,
        "RTH": RTH,
        "IB": IB,
        "IC": IC,
        "IE": IE,
        "VC": VC,
        "VE": VE,
        "VCE": VC - VE,
    }


@sheet(OWN, "i2 > R3, i1 > E1, P2 > E2, i1 i3 > R1 R5, i1 i2 i3 > E1 R3 E2")
def mesh_currents(E1, E2, R1, R2, R3, R4, R5):
    A = [[R1 + R2, -R2, 0], [-R2, R2 + R3 + R4, -R4], [0, -R4, R4 + R5]]
    i1, i2, i3 = map(float, np.linalg.solve(A, [E1, 0, -E2]))
    return {"i1": i1, "i2": i2, "i3": i3, "P2": R2 * (i1 - i2) ** 2}


@sheet(OWN, "P > d, Q1 > V1, P Q2 > d V2, Qloss > X")
def power_transfer(V1, V2, X, d):
    P, c = V1 * V2 / X * sin(radians(d)), V1 * V2 / X * cos(radians(d))
    return {
        "P": P,
        "Q1": V1**2 / X - c,
        "Q2": c - V2**2 / X,
        "Qloss": V1**2 / X + V2**2 / X - 2 * c,
    }


@sheet("the high voltage solution is the operating one", "Vr > Q, loss > P, Vr > X, loss Vr > P Q")
def bus_voltage(Vs, R, X, P, Q):
    b, c = 2 * (P * R + Q * X) - Vs**2, (P**2 + Q**2) * (R**2 + X**2)
    Vr = sqrt((-b + sqrt(b**2 - 4 * c)) / 2)
    current = hypot(P, Q) / (sqrt(3) * Vr)
    return {"Vr": Vr, "I": current, "loss": 3 * current**2 * R}


@sheet(
    "voltages near 1 are the operating ones", "d3 > Q3, V3 > V1, d2 > b13, Q2 > V1, V3 d3 > P2 V2"
)
def load_flow(V1, V2, P2, P3, Q3, b12, b13, b23):
    def rest(state):
        V3, d2, d3 = state
        return [
            V2 * V1 * b12 * sin(d2) + V2 * V3 * b23 * sin(d2 - d3) - P2,
            V3 * V1 * b13 * sin(d3) + V3 * V2 * b23 * sin(d3 - d2) + P3,
            V3 * (V3 * (b13 + b23) - V1 * b13 * cos(d3) - V2 * b23 * cos(d3 - d2)) + Q3,
        ]

    V3, d2, d3 = map(float, fsolve(rest, [1.0, 0.0, 0.0], xtol=1e-13))
    Q2 = V2 * (V2 * (b12 + b23) - V1 * b12 * cos(d2) - V3 * b23 * cos(d2 - d3))
    P1 = V1 * (V2 * b12 * sin(-d2) + V3 * b13 * sin(-d3))
    return {"V3": V3, "d2": degrees(d2), "d3": degrees(d3), "Q2": Q2, "P1": P1}


@sheet(OWN, "V > T, R > T, V > beta, R V > T Rs")
def thermistor(R25, beta, T, Vcc, Rs):
    R = R25 * exp(beta * (1 / (T + 273.15) - 1 / 298.15))
    return {"R": R, "V": Vcc * Rs / (R + Rs)}


@sheet(OWN, "C > R, gain > f, dB > Q, phase > Q, gain phase > f0 Q")
def low_pass(f, f0, Q, R):
    x = f / f0
    gain = 1 / hypot(1 - x**2, x / Q)
    return {
        "C": 1 / (2 * pi * f0 * R),
        "x": x,
        "gain": gain,
        "dB": 20 * log10(gain),
        "phase": -degrees(atan2(x / Q, 1 - x**2)),
    }


@sheet(OWN, "Z0 > D, gam > ZL, Z0 C > er d, SWR > ZL")
def coax(d, D, er, ZL):
    Z0 = 59.96 / sqrt(er) * log(D / d)
    gam = (ZL - Z0) / (ZL + Z0)
    return {
        "Z0": Z0,
        "C": 55.63 * er / log(D / d),
        "v": 299792458 / sqrt(er),
        "gam": gam,
        "SWR": (1 + abs(gam)) / (1 - abs(gam)),
    }


@sheet(
    OWN,
    "P > R, V > r, P I > E R, P > r",
    {
        "P > R": ({"R": 0.2},),
    },
)
def battery_max_power(E, r, R):
    current = E / (R + r)
    return {"I": current, "V": current * R, "P": current**2 * R, "eta": R / (R + r)}


@sheet(OWN, "pct > A, P > I, dV > L, P pct > I V")
def cable_drop(L, I, V, rho, A):  # noqa: E741
    R = 2 * L * rho / A
    return {"R": R, "dV": I * R, "pct": 100 * I * R / V, "P": I**2 * R}


@sheet(OWN, "Vo > Vin, Vo > RL, Pz > Rs, Iz > RL, Vo Pz > Vz RL")
def zener_regulator(Vin, Rs, Vz, rz, RL):
    Vo = (Vin / Rs + Vz / rz) / (1 / Rs + 1 / rz + 1 / RL)
    Iz = (Vo - Vz) / rz
    return {"Vo": Vo, "Iz": Iz, "IL": Vo / RL, "Is": Iz + Vo / RL, "Pz": Vo * Iz}


@sheet(OWN, "I > Vs, V > R, V > Is, rd > T, P > Vs, P rd > Is T")
def diode_loop(Vs, R, Is, n, T):
    Vt = 1.380649e-23 * T / 1.602176634e-19
    V = root(lambda v: Is * (exp(v / (n * Vt)) - 1) * R + v - Vs, 0, 1)
    current = (Vs - V) / R
    return {"Vt": Vt, "I": current, "V": V, "P": V * current, "rd": n * Vt / current}


@sheet(OWN, "Vout > Rf, IL > Vin, Iin > Rin")
def limited_amplifier(Vin, Rin, Rf, Vs, RL):
    G = -Rf / Rin
    Vout = max(-Vs, min(Vs, G * Vin))
    return {"G": G, "Vout": Vout, "IL": Vout / RL, "Iin": Vin / Rin}


@sheet(OWN, "VCE > Vi, P > VCC, P > RB, IC P > Vi RC, VCE IC > beta VCC")
def transistor_switch(Vi, RB, RC, VCC, beta):
    IB = max(0, (Vi - 0.7) / RB)
    IC = min(beta * IB, (VCC - 0.2) / RC)
    VCE = VCC - IC * RC
    return {"IB": IB, "IC": IC, "VCE": VCE, "P": VCE * IC + 0.7 * IB}


@sheet(OWN, "i > t")
def mains(V, R, t):
    v = V * sin(377 * t)
    return {"v": v, "i": v / R}


@sheet(OWN, "Qc > P, C > P, dI > V, phi2 > pf2")
def capacitor_bank(P, pf1, pf2, V, f):
    phi1, phi2 = acos(pf1), acos(pf2)
    Qc = P * (tan(phi1) - tan(phi2))
    return {
        "phi1": degrees(phi1),
        "phi2": degrees(phi2),
        "Qc": Qc,
        "C": Qc * 1000 / (3 * V**2 * 2 * pi * f * 1e-6),
        "dI": P * 1000 / (sqrt(3) * V) * (1 / pf1 - 1 / pf2),
    }


@sheet(OWN, "E > X, delta > X, I > P, E delta > V X, I phi > P pf")
def synchronous(V, X, P, pf):
    I = P / (3 * V * pf)  # noqa: E741
    phi = acos(pf)
    across, along = I * X * pf, V + I * X * sin(phi)
    return {
        "I": I,
        "phi": degrees(phi),
        "E": hypot(across, along),
        "delta": degrees(atan2(across, along)),
    }


@sheet(OWN, "dI > L, D > Vin, Iin > R, Ipk > fs, Iin dI > R L")
def boost_converter(Vin, Vout, fs, L, R):
    D, Iin = 1 - Vin / Vout, Vout**2 / (R * Vin)
    dI = Vin * D / (L * fs)
    return {"D": D, "Iin": Iin, "dI": dI, "Ipk": Iin + dI / 2}


@sheet(OWN, "n0 > Ra, eta > IL0, Eb > Ra, Ia > Rf, Pout n0 > n IL0")
def dc_shunt(V, Ra, Rf, IL, n, IL0):
    field = V / Rf
    Ia, Ia0 = IL - field, IL0 - field
    Eb, Eb0 = V - Ia * Ra, V - Ia0 * Ra
    Pout = Eb * Ia - Eb0 * Ia0
    return {
        "Ifd": field,
        "Ia": Ia,
        "Ia0": Ia0,
        "Eb": Eb,
        "Eb0": Eb0,
        "n0": n * Eb0 / Eb,
        "Pout": Pout,
        "eta": Pout / (V * IL),
    }


@sheet(OWN, "Prefl > P")
def transmission_line(Z0, ZL, P):
    Gam = abs((ZL - Z0) / (ZL + Z0))
    return {
        "Gam": Gam,
        "VSWR": (1 + Gam) / (1 - Gam),
        "RL": -20 * log10(Gam),
        "Prefl": P * Gam**2,
    }


@sheet(OWN, "Vth > V1, IL > RL, Rth > R1, Vth Rth > V1 R1, P > V2")
def thevenin(V1, V2, R1, R2, RL):
    Rth = 1 / (1 / R1 + 1 / R2)
    Vth = (V1 / R1 + V2 / R2) * Rth
    IL = Vth / (Rth + RL)
    return {"Vth": Vth, "Rth": Rth, "IL": IL, "P": IL**2 * RL}


@sheet("Sedra and Smith, chapter 5", "ID > VDS, ID > VGS, ID Vov > VGS kn, P > VDS")
def mosfet(VGS, VDS, Vt, kn, lam):
    Vov = VGS - Vt
    V = min(VDS, Vov)
    ID = kn * (Vov * V - V**2 / 2) * (1 + lam * VDS)
    return {"Vov": Vov, "ID": ID, "P": ID * VDS}


@sheet(OWN, "Vds > Rs, Id > Idss, Vds > Rd")
def jfet_self_bias(Idss, Vp, Rs, Rd, Vdd):
    Id = root(lambda i: Idss * (1 + i * Rs / Vp) ** 2 - i, 0.0, -Vp / Rs)
    return {"Id": Id, "Vgs": -Id * Rs, "Vds": Vdd - Id * (Rd + Rs)}


@sheet(OWN, "I > V, I > Rs, Voc > I0, P > Iph, Voc > Ns")
def module_diode(Iph, I0, n, Ns, Rs, Rsh, Vt, V):
    def excess(u):
        return Iph - I0 * (exp(u / (n * Ns * Vt)) - 1) - u / Rsh

    I = root(lambda i: excess(V + i * Rs) - i, 0, Iph)  # noqa: E741
    return {"I": I, "P": V * I, "Voc": root(excess, 0, 60)}


@sheet(OWN, "pf > kfan")
def motor_fan(VL, f, p, R1, X1, R2, X2, Xm, Prot, kfan):
    """It runs at the speed above that of the largest torque."""
    Vph, ws = VL / sqrt(3), 2 * pi * f / p
    Vth, Rth = Vph * Xm / hypot(R1, X1 + Xm), R1 * (Xm / (X1 + Xm)) ** 2
    X = X1 + X2
    smax = R2 / hypot(Rth, X)

    def gap(s):
        return 3 * Vth**2 / ((Rth + R2 / s) ** 2 + X**2) * R2 / s

    s = root(lambda s: (1 - s) * gap(s) - Prot - kfan * ((1 - s) * ws) ** 3, 1e-9, smax)
    w, Pag = (1 - s) * ws, gap(s)
    rotor = 1j * Xm * (R2 / s + 1j * X2) / (R2 / s + 1j * (X2 + Xm))
    whole = R1 + 1j * X1 + rotor
    Zin = abs(whole)
    I1, pf, Pout = Vph / Zin, whole.real / Zin, kfan * w**3
    return {
        "Vph": Vph,
        "ns": 60 * f / p,
        "ws": ws,
        "s": s,
        "n": (1 - s) * 60 * f / p,
        "w": w,
        "Vth": Vth,
        "Rth": Rth,
        "Xth": X1,
        "I2": sqrt(Pag * s / (3 * R2)),
        "T": Pag / ws,
        "Tl": kfan * w**2,
        "Pag": Pag,
        "Pmech": (1 - s) * Pag,
        "Pout": Pout,
        "Pcu2": s * Pag,
        "smax": smax,
        "Tmax": 3 * Vth**2 / (2 * ws * (Rth + hypot(Rth, X))),
        "Tst": gap(1.0) / ws,
        "Rf": rotor.real,
        "Xf": rotor.imag,
        "Zin": Zin,
        "I1": I1,
        "pf": pf,
        "Pin": 3 * Vph * I1 * pf,
        "eta": Pout / (3 * Vph * I1 * pf),
    }


@sheet(OWN, "vp > f, vp > a, Z > f, delay > f, lg > f, delay vp > L f, vg lam > a f")
def waveguide(a, b, f, L):
    fc, lam = 299.79 / (2 * a), 299.79 / f
    lg = lam / sqrt(1 - (fc / f) ** 2)
    return {
        "fc": fc,
        "lc": 2 * a,
        "lam": lam,
        "lg": lg,
        "vp": 299.79 * lg / lam,
        "vg": 299.79 * lam / lg,
        "Z": 377 * lg / lam,
        "delay": L / (299.79 * lam / lg),
    }
