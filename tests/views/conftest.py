"""A real browser for the tests of pages: Debian's chromium with software WebGL, without
a network.
"""

import shutil
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import tippetop as tt


CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
FLAGS += ["--disable-accelerated-2d-canvas", "--disable-gpu-rasterization"]  # slower in software
READY = "window.tippetop && window.tippetop.ready"
SMALL = {"width": 320, "height": 400}  # software draws: pixels cost
WITHOUT_WEBGL = """
const { getContext } = HTMLCanvasElement.prototype;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind === "webgl2" ? null : getContext.call(this, kind, ...more);
};"""


@pytest.fixture(scope="session")
def inverting() -> tt.Run:
    """A run in which the top turns over."""
    return tt.run("inverting", until=6.5)


@pytest.fixture(scope="session")
def launch() -> Iterator[Callable[..., Any]]:
    """Start a browser with these flags."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="no playwright: pip install playwright"
    )
    if CHROMIUM is None:
        pytest.skip("no chromium: apt-get install chromium")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium
        yield lambda *flags: chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", *flags]
        )


@pytest.fixture(scope="session")
def browser(launch: Callable[..., Any]) -> Any:
    return launch(*FLAGS)


@pytest.fixture(scope="session")
def browser_without_webgl(launch: Callable[..., Any]) -> Any:
    return launch("--disable-3d-apis")


@pytest.fixture(scope="module")
def open_page(
    browser: Any, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Callable[..., Any]]:
    """Open a page from a file, with the network off, and wait until `ready` is true in it.
    Close the pages of a module at its end: an open one draws frames.

    `webgl`: whether the page may draw its picture, which takes the processor seconds.
    `faults` of the tab lists errors, messages and requests of the page; `used` is the browser.
    """
    folder, contexts = tmp_path_factory.mktemp("pages"), []

    def open_it(
        text: str, ready: str = READY, used: Any = browser, webgl: bool = False, **options: Any
    ) -> Any:
        path = folder / f"{len(list(folder.iterdir()))}.html"
        path.write_text(text, encoding="utf-8")
        context = used.new_context(viewport=SMALL, reduced_motion="reduce", **options)
        contexts.append(context)
        context.set_offline(True)
        if not webgl:
            context.add_init_script(WITHOUT_WEBGL)
        context.set_default_timeout(120_000)
        tab = context.new_page()
        tab.faults = []
        tab.on(
            "console",
            lambda message: (
                tab.faults.append(message.text) if "GPU stall" not in message.text else None
            ),
        )
        tab.on("pageerror", lambda error: tab.faults.append(str(error)))
        tab.on(
            "request",
            lambda request: (
                tab.faults.append(request.url[:99]) if request.url != path.as_uri() else None
            ),
        )
        tab.goto(path.as_uri())
        tab.wait_for_function(ready)
        return tab

    yield open_it
    for context in contexts:
        context.close()
