"""A real browser for tests of pages: Debian's chromium without a window."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHROMIUM, DRIVER = Path("/usr/bin/chromium"), Path("/usr/bin/chromedriver")
_ARGUMENTS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-background-networking",
    # 3D charts without a graphics card
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
# Far more than a page needs, for machines that do much else.
_PATIENCE_S = 180.0


@contextmanager
def browser() -> Iterator[Any]:
    """Start the browser; a test without one fails, it is not skipped."""
    from selenium import webdriver

    for file in (CHROMIUM, DRIVER):
        assert file.exists(), f"{file} is missing; `tools/setup.sh browser` installs it"
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    for argument in _ARGUMENTS:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(str(DRIVER)))
    try:
        driver.set_script_timeout(_PATIENCE_S)
        yield driver
    finally:
        driver.quit()


def look_like(driver: Any, width: int, height: int, *, dark: bool = False) -> None:
    """Give the browser a screen and the colours that its user likes.

    Parameters
    ----------
    driver
        The browser.
    width, height
        Of the screen in CSS pixels; below 600 it is a phone that is touched.
    dark
        Whether the system's colours are dark.
    """
    phone = width < 600
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": phone}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": phone})
    feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})


def open_page(driver: Any, path: Path) -> None:
    """Open a page and wait until everything in it is drawn.

    Parameters
    ----------
    driver
        The browser.
    path
        The file.
    """
    driver.get_log("browser")  # forget what was said of the page before
    driver.get(path.as_uri())
    wait_for(driver, "return document.documentElement.dataset.drawn === 'all'")


def wait_for(driver: Any, script: str) -> None:
    """Wait until a script returns what is true."""
    end = time.monotonic() + _PATIENCE_S
    while not driver.execute_script(script):
        assert time.monotonic() < end, f"waited {_PATIENCE_S:.0f} s for: {script}"
        time.sleep(0.05)


def complaints(driver: Any) -> list[str]:
    """Errors that the browser wrote to its console since the last call."""
    return [e["message"] for e in driver.get_log("browser") if e["level"] == "SEVERE"]
