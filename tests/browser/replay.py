"""Checks the page of a replay: replay.py CHROMIUM REPLAY.html [SCREENSHOTS].

The 3D view draws something that changes with time, with the camera and with
the theme; it plays, is worked by keyboard, and marks jump; without WebGL and
without script everything else is there.
"""

import base64
import pathlib
import sys

import check as common
from check import check, quiet
from devtools import Browser, Page

WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
WIDTHS = [1280, 390]
SETTLE = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))"


def seen(page):
    """What the view shows now, as the bytes of a picture."""
    page.evaluate(SETTLE)
    box = page.evaluate("(() => { const b = document.getElementById('view').getBoundingClientRect();"
                        "return {x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height} })()")
    # The clock lies over the view.
    page.evaluate("document.querySelector('.overlay').style.visibility = 'hidden'")
    shot = page.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip={**box, "scale": 1})
    page.evaluate("document.querySelector('.overlay').style.visibility = ''")
    return shot["data"]


def at(page, part):
    page.evaluate(
        f"""(() => {{ const t = document.getElementById('time');
        t.value = Number(t.min) + {part} * (Number(t.max) - Number(t.min));
        t.dispatchEvent(new Event('input')); }})()"""
    )


def press(page, key, shift=False):
    page.evaluate("document.getElementById('view').focus()")
    for kind in ("keyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 if shift else 0)


def view(page, where):
    """The picture changes with whatever should change it."""
    at(page, 0.1)
    first = seen(page)
    check(len(first) > 4000, f"{where}: something is drawn ({len(first)} bytes)")
    check(seen(page) == first, f"{where}: the same time gives the same picture")
    at(page, 0.6)
    later = seen(page)
    check(later != first, f"{where}: another time gives another picture")
    for key, shift in (("ArrowLeft", False), ("ArrowUp", False), ("+", False), ("ArrowRight", True)):
        press(page, key, shift)
        moved = seen(page)
        check(moved != later, f"{where}: {'shift ' if shift else ''}{key} moves the camera")
        later = moved
    press(page, "0")
    whole = seen(page)
    page.evaluate("document.querySelector('[data-act=nearer]').click()")
    check(seen(page) != whole, f"{where}: the button for nearer works")
    page.evaluate("document.querySelector('[data-act=fit]').click()")
    check(seen(page) == whole, f"{where}: the button for all shows all again")
    middle = page.evaluate("(() => { const b = document.getElementById('view').getBoundingClientRect();"
                           "return [b.x + b.width / 2, b.y + b.height / 2] })()")
    for kind, dx, buttons in (("mousePressed", 0, 1), ("mouseMoved", 80, 1), ("mouseReleased", 80, 0)):
        page.call("Input.dispatchMouseEvent", type=kind, x=middle[0] + dx, y=middle[1], button="left", buttons=buttons, clickCount=1)
    check(seen(page) != whole, f"{where}: dragging turns it")
    press(page, "0")


def plays(page, where):
    clock = "Number(document.getElementById('time').value)"
    at(page, 0.2)
    before = page.evaluate(clock)
    page.evaluate("document.getElementById('speed').value = '4'")
    page.evaluate("document.getElementById('play').click()")
    page.evaluate("new Promise(done => setTimeout(() => done(1), 600))")
    page.evaluate("document.getElementById('play').click()")
    after = page.evaluate(clock)
    check(after > before + 0.3, f"{where}: it plays ({before:.2f} s to {after:.2f} s)")
    page.evaluate("new Promise(done => setTimeout(() => done(1), 200))")
    check(page.evaluate(clock) == after, f"{where}: it pauses")
    press(page, " ")
    check(page.evaluate("document.getElementById('play').textContent") == "Pause", f"{where}: space plays")
    press(page, " ")


def marks(page, where):
    moments = page.evaluate("[...document.querySelectorAll('[data-go]')].map(m => Number(m.dataset.go))")
    for index, moment in enumerate(moments):
        page.evaluate(f"document.querySelectorAll('[data-go]')[{index}].click()")
        page.evaluate(SETTLE)
        there = page.evaluate("Number(document.getElementById('time').value)")
        check(abs(there - moment) < 0.02, f"{where}: the mark at {moment:.2f} s is gone to")
    values = page.evaluate("[...document.querySelectorAll('.plot .now')].map(v => v.textContent)")
    check(all(values), f"{where}: every signal says its value ({len(values)})")
    inside = page.evaluate(
        """[...document.querySelectorAll('.flag-line, .name-text')].filter(mark => {
            const frame = mark.parentElement.getBoundingClientRect(), box = mark.getBoundingClientRect();
            return box.left < frame.left - 2 || box.right > frame.right + 2;
        }).length"""
    )
    check(inside == 0, f"{where}: marks lie inside their plots")


def layout(page, where):
    wide = page.evaluate("document.scrollingElement.scrollWidth") - page.width
    check(wide <= 0, f"{where}: no sideways scrolling ({wide} px)")
    sticking = page.evaluate(common.STICKING % page.width)
    check(not sticking, f"{where}: nothing is cut off at the right {sticking or ''}".rstrip())


def with_webgl(program, address, folder):
    with Browser(program, WEBGL) as browser:
        for width in WIDTHS:
            for scheme in ("light", "dark"):
                where = f"{width} px, {scheme}"
                page = Page(browser, width, media=[("prefers-color-scheme", scheme)])
                page.open(address)
                page.evaluate(SETTLE)
                check(page.evaluate("!document.getElementById('stage').hidden"), f"{where}: there is a view")
                common.picture(page, folder, f"replay-{width}-{scheme}")
                layout(page, where)
                view(page, where)
                plays(page, where)
                marks(page, where)
                before = seen(page)
                common.theme(page)
                page.evaluate("document.getElementById('theme').click()")
                check(seen(page) != before, f"{where}: the view changes with the theme")
                quiet(page, where)
                page.close()


def without(program, address, folder):
    """No WebGL, then no script: the rest is all there, and says so."""
    with Browser(program, ["--disable-3d-apis"]) as browser:
        for script in (True, False):
            where = "no WebGL" if script else "no script"
            page = Page(browser, 1280, script=script)
            page.open(address)
            told = "(e => !e.hidden && e.checkVisibility())(document.getElementById('no-view'))"
            check(page.evaluate(told), f"{where}: it is said that there is no view")
            hidden = page.evaluate("document.getElementById('stage').hidden")
            check(hidden, f"{where}: no empty view")
            plots = page.evaluate("document.querySelectorAll('.strip-box svg').length")
            check(plots == page.evaluate("document.querySelectorAll('[data-signal]').length"), f"{where}: {plots} plots")
            if script:
                marks(page, where)
            layout(page, where)
            common.picture(page, folder, "replay-" + where.replace(" ", "-"))
            quiet(page, where)
            page.close()


def main():
    program, replay = sys.argv[1:3]
    folder = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    address = pathlib.Path(replay).resolve().as_uri()
    with_webgl(program, address, folder)
    without(program, address, folder)
    failed = len(common.failures)
    print(f"{failed} failed" if failed else "all passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
