"""The measures of a person that tables have: what they are, between which values they lie, and how they are called."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from enum import StrEnum

from ..run.units import UNITS


class Quantity(StrEnum):
    """What a measure is: lengths and girths are in metres, weights in kg, angles in rad."""

    LENGTH = "length"
    WEIGHT = "weight"
    ANGLE = "angle"


@dataclass(frozen=True)
class MeasureKind:
    """Describe a measure of a person.

    Attributes:
        quantity: What it is.
        span: Least and largest value of a person from 86 cm of height [m, kg or rad], by the extremes of ANSUR II
            (adults) and of growth charts (children), widened. It tells units of length apart, no more.
        words: How it is called in tables, as `simplify` writes it, by language; `key` has the names of GarmentCode and
            FreeSewing.
    """

    quantity: Quantity
    span: tuple[float, float]
    words: dict[str, str]


def _length(low: float, high: float, **words: str) -> MeasureKind:
    return MeasureKind(Quantity.LENGTH, (low, high), words)


def _angle(high: float, **words: str) -> MeasureKind:
    return MeasureKind(Quantity.ANGLE, (-0.5, high), words)


MEASURE_KINDS: dict[str, MeasureKind] = {
    "height": _length(
        0.85, 2.35, en="height,body height,stature", de="hohe,korperhohe,korpergrosse,grosse", fr="stature,hauteur",
        it="altezza,statura", es="estatura,altura",
    ),
    "weight": MeasureKind(
        Quantity.WEIGHT, (12.0, 300.0),
        {"en": "weight,body weight,mass", "de": "gewicht,korpergewicht", "fr": "poids", "it": "peso", "es": "peso"},
    ),
    "bust": _length(
        0.50, 1.80, en="bust,chest,full bust", de="brust,oberweite", fr="poitrine,buste", it="torace,seno,petto,busto",
        es="pecho,busto",
    ),
    "high_bust": _length(0.48, 1.60, en="high bust,upper bust,upper chest", de="oberbrust", key="high bust"),
    "underbust": _length(
        0.45, 1.60, en="underbust,under bust", de="unterbrust", fr="sous poitrine,dessous de poitrine",
        it="sottoseno", es="bajo pecho,bajo busto",
    ),
    "waist": _length(
        0.44, 1.75, en="waist,natural waist", de="taille,taillen", fr="taille", it="vita", es="cintura",
    ),
    "high_hip": _length(0.48, 1.80, en="high hip,high hips,upper hip", de="obere hufte", fr="petites hanches"),
    "hip": _length(
        0.50, 1.90, en="hip,hips,full hip,seat,low hip", de="hufte,huft,huften,gesass", fr="hanches,hanche,bassin",
        it="fianchi,bacino", es="cadera,caderas",
    ),
    "thigh": _length(
        0.28, 1.05, en="thigh,upper leg", de="oberschenkel,schenkel", fr="cuisse", it="coscia", es="muslo",
        key="leg circ,upper leg",
    ),
    "knee": _length(0.20, 0.65, en="knee", de="knie", fr="genou", it="ginocchio", es="rodilla"),
    "calf": _length(0.19, 0.65, en="calf", de="wade,waden", fr="mollet", it="polpaccio", es="pantorrilla"),
    "ankle": _length(0.13, 0.42, en="ankle", de="knochel,fessel", fr="cheville", it="caviglia", es="tobillo"),
    "upper_arm": _length(
        0.15, 0.62, en="upper arm,top arm,bicep,biceps,arm girth", de="oberarm,bizeps", fr="tour de bras,biceps",
        it="circonferenza braccio,bicipite", es="contorno de brazo,contorno brazo,biceps",
    ),
    "wrist": _length(
        0.10, 0.27, en="wrist", de="handgelenk", fr="poignet", it="polso", es="muneca",
    ),
    "neck": _length(0.22, 0.62, en="neck,neck base", de="hals,kragen", fr="cou,encolure", it="collo", es="cuello"),
    "head": _length(0.46, 0.68, en="head", de="kopf", fr="tete", it="testa", es="cabeza"),
    "inseam": _length(
        0.35, 1.15, en="inseam,inside leg,inner leg,inside leg length", de="schrittlange,innenbein,innenbeinlange",
        fr="entrejambe,longueur entrejambe", it="interno gamba", es="entrepierna",
    ),
    "outseam": _length(
        0.50, 1.50, en="outseam,outside leg", de="seitenlange,aussenbeinlange",
        fr="longueur cote", it="esterno gamba", es="largo lateral", key="waist to floor",
    ),
    "shoulder_width": _length(
        0.22, 0.60, en="shoulder width,cross shoulder", de="schulterbreite", fr="largeur epaules,largeur d epaules",
        it="larghezza spalle", es="ancho hombros,ancho de hombros", key="shoulder w,shoulder to shoulder",
    ),
    "shoulder": _length(
        0.06, 0.24, en="shoulder,shoulder length", de="schulter,schulterlange", fr="epaule,longueur epaule",
        it="spalla,lunghezza spalla", es="hombro,largo hombro",
    ),
    "arm_length": _length(
        0.30, 0.95, en="arm length,sleeve length", de="armlange,armellange", fr="longueur bras,longueur manche",
        it="lunghezza braccio,lunghezza manica", es="largo brazo,largo manga",
        key="shoulder to wrist",
    ),
    "back_waist_length": _length(
        0.22, 0.62, en="back waist length,nape to waist,back length,waist back length", de="ruckenlange",
        fr="longueur dos,longueur taille dos", it="lunghezza dorso", es="largo espalda,talle espalda",
        key="waist line",
    ),
    "front_waist_length": _length(
        0.24, 0.70, en="front waist length", de="vordere lange,vorderlange", fr="longueur devant",
        it="lunghezza davanti", es="talle delantero", key="waist over bust line,hps to waist front",
    ),
    "bust_depth": _length(
        0.12, 0.48, en="bust depth,shoulder to bust", de="brusttiefe", fr="hauteur poitrine", it="altezza seno",
        es="altura pecho", key="bust line,hps to bust",
    ),
    "bust_level": _length(0.10, 0.42, en="nape to bust level", key="vert bust line"),
    "bust_span": _length(
        0.10, 0.34, en="bust span,bust point distance", de="brustpunktabstand", fr="ecart poitrine",
        it="distanza seno", es="separacion busto", key="bust points,bust span",
    ),
    "head_length": _length(0.17, 0.38, en="nape to crown", key="head l"),
    "neck_width": _length(0.08, 0.30, en="neck width", key="neck w"),
    "armscye_depth": _length(
        0.07, 0.34, en="armscye depth,armhole depth,scye depth", de="armlochtiefe", key="armscye depth"
    ),
    "back_width": _length(0.20, 0.95, en="back width", key="back width"),
    "waist_back_width": _length(0.18, 0.90, en="waist back width", key="waist back width"),
    "hip_back_width": _length(0.22, 1.00, en="hip back width", key="hip back width"),
    "waist_to_hip": _length(
        0.08, 0.36, en="waist to hip,hip depth", de="hufttiefe", key="hips line,waist to seat"
    ),
    "rise": _length(
        0.13, 0.45, en="rise,body rise,crotch depth", de="sitzhohe,leibhohe", fr="montant,hauteur montant",
        it="altezza cavallo", es="tiro,altura tiro",
    ),
    "hip_to_crotch": _length(0.02, 0.25, en="hip to crotch", key="crotch hip diff"),
    "seat_span": _length(0.08, 0.36, en="seat point distance", key="bum points"),
    "shoulder_slope": _angle(0.9, en="shoulder slope", de="schulterneigung", key="shoulder incl,shoulder slope"),
    "hip_slope": _angle(0.9, en="hip slope", key="hip inclination"),
    "arm_angle": _angle(1.6, en="arm angle", key="arm pose angle"),
}  # fmt: skip
"""The measures that tables may have, by our name."""

HOW_MEASURED = {
    "height": "from the soles to the crown",
    "head_length": "upright, from the nape to the crown",
    "neck_width": "behind the neck, from side neck point to side neck point",
    "shoulder_width": "between the ends of the shoulders",
    "shoulder_slope": "of the line from side neck point to shoulder, below level",
    "armscye_depth": "from the end of the shoulder to the armpit",
    "arm_angle": "of the line from shoulder to wrist, below level",
    "arm_length": "from the end of the shoulder to the wrist",
    "wrist": "around, where it is thinnest",
    "bust": "around, over the bust points",
    "underbust": "around, below the bust",
    "waist": "around, where it is narrowest between ribs and hip bones",
    "hip": "around, over the most prominent points of the seat",
    "thigh": "around the fuller leg, below the crotch",
    "back_width": "of the bust, behind, from side to side",
    "waist_back_width": "of the waist, behind, from side to side",
    "hip_back_width": "of the hip, behind, from side to side",
    "back_waist_length": "from the nape down the back to the waist",
    "front_waist_length": "from the shoulder over the bust point to the waist",
    "bust_depth": "from the shoulder to the bust point",
    "bust_level": "upright, from the nape to the bust",
    "bust_span": "between the bust points",
    "waist_to_hip": "upright, from the waist to the hip",
    "hip_to_crotch": "upright, from the hip to the crotch",
    "seat_span": "between the most prominent points of the seat",
    "hip_slope": "of the side from hip to waist, from upright",
}
"""The 26 measures, and how each is taken (ISO 8559-1 where it has one; the set is that of GarmentCode)."""

GENDER_HEADINGS = ("gender", "sex", "body", "geschlecht", "sexe", "genre", "sesso", "genere", "sexo", "genero")

GENDERS = {
    word: gender
    for gender, words in (
        ("female", "female f woman women w weiblich frau femme feminin femminile donna femenino mujer"),
        ("male", "male m man men mannlich mann homme masculin maschile maschio uomo masculino hombre"),
    )
    for word in words.split()
}

ROW_HEADINGS = (
    "name", "size", "measure", "measurement", "mass", "massname", "grossen", "konfektionsgrosse", "nom", "mesure",
    "nome", "taglia", "misura", "nombre", "talla", "medida", "label",
)  # fmt: skip
"""Headings of a column that has names: of persons, sizes or measures."""

GIRTH_WORDS = re.compile(
    r"\b(girth|circumference|circ|size|umfang|weite|tour|circonferenza|contorno|measurement)\b|\b(of|the|de|des|du|della|"
    r"del|di|d|la|le|les|l|round|around)\b"
)
"""Words of a heading that say no more than that something is measured, and articles."""

GIRTH_ENDINGS = re.compile(r"(umfang|weite)$")
"""Endings of German headings that say the same."""

UNIT_WORDS = {
    "m": "m", "metre": "m", "metres": "m", "meter": "m", "meters": "m", "cm": "cm", "centimetre": "cm",
    "centimetres": "cm", "centimeter": "cm", "centimeters": "cm", "zentimeter": "cm", "mm": "mm", "millimetre": "mm",
    "millimetres": "mm", "millimeter": "mm", "millimeters": "mm", "in": "inch", "inch": "inch", "inches": "inch",
    "zoll": "inch", "pouces": "inch", "pollici": "inch", "pulgadas": "inch", '"': "inch", "″": "inch", "”": "inch",
    "''": "inch", "ft": "foot", "foot": "foot", "feet": "foot", "'": "foot", "’": "foot", "′": "foot",
}  # fmt: skip
"""Names of units in tables, and their names in `UNITS`."""

WEIGHT_UNITS = {"kg": 1.0, "kgs": 1.0, "lb": 0.45359237, "lbs": 0.45359237, "g": 0.001}
"""Kilograms in one unit of weight, by the names that tables have (international pound, exact)."""

assert set(UNIT_WORDS.values()) == set(UNITS)


MAX_HEADING_LENGTH = 80
"""Largest number of letters of a heading that are read."""


def simplify(heading: str) -> str:
    """Return a heading in lower case without accents and marks, words apart: `Hüft-Umfang` is `huft umfang`,
    `hpsToBust` is `hps to bust`."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", heading[:MAX_HEADING_LENGTH].strip()).replace("ß", "ss")
    plain = "".join(one for one in unicodedata.normalize("NFKD", apart) if not unicodedata.combining(one))
    return " ".join(re.sub(r"[^a-z0-9]+", " ", plain.lower()).split())


