"""
Compile what most tests run, before several workers would each do so at the same time.

    python tools/compiled.py

What is compiled is kept between runs, for each state of the sources.
"""

import contextlib
import io
import sys
from dataclasses import replace
from pathlib import Path

from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.warm_up import warm
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[1]
NAME = "closing_with_slip"

if __name__ == "__main__":
    warm(Configuration())
    nothing = io.StringIO()
    with contextlib.redirect_stdout(nothing), contextlib.redirect_stderr(nothing):
        code = main(["replay", str(ROOT / "bags" / f"{NAME}.mcap")])
    plan = read_plan(ROOT / "config" / f"{NAME}.yaml")
    integrate(replace(plan, phases=plan.phases[:1]))
    sys.exit(code)
