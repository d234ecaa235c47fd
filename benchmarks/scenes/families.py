"""The families of scenes: how each draws its setting and what its holder is told to do."""

import numpy as np

from benchmarks.scenes.setting import setting_of
from peg_on_hole_ros.sim.dynamics import contacts, scene_numbers

LEAD_IN = 0.05
# A contact that is loaded by less of what the others carry soon opens.
LEAST_SHARE = 0.1
# Slip at which friction is full [m/s].
STILL = 1e-6


def _touching(setting, tilt, rates, offset=None):
    """Return the begin on three contacts, and the lead-in at constant rates."""
    offset = offset or [0.0, 0.0, -setting.press]
    lead = {"kind": "contact", "duration": LEAD_IN, "rates": rates}
    start = {
        "angles": [setting.scene.gamma0 + tilt - LEAD_IN * rates[0], 0.0, 0.0],
        "rates": rates,
        "offset": offset,
    }
    return start, {"lead": lead}


def _rates(setting):
    return [-setting.speed, setting.slide, setting.slip]


def _enter(draw, setting):
    """Return the phase in which the holder goes on in the hole, and comes to rest."""
    return {
        "kind": "two_point",
        "duration": 0.2,
        "rates": [0.0, 0.0, setting.slip],
        "load": [draw.even(10.0, 50.0)] * 2,
    }


def _close(draw, setting, **more):
    """Return a begin in contact and the way through gamma0 into the hole."""
    rates, closing = _rates(setting), draw.even(0.25, 0.45)
    start, phases = _touching(setting, setting.speed * closing, rates)
    phases["close"] = {"kind": "two_point", "duration": closing + 0.03, "rates": rates, **more}
    phases["enter"] = _enter(draw, setting)
    return setting, start, phases


def _insertion(draw):
    setting = setting_of(draw)
    if draw.chance(0.7):
        return _close(draw, setting)
    # From free air: a lead-in and 0.1 s free, landing, then as above.
    closing = draw.even(0.2, 0.3)
    tilt = setting.speed * (closing + 0.06)
    start = {
        "angles": [setting.scene.gamma0 + tilt, 0.0, 0.0],
        "rates": [0.0, 0.0, setting.slip],
        "offset": [0.0, 0.0, 0.003],
    }
    rates = [0.0, 0.0, setting.slip]
    phases = {
        "approach": {"kind": "free", "duration": 0.15, "rates": rates, "offset": [0.0, 0.0, 0.0]},
        "press": {
            "kind": "contact", "duration": 0.12, "rates": _rates(setting),
            "offset": [0.0, 0.0, -setting.press],
        },
        "close": {"kind": "two_point", "duration": closing + 0.03, "rates": _rates(setting)},
        "enter": _enter(draw, setting),
    }  # fmt: skip
    return setting, start, phases


def _wedge(draw):
    slip = draw.sign() * draw.log(0.03, 0.5) if draw.chance(0.25) else 0.0
    setting = setting_of(
        draw,
        clearance=draw.log(5e-5, 2.5e-4),
        friction=draw.even(0.12, 0.4),
        speed=draw.log(0.06, 0.3),
        slide=0.0,
        slip=slip,
        press=draw.even(1e-3, 2e-3),
    )
    return _close(draw, setting)


def _share_of_K(setting, tilt):
    """Return the load on K over that on B1 if a sliding peg is pressed straight down."""
    scene, rates = setting.scene, np.array([-setting.speed, 0.0, 0.0])
    start = np.array([scene.gamma0 + tilt + LEAD_IN * setting.speed, 0.0, 0.0])
    along = contacts(scene_numbers(scene), start, rates, STILL)[2]
    # Sideways the forces of K and of both B balance. Slip takes friction away, and helps K.
    return -(along[1, 0] + along[2, 0]) / (2 * along[0, 0])


