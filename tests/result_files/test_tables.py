"""Tables as programs write them: dialects that are read to the same numbers, and others that get one readable line."""

import gzip
import random

import numpy as np
import pytest

from barchain import load_scene
from barchain.result_files.channels import read_channels
from barchain.result_files.instants import SAME_ROW
from barchain.result_files.table import TableError

SCENE = load_scene("basics/two_bars_free")
TIMES = [0.0, 10.0, 20.0, 30.0]
ANGLES = [[-1.5707963267948966, -0.8726646259971648], [-1.5118768420532955, -0.9897848224804805],
          [-1.4497480088688637, -1.1121110933159839], [-1.3851364941494413, -1.2385789957327686]]  # fmt: skip
ROWS = [[f"{t:.0f}", *map(repr, row)] for t, row in zip(TIMES, ANGLES, strict=True)]
DEGREES = [[f"{t:.0f}", *(repr(float(np.degrees(a))) for a in row)] for t, row in zip(TIMES, ANGLES, strict=True)]
HEADER = ["t_s", "angle_1_rad", "angle_2_rad"]
OPEN_SIM = "Coordinates\nversion=1\nnRows=4\nnColumns=3\ninDegrees={}\n\nUnits are S.I. units\n\nendheader\n"
GMAT = ["01 Jan 2000 11:59:28.000", "01 Jan 2000 11:59:38.000", "01 Jan 2000 11:59:48.000", "01 Jan 2000 11:59:58.000"]


def table(header=HEADER, rows=ROWS, sep=",", end="\n"):
    return "".join(sep.join(row) + end for row in ([header] if header else []) + rows)


def with_times(times, rows=ROWS):
    return [[str(t), *row[1:]] for t, row in zip(times, rows, strict=True)]


def fixed(header, rows, width, align):
    return "".join("".join(align(cell, width) for cell in row) + "\n" for row in [header, *rows])


def with_single(digits):
    return [
        [t, *(f"{float(np.float32(a)):.{digits}g}" for a in row)] for (t, *_), row in zip(ROWS, ANGLES, strict=True)
    ]


