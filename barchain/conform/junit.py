"""JUnit XML of an examination: a suite for each engine, a case for each check."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from junitparser import Failure, JUnitXml, Skipped, TestCase, TestSuite

from barchain.conform.checks import Check, CheckState, Group
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.conform.checks import ConformanceReport

PAGE = "docs/howto/conform.md"


def write_junit(path: Path, reports: Iterable[ConformanceReport]) -> None:
    """Write the JUnit XML of examinations.

    Raises
    ------
    OSError
        If the file can't be written.
    """
    document = JUnitXml("barchain conform")
    for report in reports:
        suite = TestSuite(report.engine)
        for check in report.checks:
            suite.add_testcase(case(report.engine, check))
        if not report.passed and not report.failures:
            said = f"{report.verdict}: no scene was passed"
            verdict = Check("verdict", CheckState.FAILED, said, PAGE, group=Group.PHYSICS)
            suite.add_testcase(case(report.engine, verdict))
        suite.update_statistics()  # type: ignore[no-untyped-call]
        document.add_testsuite(suite)
    document.update_statistics()  # type: ignore[no-untyped-call]
    root = ElementTree.fromstring(document.tostring())  # type: ignore[no-untyped-call]
    root.attrib.pop("skipped", None)  # which the schema of Jenkins does not know here
    write_atomically(path, ElementTree.tostring(root, "utf-8", xml_declaration=True))


def case(engine: str, check: Check) -> TestCase:
    """Case of one check: a failure, skipped if it was not run or is not supported."""
    made = TestCase(check.name, f"{engine}.{check.group}", round(check.seconds, 3))
    if check.state is CheckState.FAILED:
        made.result = [Failure(printable(f"{check.words} ({check.page})"), "failed")]
    elif check.state in {CheckState.UNSUPPORTED, CheckState.NOT_RUN}:
        made.result = [Skipped(printable(check.words))]
    elif check.state is CheckState.WARNING:
        made.system_out = printable(check.words)
    return made


def printable(text: str) -> str:
    """Text of characters that XML takes."""
    return "".join(c if c.isprintable() else "?" for c in text)
