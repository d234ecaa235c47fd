"""Ten minutes at 1 kHz: a page that a mail takes, and every peak is in it."""

import numpy as np
import pytest
from test_report_page import replay_of

from estimates import SCENE, columns, estimate
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.monitor.output_row import ROW
from peg_on_hole_ros.records import ANGLES, JointSample, Rows, WrenchSample
from peg_on_hole_ros.report.replay_page import replay_page
from peg_on_hole_ros.report.tracks import Tracks
from small_bags import MS

COUNT = 600_000
SCALARS = (
    *("jamming_risk", "jamming_wedging", "jamming_stall", "jamming_load"),
    *("transition_probability", "three_point_validity", "nis_median", "nis_drift"),
    *("friction", "clearance"),
)
PEAK = 123_457

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.timeout(900)]


def outputs():
    """Return an estimate that has everything that is drawn."""
    told = dict.fromkeys(SCALARS, 0.5) | {"reactions_determined": 1.0}
    told |= {"friction_stddev": 0.01, "clearance_stddev": 1e-6}
    return estimate(t_ns=10**9, monitor=told)


def noise(count):
    """Yield rows that are nowhere as they were: they pack badly."""
    rng = np.random.default_rng(4)
    for begun in range(0, count, 1000):
        yield from rng.normal(size=(min(1000, count - begun), 12 + len(SCALARS))).tolist()


@pytest.fixture(scope="module")
def long_report(tmp_path_factory):
    tracks, made = Tracks(), outputs()
    beside = columns(OutputStream(SCENE), made).beside
    found = replay_of(tmp_path_factory.mktemp("long") / "long.mcap", tracks)
    for k, row in enumerate(noise(COUNT)):
        t_ns = 10**9 + k * MS
        turned, loads, read, told = row[:3], row[3:6], row[6:12], row[12:]
        values = np.array([made.row], ROW)
        values["state"][0, :3] = [0.15 + 1e-3 * turned[0], *turned[1:]]
        values["normal"] = [100.0 + n for n in loads]
        for name, value in zip(SCALARS, told):
            values[name] = value
        if k == PEAK:
            values["normal"][0, 0] = 345.6
        found.inputs.read(WrenchSample(t_ns, tuple(read[:3]), tuple(read[3:])))
        if k % 50 == 0:
            found.inputs.read(JointSample(t_ns, ANGLES, (0.15, *turned[1:])))
        taken = OutputColumns(Rows(np.array([t_ns]), values), beside)
        tracks.take(taken)
        found.inputs.take(taken)
    path = found.path.with_suffix(".html")
    path.write_text(replay_page(found), encoding="utf-8")
    return path


@pytest.mark.nightly
def test_ten_minutes_are_less_than_five_megabytes_and_keep_their_peak(long_report, opened):
    assert long_report.stat().st_size < 5_000_000
    shown = opened(long_report)
    assert shown.span() == pytest.approx((0.0, (COUNT - 1) / 1000))
    highest, at = shown.page.evaluate(
        """() => {
          const lines = document.querySelector(".plot[data-panel=reactions]").data;
          const line = lines.find((one) => one.name === "N_K" && !one.fill);
          const highest = Math.max(...line.y);
          return [highest, line.x[line.y.indexOf(highest)]];
        }"""
    )
    assert highest == pytest.approx(345.6, abs=0.01)
    assert at == pytest.approx(PEAK / 1000, abs=0.5)
    # The drawing has that moment, as it was.
    shown.page.locator("#time").fill(str((PEAK + 1) / 1000))
    assert shown.reading("K").startswith("346 ± ")
    summary = shown.page.inner_text("#summary")
    assert "Worst load: 346 N at K, 69% of its limit of 500 N." in summary
