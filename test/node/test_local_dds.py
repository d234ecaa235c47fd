"""Domains of DDS: each process that asks is given one of its own, for as long as it lives."""

import subprocess
import sys

from peg_on_hole_ros.ros.local_dds import free_domain

ASK = "from peg_on_hole_ros.ros.local_dds import free_domain; print(free_domain(), flush=True); "


def test_a_domain_is_given_once_while_nobody_has_joined_it():
    mine = {free_domain() for _ in range(3)}
    assert len(mine) == 3
    others = [
        subprocess.Popen(
            [sys.executable, "-c", ASK + "input()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(4)
    ]
    theirs = [int(other.stdout.readline()) for other in others]
    for other in others:
        other.communicate("\n")
    assert len({*mine, *theirs}) == 7