DAYS = [f"{k * 10 / 86400:.18f}"[:18] for k in range(4)]
TOUCHING = [[date, days, *row[1:]] for date, days, row in zip(GMAT, DAYS, DEGREES, strict=True)]
FORTRAN = [[c if c == "0" else f"{float(c):.17E}".replace("E", "D") for c in row] for row in ROWS]
CLOCK = ["23:59:30.0", "23:59:40.0", "23:59:50.0"]
BY_DAYS = {"t [d]": "Sat.ElapsedDays", "angle_1 [deg]": "angle_1", "angle_2 [deg]": "angle_2"}
BY_DATE = {"t": "Sat.UTCGregorian", "angle_1 [deg]": "angle_1", "angle_2 [deg]": "angle_2"}
GMAT_HEADER = ["Sat.UTCGregorian", "Sat.ElapsedDays", "angle_1", "angle_2"]
EXTRA = [[*row, text] for row, text in zip(ROWS, ["on", "", "1.#QNAN", "x" * 200_000], strict=True)]
DIALECTS = {
    "braces of Trick": table(["time {s}", "angle_1 {rad}", "angle_2 {rad}"]),
    "units after a slash": table(["time/s", "angle_1/deg", "angle_2/deg"], DEGREES),
    "units after a comma": table(['"time, s"', '"angle_1, deg"', '"angle_2, deg"'], DEGREES),
    "units after _": table(["t_s", "angle_1_deg", "angle_2_deg"], DEGREES),
    "units after a blank": table(["time s", "angle_1 deg", "angle_2 in deg"], DEGREES),
    "units in capitals": table(["TIME [SEC]", "ANGLE_1 [DEG]", "ANGLE_2 [DEG]"], DEGREES),
    "a row of units": table(["t", "angle_1", "angle_2"], [["s", "deg", "deg"], *DEGREES]),
    "a row of units, none given": table(["t", "angle_1", "angle_2"], [["-", "", "rad"], *ROWS]),
    "OpenSim in degrees": OPEN_SIM.format("yes") + table(["time", "angle_1", "angle_2"], DEGREES, "\t"),
    "OpenSim in radians": OPEN_SIM.format("no") + table(["time", "angle_1", "angle_2"], ROWS, "\t"),
    "Excel's line with the separator": "sep=;\r\n" + table(sep=";", end="\r\n"),
    "decimal commas of Excel": table(sep=";").replace(".", ","),
    "decimal commas in quotation marks": table(rows=[[f'"{c.replace(".", ",")}"' for c in row] for row in ROWS]),
    "decimal commas between blanks": table(sep="  ").replace(".", ","),
    "lines that end as on old Macs": table(end="\r"),
    "lines that end in all ways": table()[:40].replace("\n", "\r\n") + table()[40:],
    "separators at the ends of rows": table(HEADER, [[*row, ""] for row in ROWS], ";"),
    "separators at all ends": table([*HEADER, ""], [[*row, "", ""] for row in ROWS]),
    "quoted names": table([f'"{name}"' for name in HEADER]),
    "an index of pandas": table(["", *HEADER], [[str(k), *row] for k, row in enumerate(ROWS)]),
    "names of rows of R": table([f'"{n}"' for n in HEADER], [[f'"{k}"', *row] for k, row in enumerate(ROWS, 1)], " "),
    "Fortran's exponents": "# t_s angle_1_rad angle_2_rad\n" + table(None, FORTRAN, "  "),
    "exponents without a letter": table([*HEADER, "gap_1_m"], [[*row, "3.2148753691024587-104"] for row in ROWS], " "),
    "U+2212": table().replace("-", "−"),
    "blanks that break no line": table(rows=[["\u00a0" + cell + "\u2009" for cell in row] for row in ROWS]),
    "line separators of Unicode as ends of lines": table(end="\u2028"),
    "a line separator of Unicode in a cell": table(rows=[[cell + "\u2028" for cell in row] for row in ROWS]),
    "comments of MATLAB": "% made by hand\n% t_s angle_1_rad angle_2_rad\n" + table(None, sep=" "),
    "comments of Fortran": "! t_s angle_1_rad angle_2_rad\n" + table(None, sep=" "),
    "a row of units, unknown ones among them": table(
        ["t", "angle_1", "angle_2", "p"], [["s", "deg", "deg", "Pa"], *([*row, "1"] for row in DEGREES)]
    ),
    "quotation marks of Python": table([f"'{name}'" for name in HEADER]),
    "months between blanks": table(rows=with_times(GMAT), sep="  "),
    "months of MATLAB": table(rows=with_times([date.replace(" ", "-", 2) for date in GMAT])),
    "dates with slashes": table(rows=with_times([f"2026/03/01 12:00:{s}" for s in (10, 20, 30, 40)])),
    "a report of STK": "Satellite-1: Angles\n\n"
    + table(["Time (UTCG)", "angle_1 (rad)", "angle_2 (rad)"], [["----", "---", "---"], *with_times(GMAT)], "    "),
    "names with blanks": table(["Time (s)", "Angle 1 (rad)", "Angle 2 (rad)"], sep=";"),
    "names without _": table(["time", "angle1", "angle2"]),
    "elements of an array, Modelica": table(["time", "angle[1]", "angle[2]"]),
    "a row of units as a comment": "# t angle_1 angle_2\n# [s] [deg] [deg]\n" + table(None, DEGREES, " "),
    "a row of units above the names": "s,deg,deg\n" + table(["t", "angle_1", "angle_2"], DEGREES),
    "names that are numbers": table(["t", "angle_1", "angle_2", "0", "1"], [[*row, "7", "8"] for row in ROWS]),
    "bars between cells": table(sep="|"),
    "a table of Markdown": table(["", *HEADER, ""], [["---"] * 5, *(["", *row, ""] for row in ROWS)], " | "),
    "a start before 0 by a rounding": table(rows=[["-1e-15", *ROWS[0][1:]], *ROWS[1:]]),
    "a title above the header": "Results of run 5\n\n" + table(),
    "a rule below the header": table(sep="  ").replace("\n", "\n------  ------  ------\n", 1),
    "a header between tabs of rows between blanks": "t_s\tangle_1_rad\tangle_2_rad\n" + table(None, sep="  "),
    "text and faults in a column that is not judged": table([*HEADER, "note"], EXTRA),
    "equal rows at an event": table(rows=[ROWS[0], *[ROWS[1]] * 3, *ROWS[2:], ROWS[3]]),
    "nanoseconds": table(["time [ns]", *HEADER[1:]], with_times([0, 10**10, 2 * 10**10, 3 * 10**10])),
    "microseconds, Greek": table(["time [μs]", *HEADER[1:]], with_times([0, 10**7, 2 * 10**7, 3 * 10**7])),
    "milliseconds": table(["t_ms", *HEADER[1:]], with_times([0, 10_000, 20_000, 30_000])),
    "dates": table(rows=with_times([*(f"2026-03-01T{time}Z" for time in CLOCK), "2026-03-02T00:00:00.0Z"])),
    "days of the year": table(rows=with_times([f"2026-060T12:00:{s}.5" for s in ("10", "20", "30", "40")])),
    "clocks": table(rows=with_times(["00:00:00", "00:00:10", "00:00:20", "00:00:30"])),
    "dates and times between blanks": table(
        ["time", *HEADER[1:]], with_times([f"2026-03-01 12:00:{s}" for s in (10, 20, 30, 40)]), "  "
    ),
}  # fmt: skip
MAPPED = {
    "columns that touch, by days": (fixed(GMAT_HEADER, TOUCHING, 26, str.ljust), BY_DAYS),
    "columns that touch, by dates": (fixed(GMAT_HEADER, TOUCHING, 26, str.ljust), BY_DATE),
    "columns that end below their names": (fixed(HEADER, ROWS, 19, str.rjust), {}),
    "a unit in the column's own name": (
        table(["Zeit", "phi [deg]", "psi {deg}"], DEGREES), {"t": "1", "angle_1": "2", "angle_2": "3"}
    ),
}  # fmt: skip


