"""The page in a real browser: edits, errors, sliders, numbers written back, a lost connection."""

from __future__ import annotations

import pytest
from browser import complaints, look_like, wait_for
from selenium.webdriver.common.keys import Keys
from watched_scene import SCENE

from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene_reading.reader import read_scene

STIFFNESS = "bearings.1.stiffness_n_per_m"
STATE = "document.getElementById('picture').dataset"


@pytest.fixture
def page(driver, serve, follow, scene_path):
    """The page of the scene, drawn; the server with it."""
    server = serve(follow(scene_path))
    look_like(driver, 1280, 1000)
    # the page of an earlier test calls for its server until it is left
    driver.get("about:blank")
    driver.get_log("browser")
    driver.get(server.address)
    _wait_whole(driver, "{}")
    wait_for(driver, "return document.getElementById('campbell').dataset.drawn === 'yes'")
    return server


def _wait_whole(driver, positions):
    wait_for(driver, f"return {STATE}.stage === 'whole' && {STATE}.positions === '{positions}'")


def _text(driver, name):
    return driver.execute_script(f"return document.getElementById('{name}').textContent")


def _speeds(scene, **bearing):
    found = reduce_scene(scene).with_(**bearing).critical_speeds()
    return [f"{c.critical.speed_rad_s * RPM_PER_RAD_S:.1f}" for c in found]


def _shown(driver):
    """Critical speeds in the table."""
    return driver.execute_script(
        "return [...document.querySelectorAll('#critical-speeds tbody tr')].map("
        "r => r.cells[0].textContent)"
    )


def _number(driver, name):
    return driver.find_element("css selector", f"input[type=number][data-name='{name}']")


def test_the_page_shows_the_scene(driver, page, scene_path):
    scene = read_scene(scene_path)
    assert _text(driver, "title") == scene.title and str(scene_path) in _text(driver, "file")
    assert _shown(driver) == _speeds(scene)
    assert "stable" in _text(driver, "verdict") and "Log. decrement" in _text(driver, "verdict")
    assert "level beam" in _text(driver, "level")
    drawn = driver.execute_script(
        "return [document.querySelector('#drawing svg') !== null,"
        " document.querySelectorAll('#campbell svg.main-svg').length > 0]"
    )
    assert drawn == [True, True]
    # nothing comes from elsewhere
    names = driver.execute_script(
        "return performance.getEntriesByType('resource').map(r => r.name)"
    )
    assert names == [f"{page.address}plotly.js"]
    # a phone scrolls down only
    look_like(driver, 375, 760)
    wait_for(driver, "return document.documentElement.scrollWidth <= 375")
    assert complaints(driver) == []


def test_an_edit_changes_the_page_and_an_error_stands_at_its_line(driver, page, scene_path):
    scene_path.write_text(SCENE.replace("mass_kg = 8.0", "mass_kg = 12.0"), encoding="utf-8")
    wanted = _speeds(read_scene(scene_path))
    wait_for(
        driver,
        f"return document.getElementById('critical-speeds').textContent.includes('{wanted[0]}')",
    )
    assert _shown(driver) == wanted
    scene_path.write_text(SCENE.replace('"rotor.b"', '"rotor.c"'), encoding="utf-8")
    wait_for(driver, "return document.body.classList.contains('stale')")
    problem = driver.find_element("css selector", "#problems .problem")
    assert problem.text.startswith("29:1 bearings[1].first: ")
    assert '29 | first = "rotor.c"' in problem.text
    assert _shown(driver) == wanted  # the last good picture, grey
    opacity = "return Number(getComputedStyle(document.getElementById('picture')).opacity)"
    assert driver.execute_script(opacity) < 1
    scene_path.write_text(SCENE, encoding="utf-8")
    wait_for(driver, "return !document.body.classList.contains('stale')")
    assert driver.find_elements("css selector", "#problems .problem") == []
    assert complaints(driver) == []


def test_sliders_recompute_and_are_written_into_the_file(driver, page, scene_path):
    write, reset = (driver.find_element("id", name) for name in ("write", "reset"))
    assert not write.is_enabled() and not reset.is_enabled()
    slider = driver.find_element("id", f"slider-{STIFFNESS}")
    for _ in range(12):
        slider.send_keys(Keys.ARROW_LEFT)
    value = float(_number(driver, STIFFNESS).get_attribute("value"))
    assert 1e6 < value < 1e7
    _wait_whole(driver, f'{{"{STIFFNESS}": {value!r}}}'.replace('": ', '":').replace(".0}", "}"))
    assert _shown(driver) == _speeds(read_scene(scene_path), b=value)
    reset.click()
    _wait_whole(driver, "{}")
    assert float(_number(driver, STIFFNESS).get_attribute("value")) == 1e7
    assert _shown(driver) == _speeds(read_scene(scene_path))

    field = _number(driver, STIFFNESS)
    field.send_keys(Keys.CONTROL, "a", Keys.NULL, "4e6", Keys.TAB)
    _wait_whole(driver, f'{{"{STIFFNESS}":4000000}}')
    assert _shown(driver) == _speeds(read_scene(scene_path), b=4e6)
    write.click()
    wait_for(driver, "return document.getElementById('written').textContent.includes('1 number')")
    wanted = SCENE.replace(
        '"rotor.b"\nstiffness_n_per_m = 1e7', '"rotor.b"\nstiffness_n_per_m = 4e6'
    )
    assert scene_path.read_text(encoding="utf-8") == wanted
    _wait_whole(driver, "{}")
    assert not write.is_enabled()
    assert _shown(driver) == _speeds(read_scene(scene_path))
    assert complaints(driver) == []


def test_positions_that_can_not_be_are_told(driver, page):
    field = _number(driver, "operating.0.to_rpm")
    field.send_keys(Keys.CONTROL, "a", Keys.NULL, "100", Keys.TAB)
    wait_for(driver, "return document.querySelector('#refused .problem') !== null")
    assert "to_rpm = 100 is below from_rpm = 9000" in _text(driver, "refused")
    driver.find_element("id", "reset").click()
    wait_for(driver, "return document.querySelector('#refused .problem') === null")


def test_a_lost_connection_is_told_and_taken_up_again(driver, page, serve, follow, scene_path):
    page.end_here()
    wait_for(driver, "return document.body.classList.contains('lost')")
    assert "connection lost" in _text(driver, "state")
    # meanwhile the file changes
    scene_path.write_text(SCENE.replace("mass_kg = 8.0", "mass_kg = 12.0"), encoding="utf-8")
    driver.execute_script(f"delete {STATE}.stage")
    again = serve(follow(scene_path), port=page.port, token=page.token)
    assert again.address == page.address
    wait_for(driver, "return !document.body.classList.contains('lost')")
    _wait_whole(driver, "{}")
    assert _shown(driver) == _speeds(read_scene(scene_path))
    # and sliders move
    driver.find_element("id", f"slider-{STIFFNESS}").send_keys(Keys.ARROW_LEFT)
    wait_for(driver, f"return {STATE}.positions !== '{{}}'")


def test_a_second_page_has_the_positions_of_the_first(driver, page):
    field = _number(driver, STIFFNESS)
    field.send_keys(Keys.CONTROL, "a", Keys.NULL, "4e6", Keys.TAB)
    _wait_whole(driver, f'{{"{STIFFNESS}":4000000}}')
    shown = _shown(driver)
    driver.refresh()
    _wait_whole(driver, f'{{"{STIFFNESS}":4000000}}')
    assert float(_number(driver, STIFFNESS).get_attribute("value")) == 4e6
    assert _shown(driver) == shown
    assert driver.find_element("id", "write").is_enabled()
