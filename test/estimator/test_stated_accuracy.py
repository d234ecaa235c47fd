"""What stated accuracies add to the bounds: that of putting each error in, one by one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from insertions import inserted
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Accuracy
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import ACCURACIES, WrenchSample
from peg_on_hole_ros.replay.run import stored_configuration
from peg_on_hole_ros.sim.measure import measure
from recorded_faults import BAGS, samples

JAM, SLIP, _ = BAGS
# A low-pass is stated of the wrench, and lags only where the load changes fast.
LASTING = tuple(kind for kind in ACCURACIES if kind != "low_pass")
PAYLOAD = {"payload_mass": 2.0, "payload_com": (0.01, 0.0, -0.03)}
HOLE = "in the hole"
# Of each [s]: they slide on three contacts or two, and friction has been learnt for a while.
TIMES = {JAM: (0.3, 0.5), SLIP: (0.3, 0.5), HOLE: (0.127, 0.183)}
HALF = np.sqrt(0.5)


def with_section(configuration, section, **values):
    return replace(configuration, **{section: replace(getattr(configuration, section), **values)})


def read_as(change):
    """Return a change of samples by a function of the six values of a wrench."""

    def changed(sample):
        if not isinstance(sample, WrenchSample):
            return sample
        values = np.array([*sample.force, *sample.torque])
        return WrenchSample.of_row(sample.t_ns, values + change(values))

    return changed


def turned(along, across):
    """Return a change of samples: the peg is seen turned about e and about h [rad]."""

    def changed(sample):
        if isinstance(sample, WrenchSample):
            return sample
        gamma, psi, phi = sample.position
        s, c = np.sin(gamma), np.cos(gamma)
        return sample._replace(position=(gamma + along, psi + across / s, phi - across * c / s))

    return changed


def errors_of(kind, configuration):
    """Return of each error of a kind the samples' change and what is stated then."""
    stated, wrench = Accuracy(), configuration.wrench
    axes, channels = np.eye(3), np.eye(6)
    if kind == "gain":
        share = HALF * stated.gain
        own = [read_as(lambda u, e=e: share * e * u) for e in channels]
        return [(change, configuration) for change in (*own, read_as(lambda u: share * u))]
    if kind == "crosstalk":

        def others(u, i):
            three = np.delete(u[:3], i) if i < 3 else np.delete(u[3:], i - 3)
            return stated.crosstalk * np.linalg.norm(three) * channels[i]

        return [(read_as(lambda u, i=i: others(u, i)), configuration) for i in range(6)]
    if kind == "orientation":
        off = stated.orientation
        return [(turned(off, 0.0), configuration), (turned(0.0, off), configuration)]
    off = {
        "sensor_place": [
            {"sensor_xyz": tuple(wrench.sensor_xyz + stated.sensor_xyz * e)} for e in axes
        ],
        "sensor_axes": [{"sensor_rpy": tuple(stated.sensor_rpy * e)} for e in axes],
        "payload": [
            {"payload_mass": (1.0 + stated.payload_mass) * PAYLOAD["payload_mass"]},
            *(
                {"payload_com": tuple(PAYLOAD["payload_com"] + stated.payload_com * e)}
                for e in axes
            ),
        ],
    }
    if kind in off:
        return [(None, with_section(configuration, "wrench", **values)) for values in off[kind]]
    scene = configuration.scene
    thicker = {"peg_diameter": scene.peg_diameter + stated.diameter}
    wider = {"hole_diameter": scene.hole_diameter + stated.diameter}
    return [(None, with_section(configuration, "scene", **each)) for each in (thicker, wider)]


@cache
def seen(case, payload=False):
    """Return the configuration of a bag or an insertion, and its samples."""
    if case == HOLE:
        truth = inserted("goes_on")
        return truth.plan.configuration, list(measure(truth, 4))
    configuration, recorded = stored_configuration(Bag(case)), samples(case, 0.0, 0.51)
    if payload:
        recorded = [*carrying(recorded, configuration)]
    return configuration, recorded


def carrying(recorded, configuration):
    """Yield samples of a sensor that carries PAYLOAD as well, so slowly that it has no inertia."""
    mass, arm = PAYLOAD["payload_mass"], PAYLOAD["payload_com"]
    q = None
    for sample in recorded:
        if not isinstance(sample, WrenchSample):
            q = sample.position
        elif q is not None:
            weight = -mass * peg_axes(np.array(q)).T @ configuration.scene.gravity
            sample = WrenchSample.of_row(
                sample.t_ns,
                np.array([*sample.force, *sample.torque]) + [*weight, *np.cross(arm, weight)],
            )
        yield sample


def played(configuration, case, change=None, payload=False):
    """Return the outputs by time [s]."""
    recorded = seen(case, payload)[1]
    outputs = list(Pipeline(configuration).play(map(change, recorded) if change else recorded))
    return {round((each.t_ns - outputs[0].t_ns) * 1e-9, 3): each for each in outputs}


