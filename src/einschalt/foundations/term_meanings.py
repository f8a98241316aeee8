"""What terms of the glossary mean, each in a sentence.

By the first English word of their entry in the glossary, or by all of its words where
several entries begin with the same. Entries whose words say it
themselves, or that say it in brackets, have none.
"""

from einschalt.foundations.language import mark_each

MEANINGS = mark_each(
    {
        "densification point": (
            "A point between the control points, whose ground coordinates this program "
            "computes: the product of a project."
        ),
        "densification": (
            "Finding ground coordinates of many points between a few control points."
        ),
        "fixed point": (
            "A point with a lasting mark on the ground and known coordinates."
        ),
        "signalised (targeted) point": (
            "A point that was marked with a target before the flight, so that it can "
            "be seen and measured exactly in the images."
        ),
        "control point": (
            "A point of known ground coordinates, surveyed on the ground. Models of "
            "the high flight are transformed onto control points."
        ),
        "check point": (
            "A point of known ground coordinates that takes no part in the "
            "computation, and only shows how good the result is."
        ),
        "new point": "A point without ground coordinates, which are computed.",
        "tie point": (
            "A point in several models, which holds them together; its ground "
            "coordinates need not be known."
        ),
        "approximate coordinates": (
            "Ground coordinates of all points from the high flight. Models of the low "
            "flight are transformed onto them."
        ),
        "ground coordinates": (
            "Easting, northing and height in the coordinate reference system of the "
            "project, in metres."
        ),
        "machine (instrument) coordinates": (
            "Coordinates of a point as the instrument gives them for one model, in its "
            "own axes and at its own scale."
        ),
        "image coordinates": (
            "Coordinates of a point in the plane of an image, from the principal "
            "point, in millimetres."
        ),
        "stereo model": (
            "What two overlapping images show in space after relative orientation: "
            "points with coordinates in a system of their own."
        ),
        "image pair": "Two overlapping images, of which a model is formed.",
        "block": "All models of both flights, with control and settings.",
        "high flight": (
            "Flight with a small image scale, whose few large models are transformed "
            "onto control points; it gives approximate coordinates."
        ),
        "low flight": (
            "Flight with a large image scale, whose many small models give the final "
            "coordinates."
        ),
        "simultaneous adjustment": (
            "All models of both flights are transformed at once, so that they agree "
            "with control and with each other as well as can be."
        ),
        "strip": "Images that one flight line takes one after the other.",
        "scale number": (
            "How many times larger than in the image a distance is on the ground: 8000 "
            "at the image scale 1:8000."
        ),
        "flying height above ground": (
            "Height of the camera above the ground: scale number times principal "
            "distance."
        ),
        "principal distance": (
            "Distance of the projection centre from the plane of the image; about the "
            "focal length."
        ),
        "principal point": (
            "Foot of the perpendicular from the projection centre to the plane of the "
            "image."
        ),
        "interior orientation": (
            "What belongs to the camera: principal distance, principal point and "
            "distortion."
        ),
        "projection centre": "Point of the lens through which all rays pass.",
        "base": "Distance of the projection centres of the two images of a pair.",
        "base-height ratio": (
            "Base over flying height: the larger it is, the better are heights."
        ),
        "relative orientation": (
            "Turning and shifting the two images of a pair against each other until "
            "rays to the same point meet: y-parallaxes vanish."
        ),
        "y-parallax": (
            "By how much two rays to a point pass each other, at right angles to the "
            "base. It shows that the relative orientation is not right yet."
        ),
        "dangerous (critical) surface": (
            "Surface through the projection centres on which points determine the "
            "relative orientation badly or not at all, whatever is measured."
        ),
        "coplanarity condition": ("Two rays to a point and the base lie in one plane."),
        "affine transformation": (
            "Plane transformation with six parameters: shift, rotation, two scales and "
            "the angle between the axes."
        ),
        "similarity": (
            "Plane transformation with four parameters: shift, rotation and one scale."
        ),
        "rigid transformation": (
            "Plane transformation with three parameters: shift and rotation; the scale "
            "is known."
        ),
        "spatial Helmert transformation": (
            "Similarity in space with seven parameters: three shifts, three rotations "
            "and one scale."
        ),
        "residual": (
            "What a measurement would have to be changed by to agree with the adjusted "
            "result."
        ),
        "(least-squares) adjustment": (
            "Computation from more measurements than are needed, which makes the sum "
            "of the weighted squares of the residuals a minimum."
        ),
        "redundancy": "Number of measurements beyond those that are needed.",
        "standard error of unit weight": (
            "Error of one measured coordinate, as stated before the adjustment and as "
            "the residuals show it after."
        ),
        "standard error of unit weight, as a total": (
            "Error of one measured point, of both coordinates together, as the "
            "residuals of the transformation show it."
        ),
        "error of a measured point": (
            "How well a point can be measured in the plane of the image."
        ),
        "error from the transformation": (
            "What a point gets from errors of the points onto which its model is "
            "transformed."
        ),
        "leverage": (
            "Share of a measurement in its own adjusted value, from 0 to 1: near 1 "
            "nothing checks it."
        ),
        "redundancy number": (
            "Share of an error of a measurement that its own residual shows: 1 less "
            "the leverage."
        ),
        "standardized residual": (
            "Residual over its own standard error: beyond 3 to 4 a gross error is "
            "likely."
        ),
        "p-value": (
            "How likely a value as large as this, or larger, would be by chance alone."
        ),
        "significance": ("How often a test may call something an error that is none."),
        "data snooping": (
            "Search for gross errors: the measurement with the largest standardized "
            "residual is excluded if a test finds it too large, and the adjustment is "
            "repeated."
        ),
        "minimal detectable bias": (
            "Smallest gross error that a test finds in 80 of 100 cases."
        ),
        "external reliability": (
            "What a gross error that stays unseen does to the coordinates."
        ),
        "error ellipse": (
            "The ellipse about a point in which its true position lies with a given "
            "probability, as far as the errors that are known tell."
        ),
        "bundle adjustment": (
            "The adjustment of all images at once, by the rays of their points. This "
            "program adjusts models instead."
        ),
        "gross error": (
            "A mistake, such as a wrong point, name or reading, and no error of "
            "measuring."
        ),
        "strain of the network": (
            "Errors of the given coordinates that change little from one point to the "
            "next, as of an old network."
        ),
        "mirror image": (
            "Coordinates of which one axis points the wrong way: north to south, or "
            "easting and northing exchanged."
        ),
    }
)
