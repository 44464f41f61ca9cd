"""What all tests share."""

import pytest

from barchain.crossval import suite
from barchain.solutions import reference_runs


@pytest.fixture(autouse=True, scope="session")
def _reference_solutions_without_compiling():
    """Reference solutions by NumPy: compiling a scene's set of effects takes longer than a test's short run."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (reference_runs, suite):
            patch.setattr(module, "solution_engine", lambda: reference_runs.NUMPY)
        yield
