"""A studio and a headless Chromium for the tests; without Chromium or selenium they are skipped."""

import http.server
import os
import shutil
import subprocess
import tempfile
import threading
import urllib.request
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
PICTURES = ROOT / "target" / "browser"
CSALF = Path(os.environ.get("CSALF", ROOT / "target" / "debug" / "csalf"))
CHROMIUM = shutil.which("chromium")
FLAGS = [
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
]


class Studio:
    """A running `csalf studio`."""

    def __init__(self, *args):
        self.process = subprocess.Popen([CSALF, "studio", "--no-open", "-q", *map(str, args)], stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()
        assert self.url.startswith("http://127.0.0.1:"), self.url

    def stop(self):
        self.process.kill()
        self.process.wait()


@pytest.fixture
def studio():
    """Starts studios with the given arguments; they end with the test."""
    running = []

    def start(*args):
        running.append(Studio(*args))
        return running[-1].url

    yield start
    for one in running:
        one.stop()


@pytest.fixture
def site():
    """The static site, served; skipped where `cargo xtask site` has not made it."""
    folder = ROOT / "target" / "site"
    if not (folder / "csalf.wasm").exists():
        pytest.skip("no target/site")

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *args):
            super().__init__(*args, directory=str(folder))

        def log_message(self, *args):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


@pytest.fixture(scope="session")
def downloads():
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


@pytest.fixture(scope="session")
def chromium(downloads):
    """One browser for all tests."""
    webdriver = pytest.importorskip("selenium.webdriver")
    driver_path = shutil.which("chromedriver")
    if not (CHROMIUM and driver_path):
        pytest.skip("no chromium or chromedriver")
    with tempfile.TemporaryDirectory() as profile:
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for flag in [*FLAGS, f"--user-data-dir={profile}"]:
            options.add_argument(flag)
        options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        service = webdriver.ChromeService(executable_path=driver_path)
        driver = webdriver.Chrome(options=options, service=service)
        yield driver
        driver.quit()


@pytest.fixture
def browser(chromium):
    """The browser at desktop size; no page may have logged an error."""
    resize(chromium, 1280, 800)
    chromium.get_log("browser")
    yield chromium
    errors = [e for e in chromium.get_log("browser") if e["level"] == "SEVERE"]
    assert not errors


def resize(browser, width, height, touch=False):
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch})
    browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": touch})


def status_of(url, data=None, **headers):
    """HTTP status of a request without a browser."""
    request = urllib.request.Request(url, data=data, headers=headers)
    try:
        return urllib.request.urlopen(request).status
    except urllib.error.HTTPError as error:
        return error.code
