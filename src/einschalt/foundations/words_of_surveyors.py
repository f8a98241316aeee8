"""Words of surveyors for columns of tables and for kinds of points, folded.

German, English, French and Italian here, further languages from words_of_countries. A
word that may mean several things is not here: precision stands under many names, and
only its owner knows whether it is total or of one coordinate.
"""

from einschalt.foundations import words_of_countries

# canonical name: words by language; each list stands in the order of preference
OWN_WORDS = {
    "point_id": {
        "de": "punktnummer punktnr pktnummer pktnr punktname punktid punktbezeichnung "
        "punktkennung ptnr punkt pkt",
        "en": "pointid pointnumber pointno pointnr pointname pointref point pt ptid "
        "pnt ptno ptnumber ptname opid gcp gcpid gcpname gcplabel label",
        "fr": "numerodupoint nodupoint numeropoint numpoint nopoint nomdupoint "
        "nompoint matricule",
        "it": "numeropunto numpunto nomepunto nrpunto punto",
        "": "id nr no num nummer number numero numer broj stevilka numar 番号 name nom "
        "nome nombre namn navn naam nazwa nazev ime nimi nev 名称 stn station p",
    },
    "easting": {
        "de": "rechtswert ostwert rw ost rechts",
        "en": "easting eastings east pointx",
        "fr": "est abscisse",
        "it": "coordinataest",
        "": "e",
    },
    "northing": {
        "de": "hochwert nordwert hw nord hoch",
        "en": "northing northings north pointy",
        "fr": "ordonnee",
        "it": "coordinatanord",
        "": "n",
    },
    "longitude": {"de": "laenge", "en": "longitude lon long lng", "it": "longitudine"},
    "latitude": {"de": "breite", "en": "latitude lat", "it": "latitudine"},
    "height": {
        "de": "hoehe meereshoehe gebrauchshoehe orthometrischehoehe",
        "en": "height elevation elev altitude alt pointz orthometricheight orthoheight "
        "reducedlevel rl level ht ahd",
        "fr": "hauteur cote",
        "it": "quota altezza altitudine",
        "": "h z",
    },
    "role": {
        "de": "art punktart rolle verwendung",
        "en": "role kind usage",
        "fr": "genre nature",
        "it": "ruolo genere",
        "": "typ type tipo",
    },
    "coverage": {
        "de": "ueberdeckung befliegung deckung",
        "en": "coverage",
        "fr": "couverture recouvrement",
        "it": "copertura ricoprimento",
    },
    "model_id": {
        "de": "modell modellnummer modellnr modellname modellid stereomodell bildpaar "
        "bildpaarnummer bildpaarnr stereopaar",
        "en": "model modelid modelnumber modelno modelname stereomodel imagepair "
        "stereopair",
        "fr": "modele numeromodele couple couplestereo",
        "it": "modello numeromodello modellostereo",
    },
    "image_id": {
        "de": "bild bildnummer bildnr bildname bildid messbild foto fotonr",
        "en": "image imageid imagename imageno photo photoid photono photoname",
        "fr": "cliche numerocliche nomimage",
        "it": "immagine fotogramma numerofotogramma nomeimmagine",
    },
    "left_image": {
        "de": "linkesbild bildlinks bild1",
        "en": "leftimage imageleft leftphoto image1",
        "fr": "imagegauche clichegauche",
        "it": "immaginesinistra fotogrammasinistro",
    },
    "right_image": {
        "de": "rechtesbild bildrechts bild2",
        "en": "rightimage imageright rightphoto image2",
        "fr": "imagedroite clichedroit",
        "it": "immaginedestra fotogrammadestro",
    },
    "base": {"de": "basis basislaenge", "en": "base", "fr": "base", "it": "base"},
    "n_settings": {"de": "einstellungen anzahleinstellungen", "en": "nsettings"},
    "setting": {"de": "einstellung", "en": "setting pointing"},
    "y_parallax": {
        "de": "yparallaxe vertikalparallaxe py",
        "en": "yparallax",
        "fr": "parallaxey parallaxeverticale",
        "it": "parallassey parallasseverticale",
    },
}
OWN_KINDS = {
    "control": {
        "de": "passpunkt vollpasspunkt lagepasspunkt festpunkt pp",
        "en": "control controlpoint groundcontrolpoint gcp",
        "fr": "pointdappui pointdecalage",
        "it": "puntodappoggio puntodiappoggio",
    },
    "check": {
        "de": "kontrollpunkt pruefpunkt kp",
        "en": "check checkpoint independentcheckpoint",
        "fr": "pointdeverification",
        "it": "puntodiverifica",
    },
    "new": {
        "de": "neupunkt einschaltpunkt einschaltepunkt verknuepfungspunkt np",
        "en": "new newpoint tiepoint",
        "fr": "pointnouveau nouveaupoint pointdeliaison",
        "it": "puntonuovo puntodilegame",
    },
}


def _with_countries(own, countries):
    """Words by name and language, those of all countries behind the own ones."""
    found = {name: dict(languages) for name, languages in own.items()}
    for language, columns in countries.items():
        for name, words in columns.items():
            found[name][language] = words
    return {name: _weak_last(languages) for name, languages in found.items()}


def _weak_last(languages):
    """Languages in order, with the words that are used if there are no others last."""
    weak = languages.pop("", None)
    return languages if weak is None else languages | {"": weak}


WORDS = _with_countries(OWN_WORDS, words_of_countries.COLUMNS)
KINDS = {
    kind: languages | words_of_countries.KINDS[kind]
    for kind, languages in OWN_KINDS.items()
}
