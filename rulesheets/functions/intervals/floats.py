"""The range of every function of the table over one box of floats, by name."""

from rulesheets.functions.intervals.forms import unknown
from rulesheets.functions.row import Forms
from rulesheets.functions.table import TABLE

FLOAT_INTERVALS = Forms(TABLE, lambda row: unknown if row.interval is None else row.interval)
