"""How the tests are dealt out to workers, on which those over DDS depend."""

import pytest


@pytest.mark.xdist_group("dds")
def test_a_group_is_one_worker_s(request):
    # Versions of pytest and pytest-xdist that do not fit deal out groups test by test, and say
    # nothing; without workers there is nothing to deal out.
    if request.config.getoption("loadgroup", False):
        assert request.node.nodeid.endswith("@dds")
