"""Words of surveyors of further countries for columns and kinds of points.

By language, as offices head their lists: Spanish, Portuguese, Polish, Czech and Slovak,
Dutch, Hungarian, Slovene, Croatian, Swedish, Norwegian, Danish, Finnish, Romanian,
Turkish, and Japanese with Chinese, whose lists share their words. Words are compared
folded (``column_words.folded``). As in the main table, what may mean several things is
not here: the Spanish ``punto de control`` is control to some, a check to others.
"""

# language: canonical name: words
COLUMNS = {
    "es": {
        "point_id": "punto puntos numerodepunto numerodelpunto nopunto npunto "
        "nodepunto numpunto nrodepunto nropunto idpunto puntoid nombredepunto "
        "nombredelpunto nombrepunto codigodepunto vertice",
        "easting": "este coordenadaeste coordeste utmeste esteutm",
        "northing": "norte coordenadanorte coordnorte utmnorte norteutm",
        "longitude": "longitud",
        "latitude": "latitud",
        "height": "cota altura altitud elevacion cotaortometrica alturaortometrica "
        "altitudortometrica elevacionortometrica",
        "model_id": "modelo modeloestereoscopico parestereoscopico",
        "image_id": "imagen fotograma foto nombreimagen numerodefoto",
        "coverage": "recubrimiento cobertura",
        "left_image": "imagenizquierda fotoizquierda fotogramaizquierdo",
        "right_image": "imagenderecha fotoderecha fotogramaderecho",
    },
    "pt": {
        "point_id": "ponto pontos numerodoponto nodoponto nponto numponto idponto "
        "nomedoponto vertice marco",
        "easting": "este leste coordenadaeste coordenadaleste meridiana "
        "distanciaameridiana distmeridiana",
        "northing": "norte coordenadanorte perpendicular distanciaaperpendicular "
        "distperpendicular",
        "longitude": "longitude",
        "latitude": "latitude",
        "height": "cota altura altitude elevacao altitudeortometrica cotaortometrica "
        "alturaortometrica",
        "model_id": "modelo modeloestereoscopico parestereoscopico",
        "image_id": "imagem foto fotografia fotograma",
        "coverage": "recobrimento cobertura",
    },
    "pl": {
        "point_id": "nrpunktu nrpkt nrpunkt numerpunktu punkt nazwapunktu oznaczenie "
        "numerpkt idpunktu",
        "longitude": "dlugosc dlugoscgeograficzna",
        "latitude": "szerokosc szerokoscgeograficzna",
        "height": "wysokosc rzedna wysokoscnormalna rzednaterenu wysokosch rzednah",
        "model_id": "model stereogram numerstereogramu nrmodelu",
        "image_id": "zdjecie nrzdjecia numerzdjecia nazwazdjecia",
    },
    "cs": {
        "point_id": "cislobodu cbodu bod cisbodu oznacenibodu oznaceniebodu nazevbodu "
        "menobodu",
        "longitude": "zemepisnadelka",
        "latitude": "zemepisnasirka",
        "height": "vyska nadmorskavyska",
        "model_id": "model cislomodelu",
        "image_id": "snimek snimka cislosnimku",
    },
    "nl": {
        "point_id": "punt puntnummer puntnr puntnaam puntid",
        "easting": "oost oostwaarde",
        "northing": "noord noordwaarde",
        "longitude": "lengtegraad",
        "latitude": "breedtegraad",
        "height": "hoogte hoogtenap",
        "model_id": "model modelnummer stereomodel stereopaar",
        "image_id": "foto fotonummer beeld",
    },
    "hu": {
        "point_id": "pontszam pontszama pontnev pontneve pontazonosito pont",
        "easting": "kelet keleti",
        "northing": "eszak eszaki",
        "height": "magassag baltimagassag tengerszintfelettimagassag",
        "model_id": "modell sztereopar",
        "image_id": "kep felvetel kepnev",
    },
    "sl": {
        "point_id": "tocka stevilkatocke sttocke oznakatocke imetocke",
        "easting": "vzhod",
        "northing": "sever",
        "height": "visina nadmorskavisina kota",
        "model_id": "model stereopar",
        "image_id": "posnetek",
    },
    "hr": {
        "point_id": "tocka brojtocke brtocke oznakatocke imetocke nazivtocke",
        "easting": "istok",
        "northing": "sjever",
        "height": "visina nadmorskavisina kota",
        "model_id": "model stereopar",
        "image_id": "snimka snimak",
    },
    "sv": {
        "point_id": "punkt punktnummer punktnr punktnamn punktid pktnr pkt",
        "easting": "oest oestlig oster",
        "northing": "nord norr nordlig",
        "longitude": "longitud",
        "latitude": "latitud",
        "height": "hoejd",
        "model_id": "modell stereomodell",
        "image_id": "bild bildnummer bildnamn",
    },
    "no": {
        "point_id": "punkt punktnummer punktnr punktnavn punktid pktnr pkt",
        "easting": "oest oestlig",
        "northing": "nord nordlig",
        "longitude": "lengdegrad",
        "latitude": "breddegrad",
        "height": "hoeyde",
        "model_id": "modell stereomodell",
        "image_id": "bilde bildenummer bildenavn",
    },
    "da": {
        "point_id": "punkt punktnummer punktnr punktnavn punktid pktnr pkt",
        "easting": "oest oestlig",
        "northing": "nord nordlig",
        "longitude": "laengdegrad",
        "latitude": "breddegrad",
        "height": "hoejde kote",
        "model_id": "model stereomodel",
        "image_id": "billede billednummer",
    },
    "fi": {
        "point_id": "piste pistenumero pisteennumero pistenro pistenimi pisteennimi "
        "pisteid",
        "easting": "itae itakoordinaatti itaekoordinaatti",
        "northing": "pohjoinen pohjoiskoordinaatti",
        "height": "korkeus",
        "model_id": "malli stereomalli",
        "image_id": "kuva kuvanumero",
    },
    "ro": {
        "point_id": "punct nrpct nrpunct numarpunct denumirepunct",
        "height": "cota altitudine",
    },
    "tr": {
        "point_id": "nokta noktano noktaadi noktaid",
        "easting": "saga sagadeger",
        "northing": "yukari yukarideger",
        "height": "kot yukseklik ortometrikyukseklik",
    },
    "ja": {
        "point_id": "点名 点番号 点番 点番名 点no 測点 測点名 測点番号 点号",
        "easting": "东坐标 东",
        "northing": "北坐标 北",
        "longitude": "経度 经度",
        "latitude": "緯度 纬度",
        "height": "標高 標高値 高さ z座標 高程 h座標 z坐标",
        "model_id": "モデル モデル名 モデル番号",
        "image_id": "写真 写真名 写真番号 画像 画像名 影像",
    },
}
KINDS = {
    "control": {
        "es": "apoyo puntodeapoyo puntodeapoyofotogrametrico",
        "pt": "apoio pontodeapoio pontofotogrametrico",
        "pl": "fotopunkt punktosnowy osnowa",
        "cs": "vlicovacibod",
        "nl": "paspunt grondslagpunt",
        "hu": "illesztopont",
        "sl": "oslonilnatocka",
        "hr": "orijentacijskatocka",
        "sv": "stoedpunkt",
        "fi": "tukipiste",
        "ja": "標定点",
    },
    "check": {
        "es": "chequeo puntodechequeo puntodecomprobacion puntodeverificacion",
        "pt": "pontodeverificacao pontodechecagem",
        "pl": "punktkontrolny",
        "cs": "kontrolnibod kontrolnybod",
        "nl": "controlepunt",
        "hu": "ellenorzopont",
        "sl": "kontrolnatocka",
        "fi": "tarkastuspiste",
        "ja": "検証点",
    },
    "new": {
        "es": "puntonuevo nuevopunto puntodeenlace",
        "pt": "pontonovo novoponto pontodeligacao",
        "pl": "punktwiazacy nowypunkt",
        "nl": "nieuwpunt",
        "hu": "ujpont kapcsolopont",
        "sl": "veznatocka novatocka",
        "sv": "nypunkt",
        "ja": "新点",
    },
}
# a coordinate with the letter of its axis in the place of the braces
LETTERED = (
    *(["{0}koordinate", "koordinate{0}", "{0}koord", "koord{0}"]),
    *(["{0}coord", "coord{0}", "{0}coordinate", "coordinate{0}", "coordonnee{0}"]),
    *(["coordenada{0}", "{0}coordenada", "coor{0}", "utm{0}", "{0}utm"]),
    *(["wspolrzedna{0}", "wsp{0}"]),
    *(["souradnice{0}", "{0}souradnice", "suradnica{0}", "{0}suradnica", "sour{0}"]),
    *(["{0}coordinaat", "coordinaat{0}", "koordinata{0}", "{0}koordinata", "eov{0}"]),
    *(["koordinat{0}", "{0}koordinat", "{0}koordinaatti"]),
    *(["{0}座標", "{0}座標値", "{0}坐标"]),
)
# languages whose surveyors head the northing with X, and the easting with Y
NORTHING_IS_X = ("de", "pl", "sl", "hr", "hu", "ro", "tr", "ja")
EASTING_IS_X = ("nl",)
# that call X and Y what counts to the south and west
SOUTHING_IS_X = ("cs",)
