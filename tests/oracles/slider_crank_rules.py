"""The paper's three subsheets as equations over bare names, transcribed by hand from the figures.

Each is (guard, left, right) in Python syntax, to be evaluated by ``random_sheets.evaluated``.
"""

from __future__ import annotations

_HORIZONTAL = "(thetaAB == 0 or thetaAB == 180 or thetaAB == 360)"

RULES: tuple[tuple[str | None, str, str], ...] = (
    (None, "yB", "offset"),
    (None, "xA", "AO*cosd(thetaAO)"),
    (None, "yA", "AO*sind(thetaAO)"),
    ("branch == 'open'", "xB - xA", "sqrt(AB**2 - (yB - yA)**2)"),
    ("branch != 'open'", "xB - xA", "-sqrt(AB**2 - (yB - yA)**2)"),
    (None, "thetaAB", "atan2d(yA - yB, xA - xB)"),
    (None, "m1", "tand(thetaAB)"),
    (None, "m2*m1", "-1"),
    (None, "vA", "omegaAO*AO"),
    (None, "xa", "vA*cosd(thetaAO + 90)"),
    (None, "ya", "vA*sind(thetaAO + 90)"),
    (None, "yb", "0"),
    (_HORIZONTAL, "xb", "xa"),
    (f"not {_HORIZONTAL}", "ya - yb", "m2*(xa - xb)"),
    (None, "vAB", "sqrt((xa - xb)**2 + (ya - yb)**2)"),
    (None, "vB", "xb"),
    ("xB >= xA and ya >= 0", "vAB", "-omegaAB*AB"),
    ("xB <= xA and ya <= 0", "vAB", "-omegaAB*AB"),
    ("xB >= xA and ya <= 0", "vAB", "omegaAB*AB"),
    ("xB <= xA and ya >= 0", "vAB", "omegaAB*AB"),
    (None, "aAt", "alphaAO*AO"),
    (None, "aAn", "omegaAO**2*AO"),
    (None, "aBAn", "omegaAB**2*AB"),
    (None, "yb1", "0"),
    (None, "xa11", "aAn*cosd(thetaAO + 180)"),
    (None, "ya11", "aAn*sind(thetaAO + 180)"),
    (None, "xa1", "xa11 + aAt*cosd(thetaAO + 90)"),
    (None, "ya1", "ya11 + aAt*sind(thetaAO + 90)"),
    (None, "xb11", "xa1 + aBAn*cosd(thetaAB)"),
    (None, "yb11", "ya1 + aBAn*sind(thetaAB)"),
    (_HORIZONTAL, "xb1", "xb11"),
    (f"not {_HORIZONTAL}", "yb1 - yb11", "m2*(xb1 - xb11)"),
    (None, "aB", "xb1"),
    (None, "aBAt", "sqrt((xb1 - xb11)**2 + (yb1 - yb11)**2)"),
    ("yb1 >= yb11 and xB >= xA", "aBAt", "alphaAB*AB"),
    ("yb1 <= yb11 and xB <= xA", "aBAt", "alphaAB*AB"),
    ("yb1 <= yb11 and xB >= xA", "aBAt", "-alphaAB*AB"),
    ("yb1 >= yb11 and xB <= xA", "aBAt", "-alphaAB*AB"),
)
