"""Small files as other programs write them: for the fuzz, and for the tests."""

CAMERAS = "# Number of cameras: 1\n1 PINHOLE 4000 3000 2500 2500 2000 1500\n"
# a camera that looks down from (10, 20, 100), its x to the east
IMAGES = """\
# Number of images: 2, mean observations per image: 1
1 0 1 0 0 -10 20 100 1 a b.jpg
2000 1500 7 1 1 -1 2250 1500 8
2 0 1 0 0 -10 20 100 1 c.jpg

"""
POINTS_3D = "# Number of points: 2\n7 10 20 0 1 2 3 0.5 1 0\n8 20 20 0 1 2 3 0.25 1 2\n"
ORIENTATION = """\
<?xml version="1.0" ?><ExportAPERO><OrientationConique><Externe>
<Centre>10 20 100</Centre><ParamRotation><CodageMatr><L1>1 0 0</L1>
<L2>0 -1 0</L2><L3>0 0 -1</L3></CodageMatr></ParamRotation>
</Externe></OrientationConique></ExportAPERO>
"""
DICO = """\
<DicoAppuisFlottant><OneAppuisDAF><Pt>1 2 3</Pt><NamePt>P1</NamePt>
<Incertitude>0.01 0.02 0.03</Incertitude></OneAppuisDAF></DicoAppuisFlottant>
"""
MEASURED = """\
<SetOfMesureAppuisFlottants><MesureAppuiFlottant1Im><NameIm>a.tif</NameIm>
<OneMesureAF1I><NamePt>P1</NamePt><PtIm>5.5 6</PtIm></OneMesureAF1I>
</MesureAppuiFlottant1Im></SetOfMesureAppuisFlottants>
"""
MMVII = """\
<MMVII_Serialization><SetGCP><NameSet>"a"</NameSet><Measures><Nb>1</Nb>
<el><Name>"002"</Name><Pt>-0.2 -0.5 0.25</Pt><Sigma2>4 1 0 9 0 16</Sigma2></el>
</Measures></SetGCP></MMVII_Serialization>
"""
VRT = """\
<VRTDataset><GCPList Projection="EPSG:31467">
<GCP Id="A" Pixel="1.5" Line="2.5" X="3500000" Y="5300000" Z="12"/>
<GCP Id="" Pixel="3" Line="4" X="3500100" Y="5300100" Z="13"/>
</GCPList></VRTDataset>
"""
ARCGIS = """\
<GeodataXform><SpatialReference><WKID>31467</WKID></SpatialReference>
<SourceGCPs><Double>1</Double><Double>2</Double></SourceGCPs>
<TargetGCPs><Double>3500000</Double><Double>5300000</Double></TargetGCPs>
</GeodataXform>
"""
QGIS = """\
#CRS: EPSG:31255
mapX,mapY,sourceX,sourceY,enable,dX,dY,residual
13000.5,322000.25,10.5,-20.25,1,0,0,0
13100,322100,30,-40,0,0,0,0
"""
MARKS = """\
Project Units: meters

Object Point ID,Photo #,X (pixels),Y (pixels),Residual X,Residual Y
317,1,5007.5,7275.25,0.1,0.6
"""
POINTS_PM = """\
Project Units: meters

Id,Name,Photos (used),X (project units),Y (project units),Z (project units),\
X Precision,Y Precision,Z Precision,Type
317," ","1,2",1.5,2.5,3.5,0.01,0.02,n/a,Control
318," ","1,2",4.5,5.5,6.5,0.01,0.02,0.03,Regular
"""
PROJECT = """\
Bundle Soln
 0.0005 20 100 100
 1 2 3 4 5 6 7 8 9
 0 1 1 1 1 1 1 1 1 1
 0 0 0 0 0 0 0 0 0 0
   0 c:\\my images\\8811.jpg
   0 10 20 100 90 0 0
   0 0.1 0.1 0.1 0.1 0.1 0.1

   0 1 1 1 1 1 1 1 1 1 1
   0 1 1 1 1 1 1 1 1 1 1

     317 1.5 2.5 3.5 0.01 0.02 0.03

   0      317 5007.5 7275.25  1.0  1.0

   1    1      317

   0    1
"""
OPK = """\
CHANTIER : a
PROJECTION : LAMBERT93
UNITE ANGLE  : grade
NOM\tX\tY\tZ\tO\tP\tK\tCAMERA
im1    1029229.25    6334683.5    3660.75     0     0     100     UCE-M3
"""
PRJ = """\
$PROJECT 5.0.0
$LINEAR_UNITS_OF_IMAGE : mm
$PHOTO
  $PHOTO_NUM : 12
  $EXT_ORI : 0
   153.0 10 20 100
   0 -1 0
   1 0 0
   0 0 1
  $PHOTO_POINTS :
   P1 1.5 -2.5 1.0 2 { * }
  $END_POINTS
$END
$CONTROL_POINTS
  P1 1 2 3 HV
$END
"""
GAMA = """\
<gama-local><network><points-observations><coordinates>
<point id="A" x="2" y="1"/><cov-mat dim="2" band="1">4 1 9</cov-mat>
</coordinates></points-observations></network></gama-local>
"""
LANDXML = """\
<LandXML xmlns="http://www.landxml.org/schema/LandXML-1.0"><Units>
<Metric linearUnit="millimeter"/></Units><CgPoints>
<CgPoint name="A">2000 1000 3000</CgPoint><CgPoint pntRef="A"/></CgPoints></LandXML>
"""
REFERENCE = """\
# CoordinateSystem: EPSG:4326
#Label,X/Longitude,Y/Latitude,Z/Altitude,Error_(m),Enable
"P, 1",13.5,48.25,411.5,0.01,False
# Total error,,,,0.01
"""
JOBXML = """\
<?xml version="1.0"?><JOBFile jobName="a" version="5.7"><Reductions>
<Point><ID>1</ID><Name>P 1</Name><Code>GCP</Code><Grid><North>2.25</North>
<East>1.5</East><Elevation>3.5</Elevation></Grid></Point>
<Point><ID>2</ID><Name>P2</Name><Grid/></Point></Reductions></JOBFile>
"""
KML = """\
<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document>
<Placemark><name>P 1</name><ExtendedData><Data name="Art"><value>Passpunkt</value>
</Data></ExtendedData><Point><altitudeMode>absolute</altitudeMode>
<coordinates>13.5,48.25,411.5</coordinates></Point></Placemark>
<Placemark><LineString><coordinates>1,2 3,4</coordinates></LineString></Placemark>
</Document></kml>
"""
GSI = """\
*110001+00000000000000P7 81..10+0000000000001500 82..10-0000000000002250 \
83..16+0000000000035000
410002+00000TRE 42....+00000000
110003+00001002 84..10+00013826 85..18+00322000
"""
SDR = f"""\
00NMSDR33 V04-04.34     25-Nov-15 12:33 111121
10NMtemp            121111
08CO{"P 7":>16}{"1.50000000":16}{"-2.25000000":16}{"3.50000000":16}GCP
02TP{"P 7":>16}{"1.50000000":16}{"-2.25000000":16}{"3.50000000":16}1.6
09F1{"P 7":>16}{"0001":>16}{"479.323":16}{"122.85694444":16}{"212.36416667":16}
"""
NIKON = """\
CO,Nikon RAW data format V2.00
CO,Dist Units: Metres
CO,Coord Order: NEZ
UP,P 7,,-2.250,1.500,3.500,GCP
ST,P 7,,,,1.400,55.4500,55.4500
SS,3,1.200,330.706,326.027,20.320,07:13:46,SIGN
"""
BLOCKS = """\
<?xml version="1.0" encoding="utf-8"?>
<BlocksExchange version="3.2">
  <SpatialReferenceSystems>
    <SRS><Id>0</Id><Name>here</Name><Definition>EPSG:2154</Definition></SRS>
    <SRS><Id>1</Id><Name>WGS 84</Name><Definition>WGS84</Definition></SRS>
  </SpatialReferenceSystems>
  <Block>
    <Name>B</Name>
    <SRSId>1</SRSId>
    <Photogroups><Photogroup>
      <Name>cam</Name>
      <ImageDimensions><Width>6000</Width><Height>4000</Height></ImageDimensions>
      <CameraModelType>Perspective</CameraModelType>
      <SensorSize>24</SensorSize><FocalLength>20</FocalLength>
      <PrincipalPoint><x>3009.5</x><y>1999.5</y></PrincipalPoint>
      <Distortion><K1>0.01</K1><K2>0</K2><K3>0</K3><P1>0</P1><P2>0</P2></Distortion>
      <Photo><Id>4</Id><ImagePath>D:/flight/a.jpg</ImagePath></Photo>
      <Photo><Id>5</Id><ImagePath>D:/flight/b.jpg</ImagePath></Photo>
    </Photogroup></Photogroups>
    <ControlPoints><SRSId>0</SRSId>
      <ControlPoint><Name>P 1</Name><Category>Full</Category>
        <Position><x>652788.5</x><y>6863015.25</y><z>78.5</z></Position>
        <CheckPoint>true</CheckPoint>
        <HorizontalAccuracy>0.01</HorizontalAccuracy>
        <VerticalAccuracy>0.02</VerticalAccuracy>
        <Measurement><PhotoId>5</PhotoId><x>100.0</x><y>200.25</y></Measurement>
        <Measurement><PhotoId>4</PhotoId><x>900.0</x><y>210.25</y></Measurement>
      </ControlPoint>
    </ControlPoints>
  </Block>
</BlocksExchange>
"""
SIMA = """\
G00,01,field,
Z00,points,
A00,
A01,1,KP1,-2.250,1.500,3.500,
A01,2,KP2,10.000,20.000,,
A99,
D00,1,12-3,1,
"""
# table, then what stands in its first row
READ = {
    "a.xml": (LANDXML, "control_points", ["A", 1.0, 2.0, 3.0]),
    "a.kml": (KML, "control_points", ["P 1", 13.5, 48.25, 411.5, "control"]),
    "a.jxl": (JOBXML, "control_points", ["P 1", 1.5, 2.25, 3.5]),
    "a.gsi": (GSI, "control_points", ["P7", 1.5, -2.25, 3.5]),
    "a.sdr": (SDR, "control_points", ["P 7", 1.5, -2.25, 3.5]),
    "a.raw": (NIKON, "control_points", ["P 7", 1.5, -2.25, 3.5]),
    "blocks.xml": (BLOCKS, "image_points", ["b.jpg", "P 1", 100.5, 200.75]),
    "a.sim": (SIMA, "control_points", ["KP1", 1.5, -2.25, 3.5]),
    "a.gkf": (GAMA, "control_points", ["A", 1.0, 2.0]),
    "dico.xml": (DICO, "control_points", ["P1", 1.0, 2.0, 3.0, 0.01, 0.02, 0.03]),
    "mes.xml": (MEASURED, "image_points", ["a.tif", "P1", 5.5, 6.0]),
    "mmvii.xml": (MMVII, "control_points", ["002", -0.2, -0.5, 0.25, 2, 3, 4, 1]),
    "a.vrt": (VRT, "control_points", ["A", 3.5e6, 5.3e6, 12.0, "control"]),
    "a.tif.aux.xml": (ARCGIS, "image_points", ["a.tif", "1", 1.0, 2.0]),
    "a.tif.points": (QGIS, "image_points", ["a.tif", "1", 10.5, 20.25]),
    "marks.txt": (MARKS, "image_points", ["1", "317", 5007.5, 7275.25]),
    "points.txt": (POINTS_PM, "control_points", ["317", 1.5, 2.5, 3.5, 0.01, 0.02]),
    "project.txt": (PROJECT, "image_points", ["8811.jpg", "317", 5007.5, 7275.25]),
    "a.OPK": (OPK, "orientations", ["im1", 1029229.25, 6334683.5, 3660.75]),
    "a.xyz": ("ID\tX\tY\tZ\nP1 1 2 3\n", "control_points", ["P1", 1.0, 2.0, 3.0]),
    "a.app": ("P1 3 1 2 4\n", "control_points", ["P1", 1.0, 2.0, 4.0, "3"]),
    "a.mes": ("P1 im1 5.5 6 \r\n", "image_points", ["im1", "P1", 5.5, 6.0]),
    "a.con": ("7 1.5 2 1\n-99\n7 3 1\n-99\n", "control_points", ["7", 1.5, 2.0, 3.0]),
    "a.im": ("12\n7 1500 -2500\n-99\n", "image_points", ["12", "7", 1.5, -2.5]),
    "geoin.dat": (
        "CAPA 1\nCHCK P1 1 2 3\n",
        "control_points",
        ["P1", 1, 2, 3, "check"],
    ),
    "image.dat": ("12 a\n7 1.5 -2.5\n-99\n", "image_points", ["12", "7", 1.5, -2.5]),
    "itera.dat": ("ORIA 12 1 2 3 0 0 100\n", "orientations", ["12", 1.0, 2.0, 3.0]),
    "a.ori": ("12 1 2 3\n0 -1 0 1 0\n0 0 0 1\n", "orientations", ["12", 1.0, 2.0, 3.0]),
    "a.prj": (PRJ, "image_points", ["12", "P1", 1.5, -2.5]),
    "ref.csv": (REFERENCE, "control_points", ["P, 1", 13.5, 48.25, 411.5, "check"]),
}
SINEX = """\
%=SNX 2.02 EIN 26:060:43200 EIN 26:060:43200 26:060:43200 P 00003 2 S
+SITE/ID
 0000  A           P 7/8
-SITE/ID
+SOLUTION/ESTIMATE
     1 STAX   0000  A    1 26:060:43200 m    2  4.1000000000000E+06 1.0E-02
     2 STAY   0000  A    1 26:060:43200 m    2  9.0000000000000E+05 1.0E-02
     3 STAZ   0000  A    1 26:060:43200 m    2  4.8000000000000E+06 1.0E-02
-SOLUTION/ESTIMATE
+SOLUTION/MATRIX_ESTIMATE L COVA
     1     1  1.0E-04
     2     1  0.0E+00  1.0E-04
     3     1  0.0E+00  0.0E+00  1.0E-04
-SOLUTION/MATRIX_ESTIMATE L COVA
%ENDSNX
"""
DXF = """\
  0
SECTION
  2
ENTITIES
  0
POINT
  8
0
 10
13000.25
 20
322000.5
 30
411.25
  0
ENDSEC
  0
EOF
"""
SENSORS = """\
<?xml version="1.0" encoding="UTF-8"?>
<document version="1.5.0"><chunk label="Chunk 1"><sensors>
<sensor id="0" label="FC6310" type="frame"><resolution width="5472" height="3648"/>
<property name="pixel_width" value="0.00241"/>
<calibration type="frame" class="initial"><f>3000</f></calibration>
<calibration type="frame" class="adjusted"><resolution width="5472" height="3648"/>
<f>3239.25</f><cx>-17.5</cx><cy>51.75</cy><k1>-0.0625</k1><p1>0.001</p1></calibration>
</sensor></sensors><cameras><camera id="0" label="A.JPG" sensor_id="0">
<transform>1 0 0 10 0 -1 0 20 0 0 -1 100 0 0 0 1</transform></camera>
<camera id="1" label="B.JPG" sensor_id="0"/></cameras></chunk></document>
"""
# read, and not in the table above
MORE = {"Orientation-a.tif.xml": ORIENTATION, "a.snx": SINEX, "a.dxf": DXF}
MORE["cameras.xml"] = SENSORS
MORE["camera_models.json"] = """\
{"v2 x": {"projection_type": "brown", "width": 4000, "height": 3000, "focal_x": 0.85,
"focal_y": 0.86, "c_x": 0.01, "c_y": -0.02, "k1": 0.1, "k2": 0, "p1": 0, "p2": 0}}
"""
MORE["a.p4d"] = """\
<?xml version="1.0"?>
<pix4dmapper><inputs><cameras><camera name="FC330">
<imageWidth>4000</imageWidth><imageHeight>3000</imageHeight><pixelSize>1.5</pixelSize>
<principalPointXmm>3</principalPointXmm><principalPointYmm>2.25</principalPointYmm>
<lensType>perspective</lensType><focalLengthmm>3.75</focalLengthmm>
<radialK1>-0.001</radialK1><tangentialT1>0.0005</tangentialT1></camera></cameras>
<coordinateSystems><gcp><WKT>EPSG:21781</WKT></gcp></coordinateSystems>
<gcps><GCP label="P1" id="0" type="3DGCP" x="532575" y="151907" z="396"
lat="46.5" lon="6.6" alt="396" accuracyXY="0.02" accuracyZ="0.02"/></gcps>
<images><image path="C:\\a\\1.jpg" enabled="true">
<imageGCP x="562.3" y="2047.5" id="0"/></image></images></inputs></pix4dmapper>
"""
PIX4D_PARAMETERS = """\
fileName imageWidth imageHeight
camera matrix K [3x3]
radial distortion [3x1]
tangential distortion [2x1]
camera position t [3x1]
camera rotation R [3x3]
camera model m = K [R|-Rt] X

image 1.jpg 4000 3000

2300 0 2010
0 2310 1490
0 0 1
0.05 -0.02 0.003
0.001 -0.002
10 20 100
0 1 0
1 0 0
0 0 -1
b.jpg 4000 3000
2300 0 2010
0 2310 1490
0 0 1
0.05 -0.02 0.003
0.001 -0.002
30 20 100
1 0 0
0 -1 0
0 0 -1
"""
MORE["p_calibrated_camera_parameters.txt"] = PIX4D_PARAMETERS

