"""Tables of measures as people have them: right numbers, a question where units are unclear, and what is left."""

from __future__ import annotations

import csv
import io
import json
import math

import pytest
import yaml
from garmentq.core.body.measure_names import MEASURE_KINDS, Quantity, find_measures
from garmentq.core.body.measure_table import MeasuresBad, MeasuresUnclear, read_measure_table
from garmentq.core.body.measure_values import read_value
from garmentq.core.body.measures_file import read_measures, read_table_text
from hypothesis import given, settings
from hypothesis import strategies as st

ANNA = {"height": 1.70, "bust": 0.92, "waist": 0.74, "hip": 1.0}

PERSONS = {
    "value with unit": "gender,female\nheight,170 cm\nbust,92 cm\nwaist,74 cm\nhip,100 cm\n",
    "unit in the name": "gender,female\nheight [cm],170\nbust (cm),92\nwaist_cm,74\nhip in mm,1000\n",
    "tab": "gender\tfemale\nheight\t170\nbust\t92\nwaist\t74\nhip\t100\n",
    "bar": "gender|female\nheight|170\nbust|92\nwaist|74\nhip|100\n",
    "girth words": "gender,female\nheight,170\nbust girth,92\nwaist circumference,74\ngirth of the hip,100\n",
    "semicolon and comma": "gender;female\nheight;170,0\nbust;92,0\nwaist;74\nhip;100\n",
    "mark and CRLF": "\ufeffName,Value\r\nGender,Female\r\nHeight,170\r\nBust,92\r\nWaist,74\r\nHips,100\r\n",
    "wide": "gender,height,bust,waist,hips\nfemale,170,92,74,100\n",
    "unit column": "measure,value,unit\ngender,female,\nheight,1.7,m\nbust,92,cm\nwaist,740,mm\nhip,100,cm\n",
    "unit key": '{"unit":"cm","gender":"female","height":170,"bust":92,"waist":74,"hips":100}',
    "nested": '{"measurements":{"gender":"female","height":170,"bust":92,"waist":74,"hips":100}}',
    "metres": '{"gender":"female","height":1.70,"bust":0.92,"waist":0.74,"hips":1.00}',
    "millimetres": '{"gender":"female","height":1700,"bust":920,"waist":740,"hips":1000}',
    "height in metres": "gender,female\nheight,1.70\nbust,92\nwaist,74\nhip,100\n",
    "German": "Geschlecht;weiblich\nKörpergröße;170\nBrustumfang;92\nTaillenumfang;74\nHüftumfang;100\n",
    "German, one line": "Geschlecht;Größe;Oberweite;Taille;Hüftweite\nFrau;170;92;74;100\n",
    "French": "sexe;femme\nstature;170\ntour de poitrine;92\ntour de taille;74\ntour de hanches;100\n",
    "French, taille": "sexe;femme\ntaille;170\ntour de poitrine;92\ntour de taille;74\ntour de bassin;100\n",
    "Italian": "sesso,donna\naltezza,170\ncirconferenza seno,92\ncirconferenza vita,74\nfianchi,100\n",
    "Spanish": "sexo,mujer\nestatura,170\ncontorno de pecho,92\ncontorno de cintura,74\ncaderas,100\n",
    "YAML": "gender: female # of Anna\nbody:\n  height: 170\n  bust: 92.0\n  waist: '74'\n  hips: 100\n",
}


@pytest.mark.parametrize("form", PERSONS)
def test_a_person_in_every_form(form):
    """Broken where a separator, a unit's place, a language or a form of file gives other numbers, or is refused."""
    (row,) = read_measure_table(PERSONS[form]).rows
    assert row.gender == "female" and row.measures == pytest.approx(ANNA)


def test_feet_and_inches():
    """Broken where a height in feet and inches, or a mark of inches, is a fault."""
    (row,) = read_measure_table('name,value\ngender,female\nheight,5\'6"\nbust,36"\nwaist,28 1/2 in\nhip,38½″\n').rows
    found = {"height": 66 * 0.0254, "bust": 36 * 0.0254, "waist": 28.5 * 0.0254, "hip": 38.5 * 0.0254}
    assert row.measures == pytest.approx(found)
    assert read_value("5 ft 6 in") == read_value('66"') and read_value("5'13\"") is None


