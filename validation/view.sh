#!/bin/sh
# Draws what `pennate solve --vtk` wrote, or a network file: view.sh DIR_OR_FILE -o PICTURE.png; without -o the files of a
# folder are read by pyvista and by meshio, and compared.
#
# The first call makes the Python environment that the pictures need.
set -eu
here=$(dirname "$0")
"$here/setup.sh" >/dev/null
case " $* " in
    *" -o "* | *" --output"*) exec "$here/.venv/bin/pennate" plot "$@" ;;
    *) exec "$here/.venv/bin/python" "$here/check_vtu.py" "$@" ;;
esac