# as Metashape 1.2 and later write it
MARKERS = """\
<?xml version="1.0" encoding="UTF-8"?>
<document version="1.2.0"><chunk>
<cameras><camera id="0" label="A.JPG"/><camera id="7" label="B.JPG"/></cameras>
<markers>
<marker id="20" label="P1">
<reference x="13.5" y="48.25" z="411.5" enabled="true"/></marker>
<marker id="21" label="P2">
<reference x="13.6" y="48.26" z="412" enabled="false"/></marker>
<marker id="22" label="tie"/>
</markers>
<reference>EPSG:4326</reference>
<frames><frame id="0"><markers>
<marker marker_id="20"><location camera_id="0" pinned="true" x="1.5" y="2.25"/>
<location camera_id="7" pinned="false" x="9" y="9"/></marker>
<marker marker_id="21"><location camera_id="7" x="3" y="4"/></marker>
<marker marker_id="22"><location camera_id="7" x="5" y="6"/></marker>
</markers></frame></frames>
</chunk></document>
"""
GCP_LIST = """\
WGS84 UTM 33N
# easting northing height column row image name
500000.25 5300000.5 411.25 1999.5 1499.5 a.jpg P1
500100.25 5300050.5 412.25 20.5 30.5 b.jpg CHK-P2
"""
GCP_JSON = """\
{"points": [{"id": "P1",
"position": {"latitude": 48.25, "longitude": 13.5, "altitude": 411.25},
"observations": [{"shot_id": "a.jpg", "projection": [0.25, -0.125]}]}]}
"""
RECONSTRUCTION = """\
[{"cameras": {"v2 x": {"projection_type": "brown", "width": 4000, "height": 3000}},
"shots": {"a.jpg": {"camera": "v2 x"}, "b.jpg": {"camera": "v2 x"}}}]
"""
TRACKS_1 = """\
OPENSFM_TRACKS_VERSION_v1
a.jpg\t7\t3\t0.25\t-0.125\t0.002\t1\t2\t3
b.jpg\t7\t4\t-0.5\t0.375\t0.002\t1\t2\t3
"""
TRACKS_2 = """\
OPENSFM_TRACKS_VERSION_v2
a.jpg\t7\t3\t0.25\t-0.125\t0.002\t1\t2\t3\t-1\t-1
b.jpg\t7\t4\t-0.5\t0.375\t0.002\t1\t2\t3\t-1\t-1
"""
TRACKS_0 = """\
a.jpg\t7\t3\t0.25\t-0.125\t1\t2\t3
b.jpg\t7\t4\t-0.5\t0.375\t1\t2\t3
"""
OPF = """\
{"format": "application/opf-project+json", "version": "1.0", "items": [
{"type": "camera_list", "resources": [{"uri": "camera_list.json",
"format": "application/opf-camera-list+json"}]},
{"type": "input_cameras", "resources": [{"uri": "input_cameras.json",
"format": "application/opf-input-cameras+json"}]},
{"type": "input_control_points", "resources": [{"uri": "input_control_points.json",
"format": "application/opf-input-control-points+json"}]},
{"type": "scene_reference_frame", "resources": [{"uri": "frame.json",
"format": "application/opf-scene-reference-frame+json"}]},
{"type": "calibration", "resources": [{"uri": "calibrated_cameras.json",
"format": "application/opf-calibrated-cameras+json"}]}]}
"""
OPF_LIST = """\
{"format": "application/opf-camera-list+json", "version": "1.0", "cameras": [
{"id": 9843086184167632639, "uri": "file:///c:/a/1.jpg"},
{"id": 12, "uri": "b%20c/2.jpg"}]}
"""
OPF_CAMERAS = """\
{"format": "application/opf-input-cameras+json", "version": "1.0", "sensors": [
{"id": 3, "name": "FC330", "image_size_px": [4000, 3000], "pixel_size_um": 1.5,
"internals": {"type": "perspective", "principal_point_px": [2000, 1500],
"focal_length_px": 2500, "radial_distortion": [0, 0, 0],
"tangential_distortion": [0, 0]}}], "captures": []}
"""
OPF_CALIBRATED = """\
{"format": "application/opf-calibrated-cameras+json", "version": "1.0", "sensors": [
{"id": 3, "internals": {"type": "perspective", "principal_point_px": [2010, 1490],
"focal_length_px": 2512.5, "radial_distortion": [0.05, -0.02, 0.003],
"tangential_distortion": [0.001, -0.002]}}], "cameras": [{"id": 12, "sensor_id": 3,
"position": [10, 20, 100], "orientation_deg": [0, 0, 90]}]}
"""
OPF_FRAME = """\
{"format": "application/opf-scene-reference-frame+json", "version": "1.0",
"crs": {"definition": "EPSG:31255"}, "base_to_canonical":
{"scale": [1, 1, 1], "shift": [-13000, -322000, -400], "swap_xy": true}}
"""
OPF_POINTS = """\
{"format": "application/opf-input-control-points+json", "version": "1.0", "gcps": [
{"id": "P1", "geolocation": {"crs": {"definition": "EPSG:31255+5778"},
"coordinates": [322100.5, 13050.25, 411.5], "sigmas": [0.03, 0.04, 0.02]},
"is_checkpoint": false, "marks": [
{"camera_id": 9843086184167632639, "position_px": [562.25, 2047.5], "accuracy": 1.0},
{"camera_id": 12, "position_px": [1562.25, 2040.5], "accuracy": 1.0}]}],
"mtps": [{"id": "M1", "is_checkpoint": false, "marks": [
{"camera_id": 12, "position_px": [20.5, 30.5], "accuracy": 1.0}]}]}
"""
OPF_FILES = {
    "camera_list.json": OPF_LIST,
    "input_cameras.json": OPF_CAMERAS,
    "calibrated_cameras.json": OPF_CALIBRATED,
    "frame.json": OPF_FRAME,
    "input_control_points.json": OPF_POINTS,
}
HOMOLOGOUS = "1.5 2.5 3.5 4.5 1\n5 6 7 8 1\n"
COLMAP = {
    "colmap/cameras.txt": CAMERAS,
    "colmap/images.txt": IMAGES,
    "colmap/points3D.txt": POINTS_3D,
}
# files that are read with others beside them: their seeds
TOGETHER = {
    "tracks.csv": (TRACKS_1, TRACKS_2, TRACKS_0),
    "reconstruction.json": (RECONSTRUCTION,),
    "gcp.json": (GCP_JSON,),
    "Pastisa.tif/b.tif.txt": (HOMOLOGOUS,),
    **{name: (text,) for name, text in COLMAP.items()},
    "project.opf": (OPF,),
    **{name: (text,) for name, text in OPF_FILES.items()},
}
SIZES = {"reconstruction.json": RECONSTRUCTION}
BESIDE = {
    "tracks.csv": SIZES,
    "gcp.json": SIZES,
    "reconstruction.json": {"tracks.csv": TRACKS_1, "gcp.json": GCP_JSON},
    **{name: COLMAP for name in COLMAP},  # noqa: C420 - fromkeys would be RUF024
    "project.opf": OPF_FILES,
    **{name: {"project.opf": OPF} | OPF_FILES for name in OPF_FILES},
}