def _stall(draw):
    """Return a soft holder whose press rises faster than its pull on the tilt."""
    # The pull on the tilt grows with stiffness times speed, the press with one over its time: a
    # slower press stalls on a softer holder.
    duration = draw.log(0.4, 1.2)
    setting = setting_of(
        draw,
        clearance=draw.log(1e-4, 5e-4),
        friction=draw.even(0.2, 0.45),
        speed=draw.log(0.06, 0.2),
        slide=0.0,
        slip=0.0 if draw.chance(0.7) else draw.sign() * draw.log(0.02, 0.2),
        press=draw.even(0.5e-3, 1.0e-3),
        rotational_stiffness=draw.log(14.0, 50.0) / duration,
    )
    before = draw.even(0.1, 0.2)
    lasts = before + duration + draw.even(0.0, 0.15)
    # From so far that a press straight down would lift it off K nothing begins: more slowly then.
    while _share_of_K(setting, setting.speed * lasts) < LEAST_SHARE:
        setting = setting._replace(speed=0.95 * setting.speed)
    rates = _rates(setting)
    start, phases = _touching(setting, setting.speed * lasts, rates)
    phases["close"] = {"kind": "contact", "duration": before, "rates": rates}
    phases["press"] = {
        "kind": "two_point",
        "duration": duration,
        "rates": rates,
        "offset": [0.0, 0.0, -draw.even(4e-3, 14e-3)],
    }
    phases["hold"] = {"kind": "two_point", "duration": 0.2, "rates": rates}
    return setting, start, phases


def _overpress(draw):
    setting = setting_of(draw, max_normal=draw.log(200.0, 800.0))
    rates, before = _rates(setting), draw.even(0.1, 0.2)
    start, phases = _touching(setting, setting.speed * 0.75, rates)
    phases["close"] = {"kind": "contact", "duration": before, "rates": rates}
    phases["press"] = {
        "kind": "contact",
        "duration": draw.even(0.2, 0.4),
        "rates": rates,
        "offset": [0.0, 0.0, -draw.log(3e-3, 12e-3)],
    }
    phases["hold"] = {"kind": "contact", "duration": 0.1, "rates": rates}
    return setting, start, phases


def _tipped(draw):
    setting = setting_of(draw, slide=0.0, slip=0.0, press=draw.even(0.4e-3, 1e-3))
    rates, before = _rates(setting), draw.even(0.1, 0.25)
    tilt = setting.speed * (before + 0.25) + draw.even(0.05, 0.12)
    start, phases = _touching(setting, tilt, rates, [-5e-4, 0.0, -setting.press])
    phases["close"] = {"kind": "parted", "duration": before, "rates": rates}
    phases["tip"] = {
        "kind": "parted",
        "duration": draw.even(0.15, 0.3),
        "rates": rates,
        "offset": [draw.even(0.5e-3, 2e-3), draw.even(-1e-3, 1e-3), -draw.even(0.0, 5e-4)],
    }
    phases["hold"] = {"kind": "parted", "duration": 0.1, "rates": rates}
    return setting, start, phases


def _friction_jump(draw):
    up = draw.chance(0.75)
    setting = setting_of(draw, slip=draw.sign() * draw.log(0.2, 2.0))
    factor = draw.even(1.5, 3.0) if up else draw.even(0.3, 0.6)
    rates, before = _rates(setting), draw.even(0.1, 0.2)
    after = draw.even(0.15, 0.3)
    start, phases = _touching(setting, setting.speed * (before + after), rates)
    phases["close"] = {"kind": "two_point", "duration": before, "rates": rates}
    phases["jump"] = {
        "kind": "two_point",
        "duration": after + 0.03,
        "rates": rates,
        "friction": setting.friction * factor,
    }
    phases["enter"] = _enter(draw, setting)
    return setting, start, phases


def _clearance(draw):
    tight = draw.chance(0.5)
    clearance = draw.log(2e-5, 5e-5) if tight else draw.log(5e-4, 2e-3)
    return _close(draw, setting_of(draw, clearance=clearance))


def _leave(draw, setting):
    """Return the way off the rim and into the air."""
    height = draw.even(2e-3, 4e-3)
    return {
        "let_go": {
            "kind": "lift_off", "duration": draw.even(0.12, 0.2),
            "rates": [0.0, 0.0, setting.slip], "offset": [0.0, 0.0, height],
        },
        "away": {
            "kind": "free", "duration": 0.12, "rates": [0.0, 0.0, setting.slip],
            "offset": [0.0, 0.0, height + 2e-3],
        },
    }  # fmt: skip


