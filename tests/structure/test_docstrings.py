"""Cross-references in docstrings lead somewhere."""

from __future__ import annotations

import pytest

from tests.structure.product import PACKAGES, python_files, relative
from tests.structure.roles import resolves, roles


@pytest.mark.parametrize("package", [*PACKAGES, "tests", "benchmarks"])
def test_every_role_in_a_docstring_names_something_that_exists(package: str) -> None:
    lost = [
        f"{relative(path)}:{number}: {target}"
        for path in python_files(package)
        for number, target in roles(path)
        if not resolves(target, path)
    ]
    assert not lost, "\n".join(lost)
