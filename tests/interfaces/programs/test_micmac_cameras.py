"""Calibrations of MicMac and MMVII: points that MicMac itself has projected."""

import numpy as np
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.programs.recognised import read_foreign

PITCH_UM = 10.0
MICMAC = """<?xml version="1.0" ?>
<ExportAPERO><CalibrationInternConique>
 <KnownConv>eConvApero_DistM2C</KnownConv>
 <PP>{point}</PP><F>{f}</F><SzIm>{size}</SzIm>
 <CalibDistortion>{distortion}</CalibDistortion>
</CalibrationInternConique></ExportAPERO>
"""
# of the tests of MMVII (CeCILL-B, micmac-V2/MMVII): Saisies-MMV1 and Ori-MMV1
PENTAX = {
    "point": "856.865441648138 577.614006671526",
    "f": "2112.04115765381",
    "size": "1728 1152",
    "distortion": """<ModRad>
  <CDist>856.865441648138 577.614006671526</CDist>
  <CoeffDist>-2.13187449928481e-08</CoeffDist><CoeffDist>1.72263742999047e-15</CoeffDist>
  <CoeffDist>5.49746079672967e-21</CoeffDist><CoeffDist>-2.41801731114306e-27</CoeffDist>
  <PPaEqPPs>true</PPaEqPPs></ModRad>""",
}
NIKON = {
    "point": "3715.83452423654 2469.93743139070",
    "f": "12433.7002439217",
    "size": "7360 4912",
    "distortion": """<ModPhgrStd><RadialePart>
  <CDist>3715.83452423654 2469.93743139070</CDist>
  <CoeffDist>-2.33123826439696e-10</CoeffDist><CoeffDist>2.79861932525886e-17</CoeffDist>
  <CoeffDist>-1.51201480738528e-25</CoeffDist><PPaEqPPs>true</PPaEqPPs></RadialePart>
  <P1>-1.96102223779773e-08</P1><P2>4.07624973991257e-08</P2>
  <b1>0.000664079129024447</b1><b2>8.20835345000756e-05</b2></ModPhgrStd>""",
}
# projection centre, rotation, pixels and ground of points, as below <Verif> there
OF_PENTAX = (
    [5.20448828567060851, 1.49496779535545343, 2.11770763380631921],
    [
        [-0.162381354909888115, 0.0970335704412158828, -0.981945406723336411],
        [0.0383177901210033506, 0.99502246827372054, 0.091989317807644036],
        [0.985983794257223933, -0.022688627942266542, -0.165291208550925994],
    ],
    [[121.501184464155, 1086.21338653520], [1716.57868194295, 37.0236125010291]],
    [
        [2.76224419609029, 2.36673709230429, 0.710287999703862],
        [-2.10522541897468, 0.465717069318813, 3.81174337151526],
    ],
)
OF_NIKON = (
    [9.49951013862575877, -15.1087023498906241, -2.57995927625799837],
    [
        [0.998916580746384231, -0.0253289168052229056, 0.0390398601870777448],
        [-0.0465207005720288669, -0.521503654777997538, 0.851979907316762319],
        [-0.00122029842256471052, -0.85287301752761846, -0.52211696663208973],
    ],
    [[704.929943084714, 596.295384049415], [7268.89589309823, 4829.68926715937]],
    [
        [6.33430877505698, -0.0975835220227559, -8.85087811003305],
        [13.9867503295872, -4.67613424235403, -12.2150665551945],
    ],
)
MMVII = """<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>
<Root><Type>"MMVII_Serialization"</Type><Version>"0.0.0"</Version><Data>
<InternalCalibration><Name>"Calib-PENTAX"</Name>
<PixelFrame><NbPix>1728 1152</NbPix></PixelFrame><Projection>"Stenope"</Projection>
<PerfectProj><F>2112.217952097260422</F>
<PP>856.867008742109419 577.613650928660491</PP></PerfectProj>
<Distorsion><Radial><K1>-0.09976637812756</K1><K2>0.110628064042645</K2>
<K3>0.019690051934468</K3></Radial>
<Decentric><p1>-0.000000003177755</p1><p2>0.000000086257484</p2></Decentric>
<Polynomial><b1>-0.000001342233657</b1><b2>0.000000013881794</b2></Polynomial>
</Distorsion></InternalCalibration></Data></Root>
"""


def read(folder, text, name="AutoCal_Foc-28000_Cam-PENTAX_K5.xml"):
    (folder / name).write_text(text)
    return read_foreign(folder / name)


def camera_in(folder, text):
    (keys,) = read(folder, text).cameras.values()
    return camera_of({**keys, "pixel_size_um": PITCH_UM})


# Fraser's model and the radial one, about a centre that is not the principal point
F, POINT = 8668.7, np.array([3089.0, 2025.25])
RADIAL = (-1.78e-9, 1.77e-17, 3.6e-25, -1e-33, 2e-41)
FRASER = {"P1": 3.8e-6, "P2": -1.03e-6, "b1": 1.6e-3, "b2": -2.5e-4}


def distorted(ideal, centre, radial, p1=0.0, p2=0.0, b1=0.0, b2=0.0):
    """Pixels by the formulas of MicMac: r² and all terms are of what was ideal."""
    x, y = (ideal - centre).T
    square = x**2 + y**2
    growth = sum(k * square**n for n, k in enumerate(radial, 1))
    dx = x * growth + p1 * (square + 2 * x**2) + 2 * p2 * x * y + b1 * x + b2 * y
    dy = y * growth + p2 * (square + 2 * y**2) + 2 * p1 * x * y
    return ideal + np.column_stack([dx, dy])


