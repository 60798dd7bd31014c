"""The page in headless Chromium, opened from disk."""

import shutil
from io import BytesIO

import numpy as np
import pytest

from builders import moving, without_plucks
from roboguitarist import viewer
from roboguitarist.tablature import Bar, Note, Tablature

pytestmark = pytest.mark.slow

NOTES = tuple(Note(0.5 * k, 1 + k % 6, k % 4, 0.5) for k in range(12))
BARS = (Bar(0.0, 1), Bar(2.0, 2), Bar(4.0, 3))
PIECE = Tablature(NOTES, BARS, title="Für zwei <Hände>", composer="Anonymous")
SIZE = {"width": 480, "height": 440}
SLIDE_M_S = 0.01
"""How fast `moving` takes the left hand along the neck, which tells the time of the picture."""
CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--autoplay-policy=no-user-gesture-required"]  # fmt: skip
FOUND = """async () => {
    while (roboguitarist.player.audio.seeking) await new Promise((done) => setTimeout(done, 5));
}"""
OPENED = """async () => {
    while (!window.roboguitarist) await new Promise((done) => setTimeout(done, 20));
}"""
NEXT_PICTURES = """() => new Promise(
    (done) => requestAnimationFrame(() => requestAnimationFrame(done)))"""
PICTURE_TIME = f"roboguitarist.stage.root.getObjectByName('lh_forearm').position.x / {SLIDE_M_S}"


@pytest.fixture(scope="module")
def performance():
    return without_plucks(moving(PIECE), np.arange(12) == 5)