@cache
def plain(case, payload=False):
    """Return what is stated, and the outputs by time [s]."""
    configuration = with_section(seen(case)[0], "wrench", **(PAYLOAD if payload else {}))
    # What contacts give changes with the load: no error that a setting could have for a motion.
    configuration = with_section(configuration, "accuracy", compliance=0.0)
    return configuration, played(configuration, case, payload=payload)


@cache
def moved_by(case, kind):
    """Return by time what the errors of a kind move the reactions by, squared, shape (3,)."""
    configuration, told = plain(case, kind == "payload")
    found = {t: np.zeros(3) for t in TIMES[case]}
    for change, stated in errors_of(kind, configuration):
        off = played(stated, case, change, kind == "payload")
        for t in TIMES[case]:
            found[t] += (off[t].normal - told[t].normal) ** 2
    return found


# What is found over what is moved, least and most. Friction that is learnt without slip takes up
# errors of the geometry by twice as much as one wrench says.
WITHIN = {SLIP: (0.65, 1.35), JAM: (0.35, 1.6)}


@pytest.mark.parametrize("kind", LASTING)
@pytest.mark.parametrize("case", WITHIN, ids=lambda case: case.stem)
def test_each_kind_adds_what_its_errors_move_the_reactions_by(case, kind):
    told, (least, most) = plain(case, kind == "payload")[1], WITHIN[case]
    for t in TIMES[case]:
        assert told[t].contact_mode == "three_point"
        expected = np.sqrt(moved_by(case, kind)[t].max())
        largest = np.sqrt(max(moved_by(case, each)[t].max() for each in LASTING))
        found = told[t].monitor[f"doubt_{kind}"]
        assert found > least * expected, t
        # What is small beside the largest may be too wide: the motion makes up for some of it.
        assert found < max(most * expected, 0.6 * largest), t


@pytest.mark.parametrize("case", TIMES, ids=lambda case: getattr(case, "stem", case))
def test_all_errors_together_are_within_what_is_added(case):
    configuration, told = plain(case)
    exact = played(replace(configuration, accuracy=Accuracy.exact()), case)
    kinds = [kind for kind in LASTING if kind != "payload"]
    for t in TIMES[case]:
        moved = np.sqrt(sum(moved_by(case, kind)[t] for kind in kinds))
        added = np.sqrt(told[t].normal_stddev ** 2 - exact[t].normal_stddev ** 2)
        # Without slip friction takes up more of tilt and diameter than one wrench says.
        assert (added > (0.4 if case == JAM else 0.75) * moved).all(), t
        # In the hole the motion makes up for much of it.
        assert (added < (6.0 if case == HOLE else 2.0) * moved.max()).all(), t
        if case == HOLE:
            assert told[t].contact_mode == "two_point"
            assert told[t].normal_stddev[1] == pytest.approx(told[t].normal_stddev[2], rel=1e-6)


def test_nothing_but_bounds_depends_on_what_is_stated():
    configuration, told = plain(SLIP)
    exact = played(replace(configuration, accuracy=Accuracy.exact()), SLIP)
    same = ("state", "state_stddev", "normal", "contact_wrench", "contact_mode", "transition")
    for t, row in exact.items():
        for name in same:
            np.testing.assert_array_equal(getattr(told[t], name), getattr(row, name))
        assert told[t].row["alarms"].tobytes() == row.row["alarms"].tobytes()
        assert (told[t].normal_stddev >= row.normal_stddev).all()


def test_where_all_is_exact_bounds_are_the_filters_own():
    configuration, _ = plain(SLIP)
    line = Pipeline(replace(configuration, accuracy=Accuracy.exact()))
    out = list(line.play(seen(SLIP)[1]))[-1]
    np.testing.assert_array_equal(out.normal_stddev, line.filter.reactions()[1])
    assert not any(f"doubt_{kind}" in out.monitor for kind in ACCURACIES)


def test_kinds_add_up_to_the_bound():
    _, told = plain(SLIP)
    exact = played(replace(plain(SLIP)[0], accuracy=Accuracy.exact()), SLIP)
    added = told[0.5].normal_stddev ** 2 - exact[0.5].normal_stddev ** 2
    kinds = np.array([told[0.5].monitor[f"doubt_{kind}"] for kind in ACCURACIES])
    assert added.max() <= (kinds**2).sum() * (1 + 1e-9)
    assert (added >= 0.0).all() and added.max() >= 0.4 * (kinds**2).sum()


def test_reactions_that_an_accuracy_leaves_open_are_not_determined():
    configuration, told = plain(SLIP)
    vague = played(with_section(configuration, "accuracy", gain=0.5, sensor_rpy=0.5), SLIP)
    assert told[0.5].monitor["reactions_determined"] == 1.0
    assert vague[0.5].monitor["reactions_determined"] == 0.0
    assert vague[0.5].contact_mode == told[0.5].contact_mode == "three_point"


