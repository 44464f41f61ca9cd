"""The reports: true to the tables, whole in one file, and readable whatever the tables hold."""

from __future__ import annotations

import html
import re
import shutil
from typing import TYPE_CHECKING, Any

import pytest

from reports import render as reports
from reports.chapters.comparison.overview import summary_verdict
from reports.chapters.comparison.summary import WORDS, summarise
from reports.results.comparison import FILES, METRIC_COLUMNS, read_results
from reports.results.outcome import SEVERITY, Outcome
from reports.results.reading import DamagedResultsError
from reports.text.numerals import significant
from tests.support.page_policy import check_policy
from tests.support.report_fixture import ENGINES, build
from tests.support.results import change_record, change_rows, read_record, read_table, write_results
from tests.support.slow import one_in

if TYPE_CHECKING:
    from pathlib import Path

SCENES = ["paper/fig13", "paper/fig17", "basics/kepler_hyperbolic", "basics/two_bars_free"]
MOST_BYTES_PER_SCENE = 8e6 / 14  # the core suite in one mail attachment


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = build(tmp_path_factory.mktemp("results"), SCENES, samples=81)
    reports.render(folder)
    return folder


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A folder with one scene whose tables a test may damage."""
    return build(tmp_path, ["basics/radial_equilibrium"], faults=False, samples=21)


def one_row(outcome: str, **changes: object) -> dict[str, object]:
    row: dict[str, object] = dict.fromkeys(METRIC_COLUMNS)
    row |= {"scene": "s", "engine": f"engine-{outcome}", "setting": "rtol=1e-10", "quantity": "run"}
    value = 1e-9 if outcome == Outcome.PASS else None
    return row | {"metric": "outcome", "value": value, "outcome": outcome} | changes


def write_tables(folder: Path, rows: list[dict[str, object]], record: dict[str, object] | None = None) -> Path:
    return write_results(folder, FILES, {"metrics": rows}, record or {})


def test_the_page_loads_nothing_and_every_link_inside_it_leads_somewhere(made: Path) -> None:
    check_policy(made / "index.html")
    text = (made / "index.html").read_text()
    ids, links = re.findall(r'\sid="([^"]*)"', text), re.findall(r'\s(?:xlink:)?href="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    assert all(link.startswith("#") for link in links)
    assert "@import" not in text
    assert set(re.findall(r"url\((.)", text)) <= {"#"}
    used = {link[1:] for link in links} | set(re.findall(r"url\(#([^)]+)\)", text))
    assert used <= set(ids)


def test_charts_take_their_colours_from_the_page(made: Path) -> None:
    charts = re.findall(r"<svg role.*?</svg>", (made / "index.html").read_text(), flags=re.S)
    assert len(charts) > 8 * len(SCENES)
    for chart in charts:
        assert not re.search(r"#[0-9a-f]{6}\b", chart.replace("url(#", ""))
        assert "NaN" not in chart


def test_the_file_is_small_enough_to_mail(made: Path) -> None:
    assert (made / "index.html").stat().st_size < MOST_BYTES_PER_SCENE * len(SCENES)


def test_a_second_render_from_the_stored_tables_alone_is_the_same_to_the_byte(made: Path, tmp_path: Path) -> None:
    copy = tmp_path / "elsewhere"
    shutil.copytree(made, copy, ignore=shutil.ignore_patterns("index.html", "summary.md"))
    for path in reports.render(copy):
        assert path.read_bytes() == (made / path.name).read_bytes()


def test_only_the_last_section_of_the_markdown_knows_the_clock_and_none_the_order_of_results(small: Path) -> None:
    before = reports.render(small)[1].read_text()
    change_rows(small, lambda rows: rows.iloc[::-1])
    runs = read_record(small)["runs"]
    for run in runs:
        run["seconds"]["simulate"] = 7.77
    change_record(small, created="2031-12-31T00:00:00+00:00", seconds=9.0, runs=runs)
    after = reports.render(small)[1].read_text()
    mark = "## Environment, date and timings"
    assert after.split(mark)[0] == before.split(mark)[0]
    assert after.split(mark)[1] != before.split(mark)[1]


def test_every_outcome_is_shown_with_its_word_and_its_reason(tmp_path: Path) -> None:
    reasons = {outcome: f"because of weather {k}." for k, outcome in enumerate(Outcome)}
    rows = [one_row(outcome, scene=str(outcome), reason=reason) for outcome, reason in reasons.items()]
    folder = write_tables(tmp_path, rows)
    page, text = (html.unescape(path.read_text()) for path in reports.render(folder))
    for outcome, reason in reasons.items():
        for shown in (page, text):
            assert WORDS[outcome] in shown
            assert reason in shown
        assert outcome.advice in page


@pytest.mark.parametrize("outcome", one_in(5, Outcome))
def test_only_a_pass_is_a_good_verdict(outcome: Outcome, tmp_path: Path) -> None:
    folder = write_tables(tmp_path, [one_row(outcome, reason="because of the weather")])
    assert summary_verdict(summarise(read_results(folder))).good is (outcome is Outcome.PASS)


def test_outcomes_are_all_ranked_and_an_unknown_one_is_refused(tmp_path: Path) -> None:
    assert set(SEVERITY) == set(Outcome)
    folder = write_tables(tmp_path, [one_row("pass")])
    change_rows(folder, lambda rows: rows.assign(outcome="splendid"))
    with pytest.raises(DamagedResultsError, match="'splendid' in row 1 is no outcome"):
        reports.render(folder)


def test_a_run_cut_off_says_so_at_the_top(tmp_path: Path) -> None:
    rows = [one_row("pass"), one_row("pass", scene="t", engine="engine-pass")]
    record = {"finished": False, "scenes": {"s": {}, "t": {}, "never": {}}, "engines": {"engine-pass": {}}}
    page, text = (path.read_text() for path in reports.render(write_tables(tmp_path, rows, record)))
    assert page.index("cut off before its end") < page.index('id="verdict"')
    assert text.index("cut off before its end") < text.index("## Verdict")
    assert "1 not run" in text


@pytest.mark.parametrize("record", [{}, {"scenes": {"s": {}}, "engines": None, "runs": [], "misprints": [{}]}])
def test_missing_keys_do_not_stop_a_render(record: dict[str, object], tmp_path: Path) -> None:
    folder = write_tables(tmp_path, [one_row("pass")], record)
    assert all(path.stat().st_size for path in reports.render(folder))


@pytest.mark.parametrize(("tags", "shown"), [(["paper", "chaotic"], True), (["basics"], False)])
def test_the_papers_misprints_stand_only_beside_a_scene_of_the_paper(
    tags: list[str], shown: bool, tmp_path: Path
) -> None:
    record = {"scenes": {"s": {"tags": tags}}, "misprints": [{"place": "(17)", "printed": "a", "right": "b"}]}
    page = reports.render(write_tables(tmp_path, [one_row("pass")], record))[0].read_text()
    assert ("Misprints in the paper" in page) == ("#misprints" in page) == ("(17)" in page) == shown


def test_a_run_without_its_names_stops_a_render(tmp_path: Path) -> None:
    folder = write_tables(tmp_path, [one_row("pass")])
    change_record(folder, runs=[{}])
    with pytest.raises(DamagedResultsError, match="entry runs → 0 → scene is wrong"):
        reports.render(folder)


def test_an_empty_table_is_not_a_success(tmp_path: Path) -> None:
    for path in reports.render(write_tables(tmp_path, [])):
        assert "Nothing was compared." in path.read_text()


def test_a_hostile_title_is_only_text(small: Path) -> None:
    hostile = '<script>alert(1)</script><img src=x onerror="alert(2)"> | $x$ & `co'
    scenes = read_record(small)["scenes"]
    scenes["basics/radial_equilibrium"] |= {"title": hostile, "description": hostile, "source": hostile}
    change_record(small, scenes=scenes, command=hostile, limitations=[hostile])
    change_rows(small, lambda rows: rows.replace({"engine": {"exudyn": hostile}}).assign(reason=hostile))
    page, text = (path.read_text() for path in reports.render(small))
    assert not re.search("<(script|img)", page)
    assert html.escape(hostile, quote=False).split(" onerror")[0] in page
    assert not re.search(r"(?<!\\)<(script|img)", text)
    matrix = text.split("## Matrix")[1].split("## Scenes")[0]
    rows = [line for line in matrix.splitlines() if line.startswith("|")]
    assert len({len(re.findall(r"(?<!\\)\|", line)) for line in rows}) == 1


def test_the_words_of_the_verdict_are_those_of_the_table(made: Path) -> None:
    verdict = summary_verdict(summarise(read_results(made)))
    metrics = read_table(made)
    runs = metrics.groupby(["scene", "engine"])["outcome"].agg(set)
    failed = sum(not outcomes <= {"pass", "reported", "unsupported"} for outcomes in runs)
    left_out = sum(outcomes == {"unsupported"} for outcomes in runs)
    passed = len(runs) - failed - left_out
    outside = sum(o == {"pass", "reported"} and not e.startswith("reference") for (_, e), o in runs.items())
    assert failed == 3
    assert verdict.headline == f"{failed} of {len(runs) - left_out} comparisons failed."
    assert f"{passed} passed ({outside} with independent engines)" in verdict.sentences[0]
    assert f", {failed} failed, {left_out} unsupported." in verdict.sentences[0]
    ratios = metrics[metrics["metric"] == "normalised_error"]
    worst = ratios.loc[ratios["value"].idxmax()]
    assert f"normalised error is {significant(worst['value'])} " in verdict.sentences[1]
    assert f"{worst['engine']} on {worst['scene']}" in verdict.sentences[1]
    page = html.unescape((made / "index.html").read_text())
    assert all(c.reason in page for c in verdict.failures)


def test_a_pass_needs_bound_and_normalised_error(tmp_path: Path) -> None:
    both = {"engine": "e", "quantity": "attitude", "unit": "rad"}
    rows = [
        one_row("pass", **both | {"metric": "max", "value": 2e-7, "tolerance": 1e-6}),
        one_row("inconsistent", **both | {"metric": "normalised_error", "value": 41.0, "tolerance": 1.0}),
    ]
    folder = write_tables(tmp_path, rows)
    verdict = summary_verdict(summarise(read_results(folder)))
    assert not verdict.good
    assert verdict.headline == "1 of 1 comparison failed."
    assert "normalised error 41.0" in reports.render(folder)[1].read_text()


def test_a_scene_that_no_engine_could_do_spoils_the_verdict(tmp_path: Path) -> None:
    rows = [one_row("pass", engine="e"), one_row("unsupported", engine="e", scene="lonely")]
    verdict = summary_verdict(summarise(read_results(write_tables(tmp_path, rows))))
    assert not verdict.good
    assert any("lonely" in s for s in verdict.sentences)
    assert verdict.sentences[0] == "Of 2 scenes × 1 engine: 1 passed, 0 failed, 1 unsupported."


def test_a_row_without_its_value_shows_nan(tmp_path: Path) -> None:
    row = one_row("not_finite", engine="e", quantity="attitude", metric="max", unit="rad")
    folder = write_tables(tmp_path, [row])
    line = next(t for t in reports.render(folder)[1].read_text().splitlines() if "| attitude |" in t)
    assert line.split(" | ")[4:7] == ["NaN", "", ""]


def test_a_chart_marks_the_predictability_limit_of_the_reference_solution(small: Path) -> None:
    page, text = (path.read_text() for path in reports.render(small))
    assert ">predictability limit</text>" not in page
    assert "Solution valid: to the end of the run" in text
    record = read_record(small)
    scene = record["scenes"]["basics/radial_equilibrium"]
    scene["solution_limit_s"] = 0.4 * scene["duration_s"]
    change_record(small, scenes=record["scenes"])
    page, text = (path.read_text() for path in reports.render(small))
    assert "Solution valid: to 0.40 of 1 orbits" in text
    assert page.count(">predictability limit</text>") == 2  # in both components of the reactions, over the whole run
    scene["period_s"] = 10.0 * scene["duration_s"]
    change_record(small, scenes=record["scenes"])
    text = reports.render(small)[1].read_text()
    assert f"Solution valid: to {scene['solution_limit_s']:.4g} of {scene['duration_s']:.4g} s" in text


def test_a_prescribed_rotation_is_shown_beside_the_torque_that_causes_it(made: Path) -> None:
    page = (made / "index.html").read_text()
    assert "Torque on bar 5</figcaption>" in page
    figures = re.findall(r"<figure>.*?</figure>", page, flags=re.S)
    attitudes = [f for f in figures if "Attitude from the chain&#39;s local horizontal</figcaption>" in f]
    assert any("bar 5" in re.findall(r"</svg>([^<]+)</li>", f) for f in attitudes), "the bar that is turned"


def test_the_chart_of_independent_engines_shows_them_alone(small: Path) -> None:
    page = reports.render(small)[0].read_text()
    figures = re.findall(r"<figure>.*?</figure>", page, flags=re.S)
    (shown,) = [f for f in figures if "independent engines</figcaption>" in f]
    independent = [e for e in ENGINES if not e.startswith("reference") and e != "rebound"]
    assert re.findall(r"</svg>([^<]+)</li>", shown) == ["judging solution", *independent]
    change_record(small, engines={e: {"external": False} for e in ENGINES})
    assert "independent engines</figcaption>" not in reports.render(small)[0].read_text()


def test_where_a_comparison_stops_early_the_whole_row_shows_the_first_orbit(tmp_path: Path) -> None:
    def rows(engine: str, limit_s: float, first: float | None) -> list[dict[str, object]]:
        both = {"engine": engine, "quantity": "attitude", "unit": "rad", "limit_s": limit_s}
        made = [one_row("pass", **both | {"metric": "max", "value": 0.01, "tolerance": 1.0})]
        return made + ([one_row("reported", **both | {"metric": "first_orbit_max", "value": first})] if first else [])

    record = {"scenes": {"s": {"period_s": 100.0, "duration_s": 500.0, "gravity": "point", "speed_factor": 1.0}}}
    table = [*rows("whole", 500.0, 1e-9), *rows("early", 276.0, 1e-5), *rows("sooner", 62.0, 0.009)]
    text = reports.render(write_tables(tmp_path, table, record))[1].read_text()
    assert "1.00×10⁻⁵ rad; to 2.76 orbits |" in text
    assert "0.0100 rad; to 0.62 orbits |" in text
    assert "1.00×10⁻⁹ rad; to the end |" in text
    text = reports.render(write_tables(tmp_path, rows("whole", 500.0, 1e-9), record))[1].read_text()
    assert "| s | pass; 0.0100 rad |" in text


def test_a_scene_without_an_independent_engine_spoils_the_verdict(tmp_path: Path) -> None:
    def verdict(record: dict[str, Any]) -> Any:
        return summary_verdict(summarise(read_results(write_tables(tmp_path, rows, record))))

    rows = [one_row("pass", scene=s, engine=e) for s, e in (("s", "reference"), ("s", "theirs"), ("t", "reference"))]
    rows.append(one_row("unsupported", scene="t", engine="theirs"))
    engines = {"reference": {"external": False}, "theirs": {"external": True}}
    found = verdict({"engines": engines})
    assert not found.good
    assert found.headline == "All 3 comparisons passed, but no independent engine passed on scene t."
    assert "3 passed (1 with independent engines)" in found.sentences[0]
    alike = {"scenes": {"s": {"same_equations": ["theirs"]}, "t": {}}}
    assert "1 of these on the judging solution's equations" in verdict({"engines": engines} | alike).sentences[0]
    alone = {"reference": {"external": False}, "theirs": {"external": False}}
    assert "No independent engine passed on any scene." in verdict({"engines": alone}).sentences
    assert verdict({}).good, "a record that does not tell whose work the engines are is no ground for a failure"


def test_a_row_about_several_engines_is_no_engine(tmp_path: Path) -> None:
    rows = [one_row("pass", engine="reference"), one_row("nothing_compared", engine="(any independent engine)")]
    summary = summarise(read_results(write_tables(tmp_path, rows)))
    assert summary.engines == ("reference",)
    assert not summary_verdict(summary).good


def test_a_scene_that_no_independent_engine_supports_says_so(tmp_path: Path) -> None:
    rows = [one_row("pass", engine="reference"), one_row("unsupported", engine="theirs", reason="theirs has no shadow")]
    record: dict[str, Any] = {"engines": {"reference": {"external": False}, "theirs": {"external": True}}}

    def said(**carriers: Any) -> str:
        known = {"external_coverage": carriers} if carriers else {}
        page, text = reports.render(write_tables(tmp_path, rows, record | {"scenes": {"s": known}}))
        return page.read_text() + " ".join(text.read_text().split())

    own = "Of the selected engines only those built on barchain’s equations support"
    lack = {"theirs": ["shadow"]}
    stopped = {"engines": ["theirs"], "at_s": [100.0], "run": {"duration_s": 5500.0, "samples": 111}}
    assert said().count(f"{own} this scene.") == 2  # on the page, and in the text
    for words, carriers in {
        "the effects. Support its effects, and not selected: heyoka.": {
            "lack": lack,
            "not_requested": ["heyoka"],
        },
        "and not installed (barchain engines --missing): heyoka.": {"lack": lack, "not_installed": ["heyoka"]},
        "The adapter of heyoka does not load (ImportError: no llvm).": {
            "not_loaded": {"heyoka": "ImportError: no llvm"}
        },
        "An independent derivation, computed with heyoka, is stored": {"solution": "real128"},
        "discontinuous at t = 100 s, which is neither a sample nor the middle between": {"instants": stopped},
    }.items():
        assert said(**carriers).count(words) == 2
    assert "duration_s = 5500.0 and samples = 111" in said(instants=stopped)
    rows.append(one_row("pass", engine="others"))
    record["engines"] |= {"others": {"external": True}}
    assert own not in said()


def test_many_scenes_that_no_independent_engine_passed_are_counted(tmp_path: Path) -> None:
    engines = {"ours": {"external": False}, "theirs": {"external": True}}
    rows = [one_row("pass", scene=s, engine="theirs" if s == "-" else "ours") for s in "abcdefg-"]
    verdict = summary_verdict(summarise(read_results(write_tables(tmp_path, rows, {"engines": engines}))))
    assert "no independent engine passed on 7 scenes (a, b, c and 4 more)" in verdict.headline


def test_effects_conserved_quantities_and_the_gradients_defect_are_among_a_scenes_facts(tmp_path: Path) -> None:
    defect = {"energy": 3e-11, "angular_momentum": 2e-11, "size_squared": 2.2e-10}
    scene = {"effects": ["drag in 6e-11 kg/m³"], "conserved": "angular momentum", "gradient_defect": defect}
    scene |= {"model_difference": {"com_m": 0.056, "note": "a chain is no particle"}}
    text = reports.render(write_tables(tmp_path, [one_row("pass")], {"scenes": {"s": scene}}))[1].read_text()
    assert "- Effect: drag in 6×10⁻¹¹ kg/m³" in text
    assert "- Conserved: angular momentum" in text
    assert "relative to the totals, of order (l/r)², 2.2" in text
    assert "Model difference" not in text, "no engine without attitude ran"
    only_com = [one_row("pass", quantity="com")]
    text = reports.render(write_tables(tmp_path, only_com, {"scenes": {"s": scene}}))[1].read_text()
    assert "- Model difference: 0.0560 m in the CM: a chain is no particle" in text
