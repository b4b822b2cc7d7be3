"""Names of variables as LaTeX: ``omegaAB`` is omega with the index AB."""

from __future__ import annotations

import re

_GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu"),
    *("nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
)
_CAPITALS = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Phi", "Psi", "Omega")
_STEM = "|".join(sorted((*_GREEK, *_CAPITALS), key=len, reverse=True))

_GREEK_NAME = re.compile(rf"({_STEM})_?(|[A-Z0-9_].*)")
_LETTER_NAME = re.compile(r"([A-Za-z])_?([A-Z0-9][A-Za-z0-9_]*|_.+)", re.ASCII)
_COORDINATE = re.compile(r"([xyz])([a-z]\d*)", re.ASCII)
_NUMBERED = re.compile(r"([A-Za-z]{2,})_?(\d+)", re.ASCII)


def latex_name(name: str) -> str:
    r"""LaTeX of a variable's full name.

    >>> latex_name("omegaAB"), latex_name("thetaAO"), latex_name("xa11"), latex_name("offset")
    ('\\omega_{AB}', '\\theta_{AO}', 'x_{a11}', '\\mathrm{offset}')
    """
    *scope, local = name.split(".")
    prefix = "".join(rf"\text{{{_plain(part)}.}}" for part in scope)
    return prefix + _local(local)


def _local(name: str) -> str:
    if greek := _GREEK_NAME.fullmatch(name):
        return "\\" + greek[1] + _index(greek[2])
    if len(name) == 1:
        return name
    if name.isupper() and name.isalpha():
        return rf"\mathit{{{name}}}"
    for pattern in (_COORDINATE, _LETTER_NAME):
        if parts := pattern.fullmatch(name):
            return parts[1] + _index(parts[2])
    if numbered := _NUMBERED.fullmatch(name):
        return rf"\mathrm{{{numbered[1]}}}" + _index(numbered[2])
    return rf"\mathrm{{{_plain(name)}}}"


def _index(text: str) -> str:
    index = _plain(text.strip("_"))
    return f"_{{{index}}}" if index else ""


def _plain(text: str) -> str:
    return text.replace("_", r"\_").replace("#", r"\#")