def test_what_is_stated_of_tilt_and_clearance_themselves_counts_once():
    configuration, _ = plain(SLIP)
    with_tilt = played(with_section(configuration, "joints", hole_tilt_stddev=1e-3), SLIP)
    assert with_tilt[0.5].monitor["doubt_orientation"] == 0.0
    gauged = played(with_section(configuration, "scene", clearance_stddev=2e-6), SLIP)
    assert gauged[0.5].monitor["doubt_diameter"] == 0.0


def test_contacts_that_give_leave_more_open_the_more_they_carry():
    configuration, _ = plain(SLIP)
    rigid = replace(Accuracy.exact(), compliance=0.0, diameter=1e-6)
    soft = replace(Accuracy.exact(), compliance=1e-7)
    gauged, gives = (played(replace(configuration, accuracy=each), SLIP) for each in (rigid, soft))
    for t in TIMES[SLIP]:
        of_one_micrometre = gauged[t].monitor["doubt_diameter"] / np.sqrt(2.0)
        load = gives[t].normal.sum()
        # Friction has followed both over loads that were not all the same.
        assert gives[t].monitor["doubt_diameter"] == pytest.approx(
            1e-7 * load / 1e-6 * of_one_micrometre, rel=0.1
        )
    learnt = with_section(configuration, "scene", compliance_stddev=1e-8)
    stated = played(replace(learnt, accuracy=soft), SLIP)
    assert stated[0.5].monitor["doubt_diameter"] == 0.0


def test_friction_is_known_no_better_than_what_it_was_learnt_from():
    configuration, told = plain(JAM)
    exact = played(replace(configuration, accuracy=Accuracy.exact()), JAM)
    moved = 0.0
    for change, stated in errors_of("sensor_axes", configuration):
        off = played(stated, JAM, change)
        moved += (off[0.5].monitor["friction"] - told[0.5].monitor["friction"]) ** 2
    axes = with_section(
        replace(configuration, accuracy=Accuracy.exact()), "accuracy", sensor_rpy=5e-3
    )
    stddev = [each[0.5].monitor["friction_stddev"] for each in (played(axes, JAM), exact)]
    assert 0.7 < np.sqrt((stddev[0] ** 2 - stddev[1] ** 2) / moved) < 1.6


def test_a_reset_forgets_what_friction_was_learnt_from():
    configuration, _ = plain(JAM)
    line = Pipeline(configuration)
    list(line.play(seen(JAM)[1]))
    line.reset()
    later = list(line.play(samples(JAM, 0.51, 0.53)))
    assert later[0].monitor["friction_stddev"] == pytest.approx(
        configuration.scene.friction_stddev, rel=0.1
    )


def test_the_summary_says_which_accuracy_bounds_the_reactions(capsys):
    assert main(["replay", str(SLIP)]) == 0
    (line,) = (x for x in capsys.readouterr().out.splitlines() if "stated accuracies" in x)
    assert "N by accuracy." in line


def test_a_low_pass_widens_bounds_by_its_lag_where_the_load_changes_fast():
    """A press that rises by 2 N a millisecond, behind 100 Hz, lags by 1.6 ms and so by 3.2 N."""
    configuration, recorded = seen(SLIP)
    rises = range(400, 405)

    def pressed(sample, lacks=0.0):
        if not isinstance(sample, WrenchSample):
            return sample
        risen = round((sample.t_ns - recorded[0].t_ns) * 1e-6) - rises[0] + 1
        more = 2.0 * min(max(risen, 0), len(rises)) + lacks * (risen > 0)
        return sample._replace(force=(*sample.force[:2], sample.force[2] - more))

    def pressing(low_pass, change=pressed):
        wrench = replace(configuration.wrench, low_pass=low_pass)
        stated = replace(configuration, wrench=wrench, accuracy=Accuracy.exact())
        return played(stated, SLIP, change)

    def doubts(low_pass):
        outputs = pressing(low_pass).items()
        return {t: each.monitor.get("doubt_low_pass", np.nan) for t, each in outputs}

    found, slower = doubts(100.0), doubts(50.0)
    as_read, ahead = pressing(0.0), pressing(0.0, lambda sample: pressed(sample, 3.18))
    # The first two jump, and count little as spikes.
    for k in rises[2:]:
        moved = np.abs(ahead[k / 1000].normal - as_read[k / 1000].normal).max()
        # Changes have noise, of which two deviations are taken off.
        assert found[k / 1000] == pytest.approx(moved, rel=0.3)
        assert slower[k / 1000] == pytest.approx(2.0 * found[k / 1000], rel=0.05)
    # Of a load that changes slowly, what noise makes of it now and then.
    assert np.median([found[k / 1000] for k in range(200, 390)]) < 0.1
    assert np.isnan(doubts(0.0)[0.3])
