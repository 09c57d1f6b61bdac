"""Pages in a real browser: they show the run, and follow buttons, keys and scrubbing."""

import base64
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from nightly import at_night

import tippetop as tt
from tippetop.exchange.motion import angle_between
from tippetop.views import samples


@pytest.fixture(scope="module")
def tab(inverting: tt.Run, open_page: Any) -> Any:
    """The page of the inversion, open."""
    return open_page(inverting.view().text, webgl=True)


def test_a_page_shows_the_poses_of_its_run(inverting: tt.Run, tab: Any) -> None:
    """At moments between rows, within 0.2 degrees; force and scale of its arrow too."""
    at = np.sort(np.random.default_rng(2).uniform(0, 6.5, 200))
    exact = tt.run("inverting", until=6.5, output_times=at).trajectory.isel(time=slice(len(at)))
    poses = tab.evaluate("times => times.map(t => tippetop.pose(t))", at.tolist())
    drawn = np.array([pose["orientation"] for pose in poses])
    assert np.degrees(angle_between(drawn, exact.orientation.values)).max() < 0.02
    assert_near([pose["theta"] for pose in poses], exact.theta.values, 2e-5)
    assert_near([pose["position"][0] for pose in poses], exact.x.values, 1e-6)
    row = 5900
    table = {str(name): column.values for name, column in inverting.trajectory.variables.items()}
    force = samples.samples(table, inverting.attributes)[row, 10:13]
    tab.evaluate("t => tippetop.set(t)", float(inverting.trajectory.time[row]))
    arrow = next(a for a in tab.evaluate("tippetop.arrows()") if a["name"] == "force")
    assert arrow["size"] == pytest.approx(np.linalg.norm(force), rel=1e-5)
    assert np.linalg.norm(arrow["drawn"]) == pytest.approx(np.linalg.norm(force) / 0.1964, rel=1e-5)
    assert force[2] == pytest.approx(float(inverting.trajectory.normal_force[row]))


def test_a_page_is_moved_by_buttons_keys_and_scrubbing(inverting: tt.Run, tab: Any) -> None:
    tab.evaluate("tippetop.set(0)")
    assert tab.evaluate("tippetop.speed") == 0.1, "whoever wants less motion gets it slowly"
    tab.get_by_role("button", name="play").click()
    tab.wait_for_function("tippetop.time > 0.001")
    assert tab.evaluate("tippetop.playing")
    tab.keyboard.press("Escape")
    tab.get_by_role("button", name="pause").click()
    assert not tab.evaluate("tippetop.playing")
    tab.evaluate("tippetop.set(0)")
    tab.get_by_role("button", name="next event").click()
    first = float(inverting.events.time[0])
    assert tab.evaluate("tippetop.time") == pytest.approx(first)
    assert f"{first:.4f} s" in tab.locator("[data-part=said]").inner_text()
    tab.locator("[data-part=scrub]").evaluate(
        "e => { e.value = 3.25; e.dispatchEvent(new Event('input')); }"
    )
    assert tab.evaluate("tippetop.time") == pytest.approx(3.25, abs=1e-5)
    tab.locator("body").press(">")
    equator = inverting.events.time.values[inverting.events.kind.values == 2][0]
    assert tab.evaluate("tippetop.time") == pytest.approx(equator)
    tab.locator("body").press("End")
    assert tab.evaluate("tippetop.time") == 6.5
    tab.locator("body").press("+")
    assert tab.evaluate("tippetop.speed") == 0.2
    width = tab.locator("[data-part=theta]").bounding_box()["width"]
    tab.locator("[data-part=theta]").click(position={"x": 46 + (width - 58) / 2, "y": 60})
    assert tab.evaluate("tippetop.time") == pytest.approx(3.25, abs=0.05)
    tab.get_by_role("button", name="F force of the plane").click()
    assert [a["drawn"] for a in tab.evaluate("tippetop.arrows()") if a["name"] == "force"] == [
        [0, 0, 0]
    ]

    tab.set_viewport_size({"width": 1000, "height": 600})
    assert tab.evaluate(
        "document.documentElement.scrollWidth <= innerWidth && document.body.scrollHeight <= "
        "innerHeight"
    )
    assert tab.faults == []


def test_the_camera_follows_as_closely_with_few_pictures_a_second(tab: Any) -> None:
    """Where it is after a second does not depend on their number."""
    near = [
        tab.evaluate(
            """n => {
                const camera = new tippetop.stage.scene.camera.constructor();
                camera.mode = "follow";
                for (let i = 0; i < n; i++) camera.follow([5, 0, 0.9], 0.2 / n);
                return camera.target[0];
            }""",
            pictures,
        )
        for pictures in (1, 3, 60)
    ]
    np.testing.assert_allclose(near, near[0], rtol=1e-12)
    assert 4.5 < near[0] < 5


