"""`peg-on-hole plan`: a closing that keeps loads and wedging under limits."""

from argparse import Namespace

from peg_on_hole_ros.cli.output_paths import check_output_paths, out_folder, write_text
from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import to_json
from peg_on_hole_ros.mechanics.planning.load_profile import profile
from peg_on_hole_ros.mechanics.planning.search import plan_motion, remedies
from peg_on_hole_ros.mechanics.planning.words import as_data, in_words


def run(arguments: Namespace) -> int:
    """Plan, print, and write a picture and a file for a robot program."""
    configuration, _ = load(arguments.config)
    folder = None
    if arguments.out is not None:
        needed()
        folder = out_folder(arguments.out, arguments.config)
        names = [str(folder / f"plan.{kind}") for kind in ("json", "png", "svg")]
        check_output_paths([arguments.config], texts=names)
    scene, cell, limits = configuration.scene, configuration.plan, configuration.monitor.max_normal
    plan = plan_motion(scene, cell, limits)
    others = () if plan.possible else remedies(scene, cell, limits)
    data = as_data(plan, cell, others)
    print(to_json(data) if arguments.json else in_words(plan, cell, limits, others))
    if folder:
        from peg_on_hole_ros.plots.plan import figure

        write_text(folder / "plan.json", to_json(data) + "\n")
        profiles = [profile(scene, cell, limits, m) for m in (plan.plain, plan.motion)]
        written = [folder / "plan.json"]
        written += save(figure(*profiles, scene.gamma0, limits), folder / "plan")  # type: ignore[arg-type, call-arg]
        if not arguments.json:
            print(", ".join(map(str, written)))
    return 0
