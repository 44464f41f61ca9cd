"""Files of engines that a command names stay with their test: the command hands them to its processes by a variable."""

import pytest

from adapters.command.entries import FILES


@pytest.fixture(autouse=True)
def no_files_of_engines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Begin without a file of engines, and leave none."""
    monkeypatch.setenv(FILES, "")
