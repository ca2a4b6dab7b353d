"""report.html in a real browser: it loads, plays, follows the slider, shows fields, and asks nobody for anything."""

import json
import re

import numpy as np
import pytest

import feed
from chromium import Watched, launch
from warp_origami.output.report.page import build_report
from warp_origami.output.run_directory import RunDirectory
from warp_origami.solve.records import Frame

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

POINTS = "Array.from(report.animation.sheet.points)"
FRAME = "report.animation.player.frame"
DISTANCE = "report.animation.stage.camera.position.distanceTo(report.animation.stage.controls.target)"
DIRECTION = (
    "report.animation.stage.camera.position.clone().sub(report.animation.stage.controls.target).normalize().toArray()"
)
COLOURS = """() => {
  report.animation.stage.drawNow();
  const from = document.getElementById("canvas");
  const to = document.createElement("canvas");
  [to.width, to.height] = [from.width, from.height];
  const context = to.getContext("2d");
  context.drawImage(from, 0, 0);
  const { data } = context.getImageData(0, 0, to.width, to.height);
  let [sum, count] = [[0, 0, 0], 0];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] < 255) continue;
    for (let c = 0; c < 3; c++) sum[c] += data[i + c];
    count++;
  }
  return [...sum.map((value) => value / count), count];
}"""


@pytest.fixture(scope="module")
def playwright():
    with sync_api.sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="module")
def browser(playwright):
    browser = launch(playwright)
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    feed.feed(RunDirectory(folder), feed.scene(), 1.0, elements=16, phases={"assembly": 1.0, "contact": 2.0})
    return folder


@pytest.fixture(scope="module")
def opened(browser, folder):
    return Watched(browser, folder / "report.html", viewport={"width": 1300, "height": 900})


@pytest.fixture
def page(opened):
    """The page at its first frame, and without a fault at the end."""
    opened.page.evaluate("report.animation.player.seek(0)")
    yield opened.page
    assert opened.faults == []


def until(page, condition):
    """Waits; the browser's own way needs `eval`, which the page forbids."""
    for _ in range(300):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(50)
    raise AssertionError(condition)


def expected(frame):
    return feed.bent(feed.SURFACE.flat, frame / feed.FPS)


def drawn(page):
    """Points that are drawn and the mean colour (RGB) and number of the pixels of the sheet."""
    *colour, count = page.evaluate(COLOURS)
    return np.reshape(page.evaluate(POINTS), (-1, 3)), np.array(colour), count


def test_slider_moves_the_sheet(page):
    slider = page.locator("#time")
    assert (slider.get_attribute("min"), slider.get_attribute("max")) == ("0", "20")
    first = drawn(page)
    slider.fill("20")
    last = drawn(page)
    for (points, _, count), frame in ((first, 0), (last, 20)):
        assert np.allclose(points, expected(frame), rtol=0, atol=1.5 / 65535)
        assert count > 5000
    assert abs(last[2] - first[2]) > 0.1 * first[2]  # rolled up it takes less room in the picture
    assert page.locator("#clock").inner_text() == "1.000 s"
    assert page.locator("#time").get_attribute("aria-valuetext") == "1.000 s"


def test_plays_and_pauses(page):
    button = page.locator("#play")
    button.click()
    until(page, f"{FRAME} > 2")
    assert button.get_attribute("aria-label") == "Pause"
    button.click()
    frame = page.evaluate(FRAME)
    page.wait_for_timeout(300)
    assert page.evaluate(FRAME) == frame
    assert button.get_attribute("aria-label") == "Play"


def test_plays_once_or_in_a_loop(page):
    page.locator("#speed").select_option(label="1 × real time")
    page.locator("#loop").uncheck()
    page.evaluate("report.animation.player.seek(0.9)")
    page.locator("#play").click()
    until(page, "!report.animation.player.playing")
    assert page.evaluate(FRAME) == 20
    page.locator("#loop").check()
    page.evaluate("report.animation.player.seek(0.9)")
    page.locator("#play").click()
    until(page, f"{FRAME} < 10")
    page.locator("#play").click()


def test_keys(page):
    page.locator("#canvas").focus()
    for key, frame in (("ArrowRight", 1), ("Shift+ArrowRight", 11), ("ArrowLeft", 10), ("End", 20), ("Home", 0)):
        page.keyboard.press(key)
        assert page.evaluate(FRAME) == frame
    page.keyboard.press("Space")
    until(page, f"{FRAME} > 0")
    page.keyboard.press("Space")
    assert not page.evaluate("report.animation.player.playing")
    page.keyboard.press("c")
    assert not page.evaluate("report.animation.sheet.mesh.visible")
    assert page.evaluate("report.animation.sheet.creases.visible")
    page.keyboard.press("c")
    assert page.evaluate("report.animation.sheet.mesh.visible")


