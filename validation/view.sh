#!/bin/sh
# Draws what `pennate solve --vtk` wrote: view.sh DIR_OR_PVD -o PICTURE.png
#
# The first call makes the Python environment that view.py needs.
set -eu
here=$(dirname "$0")
"$here/setup.sh" >/dev/null
exec "$here/.venv/bin/python" "$here/view.py" "$@"
