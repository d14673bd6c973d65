"""Pages in a real browser: drawn without an error, readable on a phone, controls that work."""

from __future__ import annotations

import base64
import re
from io import BytesIO

import numpy as np
import pytest
from browser import complaints, look_like, open_page, wait_for
from matplotlib.image import imread

from solidwhirl.page.frame.build import page_html
from solidwhirl.page.frame.records import (
    Chart,
    Choice,
    Listing,
    Option,
    Picture,
    Section,
    Table,
    Text,
    Toggle,
)
from solidwhirl.page.sections import write_report

WIDE, PHONE = (1280, 900), (375, 760)
LIGHT_PAPER, DARK_PAPER = "rgb(255, 255, 255)", "rgb(20, 23, 27)"


def _chart(name, traces, layout, controls=()):
    words = {"title": name, "caption": f"{name}.", "alt": f"{name}."}
    return Chart(name=name, traces=traces, layout=layout, controls=controls, **words)


def _titled(**titles):
    return {f"{axis}axis": {"title": {"text": text}} for axis, text in titles.items()}


def _lines():
    x = np.linspace(0.0, 2.0, 5)
    which = [
        Option(label="b", traces=[1]),
        Option(label="c", traces=[2], layout={"yaxis.title.text": "y of c [m]"}),
    ]
    traces = [
        {"type": "scatter", "x": x, "y": x**2, "name": "a", "line": {"color": "@forward"}},
        {"type": "scatter", "x": x, "y": 2 * x, "name": "b", "line": {"color": "@c1"}},
        {"type": "scatter", "x": x, "y": 3 * x, "name": "c", "line": {"color": "@c2/0.5"}},
        {"type": "scatter", "x": [0.0, 1.0, 2.0], "y": np.array([1.0, np.nan, 2.0])},
    ]
    controls = (Toggle(label="first", traces=[0]), Choice(label="which", options=which))
    return _chart("lines", traces, _titled(x="x [m]", y="y [m]"), controls)


def _grid():
    z = np.arange(6.0).reshape(2, 3)
    traces = [{"type": "heatmap", "z": z, "colorscale": "Cividis"}]
    return _chart("grid", traces, _titled(x="i [1]", y="j [1]"))