def read(tmp_path, text, mapping=None, encoding="utf-8"):
    path = tmp_path / "run.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return read_channels(path, SCENE, mapping or {})


def check_same(found):
    assert found.t_s == pytest.approx(TIMES, rel=1e-12, abs=1e-5)
    for name, right in zip(("angle_1", "angle_2"), np.transpose(ANGLES), strict=True):
        assert found.values[name] == pytest.approx(right, rel=4e-16, abs=0)
        assert np.all(found.half_units[name] <= 1e-14)


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS)
def test_a_dialect_is_read_to_the_numbers_of_the_plain_table(tmp_path, text):
    check_same(read(tmp_path, text))


@pytest.mark.parametrize(("text", "mapping"), MAPPED.values(), ids=MAPPED)
def test_a_table_of_fixed_width_or_of_other_names_is_read_with_a_mapping(tmp_path, text, mapping):
    check_same(read(tmp_path, text, mapping))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_encodings_and_compression_change_no_number(tmp_path, encoding):
    text = table(["t_s", "angle_1 [°]", "angle_2 [°]"], DEGREES)
    check_same(read(tmp_path, text, encoding=encoding))
    check_same(read(tmp_path, gzip.compress(text.encode(encoding))))


REFUSED = {
    "thousands": (
        table(sep=";").replace("20;", "20'000;"),
        r"line 4 \(row 3\), column 't_s': .* has thousands separators"
    ),
    "thousands or decimals": ("t_s;angle_1\n1,250;2,125\n2,250;3,125\n", "decimal comma, or separators of thousands"),
    "points and commas": ("t_s;angle_1\n1.25;2,5\n2.25;3,5\n", "has a comma, and '.*' a point"),
    "decimal commas between commas": (
        "t_s,angle_1_rad\n0,0,0,5\n1,0,0,6\n",
        "2 names for 4 columns; if it has decimal commas"
    ),
    "a field of Fortran that is too narrow": (table(rows=[ROWS[0], ["10", "******", "1.0"]]), "does not fit its field"),
    "digits of another script": (table(rows=[ROWS[0], ["10", "1.١٢", "1.0"]]), "a digit of another script, U\\+0661"),
    "underscores": (table(rows=[ROWS[0], ["10", "1_000", "1.0"]]), "thousands separators"),
    "complex numbers": (table(rows=[ROWS[0], ["10", "1+2i", "1.0"]]), "is a complex number"),
    "a quotation mark that is open": (table(rows=[*ROWS[:2], ["20", '"1.0', "1.0"]]), "a quotation mark is not closed"),
    "a cell beyond all numbers": (
        table(rows=[*ROWS[:2], ["20", "1" * 200_000 + "x", "1.0"]]),
        "a cell of 200001 characters",
    ),
    "a number beyond all physics": (table(rows=[*ROWS[:2], ["20", "1e200", "1.0"]]), "has the run diverged"),
    "no finite number": (
        table(rows=[*ROWS[:2], ["20", "-1.#IND", "1.0"]]),
        r"line 4 \(row 3\): angle_1 is no finite number"
    ),
    "a blank": (table(rows=[*ROWS[:2], ["20", "", "1.0"]]), r"line 4 \(row 3\): angle_1 is no finite number"),
    "columns at the end that are empty from a row on": (
        table(rows=[ROWS[0], *([row[0], "", ""] for row in ROWS[1:])]),
        r"line 3 \(row 2\): angle_1 is no finite number"
    ),
    "a named column of blanks": (table(rows=[[*row[:2], ""] for row in ROWS]), r"line 2 .*: angle_2 is no finite"),
    "a row that is cut": (table() + "40,1.0\n", "line 6 has 2 values for 3 columns"),
    "times that fall": (table(rows=[*ROWS, ROWS[1]]), r"line 6 \(row 5\): the times do not rise"),
    "times of few digits": (
        table(rows=with_times(["0.01", "0.01", "0.02", "0.03"])),
        "lines 2 and 3 have one time.*write more digits"
    ),
    "rows of one instant that differ": (
        table(rows=with_times(["0", "100.0", "100.0", "200.0"])),
        "lines 3 and 4 .* at an event"
    ),
    "instants that a double can't tell apart": (
        table(rows=with_times(["0", "5e-324", "10", "20"])),
        "lines 2 and 3 have one time"
    ),
    "an unknown unit": (table(["t_s", "angle_1 [furlong]", "angle_2"]), "the unit furlong given"),
    "a unit of a huge power": (table(["t_s", "angle_1 [deg^-9999 rad^10000]", "angle_2"]), "powers up to 3"),
    "a name in a row of units": (
        table(["t", "angle_1", "angle_2"], [["s", "xyz", "deg"], *ROWS]),
        "the unit xyz given"
    ),
    "days before months, or after": (
        table(rows=with_times(["01/02/2026 12:00:00", "01/02/2026 12:00:10", "", ""])),
        "no date such as",
    ),
    "more lines than a table has": ("1\n" * 1_000_001, "has 1000002 lines"),
    "a line below the table": (table() + "end of file\n", "line 6 has 1 value for 3 columns"),
    "columns that touch": (
        table(["x y z"], [[f"{float(c):.3f}-100.5" for c in row] for row in ROWS], ""),
        "where columns touch",
    ),
    "no names": (table(None), "has no header; name its columns"),
    "names of another program": (
        table(["timestamp", "value1", "value2"]),
        "has timestamp, value1, value2; name it: --column"
    ),
    "nothing": ("\n;;\n", "has no rows"),
    "a spreadsheet": ("PK\x03\x04\0\0", "is a spreadsheet"),
    "JSON of columns": ('{"t_s": [0, 1], "angle_1_rad": [0, 1]}', "is JSON; write the table as CSV"),
    "no text": ("MATLAB 5.0\0\0", r"run\.csv is no text"),
    "no times": (table(["angle_3", *HEADER[1:]]), "has no column t_s or time"),
    "times alone": (table(["t_s"], [row[:1] for row in ROWS]), "has no channel beside the time"),
    "a word": (table(rows=[["0", "abc", "1.0"], *ROWS[1:]]), r"line 2 \(row 1\), column 'angle_1_rad': 'abc' is no"),
    "a slip in a name": (table(["t_s", "angel_1_rad", "angle_2"]), "has no angle_1, but a column 'angel_1_rad'"),
    "a name that goes on": (table(["t_s", "angle_1_radx", "angle_2"]), r"rename it, e.g. to angle_1 \[rad\]"),
    "bars from 0": (table(["t_s", "angle_0", "angle_1"]), "numbers bars from 0; allowed: from 1"),
    "more bars": (table(["t_s", "angle_2", "angle_3"]), "has 3 bars, the scene basics/two_bars_free 2"),
    "a date of another form": (table(rows=with_times(["2026-03-01T12:00:00", "2026-03-01T12:00:10", "noon", ""])),
                               r"line 4 \(row 3\), column 't_s': 'noon' is no date"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_a_table_that_can_not_be_read_gets_one_readable_line(tmp_path, text, said):
    with pytest.raises(TableError, match=said) as raised:
        read(tmp_path, text)
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) < 1000


def test_lines_about_thousands_of_columns_and_long_names_are_cut(tmp_path):
    many = [f"column_{k}_{'x' * 300}" for k in range(2000)]
    with pytest.raises(TableError) as raised:
        read(tmp_path, table(many, [["1"] * 2000]))
    assert len(str(raised.value)) < 2500
    found = read(tmp_path, table([*HEADER, *many], [[*row, *["1"] * 2000] for row in ROWS]))
    assert len(", ".join(found.ignored)) < 2500


@pytest.mark.parametrize("header", [f"x{' ' * 100_000}[m", "(" * 100_000, f"angle_1 [{'deg ' * 50_000}]"])
def test_a_header_of_any_length_is_read_at_once(tmp_path, header):
    assert read(tmp_path, table([*HEADER, header], [[*row, "1"] for row in ROWS])).t_s[-1] == 30.0


@pytest.mark.parametrize("digits", [17, 12])
def test_single_precision_has_an_error_bar_of_its_own_however_many_digits_are_written(tmp_path, digits):
    found = read(tmp_path, table(rows=with_single(digits)))
    assert any("single precision in angle_1, angle_2" in note for note in found.notes)
    half_unit = 0.5 * np.spacing(np.float32(1.4))
    assert found.half_units["angle_1"] == pytest.approx(half_unit, rel=1e-6)
    assert not any("single" in note for note in read(tmp_path, table()).notes)


def test_single_precision_is_known_by_as_few_digits_as_programs_write_of_it(tmp_path):
    angles = np.linspace(0.1, 1.4, 80).astype(np.float32)
    rows = [[repr(10.0 * k), np.format_float_positional(a), "7697.078125"] for k, a in enumerate(angles)]
    found = read(tmp_path, table(["t_s", "angle_1 [rad]", "com_vy [m/s]"], rows))
    assert any("single precision in angle_1, com_vy" in note for note in found.notes)
    assert np.array_equal(found.values["angle_1"], angles.astype(float))
    written = 0.5e-8  # eight digits below 1
    assert found.half_units["angle_1"] == pytest.approx(np.maximum(0.5 * np.spacing(angles), written), rel=1e-6)
    assert found.half_units["com_vy"] == pytest.approx(0.5 * np.spacing(np.float32(7697.0)), rel=1e-6)


def test_a_column_of_one_value_is_exact_beside_numbers_in_full(tmp_path):
    rows = [[repr(10.0 * k), repr(0.1 + k / 30.0), "7697.078125"] for k in range(40)]
    found = read(tmp_path, table(["t_s", "angle_1 [rad]", "com_vy [m/s]"], rows))
    assert found.half_units["com_vy"].max() < 1e-11


def test_of_rows_at_an_event_that_differ_the_first_shows_the_motion_before_it(tmp_path):
    scene = load_scene("effects/impulse")
    at = scene.effects.breaks_s[0]
    rows = [["0", "1.0"], [repr(at), "2.0"], [repr(at), "2.5"], [repr(at + 10.0), "3.0"]]
    (tmp_path / "run.csv").write_text(table(["t_s", "rate_1"], rows))
    found = read_channels(tmp_path / "run.csv", scene, {})
    assert list(found.values["rate_1"]) == [1.0, 2.0, 3.0]
    assert any(note.startswith("1 row of the motion after an event not judged") for note in found.notes)
    rows[2][1] = repr(2.0 * (1.0 + SAME_ROW / 10.0))
    (tmp_path / "run.csv").write_text(table(["t_s", "rate_1"], rows))
    assert any("left out" in note for note in read_channels(tmp_path / "run.csv", scene, {}).notes)


def test_half_a_unit_in_the_last_place_follows_what_a_column_shows(tmp_path):
    def half(*texts):
        rows = [[str(k), text] for k, text in enumerate(texts)]
        return list(read(tmp_path, table(["t", "angle_1"], rows, ";")).half_units["angle_1"])

    assert half("0.25", "0.3", "1.5") == pytest.approx([0.005, 0.005, 0.05])
    assert half("1.234e-3", "5.6e2") == pytest.approx([5e-7, 0.05])
    assert half("12345.6", "0.00123456") == pytest.approx([0.05, 5e-9])
    assert half("0", "7") == pytest.approx([0.5, 0.5])


PIECES = (
    '"', ",", ";", "\t", "\n", "\r", "\0", "e", "E+", "-", "−", "1e400", "nan", "1.#INF", "*****", "[", "]", "{",
    "(", "#", "\u2028", "\u0661", "\ufeff", "0" * 400, "5e-324", "deg^99", "°", "2026-01-01T00:00:00", "12:00:00", "=",
    "3*1",
)  # fmt: skip


def mutated(text, draw):
    """Text with a few faults of the kinds that files have."""
    for _ in range(draw.randint(1, 6)):
        at = draw.randrange(len(text) + 1)
        text = {
            "insert": text[:at] + draw.choice(PIECES) * draw.choice((1, 1, 2, 200)) + text[at:],
            "cut": text[:at] + text[at + draw.randint(1, 30) :],
            "double": text[:at] + text[max(0, at - 40) :],
            "end": text[: max(at, 1)],
        }[draw.choice(("insert", "insert", "insert", "cut", "double", "end"))]
    return text


@pytest.mark.parametrize("count", [100, pytest.param(3000, marks=pytest.mark.exhaustive)])
def test_a_mutated_table_is_read_or_gets_one_line(tmp_path, count):
    draw, texts, said = random.Random(59), [*DIALECTS.values()], []
    for _ in range(count):
        try:
            read(tmp_path, mutated(draw.choice(texts), draw))
        except TableError as error:
            said.append(str(error))
    assert 0 < len(said) < count
    assert not any("\n" in line for line in said)
    assert max(map(len, said)) < 3000
