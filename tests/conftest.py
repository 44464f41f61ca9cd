"""What all tests share."""

import pytest

from barchain import suite, truth_runs


@pytest.fixture(autouse=True)
def _reference_solutions_without_compiling(monkeypatch):
    """Reference solutions by NumPy: compiling a scene's set of effects takes longer than a test's short run."""
    for module in (truth_runs, suite):
        monkeypatch.setattr(module, "truth_engine", lambda: truth_runs.NUMPY)