def _solid():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float).T
    faces = np.array([(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]).T
    mesh = dict(zip("xyzijk", (*corners, *faces), strict=True), type="mesh3d", color="@c0")
    return _chart("solid", [mesh], {"scene": _titled(x="x [m]")})


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A page with every kind of block."""
    wide = Table(head=[f"column {k}" for k in range(14)], rows=[[1.5] * 14])
    words = Text(text="**Bold** & <b>plain</b>.\n\n- one\n- two", kind="note")
    line = '<line x1="0" y1="5" x2="1000" y2="5" stroke="var(--ink)"/>'
    svg = f'<svg viewBox="0 0 1000 10">{line}</svg>'
    picture = Picture(data=svg, caption="A line.", alt="A line.", scroll_px=900)
    blocks = (words, wide, picture, Listing(text="x" * 400), _lines(), _grid(), _solid())
    first = Section(name="first", title="First", blocks=blocks, note="A note.")
    filler = Section(name="last", title="Last", blocks=(Text(text="word " * 4000),))
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(page_html([first, filler], title="A title", name="test"), encoding="utf-8")
    return path


def _full(driver, key):
    return driver.execute_script(f"return document.getElementById('lines').{key}")


def test_charts_have_their_arrays_and_controls(driver, page):
    look_like(driver, *WIDE)
    open_page(driver, page)
    drawn = driver.execute_script(
        "return [...document.querySelectorAll('.plot')].map(h => [h.id, h.dataset.drawn,"
        " h.querySelectorAll('svg.main-svg, canvas').length > 0])"
    )
    assert drawn == [["lines", "yes", True], ["grid", "yes", True], ["solid", "yes", True]]
    # nothing is loaded beside the file, and scripts of the page could not
    assert driver.execute_script("return performance.getEntriesByType('resource').length") == 0
    x = np.linspace(0.0, 2.0, 5)
    assert _full(driver, "data.map(t => Array.from(t.y))")[0] == pytest.approx(x**2)
    # json of the driver has no nan: a gap arrives as null
    assert _full(driver, "data[3].y.length") == 3
    assert _full(driver, "calcdata[3].map(p => Number.isFinite(p.y))") == [True, False, True]
    z = driver.execute_script(
        "return document.getElementById('grid')._fullData[0].z.map(r => Array.from(r))"
    )
    assert z == [[0, 1, 2], [3, 4, 5]]
    shown = "_fullData.map(t => t.visible)"
    assert _full(driver, shown) == [True, True, False, True]
    box, choice = driver.find_elements("css selector", ".controls[data-for=lines] [data-control]")
    box.click()
    wait_for(driver, "return document.getElementById('lines')._fullData[0].visible === false")
    assert _full(driver, shown) == [False, True, False, True]
    assert _full(driver, "_fullLayout.yaxis.title.text") == "y [m]"
    choice.find_elements("tag name", "option")[1].click()
    wait_for(driver, "return document.getElementById('lines')._fullData[2].visible === true")
    assert _full(driver, shown) == [False, False, True, True]
    assert _full(driver, "_fullLayout.yaxis.title.text") == "y of c [m]"
    assert complaints(driver) == []


def test_an_old_browser_is_told_why_there_is_no_chart(driver, page):
    look_like(driver, *WIDE)
    script = {"source": "delete window.DecompressionStream"}
    added = driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", script)
    try:
        driver.get(page.as_uri())
        said = "return document.getElementById('lines').textContent"
        wait_for(driver, f"{said}.length > 0")
        assert "too old" in driver.execute_script(said)
    finally:
        driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


def test_colours_follow_the_system_the_reader_and_the_printer(driver, page):
    look_like(driver, *WIDE, dark=True)
    open_page(driver, page)
    paper = "return getComputedStyle(document.body).backgroundColor"
    color = "document.getElementById('lines')._fullData[0].line.color"
    assert driver.execute_script(paper) == DARK_PAPER
    assert driver.execute_script(f"return {color}") == "#4fb3e8"
    _has_contrast(driver.execute_script("return solidwhirl.theme()"))
    options = driver.find_elements("css selector", "#theme option")
    assert [o.get_attribute("value") for o in options] == ["auto", "light", "dark"]
    options[1].click()
    wait_for(driver, f"return {color} === '#0072b2'")
    assert driver.execute_script(paper) == LIGHT_PAPER
    _has_contrast(driver.execute_script("return solidwhirl.theme()"))
    # opacity behind a token
    third = "return document.getElementById('lines').data[2].line.color"
    assert driver.execute_script(third).replace(" ", "") == "rgba(0,158,115,0.5)"
    options[0].click()
    wait_for(driver, f"return getComputedStyle(document.body).backgroundColor === '{DARK_PAPER}'")
    # on paper it is light and complete, and dark again afterwards
    driver.execute_script(
        "window.seen = []; window.addEventListener('beforeprint', () => seen.push("
        "document.documentElement.dataset.theme))"
    )
    pdf = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert pdf.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) >= 3
    assert driver.execute_script("return window.seen") == ["light"]
    wait_for(driver, "return document.documentElement.dataset.theme === 'dark'")
    assert not driver.execute_script("return document.documentElement.className")
    assert complaints(driver) == []


def _has_contrast(theme):
    """WCAG's ratio of luminances is 4.5 at least for words, 3 for what is drawn."""
    for name in ("ink", "muted", "good", "bad"):
        for ground in ("paper", "panel"):
            assert _contrast(theme[name], theme[ground]) >= 4.5, (name, ground, theme)
    # sky, orange and purple of Okabe and Ito are lighter; marks and dashes tell them apart
    for name in ("forward", "backward", "mixed", "straight", "c0", "c1", "c2"):
        assert _contrast(theme[name], theme["paper"]) >= 3.0, (name, theme)


def _contrast(first, second):
    light, dark = sorted((_luminance(first), _luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _luminance(color):
    values = [int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in values]
    return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))


def test_a_phone_scrolls_down_and_wide_things_in_their_boxes(driver, page):
    """An edge behind which there is more is shaded, as pixels tell, until the end is reached."""
    look_like(driver, *PHONE)
    open_page(driver, page)
    assert driver.execute_script("return document.documentElement.scrollWidth") <= PHONE[0]
    for box in (".table", ".scroll"):
        inner = driver.execute_script(
            f"const b = document.querySelector('{box}'); return [b.scrollWidth, b.clientWidth]"
        )
        assert inner[0] > inner[1] > 0
    assert driver.execute_script("return document.getElementById('contents').open") is False

    def edges(left):
        driver.execute_script(
            "const b = document.querySelector('.table'); b.scrollLeft = arguments[0];"
            "b.scrollIntoView({behavior: 'instant', block: 'center'})",
            left,
        )
        file = BytesIO(driver.find_element("css selector", ".table").screenshot_as_png)
        found = imread(file)[:, :, :3].mean(axis=2)
        # most of a column is paper, whatever is written in it
        return np.median(found[:, 2]), np.median(found[:, -3]), np.median(found)

    for theme in ("light", "dark"):
        look_like(driver, *PHONE, dark=theme == "dark")
        wait_for(driver, f"return document.documentElement.dataset.theme === '{theme}'")
        first, last, paper = edges(0)
        assert (paper < 0.5) == (theme == "dark")
        assert abs(last - paper) > 0.1 and abs(first - paper) < 0.02
        first, last, paper = edges(10_000)
        assert abs(first - paper) > 0.1 and abs(last - paper) < 0.02
    assert complaints(driver) == []


@pytest.mark.solver
def test_the_page_of_a_run(driver, laval, tmp_path):
    """At 1400 by 900 the first screen has verdict, diagram and drawing; a phone shows them in turn.

    All of it is drawn, links lead somewhere, and no label of the drawing covers another.
    """
    path = tmp_path / "report.html"
    write_report(laval, path)
    look_like(driver, 1400, 900)
    open_page(driver, path)
    parts = ("#summary .row table", "#campbell-small", "#summary .picture svg")
    for part in parts:
        box = driver.execute_script(
            f"return document.querySelector('{part}').getBoundingClientRect().toJSON()"
        )
        assert box["top"] > 0 and box["bottom"] <= 900 and box["height"] > 60, (part, box)
    # the drawing, the last of them, takes most of the width beside the diagram
    assert box["width"] > 500 and box["height"] > 250
    undrawn = driver.execute_script(
        "return [...document.querySelectorAll('.plot')].filter(h => h.dataset.drawn !== 'yes'"
        " || !h.querySelector('svg.main-svg, canvas')).map(h => h.id)"
    )
    assert undrawn == []
    for host in driver.find_elements("css selector", ".viewer"):
        driver.execute_script("arguments[0].scrollIntoView({behavior: 'instant'})", host)
        name = host.get_attribute("id")
        wait_for(driver, f"return document.getElementById('{name}').dataset.drawn !== undefined")
    assert driver.execute_script(
        "return [...document.querySelectorAll('nav a')].every(a =>"
        " document.getElementById(a.hash.slice(1)) !== null)"
    )
    boxes = driver.execute_script(
        "return [...document.querySelectorAll('#engine svg text')].map(t => {"
        " const b = t.getBoundingClientRect(); return [t.textContent, b.left, b.top, b.right,"
        " b.bottom] })"
    )
    assert len(boxes) > 8
    for k, (name, left, top, right, bottom) in enumerate(boxes):
        for other, l2, t2, r2, b2 in boxes[k + 1 :]:
            apart = right <= l2 or r2 <= left or bottom <= t2 or b2 <= top
            assert apart, (name, other)
    assert complaints(driver) == []

    look_like(driver, *PHONE)
    open_page(driver, path)
    assert driver.execute_script("return document.documentElement.scrollWidth") == PHONE[0]
    tops = driver.execute_script(
        f"return {list(parts)}.map(p => document.querySelector(p).getBoundingClientRect().top)"
    )
    assert tops == sorted(tops)
    assert complaints(driver) == []