def split_unit(heading: str) -> tuple[str, str]:
    """Return a heading without its unit, and the unit as it is written: `Bust (cm)`, `bust_cm`, `bust in inches`."""
    heading = heading[:MAX_HEADING_LENGTH]
    found = re.fullmatch(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*", heading)
    if found:
        return found[1], found[2].lower()
    found = re.fullmatch(r"(.*\w)(?:\s*[,/_\-]\s*|\s+in\s+|\s+)([A-Za-z]+)\s*", heading)
    if found and (found[2].lower() in UNIT_WORDS or found[2].lower() in WEIGHT_UNITS) and simplify(found[1]):
        return re.sub(r"\s+in$", "", found[1]), found[2].lower()
    return heading, ""


def find_measures(heading: str) -> list[tuple[str, str]]:
    """Return the measures that a heading without unit may mean, each with the languages that call it so."""
    plain = simplify(heading)
    bare = " ".join(GIRTH_WORDS.sub(" ", plain).split())
    stem = GIRTH_ENDINGS.sub("", bare)
    umlauts = stem.replace("ae", "a").replace("oe", "o").replace("ue", "u")
    for tried in dict.fromkeys((plain, bare, stem, umlauts)):
        found = [
            (name, language)
            for name, kind in MEASURE_KINDS.items()
            for language, words in kind.words.items()
            if tried and (tried in words.split(",") or tried == name.replace("_", " "))
        ]
        if found:
            return found
    return []
