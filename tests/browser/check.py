"""Checks a report in a browser: check.py CHROMIUM REPORT.html [SCREENSHOTS].

No errors, no requests, no sideways scrolling on a phone, every section there
and visible, the theme button works, and all of it readable without script.
"""

import base64
import pathlib
import sys

from devtools import Browser, Page

SECTIONS = [
    "verdict", "matrix", "forest", "modes", "suspects", "comparisons",
    "argument", "ledger", "coverage", "published", "cost", "provenance", "reading",
]
WIDTHS = [1280, 390]

# Elements beyond the right edge, unless something around them scrolls or cuts
# them with an ellipsis.
STICKING = """(limit => {
    const beyond = e => e.getBoundingClientRect().right > limit + 1;
    const held = e => {
        for (let p = e.parentElement; p; p = p.parentElement)
            if (getComputedStyle(p).overflowX !== 'visible' && !beyond(p)) return true;
        return false;
    };
    return [...document.querySelectorAll('main *')]
        .filter(e => !e.closest('svg') && e.getBoundingClientRect().width > 1 && beyond(e) && !held(e))
        .slice(0, 5).map(e => e.tagName + '.' + (e.getAttribute('class') || ''));
})(%d)"""

failures = []


def check(holds, what):
    print(("ok    " if holds else "FAIL  ") + what)
    if not holds:
        failures.append(what)


def quiet(page, where):
    """No error on the console, no exception, nothing asked of the network."""
    errors = [e["exceptionDetails"]["text"] for e in page.mine("Runtime.exceptionThrown")]
    errors += [e["entry"]["text"] for e in page.mine("Log.entryAdded") if e["entry"]["level"] == "error"]
    errors += [str(e["args"]) for e in page.mine("Runtime.consoleAPICalled") if e["type"] in ("error", "assert")]
    check(not errors, f"{where}: no errors {errors or ''}".rstrip())
    asked = [e["request"]["url"] for e in page.mine("Network.requestWillBeSent")]
    others = [url for url in asked if not url.startswith(("file:", "data:"))]
    files = [url for url in asked if url.startswith("file:")]
    check(not others and len(files) == 1, f"{where}: nothing is loaded but the file {others or ''}".rstrip())


def layout(page, where):
    """Every section is there, has height, and nothing sticks out sideways."""
    script = "(%s).map(id => { const s = document.getElementById(id); return s ? s.getBoundingClientRect().height : 0 })"
    heights = page.evaluate(script % SECTIONS)
    hidden = [name for name, height in zip(SECTIONS, heights) if height < 40]
    check(not hidden, f"{where}: every section is visible {hidden or ''}".rstrip())
    # Against the width that was asked for: a phone widens its own view.
    wide = page.evaluate("document.scrollingElement.scrollWidth") - page.width
    check(wide <= 0, f"{where}: no sideways scrolling ({wide} px)")
    sticking = page.evaluate(STICKING % page.width)
    check(not sticking, f"{where}: nothing is cut off at the right {sticking or ''}".rstrip())


def plots(page, where):
    """Strips have width and their marks are inside."""
    stray = page.evaluate(
        """[...document.querySelectorAll('svg.strip')].filter(svg => {
            const frame = svg.getBoundingClientRect();
            if (frame.width === 0) return svg.checkVisibility();
            return [...svg.querySelectorAll('.mark')].some(mark => {
                const box = mark.getBoundingClientRect();
                return box.left < frame.left - 8 || box.right > frame.right + 8;
            });
        }).length"""
    )
    count = page.evaluate("document.querySelectorAll('svg.strip').length")
    check(stray == 0, f"{where}: the marks of {count} strips lie inside")


def theme(page):
    colour = "getComputedStyle(document.body).backgroundColor"
    press = "document.getElementById('theme').click()"
    check(page.evaluate("document.getElementById('theme').checkVisibility()"), "theme: the button is there")
    before = page.evaluate(colour)
    page.evaluate(press)
    after = page.evaluate(colour)
    page.evaluate(press)
    check(before != after and page.evaluate(colour) == before, f"theme: the button changes it and back ({before}, {after})")


def filters(page):
    """Each outcome's filter shows that outcome's pairs alone, then all again."""
    visible = "[...document.querySelectorAll('[data-outcome]')].filter(r => !r.hidden)"
    names = page.evaluate("[...document.querySelectorAll('[data-filter]')].map(f => f.dataset.filter)")
    everything = page.evaluate(visible + ".length")
    for name in names:
        press = f"document.querySelector('[data-filter=\"{name}\"] button').click()"
        page.evaluate(press)
        others = page.evaluate(f"{visible}.filter(r => r.dataset.outcome !== '{name}').length")
        page.evaluate(press)
        check(others == 0, f"filter: {name} shows nothing else")
    check(page.evaluate(visible + ".length") == everything, "filter: all pairs are back")


def picture(page, folder, name):
    if folder:
        height = page.evaluate("document.body.getBoundingClientRect().height")
        clip = {"x": 0, "y": 0, "width": page.width, "height": height, "scale": 1}
        shot = page.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)
        (folder / f"{name}.png").write_bytes(base64.b64decode(shot["data"]))


def with_script(browser, address, folder):
    for width in WIDTHS:
        for scheme in ("light", "dark"):
            where = f"{width} px, {scheme}"
            page = Page(browser, width, media=[("prefers-color-scheme", scheme)])
            page.open(address)
            layout(page, where)
            plots(page, where)
            theme(page)
            filters(page)
            page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
            layout(page, where + ", all opened")
            page.evaluate("document.querySelectorAll('details').forEach(d => d.open = false)")
            picture(page, folder, f"{width}-{scheme}")
            quiet(page, where)
            page.close()


def without_script(browser, address, folder):
    for width in WIDTHS:
        where = f"{width} px, no script"
        page = Page(browser, width, script=False)
        page.open(address)
        layout(page, where)
        check(
            not page.evaluate("document.getElementById('theme').checkVisibility()"),
            f"{where}: no button that would do nothing",
        )
        quiet(page, where)
        page.close()


def on_paper(browser, address, folder):
    page = Page(browser, 1280)
    page.open(address)
    printed = page.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
    document = base64.b64decode(printed["data"])
    check(document.startswith(b"%PDF-"), f"paper: prints ({len(document)} bytes)")
    if folder:
        (folder / "paper.pdf").write_bytes(document)
    page.close()


def main():
    program, report = sys.argv[1:3]
    folder = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    address = pathlib.Path(report).resolve().as_uri()
    with Browser(program) as browser:
        with_script(browser, address, folder)
        without_script(browser, address, folder)
        on_paper(browser, address, folder)
    print(f"{len(failures)} failed" if failures else "all passed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
