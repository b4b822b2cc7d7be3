"""A large block with tangents for its exponentials, which follow the iteration at their own pace.

Newton's method on an exponential that a step has led far up comes down by 1 in its argument each time. Here a
rise of the argument by d moves the point of tangency up by ln(1 + d) alone, to where the exponential is what
the tangent has promised: the limits of junction voltages of circuit simulators (L. W. Nagel, *SPICE2*, 1975).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from functools import partial

import numpy as np

from rulesheets.evaluate import slopes_by_name
from rulesheets.syntax.nodes import ONE, ZERO, Call, Name, add, exchange, multiply, names, negative
from rulesheets.syntax.program import walk
from solver.kernel.emitter import SparseSystem, compile_expressions
from solver.numerics.linear_algebra import Array

TOUCHING = 1e-6
"""How far a tangent's point may be from an argument: what the tangent leaves out is its square."""


class Tangents:
    """The ``system`` with tangents; ``follow`` moves their points to a point of the unknowns.

    ``some``: whether there is an exponential with unknowns in it.
    """

    def __init__(self, system: SparseSystem, known: Sequence[float]) -> None:
        self.known = np.array(known, dtype=float)
        self.system = copy(system)
        self.system.shapes = [copy(shape) for shape in system.shapes]
        self._arguments = []
        for shape in self.system.shapes:
            moving = {f"#{k}" for k, _ in shape.moving}
            calls = dict.fromkeys(
                part
                for part in walk(shape.form)
                if isinstance(part, Call) and part.function == "exp" and not moving.isdisjoint(names(part))
            )
            if not calls:
                continue
            count, arguments = len(shape.numbers), list(shape.arguments)
            inside = [call.arguments[0] for call in calls]
            self._arguments.append((shape, shape.compiled(inside), count))
            for number, (call, argument) in enumerate(zip(calls, inside, strict=True)):
                point = Name(f"#.{count + number}")
                arguments.append(point.name)
                tangent = multiply(Call("exp", (point,)), add(ONE, argument, negative(point)))
                shape.form = exchange(shape.form, call, tangent)
            shape.numbers = np.concatenate([shape.numbers, np.zeros((len(inside), len(shape.rows)))])
            shape.compiled = partial(compile_expressions, arguments=arguments, arrays=True)
            slopes = slopes_by_name(shape.form, moving)
            shape._residual = shape.compiled([shape.form])
            shape._partials = shape.compiled([slopes.get(f"#{k}", ZERO) for k, _ in shape.moving])

    @property
    def cancels(self) -> bool:
        """Whether 1 is taken from exponentials that may be next to it."""
        return any(shape.cancels for shape in self.system.shapes)

    @property
    def some(self) -> bool:
        return bool(self._arguments)

    def follow(self, x: Array) -> Array:
        """The point (n,) itself, to which the tangents have moved on."""
        for numbers, at in self._points(x):
            with np.errstate(all="ignore"):
                numbers[:] = np.where(at > numbers, numbers + np.log1p(at - numbers), at)
        return x

    def touch(self, x: Array) -> bool:
        """Whether every tangent touches its exponential at the point: no exponential is still far above."""
        return all((np.abs(at - numbers) <= TOUCHING).all() for numbers, at in self._points(x))

    def _points(self, x: Array) -> Iterator[tuple[Array, Array]]:
        """The arguments at which the tangents touch, and those at the point."""
        everything = np.concatenate([x, self.known])
        for shape, arguments, count in self._arguments:
            with np.errstate(all="ignore"):
                at = arguments(*everything[shape.places], *shape.numbers[:count])
            yield shape.numbers[count:], np.stack(np.broadcast_arrays(*at))
