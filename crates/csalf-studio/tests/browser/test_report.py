"""The pages of `csalf mesh --report FILE.html` in a real browser, opened from disk."""

import subprocess
import time

import pytest
from conftest import CSALF, PICTURES, ROOT, resize

pytest.importorskip("selenium")
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.select import Select  # noqa: E402

BLOCK = ROOT / "crates" / "csalf-step" / "tests" / "data" / "block.step"
PLATE = ROOT / "fixtures" / "ring_and_scar_layers" / "job.json"


def page_of(folder, source, *options):
    """Meshes a file; the address of the page."""
    page = folder / "report.html"
    subprocess.run([CSALF, "mesh", source, "-o", folder / "mesh.vtu", "-q", "--report", page, *options], check=True)
    return page.as_uri()


def pixels(browser):
    """Number of pixels of the canvas by what they are: drawn, and each colour's count."""
    return browser.execute_script(
        "const c = document.getElementById('canvas'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        "const of = {}; let n = 0;"
        "for (let i = 0; i < d.length; i += 4) if (d[i + 3]) { n++; const k = `${d[i]},${d[i + 1]},${d[i + 2]}`; of[k] = (of[k] || 0) + 1; }"
        "return [n, of, c.width * c.height];"
    )


def settled(browser):
    """The pixels once the page has drawn what was asked."""
    browser.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(done));")
    return pixels(browser)


def picture(browser, name):
    PICTURES.mkdir(parents=True, exist_ok=True)
    browser.save_screenshot(str(PICTURES / f"{name}.png"))


def here(browser):
    return browser.find_element(By.ID, "here").text


@pytest.mark.parametrize("width", [1280, 390])
def test_a_plane_mesh(browser, tmp_path, width):
    resize(browser, width, 900, touch=width < 500)
    browser.get(page_of(tmp_path, PLATE))
    drawn, _, size = settled(browser)
    assert drawn > 0.1 * size
    rows = browser.find_elements(By.CSS_SELECTOR, "#layers tr")
    assert len(rows) == 5, "a head, the outer loop, two holes and a scar"
    assert browser.find_element(By.ID, "faced").is_displayed() is False
    worst = browser.find_elements(By.CSS_SELECTOR, "#worst button")
    worst[0].click()
    assert here(browser).startswith("quad ") and "scaled Jacobian" in here(browser)
    Select(browser.find_element(By.ID, "metric")).select_by_value("size_ratio")
    assert "size" in browser.find_element(By.ID, "histogram-title").text
    picture(browser, f"report_plane_{width}")
    assert browser.execute_script("return document.documentElement.scrollWidth <= innerWidth + 1")


@pytest.mark.parametrize("width", [1280, 390])
def test_a_model(browser, tmp_path, width):
    resize(browser, width, 900, touch=width < 500)
    browser.get(page_of(tmp_path, BLOCK, "--size", "4", "--layers", "hole*=2"))
    first, colours, size = settled(browser)
    assert first > 0.1 * size and len(colours) > 20, "faces in different light"
    picture(browser, f"report_model_{width}")
    canvas = browser.find_element(By.ID, "canvas")
    canvas.send_keys(Keys.ARROW_RIGHT)
    _, turned, _ = settled(browser)
    assert turned != colours
    canvas.send_keys("0")
    assert settled(browser)[1] == colours, "0 shows all as at the start"
    # A tap on the middle of the model tells of the quad that is there.
    if width > 500:
        ActionChains(browser).move_to_element(canvas).click().perform()
        assert here(browser).startswith("quad ") and " of " in here(browser)
        canvas.send_keys("0")
    faces = browser.find_elements(By.CSS_SELECTOR, "#faces tr[data-face]")
    assert len(faces) == 7
    browser.execute_script("arguments[0].click()", faces[0])
    assert faces[0].get_attribute("aria-selected") == "true"
    _, alone, _ = settled(browser)
    grey = sum(n for c, n in alone.items() if max(map(int, c.split(","))) - min(map(int, c.split(","))) < 20)
    assert 0 < grey < sum(alone.values()), "the other faces are grey"
    worst = browser.find_elements(By.CSS_SELECTOR, "#worst button")
    browser.execute_script("arguments[0].click()", worst[0])
    assert here(browser).startswith("quad ") and "warpage" in here(browser)
    picture(browser, f"report_model_worst_{width}")
    assert browser.execute_script("return document.documentElement.scrollWidth <= innerWidth + 1")


def test_a_large_model_is_drawn(browser, tmp_path):
    browser.get(page_of(tmp_path, BLOCK, "--size", "0.4"))
    n = browser.execute_script("return m.n")
    assert n > 20_000
    start = time.monotonic()
    for _ in range(5):
        browser.execute_script("turn(0.1, 0.05); paint();")
    took = (time.monotonic() - start) / 5
    print(f"{n} quads: {1000 * took:.0f} ms per frame")
    assert settled(browser)[0] > 0
