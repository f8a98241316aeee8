"""Words of surveyors for columns of tables and for kinds of points, folded.

German, English, French and Italian. A word that may mean several things is not here:
precision stands under many names, and only its owner knows whether it is total or of
one coordinate.
"""

# canonical name: words by language; each list stands in the order of preference
WORDS = {
    "point_id": {
        "de": "punktnummer punktnr pktnummer pktnr punktname punktid punktbezeichnung "
        "punktkennung ptnr punkt pkt",
        "en": "pointid pointnumber pointno pointnr pointname pointref point pt ptid "
        "ptno ptnumber ptname opid gcp gcpid gcpname gcplabel label",
        "fr": "numerodupoint nodupoint numeropoint numpoint nopoint nomdupoint "
        "nompoint matricule",
        "it": "numeropunto numpunto nomepunto nrpunto punto",
        "": "id nr no num nummer number numero name nom nome p",
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
        "en": "height elevation elev altitude alt pointz orthometricheight orthoheight",
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
KINDS = {
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
