"""JUnit XML of a night: a suite for each engine, a case for each scene, failures for what is worse."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from junitparser import Error, Failure, JUnitXml, Skipped, TestCase, TestSuite

from barchain.nightly.figures.changes import result_words
from reports.results.nights.document import PartState, ratio_words
from reports.results.writing import write_atomically
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from barchain.nightly.figures.figure import Figure
    from reports.results.nights.document import ChangeEntry, NightlyFile

    Told = tuple[ChangeEntry, str]


NIGHT, PLAN = "barchain nightly", "plan"
NO_ENGINE, NO_SCENE = "all engines", "all scenes"
FAILING = {
    "worse": {"worse"}, "changed": {"worse", "better", "changed"}, "not-pass": {"worse"}, "never": set[str](),
}  # fmt: skip
"""Directions of changes that fail a case, by `--fail-on`"""
UNSUPPORTED = "unsupported"


def write_junit(
    path: Path, facts: NightlyFile, figures: Iterable[Figure], fail_on: str = "worse", *, need_history: bool = False
) -> None:
    """Write the JUnit XML of a night.

    Parameters
    ----------
    path : Path
    facts : NightlyFile
    figures : iterable of Figure
        Of the night: each engine and scene with figures is a case.
    fail_on : str
        ``worse``, ``changed``, ``not-pass`` or ``never``.
    need_history : bool
        Whether it is an error that there is nothing to compare with.

    Raises
    ------
    OSError
        If the file can't be written.
    """
    document = JUnitXml(NIGHT)
    document.add_testsuite(plan_suite(facts, Error if FAILING[fail_on] else Skipped, need_history=need_history))
    cells, rejected = by_engine(figures), {(r.engine, r.scene): r.words for r in facts.rejected}
    changes: dict[tuple[str, str], list[Told]] = defaultdict(list)
    for relation, entries in (("may be", facts.standing), ("was", facts.other_news)):  # nothing need have measured it
        for change in entries:
            changes[change.engine or NO_ENGINE, change.scene or NO_SCENE].append((change, relation))
            cells[change.engine or NO_ENGINE].setdefault(change.scene or NO_SCENE, [])
    for engine in sorted(cells):
        suite = TestSuite(engine)
        for scene, own in sorted(cells[engine].items()):
            case = cell_case(engine, scene, own, changes[engine, scene], FAILING[fail_on])
            if (engine, scene) in rejected:
                case.system_out = plain_text(rejected[engine, scene])
                if fail_on == "not-pass" and not case.is_failure:
                    case.result = [Failure(plain_text(rejected[engine, scene]), "not passed")]
            suite.add_testcase(case)
        suite.update_statistics()  # type: ignore[no-untyped-call]
        document.add_testsuite(suite)
    document.update_statistics()  # type: ignore[no-untyped-call]
    root = ElementTree.fromstring(document.tostring())  # type: ignore[no-untyped-call]
    root.attrib.pop("skipped", None)  # which the schema of Jenkins does not know here
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, "utf-8", xml_declaration=True)
    write_atomically(path, text + b"\n")


def by_engine(figures: Iterable[Figure]) -> dict[str, dict[str, list[Figure]]]:
    """Figures by engine and scene."""
    found: dict[str, dict[str, list[Figure]]] = defaultdict(lambda: defaultdict(list))
    for figure in figures:
        found[figure.identity.engine or NO_ENGINE][figure.identity.scene or NO_SCENE].append(figure)
    return found


def plan_suite(facts: NightlyFile, fault: type[Error | Skipped] = Error, *, need_history: bool = False) -> TestSuite:
    """Suite of the parts of the plan.

    A void or incomplete night, a baseline without a common figure, and a part that failed or was left, are errors; with
    `--fail-on never` they are skipped.
    """
    suite = TestSuite(PLAN)
    parts_s = sum(part.duration_s for part in facts.run.parts) if facts.run else 0.0
    night = TestCase("night", PLAN, round(max(facts.night.duration_s - parts_s, 0.0), 3))  # the rest: times add up
    if facts.night.void:
        night.result = [fault(plain_text(facts.night.void), "void")]
    parts = facts.run.parts if facts.run else ()
    if facts.night.state == "incomplete" and all(part.whole for part in parts):
        night.result = [fault("the night is incomplete", "incomplete")]
    if facts.against.baseline and not facts.counts.judged:
        night.result = [fault(plain_text(f"{facts.against.baseline} has no figure of this night"), "not compared")]
    night.system_out = plain_text("\n".join(filter(None, [facts.sentence, facts.left_out_words])))
    if not facts.compared and need_history and not night.result:
        night.result = [fault(plain_text(facts.sentence), "not compared")]
    suite.add_testcase(night)
    for part in parts:
        case = TestCase(part.name, PLAN, round(part.duration_s, 3))
        if not part.whole:
            left = f"; left: {', '.join(part.left)}" if part.left else ""
            kind = "bad input" if part.bad_input else "missing" if part.state is PartState.DONE else part.state
            case.result = [fault(plain_text(f"{part.reasons or part.state}{left}"), kind)]
        suite.add_testcase(case)
    suite.update_statistics()  # type: ignore[no-untyped-call]
    return suite


def cell_case(
    engine: str, scene: str, figures: Sequence[Figure], changes: Sequence[Told], failing: set[str]
) -> TestCase:
    """Case of one engine in one scene: a failure for its changes, skipped if the engine does not support the scene."""
    case = TestCase(scene, engine)
    told = [one for one in changes if one[0].direction in failing and one[0].accepted is None]
    if told:
        case.result = [failure(told)]
    elif figures and all(figure.missing or figure.word == UNSUPPORTED for figure in figures):
        reason = next((figure.reason for figure in figures if figure.reason), result_words(figures[0]))
        case.result = [Skipped(plain_text(reason))]
    return case


def failure(changes: Sequence[Told]) -> Failure:
    """One failure for all changes of a case: readers of JUnit count failures and cases alike."""
    (first, relation), *others = changes
    more = sum(1 + change.also for change, _ in others)
    found = Failure(plain_text(failure_words(first, relation, more)), first.direction)
    found.text = plain_text("\n".join(failure_words(*one) for one in changes))
    return found


def failure_words(change: ChangeEntry, relation: str, others: int = 0) -> str:
    """Change in one line, perhaps with the number of other figures that changed."""
    factor = f" ({ratio_words(change.factor)}{change.steps_words})" if change.factor else ""
    unmeasured = f", not measured since {change.measured}" if change.measured else ""
    more = f", and {change.also} more of this run" if change.also else ""
    beside = f" and {plural(others, 'more figure')}" if others else ""
    moved = change.never_words or f"{relation} {change.was}, is {change.became}"
    suspects = f"; suspects: {change.suspect_words}" if change.suspect_words else ""
    return f"{change.figure}: {moved}{factor}{beside} since {change.since}{unmeasured}{more}{suspects}"


def plain_text(text: str) -> str:
    """Text of characters that XML takes."""
    return "".join(c if c.isprintable() or c in "\n\t" else "?" for c in text)