def test_the_colours_of_phases_are_explained(tab: Any) -> None:
    """By the colours of the line of times, with the part of the time that each takes; without
    phases by nothing.
    """
    key = tab.locator("[data-part=key]")
    assert key.is_hidden()
    entries = tab.evaluate("""() => {
        const { shown, line } = tippetop.stage;
        const { log } = shown;
        const before = { phases: log.phases, starts: log.starts, changes: log.changes };
        const phases = [["slip", "body"], ["roll", "body"], ["flight", "stem"], ["roll", "stem"], ["slip", "body"]].map(
            ([phase, ball], i) => ({ start: i, end: i + 1, phase, ball }));
        Object.assign(log, { phases, starts: phases.map((p) => p.start), changes: true });
        shown.log = Object.create(log);
        tippetop.set(6);
        tippetop.draw();
        const entries = [...document.querySelectorAll("[data-part=key] > span")].map((entry) => entry.textContent);
        const colours = [...document.querySelectorAll("[data-part=key] > span")].map((entry) =>
            entry.style.getPropertyValue("--colour"));
        const { canvas, context } = line.chart;
        const row = context.getImageData(0, 16, canvas.width, 1).data;
        const drawn = [0.3, 1.3, 2.3, 3.3].map((t) => Math.round(line.chart.x(t))).map((x) =>
            "#" + [...row.slice(4 * x, 4 * x + 3)].map((part) => part.toString(16).padStart(2, "0")).join(""));
        Object.assign(log, before);
        shown.log = log;
        tippetop.draw();
        return [entries, colours, drawn];
    }""")
    words, colours, drawn = entries
    assert words == ["slip: 30.8 %", "roll: 15.4 %", "flight: 15.4 %", "roll on the stem: 15.4 %"]
    assert colours == drawn
    assert len(set(colours)) == 4
    assert key.is_hidden()


@pytest.mark.parametrize("preset", ["rolling-coin", at_night("spinning-egg")])
def test_another_body_touches_the_plane(preset: str, open_page: Any) -> None:
    """Where its force acts."""
    tab = open_page(tt.run(preset, until=0.3).view().text, webgl=True)
    for time in (0.0, 0.11, 0.29):
        tab.evaluate("t => tippetop.set(t)", time)
        (force,) = (a for a in tab.evaluate("tippetop.arrows()") if a["name"] == "force")
        assert force["start"][2] == pytest.approx(0, abs=0.005)
    assert tab.faults == []


def test_a_rattleback_shows_its_vertical_spin_with_its_sign(open_page: Any) -> None:
    tab = open_page(tt.run("rattleback", until=4.0).view().text)
    spins = []
    for time in (0.0, 3.9):
        tab.evaluate("t => tippetop.set(t)", time)
        tab.wait_for_timeout(300)
        spins.append(float(tab.locator("[data-part=spin]").inner_text().split()[0]))
    assert spins[0] == -5.0
    assert spins[1] > 1


def test_a_run_in_a_notebook_turns_once_it_is_opened(open_page: Any) -> None:
    """Its frame has no size before, and again when it is closed."""
    run = tt.run("inverting", until=0.2)
    tab = open_page(run._repr_html_(), ready="true")
    opening = tab.locator("summary", has_text="See it turn")
    opening.click()
    frame = tab.frames[-1]
    frame.wait_for_function("window.tippetop")
    frame.wait_for_function(DRAWN)
    opening.click()
    tab.wait_for_timeout(300)
    opening.click()
    frame = tab.frames[-1]
    frame.wait_for_function("window.tippetop")
    frame.get_by_role("button", name="next event").click()
    assert frame.evaluate("tippetop.time") == pytest.approx(float(run.events.time[0]))
    assert frame.evaluate("document.fullscreenEnabled")
    assert tab.faults == []


@pytest.mark.slow
def test_a_page_without_webgl2_shows_its_plots(browser_without_webgl: Any, open_page: Any) -> None:
    tab = open_page(tt.run("inverting", until=0.2).view().text, used=browser_without_webgl)
    assert "WebGL2" in tab.get_by_role("alert").inner_text()
    tab.wait_for_function(DRAWN)
    tab.get_by_role("button", name="play").click()
    tab.wait_for_function("tippetop.time > 0.001")
    assert tab.faults == []


@pytest.mark.slow
def test_a_page_that_loses_webgl2_names_it(open_page: Any) -> None:
    """A browser takes it from the oldest of many pages."""
    tab = open_page(tt.run("inverting", until=0.2).view().text, webgl=True)
    assert tab.get_by_role("alert").is_hidden()
    tab.evaluate("tippetop.stage.scene.gl.getExtension('WEBGL_lose_context').loseContext()")
    tab.get_by_role("alert").wait_for()
    tab.evaluate("tippetop.set(0.1)")
    tab.wait_for_function("document.querySelector('[data-part=time]').textContent === '0.1000 s'")


