"""Solutions of a chaotic and of a regular scene, and runs of them."""

import pytest

from tests.judge.trust_cases import lasting
from tests.support.solutions import run, solution_of


@pytest.fixture(scope="session")
def chaotic():
    """Three orbits of the horizontal chain: at this setting its attitude can be predicted for about one."""
    return solution_of(lasting("paper/fig05", 3.0, 121))


@pytest.fixture(scope="session")
def unmodified(chaotic):
    return run(chaotic.scene, 1e-8), run(chaotic.scene, 1e-9)


@pytest.fixture(scope="session")
def steep():
    return solution_of(lasting("paper/fig15", 0.3, 61))