def test_colours_follow_the_field_and_the_bar_has_its_unit(page):
    page.locator("#time").fill("20")
    options = page.locator("#field option").all_inner_texts()
    assert options == ["von Mises stress", "wrinkle state", "displacement", "none: two sides"]
    seen = {}
    for label in options:
        page.locator("#field").select_option(label=label)
        seen[label] = drawn(page)[1]
    legends = np.array(list(seen.values()))
    differences = np.abs(legends[:, None] - legends[None]).max(axis=-1)
    assert np.all(differences[~np.eye(len(options), dtype=bool)] > 10.0)
    page.locator("#field").select_option("von_mises")
    assert "von Mises stress (kPa)" in page.locator("#legend").inner_text()
    assert "now 0 to 1000" in page.locator("#legend").inner_text()
    values = page.evaluate("Array.from(report.animation.sheet.pointValues)")
    assert np.allclose(values, 1e6 * feed.SURFACE.flat[:, 0], rtol=1 / 1024, atol=1.0)


def test_range_of_the_colours(page):
    page.locator("#time").fill("10")
    page.locator("#field").select_option("von_mises")
    limits = "report.animation.limits()"
    page.locator("#range").select_option("frame")
    assert page.evaluate(limits)[1] == pytest.approx(0.5e6, rel=1e-3)
    page.locator("#range").select_option("all")
    assert page.evaluate(limits)[1] == pytest.approx(1e6, rel=1e-3)
    page.locator("#range").select_option("run")
    assert 0.5e6 < page.evaluate(limits)[1] < 1e6


def test_flat_pattern(page):
    page.locator("#time").fill("20")
    page.locator("#shape").select_option("flat")
    points = np.reshape(page.evaluate(POINTS), (-1, 3))
    assert np.allclose(points[:, :2], feed.SURFACE.flat, atol=1e-6) and not points[:, 2].any()
    page.locator("#shape").select_option("deformed")
    points = np.reshape(page.evaluate(POINTS), (-1, 3))
    assert np.allclose(points, expected(20), rtol=0, atol=1.5 / 65535)


def test_mouse_turns_and_zooms(page):
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = page.evaluate(DIRECTION)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 120, y + 30, steps=4)
    page.mouse.up()
    assert np.abs(np.subtract(page.evaluate(DIRECTION), before)).max() > 0.1
    distance = page.evaluate(DISTANCE)
    page.mouse.wheel(0, -300)
    until(page, f"{DISTANCE} < {0.95 * distance}")
    page.locator("#view").select_option("home")
    assert np.allclose(page.evaluate(DIRECTION), before, atol=1e-6)


def test_values_are_read_under_the_pointer(page):
    page.locator("#view").select_option("top")
    box = page.locator("#canvas").bounding_box()
    middle = (box["width"] - page.evaluate("report.animation.stage.reserved().right")) / 2  # left of the colour bar
    page.mouse.move(box["x"] + middle, box["y"] + box["height"] / 2)
    page.wait_for_selector("#reading:not([hidden])")
    text = page.locator("#reading").inner_text()
    x, y = map(float, re.fullmatch(r"0 Pa · flat x (\S+) mm, y (\S+) mm", text).groups())
    assert (x, y) == pytest.approx((500.0, 300.0), abs=3.0)  # a pixel is some 2 mm
    page.locator("#view").select_option("home")


def test_plots_show_the_tables_and_lead_to_their_time(page):
    titles = page.locator("#plots figcaption").all_inner_texts()
    assert [title.split("\n")[0] for title in titles] == [
        "Energies (J)",
        "Step (ms)",
        "Newton iterations per step",
        "Share of the area (%)",
    ]
    assert "zero throughout: contact, dissipated, external work" in titles[0]
    assert page.locator("#probes figcaption").count() == 3
    assert page.locator("#reactions figcaption").count() == 2
    strain = page.evaluate("report.plots.shown[0].plot.data[2]")
    assert np.allclose(strain, np.pi * np.arange(41) / 40, rtol=1e-6)
    page.mouse.move(5, 5)
    page.locator("#time").fill("10")
    values = page.locator("#plots figure").first.locator(".u-value").all_inner_texts()
    assert values == ["0.5", "0.3333", "1.571"]  # at the time of the animation
    over = page.locator("#plots .u-over").first
    over.click(position={"x": over.bounding_box()["width"] * 0.5, "y": 20})
    assert abs(page.evaluate(FRAME) - 10) <= 1


