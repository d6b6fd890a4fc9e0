#!/bin/sh
# Draws what `pennate solve --vtk` wrote: view.sh DIR_OR_PVD -o PICTURE.png
#
# The first call makes the Python environment that the pictures need.
set -eu
here=$(dirname "$0")
"$here/setup.sh" >/dev/null
PYTHONPATH="$here${PYTHONPATH:+:$PYTHONPATH}" exec "$here/.venv/bin/python" -m pictures "$@"
