"""The catalogue of diagnoses: every code with its title, its usual cause and its cure.

E1 syntax, E2 names and calls, E3 files, E4 variable sheets, command input and units, W6
warnings about units; the outcomes of a solve, S5,
are in ``solver.catalogue``. A code never changes its meaning; one that is not used any more is not given
away again.
"""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry
from rulesheets.catalogue.files import FILES
from rulesheets.catalogue.inputs import INPUTS
from rulesheets.catalogue.names import NAMES
from rulesheets.catalogue.requests import REQUESTS
from rulesheets.catalogue.syntax import SYNTAX
from rulesheets.catalogue.units import UNITS

CATALOGUE: dict[str, Entry] = {**SYNTAX, **NAMES, **FILES, **INPUTS, **REQUESTS, **UNITS}
