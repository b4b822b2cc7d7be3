"""How a numerical method ended: a value whose text is a sentence, never an exception."""

from __future__ import annotations

from enum import Enum


class Outcome(Enum):
    """The end of a search. Only ``CONVERGED`` stands for an isolated answer correct to rounding."""

    CONVERGED = "The residual vanishes to rounding at an isolated point."
    NO_ROOT = "It is proven that the range holds no root."
    SINGULAR_JACOBIAN = (
        "The residual vanishes to rounding, but the Jacobian loses rank there: "
        "the answer is not isolated, or it is a multiple one."
    )
    STALLED = "No step makes the residual smaller, and it does not vanish."
    LIMIT = "The limit on iterations was reached before the residual vanished."
    DOMAIN = "The residual or its Jacobian is undefined at the start or at the point approached."

    def __str__(self) -> str:
        return self.value

    @property
    def found(self) -> bool:
        """Whether the residual vanishes to rounding at the point returned."""
        return self in (Outcome.CONVERGED, Outcome.SINGULAR_JACOBIAN)
