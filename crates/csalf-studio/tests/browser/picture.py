"""Makes the picture of docs/studio.md: `python picture.py docs/images/studio.png`."""

import sys

import pytest

WHERE = sys.argv[-1]


def test_picture(browser, studio):
    from conftest import resize
    from test_studio import Page

    resize(browser, 1080, 640)
    page = Page(browser, studio())
    page.find("example").click()
    page.meshed()
    page.click(-4, -2)
    page.until(lambda: "layers made" in page.find("made").text)
    browser.save_screenshot(WHERE)


if __name__ == "__main__":
    sys.exit(pytest.main(["-q", __file__, "-p", "no:cacheprovider"]))
