"""The map of a report in a browser: it draws, answers to the mouse, and loads nothing."""

import json
import shutil

import pytest
import tomli_w
from PIL import Image
from playwright.sync_api import expect, sync_playwright

from debrisflow.results import open_run
from debrisflow.results.references import read_reference
from debrisflow.results.report import report
from debrisflow.results.survey import survey
from debrisflow.results.terrain_report import terrain_report
from debrisflow.results.terrain_survey import survey_terrain
from debrisflow.study.report import study_report
from tests.fan import (
    GRID,
    fan_case,
    layers,
    terrain,
    write_classes,
    write_frames,
    write_history,
    write_layers,
    write_ledger,
)
from tests.fast.test_study_report import results_of, study_of
from tests.recording import cells, channel_case, placed, record, sliding
from tests.slow.test_render import written

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
MISSING = (
    "no Chromium was found, in which the map of a report is tested; install it (Debian: "
    "apt install chromium)"
)
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
TITLE = '<script>alert(1)</script> & </title> "fan"'


# a place on the fan
EAST, NORTH = GRID.west + 225.0, GRID.south + 180.0


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    """Return the report of a run with layers, frames of depth, a point and a section."""
    place = {"x": EAST + 0.4, "y": NORTH + 0.3, "z": 401.0}
    probes = [
        {"name": "sensor", "type": "point", "interval": 0.1} | place,
        {"name": "dam", "type": "section", "x": EAST + 0.5, "interval": 0.1},
    ]
    root = tmp_path_factory.mktemp("web")
    folder = written(root / "fan", fan_case(root, probe=probes, title=TITLE))
    samples = "time,velocity_x,velocity_y,velocity_z,pressure,concentration,wet\n"
    samples += "0,1,0,0,5,0.2,1\n10,2,0,0,nan,0.2,1\n"
    (folder / "probes" / "sensor.csv").write_text(samples)
    section = "time,discharge,sediment_discharge,concentration,speed,depth,width,volume,"
    section += "sediment_volume\n0,0,0,nan,nan,0,0,0,0\n10,3,1,0.3,2,0.5,3,9,3\n"
    (folder / "probes" / "dam.csv").write_text(section)
    write_layers(folder)
    write_frames(folder)
    write_history(folder)
    write_ledger(folder)
    return terrain_report(survey_terrain(open_run(folder)))


@pytest.fixture(scope="module")
def browser():
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    assert found, MISSING
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=found, args=QUIET)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser, page_file):
    """Return the page when its map is drawn; at its end nothing must have gone wrong in it."""
    tab = browser.new_page(viewport={"width": 1100, "height": 900})
    wrong = []
    tab.on("console", lambda message: wrong.append(message.text))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("dialog", lambda dialog: (wrong.append("dialog"), dialog.dismiss()))
    tab.on("request", lambda one: wrong.append(one.url) if one.url[:4] == "http" else None)
    tab.goto(page_file.as_uri())
    tab.wait_for_selector("#map[data-ready=yes]", timeout=20_000)
    tab.locator("#map").scroll_into_view_if_needed()
    yield tab
    assert wrong == []
    tab.close()


def on_map(page, east, north):
    """Return where a place of the map is in the window, by its coordinates, m."""
    box = page.locator("#map canvas").bounding_box()
    grid = page.evaluate("JSON.parse(document.getElementById('map-data').textContent).grid")
    scale = min((box["width"] - 2) / grid["columns"], (box["height"] - 2) / grid["rows"])
    left = 0.5 * (box["width"] - scale * grid["columns"])
    top = 0.5 * (box["height"] - scale * grid["rows"])
    column = (east - grid["west"]) / grid["cell"]
    row = (grid["north"] - north) / grid["cell"]
    return box["x"] + left + scale * column, box["y"] + top + scale * row


def drawn(page):
    """Return the pixels of the map as text, to be compared."""
    return page.evaluate("document.querySelector('#map canvas').toDataURL()")


def test_a_title_is_text(page):
    assert page.locator("h1").text_content() == TITLE
    assert page.title() == TITLE


def test_the_value_under_the_cursor_is_that_of_the_layer(page):
    row, column = 90, 45
    east = GRID.west + GRID.cell * (column + 0.5)
    north = GRID.north - GRID.cell * (row + 0.5)
    page.mouse.move(*on_map(page, east, north))
    told = page.locator("[data-part=readout]").text_content()
    depth = layers()["peak_depth"][row, column]
    assert f"Peak flow depth: {depth:.3g} m" in told
    assert f"elevation {terrain()[row, column]:.1f} m" in told