def test_tables_name_settings_machine_and_results(page):
    settings = page.locator("#settings").inner_text()
    for text in ("youngs_modulus", "2.5e9", "spectral_radius", "0.3", "[probe.0]", "tip", "tolerance"):
        assert text in settings
    assert "Processor" in page.locator("#machine").inner_text()
    assert "warp-origami" in page.locator("#machine").inner_text()
    assert "Elements" in page.locator("#results").inner_text()
    assert page.locator(".status").inner_text() == "done"


def test_light_and_dark(page):
    background = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(background)
    page.locator("#theme").click()
    assert page.evaluate(background) != light
    assert page.locator("#plots figure").count() == 4
    page.locator("#theme").click()
    assert page.evaluate(background) == light


def test_every_control_has_a_name(page):
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, select, input, canvas[tabindex]")].filter((element) =>
        !element.labels?.length && !element.getAttribute("aria-label") && !element.innerText).map((e) => e.outerHTML)"""
    )
    assert unnamed == []


def test_phone(browser, folder):
    watched = Watched(
        browser, folder / "report.html", viewport={"width": 360, "height": 740}, has_touch=True, is_mobile=True,
        color_scheme="dark", device_scale_factor=2,
    )  # fmt: skip
    page = watched.page
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    box = page.locator("#canvas").bounding_box()
    assert 300 <= box["width"] <= 360
    touch = page.context.new_cdp_session(page)
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def fingers(kind, *places):
        points = [{"x": x + dx, "y": y, "id": k} for k, dx in enumerate(places)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = page.evaluate(DIRECTION)
    fingers("touchStart", 0)
    for k in range(1, 5):
        fingers("touchMove", 20 * k)
    fingers("touchEnd")
    assert np.abs(np.subtract(page.evaluate(DIRECTION), before)).max() > 0.1
    distance = page.evaluate(DISTANCE)
    fingers("touchStart", -30, 30)
    for k in range(1, 5):
        fingers("touchMove", -30 - 15 * k, 30 + 15 * k)
    fingers("touchEnd")
    assert page.evaluate(DISTANCE) < 0.9 * distance
    page.evaluate("report.animation.view('top')")
    page.touchscreen.tap(x, y - page.evaluate("report.animation.stage.reserved().bottom") / 2)
    page.wait_for_selector("#reading:not([hidden])")
    assert "flat x" in page.locator("#reading").inner_text()
    page.locator("#play").tap()
    until(page, f"{FRAME} > 0")
    page.locator("#play").tap()
    assert watched.faults == []


def rewritten(folder, tmp_path, kind, **summary):
    """The run as one of another kind of analysis: its page, built anew."""
    copy = tmp_path / kind
    copy.mkdir()
    for path in folder.iterdir():
        (copy / path.name).write_bytes(path.read_bytes())
    scene = (copy / "scene.toml").read_text()
    (copy / "scene.toml").write_text(re.sub(r'kind = "dynamic"\nduration = .*', f'kind = "{kind}"', scene))
    (copy / "summary.json").write_text(json.dumps({"status": "done", "scene": kind, **summary}))
    return build_report(copy)[0]


def test_static_run_starts_at_the_full_load(browser, folder, tmp_path):
    watched = Watched(browser, rewritten(folder, tmp_path, "static"))
    assert watched.page.locator("#clock").inner_text() == "load factor 1.000"
    assert watched.page.locator("#plots .u-label").first.inner_text() == "load factor"
    assert watched.faults == []


def test_motion_opens_in_its_middle_with_its_edges_drawn(browser, folder):
    watched = Watched(browser, folder / "report.html")
    assert watched.page.locator("#clock").inner_text() == "0.500 s"
    mark = "Number(/translateX.([0-9.]+)/.exec(document.querySelector('.mark').style.transform)[1])"
    until(watched.page, f"Math.abs({mark} / document.querySelector('#plots .u-over').clientWidth - 0.5) < 0.01")
    assert watched.page.evaluate("report.animation.sheet.rim.visible")
    creases, rim = (f"report.animation.sheet.{lines}.material.color.getHex()" for lines in ("creases", "rim"))
    assert watched.page.evaluate(creases) != watched.page.evaluate(rim)
    assert watched.faults == []


def test_labels_of_an_axis_differ_where_values_hardly_do(browser, folder, tmp_path):
    path = rewritten(folder, tmp_path, "dynamic").parent
    columns = "time,rate,moment_of_inertia,angular_momentum.x,angular_momentum.y,angular_momentum.z"
    rows = "".join(f"{k / 4},{0.52 - 4e-6 * k},234.0,0.0,0.0,117.0\n" for k in range(5))
    (path / "spin.csv").write_text(f"{columns}\n{rows}")
    page = Watched(browser, build_report(path)[0]).page
    shown = "report.plots.shown.find(({ chart }) => chart.title === 'Rate of spin').plot"
    until(page, f"{shown}.axes[1]._values?.length > 0")
    labels = page.evaluate(f"{shown}.axes[1]._values")
    assert len(set(labels)) == len(labels) >= 3
    assert page.evaluate(f"{shown}.axes[1]._size") > 7 * max(map(len, labels))


def test_run_that_failed_opens_where_it_stopped(browser, tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(), 0.5, status="failed", message="stopped at 0.5 s")
    assert Watched(browser, tmp_path / "report.html").page.locator("#clock").inner_text() == "0.500 s"


def test_modes_are_chosen_by_their_frequency(browser, tmp_path):
    folder = tmp_path / "modes"
    feed.feed(RunDirectory(folder), feed.scene(output={"fps": 8.0}, duration=2.0), 2.0)
    watched = Watched(browser, rewritten(folder, tmp_path, "modal", frequencies=[31.27, 49.45]))
    page = watched.page
    assert page.locator("#modes button").all_inner_texts() == ["mode 1\n31.27 Hz", "mode 2\n49.45 Hz"]
    assert page.locator("#field").input_value() == "displacement"
    page.locator("#modes button").nth(1).click()
    frames = page.evaluate("[report.animation.player.first, report.animation.player.last]")
    times = page.evaluate("Array.from(report.animation.sheet.times)")
    assert [times[frames[0]], times[frames[1]]] == [1.0, 2.0]
    assert "mode 2 · 49.45 Hz" in page.locator("#clock").inner_text()
    assert watched.faults == []


def test_without_3d_graphics_the_plots_are_there(playwright, folder):
    browser = launch(playwright, "--disable-3d-apis")
    page = Watched(browser, folder / "report.html").page
    assert "WebGL" in page.locator("#nothing").inner_text()
    assert page.locator("#time").is_hidden()
    assert page.locator("#plots figure").count() == 4
    page.locator("#theme").click()
    assert page.locator("#plots figure").count() == 4
    browser.close()


def test_run_that_ended_at_its_first_state(browser, tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(), 0.0, status="failed", message="no first step")
    watched = Watched(browser, tmp_path / "report.html")
    assert watched.page.locator("#clock").inner_text() == "0.000 s"
    assert watched.page.locator("#play").is_disabled()
    assert drawn(watched.page)[2] > 5000
    assert watched.faults == []


def test_values_that_are_not_known_are_grey(browser, tmp_path):
    directory = RunDirectory(tmp_path)
    directory.start(feed.scene(output={"fps": feed.FPS, "fields": ["s1"]}), feed.SURFACE, None)
    for k, value in enumerate((np.nan, 1e6)):
        frame = feed.frame(0.0)
        directory.frame(Frame(k / feed.FPS, frame.points, frame.nodes, {"s1": np.full(len(frame.points), value)}))
    directory.save()
    directory.finish({"status": "done"})
    watched = Watched(browser, tmp_path / "report.html")
    watched.page.locator("#draw").select_option("sheet")
    red, green, blue = drawn(watched.page)[1]
    assert red == green == blue
    watched.page.locator("#time").fill("1")
    red, green, blue = drawn(watched.page)[1]
    assert red > blue + 50.0  # the upper end of the bar, yellow
    assert watched.page.locator("#reading").is_hidden()
    assert watched.faults == []


def test_page_of_what_is_left_of_a_run(browser, tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(), 0.5, kill=True)
    (tmp_path / "animation.usdc").write_bytes((tmp_path / "animation.usdc").read_bytes()[:5000])
    (tmp_path / "probes.csv").unlink()
    watched = Watched(browser, build_report(tmp_path)[0])
    page = watched.page
    assert "missing or damaged" in page.locator("#nothing").inner_text()
    assert "killed" in page.locator(".status").inner_text()
    assert "probes.csv is missing" in page.locator("#remarks").inner_text()
    assert page.locator("#probes").is_hidden()
    assert page.locator("#plots figure").count() == 4
    assert watched.faults == []


def test_names_and_messages_are_text(browser, tmp_path):
    hostile = "</script><script>window.broken=1</script><img src=x onerror='window.broken=1'>"
    feed.feed(RunDirectory(tmp_path), feed.scene(), 0.5, status="failed", message=hostile, advice="{{style}} $& \\1")
    watched = Watched(browser, tmp_path / "report.html")
    assert watched.page.evaluate("window.broken") is None
    shown = watched.page.locator(".message").inner_text()
    assert hostile in shown and "{{style}} $& \\1" in shown
    assert watched.faults == []
