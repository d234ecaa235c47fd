"""The live page: the report's drawing and a few strips, which a stream of frames moves."""

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.report.markup import html, section
from peg_on_hole_ros.report.page import bare_page, views_and_readings

_LIVE_SCRIPTS = ("theme.js", "drawing.js", "readings.js", "strips.js", "live.js")
# Without an estimate for longer a strip has a gap [s]: four frames.
LEAST_SILENCE = 0.2
_STRIPS = (
    ("tilt", "Tilt", "mrad, with gamma0"),
    ("reactions", "Normal reactions", "N; a gap: not determined, or no estimate"),
    ("modes", "Contact mode", ""),
    ("risk", "Risk of jamming, probability of the transition", "triangles mark alarms"),
)


def live_page(name: str) -> str:
    """Return the page for a node of some full name."""
    strips = (
        f'<div class="panel"><h3>{html(title)}</h3>\n<p class="note">{html(note)}</p>\n'
        f'<canvas class="strip{" band" if strip == "modes" else ""}" data-strip="{strip}" '
        f'role="img" aria-label="{html(title)}"></canvas></div>'
        for strip, title, note in _STRIPS
    )
    body = [
        f"<header>\n<h1>{html(name)}</h1>\n",
        # What is wrong, before what the contact does.
        '<div id="banners" role="status"></div>',
        '<p class="lead" id="said">Connecting</p>',
        '<p class="damage" id="status" hidden></p>\n</header>',
        '<section id="live"><div class="desk">',
        f'<aside class="stage">{views_and_readings()}</aside>',
        '<div class="plots">\n' + "\n".join(strips) + "\n</div>\n</div></section>",
        section("alarms", "Alarms", '<ul id="alarmlist"><li>none</li></ul>'),
    ]
    return bare_page(f"{name} live", body, _LIVE_SCRIPTS)


def drawn(configuration: Configuration) -> dict:
    """Return what drawing and strips need to know of a node's settings, ready for JSON."""
    scene, monitor = configuration.scene, configuration.monitor
    return {
        "scene": {
            "hole_diameter": scene.hole_diameter,
            "peg_diameter": scene.peg_diameter,
            "peg_height": scene.peg_height,
            "friction": scene.friction,
        },
        "gamma0": scene.gamma0,
        "max_normal": list(monitor.max_normal),
        "jamming_warn": monitor.jamming_warn,
        "jamming_error": monitor.jamming_error,
        "silence": max(configuration.filter.max_gap, LEAST_SILENCE),
    }
