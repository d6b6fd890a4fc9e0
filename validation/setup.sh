#!/bin/sh
# Makes validation/.venv with what the scripts of this folder need; `setup.sh bench` adds the programs of bench/.
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
if [ "${1:-}" = bench ]; then
    .venv/bin/python -m pip install --quiet --disable-pip-version-check -r bench/requirements.txt
fi
echo "ready: validation/.venv/bin/python"
