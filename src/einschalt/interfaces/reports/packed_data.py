"""Tables of the report as compressed binary: whole numbers of a quantum, in text.

The layout is that of ``page/decode.js``: a JSON head, then for each array its bytes,
the lowest of all numbers first, so that deflate finds what is alike. 0 is a value that
is missing.
"""

import base64
import json
import re
import zlib
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import printable

LENGTH = 4  # bytes that say how long the head is
NUMBERED = re.compile(r"^(.*?)(0|[1-9]\d{0,8})$", re.DOTALL)
MOST = 0xFFFF_FFF0


@dataclass
class PackedData:
    """Head and arrays of a page, as they are put together.

    Attributes
    ----------
    head : dict
        What stands in JSON: texts, figures, and of each array where it lies.
    """

    head: dict = field(default_factory=dict)
    _parts: list = field(default_factory=list)

    def numbers(self, values, quantum):
        """Keep numbers to the next quantum, NaN included; say where they are.

        Where they lie too far apart for 32 bits, the quantum is a coarser one.
        """
        values = np.asarray(values, dtype=float)
        is_known = np.isfinite(values)
        known = values[is_known]
        while known.size and np.ptp(known) / quantum > MOST:
            quantum *= 10.0
        rounded = np.round(np.where(is_known, values, 0.0) / quantum)
        low = float(rounded[is_known].min()) if is_known.any() else 0.0
        shifted = np.where(is_known, rounded - low + 1.0, 0.0)
        return {"quantum": quantum, "low": low, **self._bytes(shifted)}

    def codes(self, texts):
        """Keep texts that repeat: each once, and the place of each row's."""
        codes, seen = pd.factorize(np.array(list(texts), dtype=object))
        shown = [printable(str(text)) for text in seen]
        return {"texts": shown, **self.numbers(codes, 1.0)}

    def names(self, texts):
        """Keep names by what precedes their number, and by their number."""
        halves = [_halves(printable(text)) for text in texts]
        return {
            "stem": self.codes(stem for stem, _ in halves),
            "number": self.numbers([number for _, number in halves], 1.0),
        }

    def _bytes(self, shifted):
        """The shorter one of the numbers themselves and of their differences."""
        whole = shifted.astype(np.uint32)
        step = np.diff(whole.astype(np.int64), prepend=0)
        zigzag = np.where(step < 0, -2 * step - 1, 2 * step)
        ways = [(False, _planes(whole))]
        if zigzag.max(initial=0) <= MOST:
            ways.append((True, _planes(zigzag.astype(np.uint32))))
        sizes = [len(zlib.compress(planes, 1)) for _, planes in ways]
        is_stepwise, planes = ways[int(np.argmin(sizes))]
        place = sum(map(len, self._parts))
        self._parts.append(planes)
        width = len(planes) // len(whole) if len(whole) else 0
        facts = {"n": len(whole), "at": place, "width": width}
        return {**facts, "steps": True} if is_stepwise else facts

    def text(self) -> str:
        """Everything, compressed, in base64: fit to stand in a page."""
        head = json.dumps(self.head, ensure_ascii=False, allow_nan=False)
        head = head.encode("utf-8", errors="replace")
        content = len(head).to_bytes(LENGTH, "little") + head + b"".join(self._parts)
        return base64.b64encode(zlib.compress(content, 9)).decode("ascii")


def _planes(whole):
    """Bytes of numbers, the lowest of all first; no more of them than are needed."""
    width = max((int(whole.max(initial=0)).bit_length() + 7) // 8, 1)
    octets = whole.astype("<u4").view(np.uint8).reshape(-1, 4)
    return octets[:, :width].T.tobytes()


def _halves(name):
    found = NUMBERED.match(name)
    return (found[1], float(found[2])) if found else (name, np.nan)


def quantum_of(values, parts=100.0):
    """Power of ten, or twice or five times one, that divides usual values finely.

    >>> quantum_of([0.031, 0.052, 0.048])
    0.0002
    """
    sizes = np.abs(np.asarray(values, dtype=float))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0.0)]
    if not sizes.size:
        return 1.0
    wanted = float(np.median(sizes)) / parts
    power = 10.0 ** np.floor(np.log10(wanted))
    step = max(step for step in (1.0, 2.0, 5.0) if step * power <= wanted * (1 + 1e-9))
    return float(f"{step * power:.0e}")
