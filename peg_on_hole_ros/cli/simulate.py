"""`peg-on-hole simulate`: a bag with known truth."""

from argparse import Namespace

from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.cli.output_paths import check_output_paths
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.sim.truth import integrate


def run(arguments: Namespace) -> int:
    """Integrate the truth, measure it, write the bag; say how it ended."""
    check_output_paths([arguments.config], bags=[arguments.out])
    plan = read_plan(arguments.config)
    with ProgressBar("simulating") as progress:
        truth = integrate(plan, progress)
    with ProgressBar("writing") as progress:
        write_bag(arguments.out, truth, progress=progress)
    duration = (len(truth.t_ns) - 1) / plan.wrench_rate
    print(f"{arguments.out}: {duration:.3f} s, seed {plan.seed}, ended by: {truth.ended_by}")
    for t_ns, what in truth.events:
        print(f"  {t_ns / 1e9:8.3f} s  {what}")
    return 0
