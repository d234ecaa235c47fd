#!/usr/bin/env bash
# The tests of `make run` and of replays on the other Python that the README names, where there is one.
set -euo pipefail
cd "$(dirname "$0")/.."
# Where pyenv holds it, it is found by its variable.
other=$(PYENV_VERSION=3.12 python3.12 -c 'import sys; print(sys.executable)' 2>/dev/null || true)
if [ -z "$other" ]; then
    echo "there is no Python 3.12 here" >&2
    exit 1
fi
# In a copy: pip would write into the same folder of the sources twice at a time.
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
tar -c --exclude=./.git --exclude='./.venv*' --exclude=./out . | tar -x -C "$copy"
# One worker: what is compiled is compiled once.
make -C "$copy" test-other PYTHON="$other" EXTRAS=ros,report,test WORKERS=1 \
    PYTEST_ARGS="test/cli/test_demo.py test/cli/test_cli_replay.py"