@pytest.mark.parametrize(
    "text",
    ["name,bust,waist,hip,height\nS,34,27,37,66\n", "gender,female\nbust,56\nwaist,50\n", '{"bust": 40, "waist": 30}'],
)
def test_inches_are_asked_about(text):
    """Broken where lengths that may be inches are read as centimetres, or the other way about, without a word."""
    with pytest.raises(MeasuresUnclear, match="--units") as error:
        read_measure_table(text)
    assert "inch: bust" in error.value.message and "cm: bust" in error.value.message
    inches = read_measure_table(text, "inch").rows[0].measures["bust"]
    assert inches == pytest.approx(0.0254 * float("".join(c for c in text.split("bust")[1] if c in "34056789 ")[:3]), 9)


SIZES = {
    "mark": "\ufeffname,bust,waist,hip,height\nS,88,70,96,168\nM,92.5,74,100,168\n",
    "chest": "size,chest,waist,hip,height\nS,88,70,96,168\nM,92.5,74,100,168\n",
    "semicolons": "name;bust;waist;hip;height\nS;88;70;96;168\nM;92,5;74;100;168\n",
    "units in the head": "Size,Bust (in),Waist (cm),hip_cm,Height (m)\nS,34.6457,70,96,1.68\nM,36.4173,74,100,1.68\n",
    "sizes as columns": ",S,M\nbust,88,92.5\nwaist,70,74\nhip,96,100\nheight,168,168\n",
    "German": "Größe;Brustumfang;Taille;Hüfte;Körperhöhe\nS;88;70;96;168\nM;92,5;74;100;168\n",
    "French": "Taille;Tour de poitrine;Tour de taille;Hanches;Stature\nS;88;70;96;168\nM;92,5;74;100;168\n",
    "list": '[{"name":"S","bust":88,"waist":70,"hip":96,"height":168},'
    '{"name":"M","bust":92.5,"waist":74,"hip":100,"height":168}]',
}


@pytest.mark.parametrize("form", SIZES)
def test_sizes_in_every_form(form):
    """Broken where a table of sizes loses a size, its name or a decimal comma."""
    rows = read_measure_table(SIZES[form]).rows
    assert [row.name for row in rows] == ["S", "M"]
    sizes = [{name: 100.0 * value for name, value in row.measures.items()} for row in rows]
    assert [sizes[0][name] for name in ("bust", "waist", "hip", "height")] == pytest.approx([88, 70, 96, 168], abs=1e-3)
    assert sizes[1]["bust"] == pytest.approx(92.5, abs=1e-3)


def test_what_is_not_known_is_left_and_listed(tmp_path):
    """Broken where an age or a name makes a table unreadable, or what is not used of it goes unsaid."""
    path = tmp_path / "m.csv"
    path.write_text("gender,female\nheight,170\nbust,92\nneck,35\nage,34\nname,Anna\n")
    found = read_measures(path)
    assert found.spec == "builtin:female,height=1.7,chest=0.92" and found.left == ("age: 34", "neck")
    table = read_measure_table("name,bust,waist,inseam,colour\nS,88,70,78,red\n")
    assert table.left == ("colour: red",) and set(table.rows[0].measures) == {"bust", "waist", "inseam"}