def test_layers_opacity_and_zoom_change_what_is_drawn(page):
    seen = {drawn(page)}
    page.get_by_label("Arrival time").check()
    assert "Arrival time, s" in page.locator("[data-part=key]").text_content()
    seen.add(drawn(page))
    page.locator("[data-part=opacity]").fill("30")
    seen.add(drawn(page))
    page.mouse.move(*on_map(page, EAST, NORTH))
    page.mouse.wheel(0.0, -200.0)
    page.wait_for_timeout(100)
    seen.add(drawn(page))
    assert len(seen) == 4
    page.get_by_role("button", name="show all").click()
    page.get_by_label("terrain only").check()
    assert "Arrival" not in page.locator("[data-part=key]").text_content()


def test_the_slider_goes_through_the_times(page):
    assert page.locator("[data-part=timing]").is_hidden()
    page.get_by_label("Flow depth (time)").check()
    first = drawn(page)
    page.locator("[data-part=slider]").fill("8")
    assert page.locator("[data-part=clock]").text_content() == "time 40 s"
    assert drawn(page) != first
    page.get_by_role("button", name="play").click()
    expect(page.locator("[data-part=clock]")).not_to_have_text("time 40 s")
    page.get_by_role("button", name="pause").click()


def test_a_click_shows_values_and_their_course(page):
    page.mouse.click(*on_map(page, EAST + 25.0, NORTH - 30.0))
    told = page.locator("[data-part=picked]")
    assert "Deposit thickness" in told.text_content()
    assert told.locator("svg").count() == 1  # the depth over the time


def test_a_click_on_a_probe_shows_its_curves(page):
    page.mouse.click(*on_map(page, EAST + 0.4, NORTH + 0.3))
    told = page.locator("[data-part=picked]")
    assert told.locator("strong").text_content() == "sensor"
    assert "pressure, Pa" in told.text_content()
    page.mouse.click(*on_map(page, EAST + 0.5, NORTH + 100.0))
    assert told.locator("strong").text_content() == "dam"
    assert "discharge, m3/s" in told.text_content()


SCRIPT = "</script><script>window.injected = 1</script>"
IMAGE = "<img src=x onerror='window.injected = 1'>"
QUOTE = "\" onmouseover='window.injected = 1' x=\""
HOSTILE = f"{SCRIPT}{IMAGE}{QUOTE} {{{{ 7 * 7 }}}} {{0.__class__}} $\\frac{{$ javascript:injected()"
NAME = IMAGE.replace("/", "")  # of a file


def made_hostile(folder):
    """Put hostile words into the log, the summary and the pictures of a run."""
    (folder / "run.log").write_text(f"2026 WARNING {HOSTILE}\n")
    words = {"end_reason": HOSTILE, "threading_layer": HOSTILE, "versions": {HOSTILE: HOSTILE}}
    (folder / "summary.json").write_text(json.dumps(words | {"steps": 3}))
    (folder / "render").mkdir()
    Image.new("RGB", (4, 4)).save(folder / "render" / f"{NAME}.png")


def hostile_table(file):
    """Write a table of hazard classes whose words are hostile, and return its path."""
    known = {"title": HOSTILE, "source": HOSTILE}
    classes = [
        {"name": HOSTILE, "color": "#d7191c", "any": [{"peak_depth": "> 1.0"}]},
        {"name": IMAGE, "color": "#3f6fd0"},
    ]
    file.write_text(tomli_w.dumps(known | {"class": classes}))
    return file


def hostile_fan(root, language):
    """Return the report of a run on a terrain of which all words are hostile."""
    folder = written(root / NAME, fan_case(root, title=HOSTILE, notes=HOSTILE))
    grid = GRID._replace(crs=GRID.crs.replace("JGD2011 / Japan Plane", IMAGE))
    write_layers(folder, grid)
    write_frames(folder, grid)
    write_history(folder)
    write_ledger(folder)
    write_classes(folder, str(hostile_table(root / f"{NAME}.toml")))
    made_hostile(folder)
    (root / f"{NAME}.csv").write_text("time,area\n0,0\n90,100\n")
    given = [read_reference(root / f"{NAME}.csv")]
    return terrain_report(survey_terrain(open_run(folder)), given, language)


