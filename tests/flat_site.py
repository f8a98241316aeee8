"""A system of one site: flat, and true to scale.

Where its coordinates are Cartesian, what is measured follows from them alone.
"""

FLAT_SITE = (
    'ENGCRS["site",EDATUM["site"],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],'
    'LENGTHUNIT["metre",1]]'
)
