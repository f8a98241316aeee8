"""What remains of a run: one file with machine and versions, and the figure of growth.

``out/bench/races.json`` and ``out/bench/growth.png``.
"""

import json
import math
import os
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

FOLDER = Path("out/bench")
PEERS = (
    *("numpy", "scipy", "pandas", "numba", "pyarrow", "pyogrio", "statsmodels"),
    *("scikit-image", "opencv-python-headless", "poselib", "pycolmap", "polars"),
    *("duckdb", "geopandas", "pypardiso", "scikit-sparse"),
)


def keep(races, seconds) -> int:
    """Write file and figure, and say whether floors and goals are kept.

    ``races`` has a list of Race by name. Gives 0 if every floor is kept, otherwise 1.
    """
    every = [race for of_name in races.values() for race in of_name]
    rows = [row for race in every for row in race.outcomes if row.bound]
    FOLDER.mkdir(parents=True, exist_ok=True)
    written = {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "seconds": round(seconds, 1),
        "machine": machine(),
        "versions": versions(),
        "races": {
            name: [_as_record(race) for race in of_name]
            for name, of_name in races.items()
        },
    }
    text = json.dumps(written, indent=1, ensure_ascii=False)
    (FOLDER / "races.json").write_text(text + "\n", encoding="utf-8")
    lines = [race for race in every if race.growth]
    if lines:
        draw(lines, FOLDER / "growth.png")
    n_kept = sum(row.is_kept for row in rows)
    n_reached = sum(row.is_reached for row in rows)
    print(
        f"\n{n_kept} of {len(rows)} floors kept, {n_reached} goals reached, in "
        f"{seconds / 60.0:.1f} min on {written['machine']['processor']}; "
        f"{FOLDER / 'races.json'}"
    )
    print("every floor is kept" if n_kept == len(rows) else "a floor was missed")
    return 0 if n_kept == len(rows) else 1


def machine():
    """Processor, cores and memory of this machine."""
    return {
        "processor": _processor(),
        "n_cores": os.cpu_count(),
        "memory_gib": round(_memory() / 2**30, 1),
        "system": platform.platform(),
        "python": platform.python_version(),
        "load_before": [round(load, 2) for load in os.getloadavg()],
    }


def versions():
    """Versions of ours and of the peers that are installed."""
    found = {}
    for name in ("einschalt", *PEERS):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _processor():
    info = Path("/proc/cpuinfo")
    if not info.exists():
        return platform.processor() or platform.machine()
    lines = info.read_text(encoding="utf-8").splitlines()
    names = [line for line in lines if line.startswith("model name")]
    return names[0].partition(":")[2].strip() if names else platform.machine()


def _memory():
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _as_record(race):
    return {
        "title": race.title,
        "rows": [_row(outcome) for outcome in race.outcomes],
        "growth": race.growth,
    }


def _row(outcome):
    bound = outcome.bound and asdict(outcome.bound)
    row = {
        "name": outcome.name,
        "figure": outcome.figure,
        "ratio": outcome.ratio,
        "peak_mb": outcome.peak_mb,
        "bound": bound,
        "is_kept": outcome.is_kept,
        "is_reached": outcome.is_reached,
    }
    is_missing = {key for key, value in row.items() if _is_nan(value)}
    return row | dict.fromkeys(is_missing)


def _is_nan(value):
    return isinstance(value, float) and math.isnan(value)


def draw(races, path):
    """Seconds against numbers of models or pairs, both logarithmic."""
    import matplotlib as mpl  # noqa: PLC0415 - only where something is drawn

    mpl.use("Agg")
    from matplotlib import pyplot as plt  # noqa: PLC0415

    figure, axes = plt.subplots(figsize=(7.0, 5.0), layout="constrained")
    for race in races:
        sizes, seconds = zip(*sorted(race.growth.items()), strict=True)
        axes.loglog(sizes, seconds, marker="o", label=race.title.partition(":")[0])
    low, high = axes.get_xlim()
    ends = [max(low, 1e3), min(high, 1e6)]
    bottom = min(min(race.growth.values()) for race in races)
    line = [bottom, bottom * ends[1] / ends[0]]
    axes.loglog(ends, line, "k:", linewidth=1, label="in proportion")
    axes.set(xlabel="models or pairs", ylabel="seconds")
    axes.grid(visible=True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=120)
    plt.close(figure)
