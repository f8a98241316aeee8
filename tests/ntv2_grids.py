"""Small grids of datum shifts, as PROJ reads them."""

import struct


def write_ntv2(path, north_shift, east_shift):
    """A grid of Central Europe with the same shift [seconds] everywhere, as NTv2."""

    def record(name, value):
        text = isinstance(value, str)
        whole = isinstance(value, int)
        packed = value.ljust(8).encode() if text else struct.pack("<d", value)
        packed = struct.pack("<i4x", value) if whole else packed
        return name.ljust(8).encode() + packed

    south, north, west, east = 45, 56, 5, 18
    n_nodes = (north - south + 1) * (east - west + 1)
    counts = {"NUM_OREC": 11, "NUM_SREC": 11, "NUM_FILE": 1}
    names = {"GS_TYPE": "SECONDS", "VERSION": "", "SYSTEM_F": "A", "SYSTEM_T": "B"}
    bessel, grs80 = (6377397.155, 6356078.963), (6378137.0, 6356752.314)
    axes = {"MAJOR_F": bessel[0], "MINOR_F": bessel[1]}
    axes |= {"MAJOR_T": grs80[0], "MINOR_T": grs80[1]}
    part = {"SUB_NAME": "ONE", "PARENT": "NONE", "CREATED": "", "UPDATED": ""}
    # west is positive
    part |= {"S_LAT": south * 3600.0, "N_LAT": north * 3600.0}
    part |= {"E_LONG": -east * 3600.0, "W_LONG": -west * 3600.0}
    part |= {"LAT_INC": 3600.0, "LONG_INC": 3600.0, "GS_COUNT": n_nodes}
    header = b"".join(record(*one) for one in (counts | names | axes | part).items())
    node = struct.pack("<4f", north_shift, -east_shift, 0.0, 0.0)
    path.write_bytes(header + node * n_nodes + record("END", 0.0))