@pytest.fixture(scope="module")
def opened(performance, tmp_path_factory):
    """The page, and what its browser complained of or asked for."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="no playwright to drive a browser"
    )
    if CHROMIUM is None:
        pytest.skip("no Chromium (Debian: apt-get install chromium)")
    path = tmp_path_factory.mktemp("page") / "short.html"
    viewer.write_page(performance, path)
    seen: dict[str, list[str]] = {"complaints": [], "requests": []}
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(300_000)
        page.on("console", lambda message: seen["complaints"].append(message.text))
        page.on("pageerror", lambda error: seen["complaints"].append(str(error)))
        page.on("request", lambda request: seen["requests"].append(request.url))
        page.goto(path.as_uri())
        page.evaluate(OPENED)
        yield page, seen
        browser.close()


@pytest.fixture
def page(opened):
    page, _ = opened
    yield page
    page.evaluate("roboguitarist.player.audio.pause()")
    page.evaluate("roboguitarist.player.setLoop(null)")
    page.evaluate("roboguitarist.player.speed = 1")


def picture(page):
    """What is drawn now, (height, width, 3) float."""
    image = pytest.importorskip("PIL.Image")
    page.evaluate(
        "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )
    raw = page.screenshot(clip=page.locator("#view").bounding_box())
    return np.asarray(image.open(BytesIO(raw)).convert("RGB"), float)


def plain(page):
    """Draw as little as the page can, for tests of its clock on busy machines."""
    page.evaluate(
        "() => { while (roboguitarist.stage.detail > 0) roboguitarist.stage.simplify(); }"
    )


def place(page, time_s, view="front"):
    page.evaluate(f"roboguitarist.player.seek({time_s})")
    page.evaluate(f"roboguitarist.stage.view('{view}')")
    page.evaluate(FOUND)


@pytest.mark.parametrize(("view", "hand"), [("front", "lh"), ("left", "lh"), ("right", "rh")])
def test_hands_are_drawn(page, view, hand):
    place(page, 1.2, view)
    whole = picture(page)
    assert whole.std() > 25
    node = f"roboguitarist.stage.root.getObjectByName('{hand}_forearm')"
    page.evaluate(f"{node}.visible = false")
    without = picture(page)
    page.evaluate(f"{node}.visible = true")
    changed = np.abs(whole - without).max(axis=2) > 40
    assert 0.01 < changed.mean() < 0.6


def test_the_picture_moves_with_time(page):
    plain(page)
    place(page, 0.2)
    one = picture(page)
    place(page, 4.0)
    assert np.abs(picture(page) - one).max() > 60


@pytest.mark.parametrize("speed", [1.0, 0.5])
def test_sound_and_picture_agree_after_seeking_and_while_playing(page, speed):
    page.evaluate(f"roboguitarist.player.speed = {speed}")
    for time_s in (3.1, 0.4, 4.6):
        place(page, time_s)
        picture(page)
        shown = page.evaluate(PICTURE_TIME) + page.evaluate("roboguitarist.player.startS")
        assert shown == pytest.approx(time_s, abs=0.02)
    place(page, 1.0)
    page.evaluate("roboguitarist.player.play()")
    # The page draws first in a frame, so this asks right after it.
    pairs = page.evaluate(
        """async () => {
            const pairs = [];
            for (let k = 0; k < 8; k++) {
                await new Promise(requestAnimationFrame);
                pairs.push([SHOWN, roboguitarist.player.audio.currentTime]);
            }
            return pairs;
        }""".replace("SHOWN", PICTURE_TIME)
    )
    shown_s, heard_s = np.array(pairs).T
    assert heard_s[-1] > heard_s[0] >= 1.4
    assert np.abs(shown_s - heard_s).max() < 0.05


def test_the_sound_in_the_page_begins_with_its_pluck(page, performance):
    onset_s = page.evaluate(
        """async () => {
            const packed = await (await fetch(roboguitarist.player.audio.src)).arrayBuffer();
            const sound = await new OfflineAudioContext(2, 48000, 48000).decodeAudioData(packed);
            const left = sound.getChannelData(0);
            return left.findIndex((value) => Math.abs(value) > 0.02) / sound.sampleRate;
        }"""
    )
    start_s = page.evaluate("roboguitarist.player.startS")
    assert start_s + onset_s == pytest.approx(performance.pluck_time_s[0], abs=0.02)


def test_half_speed_takes_twice_as_long_at_the_same_pitch(page):
    plain(page)
    assert page.evaluate("roboguitarist.player.audio.preservesPitch")
    page.select_option("#speed", "0.5")
    place(page, 0.5)
    passed = page.evaluate(
        """async () => {
            const player = roboguitarist.player;
            await player.play();
            while (player.time <= 0.55) await new Promise((done) => setTimeout(done, 5));
            const [before, started] = [player.time, performance.now()];
            await new Promise((done) => setTimeout(done, 1500));
            return (1000 * (player.time - before)) / (performance.now() - started);
        }"""
    )
    assert passed == pytest.approx(0.5, abs=0.1)


def test_a_loop_goes_back_to_its_first_bar(page):
    plain(page)
    page.select_option("#loop-from", index=1)
    page.select_option("#loop-to", index=1)
    page.check("#loop")
    assert page.evaluate("roboguitarist.player.loop") == {"fromS": 2.0, "toS": 4.0}
    assert page.evaluate("roboguitarist.player.time") == pytest.approx(2.0, abs=0.05)
    place(page, 3.6)
    times = page.evaluate(
        """async () => {
            const times = [];
            await roboguitarist.player.play();
            for (let k = 0; k < 45; k++) {
                await new Promise((done) => setTimeout(done, 40));
                times.push(roboguitarist.player.time);
            }
            return times;
        }"""
    )
    page.uncheck("#loop")
    assert max(times) < 4.4
    assert min(times) >= 2.0 - 0.01
    backwards = np.flatnonzero(np.diff(times) < -1)
    assert len(backwards) == 1
    assert times[backwards[0] + 1] == pytest.approx(2.1, abs=0.2)


def test_clicks_on_the_tablature_the_slider_and_keys_go_there(page):
    place(page, 0.0)
    box = page.locator("#tab").bounding_box()
    page.mouse.click(box["x"] + 0.25 * box["width"] + 180, box["y"] + 40)
    per_second = page.evaluate("roboguitarist.tab.perSecond")
    assert page.evaluate("roboguitarist.player.time") == pytest.approx(180 / per_second, abs=0.05)
    page.keyboard.press("ArrowRight")
    assert page.evaluate("roboguitarist.player.time") == pytest.approx(4.0, abs=0.01)
    page.locator("#seek").fill("3")
    assert page.evaluate("roboguitarist.player.time") == pytest.approx(3.0, abs=0.02)


def test_misses_and_metrics_are_shown(page):
    page.click("#details-button")
    assert page.inner_text("#title") == "Für zwei <Hände>"
    assert page.inner_text("#details-button") == "11 of 12 notes right"
    assert "not plucked" in page.inner_text("#misses")
    assert "Notes, F1" in page.inner_text("#metrics")
    page.click("#misses button")
    assert page.evaluate("roboguitarist.player.time") == pytest.approx(1.5, abs=0.02)
    page.click("#details-button")
    place(page, 2.6)
    picture(page)
    marks = page.evaluate("roboguitarist.stage.wanted.filter((mark) => mark.visible).length")
    assert marks == 1


def test_the_console_is_silent_and_nothing_is_asked_of_a_network(opened):
    _, seen = opened
    # Software rendering itself is slow to be read from; that is no complaint about the page.
    complaints = [text for text in seen["complaints"] if "GPU stall" not in text]
    assert complaints == []
    assert seen["requests"]
    assert all(url.startswith(("file:", "blob:", "data:")) for url in seen["requests"])
