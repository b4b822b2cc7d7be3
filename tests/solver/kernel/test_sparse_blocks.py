"""Blocks of many unknowns, beside a sparse Newton by hand; and where there is no answer."""

from __future__ import annotations

import numpy as np
import pytest

import rulesheets
import solver
from benchmarks.networks import Network, bratu, pipes, plate, radiation

NETWORKS = [pipes(5), radiation(60), plate(7), plate(7, 0.02), plate(19), bratu(120)]


@pytest.mark.parametrize("network", NETWORKS, ids=lambda network: network.title)
def test_the_first_answer_is_that_of_a_newton_by_hand(network: Network) -> None:
    result = solver.solve(rulesheets.loads(network.sheet))
    assert str(result.status) == "solved"
    expected = network.by_hand()
    got = np.array([result[name] for name in network.names])
    assert np.abs(got - expected).max() <= 1e-9 * np.abs(expected).max()


def test_a_list_of_one_answer_does_not_claim_to_be_complete() -> None:
    result = solver.solve(rulesheets.loads(bratu(120).sheet))
    assert not result.complete
    assert [note.code for note in result.gaps] == ["S594"]


def test_a_large_linear_block_has_one_answer() -> None:
    assert solver.solve(rulesheets.loads(plate(19).sheet)).complete


def test_a_guess_leads_to_the_upper_answer() -> None:
    network = bratu(120)
    x = np.arange(1, 121) / 121
    guesses = dict(zip(network.names, (4 * 2.9 * x * (1 - x)).tolist(), strict=True))
    result = solver.solve(rulesheets.loads(network.sheet), guesses=guesses)
    u = np.array([result[name] for name in network.names])
    residual, jacobian = network.system(u)
    assert u.max() > 2.0
    assert np.abs(residual).max() <= 1e-7 * abs(jacobian).tocsr().max()


def test_no_answer_beyond_the_turning_point() -> None:
    result = solver.solve(rulesheets.loads(bratu(120, 4.0).sheet), timeout=5.0)
    assert str(result.status) in ("failed", "infeasible")


def test_a_large_singular_linear_block_is_not_solved() -> None:
    n = 320
    rules = [f"x{i} - x{(i + 1) % n} + 0*x{(i + 7) % n} = 0" for i in range(n)]
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"), timeout=5.0)
    assert str(result.status) != "solved"
