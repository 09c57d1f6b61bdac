"""Tables of others: headers name columns and units; what is wrong with one is a sentence."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from tippetop.errors import InputError
from tippetop.exchange import motion_table
from tippetop.exchange.motion import Convention, motion


def written(folder: Path, text: str) -> Path:
    path = folder / "other.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_units_become_si_and_gaps_stay(tmp_path: Path) -> None:
    text = (
        "# filmed\nt [ms], theta [deg], x [mm], omega3 [rpm]\n0,90,1,60\n\n10,,2,60\n20,45,nan,60\n"
    )
    read = motion_table.read(written(tmp_path, text))
    assert_allclose(read.t, [0, 0.01, 0.02])
    assert_allclose(read.columns["theta"], [np.pi / 2, np.nan, np.pi / 4])
    assert_allclose(read.columns["x"], [1e-3, 2e-3, np.nan])
    assert_allclose(read.columns["omega3"], 2 * np.pi)


def test_a_parquet_file_is_read_as_csv_is(tmp_path: Path) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "other.parquet"
    pq.write_table(pa.table({"t [s]": [0.0, 1.0, 2.0], "theta [deg]": [10.0, None, 20]}), path)
    theta = motion_table.read(path).columns["theta"]
    assert_allclose(theta, [np.pi / 18, np.pi / 9])  # empty rows are left out


OWN = "time,phase,theta,theta_dot,orientation_w,energy,modified_energy,normal_force"


def test_the_export_of_a_run_is_read_by_its_names(tmp_path: Path) -> None:
    """Its phases are words, and its integrals no measurements: both are left out."""
    path = written(tmp_path, f"{OWN}\n0,slip,0.1,0,1,3,3,1\n0.5,roll,4,0,1,3,3,1\n")
    with refusal("in 0 to pi"):
        motion_table.read(path)
    read = motion_table.read(path, wrapped=False)  # as of a cylinder
    assert list(read.columns) == ["t", "theta", "theta_dot", "q_w"]
    assert_array_equal(read.columns["theta"], [0.1, 4.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t, theta\n0,1\n1,1\n", r"`t` must have a unit, such as `t \[s\]`"),
        ("t [s], tetha [deg]\n0,1\n1,1\n", "Did you mean `theta`"),
        ("0,1\n1,1\n", "a header must be names with units"),
        (
            "t [s], theta [m]\n0,1\n1,1\n",
            "unit of `theta` must be rad or of the same kind, but is `m`",
        ),
        ("", "must be a table in CSV or Parquet, but: it is empty"),
        (
            "t [s], theta [rad]\n0,1\n0.2,1\n0.1,1\n",
            r"times must ascend, but that of row 3, 0\.1 s, follows 0\.2 s",
        ),
        ("t [s], theta [rad]\n0,1\n0,1\n", "sort the rows, and keep one of each time"),
        (
            "t [s], theta [rad]\n0,1\nnan,1\n",
            "every row must have a time, but row 2 has a gap there: remove",
        ),
        ("t [s], theta [rad]\n0,1\n", "two rows must have a time and another number, but 1 has"),
        (
            "t [s], theta [rad]\n0,10\n1,170\n",
            r"in 0 to pi, but is 170 rad \(9740\.28 deg\) in row 2",
        ),
        ("t [s] theta [deg]\n0 10\n", "separated by commas, semicolons or tabs"),
        ("frame,theta [deg]\n0,10\n", r"a column `t \[s\]`, but .* divide numbers of frames by"),
        ("t [s],x [px]\n0,1\n1,1\n", "unit of `x` must be made of .*, but has `px`"),
        ("t [s],linear acceleration x (m/s^2)\n0,1\n1,1\n", "are not known: rename them or leave"),
        ("t [s];x [m]\n0;1.5\n1;2,5\n", "line 3, .* but is '2,5': write a decimal point"),
        ("t [s],theta [deg]\n0,0,28,7\n", "has 4: decimal commas must be separated by semicolons"),
        (
            "t [s], theta [rad]\n0,1,1\n1,1,1\n",
            "line 2 must have 2 cells, as the header has, but has 3",
        ),
        (
            "t [s], theta [rad]\n0,1\n1,much\n",
            "line 3, column `theta`: a cell must be a number or a gap .*, but is 'much'",
        ),
    ],
)
def test_wrong_tables_are_rejected_with_a_message(tmp_path: Path, text: str, words: str) -> None:
    with refusal(words):
        motion_table.read(written(tmp_path, text))


NOT_NUMBERS = (
    *("1.#QNAN", "1.#IND", "1.#INF", "-nan(ind)", "#DIV/0!", "1 # one", "1#", "True", "inf"),
    *("-Infinity", "1e999", "1_0", "1,5", "0x1p3", "1 2", "--", "?"),
)


@pytest.mark.parametrize("cell", NOT_NUMBERS)
def test_a_cell_is_a_number_a_gap_or_refused_with_its_place(tmp_path: Path, cell: str) -> None:
    text = f'# a comment\nt [s],theta [rad]\n0,1\n\n0.1,"{cell}"\n0.2,1\n'
    with pytest.raises(InputError) as refused:
        motion_table.read(written(tmp_path, text))
    assert "line 5, column `theta`: a cell must be a number or a gap" in str(refused.value)
    assert f"but is '{cell}'" in str(refused.value)


@pytest.mark.parametrize("cell", ["", " ", "NaN", "-nan", "NA", "N/A", "#N/A", "null", "None", "-"])
def test_documented_gaps_leave_the_rest_of_their_row(tmp_path: Path, cell: str) -> None:
    read = motion_table.read(written(tmp_path, f"t [s],theta [rad],x [m]\n0,1,2\n1,{cell},3\n"))
    assert_array_equal(read.columns["theta"], [1, np.nan])
    assert_array_equal(read.columns["x"], [2, 3])


def test_numbers_are_read_to_their_last_bit(tmp_path: Path) -> None:
    values = np.random.default_rng(5).standard_normal(2000) * 10.0 ** np.arange(-50, 50, 0.05)
    rows = "\n".join(f"{t},{value!r}" for t, value in enumerate(values.tolist()))
    read = motion_table.read(written(tmp_path, f"t [s],x [m]\n{rows}"))
    assert_array_equal(read.columns["x"], values)


ANGLES = ["28.70", "28.10", "", "-1.2E-2"]
DECIMAL = [
    f"{t},{angle}" for t, angle in zip(("0.000", "0.033", "0.067", "0.1"), ANGLES, strict=True)
]


def dialect(header: str, separator: str = ",", decimal: str = ".", gap: str = "") -> str:
    """A table of times and angles as another program writes it."""
    rows = [",".join(cell or gap for cell in row.split(",")) for row in DECIMAL]
    rows = [row.translate({ord(","): separator, ord("."): decimal}) for row in rows]
    return "\n".join([header, *rows])


@pytest.mark.parametrize(
    "content",
    [
        dialect("t [s];theta [deg]", ";", ",").encode(),
        dialect("Masse_A\t\nt (s)\ttheta (°)", "\t", ",").encode(),
        dialect("mass A\nt (s),theta (deg)").encode(),
        dialect("t [s],theta [°]").encode(),
        dialect("t/s;theta/deg", ";", ",").encode(),
        dialect("t [s],theta [deg]").encode("utf-8-sig"),
        dialect("t [s];theta [deg]", ";", ",").replace("\n", "\r\n").encode("utf-8-sig"),
        dialect("t [s]\ttheta [deg]", "\t").replace("\n", "\r\n").encode("utf-16"),
        b"\xfe\xff" + dialect("t [s]\ttheta [deg]", "\t").encode("utf-16-be"),
        dialect("t [s];theta [°]", ";").encode("latin-1"),
        dialect("# Tracker 6.1\n# video: top.mp4\nt [s],theta [deg]").encode(),
        dialect("t [s],theta [deg]", gap="NaN").encode(),
        dialect("t [s],theta [deg]", gap="-").encode(),
        dialect('"Time (s)";"Theta (deg)"', ";", ",").encode(),
        dialect("t,theta\ns,deg").encode(),
        dialect("time\ttheta\n(s)\t(°)", "\t").encode(),
        dialect("sep=;\nt [s];theta [deg]", ";", ",").encode(),
        (dialect("t [s];theta [deg]", ";").replace("\n", ";\n") + ";\n;;\n").encode(),
        b't [s],theta [deg]\n"0,000","28,70"\n"0,033","28,10"\n"0,067",\n"0,1","-1,2E-2"\n',
    ],
)
def test_dialects_of_other_programs_are_the_same_table(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "other.csv"
    path.write_bytes(content)
    read = motion_table.read(path, noise=1.0)
    assert_allclose(read.t, [0, 0.033, 0.1])
    assert_allclose(np.rad2deg(read.columns["theta"]), [28.7, 28.1, -0.012])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"PK\x03\x04\x00\x00", r"it is not a text \(save it as CSV in UTF-8\)"),
        (b"t [s],x [m]\n0,\x81\n", "is not UTF-8"),
        (b"t [s],theta [deg]\n0,1,\n1,2,\n", "must have 2 cells, as the header has, but has 3"),
        (b"t [s],omega3 [min-1]\n0,1\n", "unit of `omega3` must be rad s-1 .*`rpm`.*is `min-1`"),
        (b"t [s],omega3 [1/min]\n0,1\n", "unit of `omega3` must be rad s-1 .*`rpm`.*is `1/min`"),
        (b"Zeit (s);Weg (m)\n0,5;1,5\n", r"the times must be a column `t \[s\]`"),
        (b"mass A\nt,theta\n0,1\n", r"`t` must have a unit, such as `t \[s\]`, but has none\.\n"),
        ("t [s],θ [deg]\n0,1\n".encode(), "columns `θ` are not known: rename them"),
    ],
)
def test_other_dialects_are_refused_in_our_words(
    tmp_path: Path, content: bytes, words: str
) -> None:
    path = tmp_path / "other.csv"
    path.write_bytes(content)
    with refusal(words):
        motion_table.read(path)


TRACKS = (
    "#multi:\tA\tA\tA\tB\tB\tB\nt [s]\tx [m]\ty [m]\tt [s]\tx [m]\ty [m]\n"
    "0\t1\t2\t0\t3\t4\n1\t5\t6\t1\t7\t8\n",
    "#multi:\n,A,,B,\nt (s),x (m),y (m),x (m),y (m)\n0,1,2,3,4\n1,5,6,7,8\n",
)


@pytest.mark.parametrize("text", TRACKS)
def test_one_of_several_objects_is_chosen_by_its_name(tmp_path: Path, text: str) -> None:
    path = written(tmp_path, text)
    for track, x in (("A", [1, 5]), ("B", [3, 7])):
        read = motion_table.read(path, track=track)
        assert_array_equal(read.columns["x"], x)
        assert_array_equal(read.columns["y"], np.array(x) + 1)
    with refusal(r"`track` must be an object of the table \(A, B\), but"):
        motion_table.read(path, track="C")
    with refusal(r"`x` must occur once, .* one of several objects \(`track"):
        motion_table.read(path)


def test_a_file_of_phyphox_is_read_as_it_is(tmp_path: Path) -> None:
    header = [f'"Gyroscope {c} (rad/s)"' for c in "xyz"]
    text = f'"Time (s)",{",".join(header)},"Absolute (rad/s)"\n0,1,2,3,4\n1,1,2,3,4\n'
    read = motion(motion_table.read(written(tmp_path, text)), Convention())
    assert_array_equal(read["gyroscope"][0], [1, 2, 3])
    header = [f"Acceleration {c} (m/s^2)" for c in "xyz"]
    tabs = "\t".join(header)
    text = f"Time (s)\t{tabs}\n0,0\t1,5\t2,0\t3,0\n1,0\t1,5\t2,0\t3,0\n"
    read = motion(motion_table.read(written(tmp_path, text)), Convention())
    assert_array_equal(read["accelerometer"][0], [1.5, 2, 3])


@pytest.mark.parametrize("cells", [[True, False], [1.0, np.inf], ["1", "1.#QNAN"]])
def test_cells_of_parquet_follow_the_same_rule(tmp_path: Path, cells: list) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table({"t [s]": [0.0, 1.0], "theta [rad]": cells}), tmp_path / "a.parquet")
    with refusal(r"row [12], column `theta`: a cell must be a number"):
        motion_table.read(tmp_path / "a.parquet", wrapped=False)


def test_the_order_of_a_numbered_quaternion_is_named_never_guessed(tmp_path: Path) -> None:
    text = "t [s],q_0,q_1,q_2,q_3\n0,0,0,0.6,0.8\n1,0,0,0.6,0.8\n"
    read = motion_table.read(written(tmp_path, text))
    with refusal("--quaternion wxyz or xyzw"):
        motion(read)
    assert_allclose(motion(read, Convention("xyzw"))["orientation"][0], [0.8, 0, 0, 0.6])
    assert_allclose(motion(read, Convention("wxyz"))["orientation"][0], [0, 0, 0.6, 0.8])


def test_a_vertical_y_is_our_z(tmp_path: Path) -> None:
    """Turned about the other's z by 0.3: its axis y tilts towards -x."""
    c, s = np.cos(0.15), np.sin(0.15)
    text = f"t [s],q_w,q_x,q_y,q_z,x [m],y [m],z [m]\n0,{c},0,0,{s},1,2,3\n1,{c},0,0,{s},1,2,3\n"
    seen = motion(motion_table.read(written(tmp_path, text)), Convention(up="y"))
    assert_allclose(seen["theta"], 0.3)
    assert_allclose(seen["place"][0], [3, 1, 2])
    assert_allclose(seen["axis"][0], [0, -np.sin(0.3), np.cos(0.3)], atol=1e-15)


def test_a_row_that_begins_with_a_gap_is_no_comment(tmp_path: Path) -> None:
    table = written(tmp_path, "t [s],theta [rad]\n0,1\n#N/A,1\n0.2,1\n")
    with pytest.raises(InputError):
        motion(motion_table.read(table), Convention())