@pytest.mark.parametrize("away", [(0.0, 0.0), (-65.5, 23.25)])
@pytest.mark.parametrize(("kind", "terms"), [("ModRad", {}), ("ModPhgrStd", FRASER)])
def test_distortion_about_a_centre_of_its_own_is_undone(tmp_path, away, kind, terms):
    centre = POINT + away
    one = "<CDist>{} {}</CDist>".format(*centre)
    one += "".join(f"<CoeffDist>{k}</CoeffDist>" for k in RADIAL)
    if terms:
        one = f"<RadialePart>{one}</RadialePart>"
        one += "".join(f"<{name}>{value}</{name}>" for name, value in terms.items())
    text = MICMAC.format(
        point="{} {}".format(*POINT),
        f=F,
        size="6080 4048",
        distortion=f"<{kind}>{one}</{kind}>",
    )
    grid = np.stack(np.meshgrid(np.linspace(0, 6080, 13), np.linspace(0, 4048, 9)), -1)
    ideal = grid.reshape(-1, 2)
    lowered = {name.lower(): value for name, value in terms.items()}
    measured = distorted(ideal, centre, RADIAL, **lowered)
    assert np.abs(measured - ideal).max() > 5.0
    camera = camera_in(tmp_path, text)
    wanted = (ideal - POINT) * [1.0, -1.0] * PITCH_UM * 1e-3
    found = camera.xy_from_measured(measured)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(camera.measured_from_xy(wanted), measured, atol=1e-9)


@pytest.mark.parametrize(
    ("calibration", "oriented", "within_px"),
    [(PENTAX, OF_PENTAX, 1e-6), (NIKON, OF_NIKON, 1e-6)],
)
def test_points_lie_where_micmac_projects_them(
    tmp_path, calibration, oriented, within_px
):
    centre, turn, pixels, ground = map(np.array, oriented)
    camera = camera_in(tmp_path, MICMAC.format(**calibration))
    x, y, z = ((ground - centre) @ turn).T
    expected = np.column_stack([x / z, -y / z]) * camera.principal_distance_mm
    found = camera.xy_from_measured(pixels)
    assert np.abs(found - expected).max() < within_px * PITCH_UM * 1e-3


def test_a_camera_is_named_as_its_file_and_lacks_the_size_of_a_pixel(tmp_path):
    found = read(tmp_path, MICMAC.format(**PENTAX))
    assert list(found.cameras) == ["AutoCal_Foc-28000_Cam-PENTAX_K5"]
    (note,) = found.notes
    assert "does not say how large a pixel is" in note


def test_mmvii_converts_a_calibration_to_the_same_camera(tmp_path):
    """MMVII made its own of the older one, with fewer terms."""
    found = read(tmp_path, MMVII)
    assert list(found.cameras) == ["Calib-PENTAX"]
    cameras = [camera_in(tmp_path, text) for text in (MICMAC.format(**PENTAX), MMVII)]
    pixels = np.stack(np.meshgrid(np.arange(9) * 216, np.arange(7) * 192), -1)
    one, two = (camera.xy_from_measured(pixels.reshape(-1, 2)) for camera in cameras)
    # in angles, since the focal lengths differ by 0.2 pixels
    distances = [camera.principal_distance_mm for camera in cameras]
    away = (one / distances[0] - two / distances[1]) * float(PENTAX["f"])
    assert np.abs(away).max() < 0.2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<ModRad>", "<ModUnif>", "a distortion of the kind ModUnif"),
        (
            "<CoeffDist>-2.41801731114306e-27</CoeffDist>",
            "<CoeffDist>0</CoeffDist>" * 2 + "<CoeffDist>1e-40</CoeffDist>",
            "has 6 radial coefficients",
        ),
        ("</ModRad>", "</ModRad><ModRad/>", "has 2 distortions one after the other"),
        ("DistM2C", "DistC2M", "by the convention eConvApero_DistC2M"),
    ],
)
def test_what_camera_toml_does_not_have_is_told(tmp_path, old, new, said):
    text = MICMAC.format(**PENTAX).replace(old, new)
    text = text.replace("</ModRad>", "</ModUnif>") if "Unif" in new else text
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, text)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<K3>", "<x2y>0.1</x2y><K3>", "has the term x2y"),
        ("Stenope", "eProjFishEye", "has the projection eProjFishEye"),
        (
            "<b1>-0.000001342233657",
            "<b1>0.5",
            "has an affinity beside a large distortion",
        ),
    ],
)
def test_what_camera_toml_does_not_have_of_mmvii_is_told(tmp_path, old, new, said):
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, MMVII.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("2112.04115765381", "-1", "the focal length is -1"),
        ("1728 1152", "1728", "SzIm: '1728' is not 2 numbers"),
        ("-2.13187449928481e-08", "nan", "CoeffDist: 'nan' is no number"),
    ],
)
def test_a_damaged_calibration_is_refused(tmp_path, old, new, said):
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, MICMAC.format(**PENTAX).replace(old, new))


@pytest.mark.parametrize("tag", ["Sigma2", "OptSigma2", "__Opt__Sigma2"])
def test_precisions_of_every_version_of_mmvii_are_read(tmp_path, tag):
    """Of files of 2024 they were lost in silence."""
    (tmp_path / "a.xml").write_text(f"""<Root><Type>"MMVII_Serialization"</Type><Data>
<SetGCP><NameSet>"a"</NameSet><Measures><el><Name>"P 1"</Name><Pt>1 2 3</Pt>
<AdditionalInfo>""</AdditionalInfo><{tag}>4 0 0 9 0 16</{tag}></el></Measures></SetGCP>
</Data></Root>""")
    table = read_foreign(tmp_path / "a.xml").tables["control_points"]
    errors = [f"standard_error_{axis}" for axis in ("easting", "northing", "height")]
    assert table.loc[0, errors].tolist() == [2.0, 3.0, 4.0]