def _contact_loss(draw):
    setting = setting_of(draw)
    before = draw.even(0.15, 0.35)
    tilt = setting.speed * (before + 0.1) + draw.even(0.03, 0.1)
    start, phases = _touching(setting, tilt, _rates(setting))
    phases["close"] = {"kind": "contact", "duration": before, "rates": _rates(setting)}
    return setting, start, phases | _leave(draw, setting)


def _retry(draw):
    """Return a try that is broken off, and in two of three draws a second that goes in."""
    setting = setting_of(draw, press=draw.even(0.5e-3, 1e-3))
    rates, closing = _rates(setting), draw.even(0.15, 0.2)
    back = [0.5 * setting.speed, 0.0, setting.slip]
    tilt = setting.speed * closing + draw.even(0.01, 0.03)
    start, phases = _touching(setting, tilt, rates)
    phases["close"] = {"kind": "contact", "duration": 0.12, "rates": rates}
    phases["reverse"] = {"kind": "contact", "duration": 0.06, "rates": back}
    phases |= _leave(draw, setting)
    phases["let_go"]["duration"] = 0.12
    if draw.chance(1 / 3):
        return setting, start, phases
    spin = [0.0, 0.0, setting.slip]
    tilt = setting.speed * (closing + 0.05)
    angles = [setting.scene.gamma0 + tilt, 0.0, 0.0]
    phases["away"] = {
        "kind": "free", "duration": 0.15, "rates": spin, "angles": angles,
        "offset": [0.0, 0.0, 0.0],
    }  # fmt: skip
    phases["press"] = {
        "kind": "contact", "duration": 0.1, "rates": rates,
        "offset": [0.0, 0.0, -setting.press],
    }  # fmt: skip
    phases["close_again"] = {"kind": "two_point", "duration": closing + 0.03, "rates": rates}
    phases["enter"] = _enter(draw, setting) | {"duration": 0.15}
    return setting, start, phases


def _held(draw):
    """Return a peg that is pressed while it rests, by command: set down, then in the middle."""
    setting = setting_of(draw, press=draw.even(0.4e-3, 1e-3), noise=draw.log(0.5, 8.0))
    rates, still = _rates(setting), [0.0, 0.0, 0.0]
    before, after = draw.even(0.15, 0.3), draw.even(0.1, 0.2)
    tilt = setting.speed * (before + after + 0.15) + draw.even(0.01, 0.05)
    angles = [setting.scene.gamma0 + tilt, 0.0, 0.0]
    presses = [[0.0, 0.0, -setting.press * draw.log(1.5, 5.0)] for _ in range(2)]
    on_three = {"kind": "contact", "rates": still}
    if draw.chance(0.5):
        start = {"angles": angles, "rates": still, "offset": [0.0, 0.0, 0.003]}
        begin = {
            "approach": {"kind": "free", "duration": 0.15, "rates": still, "offset": still},
            "press": {**on_three, "duration": 0.12, "offset": [0.0, 0.0, -setting.press]},
        }
    else:
        start = {"angles": angles, "rates": still, "offset": [0.0, 0.0, -setting.press]}
        begin = {"lead": {**on_three, "duration": LEAD_IN}}
    return setting, start, begin | {
        "press_more": {**on_three, "duration": draw.even(0.1, 0.3), "offset": presses[0]},
        "close": {"kind": "contact", "duration": before, "rates": rates},
        "stop": {**on_three, "duration": draw.even(0.06, 0.15)},
        "press_again": {**on_three, "duration": draw.even(0.1, 0.25), "offset": presses[1]},
        "go_on": {"kind": "contact", "duration": after, "rates": rates},
    }  # fmt: skip


FAMILY = {
    "insertion": _insertion,
    "wedge": _wedge,
    "stall": _stall,
    "overpress": _overpress,
    "tipped": _tipped,
    "friction_jump": _friction_jump,
    "clearance": _clearance,
    "contact_loss": _contact_loss,
    "retry": _retry,
    "held": _held,
}
