"""Every template of the report compiles: no filter or tag is unknown, also in chapters that no test renders."""

import pytest

from reports.chapters.crossval.report import report_templates
from reports.page import templates


@pytest.mark.parametrize("name", [t for t in templates().list_templates() if t.endswith(".j2")])
def test_a_template_compiles_with_the_filters_of_its_page(name: str) -> None:
    made = report_templates() if name.startswith("crossval/") else templates()
    assert made.get_template(name).name == name
