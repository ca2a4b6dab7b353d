"""A real browser for the tests of pages, if the machine has one."""

import shutil

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
SLOW_DRAWING = "GPU stall due to ReadPixels"
"""What a browser without a GPU says of itself."""


def launch(playwright, *flags):
    """A headless Chromium, with further `flags`; skips the test where there is none."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    return playwright.chromium.launch(executable_path=path, args=[*FLAGS, *flags])


class Watched:
    """A page that is opened from its file, and all that goes wrong with it.

    Attributes:
        page: of the browser.
        faults: console messages of errors and warnings, exceptions, requests for anything but the file itself.
    """

    def __init__(self, browser, path, **options):
        self.page = browser.new_context(offline=True, **options).new_page()
        self.faults = []
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("console", self._told)
        self.page.on("request", self._asked)
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("html[data-ready=yes]", timeout=60_000)

    def _told(self, message):
        if message.type in ("error", "warning") and SLOW_DRAWING not in message.text:
            self.faults.append(message.text)

    def _asked(self, request):
        if not request.url.startswith(("file:", "data:", "blob:")):
            self.faults.append(f"request of {request.url}")