def hostile_flume(root, language):
    """Return the report of a run in a channel of which all words are hostile."""
    case = channel_case(title=HOSTILE, notes=HOSTILE)
    block = placed(case, cells(case, range(50), range(5)), velocity=1.0)
    folder = record(root / NAME, case, sliding(case, block, (0.0, 0.1, 0.2)))
    made_hostile(folder)
    rows = "".join(f"{y},{y}\n" for y in (0.0, 0.5, 1.0))
    (root / f"{NAME}.csv").write_text(f"y_over_h,{IMAGE}\n{rows}")
    given = [read_reference(root / f"{NAME}.csv")]
    return report(survey(open_run(folder)), given, language)


@pytest.mark.parametrize("language", ["en", "ja"])
@pytest.mark.parametrize("make", [hostile_fan, hostile_flume])
def test_words_from_files_are_text_and_no_script(browser, tmp_path, make, language):
    tab = browser.new_page()
    wrong = []
    tab.on("console", lambda message: wrong.append(message.text))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("dialog", lambda dialog: (wrong.append("dialog"), dialog.dismiss()))
    tab.on("request", lambda one: wrong.append(one.url) if one.url[:4] == "http" else None)
    page = make(tmp_path, language)
    tab.goto(page.as_uri())
    if make is hostile_fan:
        tab.wait_for_selector("#map[data-ready=yes]", timeout=20_000)
        for label in tab.locator("[data-part=layers] label").all():
            label.click()
        tab.mouse.click(*on_map(tab, EAST, NORTH))
    assert tab.locator("h1").text_content() == tab.title() == HOSTILE
    assert tab.locator(".lines").text_content() == HOSTILE
    assert HOSTILE in tab.locator(".warning").first.text_content()
    assert tab.evaluate("typeof window.injected") == "undefined"
    assert tab.locator("[onerror], [onmouseover], a[href^='javascript']").count() == 0
    assert tab.locator("script").count() == (2 if make is hostile_fan else 0)
    assert wrong == []
    tab.close()


def hostile_study(root):
    """Return the page of a study of which all words are hostile."""
    results = results_of(root, study_of(title=HOSTILE, notes=HOSTILE), message=HOSTILE)
    (root / "maps").mkdir()
    (root / "maps" / f"{NAME}.csv").write_text(f"# {IMAGE}\n{IMAGE},b\n{IMAGE},1\n")
    return study_report(results, root, [root / "maps" / f"{NAME}.csv"])


def test_words_of_a_study_are_text_and_its_style_is_its_own(browser, tmp_path):
    tab = browser.new_page()
    wrong = []
    tab.on("console", lambda message: wrong.append(message.text))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("dialog", lambda dialog: (wrong.append("dialog"), dialog.dismiss()))
    tab.on("request", lambda one: wrong.append(one.url) if one.url[:4] == "http" else None)
    tab.goto(hostile_study(tmp_path).as_uri())
    assert tab.locator("h1").text_content() == tab.title() == HOSTILE
    assert tab.locator(".lines").first.text_content() == HOSTILE
    assert tab.locator(".failed .lines").text_content() == HOSTILE
    assert tab.locator("th", has_text="onerror").count() == 1
    assert tab.locator("[onerror], [onmouseover], a[href^='javascript'], script").count() == 0
    assert tab.evaluate("typeof window.injected") == "undefined"
    assert tab.evaluate("getComputedStyle(document.querySelector('.wide')).overflowX") == "auto"
    assert wrong == []
    tab.close()


def test_a_script_that_got_into_a_page_would_not_run(browser, page_file, tmp_path):
    text = page_file.read_text()
    (tmp_path / "page.html").write_text(
        text.replace("</body>", f"<script>window.injected = 1</script>{IMAGE}</body>")
    )
    tab = browser.new_page()
    refused = []
    tab.on("console", lambda message: refused.append(message.text))
    tab.goto((tmp_path / "page.html").as_uri())
    tab.wait_for_selector("#map[data-ready=yes]", timeout=20_000)
    assert tab.evaluate("typeof window.injected") == "undefined"
    assert sum("Content Security Policy" in line for line in refused) >= 2
    tab.close()
