#!/bin/sh
# Makes validation/.venv with what the scripts of this folder need, the Python package of pennate among it; `setup.sh bench`
# adds the programs of bench/.
#
# Pictures are drawn off-screen. Where VTK finds no graphics library it says so; on Debian and Ubuntu this
# helps: apt-get install libgl1 libegl1
set -eu
cd "$(dirname "$0")"

PYTHON=${PYTHON:-python3}
if ! "$PYTHON" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
    echo "setup.sh: needs Python 3.11 or newer with venv (Debian: apt-get install python3-venv)" >&2
    exit 1
fi

[ -x .venv/bin/python ] || "$PYTHON" -m venv .venv
.venv/bin/python -m pip install --quiet --disable-pip-version-check -r requirements.txt
# The package is built again where its sources, or those of the program, are newer than what is installed.
installed=$(.venv/bin/python -c 'import pennate._core; print(pennate._core.__file__)' 2>/dev/null || true)
sources="../src ../analysis/src ../models/src ../solver/src ../chains ../elements/src ../bindings/python/src ../bindings/python/python"
if [ -z "$installed" ] || [ -n "$(find $sources ../bindings/python/pyproject.toml -newer "$installed" -name '*.*' ! -name '*.pyc' ! -name '*.so' -type f | head -n 1)" ]; then
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps ../bindings/python
fi
if [ "${1:-}" = bench ]; then
    .venv/bin/python -m pip install --quiet --disable-pip-version-check -r bench/requirements.txt
fi
echo "ready: validation/.venv/bin/python"