@pytest.mark.slow
def test_fingers_scroll_the_page_or_move_the_time(inverting: tt.Run, open_page: Any) -> None:
    """Upwards a finger only scrolls; sideways it turns the camera or moves the time."""
    tab = open_page(inverting.view().text, webgl=True, has_touch=True, is_mobile=True)
    for part in ("scene", "theta", "line"):
        assert swiped(tab, part, 0, -60) == {"scroll"}, part
    assert swiped(tab, "scene", 60, 0) == {"yaw"}
    for part in ("theta", "line"):
        assert swiped(tab, part, 60, 2) == {"time"}, part
    heights = "all => all.map((button) => button.getBoundingClientRect().height)"
    assert min(tab.locator("button:visible").evaluate_all(heights)) >= 32
    assert tab.faults == []


def swiped(tab: Any, part: str, dx: int, dy: int) -> set[str]:
    """Draw a finger across a part of a page at 3 s, and return the names of what this changes."""
    touch = tab.context.new_cdp_session(tab)
    place = tab.locator(f"[data-part={part}]")
    place.evaluate("e => e.scrollIntoView({ block: 'center' })")
    tab.evaluate("tippetop.set(3)")
    before = tab.evaluate(STATE)
    box = place.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for s in np.linspace(0, 1, 11):
        finger = {"x": x + s * dx, "y": y + s * dy}
        kind = "touchMove" if s else "touchStart"
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [finger]})
        tab.wait_for_timeout(30)
    tab.wait_for_timeout(200)
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    tab.wait_for_timeout(200)
    after = tab.evaluate(STATE)
    return {name for name in after if after[name] != pytest.approx(before[name])}


@pytest.mark.slow
def test_paper_is_white_and_balls_are_round(tab: Any) -> None:
    """Also of a dark page; no canvas is stretched."""
    tab.set_viewport_size({"width": 1280, "height": 800})
    tab.evaluate("document.documentElement.dataset.theme = 'dark'")
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    tab.emulate_media(media="print")
    tab.set_viewport_size({"width": 720, "height": 1000})
    ink, paper, stretched = tab.evaluate("""() => {
        const { canvas, context } = tippetop.stage.theta.chart;
        const pixels = context.getImageData(0, 0, canvas.width, 20).data;
        let darkest = 255;
        for (let i = 0; i < pixels.length; i += 4) {
            if (pixels[i + 3] > 200) darkest = Math.min(darkest, pixels[i]);
        }
        const stretched = [...document.querySelectorAll("canvas")].map((canvas) => {
            const { width, height } = canvas.getBoundingClientRect();
            return (width / height) / (canvas.width / canvas.height);
        });
        const { backgroundColor } = getComputedStyle(document.querySelector("figure"));
        return [darkest, backgroundColor, stretched];
    }""")
    assert ink < 60
    assert paper == "rgb(255, 255, 255)"
    np.testing.assert_allclose(stretched, 1, rtol=0.02)
    assert not tab.get_by_role("button", name="play").is_visible()
    tab.emulate_media(media="screen")
    tab.evaluate("dispatchEvent(new Event('afterprint'))")
    tab.evaluate("document.documentElement.dataset.theme = 'light'")
    tab.set_viewport_size({"width": 320, "height": 400})


@pytest.mark.slow
def test_a_film_of_the_picture_is_saved(tab: Any) -> None:
    """What the button records has the pictures that were drawn meanwhile: a file that a player
    opens.
    """
    tab.evaluate("tippetop.set(0)")
    tab.get_by_role("button", name="film").click()
    assert tab.evaluate("tippetop.playing"), "whoever films wants to see it move"
    tab.wait_for_function("tippetop.time > 0.02")
    with tab.expect_download() as saved:
        tab.get_by_role("button", name="save").click()
    film = saved.value.path().read_bytes()
    assert saved.value.suggested_filename in ("tippe-top.webm", "tippe-top.mp4")
    assert film[:4] == b"\x1aE\xdf\xa3" or film[4:8] == b"ftyp"
    player = tab.context.new_page()
    size = player.evaluate(
        PLAYED, [saved.value.suggested_filename[-4:].strip("."), base64.b64encode(film).decode()]
    )
    assert size == tab.evaluate("[tippetop.stage.scene.width, tippetop.stage.scene.height]")
    tab.get_by_role("button", name="pause").click()
    assert tab.faults == []


STATE = """() => {
  const { yaw, pitch } = tippetop.stage.scene.camera;
  return { scroll: scrollY, time: tippetop.time, yaw, pitch };
}"""
DRAWN = """(() => {
  const canvas = document.querySelector("[data-part=theta]");
  const { width, height } = canvas;
  return width && canvas.getContext("2d").getImageData(0, 0, width, height).data.some((part) => part);
})()"""
PLAYED = """([type, film]) => new Promise((done) => {
  const video = document.createElement("video");
  video.onloadeddata = () => done([video.videoWidth, video.videoHeight]);
  video.onerror = () => done(video.error.message);
  video.src = `data:video/${type};base64,${film}`;
})"""
