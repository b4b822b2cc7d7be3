"""The door to scipy.sparse.csgraph, for graphs on which plain Python would be slow.

scipy takes longer to import than a graph of some ten thousand nodes takes to search, so it is
imported when the first large graph comes.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any


def strong_components(successors: Sequence[Sequence[int]]) -> list[int]:
    """A label for every node, equal for nodes that reach one another; the labels mean nothing else."""
    from scipy.sparse.csgraph import connected_components

    graph = _graph(successors)
    labels: list[int] = connected_components(graph, directed=True, connection="strong")[1].tolist()
    return labels


def _graph(rows: Sequence[Sequence[int]]) -> Any:
    import numpy
    from scipy.sparse import csr_matrix

    starts = numpy.zeros(len(rows) + 1, dtype=numpy.int32)
    numpy.cumsum([len(row) for row in rows], out=starts[1:])
    targets = numpy.fromiter(chain.from_iterable(rows), dtype=numpy.int32, count=int(starts[-1]))
    ones = numpy.ones(len(targets), dtype=numpy.int8)
    return csr_matrix((ones, targets, starts), shape=(len(rows), len(rows)))
