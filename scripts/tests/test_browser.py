"""Clicks through a report in a browser."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.ui import Select, WebDriverWait
from synthetic import METHODS, write_experiment

from pathspace import load
from pathspace.report import write_report

TOOLS = [shutil.which(name) for name in ("chromium", "chromedriver")]

pytestmark = pytest.mark.skipif(
    None in TOOLS, reason="no chromium and chromedriver: run scripts/setup --dev as root"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experiment")
    write_experiment(folder, ["box", "other <b>"])
    write_report(load(folder), folder / "report.html")
    return folder


@pytest.fixture(scope="module")
def browser(folder: Path) -> Iterator[webdriver.Chrome]:
    options = webdriver.ChromeOptions()
    for option in ("headless=new", "no-sandbox", "disable-gpu", "window-size=1366,768"):
        options.add_argument(f"--{option}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    options.binary_location = str(TOOLS[0])
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(str(TOOLS[1])))
    browser.get((folder / "report.html").as_uri())
    browser.execute_async_script("window.ready.then(() => arguments[0]())")
    yield browser
    browser.quit()


def find(browser: webdriver.Chrome, selector: str) -> WebElement:
    return browser.find_element(By.CSS_SELECTOR, selector)


def press(browser: webdriver.Chrome, label: str) -> None:
    buttons = find(browser, ".viewer").find_elements(By.TAG_NAME, "button")
    next(button for button in buttons if button.text == label).click()


def state(browser: webdriver.Chrome, name: str) -> object:
    return browser.execute_script(f"return window.viewers[0].{name}")


def label(browser: webdriver.Chrome) -> str:
    return find(browser, "canvas.images").get_attribute("aria-label") or ""


def keys(browser: webdriver.Chrome, *pressed: str) -> None:
    browser.execute_script("document.querySelector('canvas.images').focus()")
    find(browser, "canvas.images").send_keys(*pressed)


def picture(browser: webdriver.Chrome) -> list[int]:
    """What the canvas shows, a byte of red for each of its pixels."""
    return browser.execute_script(
        "const c = document.querySelector('canvas.images');"
        "return [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data]"
        ".filter((_, i) => i % 4 == 0)"
    )


def test_it_loads_without_a_word_of_complaint(browser: webdriver.Chrome) -> None:
    assert browser.get_log("browser") == []
    assert browser.execute_script("return document.documentElement.scrollWidth <= innerWidth")


def test_plots_follow_the_choice_of_metric_and_axis(browser: webdriver.Chrome) -> None:
    def plots() -> list[dict]:
        return browser.execute_script(
            "return [...document.querySelector('.plots').children].map(plot => ({"
            "y: plot.layout.yaxis.title.text, x: plot.layout.xaxis.title.text,"
            "lines: plot.data.filter(t => t.mode == 'lines+markers').map(t => t.name),"
            "bands: plot.data.filter(t => t.fill == 'tonexty').length,"
            "open: plot.data.filter(t => t.mode == 'markers').map(t => t.name)}))"
        )

    axis = Select(find(browser, "#axis"))
    axis.select_by_visible_text("both")
    both = plots()
    assert [plot["x"] for plot in both] == ["rendering time [s]", "samples per pixel"]
    assert both[0]["lines"] == list(METHODS)
    assert both[0]["bands"] == len(METHODS)
    assert both[0]["open"] == ["bdpt"]
    assert both[0]["y"] == "relMSE"
    axis.select_by_value("seconds")
    Select(find(browser, "#metric")).select_by_value("rmse")
    assert [plot["y"] for plot in plots()] == ["RMSE"]


def test_verdicts_follow_the_choice_of_metric(browser: webdriver.Chrome) -> None:
    metric = Select(find(browser, "#metric"))
    rows = browser.find_elements(By.CSS_SELECTOR, 'table[data-table="Verdicts"] tbody tr')
    metric.select_by_value("rmse")
    assert rows
    assert all(row.is_displayed() for row in rows)
    metric.select_by_value("mse")
    assert not any(row.is_displayed() for row in rows)
    metric.select_by_value("rmse")


def test_hover_tells_the_value_and_its_interval(browser: webdriver.Chrome, folder: Path) -> None:
    browser.execute_script(
        "const plot = document.querySelector('.plot'); plot.scrollIntoView();"
        "const curve = plot.data.findIndex(t => t.mode == 'lines+markers');"
        "Plotly.Fx.hover(plot, [{curveNumber: curve, pointNumber: 0}])"
    )
    shown = find(browser, ".plot .hoverlayer").text
    curves = load(folder).curves
    where = (curves["scene"] == "box") & (curves["method"] == "path") & (curves["metric"] == "rmse")
    first = curves[where].sort_values("checkpoint").iloc[0]
    assert "path" in shown
    assert f"{first['error']:.4g}" in shown
    assert f"{first['low']:.3g}" in shown


def test_images_are_flipped_by_mouse_and_by_key(browser: webdriver.Chrome) -> None:
    press(browser, "light")
    assert label(browser) == "box: light, Flip"
    light = picture(browser)
    keys(browser, "1")
    assert label(browser) == "box: reference, Flip"
    assert picture(browser) != light
    keys(browser, Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert label(browser) == "box: light, Flip"
    assert picture(browser) == light


def test_exposure_brightens(browser: webdriver.Chrome) -> None:
    before = sum(picture(browser))
    keys(browser, "e", "e")
    assert find(browser, "output").text == "+1 stops"
    assert sum(picture(browser)) > before
    keys(browser, "E", "E")
    assert sum(picture(browser)) == before


def test_zoom_and_pan(browser: webdriver.Chrome) -> None:
    keys(browser, "+", "+")
    assert state(browser, "zoom") == pytest.approx(2.25)
    canvas = find(browser, "canvas.images")
    centre = state(browser, "centre")
    actions = webdriver.ActionChains(browser)
    actions.move_to_element(canvas).click_and_hold().move_by_offset(40, 0).release().perform()
    assert state(browser, "centre")[0] < centre[0]
    press(browser, "Whole image")
    assert state(browser, "zoom") == 1


def test_views_compare_two_images(browser: webdriver.Chrome) -> None:
    seen = []
    for view in ("Flip", "Side by side", "Split", "Difference", "Relative error"):
        press(browser, view)
        assert label(browser).endswith(view)
        seen.append(tuple(picture(browser)))
    assert len(set(seen)) == len(seen)
    press(browser, "Difference")
    assert any(picture(browser))
    Select(find(browser, ".second")).select_by_visible_text("light")
    assert not any(picture(browser)), "an image does not differ from itself"
    press(browser, "Split")
    halves = picture(browser)
    browser.execute_script("const s = document.querySelector('.split'); s.value = 0.1; s.oninput()")
    Select(find(browser, ".second")).select_by_visible_text("reference")
    assert picture(browser) != halves


def test_the_value_under_the_cursor_is_the_files(browser: webdriver.Chrome, folder: Path) -> None:
    press(browser, "Flip")
    press(browser, "light")
    browser.execute_script("window.viewers[0].cursor = null")
    keys(browser, *"iiijjj")
    column, row = state(browser, "cursor")
    image = load(folder).image("box", "light")
    assert image is not None
    assert (column, row) == (image.shape[1] // 2 - 3, image.shape[0] // 2 - 3)
    reading = find(browser, ".reading").text
    line = next(line for line in reading.splitlines() if line.startswith("light:"))
    values = [float(value) for value in line.split(":")[1].split()]
    assert np.allclose(values, image[row, column], rtol=2**-10)
    # The mouse names the pixel it is over.
    canvas = find(browser, "canvas.images")
    webdriver.ActionChains(browser).move_to_element_with_offset(canvas, 3, 3).perform()
    middle = f"pixel {image.shape[1] // 2}, {image.shape[0] // 2}"
    assert find(browser, ".reading").text.startswith(middle)


def test_everything_is_reached_by_tab(browser: webdriver.Chrome) -> None:
    browser.execute_script("document.activeElement.blur()")
    body = find(browser, "body")
    reached = set()
    for _ in range(60):
        body = browser.switch_to.active_element
        body.send_keys(Keys.TAB)
        element = browser.switch_to.active_element
        reached.add(element.get_attribute("class") or element.get_attribute("id") or element.text)
    assert {"metric", "axis", "images", "exposure", "path"} <= reached


def test_paper_has_no_controls(browser: webdriver.Chrome) -> None:
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert not find(browser, ".controls").is_displayed()
    assert find(browser, "canvas.images").is_displayed()
    assert find(browser, "table").is_displayed()
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


@pytest.mark.parametrize(("width", "height"), [(390, 844), (1920, 1080)])
def test_no_screen_is_too_narrow(browser: webdriver.Chrome, width: int, height: int) -> None:
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    wait = WebDriverWait(browser, 5)
    script = "return document.documentElement.scrollWidth"
    wait.until(lambda browser: browser.execute_script(script) <= width)
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
