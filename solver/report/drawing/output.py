"""A drawn page as the bytes of a file."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DATES: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
"""What would make two files of one picture differ."""


def encode(figure: Figure, form: str, dpi: float) -> bytes:
    """The page as ``png``, ``svg`` or ``pdf``: the same bytes for the same picture."""
    import matplotlib

    file = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "backsolve"}):
        figure.savefig(file, format=form, dpi=dpi, metadata=_DATES[form])
    return file.getvalue()
