"""Units that are unknown or do not fit: E460 to E462, and the warnings of the check, W601 to W603."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

UNITS: dict[str, Entry] = {
    "E460": Entry(
        "an unknown unit",
        "A unit is a name such as mm, psi or degC, or a product of powers of names such as W/m^2-K.",
        "Correct the name. The extra units knows more names than the common ones.",
    ),
    "E461": Entry(
        "a value in a unit that does not fit",
        "A value is converted to the unit of its variable, so both must measure the same kind of quantity.",
        "Give the value in a unit of that kind, or leave the unit out.",
    ),
    "E462": Entry(
        "a unit that cannot be defined",
        "Every unit has one definition, and m, kg, s, A, K, mol, cd and rad are what all others build on.",
        "Choose another name.",
    ),
    "W601": Entry(
        "the units of a rule do not fit",
        "What is equated or added has one unit; logarithms and exponents take numbers.",
        "Correct the rule or a unit, or write the factor between the units.",
    ),
    "W602": Entry(
        "an angle in another unit",
        "sin, cos and tan take radians; sind, cosd and tand take degrees.",
        "Use the function for the unit of the angle.",
    ),
    "W603": Entry(
        "a temperature on a scale whose zero is not absolute zero",
        "A product or a power needs an absolute temperature or a difference: 20 °C is not twice 10 °C.",
        "Write T + 273.15, or give the variable in K. A difference of temperatures may be in K, too.",
    ),
}