def test_files_of_garmentcode_and_freesewing():
    """Broken where the names of these two, degrees or millimetres are read as something else. FreeSewing's hips are the
    high hips, its seat the fullest girth."""
    code = "body: \n  height: 171.99  # cm\n  hips_line: 23.4837\n  waist: 84.3\n  leg_circ: 60.2\n"
    code += "  shoulder_incl: 21.6777\n  arm_pose_angle: 0.0\n"
    (row,) = read_measure_table(code).rows
    assert row.measures == pytest.approx({
        "height": 1.7199, "waist_to_hip": 0.234837, "waist": 0.843, "thigh": 0.602,
        "shoulder_slope": math.radians(21.6777), "arm_angle": 0.0,
    })  # fmt: skip
    sewing = {"name": "Anna", "units": "metric", "measurements": {
        "chest": 920, "hips": 900, "seat": 1000, "hpsToBust": 270, "waistBack": 370, "shoulderSlope": 13,
    }}  # fmt: skip
    table = read_measure_table(json.dumps(sewing))
    assert table.rows[0].name == "Anna" and "waistBack: 370" in table.left
    assert table.rows[0].measures == pytest.approx({
        "bust": 0.92, "high_hip": 0.9, "hip": 1.0, "bust_depth": 0.27, "shoulder_slope": math.radians(13),
    })  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gender,female\nheight,170\nwaist,7.4\n", "waist 7.4"),
        ("gender,female\nheight,17 cm\n", "height is 0.17 m"),
        ("gender,female\nwaist,70-74\n", "waist is '70-74'"),
        ("gender,female\nwaist,70\nwaist,71\n", "twice"),
        ("bust,92,5\nwaist,74,5\n", "no person's"),
        ("body:\n  bust: *all\n", "known"),
        ("a: &a [*a]\n", "known"),
        ("taille,74\nhanches,100\n", "stature"),
        ('{"a":' * 900 + "1" + "}" * 900, "deep|JSON"),
        ("bust\n", "name,value"),
    ],
)
def test_bad_tables_are_refused_by_their_fault(text, message):
    """Broken where a slip gives a person, or a refusal that does not say where the slip is."""
    with pytest.raises((MeasuresBad, MeasuresUnclear), match=message):
        read_measure_table(text)


def test_text_of_other_programs(tmp_path):
    """Broken where a table that a spreadsheet wrote on Windows, or as Unicode text, is not read."""
    text = "Geschlecht;weiblich\nKörpergröße;170\nHüfte;100\n"
    for encoding in ("cp1252", "utf-16", "utf-8-sig"):
        (tmp_path / "t").write_bytes(text.encode(encoding))
        assert read_table_text(tmp_path / "t") == text
    (tmp_path / "t").write_bytes(70_000 * b"a")
    with pytest.raises(MeasuresBad, match="large"):
        read_table_text(tmp_path / "t")


LENGTHS = [name for name, kind in MEASURE_KINDS.items() if kind.quantity == Quantity.LENGTH]


@settings(max_examples=60, deadline=None)
@given(
    st.dictionaries(st.sampled_from(LENGTHS), st.floats(0.0, 1.0), min_size=1), st.sampled_from(["cm", "mm", "inch"])
)
def test_written_by_other_libraries_and_read_again(shares, unit):
    """Broken where a measure's own name, or a value within persons', is not read back as it was written."""
    metres = {name: MEASURE_KINDS[name].span[0] * (1.001 - s) + MEASURE_KINDS[name].span[1] * s * 0.999 for name, s in
              shares.items()}  # fmt: skip
    scale = {"cm": 100.0, "mm": 1000.0, "inch": 1 / 0.0254}[unit]
    written = {name: round(scale * value, 6) for name, value in metres.items()}
    out = io.StringIO()
    csv.writer(out).writerows(written.items())
    for text in (out.getvalue(), json.dumps(written), yaml.safe_dump({"body": written})):
        (row,) = read_measure_table(text, unit).rows
        assert row.measures == pytest.approx(metres, rel=1e-5)


@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(list(PERSONS.values())), st.lists(st.tuples(st.integers(0, 200), st.text(max_size=3)), max_size=6)
)
def test_mutated_tables_are_read_or_refused(text, changes):
    """Broken where any text is a traceback, or gives a measure that no person has."""
    for at, new in changes:
        text = text[:at] + new + text[at + 1 :]
    try:
        table = read_measure_table(text)
    except (MeasuresBad, MeasuresUnclear):
        return
    for row in table.rows:
        for name, value in row.measures.items():
            assert MEASURE_KINDS[name].span[0] <= value <= MEASURE_KINDS[name].span[1]


def test_each_word_means_one_measure():
    """Broken where a heading is that of two measures, of which a reader would take the first."""
    for name, kind in MEASURE_KINDS.items():
        for words in kind.words.values():
            for word in words.split(","):
                assert {found for found, _ in find_measures(word)} == {name}, word
