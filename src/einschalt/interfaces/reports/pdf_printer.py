"""The report on paper: printed into a PDF by a Chromium that is installed."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from einschalt.foundations.errors import SettingsError

BROWSERS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"),
    *("chrome", "msedge", "microsoft-edge"),
)
OPTIONS = (
    *("--headless", "--disable-gpu", "--no-first-run", "--disable-extensions"),
    *("--disable-background-networking", "--disable-component-update"),
    *("--disable-sync", "--no-pdf-header-footer", "--window-size=1200,900"),
    "--virtual-time-budget=30000",  # of the page: its timers do not wait
)
SECONDS = 180
REMEDY = (
    "Install Chromium or Google Chrome, or open report.html in any browser and print it"
)


def require_browser() -> str:
    """Path of an installed Chromium; a SettingsError where there is none."""
    found = next((place for name in BROWSERS if (place := shutil.which(name))), None)
    if found is None:
        raise SettingsError(
            "a PDF of the report needs Chromium, and none is installed",
            expected=f"one of {', '.join(BROWSERS)}",
            remedy=REMEDY,
        )
    return found


def pdf_of(html) -> bytes:
    """Print a page into a PDF, on the paper that its style names."""
    browser = require_browser()
    # the browser may still be clearing its profile away
    temporary = tempfile.TemporaryDirectory(
        prefix="einschalt-", ignore_cleanup_errors=True
    )
    with temporary as folder:
        page, printed = Path(folder, "report.html"), Path(folder, "report.pdf")
        page.write_text(html, encoding="utf-8")
        command = [browser, *OPTIONS, f"--user-data-dir={folder}/profile"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            command.append("--no-sandbox")  # as root Chromium refuses to start in one
        command += [f"--print-to-pdf={printed}", page.as_uri()]
        data = printed.read_bytes() if _has_printed(command, printed) else b""
    if not data.rstrip().endswith(b"%%EOF"):  # cut off, where the disk is full
        found = f"{browser} printed no PDF of the report"
        raise SettingsError(found, remedy=REMEDY)
    return data


def _has_printed(command, printed):
    """Whether the browser has ended well, and in time."""
    try:
        done = subprocess.run(
            command, capture_output=True, timeout=SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0 and printed.exists()
